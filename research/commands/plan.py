"""Plan of Go1's race under commands: the laws that are tuned, the searches, the choice of one, and
the episodes that judge all beside a public policy."""

from __future__ import annotations

from pathlib import Path

from tegotae_robots.benchmark.commanded import COMMANDS
from tegotae_robots.benchmark.conditions import CONDITIONS

FOLDER = Path(__file__).parent
"""Place of the page, its tables and the laws."""
ROBOT = FOLDER.parents[1] / "examples" / "wirings" / "go1-commands.toml"
"""Robot of the laws: Go1 with servos of 100 N m/rad and 1.5 N m s/rad, in a wide stance."""
POLICY = Path("go1_policy.onnx")
"""Joystick policy of MuJoCo Playground (Apache-2.0): its file `sim2sim/onnx/go1_policy.onnx`."""
POLICY_PERIOD_S, AWAY_PERIOD_S = 0.02, 0.008
"""Control period of the policy, and that of a law on its model; the model's time step is 4 ms."""
POLICY_MODEL = "mujoco_playground:_src/locomotion/go1/xmls/go1_mjx_fullcollisions.xml"
"""Model of Go1 on which the policy was trained: servos of 35 N m/rad, joints of 0.5 N m s/rad."""

START = {
    "omega": (17.0, 1.5),
    "sigma": (1.7, 0.4),
    "lift_m": (0.18, 0.03),
    "ahead_m": (-0.16, 0.04),
    "raise_m": (-0.2, 0.04),
    "press_m": (0.08, 0.02),
    "calibration": (0.22, 0.08),
    "roll_m": (0.0, 0.08),
    "roll_rate_ms": (0.06, 0.03),
    "pitch_m": (0.4, 0.12),
    "pitch_rate_ms": (0.1, 0.04),
    "forward_s": (-0.3, 0.1),
    "left_s": (-0.1, 0.1),
    "lag_per_s": (0.2, 0.08),
}
"""Mean and standard deviation of the first candidates: ω [rad/s], others in units of the robot.
They were set by hand in trials of 6 s from starts that judge nothing."""
CLOCK = tuple(START)[:7]
"""Numbers of the open-loop trot, which gets its commands in place of leg odometry."""
LEVELLED = tuple(START)[:11]
"""Numbers of the trot with levelling, likewise without odometry."""
AWAY_START = {"press_m": (0.2, 0.05)}
"""Numbers of the law that is tuned on the policy's model, whose servos yield more."""

Command = tuple[float, float, float]
"""Forward, left [m/s] and yaw rate [rad/s]."""
TRAINED: tuple[tuple[str, tuple[Command, ...]], ...] = (
    (
        "undisturbed",
        (*((v, 0.0, 0.0) for v in (0.3, 1.2, 2.5, -0.6)), (0.0, 0.4, 0.0)),
    ),
    ("push 1.5 m/s", ((1.8, 0.0, 0.0),)),
    ("payload 5 kg", ((2.5, 0.0, 0.0),)),
    ("rough 4 cm", ((0.6, 0.0, 0.0), (1.8, 0.0, 0.0))),
    ("stairs 5 cm", ((1.2, 0.0, 0.0),)),
    ("delay 40 ms", ((1.2, 0.0, 0.0),)),
    ("friction 0.25", ((1.8, 0.0, 0.0),)),
)
"""Conditions of a search, and the commands under each."""
TRAINED_S = 6.5
"""Duration of an episode of a search [s]; a push is at 5 s."""
POPULATION, GENERATIONS = 12, 8
"""Size of CMA-ES: 1152 episodes a search, one start a generation. All searches have this size."""
SEARCHES = 3
"""Searches of the law, each with a seed of its own; of each other controller there is one."""
PRICE, SPEED, HEADING = 0.2, 1.0, 0.3
"""Weights of the cost of transport, at most 4, and of the errors of displacement and heading, at
most 1, in the fitness of an episode without a fall, 1 less all of these. With a fall it is the
share of the time until then, less 1."""
CHOICE_STARTS = (301, 302)
"""Seeds of the starts by which one of the laws is chosen: that whose error of displacement under
the conditions of the search is least, a fall counting 1."""

RACE = list(CONDITIONS)
"""Conditions of the race, nineteen."""
RACED = COMMANDS
"""Commands of the race."""
STARTS = (8201, 8202, 8203, 8204)
"""Seeds of starts, and of the ground, that no search and no choice met, nor a race before."""
FEW = STARTS[:2]
"""Starts of the laws that were not chosen, and of the law on the policy's model; all others have
all. The trots were planned with these two; when the rows of one were seen, both got all."""
SECONDS = 10.0
"""Duration of an episode that judges [s]."""
PUSHED_S = 5.0
"""Time of a push to the left [s]."""
