"""A robot on prismatic legs, at any size, as MJCF, whose template is known in advance."""

import math

G = 9.81
HIPS = ((0.7, 0.4), (0.7, -0.4), (-0.7, 0.4), (-0.7, -0.4))
"""Places of the hips over the length of a leg."""
FOOT = 0.002
"""Mass of a foot over that of the robot; the trunk has the rest."""
CENTRE = (0.05, 0.0, -0.2)
"""Centre of mass of the trunk, from the middle of the hips, over the length of a leg."""
INERTIA = (0.10, 0.25, 0.30)
"""Inertia of the trunk, over mass and squared length."""
STIFFNESS = (6.0, 4.0, 10.0)
"""Stiffness of a leg at its foot, over m g / l0."""
DAMPING = (0.6, 0.4, 0.9)
"""Over m √(g / l0)."""
FRICTION = 0.7

LEG = """
      <body name="foot{i}" pos="{x} {y} 0">
        <joint name="roll{i}" type="hinge" axis="1 0 0" damping="{d[1]}"/>
        <joint name="pitch{i}" type="hinge" axis="0 1 0" damping="{d[0]}"/>
        <joint name="slide{i}" type="slide" axis="0 0 1" damping="{d[2]}"/>
        <inertial pos="0 0 {foot}" mass="{mass}" diaginertia="{tiny} {tiny} {tiny}"/>
        <geom type="sphere" size="{radius}" pos="0 0 {foot}" contype="1" conaffinity="2"/>
      </body>"""
SERVOS = """
    <position name="roll{i}" joint="roll{i}" kp="{k[1]}"/>
    <position name="pitch{i}" joint="pitch{i}" kp="{k[0]}"/>
    <position name="slide{i}" joint="slide{i}" kp="{k[2]}" forcerange="-{push} {push}"/>"""


def sprung_robot(length_m: float = 1.0, mass_kg: float = 1.0, push: float = 2.0) -> str:
    """The robot's MJCF; all of it scales with the two numbers.

    Args:
        length_m: of a leg.
        mass_kg: of all.
        push: largest force of a leg, over the weight.
    """
    second = math.sqrt(length_m / G)
    radius = 0.01 * length_m
    lever = length_m**2  # a hinge's stiffness, over that which the foot feels
    k = [s * mass_kg * G / length_m for s in STIFFNESS]
    d = [s * mass_kg / second for s in DAMPING]
    shared = {
        "k": (lever * k[0], lever * k[1], k[2]),
        "d": (lever * d[0], lever * d[1], d[2]),
        "foot": radius - length_m,
        "mass": FOOT * mass_kg,
        "tiny": 1e-6 * mass_kg * lever,
        "radius": radius,
        "push": push * mass_kg * G,
    }
    places = [(i, length_m * x, length_m * y) for i, (x, y) in enumerate(HIPS)]
    legs = "".join(LEG.format(i=i, x=x, y=y, **shared) for i, x, y in places)
    servos = "".join(SERVOS.format(i=i, **shared) for i, _, _ in places)
    centre = " ".join(str(length_m * x) for x in CENTRE)
    inertia = " ".join(str(mass_kg * lever * x) for x in INERTIA)
    return f"""<mujoco>
  <option timestep="{0.002 * second}" gravity="0 0 -{G}" integrator="implicitfast" cone="elliptic"
    impratio="10"/>
  <default><geom friction="{FRICTION} 0 0" solref="{0.01 * second} 1" solimp="0.95 0.99 0.001"/>
  </default>
  <worldbody>
    <geom name="ground" type="plane" size="0 0 1" contype="2" conaffinity="1"/>
    <body name="trunk" pos="0 0 {1.2 * length_m}">
      <freejoint/>
      <inertial pos="{centre}" mass="{(1.0 - 4.0 * FOOT) * mass_kg}" diaginertia="{inertia}"/>{legs}
    </body>
  </worldbody>
  <actuator>{servos}
  </actuator>
</mujoco>"""
