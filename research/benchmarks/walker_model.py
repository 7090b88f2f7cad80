"""The walking torso as a MuJoCo model, its feet on springs: a quadruped, if it has four legs.

The torso is the engine's. What differs is the foot: a small mass on three springs, which meets the
ground by MuJoCo's soft contact. It leaves the ground when its spring lets go, where the walker's
leaves when the commanded foot rises.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from tegotae.parts.bodies import Walker

MOTORS, SERVOS = "motors", "servos"
"""Actuators of the feet: forces, or springs about commanded positions."""
REACH = 0.5
"""Largest commanded distance of a foot from its rest position, as a share of the leg's length."""


@dataclass(frozen=True, kw_only=True)
class Settings:
    """Numbers of the MuJoCo model, in units of the walker's mass, length and √(l0/g).

    The values are those at which gait, speed and height no longer change with any of them.
    """

    tick: float = 0.005
    """Time step. At 0.01 the walk is a tenth slower, at 0.02 it is another gait."""
    foot_mass: float = 0.005
    """Mass of a foot. 0.002 to 0.01 make no difference; at 0.05 the walk changes."""
    foot_radius: float = 0.01
    """Radius of a foot; makes no difference up to 0.05."""
    contact_ticks: float = 2.0
    """Time constant of the contact (solref) in time steps, at least 2. At 10 the trot is a third
    slower."""
    impedance: tuple[float, float, float] = (0.95, 0.99, 0.001)
    """The contact's impedance (solimp)."""
    impratio: float = 10.0
    """Ratio of the contact's tangential stiffness to its normal one."""
    cone: str = "elliptic"
    """Shape of the friction cone. A pyramid lets feet slip by direction."""


def description(body: Walker, settings: Settings | None = None, actuators: str = MOTORS) -> str:
    """Return the model in MuJoCo's language: torso, feet on three slides each, actuated along x and
    z.

    Springs and dampers are those of the joints; a joint's damper MuJoCo integrates implicitly. A
    motor adds K c + D ċ for the command c, so that they work about the commanded foot. A position
    servo is itself the spring about its command.

    Args:
        body: the walker, on flat ground.
        settings: MuJoCo's.
        actuators: `MOTORS`, or `SERVOS` that are commanded the foot's place [m].
    """
    settings = settings or Settings()
    length, mass = body.rest_length_m, body.mass_kg
    second = (length / body.gravity_m_per_s2) ** 0.5
    stiffness = body.stiffness_x_n_per_m, body.stiffness_y_n_per_m, body.stiffness_z_n_per_m
    damping = body.damping_xy_ns_per_m, body.damping_xy_ns_per_m, body.damping_z_ns_per_m
    foot_mass, radius = settings.foot_mass * mass, settings.foot_radius * length
    feet, motors = [], []
    for leg, (x, y) in enumerate(zip(body.hips_x_m, body.hips_y_m, strict=True)):
        slides = "".join(
            f'<joint name="{name}{leg}" type="slide" axis="{axis}" damping="{c}" '
            f'stiffness="{0.0 if actuators == SERVOS and name != "y" else k}"/>'
            for name, axis, k, c in zip(
                "xyz", ("1 0 0", "0 1 0", "0 0 1"), stiffness, damping, strict=True
            )
        )
        feet.append(
            f'<body name="foot{leg}" pos="{x - body.com_x_m} {y} {-body.com_z_m - length}">{slides}'
            f'<inertial pos="0 0 0" mass="{foot_mass}" diaginertia="1e-9 1e-9 1e-9"/>'
            f'<geom type="sphere" size="{radius}" pos="0 0 {radius}"'
            ' contype="1" conaffinity="2"/></body>'
        )
        for name, k in (("x", stiffness[0]), ("z", stiffness[2])):
            servo = f'<position name="{name}{leg}" joint="{name}{leg}" kp="{k}" '
            servo += f'ctrlrange="{-REACH * length} {REACH * length}"/>'
            motors.append(servo if actuators == SERVOS else f'<motor joint="{name}{leg}"/>')
    tick = settings.tick * second
    inertia = f"{body.inertia_x_kg_m2} {body.inertia_y_kg_m2} {body.inertia_z_kg_m2}"
    return f"""<mujoco model="quadruped">
  <option timestep="{tick}" gravity="0 0 {-body.gravity_m_per_s2}" integrator="implicitfast"
    cone="{settings.cone}" impratio="{settings.impratio}"/>
  <default>
    <geom condim="3" friction="{body.friction} 0 0" solref="{settings.contact_ticks * tick} 1"
      solimp="{" ".join(map(str, settings.impedance))}"/>
  </default>
  <worldbody>
    <geom type="plane" size="0 0 1" contype="2" conaffinity="1"/>
    <body name="torso" pos="0 0 {length + body.com_z_m}">
      <freejoint/>
      <inertial pos="0 0 0" mass="{mass - len(feet) * foot_mass}" diaginertia="{inertia}"/>
      {"".join(feet)}
    </body>
  </worldbody>
  <actuator>{"".join(motors)}</actuator>
</mujoco>"""


def small_robot(length_m: float = 0.2, mass_kg: float = 1.5) -> Walker:
    """Return set C of the walkers at the size of a small robot, in SI units.

    Example:
        >>> robot = small_robot()
        >>> robot.gravity_m_per_s2, round(robot.stiffness_z_n_per_m)
        (9.81, 1030)
    """
    standard, gravity = Walker(), 9.81
    second = math.sqrt(length_m / gravity)
    per_m, per_speed = mass_kg / second**2, mass_kg / second
    turn = mass_kg * length_m**2
    return Walker(
        hips_x_m=tuple(length_m * x for x in standard.hips_x_m),
        hips_y_m=tuple(length_m * y for y in standard.hips_y_m),
        com_z_m=length_m * standard.com_z_m,
        mass_kg=mass_kg,
        inertia_x_kg_m2=turn * standard.inertia_x_kg_m2,
        inertia_y_kg_m2=turn * standard.inertia_y_kg_m2,
        inertia_z_kg_m2=turn * standard.inertia_z_kg_m2,
        stiffness_x_n_per_m=per_m * standard.stiffness_x_n_per_m,
        stiffness_y_n_per_m=per_m * standard.stiffness_y_n_per_m,
        stiffness_z_n_per_m=per_m * standard.stiffness_z_n_per_m,
        damping_xy_ns_per_m=per_speed * standard.damping_xy_ns_per_m,
        damping_z_ns_per_m=per_speed * standard.damping_z_ns_per_m,
        rest_length_m=length_m,
        gravity_m_per_s2=gravity,
    )


def mjcf() -> str:
    """Return the small robot, commanded by the places of its feet."""
    return description(small_robot(), actuators=SERVOS)
