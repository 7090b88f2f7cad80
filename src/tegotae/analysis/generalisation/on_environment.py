"""Controllers that were trained on a MuJoCo model, under the disturbances that this can have."""

from __future__ import annotations

import copy
import dataclasses
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from tegotae._support.documents import JsonObject
from tegotae._support.errors import TegotaeError
from tegotae.analysis.generalisation.disturbances import Disturbance, Tested, joined, of_lanes
from tegotae.analysis.generalisation.retention import (
    EVENT_SHARE,
    MEASURED_SHARE,
    STANDING_SHARE,
    retained,
)
from tegotae.envs.mujoco.sensing import scale_model, sensing
from tegotae.envs.wrapper import Pilot
from tegotae.parts._shapes import LaneNumbers
from tegotae.simulation.schedules import SecondClock, schedule_of
from tegotae.simulation.world import OMEGA
from tegotae.training.environments.experiment import EnvExperiment
from tegotae.training.environments.rollouts import ModelLanes

_PUSHES = ("push_x_n", "push_y_n", "push_z_n")
"""Forces on the first body, which may change during an episode."""
_UNSEEN = 1000
"""Starts under test are as far from those of the training, by the seed of their noise."""
_WALKS = 0.05
"""Speed above which a body counts as walking, over √(g l)."""
_HOPS = 0.01
"""Standard deviation of its height above which a body counts as hopping, over its height at the
start."""
_KEEPS = 0.5
"""A gait is kept with this share of the usual speed, or bounce in place, at least."""


@dataclass(frozen=True)
class MujocoModel:
    """A MuJoCo model as disturbances see it: numbers that it has or could have."""

    mass_kg: float
    gravity_m_per_s2: float
    rest_length_m: float
    limbs: int
    friction: float = 1.0
    push_x_n: float = 0.0
    push_y_n: float = 0.0
    push_z_n: float = 0.0
    impulse_ns: float = 0.0
    at_s: float = math.inf
    delay_s: float = 0.0
    noise: float = 0.0
    seed: float = 0.0

    @property
    def touching_height_m(self) -> float:
        """Height at touchdown [m]."""
        return self.rest_length_m


@dataclass(frozen=True)
class ModelUnderTest(Tested):
    """A set of controllers on the MuJoCo model of its training, and how it is tried.

    Args:
        controllers: the runs of one training.
        starts: from how many starts each is tried, where the environment has noise; none of them
            is one of the training.

    Raises:
        TegotaeError: for runs that were trained on another kind of environment, or elsewhere.
    """

    CHANGED = frozenset(
        (
            *("mass_kg", "gravity_m_per_s2", "friction", *_PUSHES, "impulse_ns"),
            *("at_s", "delay_s", "noise", "seed", "omega"),
        )
    )
    SCHEDULED = frozenset(_PUSHES)
    kind = "MuJoCo model"  # type: ignore[assignment]

    def __post_init__(self) -> None:
        if not self.experiment.spec.is_model:
            raise TegotaeError(
                f"{self.experiment.spec.env} is no MuJoCo model, whose mass or friction could be "
                "changed; make it with other settings: tegotae evaluate --settings"
            )

    @property
    def starts_differ(self) -> bool:
        return self.experiment.spec.model_settings.noise > 0.0

    @cached_property
    def experiment(self) -> EnvExperiment:
        """Experiment of the training."""
        return EnvExperiment.from_controller(self.controllers)

    @cached_property
    def body(self) -> MujocoModel:  # type: ignore[override]
        """The MuJoCo model, for the disturbances."""
        sensed = sensing(self.experiment.spec.model_settings)
        gravity = float(np.linalg.norm(sensed.model.opt.gravity)) or 9.81
        lanes = self._lanes(1)
        height = lanes.reset(self.experiment.seed, np.ones(1, bool))
        lanes.close()
        length = float(height[0, sensed.names.index("root_height")])
        wiring = self.experiment.wiring
        return MujocoModel(
            mass_kg=float(sensed.model.body_mass.sum()),
            gravity_m_per_s2=gravity,
            rest_length_m=length if wiring.rest_length_m is None else float(wiring.rest_length_m),
            limbs=self.controller.limbs,
        )

    @property
    def height_m(self) -> float:
        return self.body.rest_length_m

    @property
    def time_scale(self) -> float:
        return math.sqrt(self.body.rest_length_m / self.body.gravity_m_per_s2 * 9.81)

    @property
    def document(self) -> JsonObject:
        return {"experiment": self.experiment.document, "starts": self.starts}

    def check(self, disturbances: Sequence[Disturbance]) -> None:
        for disturbance in disturbances:
            for level in disturbance.levels:
                changes = disturbance.changes(self, np.array([level]), np.zeros(1))
                for name in ("mass_kg", "gravity_m_per_s2", "friction", "delay_s", "noise"):
                    value = float(np.ravel(changes.get(name, 1.0))[0])  # type: ignore[arg-type]
                    if value < 0.0 or (name == "mass_kg" and value == 0.0):
                        raise TegotaeError(
                            f"{disturbance.name}={level:g} on {self.name}: {name} would be "
                            f"{value:g}"
                        )

    def _lanes(self, count: int, models: Sequence[Any] | None = None) -> ModelLanes:
        experiment = self.experiment
        settings = dataclasses.replace(
            experiment.spec.model_settings, duration_s=experiment.duration_s
        )
        return ModelLanes(settings, count, models=models)

    def shares_kept(self, disturbances: Sequence[Disturbance]) -> dict[str, np.ndarray]:
        """See `Tested.kept`; every run, level and start is played at once."""
        size = self.size
        weights = np.repeat(self.weights, self.starts, axis=0).astype(np.float32)

        def piloted(omega: np.ndarray) -> LanePolicy:
            count, experiment = len(omega), self.experiment
            pilot = Pilot(
                experiment.wires, experiment.wiring, np.tile(weights, (count // size, 1)).T
            )
            pilot.restart(np.ones(count, bool), omega)
            return pilot.act

        played = self.played(disturbances, piloted)
        baseline = {name: x[:size] for name, x in played.items()}
        disturbed = {name: x[size:].reshape(-1, size) for name, x in played.items()}
        length = self.body.rest_length_m
        walks = baseline["ahead_m_per_s"] > _WALKS * math.sqrt(self.body.gravity_m_per_s2 * length)
        hops = baseline["bounce_m"] > _HOPS * length
        moved = baseline["lasted"] & (walks | hops)
        with np.errstate(invalid="ignore", divide="ignore"):
            speed = disturbed["ahead_m_per_s"] / baseline["ahead_m_per_s"]
            share = np.where(walks, speed, disturbed["bounce_m"] / baseline["bounce_m"])
            efficiency = speed * disturbed["weight"] / baseline["weight"]
            efficiency *= baseline["power_w"] / disturbed["power_w"]
        moves = moved & disturbed["lasted"] & (share > STANDING_SHARE)
        of_walks = (np.where(walks, x, np.nan) for x in (efficiency, speed))
        return retained(moved, moved, moves, moves & (share >= _KEEPS), *of_walks)

    def played(
        self, disturbances: Sequence[Disturbance], pilot: PilotMaker
    ) -> dict[str, np.ndarray]:
        """An episode of every lane: undisturbed, then level by level, [(1 + levels) size] each.

        Args:
            disturbances: what is met.
            pilot: makes of the frequencies of all lanes [rad/s] what drives them: a function from
                observations [lanes, entries] to actions [lanes, actions].

        Returns:
            `lasted`, `ahead_m_per_s`, `bounce_m`, `power_w`, and `weight` as a share of the usual.
        """
        at_s = np.full(self.size, EVENT_SHARE * self.experiment.duration_s)
        encounters = [self.undisturbed(disturbances), *self.disturbed(disturbances, at_s)]
        count = sum(encounter.lanes for encounter in encounters)
        usual = of_lanes({**vars(self.body), OMEGA: self.omega or 0.0}, count, "float64")
        changes = usual | joined(self, disturbances, encounters)
        return _played(self, changes, pilot(changes[OMEGA]))


LanePolicy = Callable[[np.ndarray], np.ndarray]
"""Function from observations [lanes, entries] to actions [lanes, actions]."""
PilotMaker = Callable[[np.ndarray], LanePolicy]
"""Factory of a policy from the frequencies of all lanes [rad/s]."""


def _played(
    tested: ModelUnderTest, changes: dict[str, LaneNumbers], act: LanePolicy
) -> dict[str, np.ndarray]:
    """An episode of every lane under its changes, [lanes] each."""
    experiment, body, count = tested.experiment, tested.body, len(changes[OMEGA])
    wires, every = experiment.wires, np.ones(count, bool)
    mass = changes["mass_kg"] / body.mass_kg
    gravity = changes["gravity_m_per_s2"] / body.gravity_m_per_s2
    models = _models(tested, mass, changes["friction"], gravity)
    lanes = tested._lanes(count, models)
    start = np.arange(count) % tested.starts
    unseen = _UNSEEN if experiment.spec.model_settings.noise else 0
    observation = lanes.reset(experiment.seed + unseen + start, every)
    senses = _Senses(tested, changes["delay_s"], changes["noise"], changes["seed"])
    names, step_s = wires.observed, wires.step_s
    forward, height = names.index("root_forward"), names.index("root_height")
    late = round((1.0 - MEASURED_SHARE) * lanes.steps)
    alive = every.copy()
    track = np.zeros((lanes.steps, 3, count))
    try:
        for step in range(lanes.steps):
            push = _push(changes, SecondClock((step + 0.5) * step_s), step_s)
            observation, _, over = lanes.step(act(senses(observation)), alive, push_n=push)
            observation = np.nan_to_num(observation, posinf=0.0, neginf=0.0)
            track[step] = observation[:, forward], observation[:, height], observation[:, -1]
            alive &= ~(over & ~lanes.truncated)
    finally:
        lanes.close()
    span = (lanes.steps - 1 - late) * step_s
    return {
        "lasted": alive,
        "ahead_m_per_s": (track[-1, 0] - track[late, 0]) / span,
        "bounce_m": track[late:, 1].std(axis=0),
        "power_w": (track[-1, 2] - track[late, 2]) / span,
        "weight": mass * gravity,
    }


def _models(
    tested: ModelUnderTest, mass: np.ndarray, friction: np.ndarray, gravity: np.ndarray
) -> list[Any]:
    """A model a lane; lanes that are alike share one."""
    nominal = sensing(tested.experiment.spec.model_settings).model
    variants: dict[tuple[float, float, float], Any] = {(1.0, 1.0, 1.0): nominal}
    models = []
    for key in zip(mass.tolist(), friction.tolist(), gravity.tolist(), strict=True):
        if key not in variants:
            variants[key] = copy.copy(nominal)
            variants[key].opt.gravity[:] *= key[2]
            scale_model(variants[key], key[0], key[1])
        models.append(variants[key])
    return models


def _push(changes: dict[str, LaneNumbers], clock: SecondClock, step_s: float) -> np.ndarray | None:
    """External forces on the first body during a step with this middle [N]; None without any."""
    force = [schedule_of(changes[name]).at(clock, 0.0) for name in _PUSHES]
    since_s = clock.since_s(changes["at_s"])
    strikes = (since_s >= 0.0) & (since_s < step_s)
    force[2] = force[2] + changes["impulse_ns"] / step_s * strikes
    push = np.stack(force, axis=1)
    return push if push.any() else None


class _Senses:
    """Delayed and noisy senses of the limbs.

    Args:
        tested: the controllers.
        delay_s: of each lane [s], interpolated between control periods.
        noise: standard deviation over the scale of the sense, of each lane.
        seed: of the noise of each lane.
    """

    def __init__(
        self, tested: ModelUnderTest, delay_s: np.ndarray, noise: np.ndarray, seed: np.ndarray
    ) -> None:
        wires, scales = tested.experiment.wires, tested.experiment.wiring.scales
        self._at = {int(i): float(scales.get(name, 1.0))
                    for name, (places, _) in wires.sensed.items() for i in places}  # fmt: skip
        self._steps, self._noise = delay_s / wires.step_s, noise
        self._random = [np.random.default_rng(int(lane_seed)) for lane_seed in seed]
        self._past: list[np.ndarray] = []

    def __call__(self, observation: np.ndarray) -> np.ndarray:
        """Return the delayed and noisy senses for an observation [lanes, entries]."""
        if not self._steps.any() and not self._noise.any():
            return observation
        longest = math.ceil(self._steps.max()) + 1
        self._past = [observation.copy(), *self._past[:longest]]
        felt = observation.copy()
        last = len(self._past) - 1
        near = np.minimum(np.floor(self._steps).astype(int), last)
        part = self._steps - np.floor(self._steps)
        past, lane = np.stack(self._past), np.arange(len(observation))
        far = np.minimum(near + 1, last)
        for entry, scale in self._at.items():
            delayed = (1.0 - part) * past[near, lane, entry] + part * past[far, lane, entry]
            drawn = [generator.standard_normal() for generator in self._random]
            felt[:, entry] = delayed + self._noise * scale * np.array(drawn)
        return felt
