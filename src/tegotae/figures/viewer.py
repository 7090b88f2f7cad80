"""MuJoCo's viewer: an episode on a robot, in a window that one can turn and stop."""

from __future__ import annotations

import os
import sys
import threading
import time
import warnings
from typing import TYPE_CHECKING

from tegotae._support.errors import TegotaeError, require
from tegotae.figures.animation import model_states

if TYPE_CHECKING:
    from tegotae.training.environments.replay import Replay


def view(replay: Replay, *, repeats: int | None = None) -> None:
    """Show an episode in MuJoCo's viewer, in real time, until its window is closed.

    Args:
        replay: an episode on a MuJoCo model.
        repeats: number of times that the episode is shown; without end by default.

    Raises:
        MissingExtraError: without MuJoCo.
        TegotaeError: for an episode in another simulator, or without a screen.
    """
    spec, times = replay.experiment.spec, replay.episode.time_s
    if not spec.is_model:
        raise TegotaeError(f"{spec.env} is no MuJoCo model, which a viewer shows; use --animate")
    screens = ("DISPLAY", "WAYLAND_DISPLAY")
    if sys.platform == "linux" and not any(map(os.environ.get, screens)):  # GLFW would end Python
        raise TegotaeError("there is no screen for a window (DISPLAY is not set); use --animate")
    mujoco = require("mujoco", "mujoco")
    viewer = require("mujoco.viewer", "mujoco")
    model, distance_m, states = model_states(spec.model_settings, replay, range(len(times)))
    data = mujoco.MjData(model)
    _require_window()
    others = set(threading.enumerate())
    window = viewer.launch_passive(model, data, show_left_ui=False, show_right_ui=False)
    with window:
        window.cam.type = mujoco.mjtCamera.mjCAMERA_TRACKING
        window.cam.trackbodyid, window.cam.distance = 1, distance_m
        shown = 0
        while window.is_running() and shown != repeats:
            begin = time.monotonic()
            for time_s, state in zip(times, states.values(), strict=True):
                if not window.is_running():
                    break
                with window.lock():
                    mujoco.mj_setState(model, data, state, mujoco.mjtState.mjSTATE_FULLPHYSICS)
                    mujoco.mj_forward(model, data)
                window.sync()
                time.sleep(max(0.0, begin + time_s - time.monotonic()))
            shown += 1
    # Python's end would take GLFW away from the thread that still closes the window.
    for thread in set(threading.enumerate()) - others:
        thread.join()


def _require_window() -> None:
    """Raise an error where no window can be opened; MuJoCo's viewer would end Python, or wait."""
    if sys.platform == "darwin":  # a window needs the thread that mjpython gives it
        return
    glfw = require("glfw", "mujoco")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        hidden = glfw.init() and glfw.create_window(1, 1, "tegotae", None, None)
    if not hidden:
        raise TegotaeError("no window can be opened on this screen (DISPLAY); use --animate")
    glfw.destroy_window(hidden)
