"""Controllers that were trained on a MuJoCo model, under the disturbances that this can have."""

from __future__ import annotations

import copy
import dataclasses
import math
from collections.abc import Callable, Mapping, Sequence
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
from tegotae.envs.mujoco.settings import ModelSettings
from tegotae.envs.wrapper import Pilot
from tegotae.parts._shapes import LaneNumbers
from tegotae.simulation.schedules import SecondClock, schedule_of
from tegotae.simulation.world import OMEGA
from tegotae.training.environments.experiment import EnvExperiment
from tegotae.training.environments.rollouts import LanePilot, ModelLanes, Seeds, play

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
        lanes = ModelLanes(self.settings, 1)
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

    @property
    def settings(self) -> ModelSettings:
        """Settings of the model, in episodes of the experiment's duration."""
        experiment = self.experiment
        return dataclasses.replace(experiment.spec.model_settings, duration_s=experiment.duration_s)

    def shares_kept(self, disturbances: Sequence[Disturbance]) -> dict[str, np.ndarray]:
        """See `Tested.kept`; every run, level and start is played at once."""
        size, experiment = self.size, self.experiment
        weights = np.repeat(self.weights, self.starts, axis=0).astype(np.float32)

        def piloted(omega: np.ndarray) -> Pilot:
            count = len(omega)
            pilot = Pilot(
                experiment.wires, experiment.wiring, np.tile(weights, (count // size, 1)).T
            )
            pilot.restart(np.ones(count, bool), omega)
            return pilot

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
        self, disturbances: Sequence[Disturbance], pilot: Callable[[np.ndarray], LanePilot]
    ) -> dict[str, np.ndarray]:
        """An episode of every lane: undisturbed, then level by level, [(1 + levels) size] each.

        Args:
            disturbances: what is met.
            pilot: makes of the frequencies of all lanes [rad/s] what drives them.

        Returns:
            `lasted`, `ahead_m_per_s`, `bounce_m`, `power_w`, and `weight` as a share of the usual.
        """
        at_s = np.full(self.size, EVENT_SHARE * self.experiment.duration_s)
        encounters = [self.undisturbed(disturbances), *self.disturbed(disturbances, at_s)]
        count = sum(encounter.lanes for encounter in encounters)
        usual = of_lanes({**vars(self.body), OMEGA: self.omega or 0.0}, count, "float64")
        changes = usual | joined(self, disturbances, encounters)
        wires = self.experiment.wires
        driven = _LatePilot(pilot(changes[OMEGA]), self.experiment, changes)
        start = np.arange(count) % self.starts
        unseen = _UNSEEN if self.starts_differ else 0
        lanes = _PerturbedLanes(self.settings, self.body, changes)
        entries = ("root_forward", "root_height", "work")
        try:
            seeds = self.experiment.seed + unseen + start
            record = play(lanes, driven, wires, seed=seeds, entries=entries)
            lasted = (record.ended == lanes.steps) & lanes.truncated
        finally:
            lanes.close()
        late = round((1.0 - MEASURED_SHARE) * lanes.steps)
        span_s = (lanes.steps - 1 - late) * wires.step_s
        ahead, height, work = (record.entry(name).astype(float) for name in entries)
        return {
            "lasted": lasted,
            "ahead_m_per_s": (ahead[-1] - ahead[late]) / span_s,
            "bounce_m": height[late:].std(axis=0),
            "power_w": (work[-1] - work[late]) / span_s,
            "weight": lanes.mass * lanes.gravity,
        }


class _PerturbedLanes(ModelLanes):
    """Lanes of a model with masses, frictions and gravities of their own, which are pushed.

    Args:
        settings: of the model.
        body: the usual model.
        changes: of all lanes, by name.
    """

    def __init__(
        self, settings: ModelSettings, body: MujocoModel, changes: Mapping[str, LaneNumbers]
    ) -> None:
        self.mass = changes["mass_kg"] / body.mass_kg
        self.gravity = changes["gravity_m_per_s2"] / body.gravity_m_per_s2
        models = _models(settings, self.mass, changes["friction"], self.gravity)
        super().__init__(settings, len(models), models=models)
        self._changes, self._done = changes, 0

    def reset(self, seed: Seeds, where: np.ndarray) -> np.ndarray:
        """Begin an episode of some lanes."""
        self._done = 0
        return super().reset(seed, where)

    def step(
        self, actions: np.ndarray, alive: np.ndarray, push_n: np.ndarray | None = None
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Step every lane that is alive, under its outer forces."""
        step_s = self.batch.step_s
        middle, self._done = SecondClock((self._done + 0.5) * step_s), self._done + 1
        return super().step(actions, alive, _push(self._changes, middle, step_s))


def _models(
    settings: ModelSettings, mass: np.ndarray, friction: np.ndarray, gravity: np.ndarray
) -> list[Any]:
    """Return a model for each lane; lanes that are alike share one."""
    nominal = sensing(settings).model
    variants: dict[tuple[float, float, float], Any] = {(1.0, 1.0, 1.0): nominal}
    models = []
    for key in zip(mass.tolist(), friction.tolist(), gravity.tolist(), strict=True):
        if key not in variants:
            variants[key] = copy.copy(nominal)
            variants[key].opt.gravity[:] *= key[2]
            scale_model(variants[key], key[0], key[1])
        models.append(variants[key])
    return models


def _push(
    changes: Mapping[str, LaneNumbers], clock: SecondClock, step_s: float
) -> np.ndarray | None:
    """External forces on the first body during a step with this middle [N]; None without any."""
    force = [schedule_of(changes[name]).at(clock, 0.0) for name in _PUSHES]
    since_s = clock.since_s(changes["at_s"])
    strikes = (since_s >= 0.0) & (since_s < step_s)
    force[2] = force[2] + changes["impulse_ns"] / step_s * strikes
    push = np.stack(force, axis=1)
    return push if push.any() else None


class _LatePilot:
    """A pilot whose limbs feel late and with noise.

    Args:
        pilot: what drives the lanes.
        experiment: whose wiring says what the limbs feel.
        changes: of all lanes: `delay_s` [s], interpolated between control periods; `noise`, its
            standard deviation over the scale of the sense; and the `seed` of the noise.
    """

    def __init__(
        self, pilot: LanePilot, experiment: EnvExperiment, changes: Mapping[str, LaneNumbers]
    ) -> None:
        wires, scales = experiment.wires, experiment.wiring.scales
        self._pilot = pilot
        self._scale_of = {
            int(i): float(scales.get(name, 1.0))
            for name, (places, _) in wires.sensed.items()
            for i in places
        }
        self._steps, self._noise = changes["delay_s"] / wires.step_s, changes["noise"]
        self._seed = changes["seed"]
        self.reset()

    @property
    def phase(self) -> np.ndarray:
        """Phases [rad], [limbs, lanes]."""
        return self._pilot.phase

    def reset(self) -> None:
        """Begin an episode, with nothing felt yet."""
        self._pilot.reset()
        self._random = [np.random.default_rng(int(lane_seed)) for lane_seed in self._seed]
        self._past: list[np.ndarray] = []

    def act(self, observed: np.ndarray) -> np.ndarray:
        """Return the actions for observations [lanes, entries], as they are felt."""
        return self._pilot.act(self._felt(observed))

    def _felt(self, observed: np.ndarray) -> np.ndarray:
        """Return the delayed and noisy senses for observations [lanes, entries]."""
        if not self._steps.any() and not self._noise.any():
            return observed
        longest = math.ceil(self._steps.max()) + 1
        self._past = [observed.copy(), *self._past[:longest]]
        felt = observed.copy()
        last = len(self._past) - 1
        near = np.minimum(np.floor(self._steps).astype(int), last)
        part = self._steps - np.floor(self._steps)
        past, lane = np.stack(self._past), np.arange(len(observed))
        far = np.minimum(near + 1, last)
        for entry, scale in self._scale_of.items():
            delayed = (1.0 - part) * past[near, lane, entry] + part * past[far, lane, entry]
            drawn = [generator.standard_normal() for generator in self._random]
            felt[:, entry] = delayed + self._noise * scale * np.array(drawn)
        return felt
