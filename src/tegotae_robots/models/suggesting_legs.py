"""A first wiring of a MuJoCo model's legs, whose feet are commanded to places."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from tegotae.envs._types import MjModel
from tegotae.envs.mujoco.legs import AXES, LegKinematics
from tegotae.envs.mujoco.sensing import sensing
from tegotae.envs.mujoco.settings import ModelSettings
from tegotae.envs.scaling import gravity_m_per_s2, started, weight_n
from tegotae.envs.wiring import NOTHING, Limb, Wiring
from tegotae.parts.terms.foot import EllipticFoot
from tegotae.parts.units import Units
from tegotae.systems.vanilla import legged_named as legged_by_name
from tegotae_robots.models.checking_legs import followed, in_ground, require_stance
from tegotae_robots.models.suggesting import (
    Suggestion,
    drop_remarks,
    dropped,
    lowest_feet,
    phases_of,
    rounded,
)

_SAMPLES = 16.0
"""Control periods in √(l0 / g)."""
_DROP = 0.1
"""Height of the drop test over the model's start [l0]."""
_GRID = 81
"""Places along an axis that are tried for reach."""
_MISSES = 0.005
"""A place is out of reach if the foot stays further from it than this [l0]."""
_SAG, _SAGS = 0.1, 0.15
"""Shares of the height by which trunks sink on stiff servos, and on soft ones."""
_MIDDLE = 0.1
"""A foot is in front, behind or on a side if it is further than this from the middle [l0]."""
_STRAIGHT_DEG = 3.0
"""A start that faces no further than this from x does."""
_RATES = ("roll_rate", "pitch_rate", "side_roll_rate", "feedback")
_WALKER = "quadruped-c"
"""The walker whose law a wiring begins with."""


def suggest_legs(settings: ModelSettings) -> Suggestion:
    """Suggest a wiring whose limbs are legs: an oscillator each, that commands a foot forward and
    up, and aside if its law does.

    Its units are Froude's, l0, √(l0 / g) and the weight, with l0 from a foot to the first joint of
    its leg: a law of a walker with l0 = m = g = 1 goes on it as it is. Each leg feels the force on
    its foot as the servos' torques tell it.

    Args:
        settings: of the model, with `legs`; its control period does not count.

    Raises:
        TegotaeError: for a model without feet, legs with servos, or ground, or whose trunk cannot
            fall.

    Example:
        >>> settings = ModelSettings(model="robot.xml", legs=True)  # doctest: +SKIP
        >>> suggest_legs(settings).wiring.limbs[0].drives  # doctest: +SKIP
        ('FL_foot_x', 'FL_foot_z', 'FL_foot_y')
    """
    explicit = bool(settings.feet)
    if not explicit:
        settings = replace(
            settings, feet=lowest_feet(sensing(replace(settings, legs=False, command=())).model)
        )
    sensed = sensing(settings)
    model, legs = sensed.model, sensed.legs
    assert legs is not None
    feet, weight, gravity = sensed.feet, weight_n(model), gravity_m_per_s2(model)
    require_stance(legs)
    length = legs.height_m
    second = math.sqrt(length / gravity)
    walker = legged_by_name(_WALKER)
    omega = float(walker.omega or 0.0) / second
    rest_m, standing = dropped(sensed, sensed.still[None], _DROP * length + settings.release_m)
    phases = phases_of(model, started(model), feet)
    timestep = float(model.opt.timestep)
    step_s = timestep * max(1, round(second / _SAMPLES / timestep))
    rates = (*_RATES, "end_pitch_rate") if settings.command else _RATES
    limbs = tuple(
        Limb(
            senses=_senses(legs, i, commanded=bool(settings.command)),
            drives=tuple(f"{foot}_{axis}" for axis in "xzy"),
            phase_rad=phases[i],
        )
        for i, foot in enumerate(feet)
    )
    wiring = Wiring(
        limbs=limbs,
        controller=walker.controller,
        omega=rounded(omega),
        units=Units(length_m=rounded(length), time_s=rounded(second), force_n=rounded(weight)),
        scales={
            "spring_force": rounded(weight),
            "speed": rounded(length / second),
            **dict.fromkeys(rates, rounded(1.0 / second)),
        },
        step_s=step_s,
        contact_bodies=feet,
        height="root_height",
        work="work",
        rest_length_m=rounded(rest_m, 4),
    )
    reasons = {
        "omega": f"{walker.omega:g} √(g / l0), as the package's {_WALKER}",
        "step_s": f"{_SAMPLES:g} control periods in √(l0 / g), in whole time steps of the model",
        "contact_bodies": "as given" if explicit else "lowest bodies that end a chain",
        "height": "height of the first body",
        "work": "absolute work of the actuators, measured by the environment",
        "rest_length_m": "height at touchdown in a drop test, feet at their places",
        "units.length_m": "l0, from the feet to the first joints of their legs",
        "units.time_s": "√(l0 / g)",
        "units.force_n": "the weight",
        "scales.spring_force": "the weight, as every leg's oscillator has it in the walkers",
        "scales.speed": "√(g l0)",
        **{f"scales.{name}": "√(g / l0)" for name in rates},
    }
    for i, phase in enumerate(phases):
        reasons[f"limbs[{i}].drives"] = _reach_text(reach(legs, i))
        reasons[f"limbs[{i}].spring_force"] = "-J⁻ᵀ τ of the leg's servos, as robots have it"
        for name, reason in (
            ("side_roll", "up on the leg's side"),
            ("end_pitch", "up at the leg's end of the trunk"),
            ("side_yaw", "turned to the leg's side"),
        ):
            middle = limbs[i].senses[name] == NOTHING
            reasons[f"limbs[{i}].{name}"] = "zero: a leg in the middle" if middle else reason
        if phase:
            reasons[f"limbs[{i}].phase_rad"] = "half a turn from its neighbours"
    remarks = [
        *_faces_aside(model),
        *in_ground(sensed, settings.release_m, length),
        *followed(sensed, length),
        *_out_of_reach(legs, walker.controller.actuation, length),
        *drop_remarks(standing, _stiffer(settings, standing), 1.0 - _SAGS),
    ]
    return Suggestion(wiring, reasons, tuple(remarks), on_rail=False, legs=legs)


def _senses(legs: LegKinematics, leg: int, *, commanded: bool) -> dict[str, str]:
    """Return the senses of a leg: its load, and the trunk as a whole and as its own corner has
    it; of a robot with commands its odometry and what is commanded, too."""
    from_middle = legs.chains.foot[leg] - legs.chains.foot.mean(axis=0)
    ahead, left, _ = legs.length_m * from_middle
    limit_m = _MIDDLE * legs.height_m

    def signed(entry: str, away: float) -> str:
        """Return the entry with the sign of a distance from the middle."""
        return NOTHING if abs(away) < limit_m else entry if away > 0.0 else f"-{entry}"

    trunk, foot = ("roll", "pitch", "roll_rate", "pitch_rate", "speed"), legs.feet[leg]
    of_commands = {
        "end_pitch_rate": signed("root_pitch_rate", -ahead),
        **{f"odometry_{axis}": f"{foot}_odometry_{axis}" for axis in AXES[:2]},
        **{f"commanded_{axis}": f"{foot}_commanded_{axis}" for axis in AXES[:2]},
        "commanded_speed": "commanded_speed",
    }
    return {
        "spring_force": f"{foot}_estimated_force",
        **{name: f"root_{name}" for name in trunk},
        "side_roll": signed("root_roll", left),
        "side_roll_rate": signed("root_roll_rate", left),
        "end_pitch": signed("root_pitch", -ahead),
        "side_yaw": signed("root_yaw", left),
        **(of_commands if commanded else {}),
    }


def reach(legs: LegKinematics, leg: int) -> np.ndarray:
    """Return the reach of a foot from its place in the model's start along each axis, back and
    forth.

    Returns:
        Shape [axes, 2], [m]; 0 where it cannot go that way.
    """
    along = np.linspace(-legs.length_m, legs.length_m, 2 * _GRID + 1)
    ranges = np.zeros((len(AXES), 2))
    for axis in range(len(AXES)):
        places = np.zeros((len(along), len(legs.feet), len(AXES)))
        places[:, leg, axis] = along
        gaps = np.flatnonzero(_missed_m(legs, places)[:, leg] > _MISSES * legs.height_m)
        middle = _GRID
        low = gaps[gaps < middle].max(initial=-1) + 1
        high = gaps[gaps > middle].min(initial=len(along)) - 1
        ranges[axis] = along[low], along[high]
    return ranges


def workspace(legs: LegKinematics, plane: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
    """Return the places that the feet reach in a plane through those in the model's start.

    Args:
        legs: of the model.
        plane: its two axes, such as (0, 2).

    Returns:
        Places along an axis [m], [places]; and whether a foot reaches a pair of them, of the first
        and of the second axis, [places, places, legs].
    """
    along = np.linspace(-legs.length_m, legs.length_m, _GRID)
    places = np.zeros((len(along), len(along), len(legs.feet), len(AXES)))
    places[..., plane[0]], places[..., plane[1]] = along[:, None, None], along[None, :, None]
    missed = _missed_m(legs, places.reshape(-1, len(legs.feet), len(AXES)))
    return along, missed.reshape(places.shape[:3]) <= _MISSES * legs.height_m


def _missed_m(legs: LegKinematics, places: np.ndarray) -> np.ndarray:
    """Return distances of feet from commanded places [m], [lanes, legs], of places [m], [lanes,
    legs, 3]."""
    return np.linalg.norm(legs.places_of(legs.joints_at(places)) - places, axis=2)


def _reach_text(reach_m: np.ndarray) -> str:
    parts = (
        f"{axis} {low:+.2f} to {high:+.2f}" for axis, (low, high) in zip(AXES, reach_m, strict=True)
    )
    return "the foot reaches " + ", ".join(parts) + " m"


def _stiffer(settings: ModelSettings, standing: float) -> str:
    """Return the servos that would bear the weight better."""
    if not settings.servo_nm_per_rad:
        return "stiffer servos"
    stiffness = settings.servo_nm_per_rad * (1.0 - standing) / _SAG
    return f"stiffer servos, such as --settings servo_nm_per_rad={rounded(stiffness, 2):g}"


def _faces_aside(model: MjModel) -> list[str]:
    """List the remark on a start whose trunk does not face along x."""
    ahead, left, _ = started(model).xmat[1].reshape(3, 3)[:, 0]
    yaw = math.degrees(math.atan2(left, ahead))
    if abs(yaw) <= _STRAIGHT_DEG:
        return []
    return [
        f"the model's start faces {yaw:.0f}° from x, along which the distance is counted and from "
        "which root_yaw is; turn the start (a keyframe), or the law is paid for walking aside"
    ]


def _out_of_reach(legs: LegKinematics, ellipse: object, length_m: float) -> list[str]:
    """List the remark on feet that do not reach all of the walker's ellipse."""
    assert isinstance(ellipse, EllipticFoot)
    phase = np.linspace(0.0, 2.0 * np.pi, 64)
    x, z = np.asarray(ellipse.place(np.sin(phase), np.cos(phase))) * length_m
    places = np.zeros((len(phase), len(legs.feet), len(AXES)))
    places[..., 0], places[..., 2] = x[:, None], z[:, None]
    missed = _missed_m(legs, places).max(axis=0)
    return [
        f"{foot} misses the walker's ellipse by up to {gap:.2g} m; begin with more bent legs (a "
        "keyframe), or a smaller ellipse"
        for foot, gap in zip(legs.feet, missed, strict=True)
        if gap > _MISSES * length_m
    ]
