"""A walker fitted to a legged MuJoCo model, on which a law is trained in minutes: its template."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from tegotae._support.documents import Document
from tegotae._support.errors import TegotaeError, require
from tegotae.envs._types import MjData, MjModel
from tegotae.envs.mujoco.rigid_legs import require_open_chains
from tegotae.envs.mujoco.sensing import sensing
from tegotae.envs.mujoco.settings import ModelSettings
from tegotae.envs.scaling import chain_of, foot_of, gravity_m_per_s2, lowest, started
from tegotae.parts.bodies import Walker
from tegotae.parts.terms import EllipticFoot
from tegotae.systems.system import WALKING_TICK
from tegotae.systems.vanilla import legged_of
from tegotae_robots.models.step_response import (
    RobotStance,
    StepResponse,
    responses_of_walker,
    stance_of_robot,
)
from tegotae_robots.models.suggesting import lowest_feet
from tegotae_robots.models.swing import swing_of_robot, swing_of_walker

mujoco = require("mujoco", "mujoco")

_FREE, _SLIDE = int(mujoco.mjtJoint.mjJNT_FREE), int(mujoco.mjtJoint.mjJNT_SLIDE)
_AXES = ("x", "y", "z")
_PLANE = ((0, "x"), (2, "z"))
"""Plane in which a walker's feet are commanded."""
_MOVES = 1e-6
"""A foot moves along an axis if its compliance there is above this share of its largest."""
_ALIKE = 1.2
"""Legs are alike if their stiffness differs by less than this factor."""
_SINKS = 0.02
"""Feet that sink further into the ground than this [l0] are worth a remark."""

_OURS = "as the walkers of this package, by Froude's scaling"
_STEP = "a low step, to be tuned: a robot's mass is high"
_USUAL = {
    "sigma": (1.25, _OURS),
    "omega": (2.0, _OURS),
    "foot.stride_m": (0.15, _STEP),
    "foot.lift_m": (0.06, _STEP),
    "foot.press_m": (0.03, _OURS),
    "foot.shift_rad": (0.4, _OURS),
}
"""Numbers that no model has, with their reasons."""
_FAST = "of the usual control tick; the stance is too fast for that"
_STILL = {"stride_m": 0.0, "lift_m": 0.0, "press_m": 0.0}
"""The ellipse of a foot that stays where it is."""
_REASONS = {
    "hips": "a foot at the start, from the middle of all feet",
    "com": "centre of mass, from the middle of the feet and the height of the hips",
    "inertia": "all bodies at the start, about their centre of mass",
    "stiffness": "servos and springs through the leg's Jacobian; mean of the legs",
    "damping": "servos and joints, likewise",
    "leg": "what moves with a foot, the torso held: in the cost of transport alone",
    "joint": "damping of the joints, which the servos overcome; likewise",
    "friction": "contacts of the feet with the ground",
}


@dataclass(frozen=True)
class TemplateNumber:
    """A number of a template."""

    value: float | tuple[float, ...]
    """Without dimension: l0 = m = g = 1."""
    scale: float
    """Value of 1 of it on the robot."""
    unit: str
    """SI unit of the scale."""
    reason: str
    """Reason for the value."""


@dataclass(frozen=True)
class Template:
    """A walker that stands for a robot."""

    about: str
    """The robot in a line, with its l0, m and g."""
    length_m: float
    """Length of a leg l0 [m]."""
    mass_kg: float
    """Mass m [kg]."""
    gravity_m_per_s2: float
    """Gravity g [m/s²]."""
    numbers: Mapping[str, TemplateNumber]
    """Numbers by name, such as `omega`, `foot.lift_m` or `body.com_z_m`."""
    push_n: float
    """Largest push of a leg straight down [N]; infinite if nothing limits it."""
    walker: Mapping[str, StepResponse]
    """Step responses of the walker, over l0 and √(l0 / g)."""
    robot: RobotStance
    """Those of the robot."""
    swings: tuple[float, float]
    """Work of a leg over a cycle of its foot in the air, over m g l0: the walker's, the robot's."""
    remarks: tuple[str, ...]
    """Differences between the robot and a walker: a sentence each."""

    @property
    def document(self) -> Document:
        """The walker as plain values (`tegotae.systems.vanilla.legged_of`)."""
        return _document(self.about, self.numbers)

    @property
    def text(self) -> str:
        """The template as TOML, with the reasons as comments."""
        lines, table = [f"about = {json.dumps(self.about, ensure_ascii=False)}"], ""
        for name, number in self.numbers.items():
            inside, _, entry = name.rpartition(".")
            lines += ["", f"[{inside}]"] if inside != table else []
            lines.append(f"{entry} = {json.dumps(number.value)}  # {number.reason}")
            table = inside
        return "\n".join(lines) + "\n"


class _Leg(NamedTuple):
    body: int
    """Body of its foot."""
    joints: list[int]
    sole_m: np.ndarray
    """Place of its sole, [x, y, z]."""
    hip_m: float
    """Height of its hip over that."""
    stiffness_n_per_m: np.ndarray
    damping_ns_per_m: np.ndarray
    mass_kg: np.ndarray
    """Mass that a drive moves when it moves the foot along an axis, and the damping against it."""
    joint_damping_ns_per_m: np.ndarray
    push_n: float


class _Drives(NamedTuple):
    """Stiffness and damping on the model's degrees of freedom, [nv, nv]."""

    stiffness: np.ndarray
    damping: np.ndarray
    moment: np.ndarray
    """Moments of the actuators, [actuators, nv]."""


def fit_template(settings: ModelSettings, name: str) -> Template:
    """Fit the walker that stands for a legged MuJoCo model.

    The rest pose is the model's start. With J the Jacobian of a foot in the joints of its leg, K_q
    and D_q the stiffness and damping of servos, springs and joints, and C = J K_q⁻¹ Jᵀ, a foot that
    is pushed along axis i and free along the others has

        K_i = 1 / C_ii,    D_i = (J K_q⁻¹ D_q K_q⁻¹ Jᵀ)_ii / C_ii².

    A foot that moves along axis i costs what moves the joints q̇ = J⁺ẋ: with M_q their inertia and
    d_q their own damping, the mass (J⁺ᵀ M_q J⁺)_ii and the damping (J⁺ᵀ d_q J⁺)_ii.

    Masses and inertias, the Jacobians and the contacts are MuJoCo's own. A leg's weight and its
    pull on the torso are the torso's; limits of torque, dry friction and a soft ground are not in a
    walker.

    Args:
        settings: of the model; its feet are the lowest bodies that end a chain if none are named.
        name: of the robot.

    Raises:
        TegotaeError: without a floating base, two legs or ground; for legs of unlike numbers of
            joints, of unknown stiffness, or whose feet cannot move; or for what no walker can be.

    Example:
        >>> from tegotae.envs.mujoco.settings import PACKAGED
        >>> fit_template(PACKAGED["quadruped"], "small").mass_kg  # doctest: +SKIP
        1.5
    """
    if not settings.feet:
        settings = replace(settings, feet=lowest_feet(sensing(settings).model))
    sensed = sensing(settings)
    model, data = sensed.model, started(sensed.model)
    if not model.body_jntnum[1] or model.jnt_type[model.body_jntadr[1]] != _FREE:
        raise TegotaeError(
            f"{sensed.root} has no free joint, and the torso of a walker floats; give the model's "
            "first body a <freejoint/>"
        )
    legs = _legs(model, data, sensed.feet)
    gravity, mass = gravity_m_per_s2(model), float(data.crb[1, 9])
    length = float(np.mean([leg.hip_m for leg in legs]))
    if min(gravity, mass, length) <= 0.0:
        raise TegotaeError(
            f"gravity is {gravity:g} m/s², the mass {mass:g} kg and the hips are {length:g} m over "
            "the feet at the start; each must be greater than 0"
        )
    robot = stance_of_robot(sensed, length)
    numbers = {
        name: TemplateNumber(value, *_unit(name, length, mass, gravity), reason)
        for name, (value, reason) in _USUAL.items()
    }
    for entry, value in {**_body(data, legs, length), "friction": robot.friction}.items():
        scale, unit = _unit(entry, length, mass, gravity)
        reason = _REASONS[entry.partition("_")[0]]
        numbers[f"body.{entry}"] = TemplateNumber(_rounded(value / scale), scale, unit, reason)
    description = f"{name}: l0 = {length:.4g} m, m = {mass:.4g} kg, g = {gravity:.4g} m/s²"
    try:
        body = Walker(**_document(description, numbers)["body"])
        ticks = body.longest_tick_s / WALKING_TICK
        if ticks < 1.0:
            halved = TemplateNumber(2.0 ** math.floor(math.log2(ticks)), 1.0, "", _FAST)
            numbers = {"ticks": halved, **numbers}
        walker = legged_of({**_document(description, numbers), "foot": _STILL})
    except TegotaeError as error:
        raise TegotaeError(
            f"{name} over its length, mass and gravity is no walker: {error}"
        ) from None
    foot, omega = _document(description, numbers)["foot"], _USUAL["omega"][0]
    ellipse = EllipticFoot(**{name: x * numbers[f"foot.{name}"].scale for name, x in foot.items()})
    its_omega = omega * numbers["omega"].scale
    swings = [
        swing_of_robot(model, leg.body, leg.sole_m, leg.joints, ellipse, its_omega) for leg in legs
    ]
    ours = swing_of_walker(body, EllipticFoot(**foot), omega)
    return Template(
        about=description,
        length_m=length,
        mass_kg=mass,
        gravity_m_per_s2=gravity,
        numbers=numbers,
        push_n=min(leg.push_n for leg in legs),
        walker=responses_of_walker(walker),
        robot=robot,
        swings=(ours, float(np.mean(swings)) / (mass * gravity * length)),
        remarks=_remarks(legs, robot),
    )


def _document(description: str, numbers: Mapping[str, TemplateNumber]) -> Document:
    document: Document = {"about": description}
    for name, number in numbers.items():
        table, _, entry = name.rpartition(".")
        (document.setdefault(table, {}) if table else document)[entry] = number.value
    return document


def _unit(name: str, length_m: float, mass_kg: float, gravity: float) -> tuple[float, str]:
    """Return the robot's value of 1 of a dimensionless number, and the unit that its name ends
    in."""
    time_s, force_n = math.sqrt(length_m / gravity), mass_kg * gravity
    units = {
        "sigma": (1.0 / (time_s * force_n), "rad/(s N)"),
        "omega": (1.0 / time_s, "rad/s"),
        "_rad": (1.0, "rad"),
        "_kg_m2": (mass_kg * length_m**2, "kg m²"),
        "_ns_per_m": (force_n * time_s / length_m, "N s/m"),
        "_n_per_m": (force_n / length_m, "N/m"),
        "_m": (length_m, "m"),
        "_kg": (mass_kg, "kg"),
    }
    return next((unit for end, unit in units.items() if name.endswith(end)), (1.0, ""))


def _body(data: MjData, legs: list[_Leg], length_m: float) -> dict[str, np.ndarray]:
    """Return the numbers of the body in SI units, by the walker's names."""
    soles = np.array([leg.sole_m for leg in legs])
    middle = soles.mean(axis=0)
    centre = data.subtree_com[1] - middle - [0.0, 0.0, length_m]
    stiffness = np.mean([leg.stiffness_n_per_m for leg in legs], axis=0)
    damping = np.mean([leg.damping_ns_per_m for leg in legs], axis=0)
    moved = np.mean([leg.mass_kg for leg in legs], axis=0)
    joints = np.mean([leg.joint_damping_ns_per_m for leg in legs], axis=0)
    return {
        "hips_x_m": soles[:, 0] - middle[0],
        "hips_y_m": soles[:, 1] - middle[1],
        **{f"com_{axis}_m": centre[i] for i, axis in enumerate(_AXES)},
        **{f"inertia_{axis}_kg_m2": data.crb[1, i] for i, axis in enumerate(_AXES)},
        **{f"stiffness_{axis}_n_per_m": stiffness[i] for i, axis in enumerate(_AXES)},
        "damping_xy_ns_per_m": damping[:2].mean(),
        "damping_z_ns_per_m": damping[2],
        **{f"leg_mass_{axis}_kg": moved[i] for i, axis in _PLANE},
        **{f"joint_damping_{axis}_ns_per_m": joints[i] for i, axis in _PLANE},
    }


def _legs(model: MjModel, data: MjData, feet: tuple[str, ...]) -> list[_Leg]:
    """Return the legs, each with its own joints."""
    require_open_chains(model, feet)
    chains = [chain_of(model, foot) for foot in feet]
    hung = [
        [k for k in range(model.nv) if model.dof_bodyid[k] in chain and model.dof_bodyid[k] > 1]
        for chain in chains
    ]
    # What several feet hang on, such as a spine, is taken for rigid.
    joints = [
        [k for k in leg_dofs if sum(k in foot_dofs for foot_dofs in hung) == 1] for leg_dofs in hung
    ]
    counts = dict(zip(feet, map(len, joints), strict=True))
    if len(feet) < 2 or not all(joints):
        raise TegotaeError(
            f"the model has {sum(map(bool, joints))} legs, with joints between the first body and "
            f"a foot ({', '.join(feet)}); a walker has two at least: name other feet, --feet"
        )
    if len(set(counts.values())) > 1:
        listing = ", ".join(f"{foot} {count}" for foot, count in counts.items())
        raise TegotaeError(
            f"the legs have unlike numbers of degrees of freedom ({listing}); a walker's are "
            "alike: name feet of legs that are, --feet"
        )
    drives = _drives(model, data)
    return [
        _leg(model, data, foot, leg_dofs, drives)
        for foot, leg_dofs in zip(feet, joints, strict=True)
    ]


def _drives(model: MjModel, data: MjData) -> _Drives:
    moment = np.zeros((model.nu, model.nv))
    sparse = data.moment_rownnz, data.moment_rowadr, data.moment_colind
    mujoco.mju_sparse2dense(moment, data.actuator_moment, *sparse)
    affine = model.actuator_biastype == mujoco.mjtBias.mjBIAS_AFFINE
    stiff, damp = np.where(affine, -model.actuator_biasprm[:, 1:3].T, 0.0)
    return _Drives(
        moment.T @ (stiff[:, None] * moment) + np.diag(model.jnt_stiffness[model.dof_jntid]),
        moment.T @ (damp[:, None] * moment) + np.diag(model.dof_damping),
        moment,
    )


def _leg(model: MjModel, data: MjData, name: str, joints: list[int], drives: _Drives) -> _Leg:
    foot = foot_of(model, name)
    if not foot.geoms:
        raise TegotaeError(f"{name} has no geom to stand on; name another foot, --feet")
    low, geom = lowest(model, data, foot.geoms)
    sole = np.array([*data.geom_xpos[geom][:2], low])
    jacobian = np.zeros((3, model.nv))
    mujoco.mj_jac(model, data, jacobian, None, sole, foot.body)
    jacobian, block = jacobian[:, joints], np.ix_(joints, joints)
    stiffness = drives.stiffness[block]
    if np.linalg.matrix_rank(stiffness) < len(joints):
        held = ", ".join(dict.fromkeys(model.joint(int(model.dof_jntid[k])).name for k in joints))
        raise TegotaeError(
            f"the stiffness of the leg of {name} is unknown: not each of its joints ({held}) has a "
            "position servo or a spring of its own; give them one, or make servos of the motors: "
            "--settings servo_nm_per_rad=K"
        )
    bend = jacobian @ np.linalg.inv(stiffness)
    compliance = np.diag(bend @ jacobian.T)
    moves = compliance > _MOVES * compliance.max()
    if not (moves[0] and moves[2]):
        raise TegotaeError(
            f"{name} cannot move {'up and down' if moves[0] else 'fore and aft'} where the model "
            "starts, as a walker's feet do; begin with bent legs (a keyframe), or free a joint"
        )
    # A foot that does not move sideways is as stiff there as it is in its stiffest direction.
    axes = [0, 1 if moves[1] else int(2 * (compliance[2] < compliance[0])), 2]
    compliance, damped = compliance[axes], np.diag(bend @ drives.damping[block] @ bend.T)[axes]
    hinges = [k for k in joints if model.jnt_type[model.dof_jntid[k]] != _SLIDE]
    hip = data.xanchor[model.dof_jntid[hinges[0]], 2] if hinges else data.xpos[1, 2]
    effort = np.abs(np.linalg.pinv(drives.moment[:, joints].T) @ jacobian[2])
    limits = np.where(model.actuator_forcelimited, np.abs(model.actuator_forcerange).max(1), np.inf)
    push = np.min(limits[effort > 1e-9] / effort[effort > 1e-9], initial=np.inf)
    moved = np.linalg.pinv(jacobian)
    inertia = np.array([_inertia_of(model, data, k) for k in joints])[:, joints]
    mass, joint_damping = (
        np.diag(moved.T @ of_joints @ moved)
        for of_joints in (inertia, np.diag(model.dof_damping[joints]))
    )
    bears = 1.0 / compliance, damped / compliance**2
    return _Leg(foot.body, joints, sole, hip - low, *bears, mass, joint_damping, push_n=float(push))


def _inertia_of(model: MjModel, data: MjData, joint: int) -> np.ndarray:
    """Return a row of the matrix of inertia, [nv]."""
    row, unit = np.zeros(model.nv), np.zeros(model.nv)
    unit[joint] = 1.0
    mujoco.mj_mulM(model, data, row, unit)
    return row


def _remarks(legs: list[_Leg], robot: RobotStance) -> tuple[str, ...]:
    stiffness = np.array([leg.stiffness_n_per_m for leg in legs])
    sentences = [
        f"the legs differ: K_{axis} is {low:.3g} to {high:.3g} N/m, and the template has the mean"
        for axis, low, high in zip(_AXES, stiffness.min(0), stiffness.max(0), strict=True)
        if high > _ALIKE * low
    ]
    if robot.sinks > _SINKS:
        sentences.append(
            f"the robot's feet sink {robot.sinks:.2f} l0 into the ground, as soft as the model's "
            "contacts are; the template's ground is hard"
        )
    return tuple(sentences)


def _rounded(value: np.ndarray | float) -> float | tuple[float, ...]:
    """Round a number, or numbers, to four significant digits."""
    if isinstance(value, np.ndarray):
        return tuple(float(f"{round(x, 6) + 0.0:.4g}") for x in value.tolist())
    return float(f"{round(float(value), 6) + 0.0:.4g}")
