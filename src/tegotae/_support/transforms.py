"""JAX's transformations, typed by what they transform, which its own annotations leave open."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, partial, wraps
from typing import ParamSpec, TypeVar

import jax
from jax.core import Tracer
from jax.typing import DTypeLike

from tegotae._support.xla_programs import one_module

P = ParamSpec("P")
T = TypeVar("T")


def jit(function: Callable[P, T]) -> Callable[P, T]:
    """Compile a function with `jax.jit`."""
    return jax.jit(function)


def jit_with_static(
    function: Callable[P, T], static: tuple[int, ...], *, inline: bool = False
) -> Callable[P, T]:
    """Compile a function with `jax.jit`, some of its arguments static; a caller's program may
    contain it.
    """
    return jax.jit(function, static_argnums=static, inline=inline)


def jit_in_one_module(
    function: Callable[P, T],
    static: tuple[int, ...] | None = None,
    *,
    static_names: tuple[str, ...] | None = None,
    level: int | None = None,
) -> Callable[P, T]:
    """Compile a function with `jax.jit` in less time (`one_module`); a caller's program may contain
    it, and is compiled in its own way.

    Args:
        function: a pure function of arrays.
        static: numbers of its arguments that are static.
        static_names: names of keywords that are static.
        level: XLA's effort, from 0; its own by default.
    """
    compiled = partial(jax.jit, function, static_argnums=static, static_argnames=static_names)
    effort = {} if level is None else {"xla_backend_optimization_level": level}

    @cache
    def program(is_part: bool) -> Callable[P, T]:
        return compiled() if is_part else compiled(compiler_options={**effort, **one_module()})

    @wraps(function)
    def call(*args: P.args, **kwargs: P.kwargs) -> T:
        leaves = jax.tree.leaves((args, kwargs))
        is_part = any(isinstance(leaf, Tracer) for leaf in leaves)
        return program(is_part)(*args, **kwargs)

    return call


def compiled_for(
    function: Callable[P, T], *like: P.args, **keywords: P.kwargs
) -> jax.stages.Compiled:
    """Compile the program of a function for arrays of these shapes at once."""
    return jax.jit(function).lower(*like, **keywords).compile(one_module())


def jvp(function: Callable[[T], T], point: T, along: T) -> tuple[T, T]:
    """Return `jax.jvp` of one argument: the value there, and its derivative along a direction."""
    return jax.jvp(function, (point,), (along,))  # type: ignore[return-value]


def register_pytree(
    kind: type[T],
    flatten: Callable[[T], tuple[tuple[object, ...], tuple[object, ...]]],
    unflatten: Callable[[tuple[object, ...], tuple[object, ...]], T],
) -> None:
    """Register a class with `jax.tree_util.register_pytree_node`, by its conversions to leaves and
    back.
    """
    jax.tree_util.register_pytree_node(kind, flatten, unflatten)


def cond(holds: jax.Array, if_true: Callable[[], T], otherwise: Callable[[], T]) -> T:
    """Return the result of `jax.lax.cond` for functions without arguments."""
    return jax.lax.cond(holds, if_true, otherwise)


def shapes_of(function: Callable[P, T], *args: P.args, **kwargs: P.kwargs) -> T:
    """Return the result's shapes by `jax.eval_shape`, in place of its arrays."""
    return jax.eval_shape(function, *args, **kwargs)


def iota(dtype: DTypeLike, shape: tuple[int, ...], dimension: int) -> jax.Array:
    """Return numbers from 0 on along one axis (`jax.lax.broadcasted_iota`)."""
    return jax.lax.broadcasted_iota(dtype, shape, dimension)
