"""A film of an episode on an environment: its own simulator's pictures, without a window."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.animation import FuncAnimation

from tegotae._support.errors import TegotaeError, formatted, require
from tegotae.envs._types import MjData, MjModel
from tegotae.envs.mujoco.batch import ModelBatch
from tegotae.envs.mujoco.settings import ModelSettings
from tegotae.figures.animation import FRAMES_PER_S, animation_file, save_animation
from tegotae.figures.style import new_figure, styled
from tegotae.training.environments.replay import Replay

WIDTH, HEIGHT = 480, 360
"""Of a picture [pixels]."""
_SKY = 245
"""Brightness of what nothing covers."""
_DISTANCE = 3.5
"""From the camera to the trunk, over the trunk's height."""
_NO_CONTEXT = (
    "cannot draw without a display: MuJoCo needs EGL or OSMesa (Debian: libegl1 or libosmesa6); "
    "leave --animate out"
)


def write_film(replay: Replay, path: Path | str) -> Path:
    """Film an episode from the side, following the trunk, as .gif, or .mp4 where ffmpeg is.

    The episode's actions are played again: a MuJoCo model then goes through the same episode, to
    rounding, and so does an environment of Gymnasium that is reset with the same seed.

    Raises:
        TegotaeError: where nothing can be drawn, or the file cannot be written.
    """
    path = animation_file(path)
    pictures = film(replay)
    with styled():
        figure = new_figure(WIDTH / 90.0, (HEIGHT + 24) / 90.0)
        axes = figure.add_axes((0.0, 0.0, 1.0, HEIGHT / (HEIGHT + 24)))
        axes.set_axis_off()
        shown = axes.imshow(pictures[0])
        title = axes.set_title("0.00 s", pad=3)
        figure.set_layout_engine("none")

        def draw(index: int):
            shown.set_data(pictures[index])
            title.set_text(f"{index / FRAMES_PER_S:.2f} s")
            return shown, title

        moving = FuncAnimation(figure, draw, frames=len(pictures))  # type: ignore[arg-type]
        return save_animation(moving, path)


def film(replay: Replay) -> list[np.ndarray]:
    """Pictures of an episode, `FRAMES_PER_S` a second, uint8 [rows, columns, 3] each.

    Raises:
        TegotaeError: where nothing can be drawn.
    """
    spec = replay.experiment.spec
    if spec.is_model:
        return _of_model(spec.model_settings, replay)
    return _of_environment(replay)


def _at(replay: Replay) -> np.ndarray:
    """The steps of which there is a picture."""
    time = replay.episode.time_s
    count = max(1, int(time[-1] * FRAMES_PER_S))
    return np.searchsorted(time, np.arange(count) / FRAMES_PER_S).clip(max=len(time) - 1)


def _of_model(settings: ModelSettings, replay: Replay) -> list[np.ndarray]:
    mujoco = require("mujoco", "mujoco")
    sensing = settings.sensed
    batch = ModelBatch(sensing, 1, settings.control_s, threads=1)
    noise = None
    if settings.noise:
        drawn = np.random.default_rng(replay.seed).standard_normal((1, sensing.model.nv))
        noise = settings.noise * drawn
    try:
        seen = batch.reset(settings.release_m, noise)
        far = _DISTANCE * max(float(seen[0][sensing.names.index("root_height")]), 1e-2)
        wanted = {*_at(replay).tolist()}
        states: dict[int, np.ndarray] = {}
        for step, action in enumerate(replay.episode.action):
            batch.step(action[None].astype(float))
            if step in wanted:
                states[step] = batch.states[0]
    finally:
        batch.close()
    sensing.model.vis.headlight.ambient[:] = 0.45  # models without lights are dark
    sensing.model.vis.headlight.diffuse[:] = 0.5
    with _camera(sensing.model, far) as picture:
        data = mujoco.MjData(sensing.model)
        found = {}
        for step, state in states.items():
            mujoco.mj_setState(sensing.model, data, state, mujoco.mjtState.mjSTATE_FULLPHYSICS)
            mujoco.mj_forward(sensing.model, data)
            found[step] = picture(data)
    return [found[step] for step in _at(replay).tolist()]


@contextmanager
def _camera(model: MjModel, distance_m: float) -> Iterator[Callable[[MjData], np.ndarray]]:
    """A function that draws, from the side."""
    mujoco = require("mujoco", "mujoco")
    context = _context()
    try:
        context.make_current()
        drawing = mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_100)
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, drawing)
        scene, option = mujoco.MjvScene(model, 5000), mujoco.MjvOption()
        camera, area = mujoco.MjvCamera(), mujoco.MjrRect(0, 0, WIDTH, HEIGHT)
        # Shadows take most of the time of a renderer in software.
        scene.flags[mujoco.mjtRndFlag.mjRND_SHADOW] = 0
        scene.flags[mujoco.mjtRndFlag.mjRND_REFLECTION] = 0
        camera.type = mujoco.mjtCamera.mjCAMERA_TRACKING
        camera.trackbodyid = 1
        camera.distance, camera.azimuth, camera.elevation = distance_m, 90.0, -8.0
        everything = mujoco.mjtCatBit.mjCAT_ALL

        def picture(data: MjData) -> np.ndarray:
            mujoco.mjv_updateScene(model, data, option, None, camera, everything, scene)
            _mark_ground(mujoco, scene, data, distance_m)
            mujoco.mjr_render(area, scene, drawing)
            pixels = np.empty((HEIGHT, WIDTH, 3), np.uint8)
            mujoco.mjr_readPixels(pixels, None, area, drawing)
            pixels[(pixels == 0).all(axis=2)] = _SKY
            return np.flipud(pixels)

        yield picture
    finally:
        context.free()


def _mark_ground(mujoco: Any, scene: Any, data: MjData, distance_m: float) -> None:
    """Stripes across the ground, by which one sees the body go."""
    gap = distance_m / 10.0
    first = round(float(data.xpos[1][0]) / gap)
    for i in range(first - 12, first + 13):
        if i % 2 or scene.ngeom >= scene.maxgeom:
            continue
        size = np.array([0.5 * gap, distance_m, 1e-4])
        place = np.array([i * gap, float(data.xpos[1][1]), 1e-4])
        colour = np.array([0.55, 0.6, 0.65, 1.0], np.float32)
        box = mujoco.mjtGeom.mjGEOM_BOX
        mujoco.mjv_initGeom(scene.geoms[scene.ngeom], box, size, place, np.eye(3).ravel(), colour)
        scene.ngeom += 1


def _context() -> Any:
    """An offscreen OpenGL context by the first way that this machine has.

    Raises:
        TegotaeError: if it has none.
    """
    chosen = os.environ.get("MUJOCO_GL", "").lower()
    if sys.platform != "linux":
        ways = ["cgl" if sys.platform == "darwin" else "glfw"]
    elif chosen in ("egl", "osmesa", "glfw"):
        ways = [chosen]
    else:
        ways = ["egl", "osmesa", *(["glfw"] if os.environ.get("DISPLAY") else [])]
    for way in ways:
        try:
            return import_module(f"mujoco.{way}").GLContext(WIDTH, HEIGHT)
        except Exception:  # drivers fail in ways of their own
            continue
    raise TegotaeError(_NO_CONTEXT)


def _of_environment(replay: Replay) -> list[np.ndarray]:
    """Gymnasium's pictures, of an environment that draws itself."""
    spec = replay.experiment.spec
    if "MUJOCO_GL" not in os.environ and sys.platform == "linux" and not os.environ.get("DISPLAY"):
        os.environ["MUJOCO_GL"] = "egl"
    drawn = replace(spec, settings=(*spec.settings, ("render_mode", "rgb_array")))
    wanted = {*_at(replay).tolist()}
    found: dict[int, np.ndarray] = {}
    env = drawn.make()
    try:
        env.reset(seed=replay.seed)
        for step, action in enumerate(replay.episode.action):
            env.step(action.astype(env.action_space.dtype))
            if step in wanted:
                found[step] = np.asarray(env.render(), np.uint8)
    except Exception as error:  # somebody else's program draws
        raise TegotaeError(
            f"{spec.env} cannot be drawn: {formatted(error)}; leave --animate out"
        ) from None
    finally:
        env.close()
    return [found[step] for step in _at(replay).tolist()]
