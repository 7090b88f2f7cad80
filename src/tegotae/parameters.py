"""Frozen dataclasses whose fields may be numbers or, inside a compiled program, traced arrays."""

from __future__ import annotations

import dataclasses
from typing import TypeVar

import jax

T = TypeVar("T")


def traceable(cls: type[T]) -> type[T]:
    """Make a frozen dataclass a JAX pytree whose every field is a leaf.

    The constructor (and so its validation) runs for a user's values, never for traced ones: a
    changed mass or stiffness does not compile a new program.
    """
    names = [field.name for field in dataclasses.fields(cls)]  # type: ignore[arg-type]

    def flatten(value: T):
        return tuple(getattr(value, name) for name in names), None

    def unflatten(_, leaves) -> T:
        value = object.__new__(cls)
        for name, leaf in zip(names, leaves, strict=True):
            object.__setattr__(value, name, leaf)
        return value

    jax.tree_util.register_pytree_node(cls, flatten, unflatten)
    return cls
