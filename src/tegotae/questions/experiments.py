"""What is trained, by name, and the options that change it."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any, Self

from tegotae._support.errors import TegotaeError
from tegotae._support.tables import number
from tegotae.measures.objectives.objective import Objective
from tegotae.parts.bodies import Body
from tegotae.parts.controller import Controller
from tegotae.parts.terms import with_vanilla_settings
from tegotae.questions.options import changes
from tegotae.questions.question import Names
from tegotae.questions.task import Work
from tegotae.simulation.integrators import Hold
from tegotae.simulation.world import Condition, OneOf, Uniform
from tegotae.systems.body_file import body_called
from tegotae.systems.experiment import Experiment
from tegotae.systems.grammar import BUDGET
from tegotae.systems.models import all_models, find
from tegotae.systems.resolve import oscillator_called, resolve
from tegotae.systems.user_objects import is_reference, named

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
        numbers = [number(time) for time in times.split(":")] if at else []
        from_s, until_s = [*numbers, *(0.0, None)[len(numbers) :]]
        if ":" in values:
            low, high = map(number, values.split(":"))
            return Uniform(name, from_s, until_s, low=low, high=high)
        rows = [tuple(map(number, row.split(","))) for row in values.split("/")]
        alike = all(len(row) == 1 for row in rows)
        return OneOf(name, from_s, until_s, values=tuple(r[0] if alike else r for r in rows))
    except TegotaeError:
        raise
    except ValueError:
        raise TegotaeError(f"--vary {text} is no condition; {_HOW}") from None


@dataclass(frozen=True, kw_only=True)
class ExperimentOptions:
    """An episode of training, what varies in it, the fitness and the body."""

    height_m: float
    """Height of the release [m], in training and evaluation."""
    duration_s: float
    """Duration of a training episode [s]."""
    tick_s: float
    """Control period in training [s]."""
    hold: bool
    """Hold the controller over each tick of the training, as a robot does."""
    cot_only: bool = False
    """Use CoT⁻¹ alone as the fitness, without ΔΩ, as in the paper's comparison of algorithms.
    Agents always do."""
    vary: tuple[str, ...] = ()
    """Conditions that vary between episodes of training, such as mass_kg=0.08:0.12 (any value
    between), omega=6/8/10 (one of these) or push_x_n=-5:5@8:8.2 (from 8 s to 8.2 s)."""
    episodes_per_candidate: int
    """Number of episodes per candidate, if conditions vary."""
    objective: Objective
    body: Body

    @classmethod
    def options_of(cls, experiment: Experiment) -> Self:
        """An experiment's own values."""
        own = cls if cls is not ExperimentOptions or experiment.body.limbs > 1 else HopperOptions
        return own(**own._values(experiment))  # type: ignore[return-value]

    @classmethod
    def _values(cls, experiment: Experiment) -> dict[str, Any]:
        return {
            "height_m": experiment.system.release.height_m,
            "duration_s": experiment.timing.duration_s,
            "tick_s": experiment.timing.tick_s,
            "hold": isinstance(experiment.system.integrator, Hold),
            "episodes_per_candidate": experiment.episodes,
            "objective": experiment.objective,
            "body": experiment.body,
        }

    def applied(self, experiment: Experiment) -> Experiment:
        """The experiment with what differs from its own.

        Args:
            experiment: whose options these are.

        Raises:
            TegotaeError: for what does not fit together.
        """
        given = changes(self, type(self).options_of(experiment))
        return experiment.replaced(**self._fields(experiment, given))

    def _fields(self, experiment: Experiment, given: dict[str, Any]) -> dict[str, Any]:
        """What is given, by the names that `Experiment.replaced` takes."""
        made = {n: x for n, x in given.items() if n in ("height_m", "objective", "body")}
        times = {name: given[name] for name in ("duration_s", "tick_s") if name in given}
        if times:
            made["timing"] = replace(experiment.timing, **times)
        if "hold" in given:
            made["integrator"] = Hold()
        if "episodes_per_candidate" in given:
            made["episodes"] = self.episodes_per_candidate
        if self.vary:
            made["conditions"] = conditions_named(self.vary)
        if self.cot_only:
            if not hasattr(self.objective, "follow_omega"):
                kind = type(self.objective).__name__
                raise TegotaeError(
                    f"--cot-only belongs to the paper's fitness; this one is a {kind}"
                )
            made["objective"] = self.objective.without_frequency()
        return made


@dataclass(frozen=True, kw_only=True)
class HopperOptions(ExperimentOptions):
    """An episode of training, what varies in it, the fitness, the body, and the evaluation."""

    drop_m: float
    """Height by which the ground drops in the evaluation [m]."""
    work: Work
    """Definition of the actuator's work."""
    sector_start_rad: float | None = None
    """Phase at which a vanilla sector starts [rad]."""
    sector_duration_s: float | None = None
    """Duration of a vanilla sector at ω [s]; replaces its width in phase."""
    newtons_per_feedback: float | None = None
    """Force of a vanilla reflex per unit of feedback [N s/rad]."""
    tuned_over: tuple[float, ...]
    """Offsets from ω_t at which the gain of a pure V is searched for [rad/s], such as -2 -1 0 1 2
    for all frequencies of the evaluation."""

    @classmethod
    def _values(cls, experiment: Experiment) -> dict[str, Any]:
        return super()._values(experiment) | {
            "drop_m": experiment.protocol.drop_m,
            "work": experiment.protocol.work,
            "tuned_over": experiment.search_offsets,
        }

    def _fields(self, experiment: Experiment, given: dict[str, Any]) -> dict[str, Any]:
        made = super()._fields(experiment, given)
        of_protocol = {"drop_m": "drop_m", "work": "work", "height_m": "release_m"}
        evaluated = {field: given[name] for name, field in of_protocol.items() if name in given}
        controller = experiment.controller
        actuation = with_vanilla_settings(
            controller.actuation,
            start_rad=self.sector_start_rad,
            duration_s=self.sector_duration_s,
            newtons_per_feedback=self.newtons_per_feedback,
        )
        objective = made.get("objective", self.objective)
        if "work" in given and hasattr(objective, "work"):
            made["objective"] = replace(objective, work=self.work)
        return made | {
            "controller": replace(controller, actuation=actuation),
            "protocol": replace(experiment.protocol, **evaluated),
            "search_offsets": self.tuned_over,
        }


def _for_weight(experiment: Experiment, body: Body) -> Controller:
    """The controller for a body of another weight, on which a reflex pushes in proportion to it."""
    own, other = (getattr(of, "weight_n", None) for of in (experiment.body, body))
    scale = getattr(experiment.controller.actuation, "newtons_per_feedback", None)
    if not own or not other or not isinstance(scale, float):
        return experiment.controller
    pushes = with_vanilla_settings(
        experiment.controller.actuation, newtons_per_feedback=scale * other / own
    )
    return replace(experiment.controller, actuation=pushes)


@dataclass(frozen=True, kw_only=True)
class Experiments(Names):
    """Experiments by name. The fields, which decide what is trained, are options as well."""

    NAMED = (
        "A name is a model (see `tegotae models`), an architecture such as ART, a design for a "
        "body with legs such as ART@quadruped-c, or an experiment of your own, FILE.py:OBJECT or "
        "MODULE:OBJECT. What it names has options of its own."
    )

    budget: int | None = None
    """Maximum number of trained parameters of a model; the paper's by default."""
    oscillator: str | None = None
    """Another oscillator: hopf, adaptive-hopf, van-der-pol, matsuoka, or your own, FILE.py:OBJECT
    or MODULE:OBJECT. With the prefix learned- its parameters are trained, too."""
    body: str | None = None
    """Replace the body by your own, FILE.toml of `tegotae identify`, FILE.py:OBJECT or
    MODULE:OBJECT."""
    fitness: str | None = None
    """Another fitness, FILE.py:OBJECT or MODULE:OBJECT. On an environment: hopping (CoT⁻¹ + ΔΩ),
    return (the sum of its rewards), or a function of an episode, FILE.py:FUNCTION or
    MODULE:FUNCTION."""

    def named(self, *names: Any) -> Sequence[Any]:
        """The experiments.

        Raises:
            TegotaeError: for a name without one, a budget for what is no model of the paper, or
                what does not fit together.
        """
        return [self.applied(resolve(name, budget=self.budget).experiment()) for name in names]

    def applied(self, experiment: Experiment) -> Experiment:
        """The experiment with the parts that are named."""
        if self.oscillator is not None:
            experiment = self._with_oscillator(experiment, self.oscillator)
        given: dict[str, Any] = {}
        if self.body is not None:
            given["body"] = body_called(self.body)
            given["controller"] = _for_weight(experiment, given["body"])
        if self.fitness is not None:
            given["objective"] = named(self.fitness, Objective, "fitness")
        return experiment.replaced(**given)

    def _with_oscillator(self, experiment: Experiment, name: str) -> Experiment:
        """With another oscillator; one without any stays as it is."""
        own, oscillator = is_reference(name), oscillator_called(name)
        if experiment.controller.oscillator is None:
            return experiment
        called = f"{experiment.name}+{type(oscillator).__name__ if own else name}"
        controller = replace(experiment.controller, oscillator=oscillator)
        if experiment.name in all_models() and not own:
            # Its networks leave room for the weights of the oscillator.
            model = find(called)
            budget = BUDGET if self.budget is None else self.budget
            called, controller = model.name, model.controller(budget)
        return experiment.replaced(name=called, controller=controller)
