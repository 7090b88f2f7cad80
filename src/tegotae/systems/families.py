"""Families of controllers for several legs: Tegotae feedback, and baselines beside it."""

from __future__ import annotations

import dataclasses
import math
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

from tegotae._support.errors import TegotaeError, unknown
from tegotae.measures.gaits.names import patterns_for
from tegotae.parts.bodies import Body
from tegotae.parts.channels import FOOT
from tegotae.parts.controller import Controller, Tegotae
from tegotae.parts.oscillators import WaryOscillator
from tegotae.parts.terms import (
    BalancedFoot,
    ConstantGain,
    CorrectedFoot,
    EllipticFoot,
    LearnedActuation,
    LearnedFoot,
    OffsetAction,
    PacedFoot,
    SteppingFoot,
    TiltReaction,
    TunedFoot,
    UnitAction,
    VanillaReaction,
    WaryFoot,
    WholeBody,
    WholeBodyCorrectedFoot,
    WholeBodyFoot,
)
from tegotae.parts.terms.actuation import Actuation
from tegotae.systems.grammar import ADDED, LearnedTerms, learned_terms, networks, shared_out
from tegotae.systems.laws import LAWS, LAWS_OF_LEGS
from tegotae.systems.legged import Legged
from tegotae.systems.observations import observation


@dataclass(frozen=True, kw_only=True)
class Family:
    """A way to control a legged system: what is learned, from what (`family_named`).

    What is not learned is as the system has it: its actuation, its oscillator. All legs have the
    same weights.

    Args:
        name: its part of a design's name, such as `ART-rF-tphif`.
        about: its meaning, in a line.
        make: its controller of a system, with as many weights as a budget allows.
        has_rhythm: whether it has oscillators, and so a frequency.
    """

    name: str
    about: str
    make: Callable[[Legged, int], Controller]
    has_rhythm: bool = True


def require_system(legged: Legged) -> Legged:
    """The system itself, with oscillators and Tegotae feedback to learn from.

    Raises:
        TegotaeError: for one without.
    """
    if legged.controller.oscillator is None or legged.controller.tegotae is None:
        raise TegotaeError(
            "a design replaces the terms of a system's Tegotae controller, and this one has none"
        )
    return legged


def senses_of(observed: str, body: Body) -> tuple[str, ...]:
    """Return the inputs of a leg's own network: the senses of the leg and the motion of the body.

    Args:
        observed: name of the observation, such as "F" or "Fa".
        body: the body.

    Raises:
        TegotaeError: for another observation, or one that the body does not sense.

    Example:
        >>> from tegotae.parts.bodies import Plate, Walker
        >>> senses_of("Fr", Walker()), senses_of("Fv", Plate())
        (('spring_force', 'spring_force_rate'), ('spring_force', 'velocity'))
    """
    of_leg, of_body = observation(observed).on(body)
    return (*of_leg, *of_body)


FAMILIES = (
    *("V", "VG-gF", "AR-rF", "ART-rF-tphif", "ARG-rF-gF", "ARGT-rF-gF-tphif", "cos"),
    *LAWS_OF_LEGS,
    *("T-F", "T-Fa", "W-F", "W-Fa", "Wphi-F", "Wphi-Fa"),
)
"""The families that are listed; there are more by other senses."""

_STEPS = {
    "t": (TunedFoot, "the ellipse's four numbers"),
    "b": (BalancedFoot, "an ellipse with balance, eight numbers"),
    "p": (PacedFoot, "an ellipse with balance and a stride of the frequency, nine numbers"),
    "s": (SteppingFoot, "an ellipse with balance and steps aside, ten numbers"),
}
"""Trained parameters of a short law's step, by the end of its name."""
_NETWORK = re.compile(r"(?P<kind>T|W|Wphi|W\+phi)-(?P<observation>[A-Za-z]+)")


def family_named(name: str) -> Family:
    """The family of a name; what its networks sense may be left out.

    - `V`, `VG`, `AR`, `ART` and the others: Tegotae feedback, some of its terms learned. A leg
      senses "F" its load, and with "Fv" the velocity of its hip, "Fr" the rate of the load or
      "Fa" the body's angles. A learned T with a + before its input is added to the system's
      own, an ellipse;
    - `cos`: the law of ORCAgym, `φ̇ = ω - c N (cos φ + o)`, with c and o trained: two numbers;
    - `load`, `latch`, `decay`: short laws of three and four numbers (`tegotae.systems.laws`);
      with `-t`, as in `decay-t`, the four of the system's ellipse are trained, too, with `-b`
      those and four gains of balance, with `-p` one more, by which the stride grows with the
      frequency, and with `-s` two of steps aside, which robots alone can take; so of `clock-t`,
      `clock-b`, `clock-p` and `clock-s`, which have no feedback, and begin in a trot, or for
      other legs in the first pattern of gaits by halves of a cycle;
    - `wary`: `clock-p` with two numbers more, by which a tilt alarms it: it makes shorter and
      higher steps until it is calm again;
    - `T-F` and the like: the paper's single network, one a leg, without oscillators;
    - `W-F` and the like: one network for the whole body, which feels all legs and commands all of
      them. `Wphi` also sees a phase that turns at ω, whatever is felt. `W+phi` is added to the
      system's ellipses, which that clock drives in a trot, or for other legs in the first pattern
      of gaits whose legs step by halves of a cycle.

    Raises:
        TegotaeError: for an unknown one, or a sense of a term that is not learned.

    Example:
        >>> family_named("VG").name, family_named("W-Fa").about
        ('VG-gF', "one network for all legs, on its load and the body's pitch and roll")
    """
    if name == "cos":
        description = "the cosine law φ̇ = ω - c N (cos φ + o)"
        return Family(name=name, about=description, make=_cosine_law)
    if name == "wary":
        description = (
            "a clock with balance, whose steps are shorter and higher after a tilt, 11 numbers"
        )
        return Family(name=name, about=description, make=_wary)
    law, _, step = name.partition("-")
    if law in (*LAWS_OF_LEGS, *(["clock"] if step else [])) and step in ("", *_STEPS):
        feedback = LAWS[law].about.replace("cos φ", "cos(φ - p)")
        description = f"the short law {feedback}" if LAWS[law].action else "a clock"
        description += f", and {_STEPS[step][1]}" if step else ""
        return Family(name=name, about=description, make=partial(_short_law, law=law, step=step))
    if match := _NETWORK.fullmatch(name):
        kind, observed = match["kind"], match["observation"]
        on = f"on {observation(observed).about}"
        if kind == "T":
            description = f"a network a leg without an oscillator, {on}"
            make = partial(_network_per_leg, observed=observed)
            return Family(name=name, about=description, make=make, has_rhythm=False)
        clock, added = "phi" in kind, "+" in kind
        description = "".join(
            [
                f"one network for all legs, {on}",
                " and a clock" * clock,
                ", added to ellipses" * added,
            ]
        )
        make = partial(_network_of_body, observed=observed, clock=clock, added=added)
        return Family(name=name, about=description, make=make, has_rhythm=clock)
    terms = learned_terms(name)
    if terms is None:
        raise unknown("family", name, FAMILIES)
    description = f"Tegotae with {', '.join(terms.learned)} learned, a unit a leg"
    if not terms.learned:
        description = "vanilla Tegotae: its gain σ alone"
    return Family(name=terms.name, about=description, make=partial(_tegotae, terms=terms))


def _tegotae(legged: Legged, budget: int, *, terms: LearnedTerms) -> Controller:
    """The system's controller with networks in place of the learned terms."""
    controller = require_system(legged).controller
    if not terms.learned:
        return controller
    added = terms.actuation is not None and terms.actuation.startswith(ADDED)
    return terms.learned_upon(
        controller,
        terms.name,
        lambda observed: senses_of(observed, legged.body),
        budget,
        sigma=usual_gain(legged),
        actuation=partial(corrected if added else learned_actuation, legged),
    )


def _cosine_law(legged: Legged, budget: int) -> Controller:
    """The system's controller with another action; two weights, whatever the budget."""
    controller = require_system(legged).controller
    shared_out("cos", {}, 2, budget)
    terms = Tegotae(OffsetAction(), VanillaReaction(), ConstantGain(start=usual_gain(legged)))
    return dataclasses.replace(controller, tegotae=terms)


def _wary(legged: Legged, budget: int) -> Controller:
    """The system's controller with an alarm of a tilt, whatever its feedback was.

    Raises:
        TegotaeError: for an ellipse that the system does not have.
    """
    controller = require_system(legged).controller
    wary = dataclasses.replace(
        controller,
        actuation=WaryFoot(ellipse_of(legged)),
        oscillator=WaryOscillator(),
        tegotae=Tegotae(UnitAction(), TiltReaction(), ConstantGain()),
    )
    shared_out("wary", {}, wary.n_weights, budget)
    return wary


def _short_law(legged: Legged, budget: int, *, law: str, step: str) -> Controller:
    """The system's controller with a short law's feedback, and with a trained step if one is named.

    Raises:
        TegotaeError: for an ellipse that the system does not have.
    """
    controller = require_system(legged).controller
    if step:
        controller = dataclasses.replace(controller, actuation=_STEPS[step][0](ellipse_of(legged)))
    law_controller = LAWS[law].on_legs(controller, usual_gain(legged))
    shared_out(law, {}, law_controller.n_weights, budget)
    return law_controller


def _network_per_leg(legged: Legged, budget: int, *, observed: str) -> Controller:
    """The networks alone."""
    inputs = senses_of(observed, legged.body)
    commands = len(legged.controller.actuation.COMMANDS)
    network = networks(f"T-{observed}", {"T": inputs}, budget, commands=commands)["T"]
    return Controller(learned_actuation(legged, inputs, network.hidden), limbs=legged.body.limbs)


def _network_of_body(
    legged: Legged, budget: int, *, observed: str, clock: bool, added: bool
) -> Controller:
    """The network, and the clock: an oscillator without feedback."""
    body, limbs = legged.body, legged.body.limbs
    of_each, of_body = observation(observed).on(body)
    common = (*(["phase"] if clock else []), *of_body)
    kind: type[WholeBody] = WholeBody
    options: dict[str, Any] = {}
    if legged.controller.actuation.COMMANDS == FOOT:
        kind, options = WholeBodyFoot, {"reach_m": reach_m(legged)}
    if added:
        kind = WholeBodyCorrectedFoot
        options |= {"around": ellipse_of(legged), "lead_rad": alternating_rad(legged.names)}
    cost = kind(of_each, common, limbs, 1, **options).n_weights
    name = f"W{'+' * added}{'phi' * clock}-{observed}"
    hidden = shared_out(name, {"W": cost}, 0, budget)["W"]
    network = kind(of_each, common, limbs, hidden, **options)
    if not clock:
        return Controller(network, limbs=limbs)
    return Controller(network, require_system(legged).controller.oscillator, limbs=limbs)


def usual_gain(legged: Legged) -> float:
    """The σ of the system as it is, from which training starts; 1 if it has other weights."""
    return legged.weights[0] if len(legged.weights) == 1 else 1.0


def learned_actuation(legged: Legged, inputs: tuple[str, ...], hidden: int) -> Actuation:
    """A learned T for the legs of a system: a place of the foot, or a force.

    Args:
        legged: the system.
        inputs: signals that the network reads.
        hidden: neurons of each network.
    """
    if legged.controller.actuation.COMMANDS == FOOT:
        return LearnedFoot(inputs, hidden, reach_m=reach_m(legged))
    return LearnedActuation(inputs, hidden)


def corrected(legged: Legged, inputs: tuple[str, ...], hidden: int) -> Actuation:
    """A learned T that is added to the ellipse of a system.

    Args:
        legged: the system.
        inputs: signals that the networks read.
        hidden: neurons of each network.

    Raises:
        TegotaeError: for a system without one.
    """
    return CorrectedFoot(inputs, hidden, reach_m=reach_m(legged), around=ellipse_of(legged))


def ellipse_of(legged: Legged) -> EllipticFoot:
    """The ellipse of a system, to which what is learned is added, or which is trained itself.

    Raises:
        TegotaeError: for a system without one.
    """
    foot = legged.controller.actuation
    if not isinstance(foot, EllipticFoot):
        raise TegotaeError(
            f"the actuation of this system is a {type(foot).__name__} and no ellipse; "
            "learn T without the +, or take a short law without -t"
        )
    return foot


def reach_m(legged: Legged) -> float:
    """Return the scale of the outputs of a learned foot [m]: half the height of the ellipse.

    So the noise of training moves a foot by less than a step lifts it.
    """
    foot = legged.controller.actuation
    if isinstance(foot, EllipticFoot):
        return 0.5 * (foot.lift_m + foot.press_m)
    return 0.075 * legged.body.rest_length_m


def nominal_speed_m_per_s(legged: Legged, omega: float) -> float | None:
    """Speed of a body whose feet cross their stride in half a turn, 2 B ω / π [m/s].

    None where the feet do not go round ellipses.

    Args:
        legged: the system.
        omega: ω [rad/s].

    Example:
        >>> from tegotae.systems.resolve import legged_system as system
        >>> round(nominal_speed_m_per_s(system("quadruped-c"), 2.0), 3)
        0.255
    """
    foot = legged.controller.actuation
    return 2.0 * foot.stride_m * omega / math.pi if isinstance(foot, EllipticFoot) else None


ALTERNATING = ("trot", "tripod", "antiphase")
"""Gaits in which one half of the legs steps half a cycle after the other."""


def alternating_rad(legs: Sequence[str]) -> tuple[float, ...]:
    """Return the lead of each leg over the first in a gait by halves of a cycle [rad]: a trot of
    four.

    Args:
        legs: their names.

    Raises:
        TegotaeError: for legs that no such gait is known of.

    Example:
        >>> [round(lead, 2) for lead in alternating_rad(("LF", "RF", "LH", "RH"))]
        [0.0, 3.14, 3.14, 0.0]
    """
    patterns = {pattern.name: pattern for pattern in patterns_for(legs)}
    for name in ALTERNATING:
        if name in patterns:
            lags = patterns[name].lags
            return tuple(2.0 * math.pi * ((lags[legs[0]] - lags[leg]) % 1.0) for leg in legs)
    raise TegotaeError(
        f"no gait by halves of a cycle is known of the legs {', '.join(legs)}; leave the + out"
    )
