"""`python -m research.reproduction gain-map`: CoT⁻¹ over gain and frequency (Fig. 4)."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from research.reproduction.commands.output import Output
from research.reproduction.options import HopperParameters
from tegotae._support.limits import MOST_RAD_PER_S
from tegotae.parts.oscillators import PHASE
from tegotae.simulation.rollout import Timing
from tegotae.systems.parts_by_name import oscillator_called
from tegotae.systems.vanilla import preset

if TYPE_CHECKING:
    from research.reproduction.ridge import Ridge


@dataclass(frozen=True, kw_only=True)
class GainMap(Output, HopperParameters):
    """CoT⁻¹ A and B over gain σ and frequency ω, for sector and reflex actuation (Fig. 4)."""

    preset: str = "paper"
    """Preset of all other parameters: paper or pyTegotaeCPG."""
    oscillator: str = PHASE
    """Oscillator of the controllers: phase, hopf, adaptive-hopf, van-der-pol, matsuoka, or your
    own, FILE.py:OBJECT or MODULE:OBJECT."""
    work: str = "absolute"
    """Definition of the actuator's work: absolute, positive or net."""
    sigma: tuple[float, float] = (0.0, 12.0)
    """Range of the gain σ [rad/(s N)]."""
    omega: tuple[float, float] = (2.0, 10.0)
    """Range of the frequency ω [rad/s]."""
    resolution: int = 100
    """Points along either axis."""
    duration: float = 40.0
    """Simulated time [s]; an unsettled gait counts as one without limit cycle."""

    def run(self) -> None:
        """Compute, write, and print the fits."""
        from research.reproduction.figures.gain_map import gain_map_figure, gain_map_tables
        from research.reproduction.ridge import find_ridge, one_to_one_ridge
        from tegotae.analysis.maps import axis, sweep_gain
        from tegotae.measures.optimum import has_table

        self.check_out()
        sigma = axis("sigma", *self.sigma, self.resolution)
        omega = axis("omega", *self.omega, self.resolution, upper=MOST_RAD_PER_S)
        source, timing = preset(self.preset), Timing(duration_s=self.duration)
        body = dataclasses.replace(source.hopper, **self.overrides)
        oscillator = oscillator_called(self.oscillator)
        sweeps = {
            name: sweep_gain(
                source.controller(name, oscillator),
                sigma,
                omega,
                body,
                timing=timing,
                work=self.work,
            )
            for name in ("sector", "reflex")
        }
        ridges = {name: one_to_one_ridge(sweep) for name, sweep in sweeps.items()}
        for name, sweep in sweeps.items():
            print(f"{name}, one turn a hop: {_fit(ridges[name])}")
            overall = find_ridge(sigma, omega, sweep.outcome.cot_inverse)
            print(f"{name}, all limit cycles: {_fit(overall)}")
        figure = gain_map_figure(sweeps, ridges, optimum=has_table(body, self.work))
        self.write(figure, gain_map_tables(sweeps, ridges))


def _fit(ridge: Ridge) -> str:
    """Return a ridge's line in words: slope ± standard error, R² and its 95 % interval, its
    points.
    """
    fitted, censored = int((~ridge.censored).sum()), int(ridge.censored.sum())
    left_out = f"; {censored} more have their best gain at the map's edge" if censored else ""
    if not np.isfinite(ridge.slope):
        return f"too few frequencies with a best gain for a line: {fitted}{left_out}"
    low, high = ridge.r_squared_interval
    return (
        f"best σ = {ridge.intercept:.3g} + ({ridge.slope:.3g} ± {ridge.slope_error:.2g}) ω, "
        f"R² = {ridge.r_squared:.3f} [{low:.3f}, {high:.3f}], {fitted} frequencies{left_out}"
    )
