"""A simulated leg whose numbers nobody is given: it writes a log, and takes commands.

    python -m research.robots.hidden_leg log.csv

The physics are written here once more, in plain Python with steps of 0.1 ms, so that nothing of
tegotae's own simulation is in the log.
"""

from __future__ import annotations

import csv
import math
import random
import sys
from collections import deque
from pathlib import Path

STEPS_PER_TICK = 50
TICK_S = 0.005
GRAVITY_M_PER_S2 = 9.81


class HiddenLeg:
    """A mass on a leg, sensors that are late and noisy, and an actuator with a limit.

    Args:
        mass_kg, stiffness_n_per_m, damping_ns_per_m, rest_length_m, max_force_n: of the body.
        delay_s: how late the sensors are, a multiple of 0.1 ms.
        noise: standard deviation of the sensors, as a share of the weight and of the rest length.
        seed: of the noise and of the pushes.
    """

    def __init__(
        self,
        mass_kg: float = 1.7,
        stiffness_n_per_m: float = 310.0,
        damping_ns_per_m: float = 5.5,
        rest_length_m: float = 0.42,
        max_force_n: float = 62.0,
        delay_s: float = 0.0083,
        noise: float = 0.03,
        seed: int = 0,
    ) -> None:
        self.m, self.k, self.c = mass_kg, stiffness_n_per_m, damping_ns_per_m
        self.l0, self.limit = rest_length_m, max_force_n
        self.noise, self.random = noise, random.Random(seed)
        self.y, self.v = 1.25 * rest_length_m, 0.0
        late = round(delay_s / TICK_S * STEPS_PER_TICK)
        self.past = deque([self.y] * (late + 1), late + 1)

    def sense(self) -> tuple[float, float]:
        """Return height [m] and load [N], late and noisy."""
        y, weight = self.past[0], self.m * GRAVITY_M_PER_S2
        load = self.k * max(self.l0 - y, 0.0)
        normal = self.random.gauss
        return y + normal(0, self.noise * self.l0), load + normal(0, self.noise * weight)

    def push(self, share: float) -> None:
        """Hold a command, a share of the largest force, over a tick of 5 ms."""
        force, step = min(max(share, 0.0), 1.0) * self.limit, TICK_S / STEPS_PER_TICK
        for _ in range(STEPS_PER_TICK):
            middle = self.v + 0.5 * step * self._acceleration(self.y, self.v, force)
            a = self._acceleration(self.y + 0.5 * step * self.v, middle, force)
            self.y, self.v = self.y + step * middle, self.v + step * a
            self.past.append(self.y)

    def _acceleration(self, y: float, v: float, force: float) -> float:
        if y >= self.l0:
            return -GRAVITY_M_PER_S2
        return (self.k * (self.l0 - y) - self.c * v + force) / self.m - GRAVITY_M_PER_S2

    def log(self, file: Path, seconds: float) -> None:
        """Hop for a while by a simple rule, and write the log of the sensors.

        The rule pushes while the load falls, by another share in every hop, and harder after a hop
        that is lower than the release.
        """
        weight = self.m * GRAVITY_M_PER_S2
        smooth, previous, share, base_share = 0.0, 0.0, 0.3, 0.3
        release = apex = self.y
        with file.open("w", newline="") as out:
            rows = csv.writer(out)
            rows.writerow(["time_s", "height_m", "spring_force_n", "command_share"])
            for tick in range(round(seconds / TICK_S)):
                height, load = self.sense()
                previous, smooth = smooth, smooth + 0.3 * (load - smooth)
                if previous < 0.3 * weight <= smooth:  # it has landed
                    base_share = min(max(base_share * (1.1 if apex < release else 0.9), 0.05), 0.6)
                    share, apex = base_share * self.random.uniform(0.4, 1.6), 0.0
                apex = max(apex, height)
                command = share if smooth >= 0.3 * weight and smooth < previous else 0.0
                rows.writerow(
                    [f"{tick * TICK_S:.3f}", f"{height:.6g}", f"{load:.6g}", f"{command:.4g}"]
                )
                self.push(command)
                if not (math.isfinite(self.y) and self.y > 0.0):
                    raise SystemExit(f"the leg broke after {tick * TICK_S:.2f} s")


if __name__ == "__main__":
    HiddenLeg().log(Path(sys.argv[1]), 60.0)
