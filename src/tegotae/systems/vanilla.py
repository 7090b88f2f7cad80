"""Vanilla closed loops by name: the presets of a hopper, and legged systems."""

from __future__ import annotations

import dataclasses
import math
import tomllib
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

import msgspec

from tegotae._support import documents
from tegotae._support.documents import Json
from tegotae._support.errors import TegotaeError, lookup, require_finite, require_known, unknown
from tegotae.parts.bodies import Body, Hopper
from tegotae.parts.channels import FORCE
from tegotae.parts.controller import Controller, Tegotae
from tegotae.parts.oscillators import Oscillator, PhaseOscillator
from tegotae.parts.terms import (
    Actuation,
    ConstantGain,
    Reflex,
    Sector,
    SectorAndReflex,
    VanillaAction,
    VanillaReaction,
)
from tegotae.parts.terms.foot import EllipticFoot
from tegotae.simulation.rollout import Timing
from tegotae.systems.descriptions import restore
from tegotae.systems.legged import HOPPING_S, Legged
from tegotae.systems.registry import is_reference, load_object
from tegotae.systems.system import WALKING_TICK, Release, System, usual_system

_PAPERS = PhaseOscillator()
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

    def controller(self, actuation: str, oscillator: Oscillator = _PAPERS) -> Controller:
        """Return the vanilla controller with this actuation: "sector", "reflex" or "both".

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
        require_known("actuation", actuation, actuations)
        terms = Tegotae(VanillaAction(), VanillaReaction(), ConstantGain())
        return Controller(actuations[actuation], oscillator, terms)

    def system(self, actuation: str, oscillator: Oscillator = _PAPERS) -> System:
        """Return the closed loop of its hopper and the vanilla controller with this actuation."""
        return System(
            controller=self.controller(actuation, oscillator),
            body=self.hopper,
            omega=self.omega_rad_per_s,
            release=Release(height_m=self.height_m),
        )


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
    """Return the preset of that name.

    Raises:
        TegotaeError: for an unknown name, with the nearest ones.
    """
    return lookup("preset", name, PRESETS)


_SECTOR = PRESETS["paper"].controller("sector")


def hopping(description: str, body: Body, sigma: float = 1.0, omega: float = 8.0) -> Legged:
    """Return the paper's legs under a bar or a plate, which push over the paper's sector.

    Lags are measured from the (left) hind leg.

    Args:
        description: the system in one line.
        body: a bar or a plate.
        sigma: gain σ [rad/(s N)].
        omega: frequency ω [rad/s].
    """
    controller = dataclasses.replace(_SECTOR, limbs=body.limbs)
    system = System(
        controller=controller, body=body, omega=omega, timing=Timing(duration_s=HOPPING_S)
    )
    return Legged(about=description, system=system, weights=(sigma,))


def walking(
    description: str,
    body: Body,
    foot: EllipticFoot,
    sigma: float,
    omega: float,
    tick: float = WALKING_TICK,
) -> Legged:
    """Return a torso on legs whose feet follow ellipses; each leg's oscillator feels its own load.

    Dimensionless: l0 = m = g = 1. It begins on its feet, at rest; lags are measured from the left
    hind leg, or the first one where there is none.

    Args:
        description: the system in one line.
        body: the torso and where its legs are, a `Walker`, perhaps in wrappers.
        foot: the ellipse.
        sigma: gain σ [rad/(s N)].
        omega: frequency ω [rad/s].
        tick: control tick [√(l0 / g)].
    """
    controller = dataclasses.replace(_SECTOR, actuation=foot, limbs=body.limbs)
    system = usual_system(controller, body, omega, tick)
    return Legged(about=description, system=system, weights=(sigma,))


class _LeggedDocument(msgspec.Struct, forbid_unknown_fields=True):
    about: str
    sigma: float
    omega: float
    foot: dict[str, Json] = {}
    body: dict[str, Json] = {}
    senses: dict[str, Json] | None = None
    ticks: float = 1.0


def legged_of(document: object) -> Legged:
    """Return the legged system of plain values, such as an entry of `legged.toml`.

    Args:
        document: `about`, `sigma`, `omega`, and the fields of its `body`, a `Walker` if they name
            no other `kind`; of a walker those of its `foot`, `EllipticFoot`; `senses` those of
            `Sensors`, if they are late or noisy; `ticks` is a walker's control tick over that of
            others.

    Raises:
        TegotaeError: for an entry that is missing, unknown or out of its range.

    Example:
        >>> legged_of({"about": "mine", "sigma": 1.0, "omega": 2.0}).names
        ('LF', 'RF', 'LH', 'RH')
    """
    fields = documents.fitted(document, _LeggedDocument)
    require_finite("sigma", fields.sigma)
    entries: dict[str, Json] = {"kind": "Walker", **fields.body}
    if fields.senses is not None:
        entries = {"body": entries, **fields.senses, "kind": "Sensors"}
    body = restore(entries, Body, "body")
    if body.COMMANDS == FORCE:
        return hopping(fields.about, body, fields.sigma, fields.omega)
    foot = restore({**fields.foot, "kind": "EllipticFoot"}, EllipticFoot, "foot")
    tick = WALKING_TICK * fields.ticks
    return walking(fields.about, body, foot, fields.sigma, fields.omega, tick)


def is_walker_file(name: str) -> bool:
    """Return whether a name is that of a walker's own file, TOML."""
    return name.endswith(".toml")


_DOCUMENTS = tomllib.loads(Path(__file__).with_name("legged.toml").read_text(encoding="utf-8"))
SYSTEMS: dict[str, Callable[[], Legged]] = {
    name: partial(legged_of, document) for name, document in _DOCUMENTS.items()
}
"""Factories of the named systems."""


def legged_named(name: str) -> Legged:
    """Return a legged system by its name in recipes; `tegotae.systems.resolve` takes all other
    names.

    Args:
        name: of `SYSTEMS`; `FILE.toml`, a walker as in `legged.toml`; or `FILE.py:OBJECT` or
            `MODULE:OBJECT`, a `Legged`.

    Raises:
        TegotaeError: for an unknown name, a damaged file, an object of another kind, or a body of
            one leg.

    Example:
        >>> legged_named("bar-light").body.inertia_ratio, legged_named("quadruped-c").names
        (0.6, ('LF', 'RF', 'LH', 'RH'))
    """
    if name in SYSTEMS:
        return SYSTEMS[name]()
    if is_walker_file(name):
        return documents.read_as(Path(name), "walker", legged_of)
    if is_reference(name):
        return load_object(name, Legged, "legged system")
    error = unknown("legged system", name, SYSTEMS)
    raise TegotaeError(f"{error} FILE.py:OBJECT names one of your own")
