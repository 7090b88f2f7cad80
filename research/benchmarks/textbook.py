"""Baseline: the textbook JAX form, `vmap` of a `scan` over one rollout, with JAX as it comes.

Run as a program, it prints ticks per second. It advances the same
scheme with the same body, but writes the networks as matrix products and takes JAX's own sine.
"""

from __future__ import annotations

import json
import sys
import time
from dataclasses import dataclass
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np

from tegotae.parts.bodies import Hopper
from tegotae.parts.controller import Controller, Tegotae
from tegotae.parts.oscillators import PhaseOscillator
from tegotae.parts.terms import LearnedActuation, Network
from tegotae.simulation.integrators import PredictorCorrector
from tegotae.simulation.loop import ClosedLoop
from tegotae.simulation.world import Scenario
from tegotae.systems.recipe import recipe


class ProductNetwork(Network):
    """A network as two matrix products."""

    def __call__(self, weights, signals):
        x = jnp.stack([signals.dimensionless(name) for name in self.reads])
        w = jnp.stack(list(weights)).reshape(self.hidden, len(self.reads) + 2)
        return jnp.dot(w[:, -1], jnp.tanh(jnp.dot(w[:, :-2], x) + w[:, -2]))


class ProductActuation(ProductNetwork, LearnedActuation):
    """The product feedback of this page as an actuation."""


@dataclass(frozen=True)
class LibrarySine(PhaseOscillator):
    """The phase oscillator with JAX's own sine and cosine."""

    def sin_cos(self, state):
        return jnp.sin(state.phase), jnp.cos(state.phase)


def textbook_controller() -> Controller:
    """Return the ART controller of the benchmark, in textbook style."""
    ours = recipe("ART").controller()
    terms = {
        role: ProductNetwork(term.inputs, term.hidden) if isinstance(term, Network) else term
        for role, term in ours.terms.items()
    }
    actuation = ours.actuation
    assert isinstance(actuation, LearnedActuation)
    return Controller(
        ProductActuation(actuation.inputs, actuation.hidden),
        LibrarySine(),
        Tegotae(terms["action"], terms["reaction"], terms["gain"]),
    )


@partial(jax.jit, static_argnums=(0, 3))
def textbook_rollouts(
    static: Controller, weights: jax.Array, tick_s: jax.Array, ticks: int
) -> jax.Array:
    """Return the final heights, of one rollout per row of weights."""
    body, loop = Hopper(), ClosedLoop(static, PredictorCorrector())

    def rollout(row: jax.Array) -> jax.Array:
        scenario = jax.tree.map(jnp.float32, Scenario(omega=5.0))
        rows, scenario = loop.spread(tuple(row), scenario)

        def step(carry, index):
            lane, work, climb = carry
            lane, output = loop.tick(rows, body, scenario, lane, index, tick_s)
            contact = output.contact
            return (lane, work + jnp.abs(contact.work_j), climb + contact.climb_flight_m), None

        begun = loop.start(rows, body, scenario, tick_s), jnp.float32(0.0), jnp.float32(0.0)
        (lane, work, climb), _ = jax.lax.scan(step, begun, jnp.arange(ticks))
        return lane.moment.body.height + work + climb

    return jax.vmap(rollout)(weights)


def textbook_ticks_per_second(lanes: int = 1024, ticks: int = 500) -> float:
    """Return the control ticks per second, over all lanes; the best of three runs after
    compilation.
    """
    static = textbook_controller()
    weights = np.random.default_rng(0).normal(size=(lanes, static.n_weights)) * 0.5
    lanes_first = jnp.asarray(weights, "float32")
    times = []
    for _ in range(4):
        begun = time.perf_counter()
        textbook_rollouts(static, lanes_first, jnp.float32(0.001), ticks).block_until_ready()
        times.append(time.perf_counter() - begun)
    return lanes * ticks / min(times[1:])


if __name__ == "__main__":
    print(json.dumps(textbook_ticks_per_second(int(sys.argv[1]))))
