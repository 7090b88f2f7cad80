"""The 218 models of the paper's study: every pairing of feedback, actuation and frequency.

The paper gives the count, not the list. This full factorial gives exactly 218:

- feedback, 18: A {vanilla, learned} x R {vanilla F_k, learned [F_k], learned [F_k, ẏ]} x
  G {constant, learned [φ, F_k], learned [φ, F_k, ẏ]};
- actuation, 6: {vanilla, learned} x {[φ], [f], [φ, f]}, vanilla being sector, reflex, and both;
- ω_t, 2: {4, 8} rad/s;
- and 2 single networks without oscillator, on [F_k] and on [F_k, ẏ].

A name reads `ARCHITECTURE[-rOBS][-gOBS]-ACTUATION-wω`, where OBS is what a learned R or G senses
(`F`: F_k, `Fv`: F_k and ẏ) and ACTUATION is `sector`, `reflex`, `both`, or `tphi`, `tf`, `tphif`
for a network on φ, f, or both: `ART-rF-tphif-w8`. The single networks are `T-F` and `T-Fv`. Any of
the others can have another oscillator than the paper's: `ART-rF-tphif-w8+hopf`.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

from tegotae._support.errors import TegotaeError, require_count, unknown
from tegotae._support.limits import MOST_WEIGHTS
from tegotae.measures.objectives.fitness import EPISODE
from tegotae.parts.controller import Controller, Tegotae
from tegotae.parts.oscillators.named import PHASE, oscillator_named
from tegotae.parts.terms import (
    Actuation,
    ConstantGain,
    LearnedActuation,
    Network,
    Reflex,
    Sector,
    SectorAndReflex,
    Term,
    VanillaAction,
    VanillaReaction,
)
from tegotae.systems.experiment import Experiment
from tegotae.systems.system import System

BUDGET = 96
"""Trained numbers per controller in the paper."""

_OBSERVATIONS = {"F": ("spring_force",), "Fv": ("spring_force", "velocity")}
_ACTUATION_INPUTS = {"phi": ("phase",), "f": ("feedback",), "phif": ("phase", "feedback")}
_VANILLA_ACTUATION: dict[str, tuple[str, Actuation]] = {
    "phi": ("sector", Sector()),
    "f": ("reflex", Reflex()),
    "phif": ("both", SectorAndReflex()),
}


@dataclass(frozen=True)
class Model:
    """One cell of the study's design: which terms are learned, from what, at which frequency.

    Args:
        learned_action: whether A is learned.
        reaction: what a learned R senses, "F" or "Fv"; None for the vanilla R.
        gain: what a learned G senses besides φ, "F" or "Fv"; None for a constant gain.
        learned_actuation: whether T is learned.
        actuation: what the actuation depends on: "phi", "f" or "phif"; for the single network
            what it senses, "F" or "Fv".
        omega_t: training frequency ω_t [rad/s]; None for the single network.
        oscillator: by its name (`tegotae.parts.oscillators.OSCILLATORS`); the paper's by default.

    Raises:
        TegotaeError: for an unknown oscillator, or one in a single network.
    """

    learned_action: bool
    reaction: str | None
    gain: str | None
    learned_actuation: bool
    actuation: str
    omega_t: float | None
    oscillator: str = PHASE

    def __post_init__(self) -> None:
        oscillator_named(self.oscillator)
        if self.is_single_network and self.oscillator != PHASE:
            raise TegotaeError(
                f"{self.name} is a network without an oscillator; leave {self.oscillator} out"
            )

    @property
    def is_single_network(self) -> bool:
        """Whether this is the network without oscillator."""
        return self.omega_t is None

    @property
    def architecture(self) -> str:
        """The paper's name of the architecture: V, VG, VT, VGT, AR, ..., ARGT, or T."""
        if self.is_single_network:
            return "T"
        feedback = "A" * self.learned_action + "R" * (self.reaction is not None)
        return (feedback or "V") + "G" * (self.gain is not None) + "T" * self.learned_actuation

    @property
    def actuation_name(self) -> str:
        """`sector`, `reflex`, `both`, or `t` and the inputs of a learned actuation."""
        if self.is_single_network or self.learned_actuation:
            return f"t{self.actuation}"
        return _VANILLA_ACTUATION[self.actuation][0]

    @property
    def name(self) -> str:
        """The stable name."""
        if self.is_single_network:
            return f"T-{self.actuation}"
        parts = [self.architecture]
        parts += [f"r{self.reaction}"] if self.reaction else []
        parts += [f"g{self.gain}"] if self.gain else []
        name = "-".join([*parts, self.actuation_name, f"w{self.omega_t:g}"])
        return name if self.oscillator == PHASE else f"{name}+{self.oscillator}"

    @property
    def learned_terms(self) -> tuple[str, ...]:
        """Which of A, R, G, T are networks."""
        if self.is_single_network:
            return ("T",)
        flags = {
            "A": self.learned_action,
            "R": self.reaction is not None,
            "G": self.gain is not None,
            "T": self.learned_actuation,
        }
        return tuple(term for term, learned in flags.items() if learned)

    @property
    def observation(self) -> tuple[str, ...]:
        """All that the model senses of the body."""
        sensed = {self.reaction, self.gain, self.actuation if self.is_single_network else None}
        return _OBSERVATIONS["Fv" if "Fv" in sensed else "F"]

    @property
    def is_trained(self) -> bool:
        """Whether there is more to train than the σ of a pure V model, which a search finds."""
        return bool(self.learned_terms) or oscillator_named(self.oscillator).n_weights > 0

    def controller(self, budget: int = BUDGET) -> Controller:
        """The controller, with as many weights as the budget allows (`hidden_sizes`).

        Raises:
            TegotaeError: for a budget too small for one neuron per network.
        """
        require_count("budget", budget, most=MOST_WEIGHTS)
        inputs = self._network_inputs()
        constant_gain = not self.is_single_network and self.gain is None
        n_inputs = [len(Network(i, 1).reads) for i in inputs.values()]
        oscillator = oscillator_named(self.oscillator)
        others = constant_gain + oscillator.n_weights
        least = sum(n + 2 for n in n_inputs) + others
        if budget < least:
            raise TegotaeError(
                f"budget is {budget}, too small: {self.name} has at least {least} weights"
            )
        sizes = hidden_sizes(n_inputs, budget - others)
        hidden = dict(zip(inputs, sizes, strict=True))

        def network(role: str) -> Term:
            return Network(inputs[role], hidden[role])

        actuation = (
            LearnedActuation(inputs["T"], hidden["T"])
            if "T" in inputs
            else _VANILLA_ACTUATION[self.actuation][1]
        )
        if self.is_single_network:
            return Controller(actuation)
        tegotae = Tegotae(
            network("A") if "A" in inputs else VanillaAction(),
            network("R") if "R" in inputs else VanillaReaction(),
            network("G") if "G" in inputs else ConstantGain(),
        )
        return Controller(actuation, oscillator, tegotae)

    def experiment(self, *, budget: int = BUDGET, **settings: Any) -> Experiment:
        """The training and evaluation of this model, as in the paper but for what is given.

        Args:
            budget: largest number of trained parameters.
            settings: fields of the `Experiment`, its `System` or its `Release` in place of the
                paper's: body, height_m, timing, objective, protocol.

        Raises:
            TegotaeError: for a budget too small, or settings that do not fit together.

        Example:
            >>> find("T").experiment(height_m=1.1).omega is None
            True
        """
        system = System(controller=self.controller(budget), omega=self.omega_t, timing=EPISODE)
        return Experiment(name=self.name, system=system).replaced(**settings)

    def _network_inputs(self) -> dict[str, tuple[str, ...]]:
        if self.is_single_network:
            return {"T": _OBSERVATIONS[self.actuation]}
        inputs: dict[str, tuple[str, ...]] = {}
        if self.learned_action:
            inputs["A"] = ("phase",)
        if self.reaction:
            inputs["R"] = _OBSERVATIONS[self.reaction]
        if self.gain:
            inputs["G"] = ("phase", *_OBSERVATIONS[self.gain])
        if self.learned_actuation:
            inputs["T"] = _ACTUATION_INPUTS[self.actuation]
        return inputs


def hidden_sizes(n_inputs: list[int], budget: int) -> list[int]:
    """Hidden neurons per network: the most weights within the budget, as evenly as possible.

    A network with n inputs and h neurons has h·(n + 2) weights. Starting from equal h, neurons are
    added so that the total is the largest possible not above the budget; of equal totals the most
    even split is taken, then the first in the order of the networks.

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


@cache
def all_models() -> dict[str, Model]:
    """The 218 models by name, in a fixed order."""
    feedback = itertools.product((False, True), (None, "F", "Fv"), (None, "F", "Fv"))
    models = [
        Model(action, reaction, gain, learned, inputs, omega)
        for (action, reaction, gain), learned, inputs, omega in itertools.product(
            feedback, (False, True), ("phi", "f", "phif"), (4.0, 8.0)
        )
    ]
    models += [Model(False, None, None, True, observed, None) for observed in ("F", "Fv")]
    return {model.name: model for model in models}


def find(name: str) -> Model:
    """The model of that name; a bare architecture names its plainest member.

    `V`, `AR`, ... stand for the member at ω_t = 8 rad/s that senses F_k alone, with reflex
    actuation or, where the actuation is learned, one on [φ, f]; `T` stands for `T-F`. A name
    followed by `+` and an oscillator's (`tegotae.parts.oscillators.OSCILLATORS`) is the model with
    that oscillator.

    Raises:
        TegotaeError: for an unknown name, with the nearest ones.

    Example:
        >>> find("ART").name, find("ART+hopf").name
        ('ART-rF-tphif-w8', 'ART-rF-tphif-w8+hopf')
    """
    name, plus, oscillator = name.partition("+")
    if plus:
        return replace(find(name), oscillator=oscillator)
    models = all_models()
    if name in models:
        return models[name]
    if name == "T":
        return models["T-F"]
    for model in models.values():
        plain = model.observation == _OBSERVATIONS["F"] and model.omega_t == 8.0
        usual = model.actuation == ("phif" if model.learned_actuation else "f")
        if plain and usual and model.architecture == name:
            return model
    raise unknown("model", name, [*{m.architecture: 0 for m in models.values()}, *models])


def build(name: str, budget: int = BUDGET) -> Controller:
    """The controller of the model of that name (see `find`), within a budget of weights."""
    return find(name).controller(budget)
