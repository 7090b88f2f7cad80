"""Step responses of a robot and of its template, side by side: under the weight, under a push."""

from __future__ import annotations

import copy
import dataclasses
import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from tegotae._support.errors import TegotaeError, require
from tegotae.envs._types import MjData, MjModel
from tegotae.envs.mujoco.sensing import Sensing, is_sound
from tegotae.envs.scaling import foot_of, gravity_m_per_s2, lowest, started
from tegotae.simulation.schedules import Step
from tegotae.simulation.summaries import whole_trajectory
from tegotae.systems.legged import Legged
from tegotae.systems.system import WALKING_TICK

mujoco = require("mujoco", "mujoco")

PUSH = 0.1
"""Force fore and aft, over the weight."""
_SETTLES = 30.0
"""Time of either response [√(l0 / g)]."""
_COLLAPSES = 0.5
"""A robot that sinks further than this [l0] does not stand."""
_OVERSHOOTS = 0.02
"""Less, of ζ above 0.78, is not told from creep."""


class StepResponse(NamedTuple):
    """Response of a body that comes to rest elsewhere under a constant force."""

    travel: float
    """Distance of that."""
    frequency: float
    """Natural frequency ω_n [rad over the unit of time]; nan without an overshoot."""
    damping_ratio: float
    """ζ; 1 without an overshoot."""

    @classmethod
    def from_motion(cls, time: np.ndarray, place: np.ndarray) -> StepResponse:
        """Return the response of a damped oscillator with the same peak time t and overshoot M:

            ζ = -ln M / √(π² + ln² M),   ω_n = π / (t √(1 - ζ²)).

        Args:
            time: from the step on, [samples].
            place: at rest by the last tenth, [samples].

        Example:
            >>> t = np.linspace(0.0, 60.0, 6001)
            >>> ringing = np.exp(-0.2 * t) * (np.cos(2.0 * t) + 0.1 * np.sin(2.0 * t))
            >>> [round(x, 2) for x in StepResponse.from_motion(t, 1.0 - ringing)]
            [1.0, 2.01, 0.1]
        """
        travel = float(place[-len(place) // 10 :].mean() - place[0])
        share = (place - place[0]) / travel
        peak = int(np.argmax(share))
        overshoot = float(share[peak]) - 1.0
        if overshoot < _OVERSHOOTS or peak == 0:
            return cls(abs(travel), math.nan, 1.0)
        decay = -math.log(overshoot)
        ratio = decay / math.hypot(math.pi, decay)
        peak_time = float(time[peak] - time[0])
        return cls(abs(travel), math.pi / peak_time / math.sqrt(1.0 - ratio**2), ratio)


class RobotStance(NamedTuple):
    """A robot that stands."""

    responses: Mapping[str, StepResponse]
    """`bounce` and `sway`, lengths over l0 and times over √(l0 / g)."""
    friction: float
    """Coefficient of friction under the feet."""
    sinks: float
    """Depth by which the feet sink into the ground, over l0."""


def responses_of_walker(walker: Legged) -> Mapping[str, StepResponse]:
    """Step responses of a dimensionless walker whose feet stay where they are commanded to be.

    Args:
        walker: with feet that do not move.
    """
    timing = dataclasses.replace(walker.timing, duration_s=2.0 * _SETTLES, frame_s=WALKING_TICK)
    scenario = walker.scenario(
        0.0,
        height_m=walker.body.touching_height_m,
        changes={"push_x_n": Step(PUSH, from_s=_SETTLES)},
    )
    run = walker.run(whole_trajectory, scenario, timing)
    half = round(_SETTLES / timing.frame_s)
    ahead, height = np.asarray(run.x_m, float)[half:, 0], np.asarray(run.height_m, float)[:half, 0]
    return _responses(height, ahead, timing.frame_s)


def stance_of_robot(sensed: Sensing, length_m: float) -> RobotStance:
    """Step responses of a robot whose servos hold the model's start.

    Args:
        sensed: the model.
        length_m: length of a leg l0 [m].

    Raises:
        TegotaeError: for a model without ground under the feet, one that is unstable, or one that
            does not stand on its feet.
    """
    model = copy.copy(sensed.model)
    data, feet = started(model), [foot_of(model, name) for name in sensed.feet]
    _hold(model, data, sensed.held)
    _put_down(model, data, sensed, length_m)
    gravity = gravity_m_per_s2(model)
    tick = float(model.opt.timestep) / math.sqrt(length_m / gravity)
    geoms = [geom for foot in feet for geom in foot.geoms]

    def soles_m() -> float:
        return float(np.mean([lowest(model, data, foot.geoms)[0] for foot in feet]))

    def pushed(share: float) -> np.ndarray:
        """Return height, and the distance ahead of the feet (they creep on soft contacts), [2,
        samples].
        """
        model.opt.gravity[0] = share * gravity  # a force on all bodies alike
        places = []
        for _ in range(round(_SETTLES / tick)):
            mujoco.mj_step(model, data)
            x, _, z = data.subtree_com[1]
            places.append((z, x - data.geom_xpos[geoms, 0].mean()))
        if not is_sound(np.array(places)).all():
            raise TegotaeError(
                "the MuJoCo model is unstable: it does not come to rest on its feet; its time "
                f"step of {model.opt.timestep:g} s must be smaller, or its servos softer"
            )
        return np.array(places).T / length_m

    start_m = soles_m()
    height, _ = pushed(0.0)
    _require_standing(model, data, geoms, float(height[0] - height[-1]))
    sinks, friction = (start_m - soles_m()) / length_m, _friction(data, geoms)
    _, ahead = pushed(PUSH)
    return RobotStance(_responses(height, ahead, tick), friction, sinks)


def _responses(height: np.ndarray, ahead: np.ndarray, tick: float) -> Mapping[str, StepResponse]:
    """Return the responses of a height since the legs began to bear, and of a place since it was
    pushed."""
    signals = {"bounce": height, "sway": ahead}
    return {
        name: StepResponse.from_motion(tick * np.arange(len(x)), x) for name, x in signals.items()
    }


def _hold(model: MjModel, data: MjData, held: np.ndarray) -> None:
    """Set commands at which no servo acts in the present pose."""
    servos = model.actuator_biastype == mujoco.mjtBias.mjBIAS_AFFINE
    servos &= model.actuator_gainprm[:, 0] != 0.0
    bias = model.actuator_biasprm[:, 0] + model.actuator_biasprm[:, 1] * data.actuator_length
    data.ctrl[:] = held
    np.divide(-bias, model.actuator_gainprm[:, 0], out=data.ctrl, where=servos)
    filtered = model.actuator_actadr >= 0
    data.act[model.actuator_actadr[filtered]] = data.ctrl[filtered]


def _put_down(model: MjModel, data: MjData, sensed: Sensing, length_m: float) -> None:
    """Lower the robot, from above, until the first foot touches the ground."""
    rise = int(model.jnt_qposadr[model.body_jntadr[1]]) + 2
    data.qpos[rise] += length_m
    mujoco.mj_kinematics(model, data)
    gaps = []
    for name in sensed.feet:
        foot = foot_of(model, name)
        low, geom = lowest(model, data, foot.geoms)
        sole = np.array([*data.geom_xpos[geom][:2], low])
        down, hit = np.array([0.0, 0.0, -1.0]), np.zeros(1, np.int32)
        gaps.append(mujoco.mj_ray(model, data, sole, down, None, 1, foot.body, hit))
    if max(gaps) < 0.0:
        raise TegotaeError(
            f"there is no ground under the feet ({', '.join(sensed.feet)}); a model of a robot "
            "alone takes a floor: --settings ground=true"
        )
    data.qpos[rise] -= min(gap for gap in gaps if gap >= 0.0)
    mujoco.mj_forward(model, data)


def _require_standing(model: MjModel, data: MjData, geoms: Sequence[int], sank: float) -> None:
    """Raise TegotaeError for a robot that sank too far [l0] or touches the ground elsewhere."""
    stiffer = "give it stiffer servos, --settings servo_nm_per_rad=K, or another start"
    if sank > _COLLAPSES:
        raise TegotaeError(
            f"the robot collapses: under its weight it sinks by {sank:.2g} l0; {stiffer}"
        )
    pairs = [(int(contact.geom1), int(contact.geom2)) for contact in data.contact]
    fixed = np.flatnonzero(model.geom_bodyid == 0)
    touching = {geom for pair in pairs if set(pair) & {*fixed} for geom in pair} - {*fixed, *geoms}
    if touching:
        body = model.body(int(model.geom_bodyid[min(touching)])).name
        raise TegotaeError(f"the robot comes to rest on {body}, and not on its feet; {stiffer}")


def _friction(data: MjData, geoms: Sequence[int]) -> float:
    """Return the mean of the feet's contacts; one without sliding friction counts as 0."""
    contacts = [
        float(contact.friction[0]) if contact.dim > 1 else 0.0
        for contact in data.contact
        if {int(contact.geom1), int(contact.geom2)} & {*geoms}
    ]
    if not contacts:
        raise TegotaeError("the robot does not stand on its feet; check its servos and its start")
    return float(np.mean(contacts))
