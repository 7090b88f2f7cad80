"""Plan of Go1's race under commands: the law that is tuned, the search, and the episodes that judge
it beside a public policy."""

from __future__ import annotations

from pathlib import Path

from tegotae_robots.benchmark.commanded import COMMANDS
from tegotae_robots.benchmark.conditions import CONDITIONS

FOLDER = Path(__file__).parent
"""Place of the page, its tables and the law."""
LAW = FOLDER / "raibert.json"
"""Law that is raced. Its numbers are of an earlier search, in the model's own, narrow stance."""
TUNED_LAW = FOLDER / "tuned.json"
"""Law after another search from there, in the wide stance. It is raced under the same conditions
from the same starts, whatever the search finds."""
POLICY = Path("go1_policy.onnx")
"""Joystick policy of MuJoCo Playground (Apache-2.0): its file `sim2sim/onnx/go1_policy.onnx`."""
POLICY_SERVOS, POLICY_PERIOD_S = (35.0, 0.5), 0.02
"""Servos [N m/rad, N m s/rad] and period of the policy."""
POLICY_MODEL = "mujoco_playground:_src/locomotion/go1/xmls/go1_mjx_fullcollisions.xml"
"""Model of Go1 in whose like the policy was trained."""
LAW_SERVOS = (100.0, 1.0)
"""Servos of the law."""

Command = tuple[float, float, float]
"""Forward, left [m/s] and yaw rate [rad/s]."""
TRAINED: tuple[tuple[str, tuple[Command, ...]], ...] = (
    ("undisturbed", ((2.5, 0.0, 0.0), (0.6, 0.0, 0.0), (0.4, 0.3, 0.0))),
    ("push 1.5 m/s", ((1.2, 0.0, 0.0), (2.5, 0.0, 0.0))),
    ("blocks 4 cm", ((0.6, 0.0, 0.0), (1.8, 0.0, 0.0))),
    ("delay 40 ms", ((1.2, 0.0, 0.0),)),
)
"""Conditions of the search, and the commands under each."""
TRAINED_S = 6.5
"""Duration of an episode of the search [s]; a push is at 5 s."""
POPULATION, GENERATIONS = 12, 9
"""Size of CMA-ES: one run of 864 episodes, one start a generation."""
PRICE, SPEED, HEADING = 0.1, 0.5, 0.3
"""Weights of the cost of transport, at most 4, and of the errors of displacement and heading, at
most 1, in the fitness of an episode without a fall, 1 less all of these."""
SCALES = {
    "sigma": 0.4,
    "lift_m": 0.03,
    "ahead_m": 0.04,
    "raise_m": 0.03,
    "roll_m": 0.05,
    "roll_rate_ms": 0.03,
    "pitch_m": 0.06,
    "pitch_rate_ms": 0.03,
    "forward_s": 0.1,
    "left_s": 0.1,
    "lag_per_s": 0.06,
}
"""Standard deviation of the first candidates; that of the frequency is a twentieth of it."""

RACE = list(CONDITIONS)
"""Conditions of the race, nineteen."""
AWAY = ("undisturbed", "push 1 m/s")
"""Conditions on the servos of the other."""
PLAIN = RACE
"""Conditions of the policy on the law's model with its own servos, without a heading hold. These
rows were measured first; joints of that model are damped more than those of the policy's own, and a
plain yaw rate turns it away. The race proper, on its own model and with the heading hold that the
law has, was added to the plan when they were seen."""
NARROW = ("push 1 m/s", "push 1.5 m/s")
"""Conditions of the same law in the narrow stance."""
RACED = COMMANDS
"""Commands of the race."""
STARTS = (8101, 8102)
"""Seeds of starts, and of the ground, that the search did not meet."""
SECONDS = 10.0
"""Duration of an episode that judges [s]; a push to the left is at 5 s."""
