"""The contracts of oscillators, terms and controllers."""

from __future__ import annotations

from collections.abc import Callable

import jax
import jax.numpy as jnp
import numpy as np

from tegotae._support.errors import TegotaeError, is_of
from tegotae.parts._shapes import PerCommand, PerLane, PerLimb, StateTree, Weights
from tegotae.parts.bodies import Body
from tegotae.parts.controller import Controller
from tegotae.parts.maths import TWO_PI
from tegotae.parts.oscillators import Oscillator
from tegotae.parts.terms.actuation import Actuation
from tegotae.parts.terms.base import Signals, Term
from tegotae.simulation.checks import probing
from tegotae.simulation.checks.body import check_body
from tegotae.simulation.integrators.base import held
from tegotae.simulation.rollout import (
    Engine,
    Scenario,
    Timing,
    check_senses,
)


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


_TICK_S = 0.002
_LARGEST_STEP_RAD = 1.0


def check_oscillator(oscillator: Oscillator) -> None:
    """Try the contract of `tegotae.parts.oscillators.Oscillator` on a few lanes.

    Checked are: a frozen, hashable dataclass; states of one form, shape and type, in float32 and
    float64, in which no lane depends on another; a rate for every entry of the state; signals that
    are what `SIGNALS` names; weights of the number that it says. With a phase: `start`, `phase` and
    `sin_cos` that agree; and, over two turns, a phase that is in [0, 2π) after `settle` and does
    not jump within a tick.

    Raises:
        TegotaeError: for the first breach, with what would be right.

    Example:
        >>> from tegotae.parts.oscillators import PhaseOscillator
        >>> check_oscillator(PhaseOscillator())
    """
    name = probing.require_part(oscillator, Oscillator)
    probing.require_hashable(name, oscillator)
    probing.require_names(f"{name}.SIGNALS", oscillator.SIGNALS)
    for dtype in probing.DTYPES:
        with jax.enable_x64(dtype == "float64"):
            _check_methods(name, oscillator, dtype)
            if oscillator.has_phase:
                _check_phase(name, oscillator, dtype)
    if oscillator.has_phase:
        _check_turns(name, oscillator)


def _weights(name: str, oscillator: Oscillator, dtype: str) -> tuple[jax.Array, ...]:
    """Some weights of the oscillator, each like the lanes."""
    first = probing.attempt(f"{name}.initial", oscillator.initial, jax.random.key(0))
    if np.shape(first) != (oscillator.n_weights,):
        raise TegotaeError(
            f"{name}.initial has shape {np.shape(first)}; n_weights says ({oscillator.n_weights},)"
        )
    ones = jnp.ones((probing.LANES,), dtype)
    return tuple(jnp.asarray(w, dtype) * ones for w in first)


def _rate_of(name: str, oscillator: Oscillator, dtype: str) -> Callable[..., StateTree]:
    """Its rate as the integrators call it: with weights if it has some."""
    weights = _weights(name, oscillator, dtype)
    given = (weights,) if weights else ()

    def rate(state: StateTree, omega: PerLimb, feedback: PerLimb) -> StateTree:
        return oscillator.rate(state, omega, feedback, *given)

    return rate


def _check_methods(name: str, oscillator: Oscillator, dtype: str) -> None:
    phase = probing.lanes_of(dtype, 0.1, TWO_PI - 0.1, 0)
    omega = probing.lanes_of(dtype, 4.0, 8.0, 1)
    feedback = probing.lanes_of(dtype, -3.0, 3.0, 2)

    state = probing.attempt(f"{name}.start", oscillator.start, phase)
    if not jax.tree.leaves(state) or isinstance(state, jax.Array):
        raise TegotaeError(
            f"{name}.start returns {state!r:.60}; it must return a tuple, such as (phase,), or "
            "another pytree of arrays"
        )
    probing.require_arrays(f"{name}.start", state, dtype)

    rate_of = _rate_of(name, oscillator, dtype)
    rate = probing.attempt(f"{name}.rate", rate_of, state, omega, feedback)
    entries, derivatives = len(jax.tree.leaves(state)), len(jax.tree.leaves(rate))
    if entries != derivatives or isinstance(rate, jax.Array):
        found = type(rate).__name__ if isinstance(rate, jax.Array) else derivatives
        raise TegotaeError(
            f"{name}.rate returns {found}; "
            f"it must return a tuple of {entries}: one derivative for each entry of the state"
        )
    probing.require_arrays(f"{name}.rate", rate, dtype)

    settled = probing.attempt(f"{name}.settle", oscillator.settle, state)
    probing.same_structure(f"{name}.settle", settled, state)
    probing.require_arrays(f"{name}.settle", settled, dtype)

    values = probing.attempt(f"{name}.signals", oscillator.signals, state)
    if set(values) != set(oscillator.SIGNALS):
        raise TegotaeError(
            f"{name}.signals gives {', '.join(sorted(values))}; SIGNALS names "
            f"{', '.join(sorted(oscillator.SIGNALS))}: they must be the same"
        )
    probing.require_arrays(f"{name}.signals", tuple(values.values()), dtype)

    probing.require_independent(f"{name}.start", oscillator.start, phase)
    probing.require_independent(f"{name}.rate", rate_of, state, omega, feedback)
    probing.require_independent(f"{name}.settle", oscillator.settle, state)

    def signals(state: StateTree) -> tuple[PerLimb, ...]:
        return tuple(oscillator.signals(state).values())

    probing.require_independent(f"{name}.signals", signals, state)


def _check_phase(name: str, oscillator: Oscillator, dtype: str) -> None:
    phase = probing.lanes_of(dtype, 0.1, TWO_PI - 0.1, 0)
    state = oscillator.start(phase)
    phases = probing.attempt(f"{name}.phase", oscillator.phase, state)
    probing.require_arrays(f"{name}.phase", phases, dtype)
    _require_close(f"{name}.phase of {name}.start(φ)", phases, phase, "φ")

    sin_cos = probing.attempt(f"{name}.sin_cos", oscillator.sin_cos, state)
    if not is_of(sin_cos, tuple) or len(sin_cos) != 2:
        raise TegotaeError(f"{name}.sin_cos must return a pair (sine, cosine) of the phase")
    probing.require_arrays(f"{name}.sin_cos", sin_cos, dtype)
    _require_close(f"the sine of {name}.sin_cos", sin_cos[0], jnp.sin(phases), "sin of its phase")
    _require_close(f"the cosine of {name}.sin_cos", sin_cos[1], jnp.cos(phases), "cos of its phase")
    for method in ("phase", "sin_cos"):
        probing.require_independent(f"{name}.{method}", getattr(oscillator, method), state)


def _require_close(what: str, value: jax.Array, expected: jax.Array, meaning: str) -> None:
    if not np.allclose(value, expected, atol=1e-4):
        raise TegotaeError(
            f"{what} is {probing.listed(value)}; it must be {meaning}, {probing.listed(expected)}"
        )


def _check_turns(name: str, oscillator: Oscillator) -> None:
    omega = probing.lanes_of("float32", 4.0, 8.0, 3)
    rate_of = _rate_of(name, oscillator, "float32")
    state = oscillator.settle(oscillator.start(jnp.zeros_like(omega)))
    ticks = round(2.0 * TWO_PI / 4.0 / _TICK_S)

    def tick(state: StateTree, _: None) -> tuple[StateTree, tuple[PerLane, PerLane]]:
        ahead = held(state, rate_of(state, omega, jnp.zeros_like(omega)), _TICK_S)
        settled = oscillator.settle(ahead)
        return settled, (
            oscillator.phase(ahead) - oscillator.phase(state),
            oscillator.phase(settled),
        )

    def turn(state: StateTree) -> tuple[jax.Array, jax.Array]:
        return jax.lax.scan(tick, state, None, length=ticks)[1]

    steps, phases = probing.attempt(f"{name} over two turns", turn, state)
    if float(jnp.abs(steps).max()) > _LARGEST_STEP_RAD:
        raise TegotaeError(
            f"{name}.phase jumps by {float(jnp.abs(steps).max()):.3g} rad within a tick of "
            f"{_TICK_S:g} s; keep the phase as an entry of the state, and wrap it in `settle` only"
        )
    if not bool(((phases >= 0.0) & (phases < TWO_PI)).all()):
        raise TegotaeError(
            f"{name}.phase leaves [0, 2π) after `settle`: {float(phases.min()):.4g} ... "
            f"{float(phases.max()):.4g}; wrap it there with tegotae.parts.maths.wrap_phase"
        )


def check_controller(controller: Controller, body: Body) -> None:
    """Check every part of a controller, its body, and a short rollout of both together.

    Checked are: `check_term` for each term, `check_oscillator`; that the body senses all that the
    terms read; `check_body`; and that 0.1 s with random weights stays finite in one lane while
    another lane's weights are NaN.

    Args:
        controller: what drives the body.
        body: the body.

    Raises:
        TegotaeError: for the first breach, with what would be right.

    Example:
        >>> import tegotae
        >>> check_controller(tegotae.build("V-reflex-w4"), tegotae.Hopper())
    """
    if not is_of(controller, Controller):
        raise TegotaeError(
            f"{type(controller).__name__} is no Controller; make one of terms: "
            "Controller(actuation, oscillator, Tegotae(action, reaction, gain))"
        )
    for term in controller.terms.values():
        check_term(term)
    if not is_of(controller.actuation, Actuation):
        raise TegotaeError(
            f"{type(controller.actuation).__name__} cannot be the actuation; make it a subclass of "
            "tegotae.parts.terms.Actuation"
        )
    if controller.tegotae is not None and controller.oscillator is None:
        raise TegotaeError("the controller has Tegotae terms but no oscillator for them to drive")
    if controller.oscillator is not None:
        check_oscillator(controller.oscillator)
    check_senses(controller, body)
    check_body(body)
    _check_rollout(controller, body)


def _check_rollout(controller: Controller, body: Body) -> None:
    engine = Engine(controller=controller, timing=Timing(duration_s=0.1))
    weights = np.repeat(np.asarray(controller.initial(jax.random.key(0)))[None], 2, axis=0)
    scenario = Scenario(omega=5.0, height_m=1.01 * float(body.rest_length_m))
    sound = engine.run(weights, scenario, body)
    if bool(sound.failed.any()):
        raise TegotaeError(
            "the rollout with the controller's initial weights fails within 0.1 s of its release "
            "just over the ground; check the body's `failed` and the size of the forces"
        )
    weights[1] = np.nan
    spoiled = engine.run(weights, scenario, body)
    if not np.array_equal(sound.height_m[:, 0], spoiled.height_m[:, 0]):
        raise TegotaeError("a lane with NaN weights changes another lane; keep terms elementwise")
