"""Legged systems by name, or of a user's own file."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable

from tegotae._support.errors import TegotaeError, unknown
from tegotae.parts._shapes import LaneNumbers
from tegotae.parts.bodies import (
    Bar,
    Body,
    Plate,
    Walker,
)
from tegotae.parts.controller import Controller, Tegotae
from tegotae.parts.fields import unwrapped
from tegotae.parts.oscillators import PhaseOscillator
from tegotae.parts.terms import ConstantGain, VanillaAction, VanillaReaction
from tegotae.parts.terms.foot import EllipticFoot
from tegotae.simulation.rollout import Timing
from tegotae.systems.legged import Legged
from tegotae.systems.models import build
from tegotae.systems.system import WALKING, WALKING_TICK, System, usual_system
from tegotae.systems.user_objects import is_reference, named

HOPPING_S = 60.0
"""Time in which legs that hop under a bar or a plate settle [s]."""
LIGHT, HEAVY = 0.6, 1.6
"""Inertia ratios on either side of 1, where the legs do not feel each other."""


def hopping(about: str, body: Body) -> Legged:
    """The paper's legs under a bar or a plate; sector, ω 8, σ 1.

    Lags are measured from the (left) hind leg.

    Args:
        about: the system in one line.
        body: a bar or a plate.
    """
    controller = dataclasses.replace(build("V-sector-w8"), limbs=body.limbs)
    system = System(
        controller=controller, body=body, omega=8.0, timing=Timing(duration_s=HOPPING_S)
    )
    return Legged(about=about, system=system, weights=(1.0,))


def bar(inertia_ratio: float) -> Legged:
    """Two of the paper's legs under a bar."""
    about = f"two hopper legs under a bar, j = {inertia_ratio:g}"
    return hopping(about, Bar(inertia_ratio=inertia_ratio))


def plate(pitch: float, roll: float, twist: float | None = None) -> Legged:
    """Four of them under a plate with these inertia ratios, and a limp spine if it twists.

    Args:
        pitch: inertia ratio j_p.
        roll: inertia ratio j_r.
        twist: inertia ratio j_t; None for a rigid spine.
    """
    twisting = "" if twist is None else f", j_t = {twist:g}"
    return hopping(
        f"four hopper legs under a plate, j_p = {pitch:g}, j_r = {roll:g}{twisting}",
        Plate(pitch_inertia_ratio=pitch, roll_inertia_ratio=roll, twist_inertia_ratio=twist),
    )


def walking(
    about: str,
    body: Walker,
    foot: EllipticFoot,
    sigma: float,
    omega: float,
    tick: float = WALKING_TICK,
) -> Legged:
    """A torso on legs whose feet go round ellipses; each leg's oscillator feels its own load.

    Dimensionless: l0 = m = g = 1. It begins on its feet, at rest; lags are measured from the left
    hind leg, or the first one where there is none.

    Args:
        about: the system in one line.
        body: the torso and where its legs are.
        foot: the ellipse.
        sigma: gain σ [rad/(s N)].
        omega: frequency ω [rad/s].
        tick: control tick [√(l0 / g)].
    """
    controller = Controller(
        foot,
        PhaseOscillator(),
        Tegotae(VanillaAction(), VanillaReaction(), ConstantGain()),
        limbs=body.limbs,
    )
    system = usual_system(controller, body, omega, tick)
    return Legged(about=about, system=system, weights=(sigma,))


def quadruped_a() -> Legged:
    """Set A: broad and high, stiff legs sideways."""
    body = Walker(
        hips_x_m=(0.7, 0.7, -0.7, -0.7),
        hips_y_m=(0.45, -0.45, 0.45, -0.45),
        com_z_m=-0.2,
        inertia_x_kg_m2=0.10,
        inertia_y_kg_m2=0.25,
        inertia_z_kg_m2=0.30,
        stiffness_x_n_per_m=15.0,
        stiffness_y_n_per_m=8.0,
        stiffness_z_n_per_m=8.0,
        damping_xy_ns_per_m=1.5,
        damping_z_ns_per_m=1.2,
        friction=0.6,
    )
    foot = EllipticFoot(stride_m=0.25, lift_m=0.08, press_m=0.02, shift_rad=0.0)
    return walking("a quadruped that walks and trots, set A", body, foot, 1.0, 2.0)


def quadruped_c() -> Legged:
    """Set C: long and low, the defaults of `Walker`."""
    foot = EllipticFoot(stride_m=0.2, lift_m=0.12, press_m=0.03, shift_rad=0.4)
    return walking("a quadruped that walks and trots, set C", Walker(), foot, 1.25, 2.0)


def quadruped_g() -> Legged:
    """Set G: light in roll, heavy in pitch, its mass ahead of the middle; short and low steps."""
    body = Walker(
        hips_x_m=(1.0457, 1.0457, -1.0457, -1.0457),
        hips_y_m=(0.4044, -0.4044, 0.4044, -0.4044),
        com_x_m=0.2188,
        com_z_m=-0.3413,
        inertia_x_kg_m2=0.02383,
        inertia_y_kg_m2=0.7942,
        inertia_z_kg_m2=0.7781,
        stiffness_x_n_per_m=7.198,
        stiffness_y_n_per_m=11.996,
        stiffness_z_n_per_m=22.144,
        damping_xy_ns_per_m=0.9013,
        damping_z_ns_per_m=1.2410,
        friction=1.179,
    )
    foot = EllipticFoot(stride_m=0.0890, lift_m=0.0460, press_m=0.0102, shift_rad=0.6400)
    about = "a quadruped that walks, trots and gallops, set G"
    # Its light roll is too fast for the tick of the others.
    return walking(about, body, foot, 2.3979, 4.6, tick=0.5 * WALKING_TICK)


def hexapod() -> Legged:
    """The legs of set C, three on either side."""
    body = Walker(
        hips_x_m=(0.85, 0.85, 0.0, 0.0, -0.85, -0.85),
        hips_y_m=(0.44, -0.44, 0.44, -0.44, 0.44, -0.44),
    )
    foot = EllipticFoot(stride_m=0.2, lift_m=0.12, press_m=0.03, shift_rad=0.4)
    return walking("a hexapod with the legs of set C", body, foot, 1.25, 2.0)


def biped() -> Legged:
    """Two legs of set C, side by side. It falls: it has no ankle, and feels no tilt."""
    foot = EllipticFoot(stride_m=0.15, lift_m=0.08, press_m=0.03, shift_rad=0.4)
    body = Walker(hips_x_m=(0.0, 0.0), hips_y_m=(0.44, -0.44))
    return walking("a biped with the legs of set C; it falls", body, foot, 1.25, 2.0)


SYSTEMS: dict[str, Callable[[], Legged]] = {
    "bar-light": lambda: bar(LIGHT),
    "bar-heavy": lambda: bar(HEAVY),
    "plate-light-pitch": lambda: plate(LIGHT, HEAVY),
    "plate-light-roll": lambda: plate(HEAVY, LIGHT),
    "plate-light-both": lambda: plate(LIGHT, LIGHT),
    "plate-heavy": lambda: plate(HEAVY, HEAVY),
    "plate-light-twist": lambda: plate(HEAVY, HEAVY, LIGHT),
    "quadruped-a": quadruped_a,
    "quadruped-c": quadruped_c,
    "quadruped-g": quadruped_g,
    "hexapod": hexapod,
    "biped": biped,
}
"""What makes each of the named systems."""


def system(name: str) -> Legged:
    """A legged system, as designs are made upon; `tegotae.systems.resolve` takes all other names.

    Args:
        name: of `SYSTEMS`; or `FILE.py:OBJECT` or `MODULE:OBJECT`, a `Legged`.

    Raises:
        TegotaeError: for an unknown name, an object of another kind, or a body of one leg.

    Example:
        >>> system("bar-light").body.inertia_ratio, system("quadruped-c").names
        (0.6, ('LF', 'RF', 'LH', 'RH'))
    """
    if name in SYSTEMS:
        return SYSTEMS[name]()
    if is_reference(name):
        return named(name, Legged, "legged system")
    error = unknown("legged system", name, SYSTEMS)
    raise TegotaeError(f"{error} FILE.py:OBJECT names one of your own")


def settling(system: System, weights: LaneNumbers, about: str = "") -> Legged:
    """A system with its weights, timed so that it settles whatever its release.

    Gaits lock in some 20 to 60 √(l0 / g), which is more than an episode of training.

    Args:
        system: the system.
        weights: shape [n_weights].
        about: the system in one line; the kind of its body by default.

    Raises:
        TegotaeError: for a body of one leg, or weights of the wrong number.
    """
    timing = dataclasses.replace(system.timing, duration_s=settling_s(system.mechanics))
    return Legged(
        about=about or type(system.body).__name__,
        system=dataclasses.replace(system, timing=timing),
        weights=tuple(map(float, weights)),
    )


def settling_s(body: Body) -> float:
    """Time in which the legs of a body settle into a gait, whatever the release [s]."""
    own = unwrapped(body)
    if not isinstance(own, Walker):
        return HOPPING_S
    return WALKING * math.sqrt(own.rest_length_m / own.gravity_m_per_s2)
