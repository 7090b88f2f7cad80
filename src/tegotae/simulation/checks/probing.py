"""Trial of a part on a few lanes, and the requirements on its arrays, shared by all checks."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeVar, cast

import jax
import jax.numpy as jnp
import numpy as np
import numpy.typing as npt

from tegotae._support.errors import TegotaeError, formatted, is_of
from tegotae._support.transforms import jit

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

T = TypeVar("T")

LANES = 6
"""Trial lanes."""

SPOILED = 2
"""The lane that gets other values when lanes are tested for independence."""

DTYPES = ("float32", "float64")


@dataclass(frozen=True)
class PartTrial:
    """A part under test on lanes: each method raises `TegotaeError` for a broken promise.

    Every message begins with the part's name; `what` is what follows it, such as ".predict".

    Args:
        name: of the part.
        dtype: the type of the lanes.
    """

    name: str
    dtype: str = "float32"

    @classmethod
    def from_part(cls, part: object, *contracts: type) -> PartTrial:
        """Make a trial of an instance of one of the contracts that is a frozen dataclass, and no
        class."""
        if isinstance(part, type):
            lacking = sorted(getattr(part, "__abstractmethods__", ()))
            lacks = f"; define {', '.join(lacking)} first" if lacking else ""
            raise TegotaeError(f"{part.__name__} is a class; check an instance of it{lacks}")
        trial = PartTrial(type(part).__name__)
        kinds = " or ".join(contract.__name__ for contract in contracts)
        right = " or ".join(f"{contract.__module__}.{contract.__name__}" for contract in contracts)
        trial.require(isinstance(part, contracts), f" is no {kinds}; make it a subclass of {right}")
        # A subclass without a decorator of its own inherits its parent's dataclass parameters.
        parameters = vars(type(part)).get("__dataclass_params__")
        right = "put @dataclass(frozen=True) above the class"
        trial.require(parameters and parameters.frozen, f" is no frozen dataclass; {right}")
        return trial

    def require(self, holds: object, otherwise: str) -> None:
        """Raise `TegotaeError` unless a condition holds; the message follows the part's name."""
        if not bool(holds):
            raise TegotaeError(f"{self.name}{otherwise}")

    def hashable(self, part: object) -> None:
        """Require that equal parts are equal keys of one compiled program."""
        right = "use tuples and numbers as its fields"
        try:
            hash(part)
        except TypeError as error:
            raise TegotaeError(f"{self.name} cannot be hashed ({error}); {right}") from None
        try:
            equal = bool(part == dataclasses.replace(cast("DataclassInstance", part)))
        except Exception as error:
            raise TegotaeError(
                f"{self.name} cannot be compared with a copy of itself ({formatted(error)})"
            ) from None
        right += ", and leave __eq__ to the dataclass"
        self.require(equal, f" does not equal a copy of itself; {right}")

    def names(self, label: str, names: object) -> None:
        """Require that names are a tuple of strings."""
        hint = f"({names!r},)" if isinstance(names, str) else 'such as ("spring_force",)'
        strings = (is_of(name, str) for name in cast(Iterable[object], names))
        holds = isinstance(names, tuple) and all(strings)
        self.require(holds, f"{label} is {names!r}; it must be a tuple of names: {hint}")

    def same_names(
        self, label: str, actual: Iterable[str], field: str, names: Iterable[str]
    ) -> None:
        """Require that a method returns the names that a field of the part lists."""
        actual, names = sorted(actual), sorted(set(names))
        are = f"gives {', '.join(actual)}; {field} names {', '.join(names)}"
        self.require(actual == names, f"{label} {are}: they must be the same")

    def attempt(self, label: str, function: Callable[..., T], *args: object) -> T:
        """Return a function's result inside a compiled program; it must not need a value in
        Python.
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
                f"{self.name}{label} uses an array's value in Python (if, float(), NumPy or math); "
                "use jnp functions, and jnp.where in place of if"
            ) from None
        except Exception as error:
            raise TegotaeError(f"{self.name}{label} raised {formatted(error)}") from error

    def arrays(
        self,
        label: str,
        value: object,
        *,
        dtype: str | None = None,
        leading: tuple[int, ...] | None = (),
        axes: str = "limbs",
        events: bool = False,
    ) -> None:
        """Require that every array of a pytree has the lanes' shape and type, and is finite.

        Args:
            label: name of the value in the message.
            value: a pytree of arrays.
            dtype: another type than the lanes', such as "bool".
            leading: the axes before that of the lanes, such as the limbs'; None for any.
            axes: what these are of.
            events: whether NaN is allowed, where it means none.
        """
        dtype = dtype or self.dtype
        for leaf in jax.tree.leaves(value):
            array = np.asarray(leaf)
            shape = (*(array.shape[:-1] if leading is None else leading), LANES)
            right = "the shape of the lanes" if len(shape) == 1 else f"shape {shape}, {axes} first"
            self.require(
                array.shape == shape,
                f"{label} has shape {array.shape} for lanes of shape ({LANES},); it must have "
                f"{right} (jnp.full_like or jnp.zeros_like makes an array of a constant)",
            )
            self.require(
                array.dtype == dtype,
                f"{label} is {array.dtype} for {dtype} lanes; it must keep the lanes' type (write "
                "constants as Python numbers, not as NumPy or JAX arrays)",
            )
            if not events and dtype != "bool" and not np.isfinite(array).all():
                self.require(False, f"{label} is not finite on ordinary lanes: {listed(array)}")

    def independent(self, label: str, function: Callable[..., object], *args: object) -> None:
        """Require that spoiling one lane of the arguments, [..., LANES] each, changes no other
        one."""
        program = jit(function)
        sound = program(*args)
        other_lanes = np.delete(np.arange(LANES), SPOILED)
        for poison in (jnp.nan, 17.0):

            def spoil(x: jax.Array, poison: float = poison) -> jax.Array:
                if x.shape[-1:] != (LANES,):
                    return x
                return x.at[..., SPOILED].set(jnp.asarray(poison, x.dtype))

            spoiled = program(*jax.tree.map(spoil, args))
            for pair in zip(*map(jax.tree.leaves, (sound, spoiled)), strict=True):
                others = (np.asarray(leaf)[..., other_lanes] for leaf in pair)
                self.require(
                    np.array_equal(*others, equal_nan=True),
                    f"{label} lets one lane change another; use elementwise functions only (no "
                    "sum, mean, max, sort or roll over lanes)",
                )

    def value(
        self,
        label: str,
        function: Callable[..., T],
        *args: object,
        **right: Any,
    ) -> T:
        """Return a function's result after checks: right `arrays`, whose lanes do not depend on
        each other.
        """
        result = self.attempt(label, function, *args)
        self.arrays(label, result, **right)
        self.independent(label, function, *args)
        return result

    def same_form(self, label: str, state: object, start: object) -> None:
        """Require that a returned state has the form of the state at the start."""
        self.require(
            jax.tree.structure(state) == jax.tree.structure(start),
            f"{label} returns {_form(state)}; it must return a state of the same form as at the "
            f"start, {_form(start)}",
        )

    def lanes(self, low: float, high: float, seed: int) -> jax.Array:
        """Return trial values, all different, in [low, high)."""
        return jnp.asarray(np.random.default_rng(seed).uniform(low, high, LANES), self.dtype)


def listed(array: npt.ArrayLike | jax.Array) -> str:
    """Return an array's values in one line."""
    return ", ".join(f"{x:.5g}" for x in np.ravel(array))


def _form(state: object) -> str:
    form = type(state).__name__
    return f"{form} of {len(cast(tuple[object, ...], state))}" if is_of(state, tuple) else form
