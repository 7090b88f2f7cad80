"""Animations of a hopper, and of several beside each other."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from collections.abc import Callable, Collection, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from matplotlib.animation import FFMpegWriter
from matplotlib.artist import Artist
from matplotlib.backends.backend_agg import RendererAgg
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Rectangle
from PIL import Image

from tegotae._support.errors import TegotaeError, formatted, require
from tegotae._support.files import output_file, write_atomically
from tegotae._support.progress import reporting
from tegotae.analysis.simulation import Result
from tegotae.figures.style import COLOURS, new_figure, styled

if TYPE_CHECKING:  # of MuJoCo and Gymnasium, which are extras
    from tegotae.envs._types import MjData, MjModel
    from tegotae.envs.mujoco.settings import ModelSettings
    from tegotae.training.environments.replay import Replay


_VIDEOS = (".mp4", ".webm")
"""Endings that need ffmpeg."""
FRAMES_PER_S = 25
"""Pictures per simulated second, shown in real time."""
_DPI = 90
"""Resolution of a picture [dots per inch]."""
_PICTURES_FOR_COLOURS = 8
"""Number of pictures, evenly spaced in time, from which an animation's colours are chosen."""


@dataclass(frozen=True, eq=False)
class Animation:
    """Frames of a figure that a function draws.

    The figure is laid out once: a constrained layout per picture would take most of the time.

    Args:
        figure: what is drawn on.
        draw: moves the artists to a frame.
        frames: in their order.
        artists: all that move, where everything else stays: a tenth of the time.
    """

    figure: Figure
    draw: Callable[[int], Any]
    frames: Sequence[int]
    artists: Sequence[Artist] = ()

    def __post_init__(self) -> None:
        self.figure.draw_without_rendering()
        self.figure.set_layout_engine("none")

    def pictures(self) -> Iterator[Image.Image]:
        """Yield the pictures; the artists alone are drawn anew, with the frames of their axes."""
        figure = self.figure
        figure.dpi = _DPI
        axes = {artist.axes: None for artist in self.artists if artist.axes}
        moving = [*self.artists, *(spine for x in axes for spine in x.spines.values())]
        moving.sort(key=Artist.get_zorder)
        for artist in moving:
            artist.set_animated(True)
        renderer = RendererAgg(*figure.bbox.size, _DPI)
        background = None
        for frame in self.frames:
            self.draw(frame)
            if background is None or not moving:
                renderer.clear()
                figure.draw(renderer)
                background = renderer.copy_from_bbox(figure.bbox)
            renderer.restore_region(background)
            for artist in moving:
                artist.draw(renderer)
            size, pixels = (int(renderer.width), int(renderer.height)), renderer.buffer_rgba()
            yield Image.frombytes("RGBA", size, bytes(pixels)).convert("RGB")


def write_animation(make: Callable[[], Animation], path: Path | str) -> Path:
    """Make an animation, and write it, whole or not at all.

    Args:
        make: function that makes it.
        path: the file (.gif, .webp; or .mp4, .webm, which need ffmpeg).

    Raises:
        TegotaeError: for what cannot be drawn, another ending, a missing or failing ffmpeg, or a
            file that cannot be written.
    """
    path = animation_file(path)
    write = _write_video if path.suffix.lower() in _VIDEOS else _write_pictures
    try:
        with styled(), tempfile.TemporaryDirectory() as folder:
            moving, temporary = make(), Path(folder) / path.name
            with reporting("animation", len(moving.frames)) as reporter:
                write(moving, temporary, reporter.update)
            write_atomically(path, temporary.read_bytes())
    except subprocess.CalledProcessError:
        raise TegotaeError(f"ffmpeg failed to write {path}; use .gif") from None
    except OSError as error:
        raise TegotaeError(f"cannot write {path}: {error.strerror or error}") from None
    return path


def _write_pictures(moving: Animation, path: Path, report: Callable[[int], None]) -> None:
    """Write a .gif, whose pictures have the same 256 colours, or a .webp.

    Matplotlib's own writer draws each picture twice and looks for its colours anew.
    """
    pictures = []
    for picture in moving.pictures():
        pictures.append(picture)
        report(len(pictures))
    if path.suffix.lower() == ".gif":
        pictures = _with_256_colours(pictures)
    first, *further = pictures
    duration = int(1000 / FRAMES_PER_S)
    first.save(path, save_all=True, append_images=further, duration=duration, loop=0)


def _with_256_colours(pictures: Sequence[Image.Image]) -> list[Image.Image]:
    some = pictures[:: -(-len(pictures) // _PICTURES_FOR_COLOURS)]
    strip = Image.fromarray(np.concatenate([np.asarray(picture) for picture in some]))
    colours = strip.quantize(256, method=Image.Quantize.FASTOCTREE)
    return [x.quantize(palette=colours, dither=Image.Dither.NONE) for x in pictures]


def _write_video(moving: Animation, path: Path, report: Callable[[int], None]) -> None:
    # Browsers show no other pixels, and VP9 takes those of Matplotlib in no release.
    pixels = ["-pix_fmt", "yuv420p"]
    writer = FFMpegWriter(fps=FRAMES_PER_S, codec="h264", extra_args=pixels)
    with writer.saving(moving.figure, str(path), _DPI):
        for number, frame in enumerate(moving.frames, 1):
            moving.draw(frame)
            writer.grab_frame()
            report(number)


def animation_file(path: Path | str) -> Path:
    """Return the path of an animation to be written, after a check of its ending and folder.

    Raises:
        TegotaeError: for another ending, a missing ffmpeg, or a folder that cannot be written to.
    """
    path = Path(path)
    suffix = path.suffix.lower()
    if suffix not in (".gif", ".webp", *_VIDEOS):
        raise TegotaeError(
            f"cannot write an animation as {path.name!r}; use .gif, .webp, .mp4 or .webm"
        )
    if suffix in _VIDEOS and not FFMpegWriter.isAvailable():
        raise TegotaeError(f"writing {suffix} needs the program ffmpeg; use .gif or .webp")
    return output_file(path)


def animation(result: Result) -> Animation:
    """Return the animation of a simulation."""
    t, hopper = result.trajectory, result.body
    stride = max(1, round(1.0 / FRAMES_PER_S / result.timing.frame_s))
    frames = range(0, len(t.time_s), stride)
    figure = new_figure(4.4, 3.6)
    scene, dial = figure.subplots(1, 2, width_ratios=(1.4, 1.0))
    low = float(t.ground_m.min()) - 0.1
    scene.set(xlim=(-0.6, 0.6), ylim=(low, 1.1 * float(t.height_m.max()) + 0.1), xticks=[])
    scene.set_ylabel("height [m]")
    scene.set_aspect("equal")
    ground = scene.add_patch(Rectangle((-5, -5), 10, 5, color="0.8"))
    (spring,) = scene.plot([], [], color=COLOURS[0], lw=1.2)
    (actuator,) = scene.plot([], [], color=COLOURS[1], solid_capstyle="butt", lw=0)
    mass = scene.add_patch(Circle((0, 0), 0.08, color=COLOURS[2], zorder=3))
    label = scene.set_title(" 0.00 s")

    dial.set(xlim=(-1.3, 1.3), ylim=(-1.3, 1.3), xticks=[], yticks=[], aspect="equal")
    for spine in dial.spines.values():
        spine.set_visible(False)
    with_oscillator = result.system.controller.oscillator is not None
    if with_oscillator:
        dial.add_patch(Circle((0, 0), 1.0, fill=False, color="0.6"))
        dial.set_title("phase φ")
    (hand,) = dial.plot([], [], "o-", color=COLOURS[0], ms=5, visible=with_oscillator)

    def draw(index: int) -> None:
        y, h = float(t.height_m[index]), float(t.ground_m[index])
        foot = max(h, y - hopper.rest_length_m)
        ground.set_y(h - 5)
        mass.center = (0.0, y)
        zigzag = np.linspace(foot, y - 0.06, 13)
        sideways = 0.06 * np.array([0, 0, *([1, -1] * 4), 1, 0, 0])
        spring.set_data(sideways - 0.08, zigzag)
        force = float(t.actuator_force_n[index]) / hopper.max_force_n
        actuator.set_data([0.12, 0.12], [foot, y])
        actuator.set_linewidth(1.0 + 7.0 * force)
        actuator.set_alpha(0.25 + 0.75 * force)
        label.set_text(f"{float(t.time_s[index]):5.2f} s")
        phase = float(t.phase_rad[index])
        hand.set_data([0.0, np.cos(phase)], [0.0, np.sin(phase)])

    return Animation(figure, draw, frames, (ground, mass, spring, actuator, label, hand))


WIDTH, HEIGHT = 480, 360
"""Size of a picture [pixels]."""
_SKY = 245
"""Brightness of what nothing covers."""
_DISTANCE = 3.5
"""Distance of the camera from the trunk, over the trunk's height."""
_NO_CONTEXT = (
    "cannot draw without a display: MuJoCo needs EGL or OSMesa (Debian: libegl1 or libosmesa6); "
    "leave --animate out"
)


def film_animation(replay: Replay) -> Animation:
    """Return the film of an episode from the side, following the trunk.

    The episode's actions are played again: a MuJoCo model then goes through the same episode, to
    rounding, and so does an environment of Gymnasium that is reset with the same seed.

    Raises:
        TegotaeError: where nothing can be drawn.
    """
    pictures = film(replay)
    figure = new_figure(WIDTH / 90.0, (HEIGHT + 24) / 90.0)
    figure.set_layout_engine("none")
    axes = figure.add_axes((0.0, 0.0, 1.0, HEIGHT / (HEIGHT + 24)))
    axes.set_axis_off()
    image = axes.imshow(pictures[0])
    title = axes.set_title("0.00 s", pad=3)

    def draw(index: int) -> None:
        image.set_data(pictures[index])
        title.set_text(f"{index / FRAMES_PER_S:.2f} s")

    return Animation(figure, draw, range(len(pictures)), (image, title))


def film(replay: Replay) -> list[np.ndarray]:
    """Return pictures of an episode, `FRAMES_PER_S` per second, uint8 [rows, columns, 3] each.

    Raises:
        TegotaeError: where nothing can be drawn.
    """
    spec, time = replay.experiment.spec, replay.episode.time_s
    count = max(1, int(time[-1] * FRAMES_PER_S))
    at = np.searchsorted(time, np.arange(count) / FRAMES_PER_S).clip(max=len(time) - 1)
    steps: list[int] = at.tolist()
    if spec.is_model:
        pictures = _model_pictures(spec.model_settings, replay, steps)
    else:
        pictures = _environment_pictures(replay, steps)
    return [pictures[step] for step in steps]


class ModelStates(NamedTuple):
    """States of a MuJoCo model at some steps of an episode, played again."""

    model: MjModel
    distance_m: float
    """Distance from which the whole model is seen [m]."""
    states: dict[int, np.ndarray]
    """MuJoCo's physics state by step."""


def model_states(settings: ModelSettings, replay: Replay, steps: Collection[int]) -> ModelStates:
    """Play an episode again on its MuJoCo model, and return the states of some steps.

    Args:
        settings: of the model.
        replay: the episode.
        steps: numbers of the steps.
    """
    from tegotae.envs.mujoco.env import ModelLanes
    from tegotae.envs.mujoco.sensing import sensing
    from tegotae.envs.scaling import started

    lanes, every, sensed = ModelLanes(settings, 1), np.ones(1, bool), sensing(settings)
    states: dict[int, np.ndarray] = {}
    try:
        observation = lanes.reset(replay.seed, every)
        high = max(float(observation[0][sensed.names.index("root_height")]), 1e-2)
        wide = float(np.ptp(started(sensed.model).xpos[1:, :2], 0).max())
        for step, action in enumerate(replay.episode.action):
            lanes.step(action[None].astype(float), every)
            if step in steps:
                states[step] = lanes.batch.states[0]
    finally:
        lanes.close()
    return ModelStates(sensed.model, max(_DISTANCE * high, 2.0 * wide), states)


def _model_pictures(
    settings: ModelSettings, replay: Replay, steps: Collection[int]
) -> dict[int, np.ndarray]:
    """Return the pictures of some steps of a MuJoCo model."""
    mujoco = require("mujoco", "mujoco")
    model, distance_m, states = model_states(settings, replay, steps)
    with model_camera(model, distance_m) as picture:
        data = mujoco.MjData(model)
        pictures = {}
        for step, state in states.items():
            mujoco.mj_setState(model, data, state, mujoco.mjtState.mjSTATE_FULLPHYSICS)
            mujoco.mj_forward(model, data)
            pictures[step] = picture(data)
    return pictures


@contextmanager
def model_camera(model: MjModel, distance_m: float) -> Iterator[Callable[[MjData], np.ndarray]]:
    """Open a camera, and yield a function that draws a model's state from the side.

    Args:
        model: an `MjModel`.
        distance_m: from the camera to the first body [m].

    Raises:
        TegotaeError: where nothing can be drawn.
    """
    mujoco = require("mujoco", "mujoco")
    model.vis.headlight.ambient[:] = 0.45  # models without lights are dark
    model.vis.headlight.diffuse[:] = 0.5
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
        categories = mujoco.mjtCatBit.mjCAT_ALL

        def picture(data: MjData) -> np.ndarray:
            mujoco.mjv_updateScene(model, data, option, None, camera, categories, scene)
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
    """Draw stripes across the ground that show the motion of the body."""
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
    """Return an offscreen OpenGL context by the first method that works on this machine.

    Raises:
        TegotaeError: if it has none.
    """
    backend = os.environ.get("MUJOCO_GL", "").lower()
    if sys.platform != "linux":
        backends = ["cgl" if sys.platform == "darwin" else "glfw"]
    elif backend in ("egl", "osmesa", "glfw"):
        backends = [backend]
    else:
        backends = ["egl", "osmesa", *(["glfw"] if os.environ.get("DISPLAY") else [])]
    for candidate in backends:
        try:
            return import_module(f"mujoco.{candidate}").GLContext(WIDTH, HEIGHT)
        except Exception:  # drivers fail in ways of their own
            continue
    raise TegotaeError(_NO_CONTEXT)


def _environment_pictures(replay: Replay, steps: Collection[int]) -> dict[int, np.ndarray]:
    """Return the pictures of some steps of an environment that draws itself with Gymnasium."""
    spec = replay.experiment.spec
    if "MUJOCO_GL" not in os.environ and sys.platform == "linux" and not os.environ.get("DISPLAY"):
        os.environ["MUJOCO_GL"] = "egl"
    drawn = replace(spec, settings=(*spec.settings, ("render_mode", "rgb_array")))
    pictures: dict[int, np.ndarray] = {}
    env = drawn.make()
    try:
        env.reset(seed=replay.seed)
        for step, action in enumerate(replay.episode.action):
            env.step(action.astype(env.action_space.dtype))
            if step in steps:
                pictures[step] = np.asarray(env.render(), np.uint8)
    except Exception as error:  # somebody else's program draws
        raise TegotaeError(
            f"{spec.env} cannot be drawn: {formatted(error)}; leave --animate out"
        ) from None
    finally:
        env.close()
    return pictures
