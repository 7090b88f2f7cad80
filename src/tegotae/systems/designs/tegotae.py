"""The paper's architectures, a unit a leg: any of A, R, G and T learned."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass

from tegotae._support.errors import TegotaeError, unknown
from tegotae.parts.commands import FOOT
from tegotae.parts.controller import Controller, Tegotae
from tegotae.parts.terms import (
    ConstantGain,
    CorrectedFoot,
    EllipticFoot,
    LearnedActuation,
    LearnedFoot,
    Network,
)
from tegotae.parts.terms.actuation import Actuation
from tegotae.systems.designs.base import Family, require_system, shared_out
from tegotae.systems.designs.senses import all_of
from tegotae.systems.legged import Legged

ACTUATION_INPUTS = {"phi": ("phase",), "f": ("feedback",), "phif": ("phase", "feedback")}
"""What a learned actuation may depend on, by its short name."""
ADDED = "+"
"""Before that name: what is learned is added to the system's own actuation."""


@dataclass(frozen=True, kw_only=True)
class TegotaeFamily(Family):
    """Tegotae feedback, some of its terms learned: V, VG, AR, ART, ARG, ARGT and the others.

    Args:
        action: whether A is learned.
        reaction: what a learned R senses, "F", "Fv" or "Fa"; None for the vanilla R.
        gain: what a learned G senses besides φ; None for a constant gain.
        actuation: what a learned T depends on, "phi", "f" or "phif"; None for the system's own.
            With a + before it, what is learned is added to the system's own, an ellipse.

    Raises:
        TegotaeError: for an unknown input of T.

    Example:
        >>> TegotaeFamily(action=True, reaction="F", actuation="phif").name
        'ART-rF-tphif'
    """

    action: bool = False
    reaction: str | None = None
    gain: str | None = None
    actuation: str | None = None

    def __post_init__(self) -> None:
        if self.actuation is not None and self._foot_inputs not in ACTUATION_INPUTS:
            raise unknown("input of a learned actuation", self.actuation, ACTUATION_INPUTS)

    @property
    def _foot_inputs(self) -> str:
        return (self.actuation or "").removeprefix(ADDED)

    @property
    def architecture(self) -> str:
        """The paper's name: V, VG, VT, VGT, AR, ..., ARGT."""
        feedback = "A" * self.action + "R" * (self.reaction is not None)
        learned_gain, learned_foot = self.gain is not None, self.actuation is not None
        return (feedback or "V") + "G" * learned_gain + "T" * learned_foot

    @property
    def name(self) -> str:
        """The architecture, and what its terms sense."""
        given = {"r": self.reaction, "g": self.gain, "t": self.actuation}
        return "-".join([self.architecture, *(f"{k}{x}" for k, x in given.items() if x)])

    @property
    def about(self) -> str:
        """Which terms are learned."""
        if self.architecture == "V":
            return "vanilla Tegotae: its gain σ alone"
        learned = self.architecture.replace("V", "")
        return f"Tegotae with {', '.join(learned)} learned, a unit a leg"

    def controller(self, legged: Legged, budget: int) -> Controller:
        """The system's controller with networks in place of the learned terms."""
        own = require_system(legged).controller
        if self.architecture == "V":
            return own
        inputs = self._inputs(legged)
        cost = {role: len(Network(names, 1).reads) + 2 for role, names in inputs.items()}
        if "T" in cost:
            cost["T"] *= len(own.actuation.COMMANDS)
        constant = self.gain is None
        hidden = shared_out(self.name, cost, int(constant), budget)
        networks = {role: Network(inputs[role], size) for role, size in hidden.items()}
        assert own.tegotae is not None  # require_system
        terms = Tegotae(
            networks.get("A", own.tegotae.action),
            networks.get("R", own.tegotae.reaction),
            networks.get("G", ConstantGain(start=usual_gain(legged))),
            own.tegotae.limit_rad_per_s,
        )
        foot = own.actuation
        if self.actuation is not None:
            learn = corrected if self.actuation.startswith(ADDED) else learned_actuation
            foot = learn(legged, inputs["T"], hidden["T"])
        return dataclasses.replace(own, actuation=foot, tegotae=terms)

    def _inputs(self, legged: Legged) -> dict[str, tuple[str, ...]]:
        inputs: dict[str, tuple[str, ...]] = {}
        if self.action:
            inputs["A"] = ("phase",)
        if self.reaction is not None:
            inputs["R"] = all_of(self.reaction, legged.body)
        if self.gain is not None:
            inputs["G"] = ("phase", *all_of(self.gain, legged.body))
        if self.actuation is not None:
            inputs["T"] = ACTUATION_INPUTS[self._foot_inputs]
        return inputs


def usual_gain(legged: Legged) -> float:
    """The σ of the system as it is, from which training starts; 1 if it has other weights."""
    return legged.weights[0] if len(legged.weights) == 1 else 1.0


def learned_actuation(legged: Legged, inputs: tuple[str, ...], hidden: int) -> Actuation:
    """A learned T for the legs of a system: a place of the foot, or a force."""
    if legged.controller.actuation.COMMANDS == FOOT:
        return LearnedFoot(inputs, hidden, reach_m=reach_m(legged))
    return LearnedActuation(inputs, hidden)


def corrected(legged: Legged, inputs: tuple[str, ...], hidden: int) -> Actuation:
    """A learned T that is added to the ellipse of a system.

    Raises:
        TegotaeError: for a system without one.
    """
    foot = legged.controller.actuation
    if not isinstance(foot, EllipticFoot):
        raise TegotaeError(
            f"the actuation of this system is a {type(foot).__name__}, to which nothing can be "
            "added; learn T without the +"
        )
    return CorrectedFoot(inputs, hidden, reach_m=reach_m(legged), around=foot)


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

    Example:
        >>> from tegotae.studies.gaits import system
        >>> round(nominal_speed_m_per_s(system("quadruped-c"), 2.0), 3)
        0.255
    """
    foot = legged.controller.actuation
    return 2.0 * foot.stride_m * omega / math.pi if isinstance(foot, EllipticFoot) else None
