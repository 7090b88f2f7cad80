"""From observations to actions: the controllers of all limbs, of many environments side by side."""

from __future__ import annotations

from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
from numpy.typing import ArrayLike

from tegotae._support.errors import TegotaeError
from tegotae.envs.wires import Wires
from tegotae.envs.wiring import Wiring
from tegotae.simulation.integrators import sample

_sample = partial(jax.jit, static_argnums=0)(sample)


class Pilot:
    """Drives the limbs of several lanes, each an environment of its own, sample by sample.

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
        self._weights = jnp.asarray(weights, jnp.float32)
        self._numbers = {
            "omega": np.float32(wiring.omega),
            "scales": {signal: np.float32(scale) for signal, scale in wiring.scales.items()},
            "max_force": np.float32(wiring.max_force),
            "step_s": np.float32(wires.step_s),
        }
        self._phases = np.array([limb.phase_rad for limb in wiring.limbs], np.float32)
        self.reset()

    def reset(self) -> None:
        """All oscillators at the phases of their limbs."""
        oscillator = self._controller.oscillator
        assert oscillator is not None  # look_up refuses a controller without
        start = np.broadcast_to(self._phases[:, None], (self._wires.limbs, self._lanes))
        self._oscillator = oscillator.start(jnp.asarray(self._of_limbs(start)))
        self.phase = np.asarray(oscillator.phase(self._oscillator)).reshape(start.shape)
        """Phases [rad], [limbs, lanes]."""
        self.feedback = np.zeros(start.shape, np.float32)
        """Feedback over the last step [rad/s], [limbs, lanes]."""
        self.share = np.zeros(start.shape, np.float32)
        """Force as a share of α over the last step, [limbs, lanes]; 0 for commanded places."""

    def restart(self, where: np.ndarray, omega: np.ndarray) -> None:
        """New episodes of some lanes alone, whose oscillators begin again.

        Args:
            where: which lanes, [lanes].
            omega: the frequency of every lane from now on [rad/s], [lanes].
        """
        before, phase = self._oscillator, self.phase
        self.reset()
        begun = self._oscillator
        self._oscillator = jax.tree.map(lambda new, old: jnp.where(where, new, old), begun, before)
        self.phase = np.where(where, self.phase, phase)
        every = np.broadcast_to(omega, phase.shape)
        self._numbers["omega"] = self._of_limbs(np.array(every, np.float32))

    def act(
        self, observed: np.ndarray, *, added: np.ndarray | None = None, free: ArrayLike = 0.0
    ) -> np.ndarray:
        """One sample: the actions [lanes, entries], the oscillators being a step on then.

        Args:
            observed: the observations, [lanes, entries].
            added: feedback from elsewhere [rad/s], [limbs, lanes].
            free: entries of the action that no limb drives, [lanes, free] or one number.
        """
        wires = self._wires
        sensed = {}
        for signal, (at, sign) in wires.sensed.items():
            felt = sign[:, None] * observed[:, at].T
            felt = np.maximum(felt, 0.0) if signal == "spring_force" else felt
            sensed[signal] = self._of_limbs(felt.astype(np.float32))
        extra = np.zeros((wires.limbs, self._lanes), np.float32) if added is None else added
        given = self._weights, self._oscillator, sensed, self._of_limbs(extra), self._numbers
        sampled = _sample(self._controller, *given)
        self._oscillator, command, feedback, phase = sampled
        shape = wires.limbs, self._lanes
        self.feedback = np.asarray(feedback).reshape(shape)
        self.phase = np.asarray(phase).reshape(shape)
        command = np.asarray(command).reshape(-1, *shape)
        action = np.empty((self._lanes, len(wires.low)))
        action[:, wires.free] = np.clip(free, wires.low[wires.free], wires.high[wires.free])
        if self._controller.actuation.commands_force:
            self.share = command[0]
            action[:, wires.driven[0]] = wires.rest + (wires.push - wires.rest) * command[0].T
        else:
            for entry, place in zip(wires.driven, command, strict=True):
                action[:, entry] = np.clip(place.T, wires.low[entry], wires.high[entry])
        return action

    def _of_limbs(self, x: np.ndarray) -> np.ndarray:
        """[limbs, lanes] as the controller has it: one limb has no axis."""
        return x[0] if self._wires.limbs == 1 else x
