"""The node of a robot with twelve joints: a law in C, its limits, its watchdog and its replay."""

import numpy as np
from legged_law import Law
from legged_link import COMMAND, IMU, JOINTS, PERIOD_S, STATE, count_of

REACH_M = 0.15  # no foot is sent further from its place at rest
APART_RAD = 0.35  # no target is further from its joint: torque is below stiffness times this
TILT = 0.7  # sine of roll or pitch, beyond which joints are damped alone
WATCHDOG = 25  # periods without a new state, after which they are, too


class Node:
    """Answers every packet of the robot; what it once refused to drive it drives no more."""

    def __init__(self, folder):
        self.law, self.heard, self.due_s, self.waited = Law(folder), 0, 0.0, 0
        self.targets, self.stopped = None, ""

    def answer(self, packet):
        """The command for a state; for an old one it is that of before."""
        count, *numbers = STATE.unpack(packet)
        if not np.isfinite(numbers).all():
            self.stopped = self.stopped or "a sense is no number"
        sensed = np.nan_to_num(np.array(numbers, np.float32), posinf=0.0, neginf=0.0)
        angles, torques, imu = np.split(sensed, [JOINTS, 2 * JOINTS])
        self.waited = 0 if count > self.heard else self.waited + 1
        self.heard, felt = max(count, self.heard), dict(zip(IMU, imu, strict=True))
        if self.waited > WATCHDOG:
            self.stopped = self.stopped or "no new state"
        if max(abs(felt["root_roll"]), abs(felt["root_pitch"])) > TILT:
            self.stopped = self.stopped or "tilted"
        if self.targets is None or count * PERIOD_S >= self.due_s:
            felt |= self.law.loads_n(angles, torques)
            self.targets = self.law.step(felt, REACH_M)
            self.due_s = max(self.due_s, (count - 1) * PERIOD_S) + self.law.tick_s
        near = np.clip(self.targets, angles - APART_RAD, angles + APART_RAD)
        return COMMAND.pack(self.heard, not self.stopped, *near)


def replayed(folder, log):
    """How many answers of a log are the same to the bit; raises where one is not."""
    node, size = Node(folder), STATE.size + COMMAND.size
    for k in range(0, len(log), size):
        state, command = log[k : k + STATE.size], log[k + STATE.size : k + size]
        if node.answer(state) != command:
            raise SystemExit(f"state {count_of(state)} has another answer than in the log")
    return len(log) // size
