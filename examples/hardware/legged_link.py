"""Packets between a robot with legs and its node, and a link that delays and loses them."""

import struct

import numpy as np

PERIOD_S, JOINTS = 0.002, 12
IMU = ("root_roll", "root_pitch", "root_yaw", "root_roll_rate", "root_pitch_rate")
STATE = struct.Struct(f"<II{2 * JOINTS + len(IMU)}f")
"""Session of the robot; a count from 1; angles [rad] and torques [N m] of the joints, in the
export's order; the IMU."""
COMMAND = struct.Struct(f"<IIB{JOINTS}f")
"""Session and count of the state that it answers; 1 for servos, 0 for dampers alone; angles [rad].
A call, with which a session begins, is all 0."""
CALL = bytes(COMMAND.size)
MOST = np.repeat([6.3, 200.0, 1.0, 50.0], [JOINTS, JOINTS, 3, 2])
"""The largest sense of a state: rad, N m, sines, rad/s."""
APART_RAD = 0.35  # no target is further from its joint: torque is below stiffness times this
WATCHDOG = 25  # periods without anything new, after which joints are damped alone


class Link:
    """One direction: a packet comes some periods late, with jitter, or never.

    `late` and `jitter` are in periods, the jitter at most; `lost` is a share; `seed` draws both.
    """

    def __init__(self, seed=0, late=0, jitter=0, lost=0.0):
        self.drawn = np.random.default_rng(seed)
        self.late, self.jitter, self.lost = late, jitter, lost
        self.now, self.under_way, self.newest = 0, [], b""

    def passed(self, packet):
        """A packet goes in, if it is not empty; the newest that has come out so far, or none."""
        late = self.late + self.drawn.integers(self.jitter + 1)
        if packet and self.drawn.random() >= self.lost:
            self.under_way.append((self.now + late, packet))
        came = [packet for due, packet in self.under_way if due <= self.now]
        self.under_way = [sent for sent in self.under_way if sent[0] > self.now]
        self.newest = max([self.newest, *came], key=count_of)
        self.now += 1
        return self.newest


def count_of(packet):
    """The count of a packet; 0 of none."""
    return struct.unpack_from("<I", packet, 4)[0] if packet else 0
