"""The environments' names in Gymnasium's registry."""

from __future__ import annotations

import gymnasium

from tegotae.envs.settings import ENVIRONMENTS


def register_all() -> None:
    """Register the environments, once; nothing of them is imported before one is made."""
    for name in ENVIRONMENTS:
        if name in gymnasium.registry:
            continue
        kind = name.removeprefix("tegotae/").removesuffix("-v0")
        gymnasium.register(
            id=name,
            entry_point=f"tegotae.envs.single:{kind}Env",
            vector_entry_point=f"tegotae.envs.vector:{kind}VectorEnv",
        )
