"""A leg behind a serial port, for `drive_hardware`: packets with a frame and a checksum.

A packet has two bytes that mark its beginning, numbers of a fixed layout, and their CRC-16. The
computer sends "<Bf", what it wants (0: measure, 1: set the force) and a force [N]; the leg answers
a 0 with "<ff", the spring's force [N] and the height of the hip [m].
"""

import struct
import time
from binascii import crc_hqx

MARK, REQUEST, ANSWER = b"\xa5\x5a", "<Bf", "<ff"
MOST = 1000.0  # N and m; a packet with a larger number, or with none, counts as damaged


def packet(layout, *numbers):
    """Numbers as bytes to send."""
    body = struct.pack(layout, *numbers)
    return MARK + body + struct.pack("<H", crc_hqx(body, 0xFFFF))


class Packets:
    """The packets in a stream of bytes; what was damaged on the way is left out and counted."""

    def __init__(self, layout):
        self.layout, self.size = layout, len(MARK) + struct.calcsize(layout) + 2
        self.buffer, self.damaged = b"", 0

    def feed(self, data):
        """The numbers of each packet that is complete by now; less than a packet is kept."""
        self.buffer, packets = self.buffer + data, []
        while (start := self.buffer.find(MARK)) >= 0 and len(self.buffer) >= start + self.size:
            message = self.buffer[start : start + self.size]
            numbers = struct.unpack(self.layout, message[len(MARK) : -2])
            good = packet(self.layout, *numbers) == message and all(abs(x) <= MOST for x in numbers)
            self.damaged += not good
            self.buffer = self.buffer[start + (self.size if good else 1) :]
            packets += [numbers] * good
        self.buffer = self.buffer[start:] if start >= 0 else self.buffer[-1:]
        return packets


class SerialLeg:
    """Reads and commands the leg; `port` is a serial.Serial of pyserial, with a timeout."""

    def __init__(self, port, deadline_s=0.5):
        self.port, self.packets, self.deadline_s = port, Packets(ANSWER), deadline_s

    def read(self):
        """The spring's force and the height, measured now."""
        self.port.write(packet(REQUEST, 0, 0.0))
        end_s = time.monotonic() + self.deadline_s
        while not (packets := self.packets.feed(data := self.port.read(self.packets.size))):
            if not data or time.monotonic() > end_s:
                raise TimeoutError("the leg does not answer")
        return {"spring_force": packets[-1][0], "height_m": packets[-1][1]}

    def write(self, command):
        """Set the force of the actuator [N]."""
        self.port.write(packet(REQUEST, 1, command[0]))
