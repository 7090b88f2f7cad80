"""Conditions that vary between episodes: what is drawn, and what can be."""

from __future__ import annotations

import itertools
import reprlib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import cast

import numpy as np

from tegotae._support.errors import TegotaeError, unknown
from tegotae.parts._shapes import LaneNumbers
from tegotae.parts.bodies import Body
from tegotae.parts.fields import (
    FieldNumber,
    number_of,
    paths_of,
    replace,
)
from tegotae.parts.oscillators import Oscillator
from tegotae.simulation.schedules import Schedule, SecondClock, Step, is_scheduled, schedule_of
from tegotae.simulation.timing import Timing
from tegotae.simulation.world import (
    DROP,
    ENTRIES,
    GROUND,
    OMEGA,
    Condition,
    Scenario,
    with_changes,
)

_NO_FIELDS = {
    OMEGA: "a frequency that holds for the whole run is the scenario's omega",
    GROUND: "ground that is lower from the release on is a release from higher up",
}
"""Changes that are none of the body, and what is said of one that is no change."""


_EXAMPLES = {
    "initial_pose": '{"pitch_rad": 0.1}',
    "oscillator_state": '{"radius": 0.5}',
    "changes": '{"mass_kg": [0.1, 0.12]}',
}
"""Numbers by name of a scenario, such as these."""


def check_scenario(
    scenario: Scenario, body: Body, oscillator: Oscillator | None, timing: Timing
) -> None:
    """Raise `TegotaeError` for fields that body or oscillator lack, or changes to an impossible
    body.

    Every body that some lane meets is made once, so that the body itself says what it refuses.

    Args:
        scenario: of all lanes.
        body: that the lanes have.
        oscillator: of the controller; None without.
        timing: duration and control period.
    """
    for entry, example in _EXAMPLES.items():
        value: object = getattr(scenario, entry)
        if not isinstance(value, Mapping) and value != ():
            raise TegotaeError(
                f"{entry} is {reprlib.repr(value)}; it must be numbers by name, such as {example}"
            )
    states = () if oscillator is None else oscillator.STATE
    starts = ((body, "initial_pose", body.pose_names), (oscillator, "oscillator_state", states))
    for part, entry, takes in starts:
        for name in dict(getattr(scenario, entry)):
            if name not in takes:
                raise TegotaeError(
                    f"{type(part).__name__} has no {entry} {name!r}; it takes "
                    f"{', '.join(takes) or 'none'}"
                )
    _check_changes(body, scenario, timing)
    fastest = _fastest(scenario, timing.duration_s)
    if oscillator is not None and np.isfinite(fastest):
        oscillator.check_tick(fastest, timing.tick_s)


def _check_changes(body: Body, scenario: Scenario, timing: Timing) -> None:
    changes = dict(scenario.changes)
    for name, change in changes.items():
        if name in _NO_FIELDS and not is_scheduled(change):
            raise TegotaeError(
                f"the change of {name} is {reprlib.repr(change)}; {_NO_FIELDS[name]}, and a change "
                "of it is a schedule, such as a Step"
            )
        nominal = None if name in _NO_FIELDS else number_of(body, name)
        for schedule in schedule_of(change).parts:
            schedule.check(name, timing.tick_s)
            _check_shapes(name, schedule, nominal)
    fields = {name: change for name, change in changes.items() if name not in _NO_FIELDS}
    if fields:
        _check_bodies(body, fields, timing)


def _fastest(scenario: Scenario, duration_s: float) -> float:
    """Return the largest frequency that a lane meets, of either sign [rad/s]."""
    omega = np.asarray(scenario.omega, float)
    changes = dict(scenario.changes)
    met = [omega]
    if OMEGA in changes:
        schedule = schedule_of(changes[OMEGA]).mapped(_row)
        times = _corners([schedule], duration_s)
        met += [schedule.at(SecondClock(time), omega) for time in times]
    return max(float(np.max(np.abs(x), initial=0.0)) for x in met)


def _corners(schedules: Iterable[Schedule], duration_s: float) -> list[np.ndarray]:
    """Return the release and the corners of schedules [s]; those beyond the run as the release."""
    times = [np.zeros(1)]
    for schedule in schedules:
        times += map(np.asarray, schedule.corners(duration_s))
    return [np.where((time >= 0.0) & (time <= duration_s), time, 0.0) for time in times]


def _check_bodies(body: Body, fields: Mapping[str, LaneNumbers], timing: Timing) -> None:
    """Make every body that is met: for every lane, whenever something changes."""
    rows = {name: schedule_of(change).mapped(_row) for name, change in fields.items()}
    parts = [part for schedule in rows.values() for part in schedule.parts]
    shapes = [x.shape for part in parts for x in part.entries.values()]
    lanes = max(shape[-1] for shape in shapes)
    if any(shape[-1] not in (1, lanes) for shape in shapes):
        raise TegotaeError(
            f"changes have shapes {', '.join(map(str, shapes))}; each must be a number or have one "
            "entry per lane"
        )
    numbers = {name: number_of(body, name) for name in rows}
    nominal = {
        name: _row(x)[:, None] if isinstance(x, tuple) else _row(x) for name, x in numbers.items()
    }
    bodies: set[tuple[FieldNumber, ...]] = set()
    for time in _corners(rows.values(), timing.duration_s):
        met = {
            name: np.broadcast_to(
                schedule.at(SecondClock(time), nominal[name]), (*nominal[name].shape[:-1], lanes)
            )
            for name, schedule in rows.items()
        }
        for lane in range(lanes):
            of_lane = {name: _field(x[..., lane]) for name, x in met.items()}
            if (key := tuple(of_lane.values())) not in bodies:
                bodies.add(key)
                replace(body, of_lane).check_tick(timing.tick_s)


def _row(values: LaneNumbers) -> np.ndarray:
    return np.atleast_1d(np.asarray(values, float))


def _field(value: np.ndarray) -> FieldNumber:
    """Return a number, or a tuple of the legs' numbers."""
    return tuple(value.tolist()) if value.ndim else float(value)


def _check_shapes(name: str, schedule: Schedule, nominal: FieldNumber | None) -> None:
    for entry, value in schedule.entries.items():
        shape, is_value = np.shape(np.asarray(value, float)), entry in schedule.VALUES
        if isinstance(nominal, tuple) and is_value:
            if shape and (len(shape) != 2 or shape[0] != len(nominal)):
                raise TegotaeError(
                    f"the change of {name} has shape {shape}; it belongs to the legs: write a row "
                    f"for each of them, [{len(nominal)}, lanes], such as {[[x] for x in nominal]}"
                )
        elif len(shape) > 1 and not (name == OMEGA and is_value):
            raise TegotaeError(
                f"the change of {name} has {entry} of shape {shape}; it must be a number or [lanes]"
            )


MOST_CORNERS = 4096
"""Combinations of extremes that are tried: those of twelve conditions of two each."""


def draw(
    conditions: Sequence[Condition], body: Body, count: int, key: Sequence[int]
) -> dict[str, np.ndarray]:
    """Return so many draws of every condition by name, [count] or [limbs, count].

    Drawn by Latin hypercube: of `count` equal shares of a condition each is met once, the
    conditions independent of each other. A mean over few draws then spreads less than over as many
    independent ones.

    Args:
        conditions: what is drawn.
        body: which decides what belongs to its limbs.
        count: how many draws.
        key: whole numbers from 0 on; the same give the same draws.

    Source: M. D. McKay, R. J. Beckman, W. J. Conover, Technometrics 21 (1979) 239-245.

    Example:
        >>> from tegotae.parts.bodies import Hopper
        >>> from tegotae.simulation.world import Uniform
        >>> drawn = draw([Uniform("mass_kg", low=0.0, high=4.0)], Hopper(), 4, (0, 1))
        >>> sorted(drawn["mass_kg"].astype(int).tolist())
        [0, 1, 2, 3]
    """
    random = np.random.default_rng(list(key))
    values: dict[str, np.ndarray] = {}
    for condition in conditions:
        # What has its values limb by limb already is drawn as a whole.
        per_body = np.ndim(condition.extremes[0]) > 0 or not _is_per_limb(condition.name, body)
        rows = 1 if per_body else body.limbs
        slot = random.permuted(np.tile(np.arange(count), (rows, 1)), axis=1)
        share = (slot + random.random((rows, count))) / count
        values[condition.name] = condition.quantile(share[0] if per_body else share)
    return values


def applied(
    conditions: Sequence[Condition],
    values: Mapping[str, LaneNumbers],
    scenario: Scenario,
    body: Body,
) -> Scenario:
    """Return the scenario in which each condition has these values.

    Args:
        conditions: in what it differs.
        values: numbers, [lanes] or [limbs, lanes] by the names of the conditions.
        scenario: as it is otherwise.
        body: which decides what is an initial pose of its release.
    """
    changes: dict[str, LaneNumbers] = {}
    for condition in conditions:
        value, until_s = values[condition.name], condition.until_s
        changes[condition.name] = (
            value
            if condition.lasts
            else Step(value, condition.from_s, np.inf if until_s is None else until_s)
        )
    return with_changes(scenario, body, changes) if changes else scenario


def check_conditions(
    conditions: Sequence[Condition],
    scenario: Scenario,
    body: Body,
    oscillator: Oscillator | None,
    timing: Timing,
) -> None:
    """Raise `TegotaeError` for an unknown condition, or extremes that make no body.

    Every combination of the extremes is made once, so that the body itself says what it refuses.

    Args:
        conditions: how episodes differ.
        scenario: the world otherwise.
        body: the body.
        oscillator: whose state may be drawn; None without.
        timing: length of an episode, and control period.
    """
    names = [condition.name for condition in conditions]
    for condition in conditions:
        _check_name(condition, names, body, oscillator)
    if conditions:
        check_scenario(_extremes(conditions, scenario, body), body, oscillator, timing)


def check_releases(conditions: Sequence[Condition], scenario: Scenario, body: Body) -> None:
    """Raise `TegotaeError` if under some combination of the extremes the body can never hop.

    Args:
        conditions: how episodes differ.
        scenario: the world otherwise.
        body: the body.
    """
    lasting = [condition for condition in conditions if condition.lasts]
    for values in _combinations(lasting):
        fields = {n: x for n, x in values.items() if n not in ENTRIES and n not in body.pose_names}
        height = values.get("height_m", scenario.height_m)
        try:
            replace(body, fields).check_release(float(height))
        except TegotaeError as error:
            values_named = " and ".join(
                f"{name} {value:g}" for name, value in values.items() if not np.ndim(value)
            )
            raise TegotaeError(f"with {values_named or 'these conditions'}, {error}") from None


def _check_name(
    condition: Condition, names: list[str], body: Body, oscillator: Oscillator | None
) -> None:
    name = condition.name
    if names.count(name) > 1:
        raise TegotaeError(f"{name} is varied {names.count(name)} times; give it one condition")
    own_each = name == "phase_rad" or not (name in ENTRIES or name in body.pose_names)
    if np.ndim(condition.extremes[0]) > 0 and not own_each:
        raise TegotaeError(
            f"{name} is one number for all limbs; write its values without commas between them"
        )
    if own_each and name != "phase_rad":
        head = name.partition(".")[0]
        known_names = [*paths_of(body), "body", *body.pose_names, *ENTRIES]
        if head not in known_names:
            raise unknown(f"condition of a {type(body).__name__}", name, known_names)
    if name == DROP and (condition.from_s > 0.0) == ("drop_time_s" in names):
        raise TegotaeError(
            "the ground drops once, at one time: give drop_m the time from which on it lies "
            "lower, such as from_s=12, or vary drop_time_s"
        )
    if name == OMEGA:
        if oscillator is None:
            raise TegotaeError("omega is varied, and the controller has no oscillator to follow it")
        lowest = min(cast(tuple[float, ...], condition.extremes))
        if lowest <= 0.0:
            raise TegotaeError(f"omega is varied from {lowest:g} on; it must be greater than 0")


def _is_per_limb(name: str, body: Body) -> bool:
    """Return whether each limb has a value of its own."""
    if name in ENTRIES or name in body.pose_names:
        return name == "phase_rad" and body.limbs > 1
    return isinstance(number_of(body, name), tuple)


def _combinations(conditions: Sequence[Condition]) -> list[dict[str, LaneNumbers]]:
    """Return every combination of the extremes, by name."""
    names = [condition.name for condition in conditions]
    extremes = [condition.extremes for condition in conditions]
    if (count := int(np.prod([len(values) for values in extremes], dtype=float))) > MOST_CORNERS:
        raise TegotaeError(
            f"{len(names)} conditions have {count} combinations of extremes; {MOST_CORNERS} are "
            "the most that are checked: vary fewer at once"
        )
    return [dict(zip(names, values, strict=True)) for values in itertools.product(*extremes)]


def _extremes(conditions: Sequence[Condition], scenario: Scenario, body: Body) -> Scenario:
    """Return a scenario with a lane for every combination of the extremes."""
    rows = _combinations(conditions)
    values: dict[str, np.ndarray] = {}
    for condition in conditions:
        column = np.array([row[condition.name] for row in rows], float)
        if column.ndim == 1 and _is_per_limb(condition.name, body):
            column = np.repeat(column[:, None], body.limbs, axis=1)
        values[condition.name] = column.T
    return applied(conditions, values, scenario, body)


LEAST_EVALUATION_SET = 4
"""Episodes of the evaluation set at least: what is best under one draw may be so by luck."""
_EVALUATION_SET = (0,)
_GENERATIONS = 1  # keys of draws begin with it, the evaluation set's with another number


@dataclass(frozen=True)
class Randomization:
    """Common and varied conditions of the episodes of a training.

    Args:
        conditions: in what they differ; of none, every episode is the scenario itself.
        body: what is driven.
        scenario: numbers, or arrays of shape [limbs, 1].
    """

    conditions: tuple[Condition, ...]
    body: Body
    scenario: Scenario

    def repeats(self, episodes: int) -> int:
        """Return the episodes per candidate of the evaluation set, so that all are at least
        `LEAST_EVALUATION_SET`."""
        return -(-LEAST_EVALUATION_SET // episodes) if self.conditions else 1

    def evaluation_set(self, candidates: int, episodes: int) -> Scenario:
        """Return the same episodes for every candidate, in order: [candidates x episodes]."""
        drawn = draw(self.conditions, self.body, episodes, _EVALUATION_SET)
        values = {name: np.tile(x, candidates) for name, x in drawn.items()}
        return applied(self.conditions, values, self.scenario, self.body)

    def generation(
        self, seeds: Sequence[int], number: int, population: int, episodes: int, centre: int
    ) -> Scenario:
        """Return the episodes of a generation: seed by seed, candidate by candidate, the centre
        last.

        Args:
            seeds: of the runs; what one meets does not depend on which others there are.
            number: of the generation, from 0 on.
            population: candidates a seed beside the centre.
            episodes: of each candidate.
            centre: episodes of the centre, those of the evaluation set.

        Returns:
            The scenario, with one entry for each episode, [seeds x (population x episodes +
            centre)], in what is varied.
        """
        always = draw(self.conditions, self.body, centre, _EVALUATION_SET)
        parts: dict[str, list[np.ndarray]] = {name: [] for name in always}
        for seed in seeds:
            drawn = draw(self.conditions, self.body, episodes, (_GENERATIONS, seed, number))
            for name, values in drawn.items():
                parts[name] += [np.tile(values, population), always[name]]
        values = {name: np.concatenate(arrays, axis=-1) for name, arrays in parts.items()}
        return applied(self.conditions, values, self.scenario, self.body)
