"""Controllers on bodies of this package under disturbances: lanes of one compiled program."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import jax
import numpy as np

from tegotae._support.documents import JsonObject
from tegotae._support.errors import TegotaeError
from tegotae.analysis.generalisation.disturbances import (
    Disturbance,
    Encounter,
    Tested,
    joined,
    of_lanes,
)
from tegotae.analysis.generalisation.retention import (
    EVENT_SHARE,
    GaitRetention,
    HopRetention,
    Walked,
)
from tegotae.measures.gaits.names import HEADING, leg_names, reference_leg
from tegotae.measures.gaits.summary import has_mass
from tegotae.parts._shapes import LaneNumbers
from tegotae.parts.bodies import Actuators, Blows, Body, BodyWrapper, Pushes, Sensors
from tegotae.parts.channels import FORCE
from tegotae.parts.fields import path_of, paths_of, replace, unwrapped
from tegotae.parts.terrains import Rough, Slope, Sum
from tegotae.simulation.draws import check_scenario
from tegotae.simulation.episode import LaneInputs
from tegotae.simulation.recorder import declared
from tegotae.simulation.rollout import Scenario, Timing, check_senses
from tegotae.simulation.timing import padded_lanes
from tegotae.simulation.world import ENTRIES, with_changes
from tegotae.systems.descriptions import describe
from tegotae.systems.legged import settling_s
from tegotae.systems.system import System

HOPPING = Timing(duration_s=32.0, tick_s=0.002)
"""Evaluation timing of a hopper with a leg of a metre on Earth: at 4 rad/s a cycle of two hops is
observed five times in the 20 s after a push."""
USUAL_DELAY_S = 0.032
"""So much of what was felt is kept in any case, for a leg of a metre on Earth [s]."""
MOST_TICKS = 128
"""The longest delay of the senses that is tried, in control ticks: all of it is kept."""
LANES = 512
"""Lanes that are measured together; the last ones are filled up."""

_EARTH_S = math.sqrt(1.0 / 9.81)


@dataclass(frozen=True)
class ControllersUnderTest(Tested):
    """A set of controllers under test on the body of their training.

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
        fields = {"rest_length_m": hasattr(self.unwrapped, "rest_length_m")}
        if not self.hops:  # whose cost of transport is measured
            fields["mass_kg"] = has_mass(self.unwrapped)
            fields["gravity_m_per_s2"] = hasattr(self.unwrapped, "gravity_m_per_s2")
        for field, exists in fields.items():
            if not exists:
                kind = type(self.unwrapped).__name__
                raise TegotaeError(f"{self.name} cannot be tested: a {kind} has no {field}")

    @property
    def document(self) -> JsonObject:
        """Return the settings that decide the results, beside the disturbances, as JSON values."""
        system = self.system
        parts = {"controller": system.controller, "body": self.body, "timing": self.timing}
        parts |= {"integrator": system.integrator, "release": system.release}
        described = {name: describe(part) for name, part in parts.items()}
        return {**described, "starts": self.starts, "omega": self.omega}

    @property
    def starts_differ(self) -> bool:
        return not self.hops

    @property
    def system(self) -> System:
        """The closed loop that the runs share, as they were trained."""
        return self.controllers.system

    @property
    def body(self) -> Body:
        return self.system.mechanics

    @property
    def unwrapped(self) -> Any:
        return unwrapped(self.body)

    @property
    def hops(self) -> bool:
        """True for one leg, whose hops are counted; several have a gait."""
        return self.body.limbs == 1

    @property
    def takes_forces(self) -> bool:
        return self.body.COMMANDS == FORCE

    @cached_property
    def timing(self) -> Timing:
        """Duration and time step of the rollouts."""
        if self.looked_at is not None:
            return self.looked_at
        timing = self.system.timing
        if not self.hops:
            return dataclasses.replace(timing, duration_s=settling_s(self.body))
        frames = round(HOPPING.n_frames * self.time_scale)
        return dataclasses.replace(
            HOPPING,
            duration_s=frames * HOPPING.frame_s,
            tick_s=self.system.period_s(HOPPING.tick_s),
        )

    @property
    def criterion(self) -> HopRetention | GaitRetention:
        """Criterion of a retained gait."""
        event_s = EVENT_SHARE * self.timing.duration_s
        if self.hops:
            path = path_of(self.prepared, "rest_length_m")
            return HopRetention(path, float(self.body.rest_length_m), event_s)
        pair = self.controller, self.prepared
        reference, looks = reference_leg(leg_names(self.body)), set(HEADING) <= {*declared(*pair)}
        return GaitRetention(Walked.on(*pair, reference=reference, looks=looks), event_s)

    @property
    def height_m(self) -> float:
        return self.system.release.height_m

    @cached_property
    def phase_rad(self) -> np.ndarray:
        """Phases of the oscillators at each release [rad], [(limbs,) starts]."""
        shape = (*self.body.limb_shape, self.starts)
        if self.hops:
            return np.full(shape, self.system.release.phase_rad)
        return np.random.default_rng(0).uniform(0.0, 2.0 * np.pi, shape[::-1]).T

    @property
    def time_scale(self) -> float:
        base = self.unwrapped
        gravity = float(getattr(base, "gravity_m_per_s2", 9.81))
        return math.sqrt(float(base.rest_length_m) / gravity) / _EARTH_S

    @cached_property
    def prepared(self) -> Body:  # type: ignore[override]
        """The body with senses, actuators, blows and pushes around it, and a slope and rough
        ground under it if it has terrain; none of these has an effect by default.
        """
        body = self.body
        ticks = math.ceil(self.longest_delay_s * self.time_scale / self.timing.tick_s - 1e-6)
        wrappers = [(Blows, {}), (Actuators, {}), (Sensors, {"most_ticks": ticks})]
        if "push_z_n" not in paths_of(body):
            wrappers.insert(1, (Pushes, {}))
        for kind, settings in wrappers:
            if not _has_wrapper(kind, body):
                body = kind(body=body, **settings)
        if (terrain := getattr(self.unwrapped, "terrain", None)) is not None:
            ground = Sum(first=terrain, second=Sum(first=Slope(), second=Rough(start_m=0.0)))
            body = replace(body, {"terrain": ground})
        return body

    def usual(self, name: str) -> LaneNumbers:
        return getattr(self.system.scenario(), name) if name in ENTRIES else super().usual(name)

    def meeting(self, disturbances: Sequence[Disturbance]) -> ControllersUnderTest:
        """Return these lanes with senses that can be as late as disturbances make them."""
        longest = max(disturbance.longest_delay_s for disturbance in disturbances)
        if longest <= self.longest_delay_s:
            return self
        return dataclasses.replace(self, longest_delay_s=longest)

    def check(self, disturbances: Sequence[Disturbance]) -> None:
        tested = self.meeting(disturbances)
        body, release = tested.prepared, tested.system.scenario()
        for disturbance in disturbances:
            for level in disturbance.levels:
                changes = disturbance.changes(tested, np.array([level]), np.zeros(1))
                try:
                    met = with_changes(release, body, changes)
                    check_scenario(met, body, tested.controller.oscillator, tested.timing)
                except TegotaeError as error:
                    raise TegotaeError(
                        f"{disturbance.name}={level:g} on {tested.name}: {error}"
                    ) from None

    def shares_kept(self, disturbances: Sequence[Disturbance]) -> dict[str, np.ndarray]:
        """See `Tested.shares_kept`.

        Every run is first tried as it is. What it does then says when a disturbance comes, and what
        there is to be kept.
        """
        check_senses(self.controller, self.body)
        tested = self.meeting(disturbances)
        criterion = tested.criterion
        baseline = tested.measured(disturbances, [tested.undisturbed(disturbances)])
        at_s = np.ravel(criterion.at_s(baseline))
        encounters = tested.disturbed(disturbances, at_s)
        disturbed = tested.measured(disturbances, encounters)
        ratio = tested.weight_ratio(encounters).reshape(-1, self.size)
        return criterion.shares_kept(baseline, disturbed, ratio)

    def measured(
        self, disturbances: Sequence[Disturbance], encounters: Sequence[Encounter]
    ) -> dict[str, np.ndarray]:
        """Measure the criterion at every level, arrays [..., levels, lanes of the set].

        Args:
            disturbances: all that may be met.
            encounters: the lanes, level by level.
        """
        criterion, scenario = self.criterion, self.scenario(disturbances, encounters)
        rollout = self.system.rollout(criterion.summary, self.timing)
        count = sum(encounter.lanes for encounter in encounters)
        levels = count // self.size
        weights = np.repeat(self.weights, self.starts, axis=0).T
        weights = np.tile(np.asarray(weights, "float32"), levels)
        parts = []
        for begin in range(0, count, LANES):
            block = slice(begin, begin + LANES)
            inputs = LaneInputs(
                weights[..., block], jax.tree.map(lambda x, lanes=block: x[..., lanes], scenario)
            )
            recorded = rollout.run_lanes(inputs, self.prepared)
            padded = padded_lanes((recorded, inputs.scenario), slice(None), LANES)
            parts.append(jax.tree.map(np.asarray, criterion.outcomes(*padded)))
        every = jax.tree.map(lambda *leaves: np.concatenate(leaves, axis=-1)[..., :count], *parts)
        return jax.tree.map(lambda x: x.reshape(*x.shape[:-1], levels, self.size), every)

    def scenario(
        self, disturbances: Sequence[Disturbance], encounters: Sequence[Encounter]
    ) -> Scenario:
        """Return the scenario of the lanes, with the values that any disturbance changes.

        Args:
            disturbances: all that may be met.
            encounters: the lanes, level by level.
        """
        phases = np.tile(self.phase_rad, len(self.weights))
        count = sum(encounter.lanes for encounter in encounters)
        release = of_lanes(self.system.scenario(phase_rad=phases), count)
        changes = joined(self, disturbances, encounters, "float32")
        return with_changes(release, self.prepared, changes)


def _has_wrapper(kind: type, body: Body) -> bool:
    """Return whether a body has a wrapper of this kind."""
    while isinstance(body, BodyWrapper):
        if isinstance(body, kind):
            return True
        body = body.body
    return False
