"""Whether a scenario and a body go together; told before anything is computed."""

from __future__ import annotations

import dataclasses
import inspect
import reprlib
from collections.abc import Mapping
from typing import Any

import numpy as np

from tegotae.bodies import Body
from tegotae.errors import TegotaeError, require_finite, unknown
from tegotae.oscillators import Oscillator
from tegotae.world.changes import OMEGA, Staircase, Step
from tegotae.world.scenario import Scenario


def check_posture(body: Body, scenario: Scenario) -> None:
    """Raise `TegotaeError` if the posture names what the body's release does not take."""
    takes = list(inspect.signature(body.release).parameters)[2:]
    _require_names("posture", scenario.posture, '{"pitch_rad": 0.1}')
    for name in dict(scenario.posture):
        if name not in takes:
            says = f"it takes {', '.join(takes)}" if takes else "it takes none"
            raise TegotaeError(f"{type(body).__name__} knows no posture {name!r}; {says}")


def check_rhythm(oscillator: Oscillator | None, scenario: Scenario, tick_s: float) -> None:
    """Raise `TegotaeError` if the oscillator has no such state, or is too stiff for the tick."""
    _require_names("rhythm", scenario.rhythm, '{"radius": 0.5}')
    known = () if oscillator is None else oscillator.STATE
    for name in dict(scenario.rhythm):
        if name not in known:
            what = "no oscillator" if oscillator is None else type(oscillator).__name__
            says = f"beside a phase it has {', '.join(known)}" if known else "it has a phase alone"
            raise TegotaeError(f"{what} starts with no {name!r}; {says}")
    if oscillator is None:
        return
    fastest = np.max(np.abs(np.asarray(scenario.omega, float)), initial=0.0)
    if np.isfinite(fastest):
        oscillator.check_tick(float(fastest), tick_s)


def check_changes(body: Body, scenario: Scenario, tick_s: float) -> None:
    """Raise `TegotaeError` if a change names no field of the body, or makes it an impossible one.

    Every body that a lane meets is made once, so that the body itself says what it refuses.
    """
    _require_names("changes", scenario.changes, '{"mass_kg": [0.1, 0.12]}')
    changes = dict(scenario.changes)
    for name, change in changes.items():
        if name == OMEGA:
            if not isinstance(change, (Step, Staircase)):
                raise TegotaeError(
                    f"the change of omega is {reprlib.repr(change)}; a frequency that holds for "
                    "the whole run is the scenario's omega, and a change of it is a Step or a "
                    "Staircase"
                )
        else:
            _require_field(body, name)
            _check_numbers(name, change)
    fields = {name: change for name, change in changes.items() if name != OMEGA}
    always = {name: x for name, x in fields.items() if not isinstance(x, (Step, Staircase))}
    for body_met in _bodies(body, always):
        body_met.check_tick(tick_s)
        for name, change in fields.items():
            if isinstance(change, Step):
                for later in _bodies(body_met, {name: change.value}):
                    later.check_tick(tick_s)


def _bodies(body: Body, values: Mapping[str, Any]) -> list[Body]:
    """A body for every combination of values that some lane has."""
    if not values:
        return [body]
    columns = [np.asarray(value, float) for value in values.values()]
    lanes = max(x.shape[-1] if x.ndim else 1 for x in columns)
    try:
        rows = [np.broadcast_to(x, (*x.shape[:-1], lanes)).reshape(-1, lanes) for x in columns]
    except ValueError:
        shapes = ", ".join(str(x.shape) for x in columns)
        raise TegotaeError(
            f"changes have shapes {shapes}; each must be a number or have one entry per lane"
        ) from None
    made = []
    for lane in np.unique(np.concatenate(rows), axis=1).T:
        met, start = body, 0
        changed = {}
        for name, of_field in zip(values, rows, strict=True):
            own = lane[start : start + len(of_field)]
            start += len(of_field)
            changed[name] = float(own[0]) if len(own) == 1 else tuple(map(float, own))
        made.append(_with(met, changed))
    return made


def _with(value: Any, fields: Mapping[str, Any]) -> Any:
    """The same with other fields, validated; "terrain.rise_m" is a field of a field."""
    plain = {name: x for name, x in fields.items() if "." not in name}
    nested: dict[str, dict[str, Any]] = {}
    for name, x in fields.items():
        outer, dot, inner = name.partition(".")
        if dot:
            nested.setdefault(outer, {})[inner] = x
    plain |= {outer: _with(getattr(value, outer), inner) for outer, inner in nested.items()}
    for name, x in plain.items():
        usual = getattr(value, name)
        if isinstance(usual, tuple) and not isinstance(x, tuple):
            plain[name] = (x,) * len(usual)
    return dataclasses.replace(value, **plain)


def _require_field(body: Body, name: str) -> None:
    value: Any = body
    for part in name.split("."):
        known = (
            [f.name for f in dataclasses.fields(value)] if dataclasses.is_dataclass(value) else []
        )
        if part not in known:
            raise unknown(f"field of a {type(value).__name__}", part, known)
        value = getattr(value, part)


def _check_numbers(name: str, change: Any) -> None:
    values = change._asdict() if isinstance(change, (Step, Staircase)) else {"": change}
    for entry, value in values.items():
        what = f"the change of {name}" + (f", {entry}," if entry else "")
        for number in np.ravel(np.asarray(value, object)):
            if entry in ("until_s", "levels", "from_s") and number == float("inf"):
                continue
            require_finite(what, number)


def _require_names(what: str, given: Any, example: str) -> None:
    if not isinstance(given, Mapping) and given != ():
        raise TegotaeError(
            f"{what} is {reprlib.repr(given)}; it must be numbers by name, such as {example}"
        )
