"""Settings of the hopper's environments, with their actions and rewards."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, TypeAlias, TypeVar, cast

import jax
import jax.numpy as jnp
import numpy as np

from tegotae._support.errors import TegotaeError, require_count, require_finite, require_known
from tegotae.measures.hopping.signals import check_work, cot_inverse
from tegotae.parts._shapes import Numeric
from tegotae.parts.bodies import Body, Hopper, require_one_limb
from tegotae.parts.controller import Controller, Tegotae
from tegotae.parts.oscillators import Oscillator, PhaseOscillator
from tegotae.parts.parameters import Part, not_negative, positive, whole
from tegotae.parts.terms import (
    Actuation,
    ConstantGain,
    Reflex,
    Sector,
    SectorAndReflex,
    Signals,
    Term,
)
from tegotae.parts.terms.actuation import CommandedForce
from tegotae.simulation.rollout import Scenario


@dataclass(frozen=True)
class _One(Term):
    """A term that is 1: `f = G · 1 · 1` leaves the feedback to the gain, which is the agent's."""

    def __call__(self, weights: Sequence[jax.Array], signals: Signals) -> jax.Array:
        """Return 1."""
        return jnp.ones_like(next(iter(signals.values.values())))


def feedback_controller(actuation: Actuation, oscillator: Oscillator | None = None) -> Controller:
    """Return the controller whose one weight is the Tegotae feedback f [rad/s].

    An oscillator (the phase oscillator by default) and an actuation without weights make the force
    of it: the agent stands where `G · A′(φ) · R(s)` stood.
    """
    terms = Tegotae(_One(), _One(), ConstantGain())
    return Controller(actuation, oscillator or PhaseOscillator(), terms)


@dataclass(frozen=True, kw_only=True)
class HopReward(Part):
    """Zero but at each apex of a hop, where it is CoT⁻¹ of the hop just ended [m/J].

        r = (height climbed in flight since the last hop's apex) / (work since then),

    if any work was done, and, with the last step of an episode that ran its time, the mean over
    the rewarded hops. A hop is a flight that clears the rest length by 1 %. (The paper gives
    no formula: `CoT⁻¹` is its equation 12, taken hop by hop.)

    Args:
        work: definition of work, one of "absolute", "positive", "net".
        least_work_j: work that counts as none [J]. The paper's reward can be had for almost
            nothing: the first hops after a release need no work, and so pay the more the less is
            done in them. A greater value, or `charge_stored`, closes that door.
        charge_stored: whether energy that the body lost between the two apexes is charged as
            work too, so that hops on stored energy are not free.

    Raises:
        TegotaeError: for an unknown definition of work or a least work that is negative.

    Example:
        >>> reward = HopReward()
        >>> float(reward.of_hop(climb_m=0.2, work_j=0.4, lost_j=0.1)[0])
        0.5
    """

    work: str = "absolute"
    least_work_j: float = not_negative(1e-6)
    charge_stored: bool = False

    def __post_init__(self) -> None:
        super().__post_init__()
        check_work(self.work)

    def counted(self, work_j: Numeric) -> Numeric:
        """Return the part of the actuator's signed work over a tick that is charged [J]."""
        if self.work == "net":
            return work_j
        return jnp.abs(work_j) if self.work == "absolute" else jnp.maximum(work_j, 0.0)

    def of_hop(
        self, *, climb_m: Numeric, work_j: Numeric, lost_j: Numeric
    ) -> tuple[jax.Array, jax.Array]:
        """Return CoT⁻¹ of a hop [m/J] and whether it is rewarded, each of the shape of the
        lanes.
        """
        paid = jnp.asarray(work_j) > self.least_work_j
        spent = work_j + jnp.maximum(lost_j, 0.0) if self.charge_stored else work_j
        return jnp.where(paid, cot_inverse(climb_m, spent), 0.0), paid


K = TypeVar("K")

Chosen: TypeAlias = float | tuple[float, float]
"""A number, or the two ends of the range from which every episode draws its own."""

ACTUATIONS: dict[str, Actuation] = {
    "sector": Sector(),
    "reflex": Reflex(),
    "both": SectorAndReflex(),
}
"""The paper's actuations: equation 6, equation 7, and their clipped sum."""


@dataclass(frozen=True, kw_only=True)
class HopperSettings(Part):
    """Settings of `tegotae/Hopper-v0`, whose action is the actuator force.

    An action a in [-1, 1] is the force `F_a = α · max(0, a)`: none at 0, full force at 1.

    Raises:
        TegotaeError: for a value that cannot be used.

    Example:
        >>> HopperSettings(duration_s=5.0, tick_s=0.002, decimation=5).n_steps
        500
    """

    body: Body = field(default_factory=Hopper)
    """The body; or some parameters of a hopper by name, `{"mass_kg": 0.2}`."""
    tick_s: float = positive(0.001)
    """Control period [s]: how finely the environment is advanced."""
    decimation: int = whole(10)
    """Ticks for which an action is held: the agent acts every `decimation · tick_s` seconds."""
    duration_s: float = positive(20.0)
    """Length of an episode [s], rounded to whole steps of the agent; then it is truncated."""
    height_m: Chosen = 1.2
    """Release height [m]."""
    velocity_m_per_s: Chosen = 0.0
    """Release velocity [m/s]."""
    drop_m: Chosen = 0.0
    """Height by which the ground drops [m]."""
    drop_time_s: Chosen = math.inf
    """Time at which it drops [s]; infinity for never."""
    observation: tuple[str, ...] = ("spring_force", "velocity")
    """Entries of the agent's observation, in this order: any of `spring_force` F_k, `velocity` ẏ,
    `height` y - h, and, where the environment has an oscillator, `phase` as (sin φ, cos φ)."""
    dimensionless: bool = True
    """True for F_k, ẏ and y - h over m g, √(g l0) and l0; False for N, m/s and m."""
    reward: HopReward = field(default_factory=HopReward)
    """The step reward, or its arguments by name."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "body", _converted(Body, "body", self.body, Hopper))
        object.__setattr__(self, "reward", _converted(HopReward, "reward", self.reward, HopReward))
        require_one_limb(self.body, "the environment of a hopper")
        super().__post_init__()
        require_count("duration_s in steps of the agent", self.n_steps)
        self.body.check_tick(self.tick_s)
        for name in self.CHOSEN:
            self._check_chosen(name)
        self._check_observation()

    CHOSEN = ("height_m", "velocity_m_per_s", "drop_m", "drop_time_s")
    """Settings that an episode may draw from a range, and that `reset` may set by its options."""

    @property
    def controller(self) -> Controller:
        """Controller between the agent and the body; its one weight is the action."""
        return Controller(CommandedForce())

    @property
    def action_scale(self) -> float:
        """Force of an action of 1: α [N]."""
        return self.body.max_force_n

    @property
    def step_s(self) -> float:
        """Time between two actions of the agent [s]."""
        return self.tick_s * self.decimation

    @property
    def n_steps(self) -> int:
        """Steps of the agent in a whole episode."""
        return round(self.duration_s / self.step_s)

    @property
    def observed(self) -> tuple[str, ...]:
        """Names of the observation's entries, the phase as its sine and cosine."""
        names: list[str] = []
        for name in self.observation:
            names += ["sin_phase", "cos_phase"] if name == "phase" else [name]
        return tuple(names)

    def scenario(
        self, random: np.random.Generator | None, options: Mapping[str, float] | None = None
    ) -> Scenario:
        """Draw the scenario of an episode: the chosen numbers, at random where they are ranges.

        Args:
            random: the generator to draw with; None where nothing is drawn (`draws`).
            options: numbers by name that stand for this episode, whatever the settings say.

        Raises:
            TegotaeError: for an option that is no such setting or no number.
        """
        options = {} if options is None else dict(options)
        values = {}
        for name in self.CHOSEN:
            value = getattr(self, name)
            if isinstance(value, tuple):
                assert random is not None
                value = random.uniform(*value)
            values[name] = float(value)
        for name, value in options.items():
            require_known("option of reset", name, self.CHOSEN)
            _check_number(name, value)
            values[name] = float(value)
        return Scenario(**{"omega": 0.0, **values})

    @property
    def draws(self) -> bool:
        """True if any chosen number is drawn from a range."""
        return any(isinstance(getattr(self, name), tuple) for name in self.CHOSEN)

    def _check_chosen(self, name: str) -> None:
        value = getattr(self, name)
        ends = value if isinstance(value, tuple | list) else (value,)
        for end in ends:
            _check_number(name, end)
        if ends is not value:
            return
        if len(ends) != 2 or not ends[0] <= ends[1] < math.inf:
            raise TegotaeError(
                f"{name} is {value!r}; a range has two finite ends, the low end first"
            )
        object.__setattr__(self, name, (float(ends[0]), float(ends[1])))

    def _check_observation(self) -> None:
        names = (self.observation,) if isinstance(self.observation, str) else self.observation
        object.__setattr__(self, "observation", tuple(names))
        has_phase = self.controller.oscillator is not None
        options = (*self.body.SENSES, *(("phase",) if has_phase else ()))
        if not self.observation:
            raise TegotaeError(
                f"the observation is empty; name at least one of {', '.join(options)}"
            )
        for name in self.observation:
            require_known("observation of this environment", name, options)


@dataclass(frozen=True, kw_only=True)
class TegotaeHopperSettings(HopperSettings):
    """Settings of `tegotae/TegotaeHopper-v0`, whose action is the Tegotae feedback.

    The environment holds the oscillator, `φ̇ = ω + f`, and one of the paper's actuations; an action
    a in [-1, 1] is the feedback `f = a · max_feedback_rad_per_s`.

    Example:
        >>> TegotaeHopperSettings(omega=8.0, actuation="reflex").observed
        ('sin_phase', 'cos_phase', 'spring_force')
    """

    observation: tuple[str, ...] = ("phase", "spring_force")
    omega: Chosen = 8.0
    """Prescribed frequency ω [rad/s]."""
    phase_rad: Chosen = 0.0
    """Oscillator phase at release [rad]."""
    actuation: str | Actuation = "sector"
    """`sector` (equation 6), `reflex` (equation 7), `both`, or an actuation without weights."""
    max_feedback_rad_per_s: float = positive(40.0)
    """The feedback that an action of 1 is [rad/s]."""
    oscillator: Oscillator = field(default_factory=PhaseOscillator)
    """The oscillator."""

    CHOSEN = ("height_m", "velocity_m_per_s", "drop_m", "drop_time_s", "omega", "phase_rad")

    def __post_init__(self) -> None:
        if isinstance(self.actuation, str):
            require_known("actuation", self.actuation, ACTUATIONS)
            object.__setattr__(self, "actuation", ACTUATIONS[self.actuation])
        if not isinstance(self.actuation, Actuation) or self.actuation.n_weights:
            raise TegotaeError(
                f"actuation is {self.actuation!r}; it must be one of {', '.join(ACTUATIONS)}, or "
                "an actuation without weights"
            )
        super().__post_init__()

    @property
    def controller(self) -> Controller:
        """Oscillator and actuation; the one weight is the feedback."""
        assert isinstance(self.actuation, Actuation)
        return feedback_controller(self.actuation, self.oscillator)

    @property
    def action_scale(self) -> float:
        """Feedback of an action of 1: the largest one [rad/s]."""
        return self.max_feedback_rad_per_s


def _check_number(name: str, value: float) -> None:
    limits: dict[str, float] = {}
    if name == "height_m":
        limits = {"above": 0.0}
    elif name == "drop_time_s":
        limits = {"least": 0.0}
        if value == math.inf:
            return
    require_finite(name, value, **limits)


def _converted(kind: type[K], name: str, value: object, default: type[K]) -> K:
    """Return the value; a mapping is converted to the default class with these arguments."""
    if isinstance(value, Mapping):
        return _construct(default, f"argument of {name}", value)
    if not isinstance(value, kind):
        raise TegotaeError(
            f"{name} is {value!r}; it must be a {kind.__name__}, or the arguments of a "
            f"{default.__name__}"
        )
    return value


def _construct(kind: type[K], role: str, arguments: Mapping[str, Any]) -> K:
    names = [field.name for field in dataclasses.fields(cast(Any, kind))]
    for name in arguments:
        require_known(role, name, names)
    return kind(**arguments)


def hopper_settings_of(
    kind: type[HopperSettings], arguments: Mapping[str, object]
) -> HopperSettings:
    """Return the settings that these keyword arguments of an environment specify.

    Raises:
        TegotaeError: for an argument that the environment does not have.
    """
    return _construct(kind, "argument of this environment", arguments)


ENVIRONMENTS: dict[str, type[HopperSettings]] = {
    "tegotae/Hopper-v0": HopperSettings,
    "tegotae/TegotaeHopper-v0": TegotaeHopperSettings,
}
"""The settings of each environment, by the name that `gymnasium.make` knows it by."""
