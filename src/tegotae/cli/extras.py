"""What a command needs of the optional packages, so that one message names all that are missing."""

from __future__ import annotations

from collections.abc import Iterable

from tegotae._support.errors import require_all
from tegotae.systems.controller_set import EnvTask, is_mujoco_model


def of_environment(env: str) -> dict[str, str]:
    """The modules of an environment, with their extras.

    Example:
        >>> of_environment("Hopper-v5"), of_environment("my_leg.xml")
        ({'gymnasium': 'gym'}, {'gymnasium': 'mujoco', 'mujoco': 'mujoco'})
    """
    if is_mujoco_model(env):
        return {"gymnasium": "mujoco", "mujoco": "mujoco"}
    return {"gymnasium": "gym"}


def require_environments(tasks: Iterable[EnvTask | None]) -> None:
    """Raise `MissingExtraError` unless the simulators of all tasks are installed."""
    needed: dict[str, str] = {}
    for task in tasks:
        needed |= {} if task is None else of_environment(task.env)
    require_all(needed)
