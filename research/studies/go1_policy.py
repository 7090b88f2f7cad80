"""A network of PPO on Go1's feet, as NumPy runs it: what it reads, and what its outputs are."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from go1_feet import FEET, Course, DriverOf

Senses = Literal["contacts", "loads", "imu", "all"]
CONTACT_N = 10.0
"""Load above which a foot is in contact: less than a tenth of the weight."""
MIDDLE_RAD_PER_S = 16.0
"""Divisor of commands."""
WANTED_M = 0.0437
"""Wanted speed over ω [m]: that of the tuned clock's stride."""
LENGTH_M, TIME_S = 0.265, 0.1644
"""Units of length and time in the laws: l0 and √(l0 / g)."""
REACH_M = np.tile([0.12, 0.08, 0.08], len(FEET))
"""Range by which the network's ±1 move the feet from the ellipse that all tunings begin with."""
LIFT_M, PRESS_M, SHIFT_RAD = LENGTH_M * 0.2, LENGTH_M * 0.03, 0.4
"""Lift, press and shift of that ellipse; the stride varies."""


@dataclass(frozen=True)
class Pace:
    """Meaning of commands: the stride B (1 - ω0 / ω), and the wanted speed c (ω - ω0).

    Args:
        stride_m: B.
        still_rad_per_s: ω0.
        slope_m: c.
    """

    stride_m: float
    still_rad_per_s: float
    slope_m: float

    def stride_at(self, omega: np.ndarray) -> np.ndarray:
        """Half of the stride [m] at commands [rad/s]."""
        return self.stride_m * (1.0 - self.still_rad_per_s / omega)

    def wanted_m_per_s(self, omega: np.ndarray) -> np.ndarray:
        """The speed that commands [rad/s] mean."""
        return self.slope_m * (omega - self.still_rad_per_s)

    def omega_at(self, speed_m_per_s: np.ndarray) -> np.ndarray:
        """The commands [rad/s] that mean a speed."""
        return self.still_rad_per_s + speed_m_per_s / self.slope_m


@dataclass(frozen=True)
class Between:
    """Meaning of commands whose speed is no straight line over them: measured speeds, interpolated.

    Args:
        omega: commands [rad/s], ascending.
        speed: mean speeds at them [m/s], ascending.
    """

    omega: np.ndarray
    speed: np.ndarray

    def wanted_m_per_s(self, omega: np.ndarray) -> np.ndarray:
        """The speed that commands [rad/s] mean."""
        return np.interp(omega, self.omega, self.speed)

    def omega_at(self, speed_m_per_s: np.ndarray) -> np.ndarray:
        """The commands [rad/s] that mean a speed."""
        return np.interp(speed_m_per_s, self.speed, self.omega)


BEGUN = {"stride_m": 0.7, "still_rad_per_s": 1.97}
"""Initial values of all tunings for a foot whose stride depends on the frequency: it steps on the
spot at 12 rad/s, and reaches 2.5 m/s at 33."""
STEADY = Pace(0.25 * LENGTH_M, 0.0, WANTED_M)
PACED = Pace(
    BEGUN["stride_m"] * LENGTH_M,
    BEGUN["still_rad_per_s"] / TIME_S,
    2.0 * BEGUN["stride_m"] * LENGTH_M / math.pi,
)
TROT_RAD = np.array([0.0, np.pi, np.pi, 0.0])
IMU = {"roll": 0.3, "pitch": 0.3, "yaw": 0.5, "roll_rate": 3.0, "pitch_rate": 3.0, "yaw_rate": 3.0}
"""Divisors of an IMU's readings."""


def places_of(outputs: np.ndarray, phase: np.ndarray, stride_m: np.ndarray) -> np.ndarray:
    """Places of the feet [m] of a network's outputs, [lanes, 12], at the clock's phase and half of
    the stride, [lanes]."""
    angle = phase[:, None] + TROT_RAD
    up = np.where(np.sin(angle) > 0.0, LIFT_M, PRESS_M) * np.sin(angle)
    ahead = -stride_m[:, None] * np.cos(angle + SHIFT_RAD)
    ellipse = np.stack([ahead, np.zeros_like(angle), up], axis=2)
    return ellipse.reshape(len(phase), -1) + REACH_M * np.clip(outputs, -1.0, 1.0)


class Inputs:
    """A network's inputs from observations.

    Args:
        course: of the robot.
        senses: which.
    """

    def __init__(self, course: Course, senses: Senses) -> None:
        scales = {f"{foot}_estimated_force": 60.0 for foot in FEET}
        if senses not in ("contacts", "loads"):
            scales |= {f"root_{name}": scale for name, scale in IMU.items()}
        if senses == "all":
            velocities = [name for name in course.names if name.endswith("_joint_velocity")]
            scales |= dict.fromkeys(velocities, 10.0)
            scales |= {name.removesuffix("_velocity"): 0.5 for name in velocities}
            scales |= {"root_height": 0.1, "root_speed": 1.0, "root_climb": 1.0}
        self.read = [course.names.index(name) for name in scales]
        angles = [name.endswith("_joint") or name == "root_height" for name in scales]
        self._scale, self._angles = np.array(list(scales.values())), np.array(angles)
        self._rest, self._touched = np.zeros(len(scales)), senses == "contacts"
        self.width = 3 + len(scales)

    def begin(self, observation: np.ndarray) -> None:
        """Angles and height are from those at an episode's begin, [entries]."""
        self._rest = np.where(self._angles, observation[self.read], 0.0)

    def __call__(self, felt: np.ndarray, phase: np.ndarray, omega: np.ndarray) -> np.ndarray:
        """[lanes, width]."""
        clock = [np.sin(phase), np.cos(phase), omega / MIDDLE_RAD_PER_S]
        body = (felt[:, self.read] - self._rest) / self._scale
        if self._touched:
            body = felt[:, self.read] > CONTACT_N
        return np.clip(np.column_stack([*clock, body]), -10.0, 10.0).astype(np.float32)


class Policy:
    """A trained actor as a driver, without its noise.

    Args:
        actor: its arrays, as the file has them.
        course: of the robot, begun.
        omega: commands [rad/s], [lanes].
        senses: what it reads.
        pace: what the commands mean.
    """

    def __init__(
        self,
        actor: dict[str, np.ndarray],
        course: Course,
        omega: np.ndarray,
        senses: Senses,
        pace: Pace,
    ) -> None:
        self._actor, self._omega, self._step_s = actor, omega, course.step_s
        self._inputs = Inputs(course, senses)
        self._inputs._rest = actor["rest"]
        self._stride_m = pace.stride_at(omega)
        self._clock = course.phases[0].copy()
        self.phase = self._clock + TROT_RAD[:, None]

    @property
    def read(self) -> list[int]:
        """Return the entries of the observation that the network reads."""
        return self._inputs.read

    def act(self, observed: np.ndarray) -> np.ndarray:
        """The places of the feet [m], [lanes, actions]."""
        x = self._inputs(observed, self._clock, self._omega)
        for k in range(2):
            x = np.tanh(x @ self._actor[f"w{k}"] + self._actor[f"b{k}"])
        outputs = x @ self._actor["w2"] + self._actor["b2"]
        places = places_of(outputs, self._clock, self._stride_m)
        self._clock = self._clock + self._omega * self._step_s
        self.phase = self._clock + TROT_RAD[:, None]
        return places


def by_actor(actor: dict[str, np.ndarray], senses: Senses, pace: Pace) -> DriverOf:
    """Return the driver of all lanes by one actor."""
    return lambda course, omega, _: Policy(actor, course, omega, senses, pace)
