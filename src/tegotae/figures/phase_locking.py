"""The phase-locking map: Arnold tongues over gain and frequency, and a cut through them."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
from matplotlib.figure import Figure

from tegotae.analysis.ridge import GainSweep
from tegotae.analysis.sweep import locking_ratios
from tegotae.figures.data import long_table
from tegotae.figures.maps import category_patch, draw_categories, draw_regimes, regime_legend
from tegotae.figures.style import COLOURS, COLUMN_IN, new_figure, styled
from tegotae.measures.hopping.gait import LIMIT_CYCLE, REGIMES

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
