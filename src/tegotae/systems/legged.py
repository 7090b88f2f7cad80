"""Systems with several legs, those of the package by name."""

from __future__ import annotations

import dataclasses
import math
import tomllib
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

import jax
import msgspec
import numpy as np

from tegotae._support import documents
from tegotae._support.documents import Json
from tegotae._support.errors import TegotaeError, require_count, require_finite, unknown
from tegotae.measures.gaits.names import leg_names, reference_leg
from tegotae.measures.gaits.summary import CoordinationSummary
from tegotae.parts._shapes import AnyArray, ArrayTree, LaneNumbers
from tegotae.parts.bodies import Bar, Body, Interface, Plate, Sensors, Walker
from tegotae.parts.fields import unwrapped
from tegotae.parts.terms.foot import EllipticFoot
from tegotae.parts.terrains import Terrain
from tegotae.simulation.rollout import Rollout, Scenario, Summary, Timing
from tegotae.systems.descriptions import restore
from tegotae.systems.models import build
from tegotae.systems.registry import kinds_of
from tegotae.systems.system import WALKING, WALKING_TICK, OnSystem, System, usual_system
from tegotae.systems.user_objects import is_reference, load_object

S = TypeVar("S", bound=CoordinationSummary)
T = TypeVar("T")


@dataclass(frozen=True, kw_only=True)
class Legged(OnSystem):
    """A system on several legs with its weights, as the functions of gaits take it.

    Args:
        about: its meaning, in a line.
        system: body, controller and release; its timing is long enough to settle.
        weights: of the controller; (σ,) of a vanilla one.
        legs: the legs' names, in the body's order; those of their places if None.
        reference: the number of the leg that lags are measured from; -1 takes the left hind leg,
            or the first one where there is none.

    Raises:
        TegotaeError: for a body of one leg, or weights or names of the wrong number.

    Example:
        >>> import dataclasses
        >>> from tegotae import System
        >>> from tegotae.systems.models import build
        >>> from tegotae.parts.bodies import Bar
        >>> legs = dataclasses.replace(build("V-sector-w8"), limbs=2)
        >>> under_bar = System(controller=legs, body=Bar(), omega=8.0)
        >>> Legged(about="a bar", system=under_bar, weights=(1.0,)).names
        ('H', 'F')
    """

    about: str
    system: System
    weights: tuple[float, ...]
    legs: tuple[str, ...] | None = None
    reference: int = -1

    def __post_init__(self) -> None:
        require_legs(self.body)
        weights = tuple(float(weight) for weight in np.ravel(self.weights))
        object.__setattr__(self, "weights", weights)
        if len(weights) != self.controller.n_weights:
            raise TegotaeError(
                f"{len(weights)} weights are given; this controller has {self.controller.n_weights}"
            )
        if len(self.names) != self.body.limbs or len(set(self.names)) != self.body.limbs:
            raise TegotaeError(f"legs is {self.legs}; give each of {self.body.limbs} legs a name")
        if self.reference == -1:
            object.__setattr__(self, "reference", reference_leg(self.names))
        require_count("reference", self.reference, least=0, most=self.body.limbs - 1)

    @property
    def names(self) -> tuple[str, ...]:
        """The legs' names, in the body's order."""
        return leg_names(self.body) if self.legs is None else self.legs

    @property
    def dimensionless(self) -> bool:
        """True if length, mass and gravity are 1, so that "m" is l0 and "s" is √(l0 / g)."""
        body = unwrapped(self.body)
        return isinstance(body, Walker) and (
            body.rest_length_m == body.gravity_m_per_s2 == body.mass_kg == 1.0
        )

    @property
    def units(self) -> tuple[str, str]:
        """Units of length and time as text."""
        return ("l0", "√(l0/g)") if self.dimensionless else ("m", "s")

    def with_numbers(self, omega: float | None = None, sigma: float | None = None) -> Legged:
        """The same at another frequency ω or gain σ; None leaves it as it is.

        Raises:
            TegotaeError: for a gain of a controller that has more weights than that, or a frequency
                of one without an oscillator.
        """
        changed = self
        if omega is not None:
            if self.omega is None:
                raise TegotaeError("the controller has no oscillator, and so no omega")
            changed = changed.replaced(omega=omega)
        if sigma is not None:
            require_finite("sigma", sigma)
            if len(self.weights) != 1:
                raise TegotaeError(
                    f"sigma is the one weight of a vanilla controller; this one has "
                    f"{len(self.weights)} weights"
                )
            changed = dataclasses.replace(changed, weights=(sigma,))
        return changed

    def with_body(self, body: Body) -> Legged:
        """The same with another body, released as high over where its legs touch the ground.

        Raises:
            TegotaeError: for a body that does not go with the rest, or cannot hop from there.

        Example:
            >>> from tegotae.systems.resolve import legged_system as system
            >>> found = system("quadruped-c")
            >>> higher = found.with_body(dataclasses.replace(found.body, com_z_m=-0.3))
            >>> higher.system.release.height_m > found.system.release.height_m
            True
        """
        return dataclasses.replace(self, system=self.system.on(body))

    def scenario(self, phase_rad: LaneNumbers, **entries: LaneNumbers) -> Scenario:
        """A release.

        Args:
            phase_rad: phases of the oscillators [rad], a number, [lanes] or [limbs, lanes].
            more: other entries of the scenario.
        """
        return self.system.scenario(phase_rad=phase_rad, **entries)

    def summary(self, kind: type[S] = CoordinationSummary, **settings: Any) -> S:
        """The summary of how its legs are coordinated; `more` are arguments of its kind."""
        return kind.on(self.controller, self.body, **{"reference": self.reference, **settings})

    def rollout(self, summary: Summary, timing: Timing | None = None) -> Rollout:
        """Return the engine that advances the system, by its own timing by default."""
        return self.system.rollout(summary, timing)

    def run(self, summary: Summary, scenario: Scenario, timing: Timing | None = None) -> ArrayTree:
        """Roll out every lane of a scenario; what the summary makes of them, lanes last.

        Raises:
            TegotaeError: for what the engine refuses.
        """
        return self.rollout(summary, timing).run(self.weights, scenario, self.body)


def require_legs(body: Body | Interface) -> None:
    """Raise `TegotaeError` for a body of one leg, which has no gait."""
    if body.limbs < 2:
        raise TegotaeError(
            f"a gait command on a one-legged body: a {type(body).__name__} has one leg; "
            "name a body of two legs at least"
        )


def random_phases(limbs: int, starts: int, seed: int = 0) -> np.ndarray:
    """Phases drawn evenly from the circle, each leg's by itself [rad], [limbs, starts].

    Drawn start by start: more starts begin with the same ones.

    Args:
        limbs: how many legs.
        starts: how many releases.
        seed: of the draw.

    Example:
        >>> random_phases(2, 3).shape
        (2, 3)
        >>> bool((random_phases(2, 3) == random_phases(2, 5)[:, :3]).all())
        True
    """
    require_count("limbs", limbs)
    require_count("starts", starts)
    require_count("seed", seed, least=0)
    return np.random.default_rng(seed).uniform(0.0, 2.0 * np.pi, (starts, limbs)).T


def lanes_of(result: T) -> T:
    """A summary's arrays in double precision, of NumPy."""

    def lanes(x: AnyArray) -> np.ndarray:
        array = np.asarray(x)
        return np.asarray(array, float) if array.dtype.kind == "f" else array

    return jax.tree.map(lanes, result)


HOPPING_S = 60.0
"""Time in which legs that hop under a bar or a plate settle [s]."""
LIGHT, HEAVY = 0.6, 1.6
"""Inertia ratios on either side of 1, where the legs do not feel each other."""


def hopping(description: str, body: Body) -> Legged:
    """The paper's legs under a bar or a plate; sector, ω 8, σ 1.

    Lags are measured from the (left) hind leg.

    Args:
        description: the system in one line.
        body: a bar or a plate.
    """
    controller = dataclasses.replace(build("V-sector-w8"), limbs=body.limbs)
    system = System(
        controller=controller, body=body, omega=8.0, timing=Timing(duration_s=HOPPING_S)
    )
    return Legged(about=description, system=system, weights=(1.0,))


def bar(inertia_ratio: float) -> Legged:
    """Two of the paper's legs under a bar."""
    description = f"two hopper legs under a bar, j = {inertia_ratio:g}"
    return hopping(description, Bar(inertia_ratio=inertia_ratio))


def plate(pitch: float, roll: float, twist: float | None = None) -> Legged:
    """Four of them under a plate with these inertia ratios, and a limp spine if it twists.

    Args:
        pitch: inertia ratio j_p.
        roll: inertia ratio j_r.
        twist: inertia ratio j_t; None for a rigid spine.
    """
    twisting = "" if twist is None else f", j_t = {twist:g}"
    return hopping(
        f"four hopper legs under a plate, j_p = {pitch:g}, j_r = {roll:g}{twisting}",
        Plate(pitch_inertia_ratio=pitch, roll_inertia_ratio=roll, twist_inertia_ratio=twist),
    )


def walking(
    description: str,
    body: Body,
    foot: EllipticFoot,
    sigma: float,
    omega: float,
    tick: float = WALKING_TICK,
) -> Legged:
    """A torso on legs whose feet go round ellipses; each leg's oscillator feels its own load.

    Dimensionless: l0 = m = g = 1. It begins on its feet, at rest; lags are measured from the left
    hind leg, or the first one where there is none.

    Args:
        description: the system in one line.
        body: the torso and where its legs are, a `Walker`, perhaps in wrappers.
        foot: the ellipse.
        sigma: gain σ [rad/(s N)].
        omega: frequency ω [rad/s].
        tick: control tick [√(l0 / g)].
    """
    controller = dataclasses.replace(build("V-sector-w8"), actuation=foot, limbs=body.limbs)
    system = usual_system(controller, body, omega, tick)
    return Legged(about=description, system=system, weights=(sigma,))


class _WalkerDocument(msgspec.Struct, forbid_unknown_fields=True):
    about: str
    sigma: float
    omega: float
    foot: dict[str, Json]
    body: dict[str, Json] = {}
    senses: dict[str, Json] | None = None
    ticks: float = 1.0


def walker_of(document: object) -> Legged:
    """The walker of plain values, such as an entry of `walkers.toml`.

    Args:
        document: `about`, `sigma`, `omega`, and the fields of its `foot` and its `body`; `senses`
            those of `Sensors`, if they are late or noisy; `ticks` is its control tick over that of
            others.

    Raises:
        TegotaeError: for an entry that is missing, unknown or out of its range.

    Example:
        >>> walker_of({"about": "mine", "sigma": 1.0, "omega": 2.0, "foot": {}}).names
        ('LF', 'RF', 'LH', 'RH')
    """
    fields = documents.fitted(document, _WalkerDocument)
    require_finite("sigma", fields.sigma)
    body: dict[str, Json] = {**fields.body, "kind": "Walker"}
    if fields.senses is not None:
        body = {"body": body, **fields.senses, "kind": "Sensors"}
    return walking(
        fields.about,
        restore(body, Body, "body"),
        restore({**fields.foot, "kind": "EllipticFoot"}, EllipticFoot, "foot"),
        fields.sigma,
        fields.omega,
        WALKING_TICK * fields.ticks,
    )


def is_walker_file(name: str) -> bool:
    """Return whether a name is that of a walker's own file, TOML."""
    return name.endswith(".toml")


def _of_file(path: Path) -> Legged:
    try:
        return walker_of(documents.read(path))
    except FileNotFoundError:
        raise TegotaeError(f"there is no file {path}") from None
    except TegotaeError as error:
        raise TegotaeError(f"{path} is no walker: {error}") from None


_WALKERS = tomllib.loads(Path(__file__).with_name("walkers.toml").read_text(encoding="utf-8"))


SYSTEMS: dict[str, Callable[[], Legged]] = {
    "bar-light": lambda: bar(LIGHT),
    "bar-heavy": lambda: bar(HEAVY),
    "plate-light-pitch": lambda: plate(LIGHT, HEAVY),
    "plate-light-roll": lambda: plate(HEAVY, LIGHT),
    "plate-light-both": lambda: plate(LIGHT, LIGHT),
    "plate-heavy": lambda: plate(HEAVY, HEAVY),
    "plate-light-twist": lambda: plate(HEAVY, HEAVY, LIGHT),
    **{name: partial(walker_of, entry) for name, entry in _WALKERS.items()},
}
"""Factories of the named systems."""


def system(name: str) -> Legged:
    """A legged system, as designs are made upon; `tegotae.systems.resolve` takes all other names.

    Args:
        name: of `SYSTEMS`; `FILE.toml`, a walker as in `walkers.toml`; or `FILE.py:OBJECT` or
            `MODULE:OBJECT`, a `Legged`.

    Raises:
        TegotaeError: for an unknown name, a damaged file, an object of another kind, or a body of
            one leg.

    Example:
        >>> system("bar-light").body.inertia_ratio, system("quadruped-c").names
        (0.6, ('LF', 'RF', 'LH', 'RH'))
    """
    if name in SYSTEMS:
        return SYSTEMS[name]()
    if is_walker_file(name):
        return _of_file(Path(name))
    if is_reference(name):
        return load_object(name, Legged, "legged system")
    error = unknown("legged system", name, SYSTEMS)
    raise TegotaeError(f"{error} FILE.py:OBJECT names one of your own")


def settling(system: System, weights: LaneNumbers, description: str = "") -> Legged:
    """A system with its weights, timed so that it settles whatever its release.

    Gaits lock in some 20 to 60 √(l0 / g), which is more than an episode of training.

    Args:
        system: the system.
        weights: shape [n_weights].
        description: the system in one line; the kind of its body by default.

    Raises:
        TegotaeError: for a body of one leg, or weights of the wrong number.
    """
    timing = dataclasses.replace(system.timing, duration_s=settling_s(system.mechanics))
    return Legged(
        about=description or type(system.body).__name__,
        system=dataclasses.replace(system, timing=timing),
        weights=tuple(map(float, weights)),
    )


def settling_s(body: Body) -> float:
    """Time in which the legs of a body settle into a gait, whatever the release [s]."""
    base = unwrapped(body)
    if not isinstance(base, Walker):
        return HOPPING_S
    return WALKING * math.sqrt(base.rest_length_m / base.gravity_m_per_s2)


_MOST_LATE = 1000
"""The longest delay of the senses [control ticks]: all of it is kept."""


def terrain_of(words: Sequence[str]) -> Terrain:
    """The ground that some words name: its kind, and numbers of it.

    Raises:
        TegotaeError: for a kind or a number that there is not.

    Example:
        >>> terrain_of(["slope", "along=0.1"])
        Slope(along=0.1, across=0.0)
    """
    kind, numbers = words[0], assignments("--terrain", words[1:])
    if is_reference(kind):
        terrain = load_object(kind, Terrain, "terrain")
    else:
        terrains = {
            name.lower(): terrain_class for name, terrain_class in kinds_of(Terrain).items()
        }
        if kind.lower() not in terrains:
            raise unknown("terrain", kind, terrains)
        terrain = terrains[kind.lower()]()  # pyright: ignore[reportAbstractUsage] - no abstract one is known
    names = [field.name for field in dataclasses.fields(terrain)]  # type: ignore[arg-type]
    for name in numbers:
        if name not in names:
            raise unknown(f"number of the terrain {kind}", name, names)
    return dataclasses.replace(terrain, **numbers)  # type: ignore[type-var]


def felt(legged: Legged, delay_s: float, noise: float) -> Body:
    """The body of a system, felt late and with noise.

    Args:
        legged: the system.
        delay_s: of its senses [s].
        noise: of its senses, relative to their scales.

    Raises:
        TegotaeError: for a delay or noise below zero, or a delay of too many ticks.
    """
    require_finite("delay", delay_s, least=0.0)
    require_finite("noise", noise, least=0.0)
    ticks = max(1, math.ceil(delay_s / legged.timing.tick_s - 1e-6))
    if ticks > _MOST_LATE:
        raise TegotaeError(
            f"delay is {delay_s:g}, which is {ticks} control ticks; it must be at most "
            f"{_MOST_LATE * legged.timing.tick_s:g}"
        )
    return Sensors(body=legged.body, delay_s=delay_s, noise=noise, most_ticks=ticks)


def assignments(option: str, texts: Iterable[str]) -> dict[str, float]:
    """Names and numbers, each name once.

    Args:
        option: that the texts are of, for errors.
        texts: NAME=NUMBER each.
    """
    values: dict[str, float] = {}
    for text in texts:
        name, _, value = text.partition("=")
        try:
            number = float(value)
        except ValueError:
            raise TegotaeError(f"{option} {text} sets nothing; write NAME=NUMBER") from None
        if name in values:
            raise TegotaeError(f"{option} names {name} twice; give it one value")
        values[name] = number
    return values
