"""The tiny network that a learned term is."""

from __future__ import annotations

import functools
from collections.abc import Sequence
from dataclasses import dataclass
from typing import cast

import jax
import jax.numpy as jnp

from tegotae._support.errors import TegotaeError
from tegotae.parts._shapes import Weights
from tegotae.parts.maths import (
    RATIOS_PER_DIVISION,
    TANH_SCALE,
    one_plus_exp2,
    sum_of_ratios,
)
from tegotae.parts.parameters import whole
from tegotae.parts.terms.base import Signals, Term
from tegotae.parts.weight_names import WeightName

PHASE = "phase"

_WIDEST_WRITTEN_OUT = 12
"""Neurons up to which a network is compiled neuron by neuron; wider ones are a loop, which is
as fast, and compiles in the same time for ten thousand weights as for a hundred."""


def as_read(inputs: Sequence[str]) -> tuple[str, ...]:
    """Return the inputs of a network, the phase as its sine and cosine."""
    pairs = {PHASE: ("sin_phase", "cos_phase")}
    return tuple(name for signal in inputs for name in pairs.get(signal, (signal,)))


@dataclass(frozen=True)
class Network(Term):
    """A network with one tanh layer, `Σ_j v_j tanh(Σ_i w_ji x_i + b_j)`, h·(inputs + 2) weights.

    The hidden layer has biases, the linear output has none. The input `phase` enters as
    (sin φ, cos φ), never as a raw angle; every other signal enters dimensionless.

    Args:
        inputs: names of signals.
        hidden: number of hidden neurons h.

    Raises:
        TegotaeError: for no inputs, or fewer than one hidden neuron.

    Source: paper equations 3 and 4, where networks stand for A′, R and G. Their form is this
    library's choice (docs/reproduction/fidelity).

    Example:
        >>> Network(("phase", "spring_force"), hidden=8).n_weights
        40
    """

    inputs: tuple[str, ...]
    hidden: int = whole()

    def __post_init__(self) -> None:
        super().__post_init__()
        if not self.inputs:
            raise TegotaeError("a network has no inputs; name at least one signal")

    @property
    def reads(self) -> tuple[str, ...]:
        """Signals read, the phase as its sine and cosine."""
        return as_read(self.inputs)

    @property
    def n_weights(self) -> int:
        """h·(inputs + 2): per neuron its input weights, its bias and its output weight."""
        return self.hidden * (len(self.reads) + 2)

    @property
    def weight_names(self) -> tuple[WeightName, ...]:
        """Names of the weights: of each neuron one per input, the bias and the output."""
        entries = (*self.reads, "bias", "output")
        return tuple(("neuron", j, name) for j in range(self.hidden) for name in entries)

    def initial(self, key: jax.Array) -> jax.Array:
        """Return normal weights of standard deviation 1/√inputs (output: 1/√h), biases
        normal(0, 0.5).
        """
        n_inputs = len(self.reads)
        per_neuron = jnp.array([n_inputs**-0.5] * n_inputs + [0.5, self.hidden**-0.5])
        normal = jax.random.normal(key, (self.hidden, n_inputs + 2))
        return (normal * per_neuron[None, :]).reshape(-1)

    def __call__(self, weights: Weights, signals: Signals) -> jax.Array:
        """Return the network's output. Neuron j owns a run of weights: w_j1 ... w_jn, b_j, v_j."""
        x = [signals.dimensionless(name) for name in self.reads]
        stride = len(x) + 2
        written_out = self.hidden
        if self.hidden > _WIDEST_WRITTEN_OUT:
            written_out = self.hidden % RATIOS_PER_DIVISION
        first = (self.hidden - written_out) * stride
        neurons = [weights[start : start + stride] for start in range(first, len(weights), stride)]
        output = _layer(neurons, x) if neurons else jnp.zeros_like(x[0])
        if not first:
            return output
        rows = jnp.asarray(weights)[:first]
        rows = rows.reshape(-1, RATIOS_PER_DIVISION, stride, *rows.shape[1:])

        def further(output: jax.Array, row: jax.Array) -> tuple[jax.Array, None]:
            return output + _layer(cast(Sequence[Weights], row), x), None  # an array is one, too

        return jax.lax.scan(further, output, rows)[0]


def _layer(neurons: Sequence[Weights], x: Sequence[jax.Array]) -> jax.Array:
    """Return the activations of neurons with these weights for these inputs."""
    single = x[0].dtype == jnp.float32
    scale = TANH_SCALE if single else 1.0
    x = [scale * x_i for x_i in x]
    outputs: list[jax.Array] = []
    drives: list[jax.Array] = []
    # A matrix product of such small, per-lane matrices is slow.
    for *w, bias, v in neurons:
        drive = scale * bias
        for w_i, x_i in zip(w, x, strict=True):
            drive = drive + w_i * x_i
        drives.append(drive)
        outputs.append(v)
    if not single:
        return functools.reduce(
            jnp.add, [v * jnp.tanh(drive) for v, drive in zip(outputs, drives, strict=True)]
        )
    # v tanh x = v - 2v / (1 + 2^z): divisions are a third of a tick, if every neuron has its own.
    return functools.reduce(jnp.add, outputs) - sum_of_ratios(
        [(2.0 * v, one_plus_exp2(z)) for v, z in zip(outputs, drives, strict=True)]
    )
