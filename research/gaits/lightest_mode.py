"""Explain why the lightest mode wins: averaging predicts the gait that a body gives its legs.

    python -m research.gaits.lightest_mode

writes `lightest_mode.png`, tables as CSV and those of the page beside it, in about
two minutes of one core. What is predicted comes from a single hopper; what is measured, from
rollouts of the bar and the plate.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import jax.numpy as jnp
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from research.frame import main, markdown_table, write_text
from tegotae import Hopper, Rollout, Scenario, Timing
from tegotae.analysis.orbit import Orbit, find_orbit
from tegotae.analysis.phase_response import measure_phase_response
from tegotae.figures.style import COLOURS, PAGE_IN, new_figure, save_figure, styled, write_tables
from tegotae.parts.bodies import Bar, Body, Plate
from tegotae.simulation.recorder import needing
from tegotae.systems.controller_file import SavedController
from tegotae.systems.recipe import recipe

FOLDER = Path(__file__).parent
SIGMA, OMEGA = 1.0, 8.0
LAWS = {"sector": "V-sector-w8", "reflex": "V-reflex-w8"}
POINTS = 240
PUSH_NS = 1e-4
NEAR = 0.02
"""Deviation of 1/j from 1 at which drifts are measured."""
NUDGE_RAD = 0.005
"""Initial deviation of legs from a gait whose rates are measured: small, for unstable ones grow."""
SOON_S, LATE_S = 6.0, 26.0
"""Start and end of the measurement of a drift [s]; legs are back on their cycles at the start."""

MODES = {
    "pronk": (1, 1, 1, 1),
    "bound": (1, 1, -1, -1),
    "pace": (1, -1, 1, -1),
    "trot": (1, -1, -1, 1),
}
"""Signs of heave, pitch, roll and twist at legs left fore, right fore, left hind, right hind: each
is a mode of the body and, as phases 0 and π, a gait."""


class Leg(NamedTuple):
    """Coupling function of identical hoppers, from the response of a single one."""

    saved: SavedController
    orbit: Orbit
    lag_rad: np.ndarray
    """ψ, [points]."""
    drift_per_s: np.ndarray
    """The odd part of H(ψ) [rad/s], [points]."""
    even_per_s: np.ndarray
    """Its even part without the mean [rad/s], [points]."""
    at_0: float
    """H'(0) [1/s]."""
    at_pi: float
    """H'(π) [1/s]."""


def listen(law: str) -> Leg:
    """Measure the leg's limit cycle, its response to small pushes, and their combination.

    H(ψ) = (1/T) ∫ Z(t) F(t + ψ T / 2π) dt, with Z the shift of phase by an impulse [rad/(N s)], and
    F the force of the leg on the body [N], here the mass times its acceleration and gravity.
    """
    saved = SavedController.from_weights(recipe(LAWS[law]).controller(), np.array([SIGMA]), OMEGA)
    orbit = find_orbit(saved)
    pushes = np.array([PUSH_NS, -PUSH_NS])
    response = measure_phase_response(saved, orbit, pushes, points=POINTS, cycles=60)
    up, down = response["shift_rad"].to_numpy().reshape(2, -1)
    shift = (up - down) / (2.0 * PUSH_NS)
    velocity, body = orbit.velocity_m_per_s, Hopper()
    acceleration = np.gradient(velocity, orbit.time_s)
    force = body.mass_kg * (acceleration + body.gravity_m_per_s2)
    time = orbit.period_s * np.arange(POINTS) / POINTS
    later = (time[:, None] + time[None]) % orbit.period_s
    of_lag = (shift[:, None] * np.interp(later, orbit.time_s, force)).mean(axis=0)
    odd, even = (0.5 * (of_lag + sign * np.roll(of_lag[::-1], 1)) for sign in (-1.0, 1.0))
    # Its slopes from its first harmonics: sines, since it is odd.
    n = np.arange(1, 16)
    sines = -2.0 * np.fft.rfft(odd).imag[n] / POINTS
    slopes = (n * sines).sum(), (n * sines * (-1.0) ** n).sum()
    lag = 2.0 * np.pi * np.arange(POINTS) / POINTS
    return Leg(saved, orbit, lag, odd, even - even.mean(), *slopes)


RANDOM_STATES = 100_000


def rises(even: float) -> float:
    """Return the share of random states of four legs in which V rises if H = sin ψ + even · cos ψ.

    Inertias are drawn, too: lightnesses of pitch, roll and twist from -1 to 1, heave has none.
    """
    random = np.random.default_rng(0)
    phase = random.uniform(0.0, 2.0 * np.pi, (RANDOM_STATES, 4))
    lightness = random.uniform(-1.0, 1.0, (RANDOM_STATES, 4)) * [0.0, 1.0, 1.0, 1.0]
    patterns = 0.5 * np.array(list(MODES.values()))
    coupling = np.einsum("nk,ki,kj->nij", lightness, patterns, patterns)
    lag = phase[:, None] - phase[:, :, None]
    down = (coupling * np.sin(lag)).sum(axis=2)  # -dV/dθ
    aside = (coupling * np.cos(lag)).sum(axis=2)
    return float(((down * (down + even * aside)).sum(axis=1) < -1e-12).mean())


def evenness(legs: dict[str, Leg]) -> list[dict]:
    """Compute the even part of H, as amplitudes of its first harmonics, and the share of states in
    which V then rises."""
    rows = []
    for law, leg in legs.items():
        odd = 2.0 * float((leg.drift_per_s * np.sin(leg.lag_rad)).mean())
        even = 2.0 * float((leg.even_per_s * np.cos(leg.lag_rad)).mean())
        amplitudes = {"H": law, "odd part [1/s]": odd, "even part [1/s]": even}
        rows.append(amplitudes | {"V rises in": f"{100.0 * rises(even / odd):.1f} %"})
    for even in (0.0, 0.5, 1.0, 2.0):
        labels = {"H": f"sin ψ + {even:g} cos ψ", "odd part [1/s]": 1.0, "even part [1/s]": even}
        rows.append(labels | {"V rises in": f"{100.0 * rises(even):.1f} %"})
    return rows


def predicted(leg: Leg, gait: str, mode: str, lightness: dict[str, float]) -> float:
    """Predict the growth rate of a gait's disturbance by a mode [1/s], by averaging.

    λ = a ε_k + b (ε_gk - ε_g), a = (H'(0) + H'(π)) / 2, b = (H'(0) - H'(π)) / 2.
    """
    mean, half = 0.5 * (leg.at_0 + leg.at_pi), 0.5 * (leg.at_0 - leg.at_pi)
    product = tuple(np.multiply(MODES[gait], MODES[mode]))
    product_mode = next(name for name, signs in MODES.items() if signs == product)
    return mean * lightness[mode] + half * (lightness[product_mode] - lightness[gait])


@needing("touchdown_time_s")
def touchdowns(trajectory, scenario, body, timing):
    """Return the last touchdown of every leg before `SOON_S` and before the end [s]."""
    soon = round(SOON_S / timing.frame_s)
    time = jnp.nan_to_num(trajectory.touchdown_time_s, nan=0.0)
    return time[:soon].max(axis=0), time.max(axis=0)


def on_cycle(leg: Leg, body: Body, phase_rad: np.ndarray, changes: dict) -> tuple[np.ndarray, ...]:
    """Release every leg on its limit cycle, so far ahead of the first [rad], [limbs, lanes].

    Returns:
        times at which lags were read [s], and how far each leg was ahead then [rad].
    """
    orbit = leg.orbit
    time_s = (phase_rad / (2.0 * np.pi) % 1.0) * orbit.period_s
    turns = body.turns  # type: ignore[attr-defined]
    arms = np.array([np.ones(body.limbs), *(turn.arms_m for turn in turns)])
    of_modes = arms / (arms**2).sum(axis=1, keepdims=True)

    def at_phases(record: np.ndarray) -> np.ndarray:
        return np.interp(time_s, orbit.time_s, record, period=orbit.period_s)

    place, rate = of_modes @ at_phases(orbit.height_m), of_modes @ at_phases(orbit.velocity_m_per_s)
    initial_pose = {f"{turn.name}_rad": q for turn, q in zip(turns, place[1:], strict=True)}
    initial_pose |= {f"{t.name}_rate_rad_per_s": q for t, q in zip(turns, rate[1:], strict=True)}
    # The oscillator's phase, without the jump from 2π to 0.
    angle = np.arctan2(at_phases(np.sin(orbit.phase_rad)), at_phases(np.cos(orbit.phase_rad)))
    rollout = Rollout(
        controller=dataclasses.replace(leg.saved.controller, limbs=body.limbs),
        timing=Timing(duration_s=LATE_S),
        summary=touchdowns,
    )
    scenario = Scenario(
        OMEGA,
        height_m=place[0],
        velocity_m_per_s=rate[0],
        phase_rad=angle,
        initial_pose=initial_pose,
        changes=changes,
    )
    times = np.array(rollout.run(leg.saved.weights, scenario, body, dtype="float64"))
    # A leg that touches down earlier is ahead, by a share of the period that the gait has here.
    passed = times[1, 0] - times[0, 0]
    period = passed / np.round(passed / orbit.period_s)
    return times[:, 0], -2.0 * np.pi * (times - times[:, :1]) / period


def drifts(law: str, leg: Leg) -> pd.DataFrame:
    """Return the growth rates of a lag over 1/j - 1, measured on two legs at 1/j = 1 ± `NEAR`."""
    lightness = np.repeat([NEAR, -NEAR], 30)
    lag = np.tile(2.0 * np.pi * (np.arange(30) + 0.5) / 30, 2)
    changes = {"inertia_ratio": 1.0 / (1.0 + lightness)}
    time, ahead = on_cycle(leg, Bar(), np.array([0.0 * lag, lag]), changes)
    lags = np.unwrap(ahead[:, 1], axis=0, period=2.0 * np.pi)
    rate = (lags[1] - lags[0]) / (time[1] - time[0]) / lightness
    lag = lags.mean(axis=0) % (2.0 * np.pi)
    return pd.DataFrame({"law": law, "lightness": lightness, "lag_rad": lag, "rate": rate})


def exponents(law: str, leg: Leg) -> list[dict]:
    """Return the predicted and measured rates on limp plates of several inertias near 1."""
    cases = [(1.0, -1.0, -1.0), (-1.0, 1.0, -0.5), (-1.0, -0.5, 1.0), (-1.0, -0.7, -0.4)]
    cases = [tuple(NEAR * x for x in case) for case in cases]
    rows = [(c, g, k) for c in cases for g in MODES for k in list(MODES)[1:]]
    light = np.array([case for case, _, _ in rows]).T
    gaits = 0.5 * np.pi * (1 - np.array([MODES[g] for _, g, _ in rows]).T)
    nudge = np.array([MODES[k] for _, _, k in rows]).T
    names = ("pitch_inertia_ratio", "roll_inertia_ratio", "twist_inertia_ratio")
    changes = {name: 1.0 / (1.0 + x) for name, x in zip(names, light, strict=True)}
    time, ahead = on_cycle(leg, Plate(twist_inertia_ratio=1.0), gaits + NUDGE_RAD * nudge, changes)
    off = (ahead - (gaits - gaits[:1]) + np.pi) % (2.0 * np.pi) - np.pi
    size = (off * nudge).sum(axis=1)
    rates = np.log(np.abs(size[1] / size[0])) / (time[1] - time[0])
    rows_of_gaits = []
    for (case, gait, mode), rate in zip(rows, rates, strict=True):
        eigenvalues = dict(zip(MODES, (0.0, *case), strict=True))
        rows_of_gaits.append(
            {
                "law": law,
                **{
                    f"lightness_{n}": x
                    for n, x in zip(("pitch", "roll", "twist"), case, strict=True)
                },
                "gait": gait,
                "mode": mode,
                "predicted_per_s": predicted(leg, gait, mode, eigenvalues),
                "measured_per_s": rate,
            }
        )
    return rows_of_gaits


@needing("phase_rad")
def last_lags(trajectory, scenario, body, timing):
    """Return the phase of each leg relative to the first at the end [rad], [limbs, lanes]."""
    return trajectory.phase_rad[-1] - trajectory.phase_rad[-1, :1]


RATIOS = (0.2, 0.35, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 1.0, 1.05, 1.1, 1.3, 1.6, 2.0, 3.0, 4.0)
OMEGAS = np.arange(7.0, 13.1, 0.5)
STARTS = 32
WITHIN = np.cos(0.1 * np.pi)
"""A gait counts if every leg is within a twentieth of a cycle of it."""


def shares(law: str, ratio: np.ndarray, omega: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the shares of random starts of two legs that end in phase and in antiphase."""
    cells = np.arange(len(ratio)).repeat(STARTS)
    start = np.random.default_rng(0).uniform(0.0, 2.0 * np.pi, (2, STARTS))
    rollout = Rollout(
        controller=dataclasses.replace(recipe(LAWS[law]).controller(), limbs=2),
        timing=Timing(duration_s=300.0, frame_s=1.0, tick_s=0.002),
        summary=last_lags,
    )
    scenario = Scenario(
        omega[cells],
        phase_rad=np.tile(start, len(ratio)),
        changes={"inertia_ratio": ratio[cells]},
    )
    cosine = np.cos(rollout.run([SIGMA], scenario, Bar())[1]).reshape(len(ratio), STARTS)
    return (cosine > WITHIN).sum(axis=1), (cosine < -WITHIN).sum(axis=1)


PLATES = (
    (0.6, 1.6, None),
    (1.6, 0.6, None),
    (1.6, 1.6, None),
    (0.6, 0.6, None),
    (0.9, 1.1, None),
    (1.1, 0.9, None),
    (1.6, 1.6, 0.6),
    (0.9, 0.9, 0.7),
    (0.6, 1.6, 0.8),
    (1.6, 1.6, 1.6),
)
PLATE_STARTS = 24


def plates(law: str) -> list[dict]:
    """Measure the gaits that plates of these inertia ratios reach from random starts."""
    rows = []
    start = np.random.default_rng(0).uniform(0.0, 2.0 * np.pi, (4, PLATE_STARTS))
    for limp in (False, True):
        cases = [case for case in PLATES if (case[2] is not None) == limp]
        ratios = np.array([[x for x in case if x is not None] for case in cases]).T
        names = ("pitch_inertia_ratio", "roll_inertia_ratio", "twist_inertia_ratio")
        rollout = Rollout(
            controller=dataclasses.replace(recipe(LAWS[law]).controller(), limbs=4),
            timing=Timing(duration_s=300.0, frame_s=1.0, tick_s=0.002),
            summary=last_lags,
        )
        scenario = Scenario(
            OMEGA,
            phase_rad=np.tile(start, len(cases)),
            changes=dict(zip(names, ratios.repeat(PLATE_STARTS, axis=1), strict=False)),
        )
        body = Plate(twist_inertia_ratio=1.0 if limp else None)
        lags = rollout.run([SIGMA], scenario, body).reshape(4, len(cases), PLATE_STARTS)
        for number, case in enumerate(cases):
            counts = {
                gait: int(
                    (np.cos(lags[:, number]) * np.array(signs)[:, None] > WITHIN).all(0).sum()
                )
                for gait, signs in MODES.items()
            }
            counts["other"] = PLATE_STARTS - sum(counts.values())
            light = [0.0, *(0.0 if j is None else 1.0 / j - 1.0 for j in case)]
            light[3] = -1.0 if case[2] is None else light[3]
            best = [g for g, x in zip(MODES, light, strict=True) if x == max(light)]
            ratio = dict(zip(names, ("" if j is None else j for j in case), strict=True))
            rows.append({"law": law, **ratio, "lightest": " or ".join(best), **counts})
    return rows


def ratios(row: pd.Series) -> str:
    """Return the three inertia ratios of a plate in one cell."""
    values = row[["pitch_inertia_ratio", "roll_inertia_ratio", "twist_inertia_ratio"]]
    return ", ".join("rigid" if value == "" else str(value) for value in values)


def draw(
    legs: dict[str, Leg], curves: pd.DataFrame, bars: pd.DataFrame, rates: pd.DataFrame
) -> Figure:
    """Draw drift over lag, gaits of the bar over its inertia, and rates on plates."""
    open_mark = {"ls": "", "markersize": 3, "fillstyle": "none"}
    with styled():
        figure = new_figure(PAGE_IN, 4.6)
        axes = figure.subplots(2, 2)
        for axis, (law, leg), letter in zip(axes[0], legs.items(), "ab", strict=True):
            axis.axhline(0.0, color="0.6", lw=0.6)
            axis.plot(
                leg.lag_rad / (2 * np.pi), leg.drift_per_s, color=COLOURS[0], label="averaging"
            )
            for sign, mark, colour in ((1, "o", COLOURS[4]), (-1, "s", COLOURS[2])):
                rows = curves[(curves.law == law) & (np.sign(curves.lightness) == sign)]
                label = f"rollouts, 1/j = {1 + sign * NEAR:g}"
                axis.plot(rows.lag_rad / (2 * np.pi), rows.rate, marker=mark, color=colour,
                          label=label, **open_mark)  # fmt: skip
            axis.set_title(f"({letter}) two legs, {law}")
            axis.set_xlabel("lag ψ [cycles]")
            axis.set_ylabel("dψ/dt / (1/j - 1) [rad/s]")
            axis.set_xlim(0.0, 1.0)
        axes[0, 0].legend(loc="upper right")
        panel = axes[1, 1]
        for law, colour, mark in zip(LAWS, (COLOURS[0], COLOURS[4]), "os", strict=True):
            points = rates[rates.law == law]
            panel.plot(points.predicted_per_s, points.measured_per_s, marker=mark, color=colour,
                       label=law, **open_mark)  # fmt: skip
        _stacked(axes[1, 0], bars)
        low, high = panel.get_xlim()
        panel.axline((0.0, 0.0), slope=1.0, color="0.6", lw=0.6, zorder=0)
        panel.set_xlim(low, high)
        panel.set_xlabel("rate by averaging λ [1/s]")
        panel.set_ylabel("measured [1/s]")
        panel.set_title("(d) four legs on limp plates")
        panel.legend(loc="upper left")
    return figure


def _stacked(axis: Axes, bars: pd.DataFrame) -> None:
    """Draw the gaits that two legs reach, of either law, as bars over the inertia ratio."""
    x = np.arange(len(RATIOS))
    for level, law in enumerate(reversed(LAWS)):
        table = bars[bars.law == law]
        floor = np.full(len(RATIOS), 1.2 * level)
        shares = {
            "in phase": (table.in_phase, COLOURS[1]),
            "antiphase": (table.antiphase, COLOURS[0]),
            "another lag": (STARTS - table.in_phase - table.antiphase, "0.85"),
        }
        for name, (count, colour) in shares.items():
            label = name if level == 0 else None
            axis.bar(x, count / STARTS, 0.8, bottom=floor, color=colour, label=label)
            floor = floor + count / STARTS
    axis.set_xticks(x, [f"{j:g}" for j in RATIOS], rotation=60)
    axis.set_yticks([0.5, 1.7], list(reversed(LAWS)))
    axis.tick_params("y", length=0)
    axis.set_ylim(0.0, 2.75)
    axis.set_xlabel("inertia ratio j")
    axis.set_title(f"(c) where two legs end, of {STARTS} starts")
    axis.legend(loc="upper center", ncols=3)


def markdown(table: pd.DataFrame) -> str:
    """Return a table as Markdown."""
    lines = [[f"{x:.3g}" if isinstance(x, float) else x for x in row] for row in table.to_numpy()]
    return markdown_table([[*table], *lines])


def slopes_of(law: str, leg: Leg, curve: pd.DataFrame) -> dict[str, Any]:
    """Return the slopes of H at 0 and π, as predicted and as measured near there."""
    measured = []
    for centre in (0.0, np.pi):
        off = (curve.lag_rad - centre + np.pi) % (2 * np.pi) - np.pi
        near = off.abs() < 0.4
        measured.append(float(np.polyfit(off[near], curve.rate[near], 3)[2]))
    return {
        "law": law,
        "period [s]": float(leg.orbit.period_s),
        "H'(0) predicted [1/s]": float(leg.at_0),
        "measured": measured[0],
        "H'(π) predicted [1/s]": float(leg.at_pi),
        "measured ": measured[1],
    }


def ends_of(law: str, name: str, values: Sequence[float], ratio: Any, omega: Any) -> list[dict]:
    """Return how many starts of two legs end in phase and in antiphase, over a number."""
    counts = shares(law, np.broadcast_to(ratio, len(values)), np.broadcast_to(omega, len(values)))
    return [
        {"law": law, name: float(x), "in_phase": int(a), "antiphase": int(b)}
        for x, a, b in zip(values, *counts, strict=True)
    ]


def run() -> None:
    """Predict, measure, write."""
    legs = {law: listen(law) for law in LAWS}
    curves = pd.concat([drifts(law, leg) for law, leg in legs.items()], ignore_index=True)
    slopes = [slopes_of(law, leg, curves[curves.law == law]) for law, leg in legs.items()]
    rates = pd.DataFrame([row for law, leg in legs.items() for row in exponents(law, leg)])
    bars, climbs = (
        pd.DataFrame([row for law in LAWS for row in ends_of(law, *over)])
        for over in (
            ("inertia_ratio", RATIOS, RATIOS, OMEGA),
            ("omega", OMEGAS, 0.35, OMEGAS),
        )
    )
    ends = pd.DataFrame([row for law in LAWS for row in plates(law)])
    narrow = ends[["law", "lightest", *MODES, "other"]]
    narrow.insert(1, "pitch, roll, twist", ends.apply(ratios, axis=1))
    tables = {
        "slopes": pd.DataFrame(slopes),
        "even": pd.DataFrame(evenness(legs)),
        "bar": bars,
        "frequency": climbs,
        "plates": narrow,
    }
    for name, table in tables.items():
        write_text(FOLDER / f"lightest_mode_{name}.md", markdown(table))
    path = FOLDER / "lightest_mode.png"
    write_tables(path, {"drift": curves, "rates": rates, "bar": bars, "plates": ends})
    save_figure(draw(legs, curves, bars, rates), path)
    error = rates.measured_per_s - rates.predicted_per_s
    spread = rates.measured_per_s.pow(2).mean() ** 0.5
    print(f"rates: root mean square error {error.pow(2).mean() ** 0.5:.2g} /s, of {spread:.2g} /s; "
          f"largest {error.abs().max():.2g} /s")  # fmt: skip


if __name__ == "__main__":
    main(run)
