"""Part of pyserial's `serial.Serial` that a leg needs; Linux and macOS, no package."""

import os
import select
import tty


class Serial:
    """A serial port.

    On a robot use pyserial's, which sets the speed too: serial.Serial(path, 921600, timeout=0.1).
    """

    def __init__(self, path, baudrate=921600, timeout=0.1):
        self.file, self.timeout = os.open(path, os.O_RDWR | os.O_NOCTTY), timeout
        tty.setraw(self.file)

    def read(self, size):
        """Read at most so many bytes; none after the timeout [s]."""
        ready, _, _ = select.select([self.file], [], [], self.timeout)
        return os.read(self.file, size) if ready else b""

    def write(self, data):
        """Send bytes."""
        os.write(self.file, data)

    def close(self):
        """Close the port."""
        os.close(self.file)
