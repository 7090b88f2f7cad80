"""All runs of one set under all disturbances at once: lanes of one compiled program."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeAlias

import jax
import numpy as np

from tegotae._support.errors import TegotaeError
from tegotae.analysis.generalisation.controllers_under_test import ControllersUnderTest
from tegotae.analysis.generalisation.disturbance import Disturbance, usual_change
from tegotae.analysis.generalisation.retention import criterion_of
from tegotae.parts.fields import with_fields
from tegotae.simulation.episode import LaneInputs
from tegotae.simulation.rollout import Scenario, check_senses
from tegotae.simulation.timing import filled
from tegotae.simulation.world import ENTRIES, GROUND, OMEGA, Staircase, Step, with_changes

if TYPE_CHECKING:  # which needs Gymnasium and MuJoCo
    from tegotae.analysis.generalisation.on_environment import ModelUnderTest

Tested: TypeAlias = "ControllersUnderTest | ModelUnderTest"
"""Controllers on the body of their training: one of this package, or a MuJoCo model."""
_COLUMNS = {
    **{"condition": str, "level": float, "run": int, "start": int},
    **{"had": bool, "moved": bool, "moves": bool, "keeps": bool},
    **{"efficiency": float, "speed": float},
}
LANES = 512
"""Lanes that are measured together; the last ones are filled up."""


@dataclass(frozen=True)
class Retention:
    """What came of it: a row for each disturbance, level, run and release.

    Args:
        columns: `condition`, `level`, `run` and `start`; `moved`, whether it hopped or walked
            without the disturbance, and `moves`, whether it still does; `had`, whether it had a
            gait, and `keeps`, whether it has the same; and what of `efficiency` and `speed` it
            keeps, as shares, NaN where that is not defined.
        left_out: why a disturbance was not tried, by its name.
    """

    columns: dict[str, np.ndarray]
    left_out: dict[str, str]


def tried(tested: Tested, disturbances: Sequence[Disturbance]) -> Retention:
    """Test controllers under every disturbance that applies to them, at every level.

    Every run is first tried as it is. What it does then says when a disturbance comes, and what
    there is to be kept.

    Raises:
        TegotaeError: if a level makes no body, or too quick an oscillator.
    """
    left_out = {each.name: why for each in disturbances if (why := tested.lacks(each))}
    meets = [each for each in disturbances if each.name not in left_out]
    if not meets:
        return Retention({name: np.zeros(0, kind) for name, kind in _COLUMNS.items()}, left_out)
    check_levels(tested, meets)
    if not isinstance(tested, ControllersUnderTest):
        return Retention(tested.tried(meets), left_out)
    check_senses(tested.controller, tested.body)
    tested = _meeting(tested, meets)
    trial = _Trial(tested, meets)
    nothing = [(meets[0], np.array([meets[0].neutral]))]
    usual = trial.measured(nothing, np.full((1, trial.size), np.inf))
    at_s = np.atleast_2d(trial.criterion.at_s(usual))
    plan = [(each, np.array([*each.side(True), *each.side(False)])) for each in meets]
    found = trial.measured(plan, at_s)
    kept = trial.criterion.kept(usual, found, trial.weight_ratio(plan, at_s))
    rows = [(each.name, level) for each, levels in plan for level in levels]
    whole = {
        "condition": np.repeat([name for name, _ in rows], trial.size),
        "level": np.repeat([level for _, level in rows], trial.size),
        "run": np.tile(np.repeat(np.arange(len(tested.weights)), tested.starts), len(rows)),
        "start": np.tile(np.arange(tested.starts), len(rows) * len(tested.weights)),
    }
    return Retention(whole | {name: np.ravel(x) for name, x in kept.items()}, left_out)


def _meeting(
    tested: ControllersUnderTest, disturbances: Sequence[Disturbance]
) -> ControllersUnderTest:
    return tested.meeting(max(each.longest_delay_s for each in disturbances))


def check_levels(tested: Tested, disturbances: Sequence[Disturbance]) -> None:
    """Raise `TegotaeError` if a level of a disturbance makes no body, or one, or an oscillator,
    that is too quick for the control tick."""
    if not isinstance(tested, ControllersUnderTest):
        for each in disturbances:
            for level in each.levels:
                tested.check_level(each, level)
        return
    tested = _meeting(tested, disturbances)
    for each in disturbances:
        for level in each.levels:
            changes = each.changes(tested, np.array([level]), np.zeros(1))
            fields = {
                name: _number(change, tested.usual(name))
                for name, change in changes.items()
                if name not in (GROUND, *ENTRIES)
            }
            try:
                with_fields(tested.prepared, fields).check_tick(tested.timing.tick_s)
                if OMEGA in changes and tested.controller.oscillator is not None:
                    omega = float(np.max(changes[OMEGA]))
                    tested.controller.oscillator.check_tick(omega, tested.timing.tick_s)
            except TegotaeError as error:
                raise TegotaeError(f"{each.name}={level:g} on {tested.name}: {error}") from None


def _number(change: Any, usual: Any) -> Any:
    value = np.asarray(change.value if isinstance(change, Step) else change, float)
    if isinstance(usual, tuple):
        return tuple(map(float, np.broadcast_to(value[..., 0], len(usual))))
    return float(np.ravel(value)[0])


class _Trial:
    """The lanes of a set: run by run, release by release."""

    def __init__(self, tested: ControllersUnderTest, disturbances: Sequence[Disturbance]) -> None:
        self.tested, self.disturbances = tested, disturbances
        self.criterion = criterion_of(tested)
        self.size = len(tested.weights) * tested.starts
        self.engine = tested.system.engine(self.criterion.summary, tested.timing)

    def measured(self, plan: Sequence[tuple[Disturbance, np.ndarray]], at_s: np.ndarray) -> Any:
        """What the criterion measures at every level, arrays [..., levels, lanes of the set].

        Args:
            plan: disturbances, and the levels of each.
            at_s: when what happens at a time happens [s], [1, lanes of the set].
        """
        levels = sum(len(each) for _, each in plan)
        count = levels * self.size
        scenario = self._scenario(plan, at_s)
        weights = np.repeat(self.tested.weights, self.tested.starts, axis=0).T
        weights = np.tile(np.asarray(weights, "float32"), levels)
        parts = []
        for begin in range(0, count, LANES):
            here = slice(begin, begin + LANES)
            own = LaneInputs(
                weights[..., here], jax.tree.map(lambda x, at=here: x[..., at], scenario)
            )
            recorded = self.engine.run_lanes(own, self.tested.prepared)
            whole = filled((recorded, own.scenario), slice(None), LANES)
            found = self.criterion.of(*whole)
            parts.append(jax.tree.map(np.asarray, found))
        joined = jax.tree.map(lambda *each: np.concatenate(each, axis=-1)[..., :count], *parts)
        return jax.tree.map(lambda x: x.reshape(*x.shape[:-1], levels, self.size), joined)

    def _scenario(
        self, plan: Sequence[tuple[Disturbance, np.ndarray]], at_s: np.ndarray
    ) -> Scenario:
        """What the lanes meet, level by level; all that some disturbance changes is in it."""
        tested = self.tested
        whole = [self._changes(each, levels, at_s) for each, levels in plan]
        counts = [len(levels) * self.size for _, levels in plan]

        def joined(name: str, usual: Any) -> Any:
            """Of one name: what each disturbance gives, or what is usual."""
            given = [changes.get(name) for changes in whole]
            parts = [
                _lanes(usual if x is None else x, n) for x, n in zip(given, counts, strict=True)
            ]
            return jax.tree.map(_concatenated, *parts)

        phases = np.tile(tested.phase_rad, len(tested.weights))
        release = tested.system.scenario(phase_rad=phases)
        usual = jax.tree.map(lambda x: _lanes(x, sum(counts)), release)
        changes = {name: joined(name, x) for name, x in self._neutral(release).items()}
        return with_changes(usual, tested.prepared, changes)

    def _neutral(self, release: Scenario) -> dict[str, Any]:
        """Of every name that some disturbance changes: the change that changes nothing."""
        found = {}
        for each in self.disturbances:
            level = np.array([each.neutral])
            for name, change in each.changes(self.tested, level, np.full(1, np.inf)).items():
                if name in ENTRIES:
                    usual = getattr(release, name)
                else:
                    usual = None if name == GROUND else self.tested.usual(name)
                found[name] = _without(change, usual)
        return found

    def _changes(self, each: Disturbance, levels: np.ndarray, at_s: np.ndarray) -> dict[str, Any]:
        at = np.broadcast_to(at_s, (len(levels), self.size)).ravel()
        return each.changes(self.tested, np.repeat(levels, self.size), at)

    def weight_ratio(
        self, plan: Sequence[tuple[Disturbance, np.ndarray]], at_s: np.ndarray
    ) -> np.ndarray:
        """Weight of the body over the usual one, [levels, lanes of the set]."""
        parts = []
        for each, levels in plan:
            changes = self._changes(each, levels, at_s)
            ratio = np.ones(len(levels) * self.size)
            for name in ("mass_kg", "gravity_m_per_s2"):
                if name in changes:
                    ratio = ratio * changes[name] / self.tested.usual(name)
            parts.append(ratio)
        return np.concatenate(parts).reshape(-1, self.size)


def _without(change: Any, usual: Any) -> Any:
    """The same kind of change that changes nothing."""
    if isinstance(change, (Step, Staircase)):
        return usual_change(change, _column(usual))
    return _column(usual)


def _column(usual: Any) -> Any:
    return np.asarray(usual, float)[:, None] if isinstance(usual, tuple) else usual


def _lanes(x: Any, count: int) -> Any:
    """An entry of a scenario with a value for each of so many lanes."""

    def each(value: Any) -> np.ndarray:
        value = np.asarray(value, "float32")
        value = value[None] if value.ndim == 0 else value
        if value.shape[-1] not in (1, count):  # releases, which repeat level by level
            value = np.tile(value, count // value.shape[-1])
        return np.broadcast_to(value, (*value.shape[:-1], count))

    return jax.tree.map(each, x)


def _concatenated(*parts: np.ndarray) -> np.ndarray:
    rows = np.broadcast_shapes(*(part.shape[:-1] for part in parts))
    return np.concatenate([np.broadcast_to(x, (*rows, x.shape[-1])) for x in parts], axis=-1)
