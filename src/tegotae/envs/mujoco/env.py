"""A MuJoCo model as an environment, alone and in batches."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from types import ModuleType

import gymnasium
import numpy as np
from gymnasium.spaces import Box
from numpy.typing import ArrayLike

from tegotae._support.engines import available_cores
from tegotae._support.errors import (
    TegotaeError,
    require,
    require_count,
    require_finite,
    require_known,
)
from tegotae.envs._types import Info, MjModel, Seeds
from tegotae.envs.command import CommandSchedule, heading_rate, over_feet
from tegotae.envs.mujoco.legs import AXES
from tegotae.envs.mujoco.sensing import Sensing, is_sound, sensing
from tegotae.envs.mujoco.settings import PACKAGED, ModelSettings
from tegotae.envs.scaling import gravity_m_per_s2
from tegotae.parts.channels import COMMANDED


class ModelBatch:
    """Lanes of a model, each with its own state: one call steps all of them (`mujoco.rollout`).

    Args:
        sensing: the model.
        lanes: how many.
        control_s: time for which an action is held [s]; a whole number of the model's time steps.
        models: other models of the same shape, one a lane, such as of other masses.
        threads: how many threads step them; one a core by default.

    Raises:
        TegotaeError: for a count below one, or a control period that is no multiple of the step.

    Example:
        >>> batch = ModelBatch(sensing(PACKAGED["hopper"]), 8, 0.01)  # doctest: +SKIP
        >>> batch.reset().shape  # doctest: +SKIP
        (8, 13)
    """

    def __init__(
        self,
        sensing: Sensing,
        lanes: int,
        control_s: float,
        *,
        models: Sequence[MjModel] | None = None,
        threads: int | None = None,
    ) -> None:
        require_count("lanes", lanes)
        mujoco, rollout = require("mujoco", "mujoco"), require("mujoco.rollout", "mujoco")
        self._mujoco, self.sensing, self.lanes = mujoco, sensing, lanes
        model = sensing.model
        self.ticks = _ticks_in(control_s, model.opt.timestep)
        self.step_s = self.ticks * float(model.opt.timestep)
        self._models = [model] * lanes if models is None else list(models)
        threads = min(available_cores(), lanes) if threads is None else threads
        self._data = [mujoco.MjData(model) for _ in range(max(1, threads))]
        # Without threads of its own it computes in this one.
        self._rollout = rollout.Rollout(nthread=threads if threads > 1 else 0)
        self._kind = mujoco.mjtState.mjSTATE_FULLPHYSICS
        self._control = mujoco.mjtState.mjSTATE_CTRL | mujoco.mjtState.mjSTATE_XFRC_APPLIED
        width = mujoco.mj_stateSize(model, self._kind)
        self._states = np.zeros((lanes, self.ticks, width))
        self._sensed = np.zeros((lanes, self.ticks, model.nsensordata))
        self._given = np.zeros((lanes, self.ticks, model.nu + 6 * model.nbody))
        self.work_j = np.zeros(lanes)
        """Absolute work of the actuators since the reset [J], [lanes]."""

    @property
    def states(self) -> np.ndarray:
        """The lanes' physics states (MuJoCo's `mjSTATE_FULLPHYSICS`), [lanes, numbers].

        Of use to draw a lane: `mj_setState(model, data, states[0], mjSTATE_FULLPHYSICS)`.
        """
        return self._states[:, -1].copy()

    def reset(
        self,
        height_m: ArrayLike = 0.0,
        noise: np.ndarray | None = None,
        where: np.ndarray | None = None,
    ) -> np.ndarray:
        """Reset the lanes to the model's start; return the observations of all, [lanes, entries].

        Args:
            height_m: by how much the first body begins higher than in the model [m], [lanes].
            noise: what is added to the joints' positions, [lanes, nv]; nothing by default.
            where: which lanes, [lanes]; all by default. The others stay as they are.
        """
        mujoco, model = self._mujoco, self.sensing.model
        rise = np.broadcast_to(height_m, (self.lanes,))
        begun = np.ones(self.lanes, bool) if where is None else np.asarray(where, bool)
        state = self.states
        data = self._data[0]
        for lane in map(int, np.flatnonzero(begun)):
            mujoco.mj_resetData(model, data)
            if model.nkey:
                mujoco.mj_resetDataKeyframe(model, data, 0)
            if noise is not None:
                mujoco.mj_integratePos(model, data.qpos, np.asarray(noise[lane], float), 1.0)
            data.qpos[_height_of(mujoco, model)] += rise[lane]
            mujoco.mj_getState(model, data, state[lane], self._kind)
        self.work_j = np.where(begun, 0.0, self.work_j)
        # The sensors of the start are those of a step that is not kept.
        self._given[begun] = 0.0
        self._given[begun, :, : model.nu] = self.sensing.held
        self._states[begun, -1] = state[begun]
        self._advance(begun)
        self._states[begun, -1] = state[begun]
        self._sensed[begun, -1] = self._sensed[begun, 0]
        return self.sensing.observed(self._sensed[:, -1])

    def step(
        self,
        action: np.ndarray,
        push_n: np.ndarray | None = None,
        where: np.ndarray | None = None,
    ) -> np.ndarray:
        """Advance the lanes by a control period; return the observations of all, [lanes, entries].

        Args:
            action: the actions by their names (`Sensing.actions`), [lanes, actions]; held.
            push_n: an external force on the first body [N], [lanes, 3]; none by default.
            where: which lanes, [lanes]; all by default. The others stand still, at no cost.
        """
        n = self.sensing.model.nu
        self._given[:, :, self.sensing.driven] = self.sensing.controls(action)[:, None]
        if push_n is not None:
            self._given[:, :, n + 6 : n + 9] = push_n[:, None]  # after the world's six numbers
        going = np.ones(self.lanes, bool) if where is None else np.asarray(where, bool)
        self._advance(going)
        if push_n is not None:
            self._given[:, :, n + 6 : n + 9] = 0.0
        tick_s = float(self.sensing.model.opt.timestep)
        power = np.abs(self.sensing.power(self._sensed)).sum(axis=(1, 2))
        self.work_j = self.work_j + np.where(going, tick_s * power, 0.0)
        return self.sensing.observed(self._sensed[:, -1])

    def _advance(self, where: np.ndarray) -> None:
        """Advance some lanes by a control period from their last states."""
        if not where.any():
            return
        # All lanes are advanced in place, and some as copies.
        lanes = slice(None) if where.all() else np.flatnonzero(where)
        states, sensed = self._states[lanes], self._sensed[lanes]
        self._rollout.rollout(
            [model for model, goes in zip(self._models, where, strict=True) if goes],
            self._data,
            states[:, -1].copy(),
            self._given[lanes],
            control_spec=int(self._control),
            nstep=self.ticks,
            skip_checks=True,
            state=states,
            sensordata=sensed,
            # One task a thread: to hand over a lane takes as long as to advance it.
            chunk_size=-(-len(states) // len(self._data)),
        )
        self._states[lanes], self._sensed[lanes] = states, sensed

    def close(self) -> None:
        """End the threads."""
        self._rollout.close()


def _ticks_in(control_s: float, tick_s: float) -> int:
    """Return the number of time steps in a control period.

    Raises:
        TegotaeError: if not a whole number of them, to a hundredth.

    Example:
        >>> _ticks_in(0.01, 0.002)
        5
    """
    require_finite("control_s", control_s, above=0.0)
    ratio = control_s / tick_s
    if round(ratio) < 1 or abs(ratio - round(ratio)) > 0.01:
        raise TegotaeError(
            f"control_s is {control_s:g} s; it must be a whole multiple of the model's time step "
            f"({tick_s:g} s)"
        )
    return round(ratio)


def _height_of(mujoco: ModuleType, model: MjModel) -> int:
    """Return the index of the first body's height among the positions."""
    for i in range(model.njnt):
        if model.jnt_bodyid[i] != 1:
            break
        if model.jnt_type[i] == mujoco.mjtJoint.mjJNT_FREE:
            return int(model.jnt_qposadr[i]) + 2
        if model.jnt_type[i] == mujoco.mjtJoint.mjJNT_SLIDE and model.jnt_axis[i][2] > 0.99:
            return int(model.jnt_qposadr[i])
    raise TegotaeError(
        "the model's first body can neither rise nor fall; give it a free joint or a vertical slide"
    )


class ModelLanes:
    """Lanes of a MuJoCo model, with the rewards and ends of their episodes (`ModelEnv`).

    Args:
        settings: of the model.
        lanes: how many.
        threads: how many threads step them; one a core by default.
        models: other models of the same shape, one a lane.
        schedule: commands of the lanes; those of the settings by default.
        push: external force on the first body [N], [lanes, 3], or None, by the time of a step's
            middle [s] since all lanes have begun.
    """

    def __init__(
        self,
        settings: ModelSettings,
        lanes: int,
        *,
        threads: int | None = None,
        models: Sequence[MjModel] | None = None,
        schedule: CommandSchedule | None = None,
        push: Callable[[float], np.ndarray | None] = lambda time_s: None,
    ) -> None:
        self._settings, self.lanes, self._push = settings, lanes, push
        self.sensing = sensing(settings)
        self.batch = ModelBatch(
            self.sensing, lanes, settings.control_s, threads=threads, models=models
        )
        self.steps = max(1, round(settings.duration_s / self.batch.step_s))
        self.troubles = [""] * lanes
        self.fallen = self.truncated = np.zeros(lanes, bool)
        names, model = self.sensing.names, self.sensing.model
        self._root = [names.index(f"root_{name}") for name in ("forward", "height", "upright")]
        self._weight_n = float(model.body_mass.sum()) * (gravity_m_per_s2(model) or 1.0)
        self._length_m, self._done = np.ones(lanes), np.zeros(lanes, int)
        self._was = np.zeros((2, lanes))  # forward [m] and work [J] at the last step
        self._heading = np.zeros((2, lanes))  # by the gyroscope, and the set-point [rad]
        self._yaw_rates = np.zeros(lanes)  # commanded [rad/s]
        self._yaw_rate = names.index("root_yaw_rate")
        self.names, self._feet_m = (*names, "work"), np.zeros((0, 2))
        if settings.command:
            assert self.sensing.legs is not None
            self._schedule = schedule or CommandSchedule.from_command(settings.command)
            self._feet_m, feet = self.sensing.legs.feet_m[:, :2], self.sensing.feet
            over = [f"{foot}_commanded_{axis}" for foot in feet for axis in AXES[:2]]
            self.names = (*self.names, *over, "commanded_speed", *COMMANDED, "root_heading")

    def reset(self, seed: Seeds, where: np.ndarray) -> np.ndarray:
        """Begin a new episode of some lanes; return the observations of all, [lanes, entries]."""
        settings, noise = self._settings, None
        if settings.noise:
            seeds = np.broadcast_to(np.asarray(seed), (self.lanes,))  # type: ignore[arg-type]
            starts, lane_of = np.unique(seeds, return_inverse=True)
            nv = self.sensing.model.nv
            drawn = [np.random.default_rng(start).standard_normal(nv) for start in starts]
            noise = settings.noise * np.stack(drawn)[lane_of]
        observation = self.batch.reset(settings.release_m, noise, where)
        forward, height, _ = observation[:, self._root].T
        self._length_m = np.where(
            where, np.maximum(height - settings.release_m, 1e-6), self._length_m
        )
        self._done = np.where(where, 0, self._done)
        self._heading = np.where(where, 0.0, self._heading)
        self._was = np.where(where, [forward, np.zeros(self.lanes)], self._was)
        for lane in np.flatnonzero(where):
            self.troubles[lane] = ""
        return self._observed(observation)

    def step(
        self, actions: np.ndarray, alive: np.ndarray, push_n: np.ndarray | None = None
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Advance every living lane by a step; the others stand still.

        Args:
            actions: commands, [lanes, actuators].
            alive: whose episode goes on, [lanes].
            push_n: an external force on the first body [N], [lanes, 3]; that of `push` by default.

        Returns:
            observations [lanes, entries], rewards and whether an episode is over, [lanes].
        """
        if push_n is None:
            push_n = self._push((self._done[0] + 0.5) * self.batch.step_s)
        observation, length = self.batch.step(actions, push_n, alive), self._length_m
        if len(self._feet_m):
            rates = observation[:, self._yaw_rate], self._yaw_rates
            self._heading = self._heading + self.batch.step_s * np.stack(rates)
        self._done = self._done + 1
        forward, height, upright = observation[:, self._root].T
        was, self._was = self._was, np.stack([forward, self.batch.work_j])
        went, spent = (self._was - was) / (length * np.array([[1.0], [self._weight_n]]))
        reward = went - self._settings.effort * spent
        sound = is_sound(observation).all(axis=1)
        low = height < self._settings.fallen_share * length
        self.fallen, over = low | (upright < 0.0) | ~sound, self._done >= self.steps
        self.truncated = over & ~self.fallen
        for lane in np.flatnonzero(alive & ~sound):
            self.troubles[lane] = "its state was not finite"
        return self._observed(observation), np.where(sound, reward, 0.0), self.fallen | over

    def _observed(self, observation: np.ndarray) -> np.ndarray:
        """Return the observations with work and commands."""
        columns = [observation, self.batch.work_j[:, None]]
        if len(self._feet_m):
            command = self._schedule.commands_at(self._done * self.batch.step_s)
            explicit, (heading, set_point) = command[:, 3], self._heading
            command[:, 3] = self._heading[1] = np.where(np.isnan(explicit), set_point, explicit)
            turning = command[:, :3].copy()
            turning[:, 2] += heading_rate(command[:, 3] - heading)
            over = over_feet(turning, self._feet_m)
            fastest = np.linalg.norm(over, axis=-1).max(axis=1, keepdims=True)
            columns += [over.reshape(self.lanes, -1), fastest, command, heading[:, None]]
            self._yaw_rates = command[:, 2]
        return np.concatenate(columns, axis=1)

    def close(self) -> None:
        """End the threads."""
        self.batch.close()


class ModelEnv(gymnasium.Env[np.ndarray, np.ndarray]):
    """A MuJoCo model: actuators are actions, and what a leg can feel is observed.

    Entries of observation and action have names (`tegotae.envs.mujoco.sensing.sensing`). The last
    one of the observation is `work`, the actuators' absolute work since the reset [J]. The reward
    is the distance of the first body, in lengths, less `effort` times the work over weight and
    length; the length is the body's height in the model.

    Args:
        settings: of the model; or its fields by name. `model="hopper"` alone is one that comes with
            the package, with its own settings for all that is not given.

    Raises:
        TegotaeError: for settings that cannot be used, or a model that cannot be read.
        MissingExtraError: without MuJoCo.

    Example:
        >>> env = ModelEnv(model="hopper", duration_s=1.0)  # doctest: +SKIP
        >>> env.observation_names[0]  # doctest: +SKIP
        'height'
    """

    metadata = {"render_modes": []}  # noqa: RUF012 - as Gymnasium has it

    def __init__(self, settings: ModelSettings | None = None, **fields: object) -> None:
        self.settings = model_settings_of(settings, fields)
        self._lanes = ModelLanes(self.settings, 1, threads=1)
        self.sensing = self._lanes.sensing
        self.model, self.dt = self.sensing.model, self._lanes.batch.step_s
        self.observation_names = self._lanes.names
        self.contact_names = self.sensing.contacts
        self.action_names = self.sensing.actions
        self.still_action = self.sensing.still
        self.force_limits = self.sensing.force_limits
        commands = len(self._lanes.names) - len(self.sensing.names) - 1
        lower = np.concatenate([self.sensing.lower, [0.0], np.full(commands, -np.inf)])
        self.observation_space = Box(lower, np.full_like(lower, np.inf), dtype=np.float64)
        self.action_space = _model_action_space(self.sensing)
        self._begun = False

    def reset(
        self, *, seed: int | None = None, options: Info | None = None
    ) -> tuple[np.ndarray, Info]:
        """Reset the model to its release."""
        super().reset(seed=seed)
        self._begun = True
        return self._lanes.reset(self.np_random, np.ones(1, bool))[0], {}

    def step(self, action: np.ndarray) -> tuple[np.ndarray, float, bool, bool, Info]:
        """Step one control period; the action is clipped to its bounds.

        Raises:
            TegotaeError: before `reset`, or for an action of the wrong shape.
        """
        if not self._begun:
            raise TegotaeError("the environment has no episode yet; call reset() before step()")
        action = np.asarray(action, float)
        space = self.action_space
        assert isinstance(space, Box)
        if action.shape != space.shape:
            raise TegotaeError(f"the action has shape {action.shape}; it must be {space.shape}")
        command = np.clip(action, space.low, space.high)[None]
        observation, reward, _ = self._lanes.step(command, np.ones(1, bool))
        ends = bool(self._lanes.fallen[0]), bool(self._lanes.truncated[0])
        return observation[0], float(reward[0]), *ends, {}

    def close(self) -> None:
        """End its threads."""
        self._lanes.close()


def model_settings_of(
    settings: ModelSettings | None, fields: Mapping[str, object]
) -> ModelSettings:
    """Return the settings with fields replaced by name; a packaged model has its own as defaults.

    Raises:
        TegotaeError: for a field that there is not, or without a model.
    """
    names = list(ModelSettings.__dataclass_fields__)
    for name in fields:
        require_known("setting of a MuJoCo model", name, names)
    if settings is None and "model" not in fields:
        raise TegotaeError(
            f"no model is given; give model= a file, or one of {', '.join(PACKAGED)}"
        )
    base = PACKAGED.get(str(fields.get("model"))) if settings is None else settings
    values = {} if base is None else {name: getattr(base, name) for name in names}
    return ModelSettings(**{**values, **fields})


def _model_action_space(sensing: Sensing) -> Box:
    """Return the space of actions within their bounds."""
    low, high = sensing.bounds
    return Box(low.astype(np.float32), high.astype(np.float32), dtype=np.float32)
