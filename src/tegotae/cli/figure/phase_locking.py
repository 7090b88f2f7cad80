"""`tegotae figure phase-locking`: Arnold tongues of oscillator and body."""

from __future__ import annotations

from dataclasses import dataclass

from tegotae._support.limits import MOST_GAIN, MOST_RAD_PER_S, require_within
from tegotae.cli.figure.output import Output
from tegotae.cli.options import HopperOptions, OscillatorOption, Vanilla
from tegotae.simulation.rollout import Timing
from tegotae.systems.presets import preset


@dataclass(frozen=True, kw_only=True)
class PhaseLocking(Output, OscillatorOption, HopperOptions):
    """Turns of the oscillator per hop over gain σ and frequency ω, and both rates along a cut."""

    actuation: Vanilla = None
    """Vanilla actuation: sector, reflex or both."""
    sigma: tuple[float, float] = (0.0, 12.0)
    """Range of the gain σ [rad/(s N)]."""
    omega: tuple[float, float] = (2.0, 10.0)
    """Range of the frequency ω [rad/s]."""
    cut: float = 4.0
    """Gain of the cut [rad/(s N)]."""
    resolution: int = 100
    """Points along either axis."""
    duration: float = 40.0
    """Simulated time [s]; an unsettled gait counts as one without limit cycle."""

    def run(self) -> None:
        """Compute and write."""
        from tegotae.analysis.maps import axis, sweep_gain
        from tegotae.figures.cycles import phase_locking_figure, phase_locking_table

        self.check_out()
        require_within("cut", self.cut, MOST_GAIN)
        chosen = preset(self.preset)
        actuation = chosen.actuation if self.actuation is None else self.actuation
        sweep = sweep_gain(
            chosen.controller(actuation, self.rhythm),
            axis("sigma", *self.sigma, self.resolution),
            axis("omega", *self.omega, self.resolution, most=MOST_RAD_PER_S),
            self.hopper(),
            timing=Timing(duration_s=self.duration),
        )
        figure = phase_locking_figure(sweep, self.cut, f"{actuation} actuation")
        self.write(figure, {"": phase_locking_table(sweep)})
