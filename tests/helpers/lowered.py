"""Functions evaluated as native code, lane by lane."""

from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
import llvmlite.binding as llvm
import numpy as np

from lanewise.episode import TracedEpisode, compile_episode


def available_targets() -> list[str]:
    """Targets that this machine runs."""
    features = llvm.get_host_cpu_features()
    wide = {"avx2": "avx2", "avx512": "avx512f"}
    return ["scalar", *(name for name, needed in wide.items() if features.get(needed))]


def program(function: Callable[..., Any]) -> TracedEpisode:
    """The function of what is given, as what an episode of one tick records."""
    return TracedEpisode(
        lambda lanes, shared: lanes,
        lambda lanes, shared, state, index: state,
        lambda lanes, shared, state, last: (state, function(*state)),
    )


def evaluated(
    function: Callable[..., Any],
    *arrays: np.ndarray,
    dtype: str = "float32",
    target: str = "host",
    vectors: int = 2,
    threads: int = 1,
) -> Any:
    """Evaluate a function for arrays [lanes], as a pytree of arrays [lanes]."""
    shared: dict[str, Any] = {}
    kernel = compile_episode(
        program(function), arrays, shared, dtype, target=target, vectors=vectors
    )
    result: dict[int, Any] = {}

    def collect(first: int, lanes: int, channels: Any) -> None:
        result[first] = jax.tree.map(lambda x: np.array(x[0, ..., :lanes]), channels)

    kernel.run(arrays, shared, frames=1, ticks_per_frame=1, threads=threads, collect=collect)
    parts = [result[first] for first in sorted(result)]
    return jax.tree.map(lambda *entry: np.concatenate(entry, axis=-1), *parts)


def samples(dtype: str, n: int = 200) -> np.ndarray:
    """Numbers of all sorts: zeros, tiny and huge ones, infinities, no number, and many usual."""
    info = np.finfo(dtype)
    special = [0.0, info.smallest_subnormal, info.tiny, 1e-3, 0.5, 1.0, 1.5, 2.0, 3.0, 100.0]
    special += [float(info.max), np.inf]
    normal = np.random.default_rng(0).normal(size=n) * np.exp(
        np.random.default_rng(1).uniform(-6, 6, n)
    )
    return np.concatenate([special, np.negative(special), [np.nan], normal]).astype(dtype)


def same_bits(a: Any, b: Any) -> bool:
    """Return True if two pytrees of arrays are equal to the bit, NaN counted as equal."""

    def same(x: np.ndarray, y: np.ndarray) -> bool:
        if x.dtype.kind != "f":
            return bool((x == y).all())
        integers = f"i{x.dtype.itemsize}"
        return bool(((x.view(integers) == y.view(integers)) | (np.isnan(x) & np.isnan(y))).all())

    return all(same(x, y) for x, y in zip(jax.tree.leaves(a), jax.tree.leaves(b), strict=True))


def of_everything(x: Any, y: Any) -> dict[str, Any]:
    """A function with sums of products, divisions, branches, loops and elementary functions."""
    product = x * y + 0.1 * x - y * y
    ratio = jnp.where(x > 1.0, y / jnp.where(x > 1.0, x - 0.5, 1.0), y / 3.0)
    cosine, sine = jnp.cos(product), jnp.sin(ratio)

    def far() -> tuple[Any, Any]:
        return jnp.exp(-(x * x)) * cosine + sine, jnp.tanh(y) / (1.0 + x * x)

    def near() -> tuple[Any, Any]:
        return cosine, sine

    first, second = jax.lax.cond(jnp.any(jnp.abs(x) > 2.0), far, near)

    def goes_on(carry: Any) -> Any:
        return jnp.any(carry[0] < 1.0) & jnp.any(carry[2] < 20)

    def round_(carry: Any) -> Any:
        size, total, count = carry
        return 1.5 * size + 0.01, total + size * jnp.sqrt(size), count + 1

    begun = (jnp.minimum(jnp.abs(x), 2.0), jnp.zeros_like(x), jnp.zeros_like(x, dtype=jnp.int32))
    size, total, count = jax.lax.while_loop(goes_on, round_, begun)
    return {
        "product": product,
        "ratio": ratio,
        "branch": [first, second],
        "loop": [size, total, count],
        "angle": jnp.arctan2(y, x) + jnp.log1p(jnp.abs(x)) ** 1.5,
        "large": jnp.maximum(x, y) > jnp.minimum(x, 1.0),
    }
