"""What all checks share: trial lanes, and one way of calling a method and checking its arrays."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import TYPE_CHECKING, TypeVar, cast

import jax
import jax.numpy as jnp
import numpy as np
import numpy.typing as npt

from tegotae._support.errors import TegotaeError, is_of
from tegotae._support.transforms import jit

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

T = TypeVar("T")

LANES = 6
"""Trial lanes."""

SPOILED = 2
"""The lane that gets other values when lanes are tested for independence."""

DTYPES = ("float32", "float64")


def require_part(part: object, contract: type) -> str:
    """The part's name, after seeing that it is an instance of its contract and a plain value.

    Raises:
        TegotaeError: for a class, an object of another kind, or one that is no frozen dataclass.
    """
    kind = contract.__name__
    if isinstance(part, type):
        lacking = sorted(getattr(part, "__abstractmethods__", ()))
        lacks = f"; define {', '.join(lacking)} first" if lacking else ""
        raise TegotaeError(f"{part.__name__} is a class; check an instance of it{lacks}")
    name = type(part).__name__
    if not isinstance(part, contract):
        raise TegotaeError(
            f"{name} is no {kind}; make it a subclass of {contract.__module__}.{kind}"
        )
    if not _is_frozen_dataclass(type(part)):
        raise TegotaeError(
            f"{name} is no frozen dataclass; put @dataclass(frozen=True) above the class"
        )
    return name


def require_hashable(name: str, part: object) -> None:
    """Raise `TegotaeError` unless equal parts are equal keys of one compiled program."""
    try:
        hash(part)
    except TypeError as error:
        raise TegotaeError(
            f"{name} cannot be hashed ({error}); use tuples and numbers as its fields"
        ) from None
    try:
        same: object = part == dataclasses.replace(cast("DataclassInstance", part))
    except Exception as error:
        raise TegotaeError(
            f"{name} cannot be compared with a copy of itself ({first_line(error)})"
        ) from None
    if not same:
        raise TegotaeError(
            f"{name} does not equal a copy of itself; use tuples and numbers as its fields, and "
            "leave __eq__ to the dataclass"
        )


def _is_frozen_dataclass(kind: type) -> bool:
    parameters = getattr(kind, "__dataclass_params__", None)
    # A subclass without a decorator of its own inherits its parent's dataclass parameters.
    return "__dataclass_params__" in vars(kind) and bool(parameters and parameters.frozen)


def first_line(error: Exception) -> str:
    """An exception in one line."""
    lines = str(error).strip().splitlines()
    return f"{type(error).__name__}: {lines[0]}" if lines else type(error).__name__


def listed(array: npt.ArrayLike | jax.Array) -> str:
    """An array's values in one line."""
    return ", ".join(f"{x:.5g}" for x in np.ravel(array))


def attempt(what: str, function: Callable[..., T], *args: object) -> T:
    """The function's result inside a compiled program.

    Raises:
        TegotaeError: if it raises, naming `what`, or if it needs an array's value in Python.
    """
    try:
        return jit(function)(*args)
    except TegotaeError:
        raise
    except (
        jax.errors.ConcretizationTypeError,
        jax.errors.TracerArrayConversionError,
        jax.errors.TracerIntegerConversionError,
    ):
        raise TegotaeError(
            f"{what} uses an array's value in Python (if, float(), NumPy or math); "
            "use jnp functions, and jnp.where in place of if"
        ) from None
    except Exception as error:
        raise TegotaeError(f"{what} raised {first_line(error)}") from error


def require_arrays(
    what: str,
    value: object,
    dtype: str,
    *,
    kind: str = "finite",
    before: tuple[int, ...] | None = (),
) -> None:
    """Raise `TegotaeError` unless every array of a pytree has the lanes' shape and the dtype.

    Args:
        what: name of the value in the message.
        value: a pytree of arrays.
        dtype: what the lanes were given as; "bool" for conditions.
        kind: "finite", or "events" where NaN means none.
        before: the axes before that of the lanes, such as the limbs'; None for any.
    """
    leaves = jax.tree.leaves(value)
    for leaf in leaves:
        array = np.asarray(leaf)
        wanted = (*(array.shape[:-1] if before is None else before), LANES)
        if array.shape != wanted:
            axes = "the shape of the lanes" if len(wanted) == 1 else f"shape {wanted}, limbs first"
            raise TegotaeError(
                f"{what} has shape {array.shape} for lanes of shape ({LANES},); it must have "
                f"{axes} (jnp.full_like or jnp.zeros_like makes an array of a constant)"
            )
        if array.dtype != dtype:
            raise TegotaeError(
                f"{what} is {array.dtype} for {dtype} lanes; it must keep the lanes' type (write "
                "constants as Python numbers, not as NumPy or JAX arrays)"
            )
        if kind == "finite" and dtype != "bool" and not np.isfinite(array).all():
            raise TegotaeError(f"{what} is not finite on ordinary lanes: {listed(array)}")


def require_independent(what: str, function: Callable[..., object], *args: object) -> None:
    """Raise `TegotaeError` if spoiling one lane of the arguments changes another lane's result.

    Args:
        what: name of the function in the message.
        function: of pytrees of arrays.
        args: the arguments; of every array [..., LANES] a lane is spoiled.
    """
    program = jit(function)
    sound = program(*args)
    for poison in (jnp.nan, 17.0):

        def spoil(x: jax.Array, poison: float = poison) -> jax.Array:
            if x.shape[-1:] != (LANES,):
                return x
            return x.at[..., SPOILED].set(jnp.asarray(poison, x.dtype))

        spoiled = jax.tree.map(spoil, args)
        for before, after in zip(
            jax.tree.leaves(sound), jax.tree.leaves(program(*spoiled)), strict=True
        ):
            others = np.arange(LANES) != SPOILED
            if not np.array_equal(
                np.asarray(before)[..., others], np.asarray(after)[..., others], equal_nan=True
            ):
                raise TegotaeError(
                    f"{what} lets one lane change another; use elementwise functions only (no sum, "
                    "mean, max, sort or roll over lanes)"
                )


def require_positive(what: str, value: object) -> None:
    """Raise `TegotaeError` unless the value is a single finite number above zero."""
    try:
        number = float(cast(float, value))
    except (TypeError, ValueError):
        raise TegotaeError(f"{what} is {value!r}; it must be one number") from None
    if not (np.isfinite(number) and number > 0.0):
        raise TegotaeError(f"{what} is {number:g}; it must be finite and greater than 0")


def require_names(what: str, names: object) -> None:
    """Raise `TegotaeError` unless the value is a tuple of strings."""
    if not isinstance(names, tuple) or not all(
        is_of(name, str) for name in cast(tuple[object, ...], names)
    ):
        hint = f"({names!r},)" if isinstance(names, str) else 'such as ("spring_force",)'
        raise TegotaeError(f"{what} is {names!r}; it must be a tuple of names: {hint}")


def lanes_of(dtype: str, low: float, high: float, seed: int) -> jax.Array:
    """Trial values, all different, in [low, high)."""
    return jnp.asarray(np.random.default_rng(seed).uniform(low, high, LANES), dtype)


def same_structure(what: str, value: object, like: object) -> None:
    """Raise `TegotaeError` unless a returned state has the form of the state at the start."""
    if jax.tree.structure(value) != jax.tree.structure(like):
        raise TegotaeError(
            f"{what} returns {_form(value)}; it must return a state of the same form as at the "
            f"start, {_form(like)}"
        )


def _form(state: object) -> str:
    form = type(state).__name__
    return f"{form} of {len(cast(tuple[object, ...], state))}" if is_of(state, tuple) else form
