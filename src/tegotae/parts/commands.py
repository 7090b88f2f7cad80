"""What an actuation commands and a body takes: the kinds that there are."""

FORCE = ("force",)
"""The force of the leg's actuator [N]."""
FOOT = ("foot_x", "foot_z")
"""Where the foot shall be, from its place at rest: forward and up, in the axes of the body [m]."""
