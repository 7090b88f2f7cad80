"""A law on legs that takes commands, as `tegotae export c` wrote it; see `legged_law.py`."""

import ctypes

import numpy as np
from legged_law import Law, pointer


class CommandedLaw(Law):
    """The C of an export's folder, with commands and leg odometry."""

    def command(self, forward, sideways, yaw_rate, heading_error=0.0):
        """Command a law that takes commands: m/s, m/s, rad/s, and rad to a heading."""
        numbers = forward, sideways, yaw_rate, heading_error
        self.c.tegotae_command(pointer(self.inputs), *map(ctypes.c_float, numbers))

    def odometry(self, angles, rates, turning):
        """Set the velocity of the torso from joints, their rates and a gyroscope."""
        measured = [np.array(x, np.float32) for x in (angles, rates, turning)]
        self.c.tegotae_odometry(pointer(self.inputs), *map(pointer, measured))
