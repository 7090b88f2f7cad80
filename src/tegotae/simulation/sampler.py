"""One sample of limbs on an environment, as native code, or by XLA where there is none."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache, partial
from typing import TYPE_CHECKING, Any, cast

import jax
import jax.numpy as jnp
import numpy as np

from lanewise.nodes import CannotLower
from tegotae._support import compiled
from tegotae._support.engines import NATIVE, selected
from tegotae._support.transforms import jit_with_static
from tegotae.parts._shapes import StateTree
from tegotae.parts.controller import Controller
from tegotae.simulation.integrators import sample

if TYPE_CHECKING:
    from lanewise.function import FunctionKernel
    from lanewise.machine import NativeStep

Sampled = tuple[StateTree, np.ndarray, np.ndarray, np.ndarray]
"""Oscillators, command, feedback and phase, as `sample` returns them."""

_by_xla = jit_with_static(sample, (0,))


def sampler(
    controller: Controller, lanes: int, sensed: Sequence[str], scaled: Sequence[str]
) -> Callable[..., Sampled]:
    """Return `sample` of a controller for so many lanes, as a function that takes its weights
    first.

    Args:
        controller: of all limbs.
        lanes: how many are sampled side by side.
        sensed: the signals that the limbs sense.
        scaled: those that have a scale.
    """
    if selected() == NATIVE:
        kernel = _kernel(controller, lanes, tuple(sensed), tuple(scaled))
        if kernel is not None:
            return _stepping(kernel.step(compiled), lanes)
    return cast(Callable[..., Sampled], partial(_by_xla, controller))


@lru_cache(16)
def _kernel(
    controller: Controller, lanes: int, sensed: tuple[str, ...], scaled: tuple[str, ...]
) -> FunctionKernel | None:
    """Return the code, or None if an operation has none."""
    from lanewise.function import compile_function  # llvmlite may be missing

    number = jax.ShapeDtypeStruct((), "float32")
    of_limbs = jax.ShapeDtypeStruct((*controller.limb_shape, 1), "float32")
    numbers = {
        "omega": of_limbs,
        "scales": dict.fromkeys(scaled, number),
        "max_force": number,
        "step_s": number,
    }
    weights = jax.ShapeDtypeStruct((controller.n_weights, 1), "float32")
    inputs = weights, dict.fromkeys(sensed, of_limbs), of_limbs, numbers

    def step(oscillator: StateTree, inputs: Any) -> tuple[StateTree, Any]:
        weights, sensed, added, numbers = inputs
        ahead, *outputs = sample(controller, weights, oscillator, sensed, added, numbers)
        return ahead, outputs

    assert controller.oscillator is not None
    state = controller.oscillator.start(jnp.zeros(of_limbs.shape))
    try:
        return compile_function(step, state, inputs, lanes=lanes)
    except CannotLower:
        return None


def _stepping(step: NativeStep, lanes: int) -> Callable[..., Sampled]:
    """Return the step of a kernel, which has memory of its own, as a function on values like
    `sample`.
    """

    def views(memory: np.ndarray) -> list[np.ndarray]:
        entries = [memory[name] for name in memory.dtype.names or ()]
        return [entry[..., :lanes] if entry.ndim else entry for entry in entries]

    state, inputs, outputs = map(views, (step.state, step.inputs, step.outputs))

    def sampled(
        weights: np.ndarray,
        oscillator: StateTree,
        sensed: dict[str, np.ndarray],
        added: np.ndarray,
        numbers: dict[str, Any],
    ) -> Sampled:
        leaves, structure = jax.tree.flatten(oscillator)
        numbers_in = jax.tree.leaves((weights, sensed, added, numbers))
        for view, value in zip((*state, *inputs), (*leaves, *numbers_in), strict=True):
            view[...] = value
        step()
        ahead = jax.tree.unflatten(structure, [view.copy() for view in state])
        command, feedback, phase = (view.copy() for view in outputs)
        return ahead, command, feedback, phase

    return sampled
