"""Entries of the benchmark as functions from observation to action, in SI units."""

import numpy as np


def rebound(observed: np.ndarray) -> np.ndarray:
    """Apply full force while the leg is loaded and extends (hopper, load and IMU)."""
    load, velocity = observed
    return np.array([4.0 if load > 0.0 and velocity > 0.0 else 0.0])


class Rebound:
    """Hopper, load: full force while the load, which it remembers, falls."""

    def __init__(self) -> None:
        self.before = 0.0

    def __call__(self, observed: np.ndarray) -> np.ndarray:
        """Return the force [N]."""
        load, previous = observed[0], self.before
        self.before = load
        return np.array([4.0 if 0.0 < load < previous else 0.0])


class Trot:
    """Quadruped, load: legs on a diagonal go round half ellipses by a clock, and nothing is sensed.

    The clock's frequency is that at which a foot crosses its stride at the wanted speed.
    """

    OMEGA, STEP_S = 2.0, 0.008
    PHASE_RAD = np.pi * np.array([0.0, 1.0, 1.0, 0.0])

    def __init__(self) -> None:
        self.phase = self.PHASE_RAD.copy()

    def __call__(self, observed: np.ndarray) -> np.ndarray:
        """Return the places of the feet, forward and then up [m]."""
        self.phase = self.phase + self.OMEGA * self.STEP_S
        up = np.sin(self.phase)
        ahead = -0.2 * np.cos(self.phase)
        return np.concatenate([ahead, np.where(up > 0.0, 0.12, 0.03) * up])


class LevelTrot(Trot):
    """Quadruped, load+imu: the same, and a leg is longer where its side is low."""

    def __call__(self, observed: np.ndarray) -> np.ndarray:
        """Return the places of the feet [m]."""
        action = super().__call__(observed)
        side_roll, side_roll_rate = observed[20:24], observed[24:28]
        action[4:] += 0.1 * side_roll + 0.1 * side_roll_rate
        return action


class Go1Trot:
    """Go1, load: thighs swing and calves bend by a clock, and nothing is sensed."""

    OMEGA, STEP_S = 12.0, 0.02
    PHASE_RAD = np.pi * np.array([0.0, 1.0, 1.0, 0.0])

    def __init__(self) -> None:
        self.phase = self.PHASE_RAD.copy()

    def __call__(self, observed: np.ndarray) -> np.ndarray:
        """Return the angles of hip, thigh and calf, leg by leg [rad]."""
        self.phase = self.phase + self.OMEGA * self.STEP_S
        thigh = 0.9 + 0.2 * np.cos(self.phase)
        calf = -1.8 - 0.35 * np.maximum(0.0, np.sin(self.phase))
        return np.stack([np.zeros(4), thigh, calf], axis=1).ravel()
