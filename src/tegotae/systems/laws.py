"""Short laws: controllers of two to five numbers, beside which every learned one is to be judged.

With N the load in weights of the body, and a push of full force over a trained sector of the phase:

- `clock`: φ̇ = ω, two numbers;
- `load`: φ̇ = ω - σ N cos φ, three;
- `offset`: φ̇ = ω - σ N (cos φ + o), four;
- `latch`: φ̇ = ω - σ (1 - k N) (cos φ + o), five: in flight the phase can park, and wait;
- `decay`: φ̇ = ω - σ e^(-k N) (cos φ + o), five;
- `tuned`: vanilla feedback, its sector's two numbers, and the scale of its reflex, four.

A name is the law's, and the frequency of its training, `latch-w4`; `latch` alone is at 8 rad/s. On
several legs (`latch@quadruped-c`) load, latch and decay move the system's own feet: the action then
has a place, cos(φ - p) + o, and there is no sector.
"""

from __future__ import annotations

import dataclasses
import re
from dataclasses import dataclass, field

from tegotae._support.errors import TegotaeError, require_finite
from tegotae._support.limits import MOST_RAD_PER_S
from tegotae.measures.objectives.fitness import EPISODE
from tegotae.parts.controller import Controller, Tegotae
from tegotae.parts.oscillators import PhaseOscillator
from tegotae.parts.terms import (
    ConstantGain,
    DecayingReaction,
    FreeSector,
    FreeSectorAndReflex,
    OffsetAction,
    ReversingReaction,
    ShiftedAction,
    Term,
    VanillaAction,
    VanillaReaction,
)
from tegotae.systems.experiment import Experiment
from tegotae.systems.grammar import BUDGET
from tegotae.systems.system import System


@dataclass(frozen=True)
class LawForm:
    """Form of a short law.

    Args:
        about: its feedback, in a line.
        action: A′ on one leg; None without feedback.
        reaction: R.
        reflex: whether falling Tegotae pushes, too.
    """

    about: str
    action: Term | None = None
    reaction: Term = field(default_factory=VanillaReaction)
    reflex: bool = False

    def on_a_leg(self) -> Controller:
        """The controller of one leg."""
        push = FreeSectorAndReflex() if self.reflex else FreeSector()
        terms = None if self.action is None else self._terms(self.action, 1.0)
        return Controller(push, PhaseOscillator(), terms)

    def on_legs(self, controller: Controller, sigma: float) -> Controller:
        """A system's controller with this feedback, from such a gain on."""
        terms = None if self.action is None else self._terms(ShiftedAction(), sigma)
        return dataclasses.replace(controller, tegotae=terms)

    def _terms(self, action: Term, sigma: float) -> Tegotae:
        return Tegotae(action, self.reaction, ConstantGain(start=sigma))


LAWS: dict[str, LawForm] = {
    "clock": LawForm("no feedback"),
    "load": LawForm("-σ N cos φ", VanillaAction()),
    "offset": LawForm("-σ N (cos φ + o)", OffsetAction()),
    "latch": LawForm("-σ (1 - k N) (cos φ + o)", OffsetAction(), ReversingReaction()),
    "decay": LawForm("-σ e^(-k N) (cos φ + o)", OffsetAction(), DecayingReaction()),
    "tuned": LawForm("-σ N cos φ, with a reflex", VanillaAction(), reflex=True),
}
"""Short laws by name; on several legs there are `LAWS_OF_LEGS`."""
LAWS_OF_LEGS = ("load", "latch", "decay")
"""Short laws on several legs. With a trained step (`-t`, `-b`) there is `clock`, too."""
_NAME = re.compile(rf"(?P<law>{'|'.join(LAWS)})(?:-w(?P<omega>[0-9]+(?:[.][0-9]+)?))?")


@dataclass(frozen=True)
class ShortLaw:
    """A short law of one leg, at the frequency of its training.

    Raises:
        TegotaeError: for a frequency that is not positive.
    """

    law: str
    omega_t: float = 8.0

    def __post_init__(self) -> None:
        require_finite("omega", self.omega_t, above=0.0, most=MOST_RAD_PER_S)

    @property
    def name(self) -> str:
        """Its name."""
        return f"{self.law}-w{self.omega_t:g}"

    def controller(self, budget: int = BUDGET) -> Controller:
        """The controller.

        Raises:
            TegotaeError: for a budget of fewer numbers than it has.
        """
        controller = LAWS[self.law].on_a_leg()
        if controller.n_weights > budget:
            raise TegotaeError(
                f"{self.name} has {controller.n_weights} numbers; the budget is {budget}"
            )
        return controller

    def experiment(self, *, budget: int = BUDGET, **settings: object) -> Experiment:
        """Its training and evaluation, as those of the paper's models but for what is given."""
        system = System(controller=self.controller(budget), omega=self.omega_t, timing=EPISODE)
        return Experiment(name=self.name, system=system).replaced(**settings)


def short_law(name: str) -> ShortLaw | None:
    """The short law of a name; None for another kind of name.

    Example:
        >>> short_law("latch-w4").controller().n_weights
        5
    """
    parts = _NAME.fullmatch(name)
    if parts is None:
        return None
    return ShortLaw(parts["law"], float(parts["omega"] or 8.0))
