"""Tegotae control for any Gymnasium environment with something like a contact force."""

from __future__ import annotations

from functools import partial
from typing import Any

import gymnasium
import jax
import jax.numpy as jnp
import numpy as np
from gymnasium.spaces import Box, Dict

from tegotae.controller import Controller
from tegotae.envs.naming import flat
from tegotae.envs.wiring import Wires, Wiring, look_up
from tegotae.errors import TegotaeError
from tegotae.integrators.base import decide, held, phase_of, push, settled, with_rhythm
from tegotae.terms import Signals

PHASE_KEY = "phase"
"""Where a dictionary observation holds sin φ and cos φ of the limbs."""


class TegotaeWrapper(gymnasium.Wrapper[Any, np.ndarray, Any, np.ndarray]):
    """An environment whose named action entries are driven by Tegotae oscillators.

    For every limb, at every step: `f = G · A′(φ) · R(s) + f_agent`, the actuation's force
    F_a ∈ [0, α], the action entry `rest + (push - rest) · F_a / α`, and `φ̇ = ω + f`, all held over
    the step.

    The agent's action is, in this order, an added feedback for each limb, in [-1, 1] times
    `max_feedback_rad_per_s`, and the action entries that no limb drives, in their own bounds. An
    agent that stays at zero leaves the limbs to Tegotae alone; a gain of zero leaves the feedback
    to the agent alone.

    The observation is the environment's own, and after it sin φ of all limbs and cos φ of all
    limbs (in a dictionary, under the key `phase`). `info` tells `phase_rad`, `feedback_rad_per_s`
    and `force_share`, shape [limbs] each.

    Args:
        env: the environment.
        wiring: what is wired to what.

    Raises:
        TegotaeError: if something is missing; `check_wiring` lists all of it.

    Example:
        >>> from tegotae.envs import Limb, MujocoContactForce
        >>> env = MujocoContactForce(gymnasium.make("Hopper-v5"), "foot")  # doctest: +SKIP
        >>> leg = Limb(senses={"spring_force": "foot_force"}, drives="leg_joint", push=-1.0)
        >>> wiring = Wiring(limbs=[leg], weights=[0.05], omega=12.0)
        >>> env = TegotaeWrapper(env, wiring)  # doctest: +SKIP
    """

    def __init__(self, env: gymnasium.Env[Any, Any], wiring: Wiring) -> None:
        super().__init__(env)
        wires, problems = look_up(env, wiring)
        if wires is None:
            raise TegotaeError("; ".join(problems))
        self.wiring = wiring
        self._wires: Wires = wires
        self._n = len(wires.driven)
        inner = env.action_space
        assert isinstance(inner, Box)
        ones = np.ones(self._n, np.float32)
        self._inner_dtype = inner.dtype
        self.action_space = Box(
            np.concatenate([-ones, inner.low[wires.free].astype(np.float32)]),
            np.concatenate([ones, inner.high[wires.free].astype(np.float32)]),
            dtype=np.float32,
        )
        self.observation_space = _with_phase_space(env.observation_space, self._n)
        self._oscillator: Any = ()
        self._sensed: np.ndarray | None = None

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """Reset the environment, and the oscillators to their `phase_rad`."""
        observation, info = self.env.reset(seed=seed, options=options)
        oscillator = self.wiring.controller.oscillator
        assert oscillator is not None  # look_up refuses a controller without
        phases = jnp.asarray([limb.phase_rad for limb in self.wiring.limbs], jnp.float32)
        self._oscillator = oscillator.start(phases)
        self._sensed = flat(self.env.observation_space, observation)
        none = np.zeros(self._n, np.float32)
        return self._outward(observation, info, none, none)

    def step(self, action: np.ndarray) -> tuple[Any, Any, bool, bool, dict[str, Any]]:
        """One step of the environment.

        Raises:
            TegotaeError: before `reset`, or for an action of the wrong shape.
        """
        if self._sensed is None:
            raise TegotaeError("the environment has no episode yet; call reset() before step()")
        action = np.asarray(action, np.float32)
        if action.shape != self.action_space.shape:
            raise TegotaeError(
                f"the action has shape {action.shape}; it must be {self.action_space.shape}, the "
                f"added feedback of {self._n} limbs and the entries that no limb drives"
            )
        wires, wiring = self._wires, self.wiring
        self._oscillator, share, feedback = _control(
            wiring.controller,
            wires.weights,
            np.float32(wiring.omega),
            self._oscillator,
            {signal: self._sensed[at].astype(np.float32) for signal, at in wires.sensed.items()},
            {signal: np.float32(scale) for signal, scale in wiring.scales.items()},
            np.clip(action[: self._n], -1.0, 1.0) * np.float32(wiring.max_feedback_rad_per_s),
            np.float32(wiring.max_force),
            np.float32(wires.step_s),
        )
        share, feedback = np.asarray(share), np.asarray(feedback)
        inner = np.empty(len(wires.driven) + len(wires.free), self._inner_dtype)
        inner[wires.driven] = wires.rest + (wires.push - wires.rest) * share
        inner[wires.free] = action[self._n :]
        observation, reward, terminated, truncated, info = self.env.step(inner)
        self._sensed = flat(self.env.observation_space, observation)
        observation, info = self._outward(observation, info, share, feedback)
        return observation, reward, terminated, truncated, info

    def _outward(
        self, observation: Any, info: dict[str, Any], share: np.ndarray, feedback: np.ndarray
    ) -> tuple[Any, dict[str, Any]]:
        """Observation and info with the oscillators' part."""
        oscillator = self.wiring.controller.oscillator
        assert oscillator is not None
        phase = np.array(oscillator.phase(self._oscillator))
        told = np.concatenate([np.sin(phase), np.cos(phase)])
        if isinstance(self.env.observation_space, Dict):
            observation = {**observation, PHASE_KEY: told}
        else:
            observation = np.concatenate([observation, told.astype(observation.dtype)])
        mine = {"phase_rad": phase, "feedback_rad_per_s": feedback, "force_share": share}
        return observation, {**info, **{name: value.copy() for name, value in mine.items()}}


def _with_phase_space(space: gymnasium.Space[Any], limbs: int) -> gymnasium.Space[Any]:
    ones = np.ones(2 * limbs, np.float32)
    if isinstance(space, Dict):
        if PHASE_KEY in space.spaces:
            raise TegotaeError(f"the observation has a key {PHASE_KEY!r} already; rename it")
        return Dict({**space.spaces, PHASE_KEY: Box(-ones, ones)})
    assert isinstance(space, Box)
    return Box(
        np.concatenate([space.low, -ones.astype(space.dtype)]),
        np.concatenate([space.high, ones.astype(space.dtype)]),
        dtype=space.dtype,  # type: ignore[arg-type]
    )


@partial(jax.jit, static_argnums=0)
def _control(
    controller: Controller, weights, omega, oscillator, sensed, scales, added, max_force, step_s
):
    """One sample of all limbs' controllers: oscillators one step on, force share, feedback."""
    rows = tuple(weights[i] for i in range(weights.shape[0]))
    heard = with_rhythm(controller, Signals(sensed, scales), oscillator)
    said = decide(controller, rows, omega, heard, oscillator, max_force, added=added)
    ahead = held(oscillator, said.rate, step_s)
    begins, ends = (phase_of(controller, each, said.feedback) for each in (oscillator, ahead))
    force = push(controller, max_force, said.command, begins, ends, omega)
    return settled(controller, ahead), force.mean_n / max_force, said.feedback
