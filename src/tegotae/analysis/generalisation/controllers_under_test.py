"""Controllers under test: runs of one training, on the body that they were trained on."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from tegotae._support.documents import JsonObject
from tegotae._support.errors import TegotaeError
from tegotae.measures.gaits.names import leg_names, reference_leg
from tegotae.measures.gaits.summary import has_mass
from tegotae.parts._shapes import LaneNumbers
from tegotae.parts.bodies import (
    Actuators,
    Blows,
    Body,
    BodyWrapper,
    Sensors,
)
from tegotae.parts.channels import FORCE
from tegotae.parts.controller import Controller
from tegotae.parts.fields import (
    paths_of,
    unwrapped,
    value_of,
    with_fields,
)
from tegotae.parts.terrains import Rough, Slope, Sum
from tegotae.simulation.integrators import PredictorCorrector
from tegotae.simulation.rollout import Timing
from tegotae.systems.controller_file import ControllerSet
from tegotae.systems.descriptions import describe
from tegotae.systems.legged import settling_s
from tegotae.systems.system import Release, System

if TYPE_CHECKING:
    from tegotae.analysis.generalisation.disturbance import Disturbance

HOPPING = Timing(duration_s=32.0, tick_s=0.002)
"""How long a leg of a metre on Earth that hops is looked at: at 4 rad/s a cycle of two hops is seen
five times in the 20 s after a blow."""
USUAL_DELAY_S = 0.032
"""So much of what was felt is kept in any case, for a leg of a metre on Earth [s]."""
MOST_TICKS = 128
"""The longest delay of the senses that is tried, in control ticks: all of it is kept."""

_EARTH_S = math.sqrt(1.0 / 9.81)


@dataclass(frozen=True)
class ControllersUnderTest:
    """A set of controllers, unchanged, and how it is tried.

    Args:
        controllers: the runs of one training, and the system that they share.
        starts: from how many releases each is tried; those of several legs differ in the phases of
            their oscillators.
        looked_at: for how long, and how closely; as is usual for its body if None.
        longest_delay_s: so much of what was felt is kept, for a leg of a metre on Earth [s].

    Raises:
        TegotaeError: for no runs, a body that cannot be released here, or a delay of too many
            ticks.
    """

    controllers: ControllerSet
    starts: int = 1
    looked_at: Timing | None = None
    longest_delay_s: float = USUAL_DELAY_S

    def __post_init__(self) -> None:
        if not len(self.weights):
            raise TegotaeError(f"{self.name} has no runs to test")
        self._check_body()
        longest = MOST_TICKS * self.timing.tick_s / self.time_scale
        if self.longest_delay_s > longest * (1.0 + 1e-6):
            ticks = self.longest_delay_s * self.time_scale / self.timing.tick_s
            raise TegotaeError(
                f"delay={self.longest_delay_s:g} on {self.name} is {ticks:g} control ticks; "
                f"{MOST_TICKS} are the most that are kept: try delays up to {longest:.3g}"
            )

    def _check_body(self) -> None:
        try:
            self.body.check_release(self.height_m)
        except TegotaeError as error:
            raise TegotaeError(f"{self.name} cannot be tested: {error}") from None
        own = {"rest_length_m": hasattr(self.unwrapped, "rest_length_m")}
        if not self.hops:  # whose cost of transport is measured
            own["mass_kg"] = has_mass(self.unwrapped)
            own["gravity_m_per_s2"] = hasattr(self.unwrapped, "gravity_m_per_s2")
        for field, there in own.items():
            if not there:
                kind = type(self.unwrapped).__name__
                raise TegotaeError(f"{self.name} cannot be tested: a {kind} has no {field}")

    @classmethod
    def of(cls, runs: ControllerSet, starts: int = 4) -> ControllersUnderTest:
        """The runs of a set, without duplicates, ready for a test."""
        _, first = np.unique(runs.weights, axis=0, return_index=True)
        kept = np.sort(first)
        labels = tuple(runs.labels[i] for i in kept)
        chosen = dataclasses.replace(runs, weights=runs.weights[kept], labels=labels)
        return cls(chosen, starts if runs.body.limbs > 1 else 1)

    def lacks(self, disturbance: Disturbance) -> str:
        """Why a disturbance does not apply; empty if it does."""
        return disturbance.lacks(self)

    @property
    def document(self) -> JsonObject:
        """What decides what is found, beside the disturbances, as JSON values."""
        document: JsonObject = {
            "controller": describe(self.controller),
            "starts": self.starts,
            "omega": self.omega,
            "body": describe(self.body),
            "timing": describe(self.timing),
        }
        # Older records have neither, for they were all of the usual ones.
        integrator, release = self.system.integrator, self.system.release
        if integrator != PredictorCorrector():
            document["integrator"] = describe(integrator)
        if release != Release():
            document["release"] = describe(release)
        return document

    @property
    def name(self) -> str:
        """Of the set."""
        return self.controllers.name

    @property
    def weights(self) -> np.ndarray:
        """Of the runs, [runs, n_weights]."""
        return self.controllers.weights

    @property
    def system(self) -> System:
        """The closed loop that the runs share, as they were trained."""
        return self.controllers.system

    @property
    def controller(self) -> Controller:
        """The structure that the runs share."""
        return self.system.controller

    @property
    def omega(self) -> float | None:
        """The frequency they were trained at [rad/s]; None without an oscillator."""
        return self.system.omega

    @property
    def body(self) -> Body:
        """The body they were trained on."""
        return self.system.mechanics

    def replaced(self, **changes: object) -> ControllersUnderTest:
        """The same runs in another system: other fields of the system or its release."""
        return dataclasses.replace(self, controllers=self.controllers.replaced(**changes))

    def meeting(self, longest_delay_s: float) -> ControllersUnderTest:
        """The same, whose senses can be late by so much."""
        if longest_delay_s <= self.longest_delay_s:
            return self
        return dataclasses.replace(self, longest_delay_s=longest_delay_s)

    @property
    def unwrapped(self) -> Body:
        """The body within all that is around it."""
        return unwrapped(self.body)

    @property
    def hops(self) -> bool:
        """Whether it is one leg, of which hops are counted; several have a gait."""
        return self.body.limbs == 1

    @property
    def takes_forces(self) -> bool:
        """Whether its actuators take forces, and not places of feet."""
        return self.body.COMMANDS == FORCE

    @cached_property
    def timing(self) -> Timing:
        """How long it is looked at, and how closely."""
        if self.looked_at is not None:
            return self.looked_at
        own = self.system.timing
        if not self.hops:
            return dataclasses.replace(own, duration_s=settling_s(self.body))
        frames = round(HOPPING.n_frames * self.time_scale)
        return dataclasses.replace(
            HOPPING,
            duration_s=frames * HOPPING.frame_s,
            tick_s=self.system.period_s(HOPPING.tick_s),
        )

    @property
    def height_m(self) -> float:
        """From which height it is released [m]."""
        return self.system.release.height_m

    @property
    def reference(self) -> int:
        """The leg that lags are measured from."""
        return reference_leg(leg_names(self.body))

    @cached_property
    def phase_rad(self) -> np.ndarray:
        """Phases of the oscillators at each release [rad], [(limbs,) starts]."""
        shape = (*self.body.limb_shape, self.starts)
        if self.hops:
            return np.full(shape, self.system.release.phase_rad)
        return np.random.default_rng(0).uniform(0.0, 2.0 * np.pi, shape[::-1]).T

    @property
    def time_scale(self) -> float:
        """√(l0 / g) of the body over that of a leg of a metre on Earth: 1 for the hopper."""
        own = self.unwrapped
        gravity = float(getattr(own, "gravity_m_per_s2", 9.81))
        return math.sqrt(float(own.rest_length_m) / gravity) / _EARTH_S

    @property
    def speed_scale(self) -> float:
        """√(g l0) of the body over that of a leg of a metre on Earth: 1 for the hopper."""
        return float(self.unwrapped.rest_length_m) / self.time_scale

    @property
    def _ticks(self) -> int:
        return math.ceil(self.longest_delay_s * self.time_scale / self.timing.tick_s - 1e-6)

    @cached_property
    def prepared(self) -> Body:
        """The body with senses, actuators and blows around it, and a slope and rough ground under
        it if it knows of terrain, which all change nothing as they are."""
        body = self.body
        for kind, given in ((Blows, {}), (Actuators, {}), (Sensors, {"most_ticks": self._ticks})):
            if not self.has(kind, body):
                body = kind(body=body, **given)
        if (own := getattr(self.unwrapped, "terrain", None)) is not None:
            ground = Sum(first=own, second=Sum(first=Slope(), second=Rough(start_m=0.0)))
            body = with_fields(body, {"terrain": ground})
        return body

    @staticmethod
    def has(kind: type, body: Body) -> bool:
        """Whether a body has one of this kind around it."""
        while isinstance(body, BodyWrapper):
            if isinstance(body, kind):
                return True
            body = body.body
        return False

    def has_field(self, name: str) -> bool:
        """Whether the prepared body has a field of this name.

        Example:
            >>> from tegotae.systems.models import build
            >>> system = System(controller=build("V-reflex-w8"), omega=8.0)
            >>> leg = ControllersUnderTest(ControllerSet("V", system, np.ones((1, 1)), ("0",)))
            >>> leg.has_field("delay_s"), leg.has_field("mass_kg"), leg.has_field("present")
            (True, True, False)
        """
        return name in paths_of(self.prepared)

    def usual(self, name: str) -> LaneNumbers:
        """A field of the prepared body as it is: a number, or a tuple of the legs' numbers."""
        return value_of(self.prepared, name)
