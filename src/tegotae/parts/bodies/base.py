"""The contract of a body, and a body that another simulator has."""

from __future__ import annotations

import inspect
import math
from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import ClassVar, NamedTuple, TypeVar, cast

import jax
import jax.numpy as jnp

from tegotae._support.errors import TegotaeError, require_finite
from tegotae.parts._shapes import (
    MaskPerLane,
    Number,
    PerCommand,
    PerLane,
    PerLimb,
    Scalar,
    StateTree,
)
from tegotae.parts.bodies.frame import LARGEST_TURN_RAD
from tegotae.parts.channels import FORCE, Channel
from tegotae.parts.parameters import STATIC, Part, not_negative, positive, traceable, whole

T = TypeVar("T")


class Sensation(NamedTuple):
    """Sensor readings of a body at one instant: every entry of shape [(limbs,) lanes]."""

    values: dict[str, PerLimb]
    """Sensed quantities by name, in SI units."""
    scales: Mapping[str, Number]
    """Divisors that make each quantity dimensionless for a network, in the same units."""

    @classmethod
    def from_pairs(cls, **quantities: tuple[PerLimb, Number]) -> Sensation:
        """Return the readings of quantities, each with its scale."""
        values = {name: value for name, (value, _) in quantities.items()}
        return cls(values, {name: scale for name, (_, scale) in quantities.items()})


class Push(NamedTuple):
    """The actuator force over one tick, linear in time: mean + rise · (share of the tick - ½).

    Both of shape [(limbs,) lanes]. On a body whose feet are commanded to places, `mean_n` is the
    place at the tick's end [m], [commands, limbs, lanes].
    """

    mean_n: PerCommand
    """Mean force [N]."""
    rise_n: Number = 0.0
    """Rise of the force from the tick's start to its end [N]."""


class Contact(NamedTuple):
    """The body's motion over one control tick.

    Of shape [(limbs,) lanes] for what each limb does (its stance, its work, its touchdown),
    [lanes] for what the body does.
    """

    stance_share: PerLimb
    """Share of the tick spent in stance, 0 ... 1."""
    work_j: PerLimb
    """Signed work of the actuator over the tick [J]."""
    climb_flight_m: PerLane
    """Height climbed in flight over the tick [m], >= 0."""
    climb_m: PerLane
    """Height climbed over the tick, in flight and stance [m], >= 0."""
    apex_share: PerLane
    """Position of a flight apex in the tick, 0 ... 1; NaN without one."""
    apex_height_m: PerLane
    """Height of that apex [m]; NaN without one."""
    touchdown_share: PerLimb
    """Position of a touchdown in the tick, 0 ... 1; NaN without one."""
    force_n: PerLimb | None = None
    """Mean force of the actuator over the tick [N], where it is not the commanded one."""


class Body(Part, ABC):
    """A mechanical system with one actuated leg, or several.

    A body is a frozen dataclass of numbers, made a pytree by `tegotae.parts.parameters.traceable`,
    so that its parameters are arguments of the compiled program. No lane may look at another: the
    lanes come last in every array. What belongs to a limb has the limbs' axis before them, if the
    body has several; a body of one limb has no such axis (`limb_shape`).
    """

    SENSES: tuple[str, ...] = ()
    """Names of what `sense` returns; a controller that reads another name is refused."""
    COMMANDS: tuple[str, ...] = FORCE
    """Commands of the actuators: a force, unless stated otherwise (`Actuation.COMMANDS`)."""
    LARGEST_TURN_RAD: ClassVar[float] = LARGEST_TURN_RAD
    """Its fastest rate times the control period [rad] that is accepted."""

    max_force_n: float
    """Largest actuator force α [N]: a field of every body."""
    rest_length_m: float
    """Length of the unloaded leg l0 [m], below which there is stance: a field of every body."""

    @property
    def limbs(self) -> int:
        """Number of limbs."""
        return 1

    @property
    def limb_shape(self) -> tuple[int, ...]:
        """Leading shape of arrays of the limbs, before the axis of the lanes: () for one, else
        (limbs,)."""
        return () if self.limbs == 1 else (self.limbs,)

    @property
    def channels(self) -> tuple[Channel, ...]:
        """Channels that a rollout records of this body beside the common ones."""
        return ()

    @property
    @abstractmethod
    def rate_scale(self) -> Number:
        """A typical rate of the body [rad/s], by which a network sees the Tegotae feedback."""

    @property
    def touching_height_m(self) -> float:
        """Height of the body at which its legs at rest just touch level ground [m]."""
        return self.rest_length_m

    @property
    def pose_names(self) -> tuple[str, ...]:
        """Names of the release's entries beside height and velocity (`Scenario.initial_pose`)."""
        return tuple(inspect.signature(self.release).parameters)[2:]

    @property
    def fastest_rad_per_s(self) -> float:
        """Bound of the rates of its motion [rad/s], which a control period must resolve; 0 if any
        period does."""
        return 0.0

    @property
    def longest_tick_s(self) -> float:
        """The longest control period that resolves its motion [s]."""
        fastest = self.fastest_rad_per_s
        return self.LARGEST_TURN_RAD / fastest if fastest > 0.0 else math.inf

    def check_tick(self, tick_s: float) -> None:
        """Check that a control period suits the body.

        Args:
            tick_s: control period [s].

        Raises:
            TegotaeError: for one that is too long.
        """
        if tick_s > self.longest_tick_s:
            raise TegotaeError(
                f"the control tick of {tick_s:g} s is too long for this "
                f"{type(self).__name__.lower()}, whose stance has a rate of "
                f"{self.fastest_rad_per_s:.3g} rad/s; use at most {self.longest_tick_s:.2g} s"
            )

    def check_release(self, height_m: float) -> None:
        """Check that the body can hop after a release at rest.

        Args:
            height_m: height of the release [m].

        Raises:
            TegotaeError: for a height from which it never can.
        """

    @abstractmethod
    def release(self, height_m: PerLane, velocity_m_per_s: PerLane) -> StateTree:
        """Return the state at release, a tuple of arrays.

        A body that needs more to be released takes it by further names, each with a default
        (`Scenario.initial_pose`).

        Args:
            height_m: height of the centre of mass [m], [lanes].
            velocity_m_per_s: its upward velocity [m/s], [lanes].
        """

    def commanded(self, state: StateTree, command: PerCommand) -> StateTree:
        """Return the state at release once the first command is known: where feet are placed.

        Args:
            state: state at release.
            command: first command of the limbs, in the units of `COMMANDS`.
        """
        return state

    @abstractmethod
    def sense(self, state: StateTree, ground_m: PerLane) -> Sensation:
        """Return the readings of the sensors.

        Args:
            state: state of the body.
            ground_m: height of the ground [m], [lanes].
        """

    @abstractmethod
    def predict(
        self, state: StateTree, force_n: PerLimb, ground_m: PerLane, tick_s: Scalar
    ) -> tuple[StateTree, PerLimb, PerLimb]:
        """Predict the state one tick on under a held force, with errors of second order.

        Args:
            state: state of the body.
            force_n: force of the actuators [N], per limb.
            ground_m: height of the ground [m], [lanes].
            tick_s: control period [s].

        Returns:
            The state, and the parts of the tick (0 … 1) at which stance begins and ends; the same
            value twice without stance.
        """

    @abstractmethod
    def advance(
        self, state: StateTree, push: Push, ground_m: PerLane, tick_s: Scalar
    ) -> tuple[StateTree, Contact]:
        """Return the state one tick on under the actuator's push, and the contacts on the way.

        Args:
            state: state of the body.
            push: command of the actuators over the tick.
            ground_m: height of the ground [m], [lanes].
            tick_s: control period [s].
        """

    def apply_impulse(self, state: StateTree, impulse_ns: PerLane) -> StateTree:
        """Return the state after a vertical blow on the centre of mass.

        Args:
            state: state of the body.
            impulse_ns: impulse of the blow, upwards [N s], [lanes].

        Raises:
            TegotaeError: for a body that does not say what a blow does to it.
        """
        raise TegotaeError(
            f"a {type(self).__name__} takes no impulse; it has no method "
            "apply_impulse(state, impulse_ns)"
        )

    @abstractmethod
    def failed(self, state: StateTree, ground_m: PerLane) -> MaskPerLane:
        """Return True where the body can no longer move on (such as a leg of no length), [lanes].

        Args:
            state: state of the body.
            ground_m: height of the ground [m], [lanes].
        """

    @abstractmethod
    def height(self, state: StateTree) -> PerLane:
        """Return the height of the centre of mass [m], [lanes].

        Args:
            state: state of the body.
        """

    @abstractmethod
    def velocity(self, state: StateTree) -> PerLane:
        """Return the vertical velocity of the centre of mass [m/s], [lanes].

        Args:
            state: state of the body.
        """

    @abstractmethod
    def energy(self, state: StateTree, ground_m: PerLane) -> PerLane:
        """Return the mechanical energy, kinetic + potential (height above zero) + elastic [J].

        Args:
            state: state of the body.
            ground_m: height of the ground [m], [lanes].

        Returns:
            The energy, [lanes].
        """


@dataclass(frozen=True, kw_only=True)
class SpringLegs(Body):
    """A body on legs with springs, dampers and actuators that push, as the paper's hopper has."""

    mass_kg: float = positive(0.1)
    """Mass of the body per leg, m [kg]."""
    stiffness_n_per_m: float = positive(5.0)
    """Spring stiffness of a leg k [N/m]."""
    damping_ns_per_m: float = not_negative(0.2)
    """Damping of a leg c [N s/m], in stance."""
    rest_length_m: float = positive(1.0)
    """Rest length of a leg l0 [m]."""
    gravity_m_per_s2: float = positive(9.81)
    """Gravity g [m/s²]."""
    max_force_n: float = positive(4.0)
    """Largest force of an actuator α [N]."""

    @property
    def rate_scale(self) -> jax.Array:
        """√(g / l0) [rad/s]."""
        return jnp.sqrt(self.gravity_m_per_s2 / self.rest_length_m)


def for_limbs(of_body: T) -> T:
    """Return a value of the body with an axis for the limbs before that of the lanes.

    A number stays a number: a body's field may be one, or an array of the lanes.

    Example:
        >>> import jax.numpy as jnp
        >>> for_limbs(jnp.zeros(5)).shape, for_limbs(2.0)
        ((1, 5), 2.0)
    """
    array = cast(jax.Array, of_body)
    return cast(T, array[..., None, :]) if jnp.ndim(array) else of_body


def require_present(present: tuple[float, ...] | None, limbs: int) -> None:
    """Raise `TegotaeError` unless each leg is declared present or absent, one present."""
    if present is not None and not (
        len(present) == limbs and set(present) <= {0.0, 1.0} and any(present)
    ):
        raise TegotaeError(
            f"present is {present}; it must be 1 or 0 for each of {limbs} legs, and 1 for one"
        )


def require_one_limb(body: Body, subject: str) -> None:
    """Raise `TegotaeError` if a body has several limbs, for which something is not made.

    Args:
        body: the body.
        subject: what is not, such as "an evaluation".

    Example:
        >>> from tegotae.parts.bodies import Bar
        >>> require_one_limb(Bar(), "an evaluation")
        Traceback (most recent call last):
        tegotae.TegotaeError: an evaluation is made for bodies of one limb; a Bar has 2
    """
    if body.limbs > 1:
        raise TegotaeError(
            f"{subject} is made for bodies of one limb; a {type(body).__name__} has {body.limbs}"
        )


@traceable
@dataclass(frozen=True, kw_only=True)
class Interface(Part):
    """Signals, commands and scales of limbs; None for what is not known.

    It stands for a body whose mechanics are in another simulator or in a robot.
    A network sees a signal x as x / scale, and one without a known scale as x.

    Args:
        senses: names of the signals.
        scales: of each signal, in its units; None for all or for one that is not known.
        limbs: how many limbs there are.
        commands: what is commanded (`tegotae.parts.channels`).
        max_force_n: the force α at which the actuators are at full push.
        rest_length_m: height at which the feet touch the ground [m].
        feedback_scale: √(g / l), the scale of the feedback [rad/s].

    Raises:
        TegotaeError: for a number out of its range, or scales of another number than senses.

    Example:
        >>> Interface(senses=("spring_force", "velocity"), scales=(9.81, None)).known_scales
        {'spring_force': 9.81}
    """

    NAME: ClassVar[str] = "Interface"
    """Name in documents, in place of a body's."""

    senses: tuple[str, ...] = field(default=("spring_force",), metadata=STATIC)
    scales: tuple[float | None, ...] | None = None
    limbs: int = whole(1, static=True)
    commands: tuple[str, ...] = field(default=FORCE, metadata=STATIC)
    max_force_n: float | None = positive(None)
    rest_length_m: float | None = positive(None)
    feedback_scale: float | None = positive(None)

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.scales is not None and len(self.scales) != len(self.senses):
            raise TegotaeError(
                f"there are {len(self.scales)} scales for {len(self.senses)} senses; give one "
                "each, None where it is not known"
            )
        for name, scale in zip(self.senses, self.scales or (), strict=False):
            if scale is not None:
                require_finite(f"the scale of {name}", scale, above=0.0)

    @property
    def known_scales(self) -> dict[str, float]:
        """The scales that are known, by the names of the signals; that of `feedback` among them."""
        pairs = zip(self.senses, self.scales or (), strict=False)
        scales = {**dict(pairs), "feedback": self.feedback_scale}
        return {name: scale for name, scale in scales.items() if scale is not None}
