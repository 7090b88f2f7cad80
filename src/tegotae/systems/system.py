"""A closed loop: controller, body, release, integrator, timing."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass, field
from typing import ClassVar, Self

import numpy as np

from tegotae._support.errors import TegotaeError, require_finite
from tegotae._support.limits import MOST_M, MOST_RAD_PER_S
from tegotae.measures.evaluation import Protocol
from tegotae.parts._shapes import ArrayTree, LaneNumbers
from tegotae.parts.bodies import Body, Hopper, Interface, Walker
from tegotae.parts.controller import Controller
from tegotae.parts.fields import replace, unwrapped
from tegotae.parts.oscillators import Oscillator
from tegotae.simulation.draws import check_scenario
from tegotae.simulation.integrators import Integrator, PredictorCorrector
from tegotae.simulation.loop import check_senses
from tegotae.simulation.rollout import Rollout, Timing
from tegotae.simulation.summaries import Summary, whole_trajectory
from tegotae.simulation.world import Scenario

RELEASE_M = 1.2
"""Height of the paper's release [m]."""
WALKING = 200.0
"""Time in which a walker settles [√(l0 / g)]."""
WALKING_TICK = 0.008
"""A walker's control tick [√(l0 / g)]."""


@dataclass(frozen=True, kw_only=True)
class Release:
    """Initial state of an episode: one number each, or one per limb.

    Args:
        height_m: height of the body [m].
        velocity_m_per_s: vertical velocity of the body [m/s].
        phase_rad: phase of the oscillators [rad], one for all or one a limb.
        initial_pose: further numbers that the body's release takes, pairs of name and number, such
            as (("pitch_rad", 0.1),) for a bar.
        oscillator_state: the oscillators' state beside the phase, such as (("radius", 0.5),).

    Raises:
        TegotaeError: for a height that is not positive, or a number that is not finite.

    Example:
        >>> Release(height_m=1.1).scenario(8.0).height_m
        1.1
    """

    height_m: float = RELEASE_M
    velocity_m_per_s: float = 0.0
    phase_rad: float | tuple[float, ...] = 0.0
    initial_pose: tuple[tuple[str, float], ...] = ()
    oscillator_state: tuple[tuple[str, float], ...] = ()

    def __post_init__(self) -> None:
        require_finite("the release's height_m", self.height_m, above=0.0, most=MOST_M)
        require_finite("the release's velocity_m_per_s", self.velocity_m_per_s)
        for phase in np.atleast_1d(np.asarray(self.phase_rad, object)):
            require_finite("the release's phase_rad", phase)
        for name, value in (*self.initial_pose, *self.oscillator_state):
            require_finite(f"the release's {name}", value)

    def check(
        self, body: Body, oscillator: Oscillator | None, omega: float | None, episode: Timing
    ) -> None:
        """Raise `TegotaeError` unless this body and these oscillators can be released so.

        Args:
            body: the body.
            oscillator: of the controller.
            omega: ω [rad/s].
            episode: its duration and tick (`Timing`).
        """
        if isinstance(self.phase_rad, tuple) and not 1 < body.limbs == len(self.phase_rad):
            raise TegotaeError(
                f"the release has {len(self.phase_rad)} phases, one a limb; the body has "
                f"{body.limbs} limb{'s' if body.limbs > 1 else ''}"
            )
        check_scenario(self.scenario(omega), body, oscillator, episode)

    def scenario(self, omega: float | None, **entries: LaneNumbers) -> Scenario:
        """Return the scenario of a lane with this release.

        Args:
            omega: ω [rad/s]; None without an oscillator.
            entries: entries of the scenario in place of the release's.
        """
        by_limb = isinstance(self.phase_rad, tuple)
        given_entries = {
            "height_m": self.height_m,
            "velocity_m_per_s": self.velocity_m_per_s,
            "phase_rad": np.array(self.phase_rad)[:, None] if by_limb else self.phase_rad,
            "initial_pose": dict(self.initial_pose),
            "oscillator_state": dict(self.oscillator_state),
        }
        return Scenario.at_frequency(omega, **{**given_entries, **entries})


@dataclass(frozen=True, kw_only=True)
class System:
    """A controller, the body that it drives, their release and their timing.

    Every function of a closed loop takes a system, without hidden defaults.
    `tegotae.parts.fields.replace` changes its fields and those of its release.

    Args:
        controller: the structure; its weights are passed beside the system.
        body: the body; of limbs that are moved elsewhere, by another simulator or a robot, their
            interface.
        omega: prescribed frequency ω [rad/s]; None without an oscillator.
        release: how an episode begins.
        timing: an episode's duration, control period and recording period.
        integrator: how controller and body advance by one control period; `Hold()` holds the
            controller over each, as a robot does.

    Raises:
        TegotaeError: for an oscillator without a frequency or a frequency without an oscillator, a
            signal that the body does not sense, a release that the body does not take, or a
            control period that is too long for the body or the oscillator.

    Example:
        >>> from tegotae.systems.recipe import recipe
        >>> hopper = System(controller=recipe("V-reflex-w8").controller(), omega=8.0)
        >>> hopper.run([2.0]).height_m.shape
        (1000, 1)
    """

    INSIDE: ClassVar[tuple[str, ...]] = ("release",)

    controller: Controller
    body: Body | Interface = field(default_factory=Hopper)
    omega: float | None = None
    release: Release = field(default_factory=Release)
    timing: Timing = field(default_factory=Timing)
    integrator: Integrator = field(default_factory=PredictorCorrector)

    def __post_init__(self) -> None:
        if self.controller.oscillator is None and self.omega is not None:
            raise TegotaeError(
                f"the controller has no oscillator, but omega is {self.omega} rad/s; omega must "
                "be None"
            )
        if self.controller.oscillator is not None and self.omega is None:
            raise TegotaeError("the controller has an oscillator; give omega, such as 8 rad/s")
        if self.omega is not None:
            require_finite("omega", self.omega, above=0.0, most=MOST_RAD_PER_S)
        check_senses(self.controller, self.body)
        if isinstance(self.body, Body):
            self.release.check(self.body, self.controller.oscillator, self.omega, self.timing)
            self.body.check_tick(self.timing.tick_s)

    @property
    def mechanics(self) -> Body:
        """The body, which moves here.

        Raises:
            TegotaeError: for limbs that are moved elsewhere.
        """
        if isinstance(self.body, Interface):
            raise TegotaeError(
                "this controller was trained on an environment, and its body is not here; use "
                "Wiring.from_controller there, or give a body of this package, such as a Hopper"
            )
        return self.body

    def on(self, body: Body) -> System:
        """Return the system on another body, released at the same height above leg contact.

        Args:
            body: the other body.

        Raises:
            TegotaeError: for a body that does not go with the rest, or cannot hop from there.
        """
        height_m = self.height_on(body)
        body.check_release(height_m)
        return replace(self, {"body": body, "height_m": height_m})

    def height_on(self, body: Body) -> float:
        """Return the height that releases another body equally high above leg contact [m].

        Args:
            body: the other body.
        """
        higher = float(body.touching_height_m) - float(self.mechanics.touching_height_m)
        return self.release.height_m + higher

    def period_s(self, usual_s: float) -> float:
        """Return the control period of a task that usually takes another one [s].

        In continuous time the period is a matter of accuracy, and the task sets it. A controller
        that is held over its period, or another integrator, would be another system with another
        period, and keeps its own.

        Args:
            usual_s: control period of the task [s].
        """
        return usual_s if self.integrator == PredictorCorrector() else self.timing.tick_s

    def evaluated_by(self, protocol: Protocol) -> Protocol:
        """Return a protocol from the system's own release, and of its control period where that is
        fixed.

        Args:
            protocol: its episodes, times, drop and work.
        """
        return dataclasses.replace(
            protocol, release_m=self.release.height_m, tick_s=self.period_s(protocol.tick_s)
        )

    def timing_over(
        self, duration_s: float, *, tick_s: float = Timing.tick_s, frame_s: float = Timing.frame_s
    ) -> Timing:
        """Return the timing of a task: at its usual control period, or the system's (`period_s`).

        Args:
            duration_s: how long [s].
            tick_s: the usual control period [s].
            frame_s: the usual recording period [s]; the whole multiple of the control period that
                is nearest to it is taken.

        Example:
            >>> from tegotae.simulation.integrators import Hold
            >>> from tegotae.systems.recipe import recipe
            >>> held = Timing(tick_s=0.008, frame_s=0.016)
            >>> reflex = recipe("V-reflex-w8").controller()
            >>> robot = System(controller=reflex, omega=8.0, timing=held, integrator=Hold())
            >>> f"{robot.timing_over(40.0).frame_s:g}"
            '0.016'
        """
        tick_s = self.period_s(tick_s)
        ratio = frame_s / tick_s
        ticks = max(1, round(ratio))
        frame_s = frame_s if abs(ratio - ticks) < 1e-6 else ticks * tick_s
        return Timing(duration_s=duration_s, tick_s=tick_s, frame_s=frame_s)

    def scenario(self, **entries: LaneNumbers) -> Scenario:
        """Return the scenario of one lane's episode.

        Args:
            entries: entries of `Scenario` that override the release's, such as `drop_m=0.1`.
        """
        return self.release.scenario(self.omega, **entries)

    def rollout(self, summary: Summary = whole_trajectory, timing: Timing | None = None) -> Rollout:
        """Return the rollout that simulates the system.

        Args:
            summary: summary of each lane; the whole trajectory by default.
            timing: duration and periods; the system's own by default.
        """
        return Rollout(
            controller=self.controller,
            integrator=self.integrator,
            timing=self.timing if timing is None else timing,
            summary=summary,
        )

    def run(
        self,
        weights: LaneNumbers,
        scenario: Scenario | None = None,
        *,
        summary: Summary = whole_trajectory,
        dtype: str = "float32",
    ) -> ArrayTree:
        """Roll it out.

        Args:
            weights: shape [lanes, n_weights] or [n_weights].
            scenario: of every lane; the system's own episode by default.
            summary: function that says what is kept of a trajectory.
            dtype: "float32" or "float64".

        Returns:
            The trajectory, or what the summary makes of it: NumPy arrays, lanes last.

        Raises:
            TegotaeError: for what the engine refuses.
        """
        episode = self.scenario() if scenario is None else scenario
        return self.rollout(summary).run(weights, episode, self.mechanics, dtype=dtype)


class OnSystem:
    """An object with a system, which exposes the system's controller, body, frequency and
    timing."""

    INSIDE: ClassVar[tuple[str, ...]] = ("system",)

    system: System

    @property
    def controller(self) -> Controller:
        """The structure, whose weights are learned or set."""
        return self.system.controller

    @property
    def body(self) -> Body:
        """The body, which moves here (`System.mechanics`)."""
        return self.system.mechanics

    @property
    def omega(self) -> float | None:
        """The prescribed frequency ω [rad/s]; None without an oscillator."""
        return self.system.omega

    @property
    def timing(self) -> Timing:
        """Duration, control period and recording period of an episode."""
        return self.system.timing

    def on(self, body: Body) -> Self:
        """Return this setup on another body, released at the same height above leg contact.

        Args:
            body: the other body.

        Raises:
            TegotaeError: for a body that does not go with the rest, or cannot hop from there.

        Example:
            >>> from tegotae.systems.vanilla import legged_named
            >>> walker = legged_named("quadruped-c")
            >>> higher = walker.on(dataclasses.replace(walker.body, com_z_m=-0.3))
            >>> higher.system.release.height_m > walker.system.release.height_m
            True
        """
        return replace(self, {"system": self.system.on(body)})


def usual_system(
    controller: Controller, body: Body | Interface, omega: float | None, tick: float = WALKING_TICK
) -> System:
    """Return a controller on a body, with the body's usual release and timing.

    A walker begins on its feet, and its times are in √(l0 / g); others are released as the paper's
    hopper is.

    Args:
        controller: what drives the body.
        body: the body, or what is known of it.
        omega: frequency ω [rad/s]; None without an oscillator.
        tick: control tick of a walker [√(l0 / g)].

    Raises:
        TegotaeError: for what does not go together.
    """
    base = body if isinstance(body, Interface) else unwrapped(body)
    if not isinstance(base, Walker):
        return System(controller=controller, body=body, omega=omega)
    unit_s = math.sqrt(base.rest_length_m / base.gravity_m_per_s2)
    press_m = getattr(controller.actuation, "press_m", 0.0)
    return System(
        controller=controller,
        body=body,
        omega=omega,
        release=Release(height_m=base.standing_height_m + press_m),
        timing=Timing(duration_s=WALKING * unit_s, tick_s=tick * unit_s, frame_s=0.08 * unit_s),
    )
