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

from tegotae._support.errors import TegotaeError, require_count, unknown
from tegotae._support.limits import MOST_WEIGHTS
from tegotae.measures.objectives.fitness import EPISODE
from tegotae.parts.controller import Controller, Tegotae
from tegotae.parts.oscillators import PHASE, oscillator_named
from tegotae.parts.terms import (
    Actuation,
    ConstantGain,
    LearnedActuation,
    Reflex,
    Sector,
    SectorAndReflex,
    VanillaAction,
    VanillaReaction,
)
from tegotae.systems.experiment import Experiment
from tegotae.systems.grammar import BUDGET, LearnedTerms, learned_terms, networks, with_networks
from tegotae.systems.system import System

_OBSERVATIONS = {"F": ("spring_force",), "Fv": ("spring_force", "velocity")}
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
    def terms(self) -> LearnedTerms:
        """Which terms are learned beside an oscillator."""
        return LearnedTerms(
            action=self.learned_action,
            reaction=self.reaction,
            gain=self.gain,
            actuation=self.actuation if self.learned_actuation else None,
        )

    @property
    def architecture(self) -> str:
        """The paper's name of the architecture: V, VG, VT, VGT, AR, ..., ARGT, or T."""
        return "T" if self.is_single_network else self.terms.architecture

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
        given = "" if self.learned_actuation else f"-{self.actuation_name}"
        name = f"{self.terms.name}{given}-w{self.omega_t:g}"
        return name if self.oscillator == PHASE else f"{name}+{self.oscillator}"

    @property
    def learned_terms(self) -> tuple[str, ...]:
        """Which of A, R, G, T are networks."""
        return ("T",) if self.is_single_network else self.terms.learned

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
        oscillator = oscillator_named(self.oscillator)
        others = oscillator.n_weights
        if self.is_single_network:
            inputs = {"T": _OBSERVATIONS[self.actuation]}
        else:
            inputs = self.terms.inputs(_OBSERVATIONS.__getitem__)
            others += self.gain is None
        learned = networks(self.name, inputs, budget, others=others)
        if "T" in learned:
            actuation = LearnedActuation(learned["T"].inputs, learned["T"].hidden)
        else:
            actuation = _VANILLA_ACTUATION[self.actuation][1]
        if self.is_single_network:
            return Controller(actuation)
        vanilla = Tegotae(VanillaAction(), VanillaReaction(), ConstantGain())
        return Controller(actuation, oscillator, with_networks(vanilla, learned))

    def experiment(self, *, budget: int = BUDGET, **settings: object) -> Experiment:
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
    if (terms := learned_terms(name)) is not None:
        actuation = terms.actuation or "f"
        model = Model(
            terms.action, terms.reaction, terms.gain, "T" in terms.learned, actuation, 8.0
        )
        if model.name in models:
            return models[model.name]
    raise unknown("model", name, [*{m.architecture: 0 for m in models.values()}, *models])


def build(name: str, budget: int = BUDGET) -> Controller:
    """The controller of the model of that name (see `find`), within a budget of weights.

    Args:
        name: the model's, such as "ART" or "V-sector-w8".
        budget: weights at most.
    """
    return find(name).controller(budget)
