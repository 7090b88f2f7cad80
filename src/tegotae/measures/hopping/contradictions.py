"""Whether hops, climbs and spectrum of a recording say the same of it."""

from __future__ import annotations

import numpy as np

from tegotae.measures.hopping.hopping import Hops
from tegotae.simulation.rollout import Trajectory

_HOPS = 0.25  # of the swings; less is what hops of several heights make of a spectrum
_CLIMB = 0.1  # of the climb; less is what samples far apart cost
_BOUNCE = 0.01  # of the rest length a hop, which bounces that are no hops may climb


def contradictions(
    frames: Trajectory, table: Hops, span: tuple[int, int], rest_length_m: float
) -> tuple[str, ...]:
    """A sentence on every two measurements of the same that disagree, as noise makes them do.

    From one apex to another, the height's spectrum shows how often the body swings, which is once
    a hop, or once in a few hops of different heights; and the apexes show how much was climbed in
    flight.

    Args:
        frames: the recording, [frames, 1].
        table: its hops, [hops].
        span: rows of the first and last of them.
        rest_length_m: rest length of the leg l0 [m].
    """
    first, last = (int(table.frame[row]) for row in span)
    hops = span[1] - span[0]
    found = []
    swings = _swings(frames.height_m[first : last + 1, 0])
    times = max(1.0, np.round(hops / swings)) if swings else 1.0
    if abs(hops - times * swings) > max(1.0, _HOPS * times * swings):
        found.append(
            f"hops and spectrum contradict each other: {hops} hops, while the height swings "
            f"{swings:.3g} times"
        )
    apexes = slice(span[0] + 1, span[1] + 1)
    over_ground = table.height_m[apexes] - frames.ground_m[table.frame[apexes], 0]
    by_hops = float(np.sum(over_ground - rest_length_m))
    climbed = float(frames.climb_flight_m[last, 0] - frames.climb_flight_m[first, 0])
    if abs(climbed - by_hops) > _CLIMB * by_hops + _BOUNCE * rest_length_m * hops:
        found.append(
            f"hops and climb contradict each other: {climbed:.3g} m climbed in flight, while the "
            f"apexes of {hops} hops rise {by_hops:.3g} m over the rest length"
        )
    if found:
        found.append(
            "noise, bounces too low to be hops, a wrong rest length or a wrong unit do that: look "
            "at --plot, or set --lowpass"
        )
    return tuple(found)


def _swings(height_m: np.ndarray) -> float:
    """How many periods of its strongest frequency a height holds."""
    still = height_m - height_m.mean()
    power = np.abs(np.fft.rfft(np.hanning(len(still)) * still, 8 * len(still))) ** 2
    return float(np.argmax(power)) / 8.0
