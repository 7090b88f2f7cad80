"""Robots on random legs, as MJCF: chains of hinges and slides in any direction, all with servos."""

import numpy as np

_HEAD = """<mujoco><option timestep="0.002"/><worldbody><geom type="plane" size="0 0 1"/>
<body name="trunk" pos="0 0 1.2" euler="{euler}"><freejoint/>
<geom type="box" size=".2 .1 .05" mass="5"/>"""
_LINK = """<body name="{name}" pos="{pos}" euler="{euler}">
<joint name="{name}" {kind} limited="true" pos="{off}"/>
<geom type="capsule" fromto="0 0 0 0 0 {end}" size=".01" mass=".1"/>"""
_SOLE = '<body name="foot{leg}" pos="0 0 {end}"><geom type="sphere" size=".02"/></body>'
_SERVO = '<position name="{name}" joint="{name}" kp="200" gear="{gear:.3g}"/>'


def jointed_robot(seed: int, joints: int, legs: int = 3, slide: bool = False) -> str:
    """A trunk that leans, on legs of so many joints, the last of which may slide.

    Args:
        seed: of all lengths, directions, limits and gears.
        joints: of a leg.
        legs: how many.
        slide: whether a leg's last joint slides.
    """
    draw = np.random.default_rng(seed)
    euler = draw.uniform(-15, 15, 3)
    body, servos = _HEAD.format(euler=_numbers(euler)), ""
    end = -0.6 / joints
    for leg in range(legs):
        for k in range(joints):
            kind = 'type="slide" axis="0 0 1" range="-0.15 0.15"'
            if not (slide and k == joints - 1):
                axis = np.eye(3)[(k + leg) % 2] + draw.uniform(-0.3, 0.3, 3)
                kind = f'type="hinge" axis="{_numbers(axis)}" range="-70 80"'
            body += _LINK.format(
                name=f"leg{leg}_{k}",
                pos=_numbers(draw.uniform(-0.2, 0.2, 3) if k == 0 else [0.0, 0.0, end]),
                euler=_numbers(draw.uniform(-25, 25, 3)),
                kind=kind,
                off=_numbers(draw.uniform(-0.02, 0.02, 3)),
                end=end,
            )
            servos += _SERVO.format(name=f"leg{leg}_{k}", gear=draw.uniform(0.5, 2.0))
        body += _SOLE.format(leg=leg, end=end) + "</body>" * joints
    return f"{body}</body></worldbody><actuator>{servos}</actuator></mujoco>"


def _numbers(values: object) -> str:
    return " ".join(f"{x:.4g}" for x in np.ravel(values))
