"""The controller's own tick in pieces, each traced from the code that the simulator runs."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import jax
import jax.numpy as jnp

from lanewise.nodes import Node, array_of, input_node, keeping_calls, scalars
from tegotae._support.errors import TegotaeError, other_code
from tegotae.parts._shapes import ArrayTree, StateTree, Weights
from tegotae.parts.couplings import Coupling
from tegotae.parts.oscillators import Oscillator
from tegotae.parts.terms.actuation import Actuation
from tegotae.parts.terms.base import Signals, Term
from tegotae.parts.weight_names import WeightName, spelled
from tegotae.simulation.integrators import held, push
from tegotae_robots.c.reader import CReader
from tegotae_robots.c.text import commented
from tegotae_robots.robot import RobotController

Texts = str | Sequence[str] | Mapping[str, str | Sequence[str]]
"""Texts in C of the numbers of an argument."""
_Arrays = dict[str, jax.Array]


@dataclass(frozen=True)
class Piece:
    """One function of the tick: a graph of scalars."""

    name: str
    results: tuple[Node, ...]
    names: tuple[str, ...]
    """Names of its results."""
    comment: str
    """Description for a comment."""


class TracedTick:
    """A controller's tick in pieces, traced for one unit, in float32, as scalars.

    Args:
        robot: the controller.
        averages: whether a sector counts with its share of the tick, and not with the phase at the
            tick's start.

    Raises:
        CannotLower: for an operation that has no C, by its name.
    """

    def __init__(self, robot: RobotController, *, averages: bool) -> None:
        self._controller = robot.controller
        self._averages = averages
        self._trace = functools.partial(traced, CReader())
        oscillator = self._controller.oscillator
        self._signals = (*robot.senses, *(oscillator.SIGNALS if oscillator else ()))
        self._scales = {name: scale_name(name) for name in robot.signal_scales}
        self.state_names, self._structure = _state(oscillator)
        """Names of the numbers of the oscillator's state."""
        self._state = [f"o->{name}" for name in self.state_names]

    def pieces(self) -> dict[str, Piece]:
        """Return the functions that compose a tick, by name."""
        return {piece.name: piece for piece in self._all()}

    def _all(self) -> Iterator[Piece]:
        controller = self._controller
        oscillator, unit = controller.oscillator, controller.unit_weight_names
        if oscillator is not None:
            yield from self._oscillator_pieces(oscillator)
        if controller.coupling is not None:
            yield self._coupling(controller.coupling)
        for role, term in controller.terms.items():
            yield self._term(role, term, unit[role])
        if law := controller.tegotae:
            comment = "The Tegotae feedback f = G A' R [rad/s]."
            terms = {name: name for name in ("action", "reaction", "gain")}
            yield self._trace("feedback_law", law.feedback, ("feedback",), comment, **terms)
        else:
            comment, none = "There is no Tegotae feedback.", "nothing"
            yield self._trace(
                "feedback_law",
                lambda nothing: jnp.zeros_like(nothing),
                ("feedback",),
                comment,
                nothing=none,
            )
        if self._averages and oscillator is not None:
            comment = "The phase at the end of the tick [rad], whole turns not taken off."
            yield self._ahead(oscillator, "phase_after", oscillator.phase, ["reached"], comment)
        yield self._command(controller.actuation)
        if oscillator is not None:
            comment = f"The oscillator a tick later, its rate held: {_first_sentence(oscillator)}"
            names = self.state_names
            yield self._ahead(oscillator, "advanced", oscillator.settle, names, comment)

    def _inputs(self, values: _Arrays, scales: _Arrays) -> Signals:
        return Signals(values, {name: scale.reshape(()) for name, scale in scales.items()})

    def _from_leaves(self, leaves: Sequence[jax.Array]) -> StateTree:
        return jax.tree.unflatten(self._structure, leaves)

    def _oscillator_pieces(self, oscillator: Oscillator) -> Iterator[Piece]:
        """Yield the oscillator's pieces: its state at a phase, its signals for terms, and its
        phase.
        """
        names, state = oscillator.SIGNALS, self._state

        def rhythm(state: Sequence[jax.Array]) -> list[jax.Array]:
            values = oscillator.signals(self._from_leaves(state))
            return [values[name] for name in names]

        def phase_of(state: Sequence[jax.Array]) -> jax.Array:
            return oscillator.phase(self._from_leaves(state))

        comment, start = "The oscillator at a phase [rad].", oscillator.start
        yield self._trace(
            "started", lambda phase: start(phase), self.state_names, comment, phase="phase"
        )
        comment = "What the terms read of the oscillator."
        yield self._trace("rhythm", rhythm, names, comment, state=state)
        if oscillator.has_phase:
            yield self._trace("phase_of", phase_of, ("phase",), "The phase [rad].", state=state)

    def _term(self, role: str, term: Term, paths: Sequence[WeightName]) -> Piece:
        """Return the piece of A′, R, G or the smooth part of T."""
        values = {name: f"s->{name}" for name in self._signals}
        results: Sequence[str] = (role,)
        if role == "actuation":
            values["feedback"] = "feedback"
            results = self._controller.actuation.COMMANDS

        def evaluate(weights: Weights, values: _Arrays, scales: _Arrays) -> jax.Array:
            return term(weights, self._inputs(values, scales))

        letter = {"action": "A'", "reaction": "R", "gain": "G", "actuation": "T"}[role]
        return self._trace(
            f"{role}_term",
            evaluate,
            results,
            f"{letter}, the {role}: {_first_sentence(term)}",
            weights=_weights(paths),
            values=values,
            scales=self._scales,
        )

    def _command(self, actuation: Actuation) -> Piece:
        """Return the piece of the command over a tick: `Controller.bounded` and the sector."""
        controller, names = self._controller, actuation.COMMANDS
        comment = "Where the foot shall be [m]."
        if actuation.commands_force:
            comment = (
                "The actuator's force [N]: the term's, clipped to [0, alpha]; full force in the "
                f"sector, if there is one{'; its mean over the tick' if self._averages else ''}."
            )

        def evaluate(
            weights: Weights,
            smooth: _Arrays,
            phase: jax.Array,
            reached: jax.Array,
            omega: jax.Array,
            most: jax.Array,
        ) -> jax.Array:
            whole = smooth[names[0]] if len(names) == 1 else jnp.stack([smooth[n] for n in names])
            command = controller.bounded(whole, most)
            return push(actuation, weights, most, command, phase, reached, omega).mean_n

        return self._trace(
            "command_law",
            evaluate,
            names,
            comment,
            weights=_weights(controller.unit_weight_names["actuation"]),
            smooth={n: f"smooth_{n}" if len(names) > 1 else "smooth" for n in names},
            phase="phase",
            reached="reached" if self._averages else "phase",
            omega="omega",
            most="MAX_FORCE_N",
        )

    def _ahead(
        self,
        oscillator: Oscillator,
        name: str,
        read_off: Callable[[StateTree], ArrayTree],
        results: Sequence[str],
        comment: str,
    ) -> Piece:
        """Trace the signals of the oscillator's state at the end of a tick, its rate held."""

        def evaluate(
            weights: Weights,
            state: Sequence[jax.Array],
            omega: jax.Array,
            feedback: jax.Array,
            pulls: Sequence[jax.Array],
            tick: jax.Array,
            values: _Arrays,
        ) -> ArrayTree:
            for pull in pulls:
                feedback = feedback + pull
            oscillator_state, arguments = self._from_leaves(state), (weights,) if weights else ()
            sensed: dict[str, Any] = {"signals": Signals(values)} if values else {}
            rate = oscillator.rate(oscillator_state, omega, feedback, *arguments, **sensed)
            return read_off(held(oscillator_state, rate, tick))

        return self._trace(
            name,
            evaluate,
            results,
            comment,
            weights=_weights(self._controller.unit_weight_names.get("oscillator", ())),
            state=self._state,
            omega="omega",
            feedback="feedback",
            pulls=[] if self._controller.coupling is None else ["pull"],
            tick="TICK_S",
            values={name: f"s->{name}" for name in oscillator.READS},
        )

    def _coupling(self, coupling: Coupling) -> Piece:
        """Trace the input of each oscillator from the others: the only piece that sees all
        units."""
        limbs = range(self._controller.limbs)

        def evaluate(
            weights: Weights, values: dict[str, list[jax.Array]], scales: _Arrays
        ) -> jax.Array:
            rows = {name: jnp.stack(of_units) for name, of_units in values.items()}
            return coupling(weights, self._inputs(rows, scales))

        return self._trace(
            "coupling",
            evaluate,
            [f"unit_{i}" for i in limbs],
            f"What each oscillator gets from the others [rad/s]: {_first_sentence(coupling)}",
            weights=_weights(coupling.weight_names(len(limbs))),
            values={name: [f"heard[{i}].{name}" for i in limbs] for name in self._signals},
            scales=self._scales,
        )


def traced(
    reader: CReader,
    name: str,
    function: Callable[..., ArrayTree],
    results: Sequence[str],
    comment: str,
    **inputs: Texts,
) -> Piece:
    """Trace a piece; `inputs` are lists of C texts, one per argument of the function.

    Raises:
        CannotLower: for an operation that has no C, by its name.
        TegotaeError: for a function that gives another number of results.
    """
    flat, structure = jax.tree.flatten(inputs)
    shapes = [jax.ShapeDtypeStruct((1,), jnp.float32) for _ in flat]

    def of_flat(*arrays: jax.Array) -> ArrayTree:
        return function(**jax.tree.unflatten(structure, arrays))

    spoken = name.replace("_", " ")
    with other_code(f"the {spoken} cannot be traced for export"), keeping_calls():
        trace = jax.make_jaxpr(of_flat)(*shapes)
    nodes = [array_of([input_node(text)], (1,)) for text in flat]
    numbers = tuple(scalars(reader.read(trace, nodes)))
    if len(numbers) != len(results):
        raise TegotaeError(
            f"the {spoken} gives {len(numbers)} numbers for one limb; it must give {len(results)}"
        )
    return Piece(name, numbers, tuple(results), comment)


def scale_name(signal: str) -> str:
    """Return the constant by which a signal is divided before a network sees it."""
    return f"SCALE_{signal.upper()}"


def _first_sentence(part: object) -> str:
    """Return the first sentence of a part's docstring, in ASCII."""
    return commented(type(part).__doc__ or type(part).__name__)


def _weights(paths: Sequence[WeightName]) -> list[str]:
    return [f"w->{spelled(path)}" for path in paths]


def _state(oscillator: Oscillator | None) -> tuple[tuple[str, ...], jax.tree_util.PyTreeDef]:
    """Return the names of the numbers in an oscillator's state, and its structure."""
    if oscillator is None:
        return (), jax.tree.structure(())
    state = jax.eval_shape(oscillator.start, jax.ShapeDtypeStruct((1,), jnp.float32))
    paths, structure = jax.tree_util.tree_flatten_with_path(state)
    names: list[str] = []
    for number, (path, _) in enumerate(paths):
        name = jax.tree_util.keystr(path, simple=True, separator="_")
        names.append(name if name.isidentifier() and name not in names else f"state_{number}")
    return tuple(names), structure
