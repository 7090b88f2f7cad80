"""Readings of a whole study, by name or from a file: values of options of its command."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from pathlib import Path

from research.reproduction.options import HopperParameters
from tegotae._support import documents
from tegotae._support.errors import TegotaeError, require_known, unknown
from tegotae.api.experiments import adjusted, with_parts
from tegotae.parts.fields import replace
from tegotae.systems.experiment import Experiment

STUDY, CALIBRATED = "study", "calibrated"
NAMES = (STUDY, CALIBRATED)
"""The study's own reading, and the one that docs/reproduction/calibration.md chooses."""


_Number = float | None
_Name = str | None


@dataclass(frozen=True, kw_only=True)
class ReadingOptions(HopperParameters):
    """Overrides for all experiments of a study."""

    HEADING = "Experiment"

    body: _Name = None
    """Replace the body by your own, FILE.py:OBJECT or MODULE:OBJECT."""
    height: _Number = None
    """Height of the release [m], in training and evaluation."""
    drop: _Number = None
    """Height by which the ground drops in the evaluation [m]."""
    duration: _Number = None
    """Duration of a training episode [s]."""
    tick: _Number = None
    """Control period in training [s]."""
    settle: _Number = None
    """Time at the start of an episode that the fitness leaves out [s]."""
    work: _Name = None
    """Definition of the actuator's work: absolute, positive or net."""
    hold: bool = False
    """Hold the controller over each tick of the training, as a robot does."""
    cot_only: bool = False
    """Use CoT⁻¹ alone as the fitness, without ΔΩ, as in the paper's comparison of algorithms."""
    frequency_weight: _Number = None
    """Weight of ΔΩ in the fitness [m/J per rad²/s²]: 1 with ΔΩ in rad²/s², 0.0253
    with ΔΩ in Hz²."""
    sector_start: _Number = None
    """Phase at which a vanilla sector starts [rad]."""
    sector_duration: _Number = None
    """Duration of a vanilla sector at ω [s]; replaces its width in phase."""
    newtons_per_feedback: _Number = None
    """Force of a vanilla reflex per unit of feedback [N s/rad]."""
    tuned_over: tuple[float, ...] = ()
    """Offsets from ω_t at which the gain of a pure V is searched for [rad/s], such as -2 -1 0 1 2
    for all frequencies of the evaluation."""
    fitness: _Name = None
    """Another fitness, FILE.py:OBJECT or MODULE:OBJECT."""
    oscillator: _Name = None
    """Another oscillator: hopf, adaptive-hopf, van-der-pol, matsuoka, or your own, FILE.py:OBJECT
    or MODULE:OBJECT. With the prefix learned- its parameters are trained, too."""
    vary: tuple[str, ...] = ()
    """Conditions that vary between episodes of training, such as mass_kg=0.08:0.12 (any value
    between), omega=6/8/10 (one of these) or push_x_n=-5:5@8:8.2 (from 8 s to 8.2 s)."""
    episodes_per_candidate: int | None = None
    """Number of episodes per candidate, if conditions vary."""
    omega_t: tuple[float, ...] = ()
    """Training frequencies ω_t [rad/s], in place of the scale's; 4 and 8 in the paper."""

    def at_frequencies(self, experiments: Sequence[Experiment]) -> tuple[Experiment, ...]:
        """Return the experiments at the frequencies ω_t, each named by its own.

        Raises:
            TegotaeError: for a frequency that is none.

        Example:
            >>> from tegotae.systems.recipe import recipe
            >>> names = ("V-sector-w4", "V-sector-w8", "T-Fv")
            >>> whole = [recipe(name).experiment() for name in names]
            >>> [each.name for each in ReadingOptions(omega_t=(3.0,)).at_frequencies(whole)]
            ['V-sector-w3', 'T-Fv']
        """
        by_name: dict[str, Experiment] = {}
        for experiment in experiments:
            omegas = () if experiment.omega is None else self.omega_t
            variants = [_with_omega(experiment, omega) for omega in omegas] or [experiment]
            by_name |= {variant.name: variant for variant in variants}
        return tuple(by_name.values())

    def applied(self, experiment: Experiment) -> Experiment:
        """Return an experiment with the given values.

        Raises:
            TegotaeError: for what does not fit together, or an option that the experiment's own
                body or fitness does not have.
        """
        overrides = {
            field.name: getattr(self, field.name)
            for field in fields(self)
            if getattr(self, field.name) != field.default and field.name != "omega_t"
        }
        parts = {name: overrides.pop(name) for name in _PARTS if name in overrides}
        options = {name: overrides[x] for x, name in _OPTIONS.items() if x in overrides}
        fitness = {name: overrides[x] for x, name in _OF_FITNESS.items() if x in overrides}
        changes = {"body": self.overrides or None, "fitness": fitness or None}
        return adjusted(with_parts(experiment, **parts), {**options, **changes})


def _with_omega(experiment: Experiment, omega: float) -> Experiment:
    """Return the experiment of a model at another frequency ω_t [rad/s]."""
    model, _, _ = experiment.name.rpartition("-w")
    return replace(experiment, {"name": f"{model}-w{omega:g}", "omega": omega})


_PARTS = ("body", "fitness", "oscillator")
_OPTIONS = {
    "height": "height_m",
    "drop": "drop_m",
    "duration": "duration_s",
    "tick": "tick_s",
    "work": "work",
    "hold": "hold",
    "cot_only": "cot_only",
    "sector_start": "sector_start_rad",
    "sector_duration": "sector_duration_s",
    "newtons_per_feedback": "newtons_per_feedback",
    "tuned_over": "tuned_over",
    "vary": "vary",
    "episodes_per_candidate": "episodes_per_candidate",
}
"""Options of an experiment."""
_OF_FITNESS = {"settle": "settle_s", "frequency_weight": "frequency_weight"}
"""Fields of the fitness."""


def reading_named(name: str) -> ReadingOptions:
    """Return the options of a named reading.

    Args:
        name: of `NAMES`, or of a file with an entry per option, in JSON or TOML.

    Raises:
        TegotaeError: for an unknown name, or a file that is not one of options.

    Example:
        >>> reading_named("calibrated").mass
        0.06861
    """
    if name == STUDY:
        return ReadingOptions()
    if name not in NAMES and not name.endswith((".json", ".toml")):
        raise unknown("reading", name, (*NAMES, "FILE.toml", "FILE.json"))
    file = Path(__file__).with_name("calibrated.json") if name == CALIBRATED else Path(name)
    try:
        values = documents.fitted(documents.read(file), dict)
        options = [field.name for field in fields(ReadingOptions)]
        for option in values:
            require_known("option", option, options)
        return documents.fitted(values, ReadingOptions)
    except FileNotFoundError:
        raise TegotaeError(f"cannot read the reading {name}: there is no such file") from None
    except TegotaeError as error:
        raise TegotaeError(f"cannot read the reading {name}: {error}") from None
