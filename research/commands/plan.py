"""Plan of Go1's walk under commands: the law that is tuned, the search, and the episodes that judge
it."""

from __future__ import annotations

from pathlib import Path

from research.go1.plan import Condition

FOLDER = Path(__file__).parent
"""Place of the page, its tables and the law."""
LAW = FOLDER / "raibert.json"
"""Tuned law."""
OMEGA_RAD_PER_S = 14.7
"""Frequency of stepping on the spot before the search; it is tuned, too."""
START = {
    "sigma": 2.5,
    "lift_m": 0.26,
    "ahead_m": -0.1,
    "raise_m": 0.0,
    "roll_m": 0.0,
    "roll_rate_ms": 0.07,
    "pitch_m": 0.3,
    "pitch_rate_ms": 0.14,
    "forward_s": 0.26,
    "left_s": 0.3,
    "lag_per_s": 0.16,
}
"""Weights before the search, in units of the robot: l0 = 0.265 m, √(l0 / g) = 0.164 s."""
SCALES = {
    "sigma": 0.5,
    "lift_m": 0.05,
    "ahead_m": 0.05,
    "raise_m": 0.05,
    "roll_m": 0.1,
    "roll_rate_ms": 0.05,
    "pitch_m": 0.1,
    "pitch_rate_ms": 0.05,
    "forward_s": 0.2,
    "left_s": 0.2,
    "lag_per_s": 0.1,
}
"""Standard deviation of the first candidates; that of the frequency is a tenth of it."""

Command = tuple[float, float, float]
"""Forward, left [m/s] and yaw rate [rad/s]."""

TRAINED: tuple[tuple[Condition, tuple[Command, ...]], ...] = (
    (
        Condition(),
        ((1.8, 0.0, 0.0), (2.5, 0.0, 0.0), (-0.6, 0.0, 0.0), (0.0, 0.4, 0.0), (0.6, 0.0, 0.8)),
    ),
    (Condition(push_m_per_s=1.5), ((0.6, 0.0, 0.0), (1.2, 0.0, 0.0), (0.0, 0.0, 1.0))),
    (Condition(blocks_m=0.04), ((0.6, 0.0, 0.0), (1.8, 0.0, 0.0))),
    (Condition(delay_s=0.02), ((1.2, 0.0, 0.0),)),
)
"""Conditions of the search, and the commands under each."""
TRAINED_S = 7.0
"""Duration of an episode of the search [s]; a push is at 5 s."""
POPULATION, GENERATIONS = 12, 24
"""Size of CMA-ES: 3168 episodes of 7 s, one start a generation."""
PRICE = 0.05
"""Weight of the cost of transport in the fitness, at most 4."""

COMMANDS: dict[str, Command] = {
    "stop": (0.0, 0.0, 0.0),
    **{f"forward {v:g}": (v, 0.0, 0.0) for v in (0.3, 0.6, 1.2, 1.8, 2.5)},
    "back 0.6": (-0.6, 0.0, 0.0),
    "left 0.4": (0.0, 0.4, 0.0),
    "right 0.4": (0.0, -0.4, 0.0),
    "turn on the spot 1": (0.0, 0.0, 1.0),
    "turn right on the spot 1": (0.0, 0.0, -1.0),
    "curve 0.6, 0.8": (0.6, 0.0, 0.8),
    "aslant 0.4, 0.3": (0.4, 0.3, 0.0),
}
"""Commands that judge the law [m/s, rad/s]."""
CONDITIONS = {
    "undisturbed": Condition(),
    "push 1 m/s": Condition(push_m_per_s=1.0),
    "push 1.5 m/s": Condition(push_m_per_s=1.5),
    "mass + 20 %": Condition(mass=1.2),
    "friction 0.5": Condition(friction=0.5),
    "blocks 2 cm": Condition(blocks_m=0.02),
    "blocks 4 cm": Condition(blocks_m=0.04),
    "delay 20 ms": Condition(delay_s=0.02),
    "noise 10 %": Condition(noise=0.1),
}
"""Conditions that judge the law."""
STARTS = (8001, 8002, 8003)
"""Seeds of starts, and of blocks, that the search did not meet."""
SECONDS = 20.0
"""Duration of an episode that judges [s]."""
