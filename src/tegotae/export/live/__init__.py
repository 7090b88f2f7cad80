"""Controllers live: a saved controller stepped from Python, on a robot or beside any simulator."""

from tegotae.export.live.controller import LiveController
from tegotae.export.live.loop import LoopReport, drive_hardware, new_recording

__all__ = ["LiveController", "LoopReport", "drive_hardware", "new_recording"]
