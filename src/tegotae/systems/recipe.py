"""Recipes: specifications of controllers to be trained, by name.

A recipe is a term set on a vanilla closed loop, at a frequency. Its name reads

- on the paper's hopper `TERMS[-ACTUATION][-wω][+OSCILLATOR]`, as in `ART-rF-tphif-w8`: ACTUATION is
  `sector`, `reflex` or `both` where it is not learned. The oscillator is the paper's by default;
- on a legged system `TERMS[-wω]@SYSTEM`, as in `ART@quadruped-c`; the frequency is the system's by
  default. SYSTEM is one of `tegotae.systems.vanilla.SYSTEMS`, `FILE.toml` or `FILE.py:OBJECT`.

`tegotae.systems.term_sets` has the names of term sets. A bare architecture such as `ART` is its
plainest member: it senses F_k alone, at 8 rad/s on the hopper, with a reflex or, where the
actuation is learned, one on [φ, f].

The paper's study has 218 recipes. It gives the count, not the list; this full factorial gives
exactly 218:

- feedback, 18: A {vanilla, learned} x R {vanilla F_k, learned [F_k], learned [F_k, ẏ]} x
  G {constant, learned [φ, F_k], learned [φ, F_k, ẏ]};
- actuation, 6: {vanilla, learned} x {[φ], [f], [φ, f]}, vanilla being sector, reflex, and both;
- ω_t, 2: {4, 8} rad/s;
- and 2 single networks without oscillator, `T-F` on [F_k] and `T-Fv` on [F_k, ẏ].
"""

from __future__ import annotations

import dataclasses
import itertools
import re
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import cast

from tegotae._support.errors import TegotaeError, require_count, require_finite, unknown
from tegotae._support.limits import MOST_RAD_PER_S, MOST_WEIGHTS
from tegotae.measures.objectives.fitness import EPISODE, Fitness, HoppingLegs
from tegotae.measures.objectives.objective import Objective
from tegotae.measures.objectives.walking import Walking
from tegotae.parts.bodies import Body, Walker
from tegotae.parts.controller import Controller
from tegotae.parts.fields import replace, unwrapped
from tegotae.parts.oscillators import PHASE, oscillator_named
from tegotae.parts.terms import FreeSectorAndReflex, Reflex, SectorAndReflex, TunedFoot
from tegotae.simulation.rollout import Timing
from tegotae.systems.experiment import Experiment
from tegotae.systems.legged import random_phases
from tegotae.systems.system import System
from tegotae.systems.term_sets import (
    ACTUATION_INPUTS,
    BUDGET,
    LAWS,
    LISTED,
    LearnedTerms,
    LoneNetworks,
    ShortLaw,
    TermSet,
    alternating_rad,
    learned_terms,
    nominal_speed_m_per_s,
    observed,
    terms_on_legs,
)
from tegotae.systems.vanilla import PRESETS, SYSTEMS, is_walker_file, legged_named

_OMEGA_T = 8.0
"""Frequency of a hopper's recipe whose name has none [rad/s]."""
_EPISODE_SHARE = 0.3
"""Length of a walker's episode of training, as a share of the time of its gait commands."""
_START_SEED = 0
"""Seed of the phases at the start of every training episode: as irregular as any."""


@dataclass(frozen=True, kw_only=True)
class Recipe:
    """Specification of a controller: terms on a vanilla closed loop, at a frequency.

    Args:
        terms: terms that replace the system's.
        system: the body, the vanilla controller, and the release.
        omega: ω [rad/s]; the system's if None. It also says which speed is wanted of a walker:
            2 B ω / π, at which a foot crosses its stride in half a turn.
        oscillator: its name (`tegotae.parts.oscillators.OSCILLATORS`); the system's by default.
        place: name of a legged system, as behind the @; empty of the paper's hopper.
        sigma: gain that training starts from [rad/(s N)].
        legs: names of the legs, in the body's order; empty of a hopper.

    Raises:
        TegotaeError: for a frequency that is not positive, a system without one, an unknown
            oscillator, or one in networks without.

    Example:
        >>> recipe("ART@quadruped-c").name, recipe("ART").controller().n_weights
        ('ART-rF-tphif@quadruped-c', 96)
    """

    terms: TermSet
    system: System
    omega: float | None = None
    oscillator: str = PHASE
    place: str = ""
    sigma: float = 1.0
    legs: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        oscillator_named(self.oscillator)
        if self.omega is not None:
            require_finite("omega", self.omega, above=0.0, most=MOST_RAD_PER_S)
        if self.system.omega is None:
            raise TegotaeError(f"{self.place} has no frequency of its own to learn at")
        if self.oscillator != PHASE and not self.terms.has_rhythm:
            raise TegotaeError(
                f"{self.terms.name} is a network without an oscillator; leave {self.oscillator} out"
            )

    @property
    def name(self) -> str:
        """The stable name, such as `ART-rF-tphif-w8` or `ART-rF-tphif-w3@quadruped-c`."""
        if self.place:
            omega = "" if self.omega is None else f"-w{self.omega:g}"
            return f"{self.terms.name}{omega}@{self.place}"
        vanilla = isinstance(self.terms, LearnedTerms) and self.terms.actuation is None
        actuation = f"-{self.actuation}" if vanilla else ""
        omega = "" if self.omega_t is None else f"-w{self.omega_t:g}"
        oscillator = "" if self.oscillator == PHASE else f"+{self.oscillator}"
        return f"{self.terms.name}{actuation}{omega}{oscillator}"

    @property
    def omega_t(self) -> float | None:
        """Frequency of the training ω_t [rad/s]; None without oscillators."""
        return self._omega if self.terms.has_rhythm else None

    @property
    def _omega(self) -> float:
        """The frequency, which sets a walker's wanted speed even where there is no oscillator."""
        return cast(float, self.system.omega if self.omega is None else self.omega)

    @property
    def actuation(self) -> str:
        """Name of the actuation: "sector", "reflex", "both", or `t` and the inputs of a learned
        one, such as "tphif"."""
        if isinstance(self.terms, LearnedTerms) and self.terms.actuation is not None:
            return f"t{self.terms.actuation}"
        if isinstance(self.terms, LoneNetworks):
            return f"t{self.terms.observation}"
        trained = self.terms.actuation if isinstance(self.terms, ShortLaw) else None
        return _ACTUATION_NAMES.get(type(trained or self.system.controller.actuation), "sector")

    @property
    def learned_terms(self) -> LearnedTerms:
        """The learned terms beside an oscillator; none for a short law or for networks alone."""
        return self.terms if isinstance(self.terms, LearnedTerms) else LearnedTerms()

    @property
    def observation(self) -> tuple[str, ...]:
        """All signals of the body that the terms sense."""
        names = self.terms.observation
        return observed(names, self.system.mechanics) if names else ()

    def controller(self, budget: int = BUDGET) -> Controller:
        """Return the controller, with as many weights as the budget allows.

        Args:
            budget: largest number of weights.

        Raises:
            TegotaeError: for a budget too small for one neuron per network, or for a short law.

        Example:
            >>> recipe("V-reflex-w8").controller().n_weights
            1
        """
        require_count("budget", budget, most=MOST_WEIGHTS)
        system = self.system
        if self.oscillator != PHASE:
            vanilla = dataclasses.replace(
                system.controller, oscillator=oscillator_named(self.oscillator)
            )
            system = dataclasses.replace(system, controller=vanilla)
        return self.terms.controller(system, budget, sigma=self.sigma, legs=self.legs)

    @property
    def fitness(self) -> Objective:
        """The paper's fitness of one leg, hopping of legs that push, or a walk at the wanted speed.

        Raises:
            TegotaeError: for a walker whose feet say no speed.
        """
        if self.system.body.limbs == 1:
            return Fitness()
        if not self._walks:
            return HoppingLegs()
        speed = nominal_speed_m_per_s(self.system, self._omega)
        if speed is None:
            raise TegotaeError(
                f"{self.place} has no ellipse that says which speed is wanted; make an Experiment "
                "of your own with Walking(speed_m_per_s=...)"
            )
        return Walking(speed_m_per_s=speed, settle_s=0.5 * self.timing.duration_s)

    @property
    def timing(self) -> Timing:
        """An episode of training: the hopper's, or for a walker long enough to settle."""
        timing = self.system.timing
        if not self._walks:
            return EPISODE
        return dataclasses.replace(timing, duration_s=_EPISODE_SHARE * timing.duration_s)

    @property
    def _walks(self) -> bool:
        return isinstance(unwrapped(self.system.mechanics), Walker)

    def experiment(self, *, budget: int = BUDGET, **settings: object) -> Experiment:
        """Return the training and evaluation of this recipe, as in the paper.

        On several legs every episode begins with the same phases, drawn once for all recipes.

        Args:
            budget: largest number of trained parameters.
            settings: fields of the `Experiment`, its `System` or its `Release` that are to be
                otherwise: body, height_m, timing, objective, protocol.

        Raises:
            TegotaeError: for a budget too small, or settings that do not fit together.

        Example:
            >>> recipe("T").experiment(height_m=1.1).omega is None
            True
        """
        controller, release = self.controller(budget), self.system.release
        body = self.system.mechanics
        if body.limbs > 1:
            body = cast(Body, settings.pop("body", body))
            release = dataclasses.replace(
                release,
                height_m=self.system.height_on(body),
                phase_rad=self._start(controller, body),
            )
        system = dataclasses.replace(
            self.system,
            controller=controller,
            body=body,
            omega=self.omega_t,
            release=release,
            timing=self.timing,
        )
        if "objective" not in settings:
            settings["objective"] = self.fitness
        return replace(Experiment(name=self.name, system=system), settings)

    def _start(self, controller: Controller, body: Body) -> float | tuple[float, ...]:
        """Return the phases that every training episode begins with [rad]: drawn, or of a clock,
        whose phases nothing changes, those of a trot.
        """
        if not self.terms.has_rhythm:
            return 0.0
        if controller.tegotae is None and isinstance(controller.actuation, TunedFoot):
            return alternating_rad(self.legs)
        return tuple(random_phases(body.limbs, 1, _START_SEED)[:, 0].round(3).tolist())


_ACTUATION_NAMES: dict[type, str] = {
    Reflex: "reflex",
    SectorAndReflex: "both",
    FreeSectorAndReflex: "both",
}
_HOPPERS = ("sector", "reflex", "both")
"""Vanilla actuations of the paper's hopper."""


@cache
def _hopper(actuation: str) -> System:
    return PRESETS["paper"].system(actuation)


def recipe(name: str) -> Recipe:
    """Return the recipe of a name.

    Args:
        name: see this module: a model of the paper, an architecture, a short law, or terms on legs.

    Raises:
        TegotaeError: for an unknown name, with the nearest ones.

    Example:
        >>> recipe("ART").name, recipe("ART+hopf").name, recipe("AR@quadruped-c").name
        ('ART-rF-tphif-w8', 'ART-rF-tphif-w8+hopf', 'AR-rF@quadruped-c')
    """
    if (result := find_recipe(name)) is None:
        raise unknown("model", name, [*architectures(), *study_recipes(), *LAWS])
    return result


def find_recipe(name: str) -> Recipe | None:
    """Return the recipe of a name; None for another kind of name.

    Raises:
        TegotaeError: for a name of a recipe that is wrong in a part, such as its frequency.

    Example:
        >>> find_recipe("latch-w4").controller().n_weights, find_recipe("quadruped-c")
        (5, None)
    """
    if is_on_legs(name):
        return _on_legs(name)
    plain, plus, oscillator = name.partition("+")
    law, omega = _stem(plain)
    if law in LAWS and not plus:
        return Recipe(
            terms=LAWS[law], system=_hopper("sector"), omega=_OMEGA_T if omega is None else omega
        )
    result = study_recipe(plain) or _plainest(plain)
    if result is None or not plus:
        return result
    return dataclasses.replace(result, oscillator=oscillator)


def study_recipe(name: str) -> Recipe | None:
    """Return one of the 218 models by its full name, at any frequency; None for another name.

    Raises:
        TegotaeError: for a frequency that is not positive.

    Example:
        >>> study_recipe("V-sector-w5").omega, study_recipe("ART")
        (5.0, None)
    """
    if (model := study_recipes().get(name)) is not None:
        return model
    stem, omega = _stem(name)
    model = study_recipes().get(f"{stem}-w8")
    return None if model is None or omega is None else dataclasses.replace(model, omega=omega)


def _stem(name: str) -> tuple[str, float | None]:
    """Split a name into its stem and its frequency."""
    match = _WITH_OMEGA.fullmatch(name)
    return (match["stem"], float(match["omega"])) if match else (name, None)


def _plainest(name: str) -> Recipe | None:
    """Return the study's model of an architecture, optionally of the senses of its terms."""
    models = study_recipes()
    if name == "T":
        return models["T-F"]
    terms = learned_terms(name)
    if terms is None:
        return None
    return models.get(f"{terms.name}{'' if terms.actuation else '-reflex'}-w{_OMEGA_T:g}")


@cache
def study_recipes() -> dict[str, Recipe]:
    """Return the 218 models of the paper's study by name, in a fixed order."""
    observations = (None, "F", "Fv")
    actuations = [*((name, None) for name in _HOPPERS), *(("sector", x) for x in ACTUATION_INPUTS)]
    recipes = [
        Recipe(
            terms=LearnedTerms(action=a, reaction=r, gain=g, actuation=inputs),
            system=_hopper(actuation),
            omega=omega,
        )
        for a, r, g, (actuation, inputs), omega in itertools.product(
            (False, True), observations, observations, actuations, (4.0, 8.0)
        )
    ]
    networks = [Recipe(terms=LoneNetworks(x), system=_hopper("sector")) for x in ("F", "Fv")]
    return {result.name: result for result in [*recipes, *networks]}


def architectures() -> list[str]:
    """Return the architectures of the paper's study."""
    return list(dict.fromkeys(x.terms.architecture for x in study_recipes().values()))


_WITH_OMEGA = re.compile(r"(?P<stem>.+)-w(?P<omega>[0-9]+(?:[.][0-9]+)?)")
_TERMS_ON_LEGS = re.compile(r"(?P<terms>.+?)(?:-w(?P<omega>[0-9.]+))?")


def is_on_legs(name: str) -> bool:
    """Return whether a name has the form of a recipe's on legs: terms and a system.

    Example:
        >>> is_on_legs("ART@quadruped-c"), is_on_legs("ART-rF-tphif-w8")
        (True, False)
    """
    terms, separator, _ = name.partition("@")
    return bool(separator) and not set(terms) & set("/\\:")


def _on_legs(name: str) -> Recipe:
    """Return the recipe on legs of a name."""
    terms, _, place = name.partition("@")
    parts = _TERMS_ON_LEGS.fullmatch(terms)
    if parts is None:
        raise unknown("controller", terms, LISTED)
    try:
        omega = None if parts["omega"] is None else float(parts["omega"])
    except ValueError:
        raise TegotaeError(f"{name} has no frequency behind -w; write a number, as -w3") from None
    short = place.rpartition(":")[2] or place
    if is_walker_file(place):
        short = Path(place).stem
    legged = legged_named(place)
    return Recipe(
        terms=terms_on_legs(parts["terms"]),
        system=legged.system,
        omega=omega,
        place=short,
        sigma=legged.weights[0] if len(legged.weights) == 1 else 1.0,
        legs=legged.names,
    )


def recipes_on_legs() -> dict[str, Recipe]:
    """Return every listed term set on every named system, by name.

    Example:
        >>> "ARGT-rF-gF-tphif@plate-light-pitch" in recipes_on_legs()
        True
    """
    recipes = (_on_legs(f"{terms}@{place}") for place in SYSTEMS for terms in LISTED)
    return {result.name: result for result in recipes}
