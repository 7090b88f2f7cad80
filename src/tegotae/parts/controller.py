"""The controller: Tegotae terms, an oscillator and an actuation, for one limb or several."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import jax
import jax.numpy as jnp

from tegotae._support.errors import (
    TegotaeError,
    is_of,
    require_kind,
    whole_numbers,
)
from tegotae.parts._shapes import (
    Number,
    PartWeights,
    PerCommand,
    PerLimb,
    StateTree,
    Weights,
    WeightVector,
)
from tegotae.parts.couplings import Coupling
from tegotae.parts.oscillators import Oscillator
from tegotae.parts.parameters import Part, positive, whole
from tegotae.parts.terms.actuation import Actuation
from tegotae.parts.terms.base import ConstantGain, Signals, Term
from tegotae.parts.weight_names import WeightName, inside, numbered


@dataclass(frozen=True)
class Tegotae(Part):
    """The feedback law `f = G · A′(φ) · R(s)` [rad/s] (paper equation 4).

    Args:
        action: A′(φ).
        reaction: R(s).
        gain: G; a constant σ or a function of phase and senses.
        limit_rad_per_s: L, if the feedback is to saturate smoothly, `f = L tanh(G A′ R / L)`.
            The paper's law has none; an agent's action is bounded (`tegotae.envs`).

    Raises:
        TegotaeError: for a limit that is not positive.

    Example:
        >>> from tegotae.parts.terms import ConstantGain, VanillaAction, VanillaReaction
        >>> Tegotae(VanillaAction(), VanillaReaction(), ConstantGain(start=2.0)).gain.start
        2.0
    """

    action: Term
    reaction: Term
    gain: Term
    limit_rad_per_s: float | None = positive(None)

    def feedback(self, action: PerLimb, reaction: PerLimb, gain: PerLimb) -> PerLimb:
        """f [rad/s], of the values of the terms."""
        feedback = gain * action * reaction
        limit = self.limit_rad_per_s
        return feedback if limit is None else limit * jnp.tanh(feedback / limit)


@dataclass(frozen=True)
class Controller(Part):
    """A controller of a body: oscillator, Tegotae feedback and actuation, one unit per limb.

    Without `oscillator` and `tegotae` it is the single network that the paper compares with: its
    actuation reads the senses directly.

    All units are alike but for their weights. Each feels its own limb alone; `coupling`, if any, is
    the only place where they see each other. The hopper's controller is a network of one unit.

    The weights form one flat vector: for each set of weights those of action, reaction, gain,
    actuation and oscillator (`layout`), and then the coupling's. A controller holds no weights and
    no state, and is hashable: it is the static part of a compiled program.

    Args:
        actuation: from the signals of a limb to its force.
        oscillator: the rhythm; None without.
        tegotae: the feedback; None without.
        limbs: how many units.
        coupling: between the oscillators of several limbs; None for decentralised control.
        sharing: which set of weights each unit has, numbered from 0 on: (0, 0, 0, 0) is shared by
            all, the default; (0, 0, 1, 1) by girdle; (0, 1, 2, 3) is free.
        wiring: which limb of the body each unit feels and drives; in their order by default.

    Raises:
        TegotaeError: for a coupling that is none, or without oscillators or limbs to couple, sets
            that are not numbered through, or a wiring that leaves a limb undriven or drives it
            twice.

    Example:
        >>> from tegotae.parts.oscillators import PhaseOscillator
        >>> from tegotae.parts.terms import ConstantGain, Reflex, VanillaAction, VanillaReaction
        >>> terms = Tegotae(VanillaAction(), VanillaReaction(), ConstantGain())
        >>> Controller(Reflex(), PhaseOscillator(), terms).n_weights
        1
        >>> Controller(Reflex(), PhaseOscillator(), terms, limbs=4, sharing=(0, 0, 1, 1)).n_weights
        2
    """

    actuation: Actuation
    oscillator: Oscillator | None = None
    tegotae: Tegotae | None = None
    limbs: int = whole(1)
    coupling: Coupling | None = None
    sharing: tuple[int, ...] | None = None
    wiring: tuple[int, ...] | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.coupling is not None:
            require_kind("coupling", self.coupling, Coupling, "a Coupling")
            if self.oscillator is None:
                raise TegotaeError("the controller has a coupling but no oscillators to couple")
            if self.limbs < 2:
                raise TegotaeError("a coupling needs at least two limbs, and this controller has 1")
            self.coupling.check(self.limbs)
        for name, check in (("sharing", _check_sharing), ("wiring", _check_wiring)):
            if getattr(self, name) is not None:
                numbers = whole_numbers(name, getattr(self, name))
                check(numbers, self.limbs)
                object.__setattr__(self, name, numbers)
        if is_of(self.actuation, Actuation):
            self.actuation.check(self.limbs, self.sets)

    @property
    def limb_shape(self) -> tuple[int, ...]:
        """Leading shape of arrays, before the axes of the lanes: () with one limb, else
        (limbs,)."""
        return () if self.limbs == 1 else (self.limbs,)

    @property
    def terms(self) -> dict[str, Term]:
        """The terms by role, in the order of their weights."""
        t = self.tegotae
        feedback = {} if t is None else {"action": t.action, "reaction": t.reaction, "gain": t.gain}
        return {**feedback, "actuation": self.actuation}

    @property
    def reads(self) -> frozenset[str]:
        """Names of the signals that the terms and the oscillator read."""
        rhythm = () if self.oscillator is None else self.oscillator.READS
        return frozenset(rhythm).union(*(term.reads for term in self.terms.values()))

    @property
    def _parts(self) -> dict[str, Term | Oscillator]:
        """Return the parts of a unit that have weights, by role, in order."""
        rhythm = self.oscillator
        learned = {} if rhythm is None or not rhythm.n_weights else {"oscillator": rhythm}
        return {**self.terms, **learned}

    @property
    def has_a_gain_alone(self) -> bool:
        """True if the only weight is that of a constant gain σ, as in vanilla Tegotae."""
        tegotae = self.tegotae
        return (
            tegotae is not None
            and isinstance(tegotae.gain, ConstantGain)
            and self.n_weights == tegotae.gain.n_weights
        )

    @property
    def layout(self) -> dict[str, slice]:
        """Slices of each part's weights within a unit's."""
        slices: dict[str, slice] = {}
        start = 0
        for role, part in self._parts.items():
            slices[role] = slice(start, start + part.n_weights)
            start += part.n_weights
        return slices

    def of_part(self, role: str, weights: Weights) -> PartWeights:
        """Return the weights of one part of a unit.

        Args:
            role: part by its role: "action", "reaction", "gain", "actuation" or "oscillator".
            weights: weights of the unit; their first axis is that of the weights.
        """
        return weights[self.layout[role]]

    @property
    def unit_weights(self) -> int:
        """Number of trained parameters of a unit."""
        return sum(part.n_weights for part in self._parts.values())

    @property
    def unit_weight_names(self) -> dict[str, tuple[WeightName, ...]]:
        """Names of the weights of a unit, part by part."""
        return {role: _names(part) for role, part in self._parts.items()}

    @property
    def weight_names(self) -> tuple[WeightName, ...]:
        """Names of all weights: the set, if there are several, the part, and the name there.

        Example:
            >>> from tegotae.systems.recipe import recipe
            >>> recipe("V-reflex-w8").controller().weight_names
            (('gain', 'sigma'),)
        """
        parts = self.unit_weight_names.items()
        unit = tuple(path for role, names in parts for path in inside((role,), names))
        if self.sets > 1:
            unit = tuple(path for n in range(self.sets) for path in inside(("set", n), unit))
        if self.coupling is None:
            return unit
        return (*unit, *inside(("coupling",), self.coupling.weight_names(self.limbs)))

    @property
    def sets(self) -> int:
        """Number of units with weights of their own."""
        return 1 if self.sharing is None else max(self.sharing) + 1

    @property
    def n_weights(self) -> int:
        """Number of trained parameters of the controller."""
        between = 0 if self.coupling is None else self.coupling.n_weights(self.limbs)
        return self.sets * self.unit_weights + between

    def initial(self, key: jax.Array) -> WeightVector:
        """Return random weights to start training from, shape [n_weights].

        Args:
            key: key of JAX's random numbers.
        """
        if self.sets == 1 and self.coupling is None:
            return self._initial_unit(key)
        unit_key, between = jax.random.split(key)
        units = [self._initial_unit(subkey) for subkey in jax.random.split(unit_key, self.sets)]
        if self.coupling is not None:
            units.append(self.coupling.initial(between, self.limbs))
        return jnp.concatenate(units)

    def _initial_unit(self, key: jax.Array) -> WeightVector:
        keys = jax.random.split(key, len(self._parts))
        parts = [part.initial(k) for part, k in zip(self._parts.values(), keys, strict=True)]
        return jnp.concatenate(parts)

    def spread(self, weights: Weights) -> Weights:
        """Return the weights limb by limb: those of the units [(limbs,) ...], the coupling's as is.

        Args:
            weights: n_weights arrays, each of the shape of the lanes.

        Returns:
            unit_weights arrays with a limb axis, if there are several, and those of the coupling.
        """
        if not self.limb_shape:
            return weights
        n, sharing = self.unit_weights, self.sharing or (0,) * self.limbs
        units = [jnp.stack([weights[unit * n + i] for unit in sharing]) for i in range(n)]
        return (*units, *(weights[i] for i in range(self.sets * n, self.n_weights)))

    def feedback(self, weights: Weights, signals: Signals) -> PerLimb:
        """Return the Tegotae feedback `f = G · A′ · R` [rad/s] (equation 4), per limb.

        It is zero without Tegotae terms.

        Args:
            weights: weights of a unit; their first axis is that of the weights.
            signals: phases and senses, per limb.
        """
        if self.tegotae is None:
            return jnp.zeros_like(next(iter(signals.values.values())))
        tegotae = self.tegotae
        action = tegotae.action(self.of_part("action", weights), signals)
        reaction = tegotae.reaction(self.of_part("reaction", weights), signals)
        gain = tegotae.gain(self.of_part("gain", weights), signals)
        return self.tegotae.feedback(action, reaction, gain)

    def command(self, weights: Weights, signals: Signals, max_force_n: Number) -> PerCommand:
        """Compute the actuator command, per limb: a force [N] is clipped to [0, α].

        Args:
            weights: weights of a unit; their first axis is that of the weights.
            signals: phases, senses and feedback, per limb.
            max_force_n: largest force α [N].
        """
        command = self.actuation(self.of_part("actuation", weights), signals)
        return self.bounded(command, max_force_n)

    def bounded(self, command: PerCommand, max_force_n: Number) -> PerCommand:
        """Return a command as the actuator takes it: a force [N] is clipped to [0, α].

        Args:
            command: command, per limb.
            max_force_n: largest force α [N].
        """
        if self.actuation.commands_force:
            command = jnp.clip(command, 0.0, max_force_n)
        return command

    def rate(
        self,
        weights: Weights,
        oscillator: StateTree,
        omega: PerLimb,
        feedback: PerLimb,
        signals: Signals,
    ) -> StateTree:
        """Return the time derivative of the oscillators' state.

        Args:
            weights: weights of all units; their first axis is that of the weights.
            oscillator: state of the oscillators, per limb.
            omega: frequency ω [rad/s], per limb.
            feedback: Tegotae feedback [rad/s], per limb; the coupling adds to it.
            signals: phases and senses, per limb.
        """
        if self.oscillator is None:
            return ()
        if self.coupling is not None:
            feedback = feedback + self.coupling(weights[self.unit_weights :], signals)
        learned = self.layout.get("oscillator")
        arguments = () if learned is None else (weights[learned],)
        sensed: dict[str, Any] = {"signals": signals} if self.oscillator.READS else {}
        return self.oscillator.rate(oscillator, omega, feedback, *arguments, **sensed)


def _names(part: Term | Oscillator) -> tuple[WeightName, ...]:
    """Return the names that a part gives its weights, or numbers if they are not all different."""
    names = part.weight_names
    return names if len(set(names)) == part.n_weights == len(names) else numbered(part.n_weights)


def _check_sharing(sharing: tuple[int, ...], limbs: int) -> None:
    if len(sharing) != limbs:
        raise TegotaeError(
            f"sharing names the weights of {len(sharing)} limbs; the controller has {limbs}"
        )
    if sorted(set(sharing)) != list(range(max(sharing) + 1)):
        raise TegotaeError(
            f"sharing is {sharing}; number the sets of weights from 0 on and leave none out, "
            f"such as {tuple(range(limbs))}"
        )


def _check_wiring(wiring: tuple[int, ...], limbs: int) -> None:
    for limb in range(limbs):
        if (drivers := wiring.count(limb)) != 1:
            count = "by no unit" if drivers == 0 else f"by {drivers} units"
            raise TegotaeError(
                f"wiring is {wiring}: limb {limb} is driven {count}; every one of the limbs "
                f"0 ... {limbs - 1} must be driven once"
            )
    if len(wiring) != limbs:
        raise TegotaeError(f"wiring has {len(wiring)} entries; the controller has {limbs} limbs")
