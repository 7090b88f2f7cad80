"""A leg behind a serial port, for `drive_hardware`: packets with a frame and a checksum.

Each packet is two bytes that mark its beginning, numbers of a fixed layout, and a CRC-16 of these.
The computer sends "<Bf", what it wants (0: measure, 1: set the force) and a force [N]; the leg
answers a 0 with "<ff", the spring's force [N] and the height of the hip [m].
"""

import struct
from binascii import crc_hqx

MARK = b"\xa5\x5a"
REQUEST, ANSWER = "<Bf", "<ff"


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
        """The numbers of each packet that is complete by now."""
        self.buffer += data
        found = []
        while (at := self.buffer.find(MARK)) >= 0 and len(self.buffer) >= at + self.size:
            whole = self.buffer[at : at + self.size]
            numbers = struct.unpack(self.layout, whole[len(MARK) : -2])
            if packet(self.layout, *numbers) == whole:
                found.append(numbers)
                self.buffer = self.buffer[at + self.size :]
            else:
                self.damaged += 1
                self.buffer = self.buffer[at + 1 :]
        return found


class SerialLeg:
    """Reads and commands the leg; `port` is a serial.Serial of pyserial, with a timeout."""

    def __init__(self, port):
        self.port, self.packets = port, Packets(ANSWER)

    def read(self):
        """The spring's force and the height, measured now."""
        self.port.write(packet(REQUEST, 0, 0.0))
        while not (found := self.packets.feed(data := self.port.read(self.packets.size))):
            if not data:
                raise TimeoutError("the leg does not answer")
        return {"spring_force": found[-1][0], "height_m": found[-1][1]}

    def write(self, command):
        """Set the force of the actuator [N]."""
        self.port.write(packet(REQUEST, 1, command[0]))
