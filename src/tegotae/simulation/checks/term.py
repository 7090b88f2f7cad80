"""The contract of a term."""

from __future__ import annotations

import jax
import jax.numpy as jnp

from tegotae._support.errors import TegotaeError, is_of
from tegotae.parts._shapes import PerCommand, Weights
from tegotae.parts.maths import TWO_PI
from tegotae.parts.terms.actuation import Actuation
from tegotae.parts.terms.base import Signals, Term
from tegotae.simulation.checks import probing


def check_term(term: Term) -> None:
    """Try the contract of `tegotae.parts.terms.Term` on a few lanes.

    Checked are: a frozen, hashable dataclass; `reads`, `n_weights` and `initial`; a value of the
    shape and type of the lanes, in float32 and float64, that depends on no other lane and on no
    signal that is missing from `reads`. Of an actuation also `full_force`.

    Raises:
        TegotaeError: for the first breach, with what would be right.

    Example:
        >>> from tegotae.parts.terms import Network
        >>> check_term(Network(("phase",), hidden=4))
    """
    name = probing.require_part(term, Term)
    probing.require_hashable(name, term)
    probing.require_names(f"{name}.reads", term.reads)
    _check_weights(name, term)
    for dtype in probing.DTYPES:
        with jax.enable_x64(dtype == "float64"):
            _check_value(name, term, dtype)
            if isinstance(term, Actuation):
                _check_full_force(name, term, dtype)


def _check_weights(name: str, term: Term) -> None:
    n_weights = term.n_weights
    if isinstance(n_weights, bool) or not is_of(n_weights, int) or n_weights < 0:
        raise TegotaeError(
            f"{name}.n_weights is {n_weights!r}; it must be a whole number of at least 0 "
            "(a property, not a method)"
        )
    initial = probing.attempt(f"{name}.initial", term.initial, jax.random.key(0))
    shape = getattr(initial, "shape", None)
    if shape != (n_weights,):
        raise TegotaeError(
            f"{name}.initial returns shape {shape}; it must be ({n_weights},), one number for each "
            f"of its n_weights = {n_weights}"
        )
    if not bool(jnp.isfinite(initial).all()):
        raise TegotaeError(
            f"{name}.initial returns numbers that are not finite: {probing.listed(initial)}"
        )


class _DeclaredSignals(Signals):
    """Signals of which only those that a term declares may be read."""

    def __getitem__(self, name: str) -> jax.Array:
        if name not in self.values:
            raise TegotaeError(
                f"the term reads the signal {name!r} but does not declare it; "
                f"add {name!r} to what `reads` returns"
            )
        return super().__getitem__(name)

    def dimensionless(self, name: str) -> jax.Array:
        self[name]
        return super().dimensionless(name)


def _signals(term: Term, dtype: str) -> dict[str, jax.Array]:
    phase = probing.lanes_of(dtype, 0.0, TWO_PI, 0)
    values: dict[str, jax.Array] = {}
    # Every actuation is given the feedback, declared or not.
    names = {*term.reads, "feedback"} if isinstance(term, Actuation) else set(term.reads)
    for seed, signal in enumerate(sorted(names)):
        known = {"sin_phase": jnp.sin(phase), "cos_phase": jnp.cos(phase)}
        values[signal] = known.get(signal, probing.lanes_of(dtype, 0.1, 2.0, seed + 1))
    return values


def _check_value(name: str, term: Term, dtype: str) -> None:
    values = _signals(term, dtype)
    scales = {s: jnp.asarray(1.5, dtype) for s in values if not s.endswith("_phase")}
    weights = [probing.lanes_of(dtype, -1.0, 1.0, 100 + i) for i in range(term.n_weights)]

    def call(weights: Weights, values: dict[str, jax.Array]) -> PerCommand:
        return term(tuple(weights), _DeclaredSignals(values, scales))

    result = probing.attempt(f"{name}.__call__", call, weights, values)
    if not is_of(result, jax.Array):
        raise TegotaeError(
            f"{name}.__call__ returns a {type(result).__name__}; it must return one array"
        )
    probing.require_arrays(f"{name}.__call__", result, dtype)
    probing.require_independent(f"{name}.__call__", call, weights, values)


def _check_full_force(name: str, term: Actuation, dtype: str) -> None:
    start = probing.lanes_of(dtype, 0.0, TWO_PI, 7)
    end = start + probing.lanes_of(dtype, -0.5, 0.5, 8)
    omega = probing.lanes_of(dtype, 4.0, 8.0, 9)
    what = f"{name}.full_force"
    sector = probing.attempt(what, term.full_force, start, end, omega)
    if sector is None:
        return
    if not is_of(sector, tuple) or len(sector) != 2:
        raise TegotaeError(f"{what} must return None, or a pair (share of the path, its centre)")
    probing.require_arrays(what, sector, dtype)
    for meaning, value in zip(("share", "centre"), sector, strict=True):
        if not bool(((value >= 0.0) & (value <= 1.0)).all()):
            raise TegotaeError(
                f"{what} returns a {meaning} outside 0 ... 1: {probing.listed(value)}"
            )
    probing.require_independent(what, term.full_force, start, end, omega)
