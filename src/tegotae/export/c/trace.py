"""The controller's own tick in pieces, each traced from the code that the simulator runs."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import jax
import jax.numpy as jnp
import numpy as np

from tegotae._support.errors import TegotaeError
from tegotae.export.c.reader import CReader
from tegotae.lowering.nodes import Node, given, keeping_calls
from tegotae.parts._shapes import ArrayTree, StateTree, Weights
from tegotae.parts.controller import Controller, Tegotae
from tegotae.parts.couplings import Coupling
from tegotae.parts.terms.actuation import Actuation
from tegotae.parts.terms.base import Signals, Term
from tegotae.parts.weight_names import WeightName, spelled
from tegotae.simulation.integrators.base import held, push, settled

_Texts = str | Sequence[str] | Mapping[str, str | Sequence[str]]
"""What C calls the numbers of an argument."""
_Arrays = dict[str, jax.Array]


@dataclass(frozen=True)
class Piece:
    """One function of the tick: a graph of scalars."""

    name: str
    results: tuple[Node, ...]
    names: tuple[str, ...]
    """What its results are called."""


@dataclass(frozen=True)
class _Known(Term):
    """A term whose value is known already: a signal of that name."""

    name: str

    def __call__(self, weights: Weights, signals: Signals) -> jax.Array:
        return signals[self.name]


@dataclass(frozen=True)
class _Commanded(Actuation):
    """An actuation whose smooth part is known already."""

    own: Actuation

    @property
    def COMMANDS(self) -> tuple[str, ...]:  # type: ignore[override]  # noqa: N802
        return self.own.COMMANDS

    def full_force(
        self, phase_start: jax.Array, phase_end: jax.Array, omega: jax.Array
    ) -> tuple[jax.Array, jax.Array] | None:
        return self.own.full_force(phase_start, phase_end, omega)

    def __call__(self, weights: Weights, signals: Signals) -> jax.Array:
        return signals["command"]


@dataclass(frozen=True)
class _KnownCoupling(Coupling):
    """A coupling whose input to the oscillator is known already."""

    def __call__(self, weights: Weights, signals: Signals) -> jax.Array:
        return signals["coupling"]


class Tracer:
    """Traces a controller for one unit, in float32, as scalars.

    Args:
        controller: the controller.
        senses: names of what the body senses.
        scales: which of the signals have a scale.
    """

    def __init__(
        self, controller: Controller, senses: Sequence[str], scales: Sequence[str]
    ) -> None:
        self._controller = controller
        self._reader = CReader()
        oscillator = controller.oscillator
        rhythm = () if oscillator is None else tuple(oscillator.SIGNALS)
        self._signals = (*senses, *rhythm)
        self._scales = tuple(scales)
        self.state_names, self._structure = _state(controller)
        self._state = [f"o->{name}" for name in self.state_names]

    def _trace(
        self,
        name: str,
        function: Callable[..., ArrayTree],
        results: Sequence[str],
        **inputs: _Texts,
    ) -> Piece:
        """A piece: `inputs` are lists of C texts, one argument of the function each."""
        flat, structure = jax.tree.flatten(inputs)
        shapes = [jax.ShapeDtypeStruct((1,), jnp.float32) for _ in flat]

        def of_flat(*arrays: jax.Array) -> ArrayTree:
            return function(**jax.tree.unflatten(structure, arrays))

        try:
            with keeping_calls():
                trace = jax.make_jaxpr(of_flat)(*shapes)
        except TegotaeError:
            raise
        except Exception as error:  # whatever a user's part does with what it is given
            first = (str(error) or type(error).__name__).splitlines()[0]
            raise TegotaeError(f"the {name} cannot be traced for export: {first}") from error
        nodes = [np.array([given(text)], object) for text in flat]
        arrays = self._reader.read(trace, nodes)
        found = tuple(node for array in arrays for node in array.reshape(-1))
        if len(found) != len(results):
            raise TegotaeError(
                f"the {name} gives {len(found)} numbers for one limb; it must give {len(results)}"
            )
        return Piece(name, found, tuple(results))

    def _inputs(self, values: _Arrays, scales: _Arrays) -> Signals:
        return Signals(values, {name: scale.reshape(()) for name, scale in scales.items()})

    @property
    def _symbols(self) -> dict[str, dict[str, str]]:
        return {
            "values": {name: f"s->{name}" for name in self._signals},
            "scales": {name: scale_name(name) for name in self._scales},
        }

    def term(self, role: str, term: Term, paths: Sequence[WeightName]) -> Piece:
        """A′, R, G or the smooth part of T."""
        symbols = self._symbols
        results: Sequence[str] = (role,)
        if role == "actuation":
            symbols["values"]["feedback"] = "feedback"
            results = self._controller.actuation.COMMANDS

        def evaluate(weights: Weights, values: _Arrays, scales: _Arrays) -> jax.Array:
            return term(weights, self._inputs(values, scales))

        return self._trace(role, evaluate, results, weights=_weights(paths), **symbols)

    def feedback(self) -> Piece:
        """The law that makes the terms one feedback: `Controller.feedback`."""
        law = self._controller.tegotae
        names = [] if law is None else ["action", "reaction", "gain"]
        limit = None if law is None else law.limit_rad_per_s
        action, reaction, gain = (_Known(name) for name in ("action", "reaction", "gain"))
        known = Tegotae(action, reaction, gain, limit) if names else None
        controller = Controller(_Commanded(self._controller.actuation), tegotae=known)

        def evaluate(values: _Arrays) -> jax.Array:
            return controller.feedback((), Signals(values))

        values = {name: name for name in (names or ["nothing"])}
        return self._trace("feedback", evaluate, ("feedback",), values=values)

    def command(self, *, averaged: bool = False) -> Piece:
        """The command over a tick: `Controller.command` and the sector.

        Args:
            averaged: whether the sector counts with its share of the tick, and not with the phase
                at the tick's start.
        """
        actuation = self._controller.actuation
        names = actuation.COMMANDS
        controller = Controller(_Commanded(actuation), self._controller.oscillator)

        def evaluate(
            smooth: _Arrays,
            phase: jax.Array,
            reached: jax.Array,
            omega: jax.Array,
            most: jax.Array,
        ) -> jax.Array:
            whole = smooth[names[0]] if len(names) == 1 else jnp.stack([smooth[n] for n in names])
            command = controller.command((), Signals({"command": whole}), most)
            return push(controller, most, command, phase, reached, omega).mean_n

        smooth = {name: f"smooth_{name}" if len(names) > 1 else "smooth" for name in names}
        given_too = {
            "phase": "phase",
            "reached": "reached" if averaged else "phase",
            "omega": "omega",
            "most": "MAX_FORCE_N",
        }
        return self._trace("command", evaluate, names, smooth=smooth, **given_too)

    def rhythm(self) -> Piece:
        """What terms may read of the oscillator."""
        oscillator = self._controller.oscillator
        assert oscillator is not None

        def evaluate(state: Sequence[jax.Array]) -> list[jax.Array]:
            values = oscillator.signals(self._of_leaves(state))
            return [values[name] for name in oscillator.SIGNALS]

        return self._trace("rhythm", evaluate, oscillator.SIGNALS, state=self._state)

    def phase(self) -> Piece:
        """The oscillator's phase."""
        oscillator = self._controller.oscillator
        assert oscillator is not None
        return self._trace(
            "phase_of",
            lambda state: oscillator.phase(self._of_leaves(state)),
            ("phase",),
            state=self._state,
        )

    def start(self) -> Piece:
        """The oscillator's state at a phase."""
        oscillator = self._controller.oscillator
        assert oscillator is not None

        def evaluate(phase: jax.Array) -> list[jax.Array]:
            return jax.tree.leaves(oscillator.start(phase))

        return self._trace("started", evaluate, self.state_names, phase="phase")

    def advance(self, paths: Sequence[WeightName]) -> Piece:
        """The oscillator's state a tick later, its rate held."""
        return self._ahead(
            "advanced", lambda own, at: jax.tree.leaves(settled(own, at)), self.state_names, paths
        )

    def phase_after(self, paths: Sequence[WeightName]) -> Piece:
        """The oscillator's phase a tick later, its rate held and whole turns not taken off."""
        oscillator = self._controller.oscillator
        assert oscillator is not None
        return self._ahead("phase_after", lambda _, at: oscillator.phase(at), ("reached",), paths)

    def _ahead(
        self,
        name: str,
        read_off: Callable[[Controller, StateTree], ArrayTree],
        results: Sequence[str],
        paths: Sequence[WeightName],
    ) -> Piece:
        """What is read off the oscillator's state at the end of a tick."""
        own = self._controller
        coupling = None if own.coupling is None else _KnownCoupling()
        controller = Controller(
            _Commanded(own.actuation),
            own.oscillator,
            limbs=1 if coupling is None else 2,
            coupling=coupling,
        )
        pull = {} if coupling is None else {"coupling": "pull"}

        def evaluate(
            weights: Weights,
            state: Sequence[jax.Array],
            omega: jax.Array,
            feedback: jax.Array,
            pull: _Arrays,
            tick: jax.Array,
        ) -> ArrayTree:
            at = self._of_leaves(state)
            rate = controller.rate(weights, at, omega, feedback, Signals(pull))
            return read_off(controller, held(at, rate, tick))

        return self._trace(
            name,
            evaluate,
            results,
            weights=_weights(paths),
            state=self._state,
            omega="omega",
            feedback="feedback",
            pull=pull,
            tick="TICK_S",
        )

    def coupling(self, paths: Sequence[WeightName], reads: Sequence[str]) -> Piece:
        """What each oscillator gets from the others: the only piece that sees all units."""
        coupling, limbs = self._controller.coupling, self._controller.limbs
        assert coupling is not None

        def evaluate(
            weights: Weights, values: dict[str, list[jax.Array]], scales: _Arrays
        ) -> jax.Array:
            rows = {name: jnp.stack(each) for name, each in values.items()}
            return coupling(weights, self._inputs(rows, scales))

        values = {name: [f"heard[{i}].{name}" for i in range(limbs)] for name in self._signals}
        scales = {name: scale_name(name) for name in self._scales}
        results = [f"unit_{i}" for i in range(limbs)]
        return self._trace(
            "coupling", evaluate, results, weights=_weights(paths), values=values, scales=scales
        )

    def _of_leaves(self, leaves: Sequence[jax.Array]) -> StateTree:
        return jax.tree.unflatten(self._structure, leaves)


def scale_name(signal: str) -> str:
    """The constant that a signal is divided by before a network sees it."""
    return f"SCALE_{signal.upper()}"


def _weights(paths: Sequence[WeightName]) -> list[str]:
    return [f"w->{spelled(path)}" for path in paths]


def _state(controller: Controller) -> tuple[tuple[str, ...], jax.tree_util.PyTreeDef]:
    """Names of the numbers that the oscillator's state has, and its structure."""
    if controller.oscillator is None:
        return (), jax.tree.structure(())
    state = jax.eval_shape(controller.oscillator.start, jax.ShapeDtypeStruct((1,), jnp.float32))
    paths, structure = jax.tree_util.tree_flatten_with_path(state)
    names: list[str] = []
    for number, (path, _) in enumerate(paths):
        name = "_".join(
            str(getattr(k, "name", getattr(k, "key", getattr(k, "idx", "")))) for k in path
        )
        names.append(name if name.isidentifier() and name not in names else f"state_{number}")
    return tuple(names), structure
