"""The grammar of learned controllers: which of A, R, G and T are networks, and of what.

A name reads `ARCHITECTURE[-rOBS][-gOBS][-tIN]`, for the hopper's models and for designs of legs.
ARCHITECTURE is the paper's: V where neither A nor R is learned, then G and T where they are. OBS is
what a learned R or G senses (`F`, `Fv`, ...: `tegotae.systems.observations`), and IN what a learned
T depends on: `phi`, `f` or `phif`. Left out, they are `F` and `phif`. With a `+` before IN, what is
learned is added to the actuation that is there.
"""

from __future__ import annotations

import dataclasses
import itertools
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from tegotae._support.errors import TegotaeError, require_count, unknown
from tegotae.parts.controller import Controller
from tegotae.parts.terms import Actuation, ConstantGain, LearnedActuation, Network

BUDGET = 96
"""Trained numbers per controller in the paper."""

ACTUATION_INPUTS = {"phi": ("phase",), "f": ("feedback",), "phif": ("phase", "feedback")}
"""Inputs of a learned actuation, by its short name."""
ADDED = "+"
"""Before that name: what is learned is added to the system's own actuation."""

_USUAL = {"r": "F", "g": "F", "t": "phif"}
"""The default inputs, for names without any."""
_NAME = re.compile(
    r"(?P<feedback>V|A|R|AR)(?P<G>G?)(?P<T>T?)"
    r"(?:-r(?P<r>[A-Za-z]+))?(?:-g(?P<g>[A-Za-z]+))?(?:-t(?P<t>\+?[a-z]+))?"
)


@dataclass(frozen=True, kw_only=True)
class LearnedTerms:
    """Learned terms of `f = G · A′(φ) · R(s)` and of the actuation T, and their inputs.

    Args:
        action: whether A is learned.
        reaction: what a learned R senses, such as "F" or "Fv"; None for the vanilla R.
        gain: what a learned G senses besides φ; None for a constant gain.
        actuation: what a learned T depends on, "phi", "f" or "phif"; None for one that is given.
            With a + before it, what is learned is added to the one that is given.

    Raises:
        TegotaeError: for an unknown input of T.

    Example:
        >>> LearnedTerms(action=True, reaction="F", actuation="phif").name
        'ART-rF-tphif'
    """

    action: bool = False
    reaction: str | None = None
    gain: str | None = None
    actuation: str | None = None

    def __post_init__(self) -> None:
        if self.actuation is not None and self._actuation_inputs not in ACTUATION_INPUTS:
            raise unknown("input of a learned actuation", self.actuation, ACTUATION_INPUTS)

    @property
    def _actuation_inputs(self) -> str:
        return (self.actuation or "").removeprefix(ADDED)

    @property
    def architecture(self) -> str:
        """The paper's name: V, VG, VT, VGT, AR, ..., ARGT."""
        feedback = "A" * self.action + "R" * (self.reaction is not None)
        learned_gain, learned_actuation = self.gain is not None, self.actuation is not None
        return (feedback or "V") + "G" * learned_gain + "T" * learned_actuation

    @property
    def name(self) -> str:
        """The architecture, and what its terms sense."""
        inputs = {"r": self.reaction, "g": self.gain, "t": self.actuation}
        return "-".join([self.architecture, *(f"{k}{x}" for k, x in inputs.items() if x)])

    @property
    def learned(self) -> tuple[str, ...]:
        """Names of the terms among A, R, G, T that are networks."""
        return tuple(self.architecture.removeprefix("V"))

    def inputs(self, senses: Callable[[str], tuple[str, ...]]) -> dict[str, tuple[str, ...]]:
        """The signals that each network reads, by its term.

        Args:
            senses: the signals of an observation such as "F".

        Example:
            >>> LearnedTerms(reaction="F", gain="F").inputs({"F": ("spring_force",)}.__getitem__)
            {'R': ('spring_force',), 'G': ('phase', 'spring_force')}
        """
        inputs: dict[str, tuple[str, ...]] = {}
        if self.action:
            inputs["A"] = ("phase",)
        if self.reaction is not None:
            inputs["R"] = senses(self.reaction)
        if self.gain is not None:
            inputs["G"] = ("phase", *senses(self.gain))
        if self.actuation is not None:
            inputs["T"] = ACTUATION_INPUTS[self._actuation_inputs]
        return inputs

    def learned_upon(
        self,
        controller: Controller,
        name: str,
        senses: Callable[[str], tuple[str, ...]],
        budget: int,
        *,
        sigma: float = 1.0,
        actuation: Callable[[tuple[str, ...], int], Actuation] = LearnedActuation,
    ) -> Controller:
        """A vanilla controller with networks in place of the terms that are learned.

        Args:
            controller: the vanilla controller.
            name: the name of what is learned, for errors.
            senses: the signals of an observation such as "F".
            budget: largest number of weights.
            sigma: where a gain that is no network starts.
            actuation: makes a learned T of its inputs and its hidden neurons.

        Raises:
            TegotaeError: for a budget that does not give every network a neuron.
        """
        terms = controller.tegotae
        assert terms is not None  # of a vanilla controller
        learned = networks(
            name,
            self.inputs(senses),
            budget,
            commands=len(controller.actuation.COMMANDS),
            other_weights=(self.gain is None)
            + (controller.oscillator.n_weights if controller.oscillator else 0),
        )
        return dataclasses.replace(
            controller,
            actuation=controller.actuation
            if "T" not in learned
            else actuation(learned["T"].inputs, learned["T"].hidden),
            tegotae=dataclasses.replace(
                terms,
                action=learned.get("A", terms.action),
                reaction=learned.get("R", terms.reaction),
                gain=learned.get("G", ConstantGain(start=sigma)),
            ),
        )


def learned_terms(name: str) -> LearnedTerms | None:
    """The terms of a name; None for one that is no name of them.

    Args:
        name: such as `ART-rF-tphif`; what its terms sense may be left out.

    Raises:
        TegotaeError: for a sense of a term that is not learned, or an unknown input of T.

    Example:
        >>> learned_terms("ARG-rFv").name
        'ARG-rFv-gF'
    """
    match = _NAME.fullmatch(name)
    if match is None:
        return None
    learned = {"r": "R" in match["feedback"], "g": bool(match["G"]), "t": bool(match["T"])}
    for term, is_learned in learned.items():
        if match[term] and not is_learned:
            raise TegotaeError(f"{name} says what {term.upper()} senses, and it is not learned")
    inputs = {
        term: match[term] or _USUAL[term] for term, is_learned in learned.items() if is_learned
    }
    return LearnedTerms(
        action="A" in match["feedback"],
        reaction=inputs.get("r"),
        gain=inputs.get("g"),
        actuation=inputs.get("t"),
    )


def networks(
    name: str,
    inputs: Mapping[str, tuple[str, ...]],
    budget: int,
    *,
    commands: int = 1,
    other_weights: int = 0,
) -> dict[str, Network]:
    """A network for each term, as large as the budget allows.

    Args:
        name: whose networks they are, for an error.
        inputs: the signals that each reads, by term.
        budget: largest number of weights in all.
        commands: numbers that the actuation T commands, a network's neurons of each.
        other_weights: trained numbers beside the networks.

    Raises:
        TegotaeError: for a budget that does not give every network a neuron.

    Example:
        >>> nets = networks("AR", {"A": ("phase",), "R": ("spring_force",)}, 96, other_weights=1)
        >>> nets["A"].hidden
        14
    """
    costs = {term: len(Network(names, 1).reads) + 2 for term, names in inputs.items()}
    if "T" in costs:
        costs["T"] *= commands
    sizes = shared_out(name, costs, other_weights, budget)
    return {term: Network(inputs[term], size) for term, size in sizes.items()}


def shared_out(name: str, costs: dict[str, int], other_weights: int, budget: int) -> dict[str, int]:
    """Hidden neurons of each network, as evenly as the budget allows (`hidden_sizes`).

    Args:
        name: whose networks they are, for an error.
        costs: weights of a hidden neuron, by network.
        other_weights: trained numbers beside the networks.
        budget: largest number of weights in all.

    Raises:
        TegotaeError: for a budget that does not give every network a neuron.

    Example:
        >>> shared_out("ART", {"A": 4, "R": 3, "T": 10}, 1, 96)
        {'A': 5, 'R': 5, 'T': 6}
    """
    minimum = sum(costs.values()) + other_weights
    if budget < minimum:
        raise TegotaeError(f"budget is {budget}, too small: {name} has at least {minimum} weights")
    sizes = hidden_sizes([cost - 2 for cost in costs.values()], budget - other_weights)
    return dict(zip(costs, sizes, strict=True))


def hidden_sizes(n_inputs: list[int], budget: int) -> list[int]:
    """Hidden neurons per network: the most weights within the budget, as evenly as possible.

    A network with n inputs and h neurons has h·(n + 2) weights. Starting from equal h, neurons are
    added so that the total is the largest possible not above the budget; of equal totals the most
    even split is taken, then the first in the order of the networks.

    Args:
        n_inputs: numbers that each network reads.
        budget: weights of all of them together, at most.

    Raises:
        TegotaeError: for a budget that does not give every network a neuron.

    Example:
        >>> hidden_sizes([2, 1, 3], 96)
        [8, 8, 8]
    """
    if not n_inputs:
        return []
    require_count("budget", budget)
    costs = [n + 2 for n in n_inputs]
    equal = budget // sum(costs)
    if equal < 1:
        raise TegotaeError(
            f"a budget of {budget} weights is too small for networks that need "
            f"{sum(costs)} weights with one neuron each"
        )
    best: tuple[int, int, list[int]] | None = None
    for extra in itertools.product(range(-2, 4), repeat=len(costs)):
        sizes = [equal + e for e in extra]
        total = sum(h * cost for h, cost in zip(sizes, costs, strict=True))
        if min(sizes) < 1 or total > budget:
            continue
        rank = (total, min(sizes) - max(sizes))
        if best is None or rank > best[:2]:
            best = (*rank, sizes)
    assert best is not None  # extra = 0 is within the budget
    return best[2]
