"""Controllers in another simulator, under the disturbances that this can have."""

from __future__ import annotations

import copy
import dataclasses
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, partial

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
from tegotae.envs._types import MjModel
from tegotae.envs.mujoco.env import ModelLanes
from tegotae.envs.mujoco.sensing import scale_model, sensing
from tegotae.envs.mujoco.settings import ModelSettings
from tegotae.envs.wrapper import Pilot
from tegotae.parts._shapes import LaneNumbers
from tegotae.simulation.schedules import SecondClock, schedule_of
from tegotae.simulation.world import OMEGA
from tegotae.training.environments.experiment import EnvExperiment
from tegotae.training.environments.rollouts import (
    LanePilot,
    Lanes,
    environment_lanes,
    play,
)

_PUSHES = ("push_x_n", "push_y_n", "push_z_n")
"""Forces on the first body, which may change during an episode."""
_NOT_NEGATIVE = (
    *("mass_kg", "gravity_m_per_s2", "friction", "strength", "lag_s", "delay_s", "noise"),
)
"""Numbers that are never below zero."""
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
class EnvBody:
    """A body in another simulator as disturbances see it: numbers that it has or could have."""

    limbs: int
    rest_length_m: float = 1.0
    gravity_m_per_s2: float = 9.81
    strength: float = 1.0
    lag_s: float = 0.0
    delay_s: float = 0.0
    noise: float = 0.0
    seed: float = 0.0

    @property
    def touching_height_m(self) -> float:
        """Height at touchdown [m]."""
        return self.rest_length_m


@dataclass(frozen=True)
class MujocoModel(EnvBody):
    """A MuJoCo model as disturbances see it."""

    mass_kg: float = 1.0
    friction: float = 1.0
    slope: float = 0.0
    push_x_n: float = 0.0
    push_y_n: float = 0.0
    push_z_n: float = 0.0
    impulse_ns: float = 0.0
    at_s: float = math.inf


@dataclass(frozen=True)
class EnvironmentUnderTest(Tested):
    """A set of controllers under test in the environment of their training.

    Args:
        controllers: the runs of one training.
        starts: from how many starts each is tried, where they differ; none of them is one of the
            training.

    Raises:
        TegotaeError: for runs that were trained elsewhere, or where neither distance nor height is
            observed.
    """

    SCHEDULED = frozenset(_PUSHES)
    SLOPE = "slope"

    def __post_init__(self) -> None:
        forward, height, _ = self.observed
        if forward is None and height is None:
            raise TegotaeError(
                f"{self.experiment.spec.env} does not say how far or high the body is; name the "
                "observation of its height in the wiring: height"
            )

    @property
    def CHANGED(self) -> frozenset[str]:  # type: ignore[override]  # noqa: N802
        """Names of the quantities that can be changed."""
        fixed = {"limbs", "rest_length_m"} | (set() if self.is_model else {"gravity_m_per_s2"})
        return frozenset(vars(self.body)) - fixed | {OMEGA}

    @property
    def kind(self) -> str:
        return "MuJoCo model" if self.is_model else "Gymnasium environment"

    @property
    def is_model(self) -> bool:
        """True for a MuJoCo model, whose masses and forces can be changed."""
        return self.experiment.spec.is_model

    @property
    def takes_forces(self) -> bool:
        return self.controller.actuation.commands_force

    @property
    def starts_differ(self) -> bool:
        return not self.is_model or self.experiment.spec.model_settings.noise > 0.0

    @cached_property
    def experiment(self) -> EnvExperiment:
        """Experiment of the training."""
        return EnvExperiment.from_controller(self.controllers)

    @cached_property
    def observed(self) -> tuple[str | None, str | None, str | None]:
        """Names of the observed distance ahead [m], height [m] and work [J]; None without one."""
        wiring, names = self.experiment.wiring, self.experiment.wires.observed

        def first(*candidates: str | None) -> str | None:
            return next((name for name in candidates if name in names), None)

        height = first("root_height", wiring.height)
        return first("root_forward"), height, first("work", wiring.work)

    @cached_property
    def body(self) -> EnvBody:  # type: ignore[override]
        """The body, for the disturbances."""
        wiring, limbs = self.experiment.wiring, self.controller.limbs
        length = None if wiring.rest_length_m is None else float(wiring.rest_length_m)
        if not self.is_model:
            return EnvBody(limbs, 1.0 if length is None else length)
        sensed = sensing(self.experiment.spec.model_settings)
        lanes = environment_lanes(self.experiment, 1)
        height = lanes.reset(self.experiment.seed, np.ones(1, bool))
        lanes.close()
        start = float(height[0, sensed.names.index("root_height")])
        return MujocoModel(
            limbs=limbs,
            rest_length_m=start if length is None else length,
            gravity_m_per_s2=float(np.linalg.norm(sensed.model.opt.gravity)) or 9.81,
            mass_kg=float(sensed.model.body_mass.sum()),
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
                for name in _NOT_NEGATIVE:
                    value = float(np.ravel(changes.get(name, 1.0))[0])  # type: ignore[arg-type]
                    if value < 0.0 or (name == "mass_kg" and value == 0.0):
                        raise TegotaeError(
                            f"{disturbance.name}={level:g} on {self.name}: {name} would be "
                            f"{value:g}"
                        )

    def shares_kept(self, disturbances: Sequence[Disturbance]) -> dict[str, np.ndarray]:
        """See `Tested.shares_kept`; every run, level and start is played at once."""
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
        """Play an episode of every lane: undisturbed, then level by level, [(1 + levels) size]
        each.

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
        wires, steps = self.experiment.wires, 0
        driven = _PerturbedPilot(pilot(changes[OMEGA]), self.experiment, changes)
        unseen = _UNSEEN if self.starts_differ else 0
        seeds = self.experiment.seed + unseen + np.arange(count) % self.starts
        lanes = self._lanes(changes)
        try:
            entries = tuple(dict.fromkeys(filter(None, self.observed)))
            record = play(lanes, driven, wires, seed=seeds, entries=entries)
            steps = lanes.steps
        finally:
            lanes.close()
        late = round((1.0 - MEASURED_SHARE) * steps)
        span_s = (steps - 1 - late) * wires.step_s
        ahead, height, work = (
            np.full((steps, count), np.nan) if name is None else record.entry(name).astype(float)
            for name in self.observed
        )
        return {
            "lasted": record.completed,
            "ahead_m_per_s": (ahead[-1] - ahead[late]) / span_s,
            "bounce_m": height[late:].std(axis=0),
            "power_w": (work[-1] - work[late]) / span_s,
            "weight": self.weight_ratio(encounters),
        }

    def _lanes(self, changes: Mapping[str, LaneNumbers]) -> Lanes:
        """Return the lanes of the environment under their changes."""
        experiment, count = self.experiment, len(changes[OMEGA])
        if not self.is_model:
            return environment_lanes(experiment, count)
        settings = dataclasses.replace(
            experiment.spec.model_settings, duration_s=experiment.duration_s
        )
        push = partial(_push, changes, experiment.wires.step_s)
        return ModelLanes(settings, count, models=self._models(settings, changes), push=push)

    def _models(self, settings: ModelSettings, changes: Mapping[str, LaneNumbers]) -> list[MjModel]:
        """Return a model for each lane; lanes that are alike share one."""
        nominal, body = sensing(settings).model, self.body
        assert isinstance(body, MujocoModel)
        ratios = (
            changes["mass_kg"] / body.mass_kg,
            changes["friction"],
            changes["gravity_m_per_s2"] / body.gravity_m_per_s2,
            changes["slope"],
        )
        variants: dict[tuple[float, ...], MjModel] = {(1.0, 1.0, 1.0, 0.0): nominal}
        models = []
        for key in zip(*(ratio.tolist() for ratio in ratios), strict=True):
            if key not in variants:
                mass, friction, gravity, slope = key
                variants[key] = copy.copy(nominal)
                scale_model(variants[key], mass, friction)
                variants[key].opt.gravity[:] = gravity * _on_slope(nominal.opt.gravity, slope)
            models.append(variants[key])
        return models


def _on_slope(gravity: np.ndarray, slope: float) -> np.ndarray:
    """Return gravity in the axes of ground that rises ahead by the slope per length.

    A level floor under this gravity is that ground: heights are measured across it.
    """
    if slope == 0.0:
        return gravity
    angle = math.atan(slope)
    turn = np.array([[math.cos(angle), math.sin(angle)], [-math.sin(angle), math.cos(angle)]])
    turned = gravity.copy()
    turned[[0, 2]] = turn @ gravity[[0, 2]]
    return turned


def _push(changes: Mapping[str, LaneNumbers], step_s: float, middle_s: float) -> np.ndarray | None:
    """Return the external forces on the first body in a step with this middle [N], or None
    without any.
    """
    clock = SecondClock(middle_s)
    force = [schedule_of(changes[name]).at(clock, 0.0) for name in _PUSHES]
    since_s = clock.since_s(changes["at_s"])
    strikes = (since_s >= 0.0) & (since_s < step_s)
    force[2] = force[2] + changes["impulse_ns"] / step_s * strikes
    push = np.stack(force, axis=1)
    return push if push.any() else None


class _PerturbedPilot:
    """A pilot whose limbs feel late and with noise, and whose actuators lag and are weak.

    Args:
        pilot: what drives the lanes.
        experiment: whose wiring says what the limbs feel and move.
        changes: of all lanes: `delay_s` [s], interpolated between control periods; `noise`, its
            standard deviation over the scale of the sense, and the `seed` of the noise;
            `strength`, the share of the actuators' forces that arrives, and `lag_s`, the time
            constant of their first-order lag [s].
    """

    def __init__(
        self, pilot: LanePilot, experiment: EnvExperiment, changes: Mapping[str, LaneNumbers]
    ) -> None:
        wires, scales = experiment.wires, experiment.wiring.scales
        self._pilot, self._wires = pilot, wires
        self._scale_of = {
            int(i): float(scales.get(name, 1.0))
            for name, (places, _) in wires.sensed.items()
            for i in places
        }
        self._steps, self._noise = changes["delay_s"] / wires.step_s, changes["noise"]
        self._seed, self._strength = changes["seed"], changes["strength"][:, None]
        lag_s = changes["lag_s"][:, None]
        self._late = lag_s > 0.0
        self._rate = wires.step_s / np.where(self._late, lag_s, 1.0)
        self._forces = experiment.controller.actuation.commands_force
        self.reset()

    @property
    def phase(self) -> np.ndarray:
        """Phases [rad], [limbs, lanes]."""
        return self._pilot.phase

    def reset(self) -> None:
        """Begin an episode, before any observation and command."""
        self._pilot.reset()
        self._random = [np.random.default_rng(int(lane_seed)) for lane_seed in self._seed]
        self._past: list[np.ndarray] = []
        self._reached: np.ndarray | None = None

    def act(self, observed: np.ndarray) -> np.ndarray:
        """Return the actions that arrive, for observations [lanes, entries] as they are felt."""
        action = self._pilot.act(self._felt(observed))
        if self._forces and (self._strength != 1.0).any():
            (driven,), rest = self._wires.driven, self._wires.rest
            action[:, driven] = rest + self._strength * (action[:, driven] - rest)
        return self._followed(action) if self._late.any() else action

    def _followed(self, aim: np.ndarray) -> np.ndarray:
        """Return the delivered actions of lagging actuators, as
        `tegotae.parts.bodies.Actuators`.
        """
        reached = aim if self._reached is None else self._reached
        gone, far = -np.expm1(-self._rate), aim - reached
        self._reached = reached + far * gone
        arrives = reached + far * (1.0 - gone / self._rate) if self._forces else self._reached
        followed, driven = aim.copy(), np.concatenate(self._wires.driven)
        followed[:, driven] = np.where(self._late, arrives, aim)[:, driven]
        return followed

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
