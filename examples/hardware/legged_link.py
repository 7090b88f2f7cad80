"""Packets between a robot with legs and its node, and a link that delays and loses them."""

import struct

import numpy as np

PERIOD_S, JOINTS = 0.002, 12
IMU = ("root_roll", "root_pitch", "root_yaw", "root_roll_rate", "root_pitch_rate")
STATE = struct.Struct(f"<I{2 * JOINTS + len(IMU)}f")
"""A count from 1; angles [rad] and torques [N m] of the joints, in the export's order; the IMU."""
COMMAND = struct.Struct(f"<IB{JOINTS}f")
"""The count of the state that it answers; 1 for servos, 0 for dampers alone; angles [rad]."""


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
    """The count that a packet begins with; 0 of none."""
    return struct.unpack_from("<I", packet)[0] if packet else 0


def received(port, form):
    """A packet from a port; nothing in place of one of another size."""
    packet = port.recv(form.size + 1)
    return packet if len(packet) == form.size else b""
