"""Quantities of an environment by name, and contacts in its observation."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import gymnasium
import numpy as np
from gymnasium.spaces import Box, Dict

from tegotae._support.errors import TegotaeError, require
from tegotae.envs._types import AnyEnv, AnySpace, Observation
from tegotae.envs.scaling import foot_of


def observation_names(env: AnyEnv) -> tuple[str, ...]:
    """Return the names of the observation's entries, in the order of `flat_observation`.

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
    """Return the names of the action's entries: an attribute `action_names`, a MuJoCo model's
    actuators, or `action[i]`.

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


def contact_names(env: AnyEnv) -> tuple[str, ...]:
    """Return the observation's entries that are contact forces, which an environment may name.

    MuJoCo models and `MujocoContactForce` do; another one does by an attribute `contact_names`.
    """
    if not env.has_wrapper_attr("contact_names"):
        return ()
    return tuple(env.get_wrapper_attr("contact_names"))


def flat_observation(space: AnySpace, observation: Observation) -> np.ndarray:
    """Return the observation's entries in the order of `observation_names`, shape [entries]."""
    if isinstance(space, Dict):
        return np.concatenate([np.ravel(observation[key]) for key in space.spaces])
    return np.asarray(observation)


def space_of(env: AnyEnv, role: str) -> AnySpace:
    """Return a space of the environment, "observation" or "action".

    Raises:
        TegotaeError: if it lacks it.
    """
    try:
        return getattr(env, f"{role}_space")
    except AttributeError:
        raise TegotaeError(
            f"the environment has no {role}_space; set it, such as to a gymnasium.spaces.Box"
        ) from None


def _sizes(role: str, space: AnySpace) -> Sequence[tuple[str, int]]:
    """Return the key and number of entries of each part of a space."""
    parts = dict(space.spaces) if isinstance(space, Dict) else {"": space}
    sizes = []
    for key, part in parts.items():
        if not isinstance(part, Box) or (key == "" and len(part.shape) != 1):
            where = f" under {key!r}" if key else ""
            raise TegotaeError(
                f"the {role} space{where} is {part}; it must be a one-dimensional Box or a "
                "dictionary of Boxes (gymnasium.wrappers.FlattenObservation makes one)"
            )
        sizes.append((key, int(np.prod(part.shape))))
    return sizes


def _numbered(name: str, size: int, alone: str | None = None) -> tuple[str, ...]:
    if size == 1 and alone is not None:
        return (alone,)
    return tuple(f"{name}[{i}]" for i in range(size))


def _mujoco_observation_names(env: AnyEnv) -> tuple[str, ...] | None:
    """Return the names by joint, for Gymnasium's MuJoCo environments, which name their parts."""
    model = getattr(env.unwrapped, "model", None)
    structure = getattr(env.unwrapped, "observation_structure", None)
    if model is None or structure is None:
        return None
    positions, velocities = [""] * model.nq, [""] * model.nv
    for i in range(model.njnt):
        joint = model.joint(i)
        n_positions, n_velocities = {0: (7, 6), 1: (4, 3)}.get(int(model.jnt_type[i]), (1, 1))
        first, second = model.jnt_qposadr[i], model.jnt_dofadr[i]
        joint_names = _numbered(joint.name, n_positions, alone=joint.name)
        positions[first : first + n_positions] = joint_names
        name = f"{joint.name}_velocity"
        velocities[second : second + n_velocities] = _numbered(name, n_velocities, alone=name)
    parts = {"qpos": positions[structure.get("skipped_qpos", 0) :], "qvel": velocities}
    names: list[str] = []
    for part, size in structure.items():
        if part == "skipped_qpos":
            continue
        joint_names = parts.get(part)
        names += (
            joint_names
            if joint_names is not None and len(joint_names) == size
            else _numbered(part, int(size))
        )
    return tuple(names)


class MujocoContactForce(gymnasium.ObservationWrapper[np.ndarray, Any, np.ndarray]):
    """Adds to the observation the upward contact force on bodies of a MuJoCo model [N].

    For each body named, the vertical parts of the forces of all contacts of its geoms are summed,
    after the simulator's own contact model, and appended to the observation as `BODY_force`, never
    negative. A body without a name is given by that of a geom of its own.

    Args:
        env: an environment of Gymnasium's MuJoCo family, or any that has its `model` and `data`.
        bodies: names of bodies, such as `foot`, or of geoms.

    Raises:
        TegotaeError: for an environment without a MuJoCo model, an observation that is no
            one-dimensional Box, or a body that the model lacks.

    Example:
        >>> env = MujocoContactForce(gymnasium.make("Hopper-v5"), "foot")  # doctest: +SKIP
        >>> env.observation_names[-1]  # doctest: +SKIP
        'foot_force'
    """

    def __init__(self, env: AnyEnv, *bodies: str) -> None:
        super().__init__(env)
        self._mujoco = require("mujoco", "mujoco")
        base: Any = env.unwrapped
        if not isinstance(getattr(base, "model", None), self._mujoco.MjModel):
            raise TegotaeError(f"{base} has no MuJoCo model, and so no contact forces to read")
        if not hasattr(base, "data"):
            raise TegotaeError(f"{base} does not show its contacts; make it with feet={[*bodies]}")
        space = space_of(env, "observation")
        if not isinstance(space, Box) or len(space.shape) != 1:
            raise TegotaeError(
                f"the observation space is {space}; it must be a one-dimensional Box"
            )
        if not bodies:
            raise TegotaeError("no body is named; name those whose contact forces to observe")
        self._geoms = [frozenset(foot_of(base.model, name).geoms) for name in bodies]
        names = tuple(f"{name}_force" for name in bodies)
        self.observation_names = (*observation_names(env), *names)
        self.contact_names = (*contact_names(env), *names)
        lower = np.zeros(len(bodies), space.dtype)
        self.observation_space = Box(
            np.concatenate([space.low, lower]),
            np.concatenate([space.high, np.full_like(lower, np.inf)]),
            dtype=space.dtype,  # type: ignore[arg-type]
        )

    def observation(self, observation: np.ndarray) -> np.ndarray:
        """Return the observation and the forces [N]."""
        forces = np.maximum(self._forces(), 0.0).astype(observation.dtype)
        return np.concatenate([observation, forces])

    def _forces(self) -> np.ndarray:
        base: Any = self.env.unwrapped
        model, data = base.model, base.data
        total = np.zeros(len(self._geoms))
        wrench = np.zeros(6)
        for i in range(data.ncon):
            contact = data.contact[i]
            self._mujoco.mj_contactForce(model, data, i, wrench)
            # Rows of the contact frame are its axes; the force acts on the second geom.
            upward = float(wrench[:3] @ contact.frame.reshape(3, 3)[:, 2])
            for k, geoms in enumerate(self._geoms):
                total[k] += upward * ((contact.geom2 in geoms) - float(contact.geom1 in geoms))
        return total


def with_contact(env: AnyEnv, bodies: Sequence[str]) -> AnyEnv:
    """Wrap the environment so that it observes contact forces of bodies that it does not observe
    itself.

    Raises:
        TegotaeError: for an environment without a MuJoCo model, or a body that it lacks.
    """
    if not bodies:
        return env
    names = {*observation_names(env), *contact_names(env)}
    lacking = [body for body in bodies if not {f"{body}_force", f"{body}_contact_force"} & names]
    return MujocoContactForce(env, *lacking) if lacking else env
