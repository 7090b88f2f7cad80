"""Experiments by name, and the options that change them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any, cast

from tegotae._support.errors import TegotaeError
from tegotae._support.tables import parse_number
from tegotae.api.parameters import HIDDEN, Values, filled
from tegotae.measures.objectives.objective import Objective
from tegotae.parts.bodies import Body
from tegotae.parts.controller import Controller
from tegotae.parts.terms import with_vanilla_settings
from tegotae.simulation.integrators import Hold
from tegotae.simulation.world import Condition, OneOf, Uniform
from tegotae.systems.body_file import body_called
from tegotae.systems.experiment import Experiment
from tegotae.systems.grammar import BUDGET
from tegotae.systems.models import all_models, find
from tegotae.systems.resolve import oscillator_called, resolve
from tegotae.systems.user_objects import is_reference, load_object

_HOW = (
    "write NAME=LOW:HIGH, NAME=VALUE/VALUE or, limb by limb, NAME=1,1/0,1, and @FROM:UNTIL behind "
    "it if it holds for a time only"
)


def conditions_named(texts: Iterable[str]) -> tuple[Condition, ...]:
    """Return the conditions of the option `vary`.

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
    name, _, definition = text.partition("=")
    values, separator, times = definition.partition("@")
    try:
        numbers = [parse_number(time) for time in times.split(":")] if separator else []
        from_s, until_s = [*numbers, *(0.0, None)[len(numbers) :]]
        if ":" in values:
            low, high = map(parse_number, values.split(":"))
            return Uniform(name, from_s, until_s, low=low, high=high)
        rows = [tuple(map(parse_number, row.split(","))) for row in values.split("/")]
        constant = all(len(row) == 1 for row in rows)
        return OneOf(name, from_s, until_s, values=tuple(r[0] if constant else r for r in rows))
    except TegotaeError:
        raise
    except ValueError:
        raise TegotaeError(f"vary: {text} is no condition; {_HOW}") from None


_OF_HOPPERS = (
    *("drop_m", "work", "tuned_over"),
    *("sector_start_rad", "sector_duration_s", "newtons_per_feedback"),
)
"""Options of an experiment on a body with one leg alone."""


def option_defaults(experiment: Experiment) -> Values:
    """Return the experiment's own values of the options of a training.

    Args:
        experiment: the experiment.

    Example:
        >>> option_defaults(find("ART").experiment())["drop_m"]
        0.2
    """
    values: dict[str, Any] = {
        "": experiment.name,
        "height_m": experiment.system.release.height_m,
        "duration_s": experiment.timing.duration_s,
        "tick_s": experiment.timing.tick_s,
        "hold": isinstance(experiment.system.integrator, Hold),
        "episodes_per_candidate": experiment.episodes,
        "fitness": experiment.objective,
        "body": experiment.body,
    }
    if experiment.body.limbs > 1:
        return values | dict.fromkeys(_OF_HOPPERS, HIDDEN)
    protocol = experiment.protocol
    further = {"drop_m": protocol.drop_m, "work": protocol.work}
    return values | further | {"tuned_over": experiment.search_offsets}


def adjusted(experiment: Experiment, options: Mapping[str, Any]) -> Experiment:
    """Return an experiment with other values.

    Args:
        experiment: the experiment.
        options: options of `train` that differ; None stands for the experiment's own.

    Raises:
        TegotaeError: for an option that it does not have, or values that do not fit together.

    Example:
        >>> adjusted(find("ART").experiment(), {"body": {"mass_kg": 0.2}}).body.mass_kg
        0.2
    """
    defaults = option_defaults(experiment)
    filling = vars(filled(options, defaults))
    overrides = {
        name: x for name, x in filling.items() if x is not None and x != defaults.get(name)
    }
    updates: dict[str, Any] = {
        field: overrides[name]
        for name, field in (("height_m", "height_m"), ("fitness", "objective"), ("body", "body"))
        if name in overrides
    }
    times = {name: overrides[name] for name in ("duration_s", "tick_s") if name in overrides}
    if times:
        updates["timing"] = replace(experiment.timing, **times)
    if overrides.get("hold"):
        updates["integrator"] = Hold()
    if "episodes_per_candidate" in overrides:
        updates["episodes"] = overrides["episodes_per_candidate"]
    if overrides.get("vary"):
        updates["conditions"] = conditions_named(overrides["vary"])
    objective = updates.get("objective", experiment.objective)
    if overrides.get("cot_only"):
        if not hasattr(objective, "follow_omega"):
            kind = type(objective).__name__
            raise TegotaeError(f"cot_only belongs to the paper's fitness; this one is a {kind}")
        updates["objective"] = objective = objective.without_frequency()
    if experiment.body.limbs == 1:
        updates |= _of_hopper(experiment, overrides, objective)
    return experiment.replaced(**updates)


def _of_hopper(
    experiment: Experiment, overrides: Mapping[str, Any], objective: Objective
) -> dict[str, Any]:
    """Options of a body with one leg, by the names that `Experiment.replaced` takes."""
    of_protocol = {"drop_m": "drop_m", "work": "work", "height_m": "release_m"}
    evaluated = {field: overrides[name] for name, field in of_protocol.items() if name in overrides}
    controller = experiment.controller
    actuation = with_vanilla_settings(
        controller.actuation,
        start_rad=overrides.get("sector_start_rad"),
        duration_s=overrides.get("sector_duration_s"),
        newtons_per_feedback=overrides.get("newtons_per_feedback"),
    )
    updates: dict[str, Any] = {
        "controller": replace(controller, actuation=actuation),
        "protocol": replace(experiment.protocol, **evaluated),
        "search_offsets": overrides.get("tuned_over", experiment.search_offsets),
    }
    if "work" in overrides and hasattr(objective, "work"):
        updates["objective"] = replace(cast(Any, objective), work=overrides["work"])
    return updates


def _for_weight(experiment: Experiment, body: Body) -> Controller:
    """The controller for a body of another weight, on which a reflex pushes in proportion to it."""
    weight_n, other_n = (getattr(x, "weight_n", None) for x in (experiment.body, body))
    scale = getattr(experiment.controller.actuation, "newtons_per_feedback", None)
    if not weight_n or not other_n or not isinstance(scale, float):
        return experiment.controller
    pushes = with_vanilla_settings(
        experiment.controller.actuation, newtons_per_feedback=scale * other_n / weight_n
    )
    return replace(experiment.controller, actuation=pushes)


def experiment_named(name: Any, *, budget: int | None = None, **parts: Any) -> Experiment:
    """Return the experiment of a name.

    Args:
        name: a model, a design, an architecture, FILE.py:OBJECT, or an object.
        budget: maximum number of trained parameters of a model; the paper's by default.
        parts: parts of `with_parts`.

    Raises:
        TegotaeError: for a name without one, a budget for another experiment than a model of the
            paper, or parts that do not fit together.
    """
    return with_parts(resolve(name, budget=budget).experiment(), budget=budget, **parts)


def with_parts(
    experiment: Experiment,
    *,
    budget: int | None = None,
    oscillator: str | None = None,
    body: Any = None,
    fitness: Any = None,
) -> Experiment:
    """Return an experiment with other parts, by name or as objects.

    Args:
        experiment: the experiment.
        budget: maximum number of trained parameters of a model.
        oscillator: name of an oscillator, or FILE.py:OBJECT.
        body: a body, or FILE.toml, FILE.py:OBJECT or MODULE:OBJECT.
        fitness: an objective, or FILE.py:OBJECT or MODULE:OBJECT.

    Raises:
        TegotaeError: for parts that there are not, or that do not fit together.
    """
    body, fitness = (x.get("name") if isinstance(x, Mapping) else x for x in (body, fitness))
    if oscillator is not None:
        experiment = _with_oscillator(experiment, oscillator, budget)
    parts: dict[str, Any] = {}
    if isinstance(body, (str, Body)):
        parts["body"] = body_called(body) if isinstance(body, str) else body
        parts["controller"] = _for_weight(experiment, parts["body"])
    if isinstance(fitness, str):
        parts["objective"] = load_object(fitness, Objective, "fitness")
    elif fitness is not None:
        parts["objective"] = fitness
    return experiment.replaced(**parts)


def _with_oscillator(experiment: Experiment, name: str, budget: int | None) -> Experiment:
    """The experiment with another oscillator; one without any stays as it is."""
    custom, oscillator = is_reference(name), oscillator_called(name)
    if experiment.controller.oscillator is None:
        return experiment
    label = f"{experiment.name}+{type(oscillator).__name__ if custom else name}"
    controller = replace(experiment.controller, oscillator=oscillator)
    if experiment.name in all_models() and not custom:
        # Its networks leave room for the weights of the oscillator.
        model = find(label)
        label = model.name
        controller = model.controller(BUDGET if budget is None else budget)
    return experiment.replaced(name=label, controller=controller)
