"""Conditions outside of the training: blows, other bodies, other ground, worse signals."""

from __future__ import annotations

import dataclasses
from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple, Self

import jax
import numpy as np

from tegotae._support.documents import JsonObject
from tegotae._support.errors import TegotaeError, require_finite, require_known
from tegotae._support.tables import parse_number
from tegotae.measures.gaits.summary import has_mass, total_mass_kg
from tegotae.parts._shapes import LaneNumbers
from tegotae.parts.controller import Controller
from tegotae.parts.fields import paths_of, value_of
from tegotae.simulation.schedules import (
    Chain,
    Constant,
    Ramp,
    Staircase,
    Step,
    is_scheduled,
    schedule_of,
)
from tegotae.simulation.world import GROUND, OMEGA
from tegotae.systems.controller_file import ControllerSet

MOST_LEVEL = 1e6
"""The largest level of any disturbance: single precision can count with it."""


class LackingError(Exception):
    """Error for a body without the field that a disturbance changes; the text names it."""


@dataclass(frozen=True)
class Disturbance(ABC):
    """One condition at several levels: a frozen dataclass of its numbers.

    Args:
        name: what commands and tables call it.
        label: what figures call it.
        levels: those that are tried, below and above the neutral one, in any order.
        unit: of its levels; empty for a ratio.
        neutral: the level at which there is none of it.
        measure: what of a gait is to be kept: "keeps", that it is the same; or "moves", that the
            body still hops or walks, where the same gait cannot be.

    Raises:
        TegotaeError: for no level, one that is no number or beyond sense, twice the same, or the
            neutral one.
    """

    RANGE: ClassVar[Mapping[str, float]] = {"least": -MOST_LEVEL}
    """The lowest possible level (`require_finite`)."""

    name: str
    label: str
    levels: tuple[float, ...]
    unit: str = ""
    neutral: float = 0.0
    measure: str = "keeps"

    def __post_init__(self) -> None:
        for level in self.levels:
            require_finite(f"a level of {self.name}", level, most=MOST_LEVEL, **self.RANGE)
        if not self.levels or len(set(self.levels)) < len(self.levels):
            raise TegotaeError(
                f"the levels of {self.name} are {self.levels}; give at least one, each once"
            )
        if self.neutral in self.levels:
            raise TegotaeError(f"{self.neutral:g} is no {self.name} at all; it is always tested")

    @property
    def longest_delay_s(self) -> float:
        """Maximum sensor delay, for a leg of a metre on Earth [s]."""
        return 0.0

    def side(self, below: bool) -> list[float]:
        """Return the levels on one side of the neutral one, from there outwards."""
        levels = sorted(level for level in self.levels if (level < self.neutral) == below)
        return levels[::-1] if below else levels

    @property
    def outwards(self) -> list[float]:
        """All levels, side by side."""
        return [*self.side(True), *self.side(False)]

    @abstractmethod
    def changes(
        self, tested: Tested, level: np.ndarray, at_s: np.ndarray
    ) -> dict[str, LaneNumbers]:
        """Return the changes for lanes of these levels, by name (`with_changes`).

        Arrays [lanes] or [limbs, lanes], or schedules of them; names are those of the body's
        fields, and of the scenario's entries.

        Args:
            tested: the controllers that meet it.
            level: of each lane, [lanes]; releases are the innermost (`release_of`).
            at_s: when what happens at a time happens in it [s], [lanes].

        Raises:
            LackingError: if it does not apply to these controllers.
        """


@dataclass(frozen=True)
class Tested(ABC):
    """A set of unchanged controllers and the place of their test: bodies of this package
    (`ControllersUnderTest`), or another simulator (`EnvironmentUnderTest`).

    Args:
        controllers: the runs of one training, and the system that they share.
        starts: from how many releases each is tried.
    """

    CHANGED: ClassVar[frozenset[str] | None] = None
    """Names of what can be changed; None for all that the body has."""
    SCHEDULED: ClassVar[frozenset[str] | None] = None
    """Names of what can change during a run; None for all that can be changed."""
    SLOPE: ClassVar[str] = "terrain.second.first.along"
    """Name of the slope of the ground."""

    controllers: ControllerSet
    starts: int = 1

    @classmethod
    def from_runs(cls, runs: ControllerSet, starts: int = 4) -> Self:
        """Return the runs of a set, without duplicates, ready for a test.

        Args:
            runs: the runs.
            starts: where releases differ.
        """
        _, first = np.unique(runs.weights, axis=0, return_index=True)
        indices = np.sort(first)
        labels = tuple(runs.labels[i] for i in indices)
        tested = cls(dataclasses.replace(runs, weights=runs.weights[indices], labels=labels))
        return dataclasses.replace(tested, starts=starts) if tested.starts_differ else tested

    @property
    def name(self) -> str:
        """Name of the set."""
        return self.controllers.name

    @property
    def weights(self) -> np.ndarray:
        """Weights of the runs, [runs, n_weights]."""
        return self.controllers.weights

    @property
    def controller(self) -> Controller:
        """The structure that the runs share."""
        return self.controllers.controller

    @property
    def size(self) -> int:
        """Number of lanes of a level: runs, each from every start."""
        return len(self.weights) * self.starts

    @property
    @abstractmethod
    def document(self) -> JsonObject:
        """Return the settings that decide the results, beside the disturbances, as JSON values."""

    @property
    @abstractmethod
    def starts_differ(self) -> bool:
        """True if releases differ, so that several are informative."""

    @property
    def omega(self) -> float | None:
        """The frequency of the test [rad/s]; None without an oscillator."""
        return self.controllers.omega

    @property
    @abstractmethod
    def body(self) -> Any:
        """Body of the controllers: it has `rest_length_m`, `touching_height_m` and `limbs`."""

    @property
    def unwrapped(self) -> Any:
        """The body inside all wrappers."""
        return self.body

    @property
    def kind(self) -> str:
        """Name of the body's kind."""
        return type(self.unwrapped).__name__

    @property
    def takes_forces(self) -> bool:
        """True if its actuators take forces, and not positions of feet."""
        return True

    @property
    def mass_kg(self) -> float:
        """Mass of the body [kg].

        Raises:
            LackingError: if it does not say what it weighs.
        """
        if not has_mass(self.unwrapped):
            raise LackingError(f"a {self.kind} has no mass_kg")
        return float(total_mass_kg(self.unwrapped))

    @property
    @abstractmethod
    def height_m(self) -> float:
        """Height of the release [m]."""

    @property
    @abstractmethod
    def time_scale(self) -> float:
        """√(l0 / g) of the body over that of a leg of a metre on Earth: 1 for the hopper."""

    @property
    def speed_scale(self) -> float:
        """√(g l0) of the body over that of a leg of a metre on Earth: 1 for the hopper."""
        return float(self.unwrapped.rest_length_m) / self.time_scale

    @property
    def prepared(self) -> Any:
        """The body with all around it that disturbances change."""
        return self.body

    def has_field(self, name: str) -> bool:
        """Return whether the prepared body has a field of this name."""
        return name in paths_of(self.prepared)

    def nominal(self, name: str) -> LaneNumbers:
        """Return a field of the prepared body as it is: a number, or a tuple of the legs' numbers.

        Raises:
            LackingError: if there is none of this name.
        """
        if not self.has_field(name.partition(".")[0]):
            raise LackingError(f"a {self.kind} has no {name}")
        return value_of(self.prepared, name)  # type: ignore[return-value]

    def lacks(self, disturbance: Disturbance) -> str:
        """Return the reason why a disturbance does not apply; empty if it does."""
        try:
            changes = disturbance.changes(self, np.array([disturbance.neutral]), np.zeros(1))
        except LackingError as lacking:
            return str(lacking)
        scheduled = {name for name, change in changes.items() if is_scheduled(change)}
        for names, possible, how in (
            (set(changes), self.CHANGED, "be changed"),
            (scheduled, self.SCHEDULED, "change during a run"),
        ):
            if possible is not None and (beyond := sorted(names - possible)):
                return f"{', '.join(beyond)} cannot {how} on a {self.kind}"
        return ""

    def usual(self, name: str) -> LaneNumbers:
        """Return the number that a change replaces, of shape [limbs, 1] where limbs have it."""
        if name == GROUND:
            return 0.0
        if name == OMEGA:
            return self.omega or 0.0
        nominal = self.nominal(name)
        return np.asarray(nominal, float)[:, None] if isinstance(nominal, tuple) else nominal

    def undisturbed(self, disturbances: Sequence[Disturbance]) -> Encounter:
        """Return the lanes of one level at which nothing is changed."""
        first = disturbances[0]
        neutral = np.full(self.size, first.neutral), np.full(self.size, np.inf)
        return Encounter(first.changes(self, *neutral), self.size)

    def disturbed(self, disturbances: Sequence[Disturbance], at_s: np.ndarray) -> list[Encounter]:
        """Return the lanes of every disturbance, level by level.

        Args:
            disturbances: what they meet.
            at_s: when what happens at a time happens [s], [lanes of a level].
        """
        encounters = []
        for disturbance in disturbances:
            levels = np.array(disturbance.outwards)
            of_lanes = np.repeat(levels, self.size), np.tile(at_s, len(levels))
            encounters.append(
                Encounter(disturbance.changes(self, *of_lanes), len(levels) * self.size)
            )
        return encounters

    def weight_ratio(self, encounters: Sequence[Encounter]) -> np.ndarray:
        """Return the weight of the body over the usual one, [lanes]."""
        parts = []
        for changes, lanes in encounters:
            ratio = np.ones(lanes)
            for name in ("mass_kg", "gravity_m_per_s2"):
                if name in changes:
                    ratio = ratio * changes[name] / self.nominal(name)
            parts.append(ratio)
        return np.concatenate(parts)

    @abstractmethod
    def check(self, disturbances: Sequence[Disturbance]) -> None:
        """Raise `TegotaeError` if a level of a disturbance makes no body, or one, or an oscillator,
        that is too quick for the control tick."""

    @abstractmethod
    def shares_kept(self, disturbances: Sequence[Disturbance]) -> dict[str, np.ndarray]:
        """Measure the retained gait at every level of disturbances that apply (`Retention`),
        [levels, lanes].

        Levels are those of one disturbance after the other (`Disturbance.outwards`).
        """


class Encounter(NamedTuple):
    """Lanes that meet one disturbance."""

    changes: Mapping[str, LaneNumbers]
    """Their changes by name (`Disturbance.changes`)."""
    lanes: int
    """Number of lanes."""


def joined(
    tested: Tested,
    disturbances: Sequence[Disturbance],
    encounters: Sequence[Encounter],
    dtype: str = "float64",
) -> dict[str, LaneNumbers]:
    """Join the changes of lanes one after the other, by name.

    A name that one disturbance changes is as usual in the lanes of the others.

    Args:
        tested: the controllers.
        disturbances: all that may be met.
        encounters: the lanes.
        dtype: of the numbers.
    """
    neutral: dict[str, dict[type, LaneNumbers]] = {}
    for disturbance in disturbances:
        level = np.array([disturbance.neutral])
        for name, change in disturbance.changes(tested, level, np.full(1, np.inf)).items():
            usual = tested.usual(name)
            unchanged = change.neutral(usual) if is_scheduled(change) else usual
            neutral.setdefault(name, {})[_kind_of(change)] = unchanged
    together: dict[str, LaneNumbers] = {}
    for name, kinds in neutral.items():
        chain = []
        for kind in sorted(kinds, key=lambda kind: kind is not Constant):  # constants first
            changes = [x.changes.get(name, kinds[kind]) for x in encounters]
            of_kind = [x if _kind_of(x) is kind else kinds[kind] for x in changes]
            lanes = [of_lanes(x, y.lanes, dtype) for x, y in zip(of_kind, encounters, strict=True)]
            chain.append(jax.tree.map(_concatenated, *lanes))
        together[name] = chain[0] if len(chain) == 1 else Chain(tuple(map(schedule_of, chain)))
    return together


def _kind_of(change: LaneNumbers) -> type:
    """Return the class of a schedule; numbers are a `Constant`."""
    return type(schedule_of(change))


def of_lanes(numbers: Any, lanes: int, dtype: str = "float32") -> Any:
    """Repeat the numbers of a pytree so that there is one for each lane.

    Args:
        numbers: numbers, or arrays whose last axis is of lanes.
        lanes: how many.
        dtype: of the arrays.
    """

    def per_lane(value: Any) -> np.ndarray:
        value = np.atleast_1d(np.asarray(value, dtype))
        if value.shape[-1] not in (1, lanes):  # releases, which repeat level by level
            value = np.tile(value, lanes // value.shape[-1])
        return np.broadcast_to(value, (*value.shape[:-1], lanes))

    return jax.tree.map(per_lane, numbers)


def _concatenated(*parts: np.ndarray) -> np.ndarray:
    rows = np.broadcast_shapes(*(part.shape[:-1] for part in parts))
    return np.concatenate([np.broadcast_to(x, (*rows, x.shape[-1])) for x in parts], axis=-1)


def release_of(tested: Tested, level: np.ndarray) -> np.ndarray:
    """Return the index of every lane's release within its run, from 0 on, [lanes].

    What is drawn follows from it alone: what a run meets does not depend on which others there are.
    """
    return np.arange(len(level)) % tested.starts


@dataclass(frozen=True, kw_only=True)
class Blow(Disturbance):
    """A vertical blow that changes the velocity by the level, at an apex of what hops.

    In m/s of a leg of a metre on Earth, else times √(g l0).
    """

    def changes(self, tested, level, at_s):
        return {"impulse_ns": level * tested.speed_scale * tested.mass_kg, "at_s": at_s}


@dataclass(frozen=True, kw_only=True)
class ForcePulse(Disturbance):
    """A force on the centre of mass for a short time, that alone changes its velocity by the level.

    In m/s of a leg of a metre on Earth, else times √(g l0).
    """

    field: str
    """The body's field of the force [N]."""
    lasts_s: float = 0.1
    """Duration [s], for a leg of a metre on Earth."""

    def changes(self, tested, level, at_s):
        _ = tested.nominal(self.field)
        lasts = self.lasts_s * tested.time_scale
        force = level * tested.speed_scale * tested.mass_kg / lasts
        return {self.field: Step(force, at_s, at_s + lasts)}


@dataclass(frozen=True, kw_only=True)
class Wind(Disturbance):
    """A force on the centre of mass that rises to the level, a share of the weight, and stays."""

    field: str
    """The body's field of the force [N]."""
    rises_s: float = 5.0
    """Duration of the rise [s], for a leg of a metre on Earth."""

    def changes(self, tested, level, at_s):
        _ = tested.nominal(self.field)
        force = level * tested.mass_kg * tested.nominal("gravity_m_per_s2")
        return {self.field: Ramp(force, at_s, at_s + self.rises_s * tested.time_scale)}


@dataclass(frozen=True, kw_only=True)
class LostLeg(Disturbance):
    """Loss of a number of legs at once, which differ from release to release.

    A gait of fewer legs is another one: what counts is that it walks on.

    Raises:
        TegotaeError: for a level that is no number of legs.
    """

    measure: str = "moves"

    def __post_init__(self) -> None:
        super().__post_init__()
        for level in self.levels:
            if level < 1.0 or not float(level).is_integer():
                raise TegotaeError(
                    f"{self.name}={level:g} is no number of legs; write whole ones, such as 1/2"
                )

    def changes(self, tested, level, at_s):
        limbs = tested.body.limbs
        if not tested.has_field("present"):
            raise LackingError(f"a {tested.kind} cannot lose a leg")
        if max(self.levels) >= limbs:
            raise LackingError(f"it has {limbs} legs")
        first = release_of(tested, level) % limbs
        order = (np.arange(limbs)[:, None] - first[None]) % limbs
        present = np.asarray(tested.nominal("present"), float)[:, None] * (order >= level[None])
        return {"present": Step(present, at_s, np.inf)}


@dataclass(frozen=True, kw_only=True)
class Frequency(Disturbance):
    """Another frequency ω: that of the training times the level.

    Raises:
        TegotaeError: for a level that is not positive.
    """

    RANGE: ClassVar = {"above": 0.0}

    neutral: float = 1.0

    def changes(self, tested, level, at_s):
        if tested.omega is None:
            raise LackingError("it has no oscillator")
        return {"omega": tested.omega * level}


@dataclass(frozen=True, kw_only=True)
class Scaled(Disturbance):
    """Numbers of the body multiplied by the level, from the release on.

    A leg of another length is released as high over where it touches the ground.
    """

    fields: tuple[str, ...]
    """Names of which the body has at least one; all that it has are scaled."""
    neutral: float = 1.0

    def changes(self, tested, level, at_s):
        nominal = {name: np.asarray(tested.nominal(name), float) for name in self.fields
               if tested.has_field(name)}  # fmt: skip
        if not nominal:
            raise LackingError(f"a {tested.kind} has no {' or '.join(self.fields)}")
        if not any(map(np.any, nominal.values())):
            raise LackingError(f"its {self.fields[0]} is 0, and so is any share of it")
        # Of several legs [limbs, 1], times levels [lanes].
        changes = {name: (x[:, None] if x.ndim else x) * level for name, x in nominal.items()}
        if "rest_length_m" in self.fields:
            longer = (level - 1.0) * float(tested.body.rest_length_m)
            changes["height_m"] = tested.height_m + longer
        return changes


@dataclass(frozen=True, kw_only=True)
class ReleaseHeight(Disturbance):
    """A release from another height over where the leg touches the ground, in leg lengths; none is
    below zero, in the ground."""

    RANGE: ClassVar = {"least": 0.0}

    def changes(self, tested, level, at_s):
        if not tested.takes_forces:
            raise LackingError("it is released on its feet")
        over = level * float(tested.body.rest_length_m)
        return {"height_m": float(tested.body.touching_height_m) + over}


@dataclass(frozen=True, kw_only=True)
class Ground(Disturbance):
    """The ground rises or falls once, by the level in leg lengths: at an apex, of what hops."""

    def changes(self, tested, level, at_s):
        return {"drop_m": Step(-level * float(tested.body.rest_length_m), at_s)}


@dataclass(frozen=True, kw_only=True)
class Stairs(Disturbance):
    """The ground falls again and again by the level, in leg lengths."""

    dwell_s: float = 5.0
    """Duration of a level [s], for a leg of a metre on Earth."""
    times: int = 4
    """Number of drops."""

    def changes(self, tested, level, at_s):
        down = -level * float(tested.body.rest_length_m)
        stairs = Staircase(down, self.dwell_s * tested.time_scale, float(self.times + 1))
        return {"ground_m": stairs}


@dataclass(frozen=True, kw_only=True)
class Incline(Disturbance):
    """Ground that rises forward by the level per length, or falls, from the release on."""

    def changes(self, tested, level, at_s):
        _require_ground(tested, tested.SLOPE)
        return {tested.SLOPE: level}


@dataclass(frozen=True, kw_only=True)
class Roughness(Disturbance):
    """Rough ground of this root mean square, in leg lengths; every release is elsewhere on it.

    Its typical wavelength is a leg's length, and it begins within one from the release.
    """

    def changes(self, tested, level, at_s):
        _require_ground(tested, "terrain")
        length = float(tested.body.rest_length_m)
        fields = {"rms_m": level * length, "wavelength_m": np.full(len(level), length)}
        fields["place"] = 1.0 + release_of(tested, level)
        return {f"terrain.second.second.{field}": value for field, value in fields.items()}


def _require_ground(tested: Tested, field: str) -> None:
    if not tested.has_field(field.partition(".")[0]):
        raise LackingError(f"a {tested.kind} stays in its place, on level ground")


@dataclass(frozen=True, kw_only=True)
class Strength(Disturbance):
    """Actuators that deliver this share of the force."""

    neutral: float = 1.0

    def changes(self, tested, level, at_s):
        if not tested.takes_forces:
            raise LackingError("its actuators take places, not forces")
        return {"strength": tested.nominal("strength") * level}


@dataclass(frozen=True, kw_only=True)
class Late(Disturbance):
    """Actuators that lag, or senses that are late, by the level more [s].

    As much later for a body whose √(l0 / g) is larger.
    """

    field: str

    @property
    def longest_delay_s(self) -> float:
        """See `Disturbance.longest_delay_s`."""
        return max(self.levels) if self.field == "delay_s" else 0.0

    def changes(self, tested, level, at_s):
        return {self.field: tested.nominal(self.field) + level * tested.time_scale}


@dataclass(frozen=True, kw_only=True)
class Noise(Disturbance):
    """White noise on the senses, one value per control tick, as a share of their scale.

    Every release meets another one.

    Under noise no hop is as the last: what counts is that there are hops.
    """

    measure: str = "moves"

    def changes(self, tested, level, at_s):
        drawn = 1.0 + release_of(tested, level)
        return {"noise": tested.nominal("noise") + level, "seed": drawn}


_BELOW = (0.85, 0.7, 0.5)
_ABOVE = (1.2, 1.5, 2.0, 3.0)
_RATIOS = (*_BELOW, *_ABOVE)
_STIFFNESS = ("stiffness_n_per_m", "stiffness_z_n_per_m")
_DAMPING = ("damping_ns_per_m", "damping_z_ns_per_m")
_SPEEDS = (0.3, 0.6, 1.0, 1.5)
_BLOWS = (-0.5, -1.0, -2.0, -3.0, 0.5, 1.0, 2.0, 3.0)
_WINDS = (-0.05, -0.1, -0.2, -0.4, 0.05, 0.1, 0.2, 0.4)
_STEPS = (-0.1, -0.25, -0.5, -1.0, 0.1, 0.2, 0.3)

CATALOGUE: dict[str, Disturbance] = {
    preset.name: preset
    for preset in (
        Frequency("omega", "frequency ω / ω_t", _RATIOS),
        Scaled("mass", "mass", _RATIOS, fields=("mass_kg",)),
        Scaled("stiffness", "stiffness", _RATIOS, fields=_STIFFNESS),
        Scaled("damping", "damping", (0.5, 0.0, 1.5, 2.5, 4.0), fields=_DAMPING),
        Scaled("gravity", "gravity", _RATIOS, fields=("gravity_m_per_s2",)),
        Scaled("leg-length", "leg length", (0.8, 0.5, 1.4, 2.0), fields=("rest_length_m",)),
        Scaled("friction", "friction", (0.75, 0.5, 0.25, 0.1), fields=("friction",)),
        ReleaseHeight("release", "release over touchdown", (0.05, 0.02, 0.5, 1.0, 1.5), "l0", 0.2),
        Ground("step", "step of the ground", _STEPS, "l0"),
        Stairs("drops", "four drops in a row", (0.05, 0.1, 0.2, 0.4), "l0"),
        Blow("blow", "vertical blow", _BLOWS, "m/s"),
        ForcePulse(
            "push-ahead", "push ahead", (*(-x for x in _SPEEDS), *_SPEEDS), "m/s", field="push_x_n"
        ),
        ForcePulse("push-aside", "push aside", _SPEEDS, "m/s", field="push_y_n"),
        Wind("wind-ahead", "wind from behind / weight", _WINDS, field="push_x_n"),
        Wind("wind-up", "upward wind / weight", _WINDS, field="push_z_n"),
        Incline("slope", "slope of the ground", (-0.2, -0.1, -0.05, 0.05, 0.1, 0.2)),
        Roughness("rough", "roughness of the ground", (0.01, 0.02, 0.05, 0.1), "l0"),
        LostLeg("lost-leg", "lost legs", (1.0, 2.0), "legs"),
        Strength("strength", "strength of the actuator", (0.8, 0.6, 0.45, 0.3)),
        Late("lag", "lag of the actuator", (0.005, 0.015, 0.04, 0.1), "s", field="lag_s"),
        Late("delay", "delay of the senses", (0.004, 0.008, 0.016, 0.032), "s", field="delay_s"),
        Noise("noise", "noise of the senses", (0.05, 0.1, 0.2, 0.4, 0.8)),
    )
}
"""All by name."""


def disturbances_named(texts: Iterable[str]) -> tuple[Disturbance, ...]:
    """Return disturbances by name, each with other levels if the text has some: "delay=0.01/0.02".

    Args:
        texts: names; all that there are, if there are none.

    Raises:
        TegotaeError: for an unknown name, one that is given twice, or levels that are none.

    Example:
        >>> [each.levels for each in disturbances_named(["lag=0.01/0.02", "drops"])]
        [(0.01, 0.02), (0.05, 0.1, 0.2, 0.4)]
    """
    selected: dict[str, Disturbance] = {}
    for text in texts:
        name, equals, levels = text.partition("=")
        require_known("condition", name, CATALOGUE)
        if name in selected:
            raise TegotaeError(f"{name} is named twice; name each condition once")
        selected[name] = CATALOGUE[name]
        if equals:
            try:
                numbers = tuple(parse_number(part) for part in levels.split("/"))
            except ValueError:
                raise TegotaeError(
                    f"{text} has no levels; write {name}=LEVEL/LEVEL, such as {name}="
                    f"{'/'.join(f'{x:g}' for x in CATALOGUE[name].levels[:2])}"
                ) from None
            selected[name] = dataclasses.replace(CATALOGUE[name], levels=numbers)
    return tuple(selected.values()) or tuple(CATALOGUE.values())
