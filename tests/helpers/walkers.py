"""The walkers of `walker_oracle` as the package has them, for tests and studies."""

import dataclasses
from dataclasses import dataclass

import numpy as np

from tegotae import Controller, Rollout, Scenario, Timing
from tegotae.parts.bodies import Walker
from tegotae.parts.terms import EllipticFoot
from tegotae.systems.recipe import recipe
from walker_oracle import Parts


@dataclass(frozen=True)
class Seen:
    """Recording for comparison with the oracle: the whole rollout, of these channels alone."""

    needs = (
        *("time_s", "x_m", "y_m", "height_m", "roll_rad", "pitch_rad", "yaw_rad", "phase_rad"),
        *("spring_force_n", "slid_m", "work_positive_j", "work_absolute_j", "energy_j"),
    )

    def __call__(self, trajectory, scenario, body, timing):
        return {name: getattr(trajectory, name) for name in self.needs}


def controller_of(parts: Parts) -> Controller:
    """Vanilla Tegotae, a unit a leg; its weight is σ."""
    foot = EllipticFoot(parts.stride, parts.lift, parts.press, parts.shift)
    return dataclasses.replace(
        recipe("V-sector-w8").controller(), limbs=len(parts.hips), actuation=foot
    )


def body_of(parts: Parts, kind: type[Walker] = Walker) -> Walker:
    """The body."""
    hips_x, hips_y = zip(*parts.hips, strict=True)
    inertia, stiffness = parts.inertia, parts.stiffness
    return kind(
        hips_x_m=hips_x,
        hips_y_m=hips_y,
        com_x_m=parts.com_x,
        com_z_m=parts.com_z,
        inertia_x_kg_m2=inertia[0],
        inertia_y_kg_m2=inertia[1],
        inertia_z_kg_m2=inertia[2],
        stiffness_x_n_per_m=stiffness[0],
        stiffness_y_n_per_m=stiffness[1],
        stiffness_z_n_per_m=stiffness[2],
        damping_xy_ns_per_m=parts.damping[0],
        damping_z_ns_per_m=parts.damping[2],
        friction=parts.friction,
    )


def run(
    parts: Parts, omega, phases, timing: Timing, kind: type[Walker] = Walker
) -> dict[str, np.ndarray]:
    """Channels of walks let go over legs of full length; phases [legs, lanes], float64."""
    start = Scenario(omega=omega, height_m=1.0 + parts.com_z, phase_rad=np.asarray(phases))
    rollout = Rollout(controller=controller_of(parts), timing=timing, summary=Seen())
    return rollout.run([parts.sigma], start, body_of(parts, kind), dtype="float64")
