"""The contract of a body."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cache

import jax
import jax.numpy as jnp
import numpy as np

from tegotae._support.errors import is_of, require_finite
from tegotae._support.transforms import jit
from tegotae.parts._shapes import Number, PerCommand, PerLane, Scalar, StateTree
from tegotae.parts.bodies import Body, Contact, Hopper, Push, Sensation
from tegotae.parts.channels import FORCE
from tegotae.simulation.checks.passive import pushed
from tegotae.simulation.checks.probing import DTYPES, LANES, PartTrial, listed
from tegotae.simulation.native import with_numpy_numbers

_TICK_S = 0.001
_TICKS = 2000
_OF_LIMBS = ("stance_share", "work_j", "touchdown_share", "force_n")
"""Entries of a `Contact` that belong to each limb."""
_NUMBERS = int | float | np.number | jax.Array
_MOTION = ("height", "velocity")
_ENERGY_TOLERANCE = 1e-3
"""Share of the energy that may be made from nothing over a rollout: integration error."""


def check_body(body: Body) -> None:
    """Try the contract of `tegotae.parts.bodies.Body` on a few lanes (`tegotae.check`).

    Raises:
        TegotaeError: for the first breach, with what would be right.
    """
    trial = PartTrial.from_part(body, Body)
    leaves = jax.tree.leaves(body)
    right = "put @tegotae.parts.parameters.traceable above its @dataclass"
    trial.require(not any(leaf is body for leaf in leaves), f" is no pytree; {right}")
    for leaf in leaves:
        number = isinstance(leaf, _NUMBERS) and not isinstance(leaf, bool)
        trial.require(number, f" has a field {leaf!r}; its fields must be numbers")
    trial.names(".SENSES", body.SENSES)
    trial.require(body.SENSES, ".SENSES is empty; name at least one sensed quantity")
    for quantity in ("max_force_n", "rest_length_m", "rate_scale"):
        require_finite(f"{trial.name}.{quantity}", getattr(body, quantity), above=0.0)
    body.check_tick(_TICK_S)
    for dtype in DTYPES:
        with jax.enable_x64(dtype == "float64"):
            tried = _BodyTrial(trial.name, dtype, with_numpy_numbers(body, dtype))
            _check_release(tried)
            _check_sense(tried)
            _check_predict(tried)
            _check_advance(tried)
            for method, kind in (("failed", "bool"), ("energy", dtype)):
                arguments = tried.body, tried.state, tried.ground
                tried.value(f".{method}", _method(method), *arguments, dtype=kind)
    with jax.enable_x64(True):
        tried = _BodyTrial(trial.name, "float64", with_numpy_numbers(body, "float64"))
        _check_small_ticks(tried)
        _check_energy(tried)


@cache
def _method(name: str) -> Callable[..., StateTree]:
    """Return a body's method as a function of the body, which is traced as in a rollout.

    The same function for every trial of it, so that it is compiled once.
    """

    def call(body: Body, *args: object) -> StateTree:
        return getattr(body, name)(*args)

    return call


@dataclass(frozen=True)
class _BodyTrial(PartTrial):
    """A body on lanes in flight, in stance and about to touch down, and a ground not at zero."""

    body: Body = field(default_factory=Hopper)

    @property
    def tick(self) -> Scalar:
        return jnp.asarray(_TICK_S, self.dtype)

    @property
    def ground(self) -> PerLane:
        return jnp.full((LANES,), -0.05, self.dtype)

    @property
    def state(self) -> StateTree:
        shares = jnp.linspace(0.9, 1.2, LANES, dtype=self.dtype)
        height = shares * float(self.body.touching_height_m) + self.ground
        return self.body.release(height, self.lanes(-1.5, 1.5, 4))

    @property
    def force(self) -> PerCommand:
        return _command(self.body, 0.5, self.ground)

    def call(self, method: str, *args: object) -> StateTree:
        """Return the result of a method of the body."""
        return self.attempt(f".{method}", _method(method), self.body, *args)


def _command(body: Body, share: Number, like: jax.Array) -> jax.Array:
    """Return a command: a share of the largest force, or places of feet slightly off their rest."""
    force = body.COMMANDS == FORCE
    size = body.max_force_n if force else 0.1 * jnp.asarray(body.rest_length_m)
    of_body = share * jnp.asarray(size, like.dtype) + 0.0 * like
    of_limbs = jnp.broadcast_to(of_body, (*body.limb_shape, *of_body.shape))
    return of_limbs if force else jnp.stack([of_limbs] * len(body.COMMANDS))


def _check_release(trial: _BodyTrial) -> None:
    height = trial.lanes(0.9, 1.2, 5) * float(trial.body.touching_height_m)
    velocity = trial.lanes(-1.0, 1.0, 6)
    state = trial.call("release", height, velocity)
    returns = f".release returns {state!r:.60}; it must return a tuple of arrays"
    trial.require(is_of(state, tuple) and state, returns)
    trial.arrays(".release", state, leading=None)
    for method, values in zip(_MOTION, (height, velocity), strict=True):
        measured = trial.call(method, state)
        trial.arrays(f".{method}", measured)
        trial.require(
            np.allclose(measured, values, atol=1e-5),
            f".{method} of the release is {listed(measured)}; it must be {listed(values)}",
        )


def _sensed(body: Body, state: StateTree, ground: PerLane) -> dict[str, jax.Array]:
    return body.sense(state, ground).values


def _check_sense(trial: _BodyTrial) -> None:
    body, arguments = trial.body, (trial.state, trial.ground)
    felt = trial.call("sense", *arguments)
    returns = f".sense returns a {type(felt).__name__}; it must return a Sensation"
    trial.require(isinstance(felt, Sensation), returns)
    trial.same_names(".sense", felt.values, "SENSES", body.SENSES)
    for quantity in body.SENSES:
        trial.arrays(f".sense's {quantity}", felt.values[quantity], leading=body.limb_shape)
        right = "networks see quantity / scale, so add one"
        trial.require(quantity in felt.scales, f".sense gives no scale for {quantity}; {right}")
        scale = float(felt.scales[quantity])
        require_finite(f"{trial.name}.sense's scale of {quantity}", scale, above=0.0)
    trial.independent(".sense", _sensed, body, *arguments)


def _check_predict(trial: _BodyTrial) -> None:
    arguments = trial.state, trial.force, trial.ground, trial.tick
    result = trial.call("predict", *arguments)
    three = is_of(result, tuple) and len(result) == 3
    trial.require(three, ".predict must return (state, stance from, stance to)")
    guess, begins, ends = result
    trial.same_form(".predict", guess, trial.state)
    trial.arrays(".predict", guess, leading=None)
    trial.arrays(".predict", (begins, ends), leading=trial.body.limb_shape)
    trial.require(
        ((begins >= 0) & (begins <= ends) & (ends <= 1)).all(),
        f".predict returns stance from {listed(begins)} to {listed(ends)}; it must be "
        "0 <= from <= to <= 1 (shares of the tick)",
    )
    trial.independent(".predict", _method("predict"), trial.body, *arguments)


def _check_advance(trial: _BodyTrial) -> None:
    push = Push(trial.force, jnp.zeros_like(trial.force))
    arguments = trial.state, push, trial.ground, trial.tick
    result = trial.call("advance", *arguments)
    pair = is_of(result, tuple) and len(result) == 2 and is_of(result[1], Contact)
    trial.require(pair, ".advance must return (state, tegotae.parts.bodies.Contact)")
    end, contact = result
    trial.same_form(".advance", end, trial.state)
    trial.arrays(".advance", end, leading=None)
    values: dict[str, jax.Array] = contact._asdict()
    for name, value in values.items():
        entry, events = f".advance's {name}", name.startswith(("apex", "touchdown"))
        shape = trial.body.limb_shape if name in _OF_LIMBS else ()
        trial.arrays(entry, value, events=events, leading=shape)
        array, share = np.asarray(value, float), name.endswith("_share")
        inside = np.isnan(array) | (array >= 0.0) & (array <= (1.0 if share else np.inf))
        right = "a share, 0 ... 1" if share else "at least 0"
        signed = not share and not name.startswith("climb")
        must = f"{entry} is {listed(array)}; it must be {right}"
        trial.require(signed or np.all(inside), must)
    within = values["climb_flight_m"] <= values["climb_m"] + 1e-6
    exceeds = ".advance's climb_flight_m exceeds climb_m, which includes it"
    trial.require(within.all(), exceeds)
    apexes = np.isnan(values["apex_share"]) == np.isnan(values["apex_height_m"])
    message = ".advance's apex_share and apex_height_m must be NaN on the same lanes"
    trial.require(apexes.all(), message)
    trial.independent(".advance", _method("advance"), trial.body, *arguments)


def _check_small_ticks(trial: _BodyTrial) -> None:
    """Require that `predict` and the velocity agree with `advance` the better the shorter the
    tick.
    """
    body, ground, force = trial.body, trial.ground, trial.force
    push, released = Push(force, jnp.zeros_like(force)), trial.call("commanded", trial.state, force)

    def observed(state: StateTree) -> list[np.ndarray]:
        """Return the sensed part of a state: the guess must be right for it alone."""
        sensed = trial.attempt(".sense", _sensed, body, state, ground)
        moves = [trial.call(method, state) for method in _MOTION]
        return [np.asarray(x) for x in (*sensed.values(), *moves)]

    def gaps(tick_s: float) -> tuple[np.ndarray, np.ndarray]:
        """Return the gaps, computed with programs that the checks of the methods have compiled."""
        tick = jnp.asarray(tick_s, "float64")
        # A body may guess from what its last tick was like.
        begun, _ = trial.call("advance", released, push, ground, tick)
        end, contact = trial.call("advance", begun, push, ground, tick)
        guess, _, _ = trial.call("predict", begun, force, ground, tick)
        share = np.asarray(contact.stance_share).reshape(-1, LANES)
        steady = np.all((share == 0.0) | (share == 1.0), axis=0)
        start, finish, guessed = observed(begun), observed(end), observed(guess)
        distances = sum(
            np.abs(a - b).reshape(-1, LANES).max(axis=0)
            for a, b in zip(finish, guessed, strict=True)
        )
        height, velocity = start[-2:]
        slope = (finish[-2] - height) / tick_s
        return (
            np.where(steady, distances / tick_s, 0.0),
            np.where(steady, np.abs(slope - velocity), 0.0),
        )

    long, short = gaps(1e-4), gaps(1e-5)
    meanings = (
        "predict does not approach advance as the tick shrinks; check its signs, units and forces",
        "velocity is not the rate of change of height; check signs and units",
    )
    for large, small, meaning in zip(long, short, meanings, strict=True):
        trial.require((small <= 0.5 * large + 1e-6).all(), f".{meaning}")


def _check_energy(trial: _BodyTrial) -> None:
    """Require that over 2 s, with and without force, the energy rises by no more than the
    actuator's work.
    """
    body, start, ground, tick = trial.body, trial.state, trial.ground, trial.tick

    @jit
    def excess(share: jax.Array) -> jax.Array:
        push = Push(_command(body, share, ground))
        placed = body.commanded(start, push.mean_n)
        energy, work, stands = pushed(body, placed, push, ground, tick, _TICKS)
        first = body.energy(placed, ground)
        scale = jnp.abs(first) + jnp.asarray(body.max_force_n * body.rest_length_m)
        gained = (energy - work - first[None]) / scale[None]
        return jnp.max(jnp.where(stands, gained, 0.0))

    for share, when in ((0.0, "without the actuator"), (0.5, "beyond the actuator's work_j")):
        gained = float(excess(jnp.asarray(share)))
        trial.require(
            gained <= _ENERGY_TOLERANCE,
            f" makes energy from nothing, {when}: {gained:.2%} of its energy within "
            f"{_TICKS * _TICK_S:g} s; check the signs of its forces, of `energy` and of work_j",
        )
