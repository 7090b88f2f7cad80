"""Conditions under which robots on legs are judged: pushes, ground, senses, loads and motors."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass

import numpy as np

from tegotae._support.errors import require
from tegotae.envs._types import MjModel, MjSpec
from tegotae.envs.mujoco.sensing import scale_model, sensing
from tegotae.envs.mujoco.settings import ModelSettings
from tegotae.parts.parameters import Part

FIELD_M = ((-3.0, -3.0), (60.0, 3.0))
"""Two corners of the field of blocks, stairs and rough ground."""
_FREE_M = 0.6
"""Distance from the start within which the ground is level."""
_BLOCKS, _HALF_M = 1500, (0.1, 0.1, 0.25)
"""Number of blocks, and half of their sizes [m]. They reach deep into the ground: soft feet sink 2
cm into it, and out of a block that ends there the nearest way is down."""
_FLIGHT, _TREAD_M = 4, 0.4
"""Steps of a flight of stairs, up and then down, and their depth."""
_CELL_M = 0.2
"""Distance between the heights of rough ground."""
_PAYLOAD_M = (-0.1, 0.05, 0.08)
"""Place of a payload in the trunk: behind, to the left and above its origin."""


@dataclass(frozen=True, kw_only=True)
class RobotCondition(Part):
    """Differences from an undisturbed episode on the unchanged model.

    Args:
        friction: factor of the sliding friction.
        mass: factor of all masses and inertias.
        push_m_per_s: change of speed to the left by a push of 0.1 s at 5 s, to the right at 15 s.
        slope_rad: slope of the ground ahead, up.
        blocks_m: height of blocks of 20 cm x 20 cm on the ground.
        stairs_m: height of steps of 40 cm, four up and four down in turn.
        rough_m: half of the range of heights, drawn every 20 cm.
        delay_s: of all senses.
        noise: of all senses, a share of the mean size of each.
        motor: share of its torque that the last motor of the first leg has.
        payload_kg: mass on the trunk, 10 cm behind and 5 cm to the left of its origin.
        random_phases: whether oscillators begin anywhere.
        finer: whether the simulation's time step is half of the model's.
    """

    friction: float = 1.0
    mass: float = 1.0
    push_m_per_s: float = 0.0
    slope_rad: float = 0.0
    blocks_m: float = 0.0
    stairs_m: float = 0.0
    rough_m: float = 0.0
    delay_s: float = 0.0
    noise: float = 0.0
    motor: float = 1.0
    payload_kg: float = 0.0
    random_phases: bool = False
    finer: bool = False

    @property
    def has_field(self) -> bool:
        """True if the ground differs within `FIELD_M` alone."""
        return bool(self.blocks_m or self.stairs_m or self.rough_m)


TWELVE = {
    "undisturbed": RobotCondition(),
    "friction 0.5": RobotCondition(friction=0.5),
    "mass + 20 %": RobotCondition(mass=1.2),
    "mass - 20 %": RobotCondition(mass=0.8),
    "push 0.5 m/s": RobotCondition(push_m_per_s=0.5),
    "push 1 m/s": RobotCondition(push_m_per_s=1.0),
    "5° up": RobotCondition(slope_rad=math.radians(5)),
    "5° down": RobotCondition(slope_rad=-math.radians(5)),
    "blocks 2 cm": RobotCondition(blocks_m=0.02),
    "blocks 4 cm": RobotCondition(blocks_m=0.04),
    "delay 20 ms": RobotCondition(delay_s=0.02),
    "noise 10 %": RobotCondition(noise=0.1),
}
CONDITIONS = TWELVE | {
    "push 1.5 m/s": RobotCondition(push_m_per_s=1.5),
    "stairs 5 cm": RobotCondition(stairs_m=0.05),
    "rough 4 cm": RobotCondition(rough_m=0.04),
    "motor at half": RobotCondition(motor=0.5),
    "delay 40 ms": RobotCondition(delay_s=0.04),
    "payload 5 kg": RobotCondition(payload_kg=5.0),
    "friction 0.25": RobotCondition(friction=0.25),
}
"""Conditions by name: the twelve, and seven harder ones."""


@dataclass(frozen=True, kw_only=True)
class ModelUnderCondition(ModelSettings):
    """A model under a condition of the ground or its load, which a layout draws."""

    condition: RobotCondition = RobotCondition()
    layout: int = 0

    def spec(self) -> MjSpec:
        """Return the `MjSpec`."""
        spec, condition = super().spec(), self.condition
        spec.option.timestep *= 0.5 if condition.finer else 1.0
        draw = np.random.default_rng([37, self.layout])
        if condition.blocks_m:
            places = draw.uniform(*FIELD_M, (2 * _BLOCKS, 2))
            free = places[np.hypot(*places.T) > _FREE_M]
            for x, y in free[:_BLOCKS]:
                _add_box(spec, (x, y, condition.blocks_m - _HALF_M[2]), _HALF_M)
        if condition.stairs_m:
            _add_stairs(spec, condition.stairs_m)
        if condition.rough_m:
            _add_rough_ground(spec, condition.rough_m, draw)
        if condition.payload_kg:
            trunk = next(body for body in spec.bodies if body.name != "world")
            sphere = require("mujoco", "mujoco").mjtGeom.mjGEOM_SPHERE
            load = trunk.add_body(pos=_PAYLOAD_M)
            options = {"contype": 0, "conaffinity": 0, "mass": condition.payload_kg}
            load.add_geom(type=sphere, size=[0.05, 0.0, 0.0], **options)
        return spec


def _add_box(spec: MjSpec, place: tuple[float, ...], half: tuple[float, ...]) -> None:
    box = require("mujoco", "mujoco").mjtGeom.mjGEOM_BOX
    spec.worldbody.add_geom(type=box, size=half, pos=[*place])


def _add_stairs(spec: MjSpec, height_m: float) -> None:
    """Add flights of stairs across the field, up and down in turn, from a metre ahead on."""
    (_, y0), (far, y1) = FIELD_M
    for k in range(int((far - 1.0) / _TREAD_M)):
        turn = k % (2 * _FLIGHT)
        level = turn + 1 if turn < _FLIGHT else 2 * _FLIGHT - turn - 1
        if level:
            half = 0.5 * level * height_m
            place = 1.0 + (k + 0.5) * _TREAD_M, 0.5 * (y0 + y1), half
            _add_box(spec, place, (0.5 * _TREAD_M, 0.5 * (y1 - y0), half))


def _add_rough_ground(spec: MjSpec, half_m: float, draw: np.random.Generator) -> None:
    """Add heights from 0 to twice `half_m`; around the start it is level."""
    (back, y0), (far, y1) = FIELD_M
    x = np.arange(back, far + 1e-9, _CELL_M)
    y = np.arange(y0, y1 + 1e-9, _CELL_M)
    share = draw.uniform(size=(len(y), len(x)))
    share[np.hypot(*np.meshgrid(x, y)) < _FREE_M] = 0.0
    half = 0.5 * (far - back), 0.5 * (y1 - y0)
    spec.add_hfield(
        name="tegotae/rough",
        nrow=len(y),
        ncol=len(x),
        size=[*half, 2.0 * half_m / share.max(), 0.5],
        userdata=share.ravel(),
    )
    kind = require("mujoco", "mujoco").mjtGeom.mjGEOM_HFIELD
    middle = [0.5 * (far + back), 0.5 * (y0 + y1), 0.0]
    spec.worldbody.add_geom(type=kind, hfieldname="tegotae/rough", pos=middle)


def model_of(
    condition: RobotCondition, settings: ModelSettings, layout: int = 0
) -> tuple[ModelSettings, MjModel]:
    """Return the settings and the model of a robot under a condition.

    Args:
        condition: of the episode.
        settings: of the robot.
        layout: seed of blocks or rough ground.
    """
    fields = {field.name: getattr(settings, field.name) for field in dataclasses.fields(settings)}
    settings = ModelUnderCondition(**fields, condition=condition, layout=layout)
    sensed = sensing(settings)
    model = sensed.model
    scale_model(model, condition.mass, condition.friction)
    if condition.motor != 1.0:
        weak = int(sensed.driven[len(sensed.driven) // max(1, len(sensed.feet)) - 1])
        model.actuator_gainprm[weak] *= condition.motor
        model.actuator_biasprm[weak] *= condition.motor
        model.actuator_forcerange[weak] *= condition.motor
    g = float(np.linalg.norm(model.opt.gravity))
    slope = condition.slope_rad
    model.opt.gravity[:] = g * np.array([-math.sin(slope), 0.0, -math.cos(slope)])
    return settings, model
