"""Lesions: a leg lost, a load, a push, a drop of the ground; who stays up, and how lags move."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pandas as pd

from tegotae._support.errors import TegotaeError, require_count, require_finite, require_known
from tegotae._support.limits import MOST_M, MOST_SEEDS
from tegotae.analysis.gaits.releases import gait_counts
from tegotae.measures.gaits.lags import lag_difference, largest_drift, support_margin_m
from tegotae.measures.gaits.names import FALLEN, TOLERANCE, gait_of
from tegotae.measures.gaits.summary import (
    LEAST_FRAMES,
    Coordination,
    CoordinationSummary,
    coordination,
    coordination_columns,
)
from tegotae.measures.statistics import Interval, share_interval
from tegotae.parts._shapes import LaneNumbers
from tegotae.parts.bodies import Body, Walker
from tegotae.parts.fields import numbers_of, unwrapped
from tegotae.parts.parameters import Part, finite
from tegotae.simulation.recorder import Trajectory
from tegotae.simulation.rollout import Scenario, Timing
from tegotae.simulation.schedules import Step
from tegotae.simulation.world import apply_changes, with_changes
from tegotae.systems.legged import Legged, lanes_of, random_phases


@dataclass(frozen=True, kw_only=True)
class GaitLesion(Part):
    """A single perturbation of the body, permanent unless it has a duration.

    Args:
        at_s: when [s]; at the frame nearest to it.
        lost: the names of legs that are there no more.
        fields: numbers of the body that are otherwise from then on, pairs of name and number.
        drop_m: how far the ground drops [m].
        lasts_s: how long the fields are otherwise [s], as under a push; for good by default.

    Raises:
        TegotaeError: if nothing happens, or for a time or a drop that is no such number.

    Example:
        >>> GaitLesion(at_s=100.0, lost=("LH",)).label
        'LH lost'
    """

    at_s: float = finite(above=0.0)
    lost: tuple[str, ...] = ()
    fields: tuple[tuple[str, float], ...] = ()
    drop_m: float = finite(0.0, least=-MOST_M, most=MOST_M)
    lasts_s: float = math.inf

    def __post_init__(self) -> None:
        super().__post_init__()
        for name, value in self.fields:
            require_finite(name, value)
        if self.lasts_s != math.inf:
            require_finite("lasts_s", self.lasts_s, above=0.0)
            if not self.fields:
                raise TegotaeError(
                    "only numbers of the body pass: a lost leg or a drop is for good"
                )
        if not (self.lost or self.fields or self.drop_m):
            raise TegotaeError(
                "nothing happens: name a leg to lose, a number of the body that changes, or how "
                "far the ground drops"
            )

    @property
    def label(self) -> str:
        """Short description."""
        words = [f"{leg} lost" for leg in self.lost]
        passes = "" if self.lasts_s == math.inf else f" for {self.lasts_s:g} s"
        words += [f"{name} {value:g}{passes}" for name, value in self.fields]
        words += [f"ground {self.drop_m:g} lower"] if self.drop_m else []
        return ", ".join(words)

    def left(self, legged: Legged) -> tuple[int, ...]:
        """Return the numbers of the remaining legs.

        Raises:
            TegotaeError: for a leg that is not there, a body that cannot lose any, or fewer than
                two that are left.
        """
        names, body = legged.names, unwrapped(legged.body)
        shares: tuple[float, ...] | None = getattr(body, "present", None)
        present = [i for i, share in enumerate(shares or (1.0,) * body.limbs) if share > 0.5]
        for leg in self.lost:
            require_known("leg of this body", leg, names)
            if shares is None:
                raise TegotaeError(
                    f"a {type(body).__name__} cannot lose a leg: it does not say which are present"
                )
            if names.index(leg) not in present:
                raise TegotaeError(f"leg {leg} is lost already; name one that is there")
        remaining = tuple(i for i in present if names[i] not in self.lost)
        if len(remaining) < 2:
            raise TegotaeError(
                f"{len(remaining)} of {body.limbs} legs is left; a gait is how several legs go "
                "together"
            )
        return remaining

    def scenario(self, legged: Legged, phase_rad: LaneNumbers) -> Scenario:
        """Return the scenario of a release of the system with this lesion.

        Raises:
            TegotaeError: for legs or numbers that the body does not have.
        """
        body = unwrapped(legged.body)
        remaining, changes = self.left(legged), dict[str, LaneNumbers]()
        numbers = [name for name, x in numbers_of(body).items() if not isinstance(x, tuple)]
        for name, value in self.fields:
            require_known(f"number of a {type(body).__name__}", name, numbers)
            changes[name] = Step(value, from_s=self.at_s, until_s=self.at_s + self.lasts_s)
        if self.lost:
            present = np.isin(np.arange(legged.body.limbs), remaining).astype(float)
            changes["present"] = Step(present[:, None], from_s=self.at_s)
        if self.drop_m:
            changes["drop_m"] = Step(self.drop_m, from_s=self.at_s)
        return with_changes(legged.scenario(phase_rad), legged.body, changes)


@dataclass(frozen=True)
class Aftermath:
    """Gaits of random releases before and after a lesion."""

    legged: Legged
    """The released system."""
    lesion: GaitLesion
    """The lesion."""
    left: tuple[int, ...]
    """The legs that are left, by their numbers."""
    reference: int
    """The leg that lags are measured from, before and after."""
    frame: pd.DataFrame
    """A row a start: whether it `stood_before` and `stays_up`; its gait, and how far its lags have
    moved for good, the short way round; and the coordination just before, and in the end. Later
    times count from the lesion."""

    @property
    def stood(self) -> int:
        """Number of starts that stood before the lesion."""
        return int(self.frame.stood_before.sum())

    @property
    def share(self) -> Interval:
        """Share of the standing bodies that stay up, and its 95 % interval; NaN if none stood."""
        return share_interval(int(self.frame.stays_up.sum()), self.stood)

    @property
    def title(self) -> str:
        """The lesion, and the share that stays up, in a few words."""
        (_, time), share = self.legged.units, self.share
        return (
            f"{self.lesion.label} at {self.lesion.at_s:g} {time}: {self.frame.stays_up.sum()} of "
            f"{self.stood} that stood stay up, {share.mean:.3f} "
            f"({share.low:.3f} … {share.high:.3f})"
        )

    @property
    def summary(self) -> pd.DataFrame:
        """Number of starts of every pair of gaits before and after."""
        stood: Any = self.frame[self.frame["stood_before"]]
        pairs = gait_counts(stood["gait_before"] + " → " + stood["gait_after"])
        return pairs.rename_axis("before → after").to_frame("starts")

    @property
    def notes(self) -> list[str]:
        """The remaining support, the moved lags, and the times to fall and to lock again."""
        (length, time), margin, names = self.legged.units, self.margin_m, self.legged.names
        notes = [f"the mass is {margin:.3f} {length} inside the feet that are left"]
        notes = [] if math.isnan(margin) else notes
        stood: Any = self.frame[self.frame["stood_before"]]
        stays: Any = self.frame[self.frame["stays_up"]]
        for leg in self.left:
            change = stays[f"lag_change_cycles_{names[leg]}"].median()
            if leg != self.reference and not math.isnan(change):
                notes.append(f"lag of {names[leg]} moves by {change:+.3f} cycles (median)")
        for quantity, values in (
            ("falls after", stood["after_fall_time_s"]),
            ("locks again after", stays["after_lock_time_s"]),
        ):
            if values.count():
                notes.append(
                    f"{quantity} {values.median():.3g} {time} (median of {values.count()})"
                )
        return notes

    @property
    def margin_m(self) -> float:
        """Distance of the mass inside the polygon of the remaining legs' hips [m], after the
        lesion.

        NaN of other bodies than walkers, and of fewer than three legs.
        """
        body = unwrapped(self.legged.body)
        if not isinstance(body, Walker) or len(self.left) < 3:
            return math.nan
        present = tuple(float(leg in self.left) for leg in range(body.limbs))
        changes = {**dict(self.lesion.fields), "present": present}
        return support_margin_m(dataclasses.replace(body, **changes))


@dataclass(frozen=True, kw_only=True)
class _BeforeAndAfter(CoordinationSummary):
    """A `Rollout`'s summary: the coordination at the end of each of two parts of a recording.

    Args:
        cut: how many frames the first part has.
        window: how many frames of either part's end are measured.
        left: the legs of the second part.
    """

    cut: int
    window: int
    left: tuple[int, ...]

    def __call__(
        self, trajectory: Trajectory, scenario: Scenario, body: Body, timing: Timing
    ) -> tuple[Coordination, Coordination]:
        """Return the coordination of every lane, before and after."""

        def of_part(part: Trajectory, its_body: Body, reference: int) -> Coordination:
            begins = len(part.time_s) - self.window
            return coordination(self, part, its_body, timing.frame_s, begins, reference)

        first = jax.tree.map(lambda x: x[: self.cut], trajectory)
        second = jax.tree.map(lambda x: _select_legs(x[self.cut :], self.left), trajectory)
        begun = self.cut * timing.frame_s
        last = jnp.asarray(timing.n_frames * timing.ticks_per_frame - 1)
        changes = dict(scenario.changes)
        harmed, _ = apply_changes(body, scenario.omega, changes, last, timing.tick_s)
        reference = self.left.index(self.reference)
        gait_after = of_part(second, harmed, reference)
        # Legs that have never felt each other are no more locked after a lesion than before it.
        lags = _select_legs(self.rhythm.lag(trajectory, self.reference), self.left)
        gait_after = gait_after._replace(
            lock_time_s=gait_after.lock_time_s - begun,
            fall_time_s=gait_after.fall_time_s - begun,
            moved=jnp.where(jnp.isnan(gait_after.moved), jnp.nan, largest_drift(lags)),
        )
        return of_part(first, body, self.reference), gait_after


def aftermath(
    legged: Legged,
    lesion: GaitLesion,
    starts: int = 64,
    *,
    seed: int = 0,
    tolerance: float = TOLERANCE,
) -> Aftermath:
    """Release a body at random phases, apply a lesion, and measure which bodies stay up.

    Nothing before the lesion knows of it. Measured is the last quarter of either part.

    Args:
        legged: the body and what drives it.
        lesion: what happens.
        starts: how many releases.
        seed: of their phases.
        tolerance: how far lags may be from a named pattern's [cycles].

    Raises:
        TegotaeError: for a lesion that the body cannot have, or at a time outside the rollout.

    Example:
        >>> from tegotae.systems.resolve import legged_system as system
        >>> found = aftermath(system("bar-light"), GaitLesion(at_s=30.0, drop_m=0.05), starts=4)
        >>> found.share.mean, found.frame.gait_after.tolist()
        (1.0, ['antiphase', 'antiphase', 'antiphase', 'antiphase'])
    """
    require_count("starts", starts, most=MOST_SEEDS)
    timing = legged.timing
    cut = round(lesion.at_s / timing.frame_s)
    shorter = min(cut, timing.n_frames - cut)
    if shorter < LEAST_FRAMES:
        edge = LEAST_FRAMES * timing.frame_s
        raise TegotaeError(
            f"at_s is {lesion.at_s:g}; it must be from {edge:g} to {timing.duration_s - edge:g}, "
            "so that there is a before and an after"
        )
    lesion = dataclasses.replace(lesion, at_s=cut * timing.frame_s)
    remaining, legs = lesion.left(legged), legged.names
    reference = legged.reference if legged.reference in remaining else remaining[0]
    phase = random_phases(len(legs), starts, seed)
    summary = legged.summary(
        _BeforeAndAfter, reference=reference, cut=cut, window=shorter // 4, left=remaining
    )
    gait_before, gait_after = lanes_of(legged.run(summary, lesion.scenario(legged, phase)))
    left_legs = [legs[i] for i in remaining]
    stood = ~np.isfinite(gait_before.fall_time_s)
    change = np.asarray(lag_difference(gait_after.lag, gait_before.lag[list(remaining)]), float)
    columns = {
        "start": np.arange(starts),
        "stood_before": stood,
        "stays_up": stood & ~np.isfinite(gait_after.fall_time_s),
        "gait_before": gait_of(gait_before, legs, tolerance),
        "gait_after": np.where(stood, gait_of(gait_after, left_legs, tolerance), FALLEN),
        **{f"lag_change_cycles_{leg}": x for leg, x in zip(left_legs, change, strict=True)},
        **{f"before_{name}": x for name, x in coordination_columns(gait_before, legs).items()},
        **{f"after_{name}": x for name, x in coordination_columns(gait_after, left_legs).items()},
    }
    return Aftermath(legged, lesion, remaining, reference, pd.DataFrame(columns))


def _select_legs(x: jax.Array, legs: Sequence[int]) -> jax.Array:
    """Return the part of a recording [frames, (limbs,) lanes] that belongs to some legs."""
    return x[:, np.array(legs)] if x.ndim == 3 else x
