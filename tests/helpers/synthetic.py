"""Recordings of gaits with known answers, for the tests of the metrics."""

from dataclasses import dataclass

import numpy as np

G = 9.81
STANCE_S = 0.4
L0 = 1.0


@dataclass(frozen=True)
class Hopping:
    """A body released at rest at the first apex, which then hops through all the others.

    Flights are ballistic over a touchdown height of 1 m; in between, stances of 0.4 s are cubics
    that meet both flights in height and velocity.
    """

    apex_m: np.ndarray
    """Heights of the apexes over the ground that each flight ends on [m]."""

    @property
    def _half_flight_s(self) -> np.ndarray:
        return np.sqrt(2.0 * (self.apex_m - L0) / G)

    @property
    def apex_s(self) -> np.ndarray:
        """Times of the apexes [s], the release being the first."""
        half = self._half_flight_s
        return np.concatenate([[0.0], np.cumsum(half[:-1] + STANCE_S + half[1:])])

    @property
    def touchdown_s(self) -> np.ndarray:
        """Times of the touchdowns, one after each apex [s]."""
        return self.apex_s + self._half_flight_s

    def height_m(self, time_s: np.ndarray) -> np.ndarray:
        """Heights at the given times [m]; rests at the touchdown height after the last flight."""
        height = np.full_like(time_s, L0)
        for apex, index, half in zip(self.apex_m, self.apex_s, self._half_flight_s, strict=True):
            flies = np.abs(time_s - index) <= half
            height[flies] = apex - 0.5 * G * (time_s[flies] - index) ** 2
        lands, leaves = -G * self._half_flight_s[:-1], G * self._half_flight_s[1:]
        for index, down, up in zip(self.touchdown_s, lands, leaves, strict=False):
            stands = (time_s > index) & (time_s < index + STANCE_S)
            s = (time_s[stands] - index) / STANCE_S
            height[stands] = L0 + STANCE_S * (s * (1 - s) ** 2 * down - s**2 * (1 - s) * up)
        return height

    def phase_rad(self, time_s: np.ndarray, at_apex_rad: np.ndarray) -> np.ndarray:
        """A phase that goes round once per hop and has the given values at the apexes [rad]."""
        turns = 2.0 * np.pi * np.arange(len(self.apex_m))
        return np.interp(time_s, self.apex_s, turns + at_apex_rad)


def seconds(duration_s: float = 20.0, step_s: float = 0.004) -> np.ndarray:
    """Sampling times [s], the end included."""
    return np.arange(round(duration_s / step_s) + 1) * step_s
