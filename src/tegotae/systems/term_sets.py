"""Term sets: what a recipe puts in place of the terms of a vanilla controller, by name.

- Learned terms, `ARCHITECTURE[-rOBS][-gOBS][-tIN]`, as in `ART-rF-tphif`: ARCHITECTURE is the
  paper's, V where neither A nor R is learned, then G and T where they are. OBS is what a learned R
  or G senses (`tegotae.systems.observations`), and IN what a learned T depends on: `phi`, `f` or
  `phif`. Left out, they are `F` and `phif`. With a + before IN, what is learned is added to the
  system's actuation.
- Short laws, of two to five numbers, beside which every learned controller is to be judged. With N
  the load in weights of the body: `clock`, φ̇ = ω; `load`, φ̇ = ω - σ N cos φ; `offset`,
  φ̇ = ω - σ N (cos φ + o); `latch`, φ̇ = ω - σ (1 - k N) (cos φ + o), whose phase can park in flight
  and wait; `decay`, φ̇ = ω - σ e^(-k N) (cos φ + o); and `tuned`, vanilla feedback with a scaled
  reflex. A hopper pushes over a trained sector. Several legs keep their feet, and the action of
  load, latch and decay has a place, cos(φ - p) + o; `STEPS` train the feet, too, as in `decay-t`.
- Networks alone: `T-OBS`, one a leg; `W-OBS`, one for the whole body, `Wphi-OBS` with a clock,
  `W+phi-OBS` added to ellipses that the clock drives.
"""

from __future__ import annotations

import dataclasses
import itertools
import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar

from tegotae._support.errors import TegotaeError, unknown
from tegotae.measures.gaits.names import patterns_for
from tegotae.parts.bodies import Body
from tegotae.parts.channels import FOOT
from tegotae.parts.controller import Controller, Tegotae
from tegotae.parts.oscillators import FootholdOscillator, Oscillator, WaryOscillator
from tegotae.parts.terms import (
    BalancedFoot,
    ConstantGain,
    CorrectedFoot,
    DecayingReaction,
    FreeSector,
    FreeSectorAndReflex,
    LearnedActuation,
    LearnedFoot,
    Network,
    OffsetAction,
    PacedFoot,
    PlacedFoot,
    ReversingReaction,
    ShiftedAction,
    SpeedReaction,
    SteppingFoot,
    Term,
    TiltReaction,
    TunedFoot,
    UnitAction,
    VanillaAction,
    VanillaReaction,
    WaryFoot,
    WholeBody,
    WholeBodyCorrectedFoot,
    WholeBodyFoot,
)
from tegotae.parts.terms.actuation import Actuation
from tegotae.parts.terms.foot import EllipticFoot
from tegotae.systems.observations import observation
from tegotae.systems.system import System

BUDGET = 96
"""Trained numbers per controller in the paper."""

ACTUATION_INPUTS = {"phi": ("phase",), "f": ("feedback",), "phif": ("phase", "feedback")}
"""Inputs of a learned actuation, by its short name."""
ADDED = "+"
"""Before that name: what is learned is added to the system's own actuation."""


@dataclass(frozen=True, kw_only=True)
class LearnedTerms:
    """Learned terms of `f = G · A′(φ) · R(s)` and of the actuation T, and their inputs.

    Args:
        action: True if A is learned.
        reaction: what a learned R senses, such as "F" or "Fv"; None for the vanilla R.
        gain: what a learned G senses besides φ; None for a constant gain.
        actuation: what a learned T depends on, "phi", "f" or "phif"; None for the system's.
            With a + before it, what is learned is added to the system's.

    Raises:
        TegotaeError: for an unknown input of T.

    Example:
        >>> LearnedTerms(action=True, reaction="F", actuation="phif").name
        'ART-rF-tphif'
    """

    has_rhythm: ClassVar[bool] = True

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
        """The architecture, and the senses of its terms."""
        inputs = {"r": self.reaction, "g": self.gain, "t": self.actuation}
        return "-".join([self.architecture, *(f"{k}{x}" for k, x in inputs.items() if x)])

    @property
    def about(self) -> str:
        """Meaning in a line."""
        if not self.learned:
            return "vanilla Tegotae: its gain σ alone"
        return f"Tegotae with {', '.join(self.learned)} learned, a unit a leg"

    @property
    def learned(self) -> tuple[str, ...]:
        """Names of the terms among A, R, G, T that are networks."""
        return tuple(self.architecture.removeprefix("V"))

    @property
    def observation(self) -> str:
        """Observation of all terms together."""
        return max((self.reaction or "F", self.gain or "F"), key=len)

    def inputs(self, body: Body) -> dict[str, tuple[str, ...]]:
        """Return the signals that each network reads, by its term.

        Args:
            body: the body, whose senses they are.

        Example:
            >>> from tegotae.parts.bodies import Hopper
            >>> LearnedTerms(reaction="F", gain="F").inputs(Hopper())
            {'R': ('spring_force',), 'G': ('phase', 'spring_force')}
        """
        inputs: dict[str, tuple[str, ...]] = {}
        if self.action:
            inputs["A"] = ("phase",)
        if self.reaction is not None:
            inputs["R"] = observed(self.reaction, body)
        if self.gain is not None:
            inputs["G"] = ("phase", *observed(self.gain, body))
        if self.actuation is not None:
            inputs["T"] = ACTUATION_INPUTS[self._actuation_inputs]
        return inputs

    def controller(
        self, system: System, budget: int, *, sigma: float = 1.0, legs: Sequence[str] = ()
    ) -> Controller:
        """Return the system's controller with networks in place of the learned terms."""
        controller, oscillator = system.controller, _oscillator_of(system)
        terms = controller.tegotae
        if terms is None:
            raise _no_terms()
        learned = networks(
            self.name,
            self.inputs(system.mechanics),
            budget,
            commands=len(controller.actuation.COMMANDS),
            other_weights=(self.gain is None) + oscillator.n_weights,
        )
        if not learned:
            return controller
        actuation = controller.actuation
        if self.actuation is not None:
            network, added = learned["T"], self.actuation.startswith(ADDED)
            actuation = _learned_actuation(system, network.inputs, network.hidden, added=added)
        terms = dataclasses.replace(
            terms,
            action=learned.get("A", terms.action),
            reaction=learned.get("R", terms.reaction),
            gain=learned.get("G", ConstantGain(start=sigma)),
        )
        return dataclasses.replace(controller, actuation=actuation, tegotae=terms)


@dataclass(frozen=True, kw_only=True)
class ShortLaw:
    """Feedback law of few numbers, independent of the budget.

    Args:
        name: part of a recipe's name, such as `latch` or `decay-t`.
        about: meaning in a line.
        action: A′; None without feedback.
        reaction: R.
        gain: G; None for a gain σ that starts at the system's.
        actuation: actuation in place of the system's.
        step: kind of a trained foot in place of the system's, which starts from its ellipse.
        oscillator: oscillator in place of the system's.
    """

    has_rhythm: ClassVar[bool] = True
    learned: ClassVar[tuple[str, ...]] = ()

    name: str
    about: str = ""
    action: Term | None = None
    reaction: Term = field(default_factory=VanillaReaction)
    gain: Term | None = None
    actuation: Actuation | None = None
    step: type[TunedFoot] | type[WaryFoot] | None = None
    oscillator: Oscillator | None = None

    @property
    def architecture(self) -> str:
        """The law's name."""
        return self.name

    @property
    def observation(self) -> str:
        """Observation of the feedback."""
        return "" if self.action is None else "F"

    def controller(
        self,
        system: System,
        budget: int = BUDGET,
        *,
        sigma: float = 1.0,
        legs: Sequence[str] = (),
    ) -> Controller:
        """Return the system's controller with this feedback."""
        controller, terms = system.controller, None
        if self.action is not None:
            terms = Tegotae(self.action, self.reaction, self.gain or ConstantGain(start=sigma))
        actuation = self.actuation or controller.actuation
        if self.step is not None:
            actuation = self.step(ellipse_of(system))
        short = dataclasses.replace(
            controller,
            actuation=actuation,
            oscillator=self.oscillator or _oscillator_of(system),
            tegotae=terms,
        )
        hidden_sizes(self.name, {}, budget, short.n_weights)
        return short


@dataclass(frozen=True)
class LoneNetworks:
    """Networks without Tegotae feedback: the paper's single network, one a leg, or one for all.

    Args:
        observation: what they sense of each leg, and of the body.
        whole_body: True for one network that feels all legs and commands all of them.
        clock: True if that sees a phase which turns at ω, whatever is felt.
        added: True if that is added to the system's ellipses, which the clock drives in a trot, or
            for other legs in the first pattern of gaits by halves of a cycle.
    """

    learned: ClassVar[tuple[str, ...]] = ("T",)

    observation: str
    whole_body: bool = False
    clock: bool = False
    added: bool = False

    @property
    def architecture(self) -> str:
        """T, or W for the whole body, with the clock and with the ellipses."""
        return f"W{ADDED * self.added}{'phi' * self.clock}" if self.whole_body else "T"

    @property
    def name(self) -> str:
        """The architecture, and its senses."""
        return f"{self.architecture}-{self.observation}"

    @property
    def about(self) -> str:
        """Meaning in a line."""
        senses = f"on {observation(self.observation).about}"
        if not self.whole_body:
            return f"a network a leg without an oscillator, {senses}"
        clock, added = " and a clock" * self.clock, ", added to ellipses" * self.added
        return f"one network for all legs, {senses}{clock}{added}"

    @property
    def has_rhythm(self) -> bool:
        """True with a clock."""
        return self.clock

    def controller(
        self, system: System, budget: int, *, sigma: float = 1.0, legs: Sequence[str] = ()
    ) -> Controller:
        """Return the networks, with a clock an oscillator without feedback."""
        body, commands = system.mechanics, system.controller.actuation.COMMANDS
        of_each, of_body = observation(self.observation).on(body)
        if not self.whole_body:
            inputs = (*of_each, *of_body)
            network = networks(self.name, {"T": inputs}, budget, commands=len(commands))["T"]
            actuation = _learned_actuation(system, inputs, network.hidden)
            return Controller(actuation, limbs=body.limbs)
        common = (*(["phase"] if self.clock else []), *of_body)
        kind: type[WholeBody] = WholeBody
        options: dict[str, Any] = {}
        if commands == FOOT:
            kind, options = WholeBodyFoot, {"reach_m": _reach_m(system)}
        if self.added:
            kind = WholeBodyCorrectedFoot
            options |= {"around": ellipse_of(system), "lead_rad": alternating_rad(legs)}
        cost = kind(of_each, common, body.limbs, 1, **options).n_weights
        hidden = hidden_sizes(self.name, {"W": cost}, budget)["W"]
        actuation = kind(of_each, common, body.limbs, hidden, **options)
        oscillator = _oscillator_of(system) if self.clock else None
        return Controller(actuation, oscillator, limbs=body.limbs)


TermSet = LearnedTerms | ShortLaw | LoneNetworks
"""Terms that a recipe puts in place of those of a vanilla controller. Each has a `name`, a line
`about` it, an `architecture`, its `learned` terms and `observation`, and makes a `controller`."""


def observed(name: str, body: Body) -> tuple[str, ...]:
    """Return the inputs of a leg's own network: the senses of the leg and the motion of the body.

    Args:
        name: name of the observation, such as "F" or "Fa".
        body: the body.

    Raises:
        TegotaeError: for another observation, or one that the body does not sense.

    Example:
        >>> from tegotae.parts.bodies import Plate, Walker
        >>> observed("Fr", Walker()), observed("Fv", Plate())
        (('spring_force', 'spring_force_rate'), ('spring_force', 'velocity'))
    """
    of_leg, of_body = observation(name).on(body)
    return (*of_leg, *of_body)


def _oscillator_of(system: System) -> Oscillator:
    oscillator = system.controller.oscillator
    if oscillator is None:
        raise _no_terms()
    return oscillator


def _no_terms() -> TegotaeError:
    return TegotaeError(
        "a recipe replaces the terms of a system's Tegotae controller, and this one has none"
    )


def _learned_actuation(
    system: System, inputs: tuple[str, ...], hidden: int, *, added: bool = False
) -> Actuation:
    """Return a learned T: a force, a place of the foot, or a correction of the ellipse of a
    foot.
    """
    if added:
        return CorrectedFoot(inputs, hidden, reach_m=_reach_m(system), around=ellipse_of(system))
    if system.controller.actuation.COMMANDS == FOOT:
        return LearnedFoot(inputs, hidden, reach_m=_reach_m(system))
    return LearnedActuation(inputs, hidden)


def ellipse_of(system: System) -> EllipticFoot:
    """Return the ellipse of a system's feet.

    Raises:
        TegotaeError: for a system without one.
    """
    foot = system.controller.actuation
    if not isinstance(foot, EllipticFoot):
        raise TegotaeError(
            f"the actuation of this system is a {type(foot).__name__} and no ellipse; "
            "learn T without the +, or take a short law without -t"
        )
    return foot


def _reach_m(system: System) -> float:
    """Return the scale of a learned foot's outputs [m]: half the height of the ellipse.

    So the noise of training moves a foot by less than a step lifts it.
    """
    foot = system.controller.actuation
    if isinstance(foot, EllipticFoot):
        return 0.5 * (foot.lift_m + foot.press_m)
    return 0.075 * system.mechanics.rest_length_m


def nominal_speed_m_per_s(system: System, omega: float) -> float | None:
    """Return the speed at which a foot crosses its stride in half a turn, 2 B ω / π [m/s].

    None where the feet do not go round ellipses.

    Args:
        system: the system.
        omega: ω [rad/s].

    Example:
        >>> from tegotae.systems.vanilla import legged_named
        >>> round(nominal_speed_m_per_s(legged_named("quadruped-c").system, 2.0), 3)
        0.255
    """
    foot = system.controller.actuation
    return 2.0 * foot.stride_m * omega / math.pi if isinstance(foot, EllipticFoot) else None


_ALTERNATING = ("trot", "tripod", "antiphase")
"""Gaits in which one half of the legs steps half a cycle after the other."""


def alternating_rad(legs: Sequence[str]) -> tuple[float, ...]:
    """Return the lead of each leg over the first in a gait by halves of a cycle [rad].

    Args:
        legs: their names.

    Raises:
        TegotaeError: for legs that no such gait is known of.

    Example:
        >>> [round(lead, 2) for lead in alternating_rad(("LF", "RF", "LH", "RH"))]
        [0.0, 3.14, 3.14, 0.0]
    """
    patterns = {pattern.name: pattern for pattern in patterns_for(legs)}
    for name in _ALTERNATING:
        if name in patterns:
            lags = patterns[name].lags
            return tuple(2.0 * math.pi * ((lags[legs[0]] - lags[leg]) % 1.0) for leg in legs)
    raise TegotaeError(
        f"no gait by halves of a cycle is known of the legs {', '.join(legs)}; leave the + out"
    )


_PUSH = FreeSector()
LAWS = {
    law.name: law
    for law in (
        ShortLaw(name="clock", actuation=_PUSH),
        ShortLaw(name="load", action=VanillaAction(), actuation=_PUSH),
        ShortLaw(name="offset", action=OffsetAction(), actuation=_PUSH),
        ShortLaw(
            name="latch", action=OffsetAction(), reaction=ReversingReaction(), actuation=_PUSH
        ),
        ShortLaw(name="decay", action=OffsetAction(), reaction=DecayingReaction(), actuation=_PUSH),
        ShortLaw(name="tuned", action=VanillaAction(), actuation=FreeSectorAndReflex()),
    )
}
"""Short laws of one leg by name."""
STEPS: dict[str, tuple[type[TunedFoot], str]] = {
    "t": (TunedFoot, "the ellipse's four numbers"),
    "b": (BalancedFoot, "an ellipse with balance, eight numbers"),
    "p": (PacedFoot, "an ellipse with balance and a stride of the frequency, nine numbers"),
    "s": (SteppingFoot, "an ellipse with balance and steps aside, ten numbers"),
}
"""Trained feet of a short law on several legs, by the end of its name; robots alone take steps
aside."""
_FEEDBACK = {
    "load": "-σ N cos(φ - p)",
    "latch": "-σ (1 - k N) (cos(φ - p) + o)",
    "decay": "-σ e^(-k N) (cos(φ - p) + o)",
}
LAWS_OF_LEGS = tuple(_FEEDBACK)
"""Short laws on several legs that keep the feet of the system; there are `clock` with a step, the
cosine law `cos` and `wary`, too."""
_COSINE = ShortLaw(
    name="cos",
    about="the cosine law φ̇ = ω - c N (cos φ + o)",
    action=OffsetAction(),
)
_WARY = ShortLaw(
    name="wary",
    about="a clock with balance, whose steps are shorter and higher after a tilt, 11 numbers",
    action=UnitAction(),
    reaction=TiltReaction(),
    gain=ConstantGain(),
    step=WaryFoot,
    oscillator=WaryOscillator(),
)

_RAIBERT = ShortLaw(
    name="raibert",
    about="a clock with Raibert's foot placement and levelling, for commands, 13 numbers",
    action=UnitAction(),
    reaction=SpeedReaction(),
    gain=ConstantGain(),
    actuation=PlacedFoot(),
    oscillator=FootholdOscillator(),
)
_NAMED = {law.name: law for law in (_COSINE, _WARY, _RAIBERT)}


def _law_of_legs(name: str) -> ShortLaw | None:
    """Return the short law of several legs of a name, or None for another kind of name."""
    if name in _NAMED:
        return _NAMED[name]
    law, _, step = name.partition("-")
    if law not in (*_FEEDBACK, *(["clock"] if step else [])) or step not in ("", *STEPS):
        return None
    foot, about_foot = STEPS[step] if step else (None, "")
    return ShortLaw(
        name=name,
        about=(f"the short law {_FEEDBACK[law]}" if law in _FEEDBACK else "a clock")
        + (f", and {about_foot}" if step else ""),
        action=ShiftedAction() if law in _FEEDBACK else None,
        reaction=LAWS[law].reaction,
        step=foot,
    )


LISTED = (
    *("V", "VG-gF", "AR-rF", "ART-rF-tphif", "ARG-rF-gF", "ARGT-rF-gF-tphif", "cos"),
    *LAWS_OF_LEGS,
    *("T-F", "T-Fa", "W-F", "W-Fa", "Wphi-F", "Wphi-Fa"),
)
"""Term sets on legs that are listed; there are more by other senses and steps."""
_USUAL = {"r": "F", "g": "F", "t": "phif"}
"""The default inputs, for names without any."""
_LEARNED = re.compile(
    r"(?P<feedback>V|A|R|AR)(?P<G>G?)(?P<T>T?)"
    r"(?:-r(?P<r>[A-Za-z]+))?(?:-g(?P<g>[A-Za-z]+))?(?:-t(?P<t>\+?[a-z]+))?"
)
_NETWORK = re.compile(r"(?P<kind>T|W|Wphi|W\+phi)-(?P<observation>[A-Za-z]+)")


def terms_on_legs(name: str) -> TermSet:
    """Return the term set of a name on several legs; the inputs of its networks may be left out.

    Args:
        name: see this module; `cos` is the law of ORCAgym with two trained numbers. A clock begins
            in a trot, or for other legs in the first pattern of gaits by halves of a cycle. `wary`
            is `clock-p` with two numbers more, by which a tilt alarms it: it makes shorter and
            higher steps until it is calm again. `raibert` follows commands of a robot.

    Raises:
        TegotaeError: for an unknown one, or a sense of a term that is not learned.

    Example:
        >>> terms_on_legs("VG").name, terms_on_legs("W-Fa").about
        ('VG-gF', "one network for all legs, on its load and the body's pitch and roll")
    """
    if (law := _law_of_legs(name)) is not None:
        return law
    if match := _NETWORK.fullmatch(name):
        kind, senses = match["kind"], observation(match["observation"]).name
        return LoneNetworks(senses, kind != "T", "phi" in kind, ADDED in kind)
    if (terms := learned_terms(name)) is not None:
        return terms
    raise unknown("controller", name, LISTED)


def learned_terms(name: str) -> LearnedTerms | None:
    """Return the learned terms of a name, or None for a name of something else.

    Args:
        name: such as `ART-rF-tphif`; what its terms sense may be left out.

    Raises:
        TegotaeError: for a sense of a term that is not learned, or an unknown input of T.

    Example:
        >>> learned_terms("ARG-rFv").name
        'ARG-rFv-gF'
    """
    match = _LEARNED.fullmatch(name)
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
    """Return a network for each term, as large as the budget allows.

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
    sizes = hidden_sizes(name, costs, budget, other_weights)
    return {term: Network(inputs[term], size) for term, size in sizes.items()}


def hidden_sizes(
    name: str, costs: Mapping[str, int], budget: int, other_weights: int = 0
) -> dict[str, int]:
    """Return hidden neurons per network: the most weights within the budget, as evenly as possible.

    Starting from equal numbers, neurons are added so that the total is the largest possible not
    above the budget; of equal totals the most even split is taken, then the first in the order of
    the networks.

    Args:
        name: whose networks they are, for an error.
        costs: weights of a hidden neuron, by network.
        budget: largest number of weights in all.
        other_weights: trained numbers beside the networks.

    Raises:
        TegotaeError: for a budget that does not give every network a neuron.

    Example:
        >>> hidden_sizes("ART", {"A": 4, "R": 3, "T": 10}, 96, other_weights=1)
        {'A': 5, 'R': 5, 'T': 6}
    """
    minimum = sum(costs.values()) + other_weights
    if budget < minimum:
        raise TegotaeError(f"budget is {budget}, too small: {name} has at least {minimum} weights")
    if not costs:
        return {}
    available = budget - other_weights
    equal = available // sum(costs.values())
    best: tuple[int, int, list[int]] | None = None
    for extra in itertools.product(range(-2, 4), repeat=len(costs)):
        sizes = [equal + e for e in extra]
        total = sum(h * cost for h, cost in zip(sizes, costs.values(), strict=True))
        if min(sizes) < 1 or total > available:
            continue
        rank = (total, min(sizes) - max(sizes))
        if best is None or rank > best[:2]:
            best = (*rank, sizes)
    assert best is not None  # extra = 0 is within the budget
    return dict(zip(costs, best[2], strict=True))
