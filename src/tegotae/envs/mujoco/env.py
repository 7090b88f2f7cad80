"""Any MuJoCo model as a Gymnasium environment: the same steps as `ModelBatch`, one lane of it."""

from __future__ import annotations

from collections.abc import Mapping

import gymnasium
import numpy as np
from gymnasium.spaces import Box

from tegotae._support.errors import TegotaeError
from tegotae.envs._types import Info
from tegotae.envs.mujoco.batch import ModelBatch
from tegotae.envs.mujoco.episodes import Fate
from tegotae.envs.mujoco.sensing import Sensing
from tegotae.envs.mujoco.settings import PACKAGED, ModelSettings


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
        self.settings = settings_of(settings, fields)
        own = self.settings
        self.sensing = own.sensed
        self.batch = ModelBatch(self.sensing, 1, own.control_s, threads=1)
        self.model = self.sensing.model
        self.dt = self.batch.step_s
        self.observation_names = (*self.sensing.names, "work")
        self.contact_names = self.sensing.contacts
        self.action_names = self.sensing.actuators
        self.fate = Fate(own, self.sensing, self.dt)
        least = [entry.least for entry in self.sensing.entries]
        high = np.full(len(least) + 1, np.inf)
        self.observation_space = Box(np.array([*least, 0.0]), high, dtype=np.float64)
        self.action_space = action_space(self.sensing)
        self._seen: np.ndarray | None = None

    def reset(
        self, *, seed: int | None = None, options: Info | None = None
    ) -> tuple[np.ndarray, Info]:
        """The model at its release."""
        super().reset(seed=seed)
        own = self.settings
        noise = own.noise * self.np_random.standard_normal((1, self.model.nv))
        self._seen = self.batch.reset(own.release_m, noise if own.noise else None)
        self.fate.begin(self._seen)
        return self._observation(self._seen), {}

    def step(self, action: np.ndarray) -> tuple[np.ndarray, float, bool, bool, Info]:
        """One control period; the action is clipped to its bounds.

        Raises:
            TegotaeError: before `reset`, or for an action of the wrong shape.
        """
        if self._seen is None:
            raise TegotaeError("the environment has no episode yet; call reset() before step()")
        action = np.asarray(action, float)
        space = self.action_space
        assert isinstance(space, Box)
        if action.shape != space.shape:
            raise TegotaeError(f"the action has shape {action.shape}; it must be {space.shape}")
        self._seen = self.batch.step(np.clip(action, space.low, space.high)[None])
        reward, fallen, over = self.fate.after(self._seen, self.batch.work_j)
        seen = self._observation(self._seen)
        return seen, float(reward[0]), bool(fallen[0]), bool(over[0]), {}

    def _observation(self, seen: np.ndarray) -> np.ndarray:
        return np.append(seen[0], self.batch.work_j[0])

    def close(self) -> None:
        """End its threads."""
        self.batch.close()


def settings_of(settings: ModelSettings | None, fields: Mapping[str, object]) -> ModelSettings:
    """The settings, with fields by name; those of a packaged model are its own by default.

    Raises:
        TegotaeError: for a field that there is not, or without a model.
    """
    known = set(ModelSettings.__dataclass_fields__)
    if strange := sorted(set(fields) - known):
        raise TegotaeError(
            f"a MuJoCo model's environment has no setting {strange[0]!r}; it has "
            f"{', '.join(sorted(known))}"
        )
    if settings is None and "model" not in fields:
        raise TegotaeError(
            "no model is given; give model= a file, or one of " + ", ".join(PACKAGED)
        )
    base = PACKAGED.get(str(fields.get("model"))) if settings is None else settings
    values = {} if base is None else {name: getattr(base, name) for name in known}
    return ModelSettings(**{**values, **fields})


def action_space(sensing: Sensing) -> Box:
    """The actuators' ranges; unbounded where a model gives none."""
    model, driven = sensing.model, sensing.driven
    limited = model.actuator_ctrllimited[driven].astype(bool)
    low = np.where(limited, model.actuator_ctrlrange[driven, 0], -np.inf)
    high = np.where(limited, model.actuator_ctrlrange[driven, 1], np.inf)
    return Box(low.astype(np.float32), high.astype(np.float32), dtype=np.float32)
