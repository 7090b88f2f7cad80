"""Tegotae control for any Gymnasium environment with something like a contact force: observations
to actions, of one environment or of many side by side."""

from __future__ import annotations

import warnings
from typing import Any

import gymnasium
import jax
import jax.numpy as jnp
import numpy as np
from gymnasium.spaces import Box, Dict
from numpy.typing import ArrayLike

from tegotae._support.errors import TegotaeError
from tegotae.envs._types import AnyEnv, AnySpace, Info
from tegotae.envs.contact import contact_names, flat_observation, with_contact
from tegotae.envs.wires import Wires, WiringWarning, look_up, remarks, weights_of
from tegotae.envs.wiring import Wiring
from tegotae.parts.units import Units
from tegotae.simulation.sampler import sampler

_PHASE_KEY = "phase"
"""Key of a dictionary observation under which sin φ and cos φ of the limbs are."""


class Pilot:
    """Driver of the limbs of several lanes, each an environment of its own, sample by sample.

    Args:
        wires: where in observations and actions is what.
        wiring: its numbers.
        weights: of the controller of all limbs, [n_weights, lanes].

    Raises:
        TegotaeError: for a wiring without a frequency, or weights of another number.
    """

    def __init__(self, wires: Wires, wiring: Wiring, weights: np.ndarray) -> None:
        controller = wires.controller
        if wiring.omega is None:
            raise TegotaeError("the wiring has no frequency; give omega= [rad/s]")
        if weights.shape[0] != controller.n_weights:
            raise TegotaeError(
                f"the weights have shape {weights.shape}; the controller has {controller.n_weights}"
            )
        self._wires, self._controller = wires, controller
        self._lanes = weights.shape[1]
        self._weights = np.asarray(weights, np.float32)
        self._units = units = wiring.units or Units()
        self._numbers = {
            "omega": np.float32(units.time_s * wiring.omega),
            "scales": {
                name: np.float32(x / units.value_of(name)) for name, x in wiring.scales.items()
            },
            "max_force": np.float32(wiring.max_force),
            "step_s": np.float32(wires.step_s / units.time_s),
        }
        self._phases = np.array([limb.phase_rad for limb in wiring.limbs], np.float32)
        self.reset()
        self._sample = sampler(controller, self._lanes, tuple(wires.sensed), tuple(wiring.scales))

    def reset(self) -> None:
        """Reset all oscillators to the phases of their limbs."""
        oscillator = self._controller.oscillator
        assert oscillator is not None  # look_up refuses a controller without
        start = np.broadcast_to(self._phases[:, None], (self._wires.limbs, self._lanes))
        self._oscillator = oscillator.start(jnp.asarray(self._in_controller_layout(start)))
        self.phase = np.asarray(oscillator.phase(self._oscillator)).reshape(start.shape)
        """Phases [rad], [limbs, lanes]."""
        self.feedback = np.zeros(start.shape, np.float32)
        """Feedback over the last step [rad/s], [limbs, lanes]."""
        self.share = np.zeros(start.shape, np.float32)
        """Force as a share of α over the last step, [limbs, lanes]; 0 for commanded places."""

    def restart(self, where: np.ndarray, omega: np.ndarray) -> None:
        """Start new episodes of some lanes, whose oscillators begin again.

        Args:
            where: which lanes, [lanes].
            omega: the frequency of every lane from now on [rad/s], [lanes].
        """
        previous, phase = self._oscillator, self.phase
        self.reset()
        begun = self._oscillator
        self._oscillator = jax.tree.map(
            lambda new, old: jnp.where(where, new, old), begun, previous
        )
        self.phase = np.where(where, self.phase, phase)
        every = np.broadcast_to(self._units.time_s * np.asarray(omega), phase.shape)
        self._numbers["omega"] = self._in_controller_layout(np.array(every, np.float32))

    def act(
        self,
        observed: np.ndarray,
        *,
        added: np.ndarray | None = None,
        free: ArrayLike | None = None,
    ) -> np.ndarray:
        """Take one sample: return the actions [lanes, entries] and advance the oscillators by a
        step.

        Args:
            observed: the observations, [lanes, entries].
            added: feedback from elsewhere [rad/s], [limbs, lanes].
            free: entries of the action that no limb drives, [lanes, free] or one number; those
                of the environment's start by default.
        """
        wires, units = self._wires, self._units
        sensed = {}
        for signal in wires.sensed:
            felt = wires.felt(signal, observed) / units.value_of(signal)
            sensed[signal] = self._in_controller_layout(felt.astype(np.float32))
        extra = np.zeros((wires.limbs, self._lanes), np.float32)
        if added is not None:
            extra = np.asarray(units.time_s * added, np.float32)
        arguments = (
            self._weights,
            self._oscillator,
            sensed,
            self._in_controller_layout(extra),
            self._numbers,
        )
        self._oscillator, command, feedback, phase = self._sample(*arguments)
        shape = wires.limbs, self._lanes
        self.feedback = np.asarray(feedback).reshape(shape) / units.time_s
        self.phase = np.asarray(phase).reshape(shape)
        command = np.asarray(command).reshape(-1, *shape)
        action = np.empty((self._lanes, len(wires.low)))
        free = wires.still[wires.free] if free is None else free
        action[:, wires.free] = np.clip(free, wires.low[wires.free], wires.high[wires.free])
        if self._controller.actuation.commands_force:
            self.share = command[0]
            action[:, wires.driven[0]] = wires.rest + (wires.push - wires.rest) * command[0].T
        else:
            for entry, place in zip(wires.driven, command, strict=True):
                commanded = units.length_m * place.T
                action[:, entry] = np.clip(commanded, wires.low[entry], wires.high[entry])
        return action

    def _in_controller_layout(self, x: np.ndarray) -> np.ndarray:
        """Return [limbs, lanes] in the controller's layout: one limb has no axis."""
        return x[0] if self._wires.limbs == 1 else x


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
    limbs (in a dictionary, under the key `phase`). `info` has `phase_rad`, `feedback_rad_per_s`
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

    def __init__(self, env: AnyEnv, wiring: Wiring) -> None:
        super().__init__(with_contact(env, wiring.contact_bodies))
        env = self.env
        wires, problems = look_up(env, wiring)
        weights, wrong = weights_of(wiring)
        if wires is None or problems or wrong:
            raise TegotaeError("; ".join([*problems, *wrong]))
        for remark in remarks(wiring, contact_names(env)):
            warnings.warn(remark, WiringWarning, stacklevel=2)
        self.wiring = wiring
        self._pilot = Pilot(wires, wiring, weights[:, None])
        n = wires.limbs
        space = env.action_space
        assert isinstance(space, Box)
        ones = np.ones(n, np.float32)
        self._inner_dtype = space.dtype
        self.action_space = Box(
            np.concatenate([-ones, space.low[wires.free].astype(np.float32)]),
            np.concatenate([ones, space.high[wires.free].astype(np.float32)]),
            dtype=np.float32,
        )
        self.observation_space = _with_phase_space(env.observation_space, n)
        self._n = n
        self._sensed: np.ndarray | None = None

    def reset(self, *, seed: int | None = None, options: Info | None = None) -> tuple[Any, Info]:
        """Reset the environment, and the oscillators to their `phase_rad`."""
        observation, info = self.env.reset(seed=seed, options=options)
        self._pilot.reset()
        self._sensed = flat_observation(self.env.observation_space, observation)
        return self._outward(observation, info)

    def step(self, action: np.ndarray) -> tuple[Any, Any, bool, bool, Info]:
        """Step the environment once.

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
        added = np.clip(action[: self._n], -1.0, 1.0)
        added = added * np.float32(self.wiring.max_feedback_rad_per_s)
        free = action[self._n :]
        command = self._pilot.act(self._sensed[None], added=added[:, None], free=free[None])[0]
        observation, reward, terminated, truncated, info = self.env.step(
            command.astype(self._inner_dtype)
        )
        self._sensed = flat_observation(self.env.observation_space, observation)
        observation, info = self._outward(observation, info)
        return observation, reward, terminated, truncated, info

    def _outward(self, observation: Any, info: Info) -> tuple[Any, Info]:
        """Return observation and info with the oscillators' part."""
        phase = self._pilot.phase[:, 0]
        entries = np.concatenate([np.sin(phase), np.cos(phase)])
        if isinstance(self.env.observation_space, Dict):
            observation = {**observation, _PHASE_KEY: entries}
        else:
            observation = np.concatenate([observation, entries.astype(observation.dtype)])
        mine = {
            "phase_rad": phase,
            "feedback_rad_per_s": self._pilot.feedback[:, 0],
            "force_share": self._pilot.share[:, 0],
        }
        return observation, {**info, **{name: value.copy() for name, value in mine.items()}}


def _with_phase_space(space: AnySpace, limbs: int) -> AnySpace:
    ones = np.ones(2 * limbs, np.float32)
    if isinstance(space, Dict):
        if _PHASE_KEY in space.spaces:
            raise TegotaeError(f"the observation has a key {_PHASE_KEY!r} already; rename it")
        return Dict({**space.spaces, _PHASE_KEY: Box(-ones, ones)})
    assert isinstance(space, Box)
    return Box(
        np.concatenate([space.low, -ones.astype(space.dtype)]),
        np.concatenate([space.high, ones.astype(space.dtype)]),
        dtype=space.dtype,  # type: ignore[arg-type]
    )
