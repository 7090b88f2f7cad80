"""Check of the contracts that a new term, oscillator, body or controller must keep."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from tegotae._support.errors import TegotaeError, is_of
from tegotae.parts._shapes import PerCommand, PerLane, PerLimb, StateTree, Weights
from tegotae.parts.bodies import Body
from tegotae.parts.channels import FORCE
from tegotae.parts.controller import Controller
from tegotae.parts.maths import TWO_PI
from tegotae.parts.oscillators import Oscillator
from tegotae.parts.terms.actuation import Actuation
from tegotae.parts.terms.base import Signals, Term
from tegotae.simulation.checks.body import check_body
from tegotae.simulation.checks.probing import DTYPES, LANES, PartTrial, listed
from tegotae.simulation.integrators import held
from tegotae.simulation.loop import check_senses
from tegotae.simulation.rollout import Rollout, Timing
from tegotae.simulation.world import Scenario

__all__ = ["check_part"]

_TICK_S = 0.002
_LARGEST_STEP_RAD = 1.0


def check_part(part: Term | Oscillator | Body | Controller, body: Body) -> None:
    """Try the contract of a term, an oscillator, a body or a controller (`tegotae.check`).

    Args:
        part: the part.
        body: body that a controller drives.

    Raises:
        TegotaeError: for the first breach, in one line with what would be right.
    """
    if isinstance(part, Controller):
        _check_controller(part, body)
    elif isinstance(part, Oscillator):
        _check_oscillator(part)
    elif isinstance(part, Body):
        check_body(part)
    else:
        _check_term(part)


def _check_term(term: Term) -> None:
    trial = PartTrial.from_part(term, Term)
    trial.hashable(term)
    trial.names(".reads", term.reads)
    _check_weights(trial, term)
    for dtype in DTYPES:
        with jax.enable_x64(dtype == "float64"):
            _check_value(PartTrial(trial.name, dtype), term)
            if isinstance(term, Actuation):
                _check_full_force(PartTrial(trial.name, dtype), term)


def _check_weights(trial: PartTrial, part: Term | Oscillator) -> jax.Array:
    """Return the weights that training starts from."""
    count = part.n_weights
    trial.require(
        is_of(count, int) and not isinstance(count, bool) and count >= 0,
        f".n_weights is {count!r}; it must be a whole number of at least 0 (a property, not a "
        "method)",
    )
    initial = trial.attempt(".initial", part.initial, jax.random.key(0))
    shape = getattr(initial, "shape", None)
    trial.require(
        shape == (count,),
        f".initial returns shape {shape}; it must be ({count},), one number for each of its "
        f"n_weights = {count}",
    )
    finite = jnp.isfinite(initial).all()
    trial.require(finite, f".initial returns numbers that are not finite: {listed(initial)}")
    return initial


class _DeclaredSignals(Signals):
    """Signals of which only declared ones may be read by a term."""

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


def _check_value(trial: PartTrial, term: Term) -> None:
    phase = trial.lanes(0.0, TWO_PI, 0)
    signals = {"sin_phase": jnp.sin(phase), "cos_phase": jnp.cos(phase)}
    # Every actuation is given the feedback, declared or not.
    names = {*term.reads, "feedback"} if isinstance(term, Actuation) else set(term.reads)
    values = {
        name: signals.get(name, trial.lanes(0.1, 2.0, seed))
        for seed, name in enumerate(sorted(names), 1)
    }
    scales = {s: jnp.asarray(1.5, trial.dtype) for s in values if not s.endswith("_phase")}
    weights = [trial.lanes(-1.0, 1.0, 100 + i) for i in range(term.n_weights)]

    commands = term.COMMANDS if isinstance(term, Actuation) else FORCE
    shape = () if len(commands) == 1 else (len(commands),)
    right = {"leading": shape, "axes": ", ".join(commands)}

    def array(label: str, result: PerCommand) -> PerCommand:
        returns = f"{label} returns a {type(result).__name__}"
        trial.require(is_of(result, jax.Array), f"{returns}; it must return one array")
        return result

    def call(weights: Weights, values: dict[str, jax.Array]) -> PerCommand:
        return array(".__call__", term(tuple(weights), _DeclaredSignals(values, scales)))

    command = trial.value(".__call__", call, weights, values, **right)
    if isinstance(term, Actuation):

        def paced(weights: Weights, command: PerCommand, omega: PerLane) -> PerCommand:
            return array(".paced", term.paced(tuple(weights), command, omega))

        trial.value(".paced", paced, weights, command, trial.lanes(4.0, 8.0, 9), **right)


def _check_full_force(trial: PartTrial, term: Actuation) -> None:
    start = trial.lanes(0.0, TWO_PI, 7)
    weights = tuple(trial.lanes(-1.0, 1.0, 100 + i) for i in range(term.n_weights))
    path = start, start + trial.lanes(-0.5, 0.5, 8), trial.lanes(4.0, 8.0, 9)
    sector = trial.value(".full_force", term.full_force, weights, *path)
    if sector is None:
        return
    pair = is_of(sector, tuple) and len(sector) == 2
    trial.require(pair, ".full_force must return None, or a pair (share of the path, its centre)")
    for meaning, value in zip(("share", "centre"), sector, strict=True):
        outside = f".full_force returns a {meaning} outside 0 ... 1: {listed(value)}"
        trial.require(((value >= 0.0) & (value <= 1.0)).all(), outside)


def _check_oscillator(oscillator: Oscillator) -> None:
    trial = PartTrial.from_part(oscillator, Oscillator)
    trial.hashable(oscillator)
    trial.names(".SIGNALS", oscillator.SIGNALS)
    initial = _check_weights(trial, oscillator)
    for dtype in DTYPES:
        with jax.enable_x64(dtype == "float64"):
            _check_methods(PartTrial(trial.name, dtype), oscillator, initial)
            if oscillator.has_phase:
                _check_phase(PartTrial(trial.name, dtype), oscillator)
    if oscillator.has_phase:
        _check_turns(trial, oscillator, initial)


_Rate = Callable[[StateTree, PerLimb, PerLimb], StateTree]


def _rate_of(oscillator: Oscillator, initial: jax.Array) -> _Rate:
    """Return its rate as the integrators call it, with weights and signals if it has some."""

    def rate(state: StateTree, omega: PerLimb, feedback: PerLimb) -> StateTree:
        weights = tuple(jnp.full((LANES,), weight, omega.dtype) for weight in initial)
        values = {name: jnp.full((LANES,), 0.5, omega.dtype) for name in oscillator.READS}
        sensed: dict[str, Any] = {"signals": _DeclaredSignals(values, {})} if values else {}
        return oscillator.rate(state, omega, feedback, *((weights,) if weights else ()), **sensed)

    return rate


def _check_methods(trial: PartTrial, oscillator: Oscillator, initial: jax.Array) -> None:
    phase = trial.lanes(0.1, TWO_PI - 0.1, 0)
    omega, feedback = trial.lanes(4.0, 8.0, 1), trial.lanes(-3.0, 3.0, 2)
    state = trial.value(".start", oscillator.start, phase)
    trial.require(
        jax.tree.leaves(state) and not isinstance(state, jax.Array),
        f".start returns {state!r:.60}; it must return a tuple, such as (phase,), or another "
        "pytree of arrays",
    )
    rate_of = _rate_of(oscillator, initial)
    rate = trial.attempt(".rate", rate_of, state, omega, feedback)
    entries, derivatives = len(jax.tree.leaves(state)), len(jax.tree.leaves(rate))
    bare = isinstance(rate, jax.Array)
    trial.require(
        entries == derivatives and not bare,
        f".rate returns {type(rate).__name__ if bare else derivatives}; it must return a tuple of "
        f"{entries}: one derivative for each entry of the state",
    )
    trial.value(".rate", rate_of, state, omega, feedback)
    for label, tree in (("its state", state), ("its .rate", rate)):
        missing = ", ".join(name for name in oscillator.STATE if not hasattr(tree, name))
        trial.require(
            not missing or type(oscillator).channels is not Oscillator.channels,
            f".STATE names {missing}, which {label} lacks; make state and rate named tuples",
        )
    trial.same_form(".settle", trial.value(".settle", oscillator.settle, state), state)
    signals = trial.value(".signals", oscillator.signals, state)
    trial.same_names(".signals", signals, "SIGNALS", oscillator.SIGNALS)


def _check_phase(trial: PartTrial, oscillator: Oscillator) -> None:
    phase = trial.lanes(0.1, TWO_PI - 0.1, 0)
    state = oscillator.start(phase)
    phases = trial.value(".phase", oscillator.phase, state)
    pair = trial.value(".sin_cos", oscillator.sin_cos, state)
    two = is_of(pair, tuple) and len(pair) == 2
    trial.require(two, ".sin_cos must return a pair (sine, cosine) of the phase")
    name, suffix = trial.name, f"of {trial.name}.sin_cos"
    for label, value, right, meaning in (
        (f"{name}.phase of {name}.start(φ)", phases, phase, "φ"),
        (f"the sine {suffix}", pair[0], jnp.sin(phases), "sin of its phase"),
        (f"the cosine {suffix}", pair[1], jnp.cos(phases), "cos of its phase"),
    ):
        must = f" is {listed(value)}; it must be {meaning}, {listed(right)}"
        PartTrial(label).require(np.allclose(value, right, atol=1e-4), must)


def _check_turns(trial: PartTrial, oscillator: Oscillator, initial: jax.Array) -> None:
    omega = trial.lanes(4.0, 8.0, 3)
    rate_of = _rate_of(oscillator, initial)
    state = oscillator.settle(oscillator.start(jnp.zeros_like(omega)))
    ticks = round(2.0 * TWO_PI / 4.0 / _TICK_S)

    def tick(state: StateTree, _: None) -> tuple[StateTree, tuple[PerLane, PerLane]]:
        ahead = held(state, rate_of(state, omega, jnp.zeros_like(omega)), _TICK_S)
        settled = oscillator.settle(ahead)
        step = oscillator.phase(ahead) - oscillator.phase(state)
        return settled, (step, oscillator.phase(settled))

    def turn(state: StateTree) -> tuple[jax.Array, jax.Array]:
        return jax.lax.scan(tick, state, None, length=ticks)[1]

    steps, phases = trial.attempt(" over two turns", turn, state)
    longest, low, high = (float(x) for x in (jnp.abs(steps).max(), phases.min(), phases.max()))
    trial.require(
        longest <= _LARGEST_STEP_RAD,
        f".phase jumps by {longest:.3g} rad within a tick of {_TICK_S:g} s; keep the phase as an "
        "entry of the state, and wrap it in `settle` only",
    )
    trial.require(
        low >= 0.0 and high < TWO_PI,
        f".phase leaves [0, 2π) after `settle`: {low:.4g} ... {high:.4g}; wrap it there with "
        "tegotae.parts.maths.wrap_phase",
    )


def _check_controller(controller: Controller, body: Body) -> None:
    for term in controller.terms.values():
        _check_term(term)
    actuation, right = controller.actuation, "make it a subclass of tegotae.parts.terms.Actuation"
    trial = PartTrial(type(actuation).__name__)
    trial.require(is_of(actuation, Actuation), f" cannot be the actuation; {right}")
    if controller.oscillator is not None:
        _check_oscillator(controller.oscillator)
    elif controller.tegotae is not None:
        raise TegotaeError("the controller has Tegotae terms but no oscillator for them to drive")
    check_senses(controller, body)
    check_body(body)

    rollout = Rollout(controller=controller, timing=Timing(duration_s=0.1))
    weights = np.repeat(np.asarray(controller.initial(jax.random.key(0)))[None], 2, axis=0)
    scenario = Scenario(omega=5.0, height_m=1.01 * float(body.rest_length_m))
    sound = rollout.run(weights, scenario, body)
    if sound.failed.any():
        raise TegotaeError(
            "the rollout with the controller's initial weights fails within 0.1 s of its release "
            "just over the ground; check the body's `failed` and the size of the forces"
        )
    weights[1] = np.nan
    spoiled = rollout.run(weights, scenario, body)
    if not np.array_equal(sound.height_m[:, 0], spoiled.height_m[:, 0]):
        raise TegotaeError("a lane with NaN weights changes another lane; keep terms elementwise")
