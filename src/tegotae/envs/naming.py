"""Names for the entries of any environment's observations and actions."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from gymnasium.spaces import Box, Dict

from tegotae._support.errors import TegotaeError
from tegotae.envs._types import AnyEnv, AnySpace, Observation


def observation_names(env: AnyEnv) -> tuple[str, ...]:
    """Names of the observation's entries, in the order of `flat`.

    Taken from the first that there is: an attribute `observation_names` of the environment or one
    of its wrappers; the keys of a dictionary space (`key`, or `key[i]` where it has several
    entries); the joints of a MuJoCo model (`joint` its position, `joint_velocity`); else
    `observation[i]`.

    Raises:
        TegotaeError: for a space that is neither a one-dimensional Box nor a dictionary of Boxes.

    Example:
        >>> import gymnasium
        >>> observation_names(gymnasium.make("CartPole-v1"))
        ('observation[0]', 'observation[1]', 'observation[2]', 'observation[3]')
    """
    space = space_of(env, "observation")
    sizes = _sizes("observation", space)
    if env.has_wrapper_attr("observation_names"):
        return tuple(env.get_wrapper_attr("observation_names"))
    if isinstance(space, Dict):
        return tuple(name for key, size in sizes for name in _numbered(key, size, alone=key))
    (_, size), *_ = sizes
    from_model = _mujoco_observation_names(env)
    if from_model is not None and len(from_model) == size:
        return from_model
    return _numbered("observation", size)


def action_names(env: AnyEnv) -> tuple[str, ...]:
    """Names of the action's entries: an attribute `action_names`, a MuJoCo model's actuators, or
    `action[i]`.

    Raises:
        TegotaeError: for a space that is no one-dimensional Box.
    """
    space = space_of(env, "action")
    if not isinstance(space, Box) or len(space.shape) != 1:
        raise TegotaeError(f"the action space is {space}; it must be a one-dimensional Box")
    if env.has_wrapper_attr("action_names"):
        return tuple(env.get_wrapper_attr("action_names"))
    model = getattr(env.unwrapped, "model", None)
    if model is not None and getattr(model, "nu", None) == space.shape[0]:
        names = [model.actuator(i).name or model.joint(model.actuator_trnid[i][0]).name
                 for i in range(model.nu)]  # fmt: skip
        if all(names) and len(set(names)) == len(names):
            return tuple(names)
    return _numbered("action", space.shape[0])


def flat(space: AnySpace, observation: Observation) -> np.ndarray:
    """The observation's entries in the order of `observation_names`, shape [entries]."""
    if isinstance(space, Dict):
        return np.concatenate([np.ravel(observation[key]) for key in space.spaces])
    return np.asarray(observation)


def space_of(env: AnyEnv, what: str) -> AnySpace:
    """A space of the environment, "observation" or "action".

    Raises:
        TegotaeError: if it lacks it.
    """
    try:
        return getattr(env, f"{what}_space")
    except AttributeError:
        raise TegotaeError(
            f"the environment has no {what}_space; set it, such as to a gymnasium.spaces.Box"
        ) from None


def _sizes(what: str, space: AnySpace) -> Sequence[tuple[str, int]]:
    """Key and number of entries of each part of a space."""
    parts = dict(space.spaces) if isinstance(space, Dict) else {"": space}
    sizes = []
    for key, part in parts.items():
        if not isinstance(part, Box) or (key == "" and len(part.shape) != 1):
            where = f" under {key!r}" if key else ""
            raise TegotaeError(
                f"the {what} space{where} is {part}; it must be a one-dimensional Box or a "
                "dictionary of Boxes (gymnasium.wrappers.FlattenObservation makes one)"
            )
        sizes.append((key, int(np.prod(part.shape))))
    return sizes


def _numbered(name: str, size: int, alone: str | None = None) -> tuple[str, ...]:
    if size == 1 and alone is not None:
        return (alone,)
    return tuple(f"{name}[{i}]" for i in range(size))


def _mujoco_observation_names(env: AnyEnv) -> tuple[str, ...] | None:
    """Names by joint, for Gymnasium's MuJoCo environments, which name their parts."""
    model = getattr(env.unwrapped, "model", None)
    structure = getattr(env.unwrapped, "observation_structure", None)
    if model is None or structure is None:
        return None
    positions, velocities = [""] * model.nq, [""] * model.nv
    for i in range(model.njnt):
        joint = model.joint(i)
        n_positions, n_velocities = {0: (7, 6), 1: (4, 3)}.get(int(model.jnt_type[i]), (1, 1))
        first, second = model.jnt_qposadr[i], model.jnt_dofadr[i]
        own = _numbered(joint.name, n_positions, alone=joint.name)
        positions[first : first + n_positions] = own
        name = f"{joint.name}_velocity"
        velocities[second : second + n_velocities] = _numbered(name, n_velocities, alone=name)
    parts = {"qpos": positions[structure.get("skipped_qpos", 0) :], "qvel": velocities}
    names: list[str] = []
    for part, size in structure.items():
        if part == "skipped_qpos":
            continue
        own = parts.get(part)
        names += own if own is not None and len(own) == size else _numbered(part, int(size))
    return tuple(names)
