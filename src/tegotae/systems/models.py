"""Vanilla controllers by presets, and the 218 models of the paper's study.

The models are every pairing of feedback, actuation and frequency.

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
import math
import re
from dataclasses import dataclass, field, replace
from functools import cache

from tegotae._support.errors import TegotaeError, require_count, require_finite, unknown
from tegotae._support.limits import MOST_RAD_PER_S, MOST_WEIGHTS
from tegotae.measures.objectives.fitness import EPISODE
from tegotae.parts.bodies import Hopper
from tegotae.parts.controller import Controller, Tegotae
from tegotae.parts.oscillators import PHASE, Oscillator, PhaseOscillator, oscillator_named
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
from tegotae.systems.grammar import ACTUATION_INPUTS, BUDGET, LearnedTerms, learned_terms, networks
from tegotae.systems.observations import observation
from tegotae.systems.system import System

PAPERS = PhaseOscillator()
"""The paper's oscillator."""


@dataclass(frozen=True, kw_only=True)
class Preset:
    """A hopper, its vanilla controller's numbers, and how it is released."""

    about: str
    """One line on where the numbers come from."""
    hopper: Hopper = field(default_factory=Hopper)
    sector: Sector = field(default_factory=Sector)
    actuation: str = "sector"
    """The actuation that the preset stands for: "sector", "reflex" or "both"."""
    omega_rad_per_s: float = 5.0
    """Frequency ω [rad/s]."""
    sigma: float = 2.753
    """Gain σ [rad/(s N)]."""
    height_m: float = 1.2
    """Release height [m], at rest."""

    def controller(self, actuation: str, oscillator: Oscillator = PAPERS) -> Controller:
        """The vanilla controller with this actuation: "sector", "reflex" or "both".

        Args:
            actuation: its name.
            oscillator: the paper's by default.

        Raises:
            TegotaeError: for another actuation.
        """
        sector = self.sector
        actuations: dict[str, Actuation] = {
            "sector": sector,
            "reflex": Reflex(),
            "both": SectorAndReflex(sector.start_rad, sector.width_rad, sector.duration_s),
        }
        if actuation not in actuations:
            raise unknown("actuation", actuation, actuations)
        terms = Tegotae(VanillaAction(), VanillaReaction(), ConstantGain())
        return Controller(actuations[actuation], oscillator, terms)


PRESETS: dict[str, Preset] = {
    "paper": Preset(
        about="the paper's hopper; numbers from its co-author's program, the paper prints none"
    ),
    "pyTegotaeCPG": Preset(
        about="the exact rules of the program daiowaki1229/pyTegotaeCPG (2025): damping in flight "
        "too, a sector from 1.6π of width 0.02·ω·π, released at the rest length",
        hopper=Hopper(flight_damping_ns_per_m=0.2),
        sector=Sector(start_rad=1.6 * math.pi, width_rad=0.0, duration_s=0.02 * math.pi),
        height_m=1.0,
    ),
}


def preset(name: str) -> Preset:
    """The preset of that name.

    Raises:
        TegotaeError: for an unknown name, with the nearest ones.
    """
    if name not in PRESETS:
        raise unknown("preset", name, PRESETS)
    return PRESETS[name]


_ACTUATIONS = {
    **dict.fromkeys(("sector", "reflex", "both")),
    **{f"t{inputs}": inputs for inputs in ACTUATION_INPUTS},
}
"""Inputs of a learned actuation, by the names of all."""


@dataclass(frozen=True)
class Model:
    """One cell of the study's design: which terms are learned, from what, at which frequency.

    Args:
        terms: which terms are learned beside an oscillator; none of the single network.
        actuation: "sector", "reflex" or "both"; or `t` and what a learned actuation depends on,
            such as "tphif", or what the single network senses, "tF" or "tFv".
        omega_t: training frequency ω_t [rad/s]; None for the single network.
        oscillator: by its name (`tegotae.parts.oscillators.OSCILLATORS`); the paper's by default.

    Raises:
        TegotaeError: for a frequency that is not positive, an unknown oscillator, or one in a
            single network.
    """

    terms: LearnedTerms
    actuation: str
    omega_t: float | None
    oscillator: str = PHASE

    def __post_init__(self) -> None:
        oscillator_named(self.oscillator)
        if self.omega_t is not None:
            require_finite("omega", self.omega_t, above=0.0, most=MOST_RAD_PER_S)
        if self.is_single_network and self.oscillator != PHASE:
            raise TegotaeError(
                f"{self.name} is a network without an oscillator; leave {self.oscillator} out"
            )

    @property
    def is_single_network(self) -> bool:
        """True for the network without oscillator."""
        return self.omega_t is None

    @property
    def architecture(self) -> str:
        """The paper's name of the architecture: V, VG, VT, VGT, AR, ..., ARGT, or T."""
        return "T" if self.is_single_network else self.terms.architecture

    @property
    def name(self) -> str:
        """The stable name."""
        if self.is_single_network:
            return f"T-{self.actuation[1:]}"
        suffix = "" if self.terms.actuation else f"-{self.actuation}"
        name = f"{self.terms.name}{suffix}-w{self.omega_t:g}"
        return name if self.oscillator == PHASE else f"{name}+{self.oscillator}"

    @property
    def learned_terms(self) -> tuple[str, ...]:
        """Names of the terms among A, R, G, T that are networks."""
        return ("T",) if self.is_single_network else self.terms.learned

    @property
    def observation(self) -> tuple[str, ...]:
        """All that the model senses of the body."""
        sensed = {self.terms.reaction, self.terms.gain, self.actuation[1:]}
        return observation("Fv" if "Fv" in sensed else "F").senses

    @property
    def is_trained(self) -> bool:
        """True if there is more to train than the σ of a pure V model, which a search finds."""
        return bool(self.learned_terms) or oscillator_named(self.oscillator).n_weights > 0

    def controller(self, budget: int = BUDGET) -> Controller:
        """The controller, with as many weights as the budget allows (`hidden_sizes`).

        Raises:
            TegotaeError: for a budget too small for one neuron per network.
        """
        require_count("budget", budget, most=MOST_WEIGHTS)
        if self.is_single_network:
            inputs = {"T": observation(self.actuation[1:]).senses}
            network = networks(self.name, inputs, budget)["T"]
            return Controller(LearnedActuation(network.inputs, network.hidden))
        actuation = "sector" if self.terms.actuation else self.actuation
        vanilla = PRESETS["paper"].controller(actuation, oscillator_named(self.oscillator))
        return self.terms.learned_upon(
            vanilla, self.name, lambda observed: observation(observed).senses, budget
        )

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
    observations = ("F", "Fv")
    observed = (None, *observations)
    models = [
        Model(LearnedTerms(action=a, reaction=r, gain=g, actuation=t), actuation, omega)
        for a, r, g, (actuation, t), omega in itertools.product(
            (False, True), observed, observed, _ACTUATIONS.items(), (4.0, 8.0)
        )
    ]
    models += [Model(LearnedTerms(), f"t{senses}", None) for senses in observations]
    return {model.name: model for model in models}


_WITH_OMEGA = re.compile(r"(?P<model>.+)-w(?P<omega>[0-9]+(?:[.][0-9]+)?)")


def at_another_omega(name: str) -> Model | None:
    """One of the 218 models, trained at any frequency; None for another kind of name.

    Raises:
        TegotaeError: for a frequency that is not positive.

    Example:
        >>> at_another_omega("V-sector-w5").omega_t
        5.0
    """
    parts = _WITH_OMEGA.fullmatch(name)
    model = parts and all_models().get(f"{parts['model']}-w8")
    return replace(model, omega_t=float(parts["omega"])) if parts and model else None


def find(name: str) -> Model:
    """The model of that name; a bare architecture names its plainest member.

    `V`, `AR`, ... stand for the member at ω_t = 8 rad/s that senses F_k alone, with reflex
    actuation or, where the actuation is learned, one on [φ, f]; `T` stands for `T-F`. A model of
    the paper may have any other ω_t, such as `-w5`. A name followed by `+` and an oscillator's
    (`tegotae.parts.oscillators.OSCILLATORS`) is the model with that oscillator.

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
    if (model := at_another_omega(name)) is not None:
        return model
    if (terms := learned_terms(name)) is not None:
        model = Model(terms, f"t{terms.actuation}" if terms.actuation else "reflex", 8.0)
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
