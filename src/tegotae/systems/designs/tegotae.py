"""The paper's architectures, a unit a leg: any of A, R, G and T learned."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass

from tegotae._support.errors import TegotaeError
from tegotae.parts.commands import FOOT
from tegotae.parts.controller import Controller
from tegotae.parts.terms import (
    ConstantGain,
    CorrectedFoot,
    EllipticFoot,
    LearnedActuation,
    LearnedFoot,
)
from tegotae.parts.terms.actuation import Actuation
from tegotae.systems.designs.base import Family, require_system
from tegotae.systems.designs.senses import all_of
from tegotae.systems.grammar import ADDED, LearnedTerms, networks, with_networks
from tegotae.systems.legged import Legged


@dataclass(frozen=True, kw_only=True)
class TegotaeFamily(LearnedTerms, Family):
    """Tegotae feedback, some of its terms learned: V, VG, AR, ART, ARG, ARGT and the others.

    A leg senses "F" its load, "Fv" its rate, too, or "Fa" the body's angles, too. A learned T with
    a + before its input is added to the system's own, an ellipse.

    Example:
        >>> TegotaeFamily(action=True, reaction="F", actuation="phif").name
        'ART-rF-tphif'
    """

    @property
    def about(self) -> str:
        """Which terms are learned."""
        if self.architecture == "V":
            return "vanilla Tegotae: its gain σ alone"
        return f"Tegotae with {', '.join(self.learned)} learned, a unit a leg"

    def controller(self, legged: Legged, budget: int) -> Controller:
        """The system's controller with networks in place of the learned terms."""
        own = require_system(legged).controller
        if self.architecture == "V":
            return own
        assert own.tegotae is not None  # require_system
        learned = networks(
            self.name,
            self.inputs(lambda observation: all_of(observation, legged.body)),
            budget,
            commands=len(own.actuation.COMMANDS),
            others=int(self.gain is None),
        )
        vanilla = dataclasses.replace(own.tegotae, gain=ConstantGain(start=usual_gain(legged)))
        foot = own.actuation
        if self.actuation is not None:
            learn = corrected if self.actuation.startswith(ADDED) else learned_actuation
            foot = learn(legged, learned["T"].inputs, learned["T"].hidden)
        return dataclasses.replace(own, actuation=foot, tegotae=with_networks(vanilla, learned))


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
    """The ellipse of a system, to which what is learned is added.

    Raises:
        TegotaeError: for a system without one.
    """
    foot = legged.controller.actuation
    if not isinstance(foot, EllipticFoot):
        raise TegotaeError(
            f"the actuation of this system is a {type(foot).__name__}, to which nothing can be "
            "added; learn T without the +"
        )
    return foot


def reach_m(legged: Legged) -> float:
    """By what the outputs of a learned foot are multiplied [m]: half the height of the ellipse.

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
        >>> from tegotae.analysis.gaits import system
        >>> round(nominal_speed_m_per_s(system("quadruped-c"), 2.0), 3)
        0.255
    """
    foot = legged.controller.actuation
    return 2.0 * foot.stride_m * omega / math.pi if isinstance(foot, EllipticFoot) else None
