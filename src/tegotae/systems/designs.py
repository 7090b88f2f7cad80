"""Designs: what of a legged system's controller is learned, by names such as `ART@quadruped-c`."""

from __future__ import annotations

import dataclasses
import re
from dataclasses import dataclass
from pathlib import Path
from typing import cast

from tegotae._support.errors import TegotaeError, require_count, require_finite, unknown
from tegotae._support.limits import MOST_RAD_PER_S, MOST_WEIGHTS
from tegotae.measures.objectives.fitness import EPISODE, HoppingLegs
from tegotae.measures.objectives.objective import Objective
from tegotae.measures.objectives.walking import Walking
from tegotae.parts.bodies import Body, Walker
from tegotae.parts.controller import Controller
from tegotae.parts.fields import unwrapped
from tegotae.parts.terms import TunedFoot
from tegotae.simulation.rollout import Timing
from tegotae.systems.experiment import Experiment
from tegotae.systems.families import (
    FAMILIES,
    Family,
    alternating_rad,
    family_named,
    nominal_speed_m_per_s,
)
from tegotae.systems.grammar import BUDGET
from tegotae.systems.legged import SYSTEMS, Legged, is_walker_file, random_phases, system

EPISODE_SHARE = 0.3
"""Length of a walker's episode of training, as a share of the time of its gait commands."""
START_SEED = 0
"""Seed of the phases at the start of every training episode: as irregular as any."""


@dataclass(frozen=True)
class Design:
    """A family of controllers on a legged system, at a frequency.

    Args:
        family: what is learned.
        system: the body, the controller that is learned upon, and the release.
        called: the system's name.
        omega: ω [rad/s]; the system's own if None. It also says which speed is wanted of a walker:
            2 B ω / π, at which a foot crosses its stride in half a turn.

    Raises:
        TegotaeError: for a frequency that is not positive.

    Example:
        >>> from tegotae.systems.designs import design
        >>> found = design("ART@quadruped-c")
        >>> found.name, found.controller().n_weights
        ('ART-rF-tphif@quadruped-c', 96)
    """

    family: Family
    system: Legged
    called: str
    omega: float | None = None

    def __post_init__(self) -> None:
        if self.omega is not None:
            require_finite("omega", self.omega, above=0.0, most=MOST_RAD_PER_S)
        if self.system.omega is None:
            raise TegotaeError(f"{self.called} has no frequency of its own to learn at")

    @property
    def name(self) -> str:
        """The stable name, such as `ART-rF-tphif-w3@quadruped-c`."""
        omega = "" if self.omega is None else f"-w{self.omega:g}"
        return f"{self.family.name}{omega}@{self.called}"

    @property
    def omega_t(self) -> float:
        """ω [rad/s], which sets the wanted speed even where there is no oscillator."""
        omega = self.system.omega if self.omega is None else self.omega
        assert omega is not None  # __post_init__
        return omega

    def controller(self, budget: int = BUDGET) -> Controller:
        """The controller, with as many weights as the budget allows.

        Raises:
            TegotaeError: for a budget too small for one neuron per network.
        """
        require_count("budget", budget, most=MOST_WEIGHTS)
        return self.family.make(self.system, budget)

    @property
    def fitness(self) -> Objective:
        """A walk at the wanted speed, of a walker; hopping, of legs that push.

        Raises:
            TegotaeError: for a walker whose feet say no speed.
        """
        if not isinstance(unwrapped(self.system.body), Walker):
            return HoppingLegs()
        speed = nominal_speed_m_per_s(self.system, self.omega_t)
        if speed is None:
            raise TegotaeError(
                f"{self.called} has no ellipse that says which speed is wanted; make an Experiment "
                "of your own with Walking(speed_m_per_s=...)"
            )
        return Walking(speed_m_per_s=speed, settle_s=0.5 * self.timing.duration_s)

    @property
    def timing(self) -> Timing:
        """An episode of training: the hopper's, or for a walker long enough to settle."""
        timing = self.system.timing
        if not isinstance(unwrapped(self.system.body), Walker):
            return EPISODE
        return Timing(
            duration_s=EPISODE_SHARE * timing.duration_s,
            tick_s=timing.tick_s,
            frame_s=timing.frame_s,
        )

    def experiment(self, *, budget: int = BUDGET, **settings: object) -> Experiment:
        """The training of this design.

        Every episode begins with the same phases, drawn once for all designs (`START_SEED`).

        Args:
            budget: largest number of trained parameters.
            settings: of the `Experiment` or its system that are to be otherwise, such as timing or
                objective.

        Raises:
            TegotaeError: for a budget too small, or settings that do not fit together.
        """
        legged = self.system
        body, controller = cast(Body, settings.pop("body", legged.body)), self.controller(budget)
        system = dataclasses.replace(
            legged.system,
            controller=controller,
            body=body,
            omega=self.omega_t if self.family.has_rhythm else None,
            release=dataclasses.replace(
                legged.system.release,
                height_m=legged.system.height_on(body),
                phase_rad=self._start(controller, body),
            ),
            timing=self.timing,
        )
        objective = (
            cast(Objective, settings.pop("objective")) if "objective" in settings else self.fitness
        )
        experiment = Experiment(name=self.name, system=system, objective=objective)
        return experiment.replaced(**settings) if settings else experiment

    def _start(self, controller: Controller, body: Body) -> float | tuple[float, ...]:
        """The phases that every episode of training begins with [rad]: drawn, or of a clock, whose
        phases nothing changes, those of a trot."""
        if not self.family.has_rhythm:
            return 0.0
        if controller.tegotae is None and isinstance(controller.actuation, TunedFoot):
            return alternating_rad(self.system.names)
        return tuple(random_phases(body.limbs, 1, START_SEED)[:, 0].round(3).tolist())


_OMEGA = re.compile(r"(?P<family>.+?)(?:-w(?P<omega>[0-9.]+))?")


def is_design(name: str) -> bool:
    """Return whether a name has the form of a design's: a family and a system.

    Example:
        >>> is_design("ART@quadruped-c"), is_design("ART-rF-tphif-w8")
        (True, False)
    """
    family, separator, _ = name.partition("@")
    return bool(separator) and not set(family) & set("/\\:")


def design(name: str) -> Design:
    """The design of a name.

    Args:
        name: `FAMILY@SYSTEM`; the system is one of `tegotae.systems.legged.SYSTEMS`, `FILE.toml`
            or `FILE.py:OBJECT`.

    Raises:
        TegotaeError: for an unknown family or system, with the nearest ones.

    Example:
        >>> design("ARG-w3@hexapod").name
        'ARG-rF-gF-w3@hexapod'
    """
    family_name, _, system_name = name.partition("@")
    parts = _OMEGA.fullmatch(family_name)
    if parts is None:
        raise unknown("family", family_name, FAMILIES)
    try:
        omega = None if parts["omega"] is None else float(parts["omega"])
    except ValueError:
        raise TegotaeError(f"{name} has no frequency behind -w; write a number, as -w3") from None
    legged = system(system_name)
    short = (
        Path(system_name).stem
        if is_walker_file(system_name)
        else system_name.rpartition(":")[2] or system_name
    )
    return Design(family_named(parts["family"]), legged, short, omega)


def all_designs() -> dict[str, Design]:
    """Every listed family on every named system, by name.

    Example:
        >>> "ARGT-rF-gF-tphif@plate-light-pitch" in all_designs()
        True
    """
    legged = {name: make() for name, make in SYSTEMS.items()}
    families = [family_named(name) for name in FAMILIES]
    designs = (Design(family, body, name) for name, body in legged.items() for family in families)
    return {design.name: design for design in designs}
