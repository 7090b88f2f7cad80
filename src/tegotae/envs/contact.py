"""The contact force of a MuJoCo environment, which its observation may not hold."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import gymnasium
import numpy as np
from gymnasium.spaces import Box

from tegotae._support.errors import TegotaeError, require, unknown
from tegotae.envs._types import AnyEnv
from tegotae.envs.naming import observation_names, space_of


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
        model = base.model
        known = {model.geom(i).name: [i] for i in range(model.ngeom) if model.geom(i).name}
        for body in range(model.nbody):
            if model.body(body).name:
                own = np.flatnonzero(model.geom_bodyid == body)
                known[model.body(body).name] = own.tolist()
        for name in bodies:
            if name not in known:
                raise unknown("body of this model", name, known)
        self._geoms = [frozenset(known[name]) for name in bodies]
        named = tuple(f"{name}_force" for name in bodies)
        self.observation_names = (*observation_names(env), *named)
        own = env.get_wrapper_attr("contact_names") if env.has_wrapper_attr("contact_names") else ()
        self.contact_names = (*own, *named)
        more = np.zeros(len(bodies), space.dtype)
        self.observation_space = Box(
            np.concatenate([space.low, more]),
            np.concatenate([space.high, np.full_like(more, np.inf)]),
            dtype=space.dtype,  # type: ignore[arg-type]
        )

    def observation(self, observation: np.ndarray) -> np.ndarray:
        """The observation and the forces [N]."""
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
    """The environment with the contact forces of bodies that it does not observe already.

    Raises:
        TegotaeError: for an environment without a MuJoCo model, or a body that it lacks.
    """
    if not bodies:
        return env
    known = {*observation_names(env)}
    if env.has_wrapper_attr("contact_names"):
        known |= {*env.get_wrapper_attr("contact_names")}
    lacking = [body for body in bodies if not {f"{body}_force", f"{body}_contact_force"} & known]
    return MujocoContactForce(env, *lacking) if lacking else env
