"""Options that several commands share."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Annotated, Any

import tyro

from tegotae._support.errors import TegotaeError
from tegotae._support.tables import number
from tegotae.measures.objectives.fitness import Fitness
from tegotae.measures.objectives.objective import Objective
from tegotae.parts.bodies import Body, Interface
from tegotae.parts.terms import with_vanilla_settings
from tegotae.simulation.integrators import Hold
from tegotae.simulation.world import Condition, OneOf, Uniform
from tegotae.systems.experiment import Experiment
from tegotae.systems.grammar import BUDGET
from tegotae.systems.models import all_models, find
from tegotae.systems.resolve import Resolved, oscillator_called, resolve
from tegotae.systems.user_objects import is_reference, named

_TIMES = ("from_s", "until_s")
_HOW = (
    "write NAME=LOW:HIGH, NAME=VALUE/VALUE or, limb by limb, NAME=1,1/0,1, and @FROM:UNTIL behind "
    "it if it holds for a time only"
)


def conditions_named(texts: Iterable[str]) -> tuple[Condition, ...]:
    """The conditions of `--vary`.

    Raises:
        TegotaeError: for a text that is none.

    Example:
        >>> conditions_named(["mass_kg=0.08:0.12"])
        (Uniform(name='mass_kg', from_s=0.0, until_s=None, low=0.08, high=0.12),)
        >>> conditions_named(["push_x_n=-5/5@8:8.2"])
        (OneOf(name='push_x_n', from_s=8.0, until_s=8.2, values=(-5.0, 5.0)),)
    """
    return tuple(map(_condition, texts))


def _condition(text: str) -> Condition:
    name, _, rest = text.partition("=")
    values, at, times = rest.partition("@")
    try:
        numbers = [number(each) for each in times.split(":")] if at else []
        if len(numbers) > len(_TIMES):
            raise ValueError
        window: dict[str, float] = dict(zip(_TIMES, numbers, strict=False))
        return _drawn(name, values, window)
    except ValueError as error:
        if isinstance(error, TegotaeError):
            raise
        raise TegotaeError(f"--vary {text} is no condition; {_HOW}") from None


def _drawn(name: str, values: str, window: dict[str, float]) -> Condition:
    if ":" in values:
        low, high = map(number, values.split(":"))
        return Uniform(name, low=low, high=high, **window)
    rows = [tuple(map(number, each.split(","))) for each in values.split("/")]
    if all(len(row) == 1 for row in rows):
        return OneOf(name, values=tuple(number for (number,) in rows), **window)
    return OneOf(name, values=tuple(rows), **window)


BodysOwn = Annotated[float | None, tyro.conf.arg(help_behavior_hint="(default: the body's)")]
"""A parameter of a body."""
SystemsOwn = Annotated[float | None, tyro.conf.arg(help_behavior_hint="(default: the system's)")]
"""A number that a system has, too."""
OWN = tyro.conf.arg(help_behavior_hint="(default: the experiment's)")
"""For an option without which an experiment stays as it is."""
UNSET = tyro.conf.arg(help_behavior_hint="")
"""For an option whose help says what leaving it out means."""


Several = tyro.conf.UseAppendAction[tuple[tuple[str, ...], ...]]
"""Words of an option that may be given several times, each time with one word or a list."""


@dataclass(frozen=True, kw_only=True)
class HopperParameters:
    """The hopper's parameters, which other bodies may have, too; those not given are left as
    they are."""

    HEADING = "Body"

    mass: BodysOwn = None
    """Mass [kg]."""
    stiffness: BodysOwn = None
    """Spring stiffness [N/m]."""
    damping: BodysOwn = None
    """Damping in stance [N s/m]."""
    flight_damping: BodysOwn = None
    """Damping in flight [N s/m]."""
    rest_length: BodysOwn = None
    """Rest length of the leg [m]."""
    gravity: BodysOwn = None
    """Gravity [m/s²]."""
    max_force: BodysOwn = None
    """Largest actuator force [N]."""

    @property
    def given(self) -> dict[str, float]:
        """The parameters that were given, by the names of the hopper's fields."""
        values = {
            "mass_kg": self.mass,
            "stiffness_n_per_m": self.stiffness,
            "damping_ns_per_m": self.damping,
            "flight_damping_ns_per_m": self.flight_damping,
            "rest_length_m": self.rest_length,
            "gravity_m_per_s2": self.gravity,
            "max_force_n": self.max_force,
        }
        return {name: value for name, value in values.items() if value is not None}

    def on(self, body: Body) -> Body:
        """A body with the parameters that were given.

        Raises:
            TegotaeError: for a parameter that the body does not have.
        """
        if not self.given:
            return body
        own = {field.name for field in dataclasses.fields(body)}  # type: ignore[arg-type]
        for name in self.given:
            if name not in own:
                raise TegotaeError(
                    f"a {type(body).__name__} has no {name}; its own are {', '.join(sorted(own))}"
                )
        return dataclasses.replace(body, **self.given)  # type: ignore[type-var]


@dataclass(frozen=True, kw_only=True)
class BodyOptions(HopperParameters):
    """What of something that has a body, an experiment or a controller, that body is to be."""

    HEADING = "Body"

    body: Annotated[str | None, UNSET] = None
    """Replace the body by your own, FILE.py:OBJECT or MODULE:OBJECT."""

    def in_place_of(self, own: Body) -> Body:
        """The body that was named, or else its own, with the parameters that were given.

        Raises:
            TegotaeError: for a name that is no body's, or a parameter that it does not have.
        """
        return self.on(own if self.body is None else named(self.body, Body, "body"))


@dataclass(frozen=True, kw_only=True)
class ExperimentOptions(BodyOptions):
    """What of an experiment is to be other than it is by itself."""

    HEADING = "Experiment"

    height: Annotated[float | None, OWN] = None
    """Height of the release [m], in training and evaluation."""
    drop: Annotated[float | None, OWN] = None
    """Height by which the ground drops in the evaluation [m]."""
    duration: Annotated[float | None, OWN] = None
    """Duration of a training episode [s]."""
    tick: Annotated[float | None, OWN] = None
    """Control period in training [s]."""
    settle: Annotated[float | None, OWN] = None
    """Time at the start of an episode that the fitness leaves out [s]."""
    work: Annotated[str | None, OWN] = None
    """Definition of the actuator's work: absolute, positive or net."""
    hold: bool = False
    """Hold the controller over each tick of the training, as a robot does."""
    cot_only: bool = False
    """Use CoT⁻¹ alone as the fitness, without ΔΩ, as in the paper's comparison of algorithms.
    Agents always do."""
    frequency_weight: Annotated[float | None, OWN] = None
    """Weight of ΔΩ in the fitness [m/J per rad²/s²]: 1 with ΔΩ in rad²/s², 0.0253
    with ΔΩ in Hz²."""
    sector_start: Annotated[float | None, OWN] = None
    """Phase at which a vanilla sector starts [rad]."""
    sector_duration: Annotated[float | None, OWN] = None
    """Duration of a vanilla sector at ω [s]; replaces its width in phase."""
    newtons_per_feedback: Annotated[float | None, OWN] = None
    """Force of a vanilla reflex per unit of feedback [N s/rad]."""
    tuned_over: Annotated[tuple[float, ...], OWN] = ()
    """Offsets from ω_t at which the gain of a pure V is searched for [rad/s], such as -2 -1 0 1 2
    for all frequencies of the evaluation."""
    fitness: Annotated[str | None, OWN] = None
    """Another fitness, FILE.py:OBJECT or MODULE:OBJECT. On an environment: hopping (CoT⁻¹ + ΔΩ),
    return (the sum of its rewards), or a function of an episode, FILE.py:FUNCTION or
    MODULE:FUNCTION."""
    oscillator: Annotated[str | None, OWN] = None
    """Another oscillator: hopf, adaptive-hopf, van-der-pol, matsuoka, or your own, FILE.py:OBJECT
    or MODULE:OBJECT. With the prefix learned- its parameters are trained, too."""
    vary: Annotated[tuple[str, ...], UNSET] = ()
    """Conditions that vary between episodes of training, such as mass_kg=0.08:0.12 (any value
    between), omega=6/8/10 (one of these) or push_x_n=-5:5@8:8.2 (from 8 s to 8.2 s)."""
    episodes_per_candidate: Annotated[int | None, OWN] = None
    """Number of episodes per candidate, if conditions vary."""

    def applied(self, experiment: Experiment, budget: int | None = None) -> Experiment:
        """The experiment with what was given.

        Args:
            experiment: as it is by itself.
            budget: largest number of trained parameters, of a model; the paper's by default.

        Raises:
            TegotaeError: for what does not fit together, or an option that the experiment's own
                body or fitness does not have.
        """
        if experiment.body.limbs > 1 and self.drop is not None:
            raise TegotaeError(f"--drop is for bodies with one leg; {experiment.name} has several")
        times = {"duration_s": self.duration, "tick_s": self.tick}
        heights = {"release_m": self.height, "drop_m": self.drop, "work": self.work}
        if self.oscillator is not None:
            experiment = with_oscillator(experiment, self.oscillator, budget)
        changes = {
            "height_m": self.height,
            "episodes": self.episodes_per_candidate,
            "search_offsets": self.tuned_over or None,
        }
        actuation = with_vanilla_settings(
            experiment.controller.actuation,
            start_rad=self.sector_start,
            duration_s=self.sector_duration,
            newtons_per_feedback=self.newtons_per_feedback,
        )
        return experiment.replaced(
            controller=dataclasses.replace(experiment.controller, actuation=actuation),
            body=self.in_place_of(experiment.body),
            conditions=conditions_named(self.vary) or experiment.conditions,
            timing=dataclasses.replace(experiment.timing, **_given(times)),
            integrator=Hold() if self.hold else experiment.system.integrator,
            objective=self._objective(experiment.objective),
            protocol=dataclasses.replace(experiment.protocol, **_given(heights)),
            **_given(changes),
        )

    def _objective(self, own: Objective) -> Objective:
        if self.fitness is not None:
            own = named(self.fitness, Objective, "fitness")
        values = _given(
            {
                "settle_s": self.settle,
                "work": self.work,
                "frequency_weight": self.frequency_weight,
            }
        )
        if self.cot_only:
            values["follow_omega"] = False
        if values and not isinstance(own, Fitness):
            option = {"settle_s": "settle", "follow_omega": "cot-only"}
            option |= {"frequency_weight": "frequency-weight"}
            name = next(iter(values))
            raise TegotaeError(
                f"--{option.get(name, name)} belongs to the paper's fitness; this one is a "
                f"{type(own).__name__}"
            )
        return dataclasses.replace(own, **values) if isinstance(own, Fitness) else own


def experiment_named(name: str, budget: int | None = None) -> Experiment:
    """The experiment of a name (`tegotae.systems.resolve`).

    Args:
        name: such as ART, ART@quadruped-c for a body with legs, or `FILE.py:OBJECT`.
        budget: largest number of trained parameters, of a model; the paper's by default.

    Raises:
        TegotaeError: for a name without one, or a budget for what is no model of the paper.
    """
    return resolve(name, budget=budget).experiment()


def experiments_at(place: str) -> list[Experiment]:
    """The experiments of a name: one, or a list in a user's own file or a file of documents.

    Raises:
        TegotaeError: if there are none, or they cannot be read.
    """
    found = resolve(place)
    return list(found.experiments) or [found.experiment()]


def with_oscillator(experiment: Experiment, name: str, budget: int | None = None) -> Experiment:
    """The experiment with another oscillator; one without any stays as it is.

    Args:
        experiment: as it is.
        name: of the oscillator, or `FILE.py:OBJECT`.
        budget: largest number of trained parameters, of a model; the paper's by default.

    Raises:
        TegotaeError: for an unknown oscillator, or what does not fit together.
    """
    oscillator = oscillator_called(name)
    if experiment.controller.oscillator is None:
        return experiment
    called = f"{experiment.name}+{type(oscillator).__name__ if is_reference(name) else name}"
    controller = dataclasses.replace(experiment.controller, oscillator=oscillator)
    if experiment.name in all_models() and not is_reference(name):
        # Its networks leave room for the weights of the oscillator.
        model = find(called)
        called, controller = model.name, model.controller(BUDGET if budget is None else budget)
    return experiment.replaced(name=called, controller=controller)


def _given(values: dict[str, Any]) -> dict[str, Any]:
    return {name: value for name, value in values.items() if value is not None}


def require_ours(found: Resolved) -> None:
    """Raise `TegotaeError` for a controller of limbs that a foreign simulator moves."""
    if isinstance(found.body, Interface):
        raise TegotaeError(
            f"{found.name} drives the limbs of another simulator, whose mechanics are not here; "
            "tegotae simulate and tegotae evaluate run it there"
        )
