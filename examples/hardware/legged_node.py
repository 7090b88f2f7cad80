"""The node of a robot with twelve joints: a law in C, its limits, its watchdog and its replay."""

import legged_link as link
import numpy as np
from legged_law import Law

REACH_M = 0.15  # no foot is sent further from its place at rest
TILT = 0.7  # sine of roll or pitch, beyond which joints are damped alone
WINDOW = 500  # states that may be lost in a row; a count further ahead is none of the robot's


class Node:
    """Answers the robot of one session; what it once refused to drive it drives no more."""

    def __init__(self, folder):
        self.law, self.session, self.heard, self.waited = Law(folder), 0, 0, 0
        self.targets, self.due_s, self.near, self.stopped = None, 0.0, np.zeros(link.JOINTS), ""

    def answer(self, packet):
        """The command for a new state, or that of before; nothing to another session."""
        session, count, *numbers = link.STATE.unpack(packet)
        self.session = self.session or session
        if not session or session != self.session:
            return b""
        if new := self.heard < count <= self.heard + WINDOW:
            self.heard, self.waited = count, 0
            self._step(np.array(numbers, np.float32))
        self.waited += not new
        if self.waited > link.WATCHDOG:
            self.stopped = self.stopped or "no new state"
        return link.COMMAND.pack(self.session, self.heard, not self.stopped, *self.near)

    def _step(self, numbers):
        """The targets of a new state: those of the law, near to its joints."""
        good = np.abs(numbers) <= link.MOST  # which NaN is not
        if not good.all():
            self.stopped = self.stopped or "a sense is no number, or out of range"
        sensed, places = np.where(good, numbers, 0.0), [link.JOINTS, 2 * link.JOINTS]
        angles, torques, imu = np.split(sensed, places)
        felt = dict(zip(link.IMU, imu, strict=True))
        if max(abs(felt["root_roll"]), abs(felt["root_pitch"])) > TILT:
            self.stopped = self.stopped or "tilted"
        if self.targets is None or self.heard * link.PERIOD_S >= self.due_s:
            felt |= self.law.loads_n(angles, torques)
            self.targets = self.law.step(felt, REACH_M)
            self.due_s = max(self.due_s, (self.heard - 1) * link.PERIOD_S) + self.law.tick_s
        self.near = np.clip(self.targets, angles - link.APART_RAD, angles + link.APART_RAD)


def replayed(folder, log):
    """Count the answers of a log that are the same to the bit; raise where one is not."""
    node, size = Node(folder), link.STATE.size + link.COMMAND.size
    for k in range(0, len(log), size):
        state, command = log[k : k + link.STATE.size], log[k + link.STATE.size : k + size]
        if node.answer(state) != command:
            raise SystemExit(f"state {link.count_of(state)} has another answer than in the log")
    return len(log) // size
