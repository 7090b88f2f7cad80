"""Whether a scenario and a body go together, before anything is computed."""

from __future__ import annotations

import reprlib
from collections.abc import Mapping

import numpy as np

from tegotae._support.errors import TegotaeError, require_finite
from tegotae.parts._shapes import LaneNumbers
from tegotae.parts.bodies import Body
from tegotae.parts.fields import FieldNumber, number_of, with_fields
from tegotae.parts.oscillators import Oscillator
from tegotae.simulation.world.scenario import (
    GROUND,
    OMEGA,
    Scenario,
    Staircase,
    Step,
)

_NO_FIELDS = {
    OMEGA: "a frequency that holds for the whole run is the scenario's omega",
    GROUND: "ground that is lower from the release on is a release from higher up",
}
"""Changes that are none of the body, and what is said of one that is no change."""


def check_initial_pose(body: Body, scenario: Scenario) -> None:
    """Raise `TegotaeError` if the initial pose names what the body's release does not take."""
    takes = body.pose_names
    _require_names("initial_pose", scenario.initial_pose, '{"pitch_rad": 0.1}')
    for name in dict(scenario.initial_pose):
        if name not in takes:
            hint = f"it takes {', '.join(takes)}" if takes else "it takes none"
            raise TegotaeError(f"{type(body).__name__} has no initial_pose {name!r}; {hint}")


def check_oscillator_state(
    oscillator: Oscillator | None, scenario: Scenario, tick_s: float, duration_s: float
) -> None:
    """Raise `TegotaeError` if the oscillator has no such state, or is too stiff for the tick."""
    _require_names("oscillator_state", scenario.oscillator_state, '{"radius": 0.5}')
    known = () if oscillator is None else oscillator.STATE
    for name in dict(scenario.oscillator_state):
        if name not in known:
            what = "no oscillator" if oscillator is None else type(oscillator).__name__
            hint = f"beside a phase it has {', '.join(known)}" if known else "it has a phase alone"
            raise TegotaeError(f"{what} starts with no {name!r}; {hint}")
    if oscillator is None:
        return
    most = fastest(scenario, duration_s)
    if np.isfinite(most):
        oscillator.check_tick(most, tick_s)


def check_changes(body: Body, scenario: Scenario, tick_s: float, duration_s: float) -> None:
    """Raise `TegotaeError` if a change names no field of the body, or makes it an impossible one.

    Every body that some lane meets is made once, so that the body itself says what it refuses.
    """
    _require_names("changes", scenario.changes, '{"mass_kg": [0.1, 0.12]}')
    changes = dict(scenario.changes)
    for name, change in changes.items():
        if name in _NO_FIELDS and not isinstance(change, (Step, Staircase)):
            raise TegotaeError(
                f"the change of {name} is {reprlib.repr(change)}; {_NO_FIELDS[name]}, and a change "
                "of it is a Step or a Staircase"
            )
        usual = None if name in _NO_FIELDS else number_of(body, name)
        for entry, value in _entries(change).items():
            _check_numbers(name, entry, value, tick_s)
            _check_shape(name, entry, value, usual)
        if isinstance(change, Step) and not np.all(
            np.less(change.from_s, change.until_s) | np.isinf(change.from_s)  # inf: never
        ):
            raise TegotaeError(
                f"the change of {name} ends at {change.until_s} s and begins at {change.from_s} s; "
                "let it begin first"
            )
    fields = {name: change for name, change in changes.items() if name not in _NO_FIELDS}
    if fields:
        _check_bodies(body, fields, tick_s, duration_s)


def fastest(scenario: Scenario, duration_s: float) -> float:
    """The largest frequency that a lane meets, either way [rad/s]."""
    omega = np.asarray(scenario.omega, float)
    omegas = [omega]
    change = dict(scenario.changes).get(OMEGA) if scenario.changes else None
    if isinstance(change, Step):
        omegas.append(np.asarray(change.value, float))
    if isinstance(change, Staircase):
        omegas.append(omega + np.asarray(change.step, float) * _levels(change, duration_s))
    return max(float(np.max(np.abs(x), initial=0.0)) for x in omegas)


def _levels(stairs: Staircase, duration_s: float) -> np.ndarray:
    """How many steps a staircase takes within a run."""
    reached = np.floor(duration_s / np.asarray(stairs.dwell_s, float))
    return np.minimum(reached, np.asarray(stairs.levels, float) - 1.0)


def _entries(change: LaneNumbers) -> dict[str, LaneNumbers]:
    return change._asdict() if isinstance(change, (Step, Staircase)) else {"value": change}


def _check_bodies(
    body: Body, fields: Mapping[str, LaneNumbers], tick_s: float, duration_s: float
) -> None:
    """Make every body that is met: for every lane, whenever something changes."""
    columns = {
        (name, entry): np.atleast_1d(np.asarray(value, float))
        for name, change in fields.items()
        for entry, value in _entries(change).items()
    }
    lanes = max(x.shape[-1] for x in columns.values())
    if any(x.shape[-1] not in (1, lanes) for x in columns.values()):
        shapes = ", ".join(str(x.shape) for x in columns.values())
        raise TegotaeError(
            f"changes have shapes {shapes}; each must be a number or have one entry per lane"
        )
    rows = [np.broadcast_to(x, (*x.shape[:-1], lanes)).reshape(-1, lanes) for x in columns.values()]
    made: set[tuple[FieldNumber, ...]] = set()
    for lane in np.unique(np.concatenate(rows), axis=1).T:
        parts = np.split(lane, np.cumsum([len(row) for row in rows])[:-1])
        own = {
            key: part if len(part) > 1 else part[0]
            for key, part in zip(columns, parts, strict=True)
        }
        times = {0.0}
        for (name, entry), value in own.items():
            if entry in ("from_s", "until_s"):
                times.add(float(value))
            if entry == "dwell_s":
                stairs = Staircase(0.0, value, own[name, "levels"])
                times.add(float(value * _levels(stairs, duration_s)))
        for time in sorted(t for t in times if 0.0 <= t <= duration_s):
            applied = {
                name: _value_at(body, name, change, own, time) for name, change in fields.items()
            }
            if (key := tuple(applied.values())) not in made:
                made.add(key)
                with_fields(body, applied).check_tick(tick_s)


def _value_at(
    body: Body,
    name: str,
    change: LaneNumbers,
    own: Mapping[tuple[str, str], LaneNumbers],
    time: float,
) -> FieldNumber:
    """What a field is at a time: a number, or a tuple of the legs' numbers."""
    usual = np.asarray(number_of(body, name), float)
    value = own.get((name, "value"), usual)
    if isinstance(change, Step) and not own[name, "from_s"] <= time < own[name, "until_s"]:
        value = usual
    if isinstance(change, Staircase):
        steps = min(np.floor(time / own[name, "dwell_s"] + 1e-6), own[name, "levels"] - 1.0)
        value = usual + steps * own[name, "step"]
    value = np.broadcast_to(value, np.broadcast_shapes(np.shape(value), usual.shape))
    return tuple(map(float, value)) if value.ndim else float(value)


def _check_numbers(name: str, entry: str, value: LaneNumbers, tick_s: float) -> None:
    what = f"the change of {name}" + ("" if entry == "value" else f", {entry},")
    for number in np.ravel(np.asarray(value, object)):
        if entry in ("until_s", "levels", "from_s") and number == float("inf"):
            continue
        least = {"dwell_s": tick_s, "levels": 1.0}.get(entry)
        require_finite(what, number, least=least)


def _check_shape(name: str, entry: str, value: LaneNumbers, usual: FieldNumber | None) -> None:
    shape = np.shape(np.asarray(value, float))
    if isinstance(usual, tuple) and entry in ("value", "step"):
        if shape and (len(shape) != 2 or shape[0] != len(usual)):
            raise TegotaeError(
                f"the change of {name} has shape {shape}; it belongs to the legs: write a row for "
                f"each of them, [{len(usual)}, lanes], such as {[[x] for x in usual]}"
            )
    elif len(shape) > 1 and not (name == OMEGA and entry in ("value", "step")):
        raise TegotaeError(
            f"the change of {name} has {entry} of shape {shape}; it must be a number or [lanes]"
        )


def _require_names(what: str, given: object, example: str) -> None:
    if not isinstance(given, Mapping) and given != ():
        raise TegotaeError(
            f"{what} is {reprlib.repr(given)}; it must be numbers by name, such as {example}"
        )
