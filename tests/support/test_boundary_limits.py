"""Unreasonable requests are refused before any work starts, with the memory that it would need."""

import os
import subprocess

import numpy as np
import pytest
from matplotlib import rc_context
from matplotlib.animation import FFMpegWriter
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from PIL import Image

from refusals import refused
from tegotae import Rollout, Scenario, TegotaeError, Timing
from tegotae._support import limits
from tegotae._support.errors import require_count, require_finite, unknown
from tegotae._support.files import write_atomically
from tegotae._support.limits import require_memory
from tegotae.analysis.maps import axis, lanes
from tegotae.figures.animation import Animation, animation_file, write_animation
from tegotae.figures.style import literal_text, new_figure, save_figure, styled
from tegotae.simulation.summaries import whole_trajectory
from tegotae.systems.recipe import recipe
from tegotae.training.run import Run, train as train_run


@pytest.fixture
def no_rollout(monkeypatch):
    """Any rollout fails: such requests are refused before."""

    def run(*_, **__):
        raise AssertionError("a rollout was started before the input was checked")

    monkeypatch.setattr(Rollout, "run", run)
    monkeypatch.setattr(Rollout, "run_lanes", run)
    monkeypatch.setattr("tegotae.training.run.read_checkpoint", run)


# Memory.


def test_what_does_not_fit_into_the_memory_is_told_with_both_numbers(monkeypatch):
    monkeypatch.setattr(limits, "available_memory", lambda: 2.0**30)
    require_memory(2**30, "a map")
    with pytest.raises(TegotaeError) as raised:
        require_memory(2**31, "a map")
    assert str(raised.value) == (
        "a map would need about 2 GiB of memory, and 1 GiB are free; ask for less"
    )


def test_where_the_system_does_not_say_nothing_is_refused(monkeypatch):
    monkeypatch.setattr(limits, "available_memory", lambda: None)
    require_memory(1e30, "a map")


def test_rollouts_maps_and_trainings_are_told_before_they_take_memory(monkeypatch, tmp_path):
    monkeypatch.setattr(limits, "available_memory", lambda: 2.0**20)
    rollout = Rollout(
        controller=recipe("V-reflex-w8").controller(), timing=Timing(duration_s=2000.0)
    )
    assert rollout.summary is whole_trajectory
    with pytest.raises(TegotaeError, match="a rollout of 3 lanes and 100000 frames would need"):
        rollout.run(np.ones((3, 1)), Scenario(omega=8.0))
    refused("2000 x 2000 rollouts would need", lanes, np.zeros(2000), np.zeros(2000))
    with pytest.raises(TegotaeError, match="32 episodes a generation, of 100 seeds"):
        train_run(
            Run(experiment=recipe("ART").experiment(), seeds=tuple(range(100))), tmp_path / "out"
        )
    assert os.listdir(tmp_path) == []


# Numbers and names.


@pytest.mark.parametrize("value", [10**400, "x", None, float("nan"), 1.1])
def test_a_number_beyond_its_bound_is_named(value):
    refused(r"^mass is ", require_finite, "mass", value, most=1.0)


def test_a_count_of_thousands_of_digits_is_named():
    require_count("lanes", 3, most=3)
    with pytest.raises(TegotaeError, match=r"^lanes is about 2\^16610; it must be at most 3$"):
        require_count("lanes", 10**5000, most=3)


def test_axis_keeps_within_its_bounds():
    np.testing.assert_array_equal(axis("height", 1.0, 2.0, 3, above=0.0), [1.0, 1.5, 2.0])
    with pytest.raises(TegotaeError, match=r"height \(low end\) is 0; it must be greater than 0"):
        axis("height", 0.0, 2.0, 3, above=0.0)


@pytest.mark.parametrize(
    ("name", "first"), [("art", "ART"), ("SAC", "sac"), ("Pgpe", "pgpe"), ("v-SECTOR", "V-sector")]
)
def test_capitals_keep_nobody_from_the_name_that_was_meant(name, first):
    message = str(unknown("thing", name, ["AR", "ART", "sac", "pgpe", "ppo", "V-sector"]))
    assert f"did you mean {first}" in message


# Figures and files.


NAMES = [
    "$\\frac{$",
    "$x",
    "a$b$c",
    "\\$x$",
    "[red]",
    "\udcff",
    "\x1b[31m",
    "a\nb",
    "日本",
    "%_^{}",
]


@pytest.mark.parametrize("name", NAMES)
def test_a_name_is_drawn_as_it_is_whatever_it_has(tmp_path, name, recwarn):
    with styled():
        figure = new_figure(1.0, 1.0)
        figure.subplots().set_title(literal_text(name))
    for ending in ("png", "svg", "pdf"):
        assert save_figure(figure, tmp_path / f"a.{ending}").stat().st_size > 100
    assert not recwarn.list


def test_a_dollar_is_a_dollar(tmp_path):
    with styled():
        figure = new_figure(2.0, 1.0)
        figure.subplots().set_title(literal_text("a$b$c"))
    assert "a$b$c" in save_figure(figure, tmp_path / "a.svg").read_text()


def test_half_a_character_in_a_table_is_spelled_out(tmp_path):
    write_atomically(tmp_path / "a.csv", "name\n\udcff\n")
    assert (tmp_path / "a.csv").read_text() == "name\n\\udcff\n"


def test_a_program_that_a_picture_needs_is_asked_for_before_the_work(
    tmp_path, monkeypatch, one_line_error, no_rollout
):
    monkeypatch.setattr(FFMpegWriter, "isAvailable", lambda: False)
    needs = r"writing \.mp4 needs the program ffmpeg; use \.gif or \.webp"
    with pytest.raises(TegotaeError, match=needs):
        animation_file(tmp_path / "a.mp4")
    message = one_line_error("simulate", "--animate", str(tmp_path / "a.mp4"))
    assert "needs the program" in message
    assert os.listdir(tmp_path) == []


FFMPEG = """#!/bin/sh
cat > /dev/null
for film; do :; done
echo "$*" > "$film"
"""
"""A program that takes pictures as ffmpeg does, and writes its options in place of a film."""


@pytest.mark.skipif(os.name == "nt", reason="its program is for a shell of POSIX")
@pytest.mark.parametrize("ending", ["mp4", "webm"])
def test_a_film_of_ffmpeg_has_pixels_that_browsers_show(tmp_path, ending):
    program, film = tmp_path / "ffmpeg", tmp_path / f"a.{ending}"
    program.write_text(FFMPEG)
    program.chmod(0o700)
    with rc_context({"animation.ffmpeg_path": str(program)}):
        write_animation(lambda: Animation(Figure(), lambda frame: None, range(3)), film)
    options_of_film = film.read_text().partition("-i pipe:")[2]
    assert "-pix_fmt yuv420p" in options_of_film


def test_a_film_without_ffmpeg_has_all_its_pictures(tmp_path):
    def animation() -> Animation:
        figure = Figure()
        line = figure.add_artist(Line2D([0, 1], [0, 1]))
        return Animation(figure, lambda frame: line.set_ydata([0, frame]), range(3))

    film = write_animation(animation, tmp_path / "a.webp")
    with Image.open(film) as pictures:
        assert (pictures.format, pictures.n_frames) == ("WEBP", 3)


@pytest.mark.parametrize(
    "error", [OSError(28, "No space left on device"), subprocess.CalledProcessError(1, "ffmpeg")]
)
def test_half_an_animation_is_not_kept(tmp_path, error):
    def draw(frame: int) -> None:
        if frame == 1:
            raise error

    path = tmp_path / "a.gif"
    path.write_bytes(b"before")
    with pytest.raises(TegotaeError, match=r"No space left on device|ffmpeg failed"):
        write_animation(lambda: Animation(Figure(), draw, range(3)), path)
    assert path.read_bytes() == b"before"
    assert os.listdir(tmp_path) == ["a.gif"]
