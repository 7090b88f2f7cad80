"""Experiments by name, and the options that change them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from tegotae._support.errors import TegotaeError
from tegotae._support.tables import parse_number
from tegotae.api.parameters import HIDDEN, Values, filled
from tegotae.measures.objectives.objective import Objective
from tegotae.parts.bodies import Body
from tegotae.parts.controller import Controller
from tegotae.parts.fields import replace, value_of
from tegotae.parts.terms import with_vanilla_settings
from tegotae.simulation.integrators import Hold
from tegotae.simulation.world import Condition, OneOf, Uniform
from tegotae.systems.experiment import Experiment
from tegotae.systems.parts_by_name import body_called, oscillator_called
from tegotae.systems.recipe import recipe, study_recipes
from tegotae.systems.registry import is_reference, load_object
from tegotae.systems.term_sets import BUDGET

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


_FIELDS = {
    "height_m": "height_m",
    "duration_s": "timing.duration_s",
    "tick_s": "timing.tick_s",
    "episodes_per_candidate": "episodes",
    "fitness": "objective",
    "body": "body",
}
"""Fields of an experiment by the options that set them."""
_FIELDS_OF_HOPPERS = {
    "drop_m": "protocol.drop_m",
    "work": "protocol.work",
    "tuned_over": "search_offsets",
}
"""The same on a body with one leg alone."""
_VANILLA = ("sector_start_rad", "sector_duration_s", "newtons_per_feedback")
"""Options of a vanilla actuation on a body with one leg."""


def option_defaults(experiment: Experiment) -> Values:
    """Return the experiment's own values of the options of a training.

    Args:
        experiment: the experiment.

    Example:
        >>> option_defaults(recipe("ART").experiment())["drop_m"]
        0.2
    """
    several = experiment.body.limbs > 1
    fields = _FIELDS if several else _FIELDS | _FIELDS_OF_HOPPERS
    return {
        "": experiment.name,
        "hold": isinstance(experiment.system.integrator, Hold),
        **{option: value_of(experiment, path) for option, path in fields.items()},
        **(dict.fromkeys((*_FIELDS_OF_HOPPERS, *_VANILLA), HIDDEN) if several else {}),
    }


def adjusted(experiment: Experiment, options: Mapping[str, Any]) -> Experiment:
    """Return an experiment with other values.

    Args:
        experiment: the experiment.
        options: options of `train` that differ; None stands for the experiment's own.

    Raises:
        TegotaeError: for an option that it does not have, or values that do not fit together.

    Example:
        >>> adjusted(recipe("ART").experiment(), {"body": {"mass_kg": 0.2}}).body.mass_kg
        0.2
    """
    defaults = option_defaults(experiment)
    filling = vars(filled(options, defaults))
    overrides = {
        name: x for name, x in filling.items() if x is not None and x != defaults.get(name)
    }
    fields = _FIELDS | _FIELDS_OF_HOPPERS
    updates = {fields[option]: x for option, x in overrides.items() if option in fields}
    if overrides.get("hold"):
        updates["integrator"] = Hold()
    if overrides.get("vary"):
        updates["conditions"] = conditions_named(overrides["vary"])
    objective = updates.get("objective", experiment.objective)
    if "work" in overrides and hasattr(objective, "work"):
        objective = replace(objective, {"work": overrides["work"]})
    if overrides.get("cot_only"):
        if not hasattr(objective, "follow_omega"):
            kind = type(objective).__name__
            raise TegotaeError(f"cot_only belongs to the paper's fitness; this one is a {kind}")
        objective = objective.without_frequency()
    updates["objective"] = objective
    if experiment.body.limbs == 1:
        updates["controller.actuation"] = with_vanilla_settings(
            experiment.controller.actuation,
            start_rad=overrides.get("sector_start_rad"),
            duration_s=overrides.get("sector_duration_s"),
            newtons_per_feedback=overrides.get("newtons_per_feedback"),
        )
        if "height_m" in overrides:
            updates["protocol.release_m"] = overrides["height_m"]
    return replace(experiment, updates)


def _for_weight(experiment: Experiment, body: Body) -> Controller:
    """Return the controller for another body, whose weight scales the push of a reflex."""
    weight_n, other_n = (getattr(x, "weight_n", None) for x in (experiment.body, body))
    scale = getattr(experiment.controller.actuation, "newtons_per_feedback", None)
    if not weight_n or not other_n or not isinstance(scale, float):
        return experiment.controller
    pushes = with_vanilla_settings(
        experiment.controller.actuation, newtons_per_feedback=scale * other_n / weight_n
    )
    return replace(experiment.controller, {"actuation": pushes})


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
    return replace(experiment, parts)


def _with_oscillator(experiment: Experiment, name: str, budget: int | None) -> Experiment:
    """Return the experiment with another oscillator; one without any stays as it is."""
    custom, oscillator = is_reference(name), oscillator_called(name)
    if experiment.controller.oscillator is None:
        return experiment
    label = f"{experiment.name}+{type(oscillator).__name__ if custom else name}"
    controller = replace(experiment.controller, {"oscillator": oscillator})
    if experiment.name in study_recipes() and not custom:
        # Its networks leave room for the weights of the oscillator.
        model = recipe(label)
        label = model.name
        controller = model.controller(BUDGET if budget is None else budget)
    return replace(experiment, {"name": label, "controller": controller})
