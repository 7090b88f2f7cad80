"""Closed loops as native code, tick by tick beside XLA."""

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from lanewise.episode import TracedEpisode, compile_episode
from lowered import same_bits
from tegotae import Scenario
from tegotae.parts.bodies import Bar, Hopper, Walker
from tegotae.parts.terms import EllipticFoot
from tegotae.simulation.integrators import Hold, PredictorCorrector
from tegotae.simulation.loop import ClosedLoop
from tegotae.systems.recipe import recipe

LANES = 19
TICKS = 60


def walking():
    return dataclasses.replace(
        recipe("V-sector-w8").controller(), limbs=4, actuation=EllipticFoot()
    )


CASES = {
    "ART on a hopper": (recipe("ART").controller(), Hopper(), PredictorCorrector(), "float32", 1.0),
    "a held controller on a hopper": (
        recipe("V-sector-w8").controller(),
        Hopper(),
        Hold(),
        "float64",
        1.0,
    ),
    "a bar": (
        dataclasses.replace(recipe("V-sector-w8").controller(), limbs=2),
        Bar(),
        PredictorCorrector(),
        "float32",
        1.0,
    ),
    "a walker": (walking(), Walker(), PredictorCorrector(), "float64", 0.58),
}


def scenario(limbs, height, dtype):
    rng = np.random.default_rng(0)
    shape = (limbs, LANES) if limbs > 1 else (LANES,)

    def lanes(value):
        return np.full(LANES, value, dtype)

    return Scenario(
        omega=np.full(shape, 5.0, dtype),
        height_m=(height + 0.01 * rng.uniform(size=LANES)).astype(dtype),
        velocity_m_per_s=lanes(0.0),
        phase_rad=rng.uniform(0.0, 6.0, shape).astype(dtype),
        drop_m=lanes(0.0),
        drop_time_s=lanes(np.inf),
    )


def program(loop):
    def started(lanes, shared):
        weights, meets = lanes
        rows, meets = loop.spread(list(weights), meets)
        return loop.start(rows, shared["body"], meets, shared["tick_s"])

    def ticked(lanes, shared, state, index):
        weights, meets = lanes
        rows, meets = loop.spread(list(weights), meets)
        return loop.tick(rows, shared["body"], meets, state, index, shared["tick_s"])[0]

    return TracedEpisode(started, ticked, lambda lanes, shared, state, last: (state, state))


DUPLICATES = ("ART on a hopper", "a walker")
"""Quickly checked by `tests/simulation/test_native.py` alone, in the engine, tick by tick, too."""


@pytest.mark.parametrize(
    "name",
    [pytest.param(n, marks=pytest.mark.thorough if n in DUPLICATES else ()) for n in CASES],
)
def test_a_closed_loop_goes_on_tick_by_tick_as_under_xla(name):
    controller, body, integrator, dtype, height = CASES[name]
    loop = ClosedLoop(controller, integrator)
    weights = 0.5 * np.random.default_rng(1).normal(size=(controller.n_weights, LANES))
    lanes = weights.astype(dtype), scenario(body.limbs, height, dtype)
    with jax.enable_x64(dtype == "float64"):
        of_body = jax.tree.map(lambda x: np.asarray(x, dtype), body)
        shared = {"body": of_body, "tick_s": np.asarray(0.001, dtype)}
        complete = program(loop)
        kernel = compile_episode(complete, lanes, shared, dtype)
        frames = []

        def collect(first, n, state):
            frames.append((first, jax.tree.map(lambda x: np.array(x[..., :n]), state)))

        kernel.run(lanes, shared, frames=TICKS, ticks_per_frame=1, threads=1, collect=collect)
        frames.sort(key=lambda group: group[0])
        native = jax.tree.map(
            lambda *parts: np.concatenate(parts, axis=-1), *(state for _, state in frames)
        )

        @jax.jit
        def under_xla(lanes, shared):
            begun = complete.start(lanes, shared)

            def step(state, index):
                state = complete.tick(lanes, shared, state, index)
                return state, state

            return jax.lax.scan(step, begun, jnp.arange(TICKS, dtype="int32"))[1]

        xla = under_xla(jax.tree.map(jnp.asarray, lanes), jax.tree.map(jnp.asarray, shared))
    tolerance = 3e-4 if dtype == "float32" else 1e-11
    for got, expected in zip(jax.tree.leaves(native), jax.tree.leaves(xla), strict=True):
        np.testing.assert_allclose(got, np.asarray(expected), tolerance, tolerance)


def test_an_episode_cut_into_other_frames_is_the_same():
    controller, body, integrator, dtype, height = CASES["ART on a hopper"]
    loop = ClosedLoop(controller, integrator)
    weights = 0.5 * np.random.default_rng(1).normal(size=(controller.n_weights, LANES))
    lanes = weights.astype(dtype), scenario(body.limbs, height, dtype)
    shared = {
        "body": jax.tree.map(lambda x: np.asarray(x, dtype), body),
        "tick_s": np.asarray(0.001, dtype),
    }
    kernel = compile_episode(program(loop), lanes, shared, dtype)
    ends = []
    for frames, ticks in ((TICKS, 1), (4, TICKS // 4)):

        def collect(first, n, state):
            ends.append(jax.tree.map(lambda x: np.array(x[-1, ..., :n]), state))

        kernel.run(lanes, shared, frames=frames, ticks_per_frame=ticks, collect=collect, threads=1)
    assert same_bits(ends[0], ends[1])
