"""Episodes of many lanes as native code: what a kernel gives, and to whom."""

import jax.numpy as jnp
import numpy as np
import pytest

from lanewise.episode import TracedEpisode, compile_episode

FRAMES, TICKS = 5, 4


def start(lanes, shared):
    return {"x": lanes["x"], "largest": jnp.full_like(lanes["x"], -jnp.inf)}


def tick(lanes, shared, state, index):
    x = (
        state["x"]
        + shared["step"] * (lanes["rate"] - state["x"])
        + 0.01 * index.astype(state["x"].dtype)
    )
    return {"x": x, "largest": jnp.maximum(state["largest"], x)}


def frame(lanes, shared, state, last):
    channels = {
        "x": state["x"],
        "largest": state["largest"],
        "high": state["x"] > 1.0,
        "last": last,
    }
    channels["last"] = jnp.broadcast_to(last, state["x"].shape)
    return {**state, "largest": jnp.full_like(state["x"], -jnp.inf)}, channels


PROGRAM = TracedEpisode(start, tick, frame)


def inputs(lanes=37, dtype="float32"):
    rng = np.random.default_rng(0)
    of_lanes = {name: rng.normal(size=lanes).astype(dtype) for name in ("x", "rate")}
    return of_lanes, {"step": np.asarray(0.125, dtype)}


def run(of_lanes, shared, dtype="float32", threads=1, **options):
    kernel = compile_episode(PROGRAM, of_lanes, shared, dtype, **options)
    groups = []

    def collect(first, n, channels):
        groups.append((first, n, {name: np.array(x[..., :n]) for name, x in channels.items()}))

    kernel.run(
        of_lanes, shared, frames=FRAMES, ticks_per_frame=TICKS, threads=threads, collect=collect
    )
    groups.sort(key=lambda group: group[0])
    assert [first for first, _, _ in groups] == list(
        np.cumsum([0, *(n for _, n, _ in groups)])[:-1]
    )
    return {
        name: np.concatenate([group[name] for _, _, group in groups], axis=-1)
        for name in groups[0][2]
    }


@pytest.mark.parametrize("dtype", ["float32", "float64"])
def test_a_kernel_rolls_out_every_lane_as_numpy_does(dtype):
    of_lanes, shared = inputs(dtype=dtype)
    result = run(of_lanes, shared, dtype)
    x = of_lanes["x"].astype("float64")
    for n in range(FRAMES):
        largest = np.full_like(x, -np.inf)
        for index in range(n * TICKS, (n + 1) * TICKS):
            x = x + 0.125 * (of_lanes["rate"] - x) + 0.01 * index
            largest = np.maximum(largest, x)
        tolerance = 1e-5 if dtype == "float32" else 1e-13
        np.testing.assert_allclose(result["x"][n], x, tolerance, tolerance)
        np.testing.assert_allclose(result["largest"][n], largest, tolerance, tolerance)
        assert (result["last"][n] == (n + 1) * TICKS - 1).all()
    assert result["x"].dtype == dtype
    assert result["high"].dtype == bool
    assert (result["high"] == (result["x"] > 1.0)).all()


def test_what_a_collector_raises_reaches_the_caller():
    of_lanes, shared = inputs()
    kernel = compile_episode(PROGRAM, of_lanes, shared, "float32")

    def collect(first, n, channels):
        raise RuntimeError("no more room")

    with pytest.raises(RuntimeError, match="no more room"):
        kernel.run(
            of_lanes, shared, frames=FRAMES, ticks_per_frame=TICKS, threads=2, collect=collect
        )
