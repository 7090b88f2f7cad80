"""Types of Gymnasium, whose spaces hold anything, and of MuJoCo, which has none for checkers."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

if TYPE_CHECKING:
    import gymnasium

    AnyEnv: TypeAlias = gymnasium.Env[Any, Any]
    AnySpace: TypeAlias = gymnasium.Space[Any]
else:  # Gymnasium is optional.
    AnyEnv = AnySpace = object

Observation: TypeAlias = "np.ndarray | Mapping[str, np.ndarray]"
"""An array, or a dictionary of arrays."""
Info: TypeAlias = dict[str, Any]
"""Values by name that an environment returns beside its observation, or takes at a reset."""

Seeds: TypeAlias = "int | np.ndarray | np.random.Generator"
"""Seeds of the starts of episodes: one for all lanes, or one a lane, [lanes]."""

_OfMujoco: TypeAlias = Any
MjData: TypeAlias = _OfMujoco
MjModel: TypeAlias = _OfMujoco
MjSpec: TypeAlias = _OfMujoco
MjsActuator: TypeAlias = _OfMujoco
