"""Hopper environments for Gymnasium and Stable-Baselines3, and Tegotae control for any environment.

Importing this package registers the environments:

    gymnasium.make("tegotae/Hopper-v0", ...)              one hopper, the action is its force
    gymnasium.make("tegotae/TegotaeHopper-v0", ...)       the action is the Tegotae feedback
    gymnasium.make_vec("tegotae/Hopper-v0", 1024, ...)    thousands at once
    tegotae.envs.make_sb3("tegotae/Hopper-v0", 1024, ...) the same for Stable-Baselines3
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from tegotae._support.errors import require, require_known

gymnasium = require("gymnasium", "gym")

from tegotae.envs.contact import (  # noqa: E402
    MujocoContactForce,
    action_names,
    observation_names,
)
from tegotae.envs.hoppers import (  # noqa: E402
    HopperEnv,
    HopperVectorEnv,
    TegotaeHopperEnv,
    TegotaeHopperVectorEnv,
)
from tegotae.envs.scaling import model_scales  # noqa: E402
from tegotae.envs.settings import (  # noqa: E402
    ENVIRONMENTS,
    HopperSettings,
    HopReward,
    TegotaeHopperSettings,
    hopper_settings_of,
)
from tegotae.envs.wires import WiringWarning, check_wiring  # noqa: E402
from tegotae.envs.wiring import Limb, Wiring, load_wiring, save_wiring  # noqa: E402
from tegotae.envs.wrapper import TegotaeWrapper  # noqa: E402

if TYPE_CHECKING:
    from stable_baselines3.common.vec_env import VecMonitor

for _name in ENVIRONMENTS.keys() - gymnasium.registry.keys():
    _kind = _name.removeprefix("tegotae/").removesuffix("-v0")
    gymnasium.register(
        id=_name,
        entry_point=f"tegotae.envs.hoppers:{_kind}Env",
        vector_entry_point=f"tegotae.envs.hoppers:{_kind}VectorEnv",
    )

__all__ = [
    "ENVIRONMENTS",
    "HopReward",
    "HopperEnv",
    "HopperSettings",
    "HopperVectorEnv",
    "Limb",
    "MujocoContactForce",
    "TegotaeHopperEnv",
    "TegotaeHopperSettings",
    "TegotaeHopperVectorEnv",
    "TegotaeWrapper",
    "Wiring",
    "WiringWarning",
    "action_names",
    "check_wiring",
    "load_wiring",
    "make_sb3",
    "model_scales",
    "observation_names",
    "save_wiring",
]


def make_sb3(
    name: str, num_envs: int = 1, *, render_mode: str | None = None, **settings: object
) -> VecMonitor:
    """Return many hoppers as a Stable-Baselines3 `VecEnv`.

    Its monitor writes return, length and time of an episode that ends into `info`, so that
    Stable-Baselines3 logs its usual curves.

    Args:
        name: `tegotae/Hopper-v0` or `tegotae/TegotaeHopper-v0`.
        num_envs: how many.
        render_mode: `rgb_array` or None.
        settings: the fields of the environment's settings, by name.

    Raises:
        TegotaeError: for an unknown environment or setting, or one that cannot be used.
        MissingExtraError: without Stable-Baselines3.

    Example:
        >>> vec_env = make_sb3("tegotae/TegotaeHopper-v0", 64, omega=(6.0, 10.0))
        >>> vec_env.reset().shape
        (64, 3)
    """
    require_known("environment", name, ENVIRONMENTS)
    from tegotae.envs.sb3 import HopperVecEnv  # first, for it says which extra is missing

    # isort: split
    from stable_baselines3.common.vec_env import VecMonitor

    chosen = hopper_settings_of(ENVIRONMENTS[name], settings)
    return VecMonitor(HopperVecEnv(chosen, num_envs, render_mode))
