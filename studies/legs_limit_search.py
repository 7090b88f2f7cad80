"""The search for gaits of least cost: many evolution strategies at once, a rollout a candidate."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from legs_limit_gaits import OverStrides, Space
from tegotae.parts.bodies import Walker
from tegotae.simulation.rollout import Timing
from tegotae.training.algorithms import CMAES

TIMING = Timing(duration_s=32.0, tick_s=0.0125, frame_s=0.1)
"""Of a candidate's rollout."""
SETTLE_S = 10.0
"""Of it left to settle."""
POPULATION = 16
"""Candidates of a generation."""
TRACKING = 4.0
"""What a speed that is off by all of itself costs, in units of log CoT."""


class Found(NamedTuple):
    """The best of every start, [starts] first."""

    x: np.ndarray
    loss: np.ndarray
    speed: np.ndarray
    cost: np.ndarray
    history: np.ndarray
    """The least loss after every generation, [generations, starts]."""


def losses(
    space: Space, x: np.ndarray, speed: np.ndarray, timing: Timing = TIMING
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """log CoT + 4 |v / v* - 1| of vectors [lanes, size] for speeds v* [lanes]; speeds, costs.

    Of two windows the one with the larger loss counts.
    """
    weights, scenario = space.decoded(x, speed)
    settle = SETTLE_S / TIMING.duration_s * timing.duration_s
    walked = space.engine(OverStrides(settle), timing).run(weights, scenario, Walker())
    v, power, turn, fall = (np.asarray(a, float) for a in walked)
    cost = np.where(v > 0.0, power / np.maximum(v, 1e-3), 1e6)
    loss = np.log(np.clip(cost, 1e-6, 1e6)) + TRACKING * np.abs(v / speed - 1.0)
    loss = loss + 2.0 * np.maximum(turn - 0.05, 0.0)
    worse = np.argmax(loss, axis=0), np.arange(len(x))
    loss = np.where(np.isfinite(fall), 100.0 - np.nan_to_num(fall, posinf=0.0), loss[worse])
    return np.where(np.isfinite(loss), loss, 200.0), v[worse], cost[worse]


def search(
    space: Space,
    speed: np.ndarray,
    start: np.ndarray,
    *,
    std: float,
    generations: int,
    seed: int,
    checkpoint: Path,
    progress: Callable[[int, np.ndarray], None] = lambda *_: None,
) -> Found:
    """One strategy (CMA-ES) a start, all in one rollout a generation.

    Args:
        space: what gaits there are.
        speed: v* of each start [starts].
        start: vectors [starts, size].
        std: first deviation.
        generations: how many.
        seed: of the draws.
        checkpoint: file from which it goes on, and where it is written every 20 generations.
        progress: called with the generation and the losses.
    """
    starts, size = start.shape
    algorithm = CMAES(population=POPULATION, std=std)
    strategy, settings = algorithm.strategy(size), algorithm.parameters(size)
    keys = jax.random.split(jax.random.key(seed), starts)

    @jax.jit
    def begin(mean):
        return jax.lax.map(lambda a: strategy.init(*a, settings), (keys, mean))

    @jax.jit
    def ask(number, state):
        own = jax.vmap(lambda key: jax.random.fold_in(key, number))(keys)
        return jax.lax.map(lambda a: strategy.ask(*a, settings), (own, state))

    @jax.jit
    def tell(x, loss, state):
        return jax.lax.map(lambda a: strategy.tell(*a, settings)[0], (keys, x, loss, state))

    state = begin(jnp.asarray(start, "float32"))
    leaves, tree = jax.tree.flatten(state)
    best = Found(np.array(start), *(np.full(starts, np.inf) for _ in range(3)), np.zeros((0,)))
    history: list[np.ndarray] = []
    if checkpoint.exists():
        with np.load(checkpoint) as kept:
            state = jax.tree.unflatten(tree, [kept[f"state{k}"] for k in range(len(leaves))])
            best = Found(*(kept[field].copy() for field in Found._fields))
        history = list(best.history)
    lanes = np.repeat(speed, POPULATION)
    for number in range(len(history), generations):
        x, state = ask(number, state)
        own = np.array(x, float)
        if number == 0:
            own[:, 0] = start
        found = losses(space, own.reshape(-1, size), lanes)
        loss, v, cost = (a.reshape(starts, POPULATION) for a in found)
        state = tell(jnp.asarray(own, "float32"), jnp.asarray(loss, "float32"), state)
        k, each = loss.argmin(axis=1), np.arange(starts)
        for s in each[loss[each, k] < best.loss]:
            best.x[s], best.loss[s] = own[s, k[s]], loss[s, k[s]]
            best.speed[s], best.cost[s] = v[s, k[s]], cost[s, k[s]]
        history.append(best.loss.copy())
        progress(number + 1, best.loss)
        if (number + 1) % 20 == 0 or number + 1 == generations:
            best = best._replace(history=np.array(history))
            kept = {f"state{k}": leaf for k, leaf in enumerate(jax.tree.leaves(state))}
            np.savez(checkpoint, speed_wanted=speed, **best._asdict(), **kept)
    return best
