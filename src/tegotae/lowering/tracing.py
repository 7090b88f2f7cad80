"""Traces of a computation that keep what people call by name."""

from __future__ import annotations

import functools
from collections.abc import Callable, Generator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import ParamSpec, TypeVar

from tegotae._support.transforms import jit

P = ParamSpec("P")
T = TypeVar("T")

_kept: ContextVar[bool] = ContextVar("kept", default=False)


def stays_a_call(function: Callable[P, T]) -> Callable[P, T]:
    """Let the function stay one call in traces made within `keeping_calls`.

    Everywhere else it is the plain function: nothing of it shows in a compiled program.
    """
    apart = jit(function)

    @functools.wraps(function)
    def call(*args: P.args, **kwargs: P.kwargs) -> T:
        return (apart if _kept.get() else function)(*args, **kwargs)

    return call


@contextmanager
def keeping_calls() -> Generator[None]:
    """While this lasts, traces show calls of functions that are made for it.

    Example:
        >>> import jax
        >>> import jax.numpy as jnp
        >>> @stays_a_call
        ... def doubled(x):
        ...     return x + x
        >>> with keeping_calls():
        ...     trace = jax.make_jaxpr(lambda x: doubled(x))(jnp.ones(()))
        >>> trace.eqns[0].params["name"]
        'doubled'
    """
    token = _kept.set(True)
    try:
        yield
    finally:
        _kept.reset(token)
