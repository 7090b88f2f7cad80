"""JAX's transformations, typed by what they transform, which its own annotations leave open."""

from __future__ import annotations

from collections.abc import Callable
from typing import ParamSpec, TypeVar

import jax
from jax.typing import DTypeLike

P = ParamSpec("P")
T = TypeVar("T")


def jit(function: Callable[P, T]) -> Callable[P, T]:
    """`jax.jit`: the function as a compiled program."""
    return jax.jit(function)


def jit_with_static(
    function: Callable[P, T], static: tuple[int, ...], *, inline: bool = False
) -> Callable[P, T]:
    """`jax.jit` with arguments that shape the program, and perhaps as part of the caller's."""
    return jax.jit(function, static_argnums=static, inline=inline)


def compiled_for(
    function: Callable[P, T], *like: P.args, **keywords: P.kwargs
) -> jax.stages.Compiled:
    """The program of a function for arrays of these shapes, compiled at once."""
    return jax.jit(function).lower(*like, **keywords).compile()


def jvp(function: Callable[[T], T], point: T, along: T) -> tuple[T, T]:
    """`jax.jvp` of one argument: the value there, and its derivative along a direction."""
    return jax.jvp(function, (point,), (along,))  # type: ignore[return-value]


def register_pytree(
    kind: type[T],
    flatten: Callable[[T], tuple[tuple[object, ...], tuple[object, ...]]],
    unflatten: Callable[[tuple[object, ...], tuple[object, ...]], T],
) -> None:
    """`jax.tree_util.register_pytree_node`: from a value to its leaves and the rest, and back."""
    jax.tree_util.register_pytree_node(kind, flatten, unflatten)


def cond(holds: jax.Array, if_true: Callable[[], T], otherwise: Callable[[], T]) -> T:
    """`jax.lax.cond` of functions without arguments."""
    return jax.lax.cond(holds, if_true, otherwise)


def shapes_of(function: Callable[P, T], *args: P.args, **kwargs: P.kwargs) -> T:
    """`jax.eval_shape`: what the function returns, with shapes in place of arrays."""
    return jax.eval_shape(function, *args, **kwargs)


def iota(dtype: DTypeLike, shape: tuple[int, ...], dimension: int) -> jax.Array:
    """`jax.lax.broadcasted_iota`: numbers from 0 on along one axis."""
    return jax.lax.broadcasted_iota(dtype, shape, dimension)
