"""A moving picture of a rollout: body, spring, actuator and phase."""

from __future__ import annotations

import subprocess
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.animation import FFMpegWriter, FuncAnimation, PillowWriter
from matplotlib.backends.backend_agg import RendererAgg
from matplotlib.patches import Circle, Rectangle
from PIL import Image

from tegotae._support.errors import TegotaeError
from tegotae._support.files import output_file, write_atomically
from tegotae._support.progress import reporting
from tegotae.figures.style import COLOURS, new_figure, styled
from tegotae.systems.simulation import Result

FRAMES_PER_S = 25
"""Pictures per simulated second, shown in real time."""
_PICTURES_FOR_COLOURS = 8
"""From so many pictures, evenly in time, an animation's colours are chosen."""


def write_animation(result: Result, path: Path | str) -> Path:
    """Write the animation, whole or not at all, as .gif, or .mp4 where ffmpeg is installed.

    Raises:
        TegotaeError: for another ending, a missing ffmpeg, or a file that cannot be written.
    """
    path = animation_file(path)
    with styled():
        return save_animation(animation(result), path)


def save_animation(moving: FuncAnimation, path: Path) -> Path:
    """Write an animation to a file that `animation_file` has looked at.

    Raises:
        TegotaeError: if ffmpeg fails, or the file cannot be written.
    """
    writer = (GifWriter if path.suffix.lower() == ".gif" else FFMpegWriter)(fps=FRAMES_PER_S)
    try:
        with styled(), tempfile.TemporaryDirectory() as folder:
            whole = Path(folder) / path.name
            with reporting("animation", sum(1 for _ in moving.new_saved_frame_seq())) as reporter:
                moving.save(
                    whole,
                    writer=writer,
                    dpi=90,
                    progress_callback=lambda frame, _: reporter.update(frame + 1),
                )
            write_atomically(path, whole.read_bytes())
    except subprocess.CalledProcessError:
        raise TegotaeError(f"ffmpeg failed to write {path}; use .gif") from None
    except OSError as error:
        raise TegotaeError(f"cannot write {path}: {error.strerror or error}") from None
    return path


def animation_file(path: Path | str) -> Path:
    """The path of an animation to be written, its ending known and its folder tried.

    Raises:
        TegotaeError: for another ending, a missing ffmpeg, or a folder that cannot be written to.
    """
    path = Path(path)
    suffix = path.suffix.lower()
    if suffix not in (".gif", ".mp4"):
        raise TegotaeError(f"cannot write an animation as {path.name!r}; use .gif or .mp4")
    if suffix == ".mp4" and not FFMpegWriter.isAvailable():
        raise TegotaeError("writing .mp4 needs the program ffmpeg; use .gif")
    return output_file(path)


class GifWriter(PillowWriter):
    """Writes .gif: each picture is drawn once, and all have the same 256 colours.

    Matplotlib's own writer draws each picture twice and looks for its colours anew.
    """

    def setup(self, fig: Any, outfile: Any, dpi: float | None = None) -> None:
        """Begin a file."""
        super().setup(fig, outfile, dpi)
        self._pictures: list[Image.Image] = []

    def grab_frame(self, **_: Any) -> None:
        """Draw the figure as it is now."""
        width, height = self.frame_size
        renderer = RendererAgg(width, height, self.dpi)
        before, self.fig.dpi = self.fig.dpi, self.dpi
        self.fig.draw(renderer)
        self.fig.dpi = before
        drawn = np.asarray(renderer.buffer_rgba())[..., :3]
        self._pictures.append(Image.fromarray(np.ascontiguousarray(drawn)))

    def finish(self) -> None:
        """Write the file."""
        some = self._pictures[:: -(-len(self._pictures) // _PICTURES_FOR_COLOURS)]
        strip = Image.fromarray(np.concatenate([np.asarray(each) for each in some]))
        colours = strip.quantize(256, method=Image.Quantize.FASTOCTREE)
        first, *others = (
            each.quantize(palette=colours, dither=Image.Dither.NONE) for each in self._pictures
        )
        first.save(
            self.outfile,
            save_all=True,
            append_images=others,
            duration=int(1000 / self.fps),
            loop=0,
        )


def animation(result: Result) -> FuncAnimation:
    """The animation of a simulation."""
    t, hopper = result.trajectory, result.simulation.hopper
    stride = max(1, round(1.0 / FRAMES_PER_S / result.simulation.timing.frame_s))
    frames = np.arange(0, len(t.time_s), stride)
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

    dial.set(xlim=(-1.3, 1.3), ylim=(-1.3, 1.3), xticks=[], yticks=[])
    dial.set_aspect("equal")
    for spine in dial.spines.values():
        spine.set_visible(False)
    with_oscillator = result.simulation.controller.oscillator is not None
    if with_oscillator:
        dial.add_patch(Circle((0, 0), 1.0, fill=False, color="0.6"))
        dial.set_title("phase φ")
    (hand,) = dial.plot([], [], "o-", color=COLOURS[0], ms=5, visible=with_oscillator)

    def draw(index: int):
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
        return ground, mass, spring, actuator, label, hand

    # Laid out once: a constrained layout per picture would take most of the time.
    figure.draw_without_rendering()
    figure.set_layout_engine("none")
    return FuncAnimation(figure, draw, frames=frames.tolist(), interval=1000 / FRAMES_PER_S)  # type: ignore[arg-type]
