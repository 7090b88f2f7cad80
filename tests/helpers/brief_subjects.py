"""The benchmark's subjects in seconds: few starts, one condition, short episodes."""

from dataclasses import dataclass

from tegotae import Timing
from tegotae.measures.objectives.fitness import Fitness
from tegotae.measures.objectives.walking import Walking
from tegotae_robots.benchmark.bodies import HopperSubject, QuadrupedSubject


@dataclass(frozen=True)
class BriefHopper(HopperSubject):
    """Five seconds, alone and under another mass."""

    CONDITIONS = ("mass=1.5",)
    TIMING = Timing(duration_s=5.0, tick_s=0.002)
    OBJECTIVE = Fitness(settle_s=2.0)
    starts: int = 2


@dataclass(frozen=True)
class BriefQuadruped(QuadrupedSubject):
    """Twelve seconds, alone and under another mass."""

    CONDITIONS = ("mass=0.7",)
    TIMING = Timing(duration_s=12.0, tick_s=0.008, frame_s=0.08)
    OBJECTIVE = Walking(speed_m_per_s=0.25, settle_s=4.0)
    starts: int = 2
