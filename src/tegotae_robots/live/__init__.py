"""Controllers live: a saved controller stepped from Python, on a robot or beside any simulator."""

from tegotae_robots.live.controller import LiveController
from tegotae_robots.live.loop import LoopReport, drive_hardware, new_recording

__all__ = ["LiveController", "LoopReport", "drive_hardware", "new_recording"]
