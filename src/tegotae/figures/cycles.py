"""Limit cycles: portrait, return map, phase response, locking."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Patch
from matplotlib.ticker import MaxNLocator

from tegotae.analysis.maps import GainSweep, locking_ratios
from tegotae.analysis.orbit import Paths
from tegotae.analysis.phase_response import PhaseResponse
from tegotae.analysis.poincare import NUMERICAL, Poincare
from tegotae.figures.maps import (
    category_patch,
    draw_categories,
    draw_regimes,
    phase_axis,
    phase_ticks,
    regime_legend,
)
from tegotae.figures.style import COLOURS, COLUMN_IN, PAGE_IN, Table, long_table, new_figure, styled
from tegotae.measures.hopping.episode import LIMIT_CYCLE, REGIMES

_LATE = 0.75
"""From this share of the time on a path is drawn as where the gait has come to."""


def portrait_figure(paths: Paths, *, rest_length_m: float, note: str = "") -> Figure:
    """Velocity over height, and spring force over phase, or over velocity without an oscillator.

    Thin lines lead from the releases, the squares; the last quarter of the time is thick. A cross
    is where a leg has no length left.

    Args:
        paths: the rollouts.
        rest_length_m: rest length of the leg l0 [m], above which it flies.
        note: a title.
    """
    with styled():
        figure = new_figure(PAGE_IN, 2.9)
        body, felt = figure.subplots(1, 2)
        figure.suptitle(note, fontsize=8)
        body.axvline(rest_length_m, color="0.4", ls=":", lw=0.8)
        _draw(body, paths.height_m, paths.velocity_m_per_s, paths.failed, _labels(paths))
        body.set(xlabel="height y [m]", ylabel="velocity ẏ [m/s]")
        figure.legend(title="released from", loc="outside right center", title_fontsize=7)
        if paths.phase_rad is None:
            _draw(felt, paths.velocity_m_per_s, paths.spring_force_n, paths.failed)
            felt.set_xlabel("velocity ẏ [m/s]")
        else:
            phase = _broken(paths.phase_rad % (2.0 * np.pi))
            _draw(felt, phase, paths.spring_force_n, paths.failed)
            phase_axis(felt)
        felt.set_ylabel("spring force $F_k$ [N]")
        felt.set_ylim(bottom=0.0)
    return figure


def portrait_table(paths: Paths) -> dict[str, np.ndarray]:
    """What the figure shows, a row a frame and release."""
    frames, releases = paths.height_m.shape
    phase = {} if paths.phase_rad is None else {"phase_rad": paths.phase_rad.T.ravel()}
    return {
        "release_height_m": np.repeat(paths.height_m[0], frames),
        "time_s": np.tile(paths.time_s, releases),
        "height_m": paths.height_m.T.ravel(),
        "velocity_m_per_s": paths.velocity_m_per_s.T.ravel(),
        **phase,
        "spring_force_n": paths.spring_force_n.T.ravel(),
        "actuator_force_n": paths.actuator_force_n.T.ravel(),
    }


def _labels(paths: Paths) -> list[str]:
    return [f"{height:.3g} m" for height in paths.height_m[0]]


def _draw(
    axes: Axes, x: np.ndarray, y: np.ndarray, failed: np.ndarray, labels: list[str] | None = None
) -> None:
    late = round(_LATE * len(x))
    for i, (across, up) in enumerate(zip(x.T, y.T, strict=True)):
        colour = COLOURS[i % len(COLOURS)]
        axes.plot(across[: late + 1], up[: late + 1], color=colour, lw=0.4, alpha=0.6)
        axes.plot(across[late:], up[late:], color=colour, lw=1.3, label=labels and labels[i])
        axes.plot(across[0], up[0], "s", color=colour, ms=4)
        if failed[i]:
            axes.plot(across[-1], up[-1], "x", color=colour, ms=6, clip_on=False)


def _broken(phase_rad: np.ndarray) -> np.ndarray:
    """Phases [frames, releases] with a gap where they wrap."""
    jumps = np.abs(np.diff(phase_rad, axis=0, prepend=phase_rad[:1])) > np.pi
    return np.where(jumps, np.nan, phase_rad)


_SEEN = ("apex_height_m", "apex_phase_rad")
"""The shown part of a point of the section; an oscillator may have more state than its phase."""


def poincare_figure(found: Poincare, transient: np.ndarray, note: str = "") -> Figure:
    """Apexes after the release; decay of a nudge; multipliers in the complex plane.

    Args:
        found: the fixed point and its multipliers.
        transient: apexes from a release on, height [m] and phase [rad], shape [hops, 1 or 2].
        note: a title.
    """
    with styled():
        figure = new_figure(PAGE_IN, 2.4)
        section, decay, plane = figure.subplots(1, 3)
        figure.suptitle(note, fontsize=8)
        _draw_section(section, found, transient)
        _draw_decay(decay, found)
        _draw_multipliers(plane, found)
    return figure


def poincare_tables(found: Poincare, transient: np.ndarray) -> dict[str, Table]:
    """What the figure shows: `decay` of the nudge, apexes of the `transient`, `multipliers`."""
    names = _SEEN[: len(found.fixed_point)]
    turns = np.arange(len(found.distance))
    return {
        "": {
            "turn": turns,
            **dict(zip(names, found.nudged.T, strict=False)),
            "distance": found.distance,
            "predicted_distance": predicted(found),
        },
        "transient": {
            "hop": np.arange(len(transient)),
            **dict(zip(names, transient.T, strict=True)),
        },
        "multipliers": {
            "real": np.real(found.multipliers),
            "imaginary": np.imag(found.multipliers),
            "modulus": np.abs(found.multipliers),
            "observed_factor": found.observed,
            "refined": found.refined,
            "period_hops": found.hops,
            "period_s": found.period_s,
            "decay_time_s": found.decay_s,
        },
    }


def predicted(found: Poincare) -> np.ndarray:
    """The nudge's distance from the fixed point if the return map were linear, shape [turns]."""
    point = found.nudged[0] - found.fixed_point
    distances = []
    for _ in found.distance:
        distances.append(np.linalg.norm(point))
        point = found.jacobian @ point
    return np.array(distances)


def _draw_section(axes: Axes, found: Poincare, transient: np.ndarray) -> None:
    if len(found.fixed_point) > 1:
        axes.plot(transient[:, 1], transient[:, 0], color="0.75", lw=0.5)
        axes.plot(transient[:, 1], transient[:, 0], ".", color=COLOURS[0], ms=4)
        axes.plot(*transient[0, ::-1], "s", color=COLOURS[2], ms=4, label="first apex")
        axes.plot(
            *found.fixed_point[1::-1], "x", color=COLOURS[4], ms=7, mew=1.4, label=_star(found)
        )
        axes.set_xlabel("phase at the apex φ [rad]")
        phase_ticks(axes.xaxis)
    else:
        axes.plot(transient[:-1, 0], transient[1:, 0], ".", color=COLOURS[0], ms=4)
        axes.plot(transient[0, 0], transient[1, 0], "s", color=COLOURS[2], ms=4, label="first apex")
        if found.hops == 1:
            star = found.fixed_point[0]
            axes.plot(star, star, "x", color=COLOURS[4], ms=7, mew=1.4, label=_star(found))
        axes.axline((transient[0, 0], transient[0, 0]), slope=1.0, color="0.6", lw=0.6)
        axes.set_xlabel("height of the apex before [m]")
    axes.set_ylabel("height of the apex y [m]")
    axes.legend(handletextpad=0.2)


def _star(found: Poincare) -> str:
    return "x*" if found.refined else "x*, not refined"


def _draw_decay(axes: Axes, found: Poincare) -> None:
    turns = np.arange(len(found.distance))
    axes.xaxis.set_major_locator(MaxNLocator(5, integer=True))
    axes.semilogy(turns, predicted(found), color="black", lw=0.9, label="linear map")
    axes.semilogy(turns, found.distance, "o", color=COLOURS[0], ms=3, mfc="none", label="simulated")
    shown = np.flatnonzero(found.distance > NUMERICAL)
    axes.set_ylim(NUMERICAL, 3.0 * np.nanmax(found.distance))
    axes.set_xlim(-0.5, shown[-1] + 1.5)
    unit = "hops" if found.hops == 1 else f"turns of {found.hops} hops"
    axes.set_xlabel(unit)
    axes.set_ylabel("distance from x* [m, rad]")
    axes.legend()


def _draw_multipliers(axes: Axes, found: Poincare) -> None:
    axes.add_patch(Circle((0.0, 0.0), 1.0, fill=False, color="0.5", lw=0.8))
    axes.axhline(0.0, color="0.85", lw=0.5, zorder=0)
    axes.axvline(0.0, color="0.85", lw=0.5, zorder=0)
    axes.plot(np.real(found.multipliers), np.imag(found.multipliers), "o", color=COLOURS[4], ms=4)
    reach = 1.15 * max(1.0, float(np.abs(found.multipliers).max()))
    axes.set(xlim=(-reach, reach), ylim=(-reach, reach), xlabel="Re λ", ylabel="Im λ")
    axes.set_aspect("equal")
    axes.set_title(f"|λ₁| = {abs(found.multipliers[0]):.3f}")


NEGLIGIBLE_RAD = 0.01
"""A shift below this, 1/600 of a period, is negligible, and drawn as the flat line that it is."""

_LINES = ("-", "--", "-.", ":")


def phase_response_figure(response: PhaseResponse, note: str = "") -> Figure:
    """Shift of the rhythm over the phase of the cycle at which the push comes.

    The axis reaches at least to twice `NEGLIGIBLE_RAD`, so that a gait that does not respond does
    not look like one that does; the picture then says so.
    """
    largest = largest_shift_rad(response)
    with styled():
        figure = new_figure(COLUMN_IN, 2.6)
        axes = figure.subplots()
        x = response.cycle_phase_rad / (2.0 * np.pi)
        axes.fill_between(
            x,
            0.0,
            1.0,
            where=response.stance.tolist(),
            transform=axes.get_xaxis_transform(),
            color="0.88",
            lw=0,
            step="post",
        )
        axes.axhline(0.0, color="0.5", lw=0.6)
        for number, (push, shift) in enumerate(
            zip(response.push_ns, response.shift_rad, strict=True)
        ):
            axes.plot(
                x,
                _unjumped(shift),
                ls=_LINES[number % len(_LINES)],
                color=COLOURS[(0, 4, 2, 5)[number % 4]],
                label=f"push of {1e3 * push:+.3g} mN s",
            )
        low, high = axes.get_ylim()
        axes.set_ylim(min(low, -2.0 * NEGLIGIBLE_RAD), max(high, 2.0 * NEGLIGIBLE_RAD))
        if largest < NEGLIGIBLE_RAD:
            axes.text(
                0.5, 0.95, _negligible(largest), transform=axes.transAxes, ha="center", va="top"
            )
        elif np.isnan(largest):
            words = "the gait never returns to its limit cycle"
            axes.text(0.5, 0.95, words, transform=axes.transAxes, ha="center", va="top")
        axes.set_xlim(0.0, 1.0)
        axes.set_xlabel("when the push comes, t / T since the apex")
        axes.set_ylabel("shift of the rhythm Δθ [rad]")
        axes.set_title(note)
        handles = [*axes.get_legend_handles_labels()[0], Patch(color="0.88", label="stance")]
        figure.legend(handles=handles, loc="outside lower center", ncols=3)
    return figure


def largest_shift_rad(response: PhaseResponse) -> float:
    """Largest shift by any push, in either direction [rad]; NaN if the gait never returns."""
    returned = np.isfinite(response.shift_rad)
    return float(np.abs(response.shift_rad[returned]).max()) if returned.any() else float("nan")


def _negligible(largest_rad: float) -> str:
    share = largest_rad / (2.0 * np.pi)
    return f"negligible response: at most {largest_rad:.1g} rad,\n{share:.1g} of a period"


def phase_response_table(response: PhaseResponse) -> dict[str, np.ndarray]:
    """What the figure shows, one row per push and point of the cycle."""
    pushes, points = response.shift_rad.shape
    return {
        "push_ns": np.repeat(response.push_ns, points),
        "cycle_phase_rad": np.tile(response.cycle_phase_rad, pushes),
        "oscillator_phase_rad": np.tile(response.oscillator_phase_rad, pushes),
        "stance": np.tile(response.stance, pushes),
        "shift_rad": response.shift_rad.ravel(),
    }


def _unjumped(shift_rad: np.ndarray) -> np.ndarray:
    """The curve with a gap where it wraps from π to -π."""
    jumps = np.abs(np.diff(shift_rad, prepend=shift_rad[:1])) > np.pi
    return np.where(jumps, np.nan, shift_rad)


_NAMED = tuple(Fraction(*ratio) for ratio in ((1, 1), (2, 1), (1, 2), (3, 2), (0, 1)))
_OTHER = len(_NAMED)


def phase_locking_figure(sweep: GainSweep, cut_sigma: float, note: str = "") -> Figure:
    """Turns of the oscillator per hop over frequency and gain; below, both rates along a cut.

    Args:
        sweep: outcomes over gain and frequency.
        cut_sigma: the gain of the cut [rad/(s N)]; the nearest of the sweep's is taken.
        note: a title.
    """
    ratios = locking_ratios(sweep.outcome)
    category = np.full(ratios.shape, -1)
    for at in zip(*np.nonzero(sweep.outcome.regime == LIMIT_CYCLE), strict=True):
        category[at] = _NAMED.index(ratios[at]) if ratios[at] in _NAMED else _OTHER
    cut = int(np.argmin(np.abs(sweep.sigma - cut_sigma)))
    with styled():
        figure = new_figure(COLUMN_IN, 4.6)
        top, below = figure.subplots(2, 1, height_ratios=(1.5, 1.0), sharex=True)
        draw_regimes(top, sweep.omega, sweep.sigma, sweep.outcome.regime)
        colours = draw_categories(top, sweep.omega, sweep.sigma, category, _OTHER + 1)
        top.axhline(sweep.sigma[cut], color="white", lw=2.2)
        top.axhline(sweep.sigma[cut], color="black", lw=1.0, ls="--")
        top.set_ylabel("gain σ [rad/(s N)]")
        top.set_title(note)
        labels = [*(f"{ratio_name(ratio)} turns : hops" for ratio in _NAMED), "another ratio"]
        patches = [
            category_patch(colour, label)
            for number, (colour, label) in enumerate(zip(colours, labels, strict=True))
            if np.any(category == number)
        ]

        below.plot(sweep.omega, sweep.omega, color="0.6", lw=0.8, ls=":", label="ω")
        at_cut = {
            "mean phase rate": sweep.outcome.phase_rate[cut],
            "hopping frequency": sweep.outcome.hop_rate[cut],
        }
        for (label, rate), colour, marker in zip(
            at_cut.items(), (COLOURS[2], COLOURS[4]), ("o", "."), strict=True
        ):
            size = 3.2 if marker == "o" else 2.6
            face = "none" if marker == "o" else colour
            below.plot(
                sweep.omega, rate, marker, color=colour, ms=size, mfc=face, mew=0.5, label=label
            )
        below.set_xlabel("frequency ω [rad/s]")
        below.set_ylabel(f"rate [rad/s] at σ = {sweep.sigma[cut]:.3g}")
        below.legend(loc="lower center", bbox_to_anchor=(0.5, 0.98), ncols=3, handletextpad=0.3)
        regime_legend(figure, sweep.outcome.regime, *patches, ncols=3)
    return figure


def ratio_name(ratio: Fraction) -> str:
    """p:q."""
    return f"{ratio.numerator}:{ratio.denominator}"


def phase_locking_table(sweep: GainSweep) -> dict[str, np.ndarray]:
    """What the figure shows, pair by pair of gain and frequency."""
    ratios = locking_ratios(sweep.outcome)
    names = np.array([ratio_name(ratio) if ratio is not None else "" for ratio in ratios.ravel()])
    return long_table(
        ("sigma_rad_per_s_n", sweep.sigma),
        ("omega_rad_per_s", sweep.omega),
        {
            "regime": np.asarray(REGIMES)[sweep.outcome.regime],
            "turns_to_hops": names.reshape(ratios.shape),
            "limit_cycle_period_hops": sweep.outcome.limit_cycle_period,
            "mean_phase_rate_rad_per_s": sweep.outcome.phase_rate,
            "hopping_frequency_rad_per_s": sweep.outcome.hop_rate,
            "winding_ratio": sweep.outcome.winding_ratio,
        },
    )
