"""`tegotae demo`: a learned hopper hops at once, and leaves a picture, a film and a next step."""

import shlex

import pytest

from tegotae.api.demo import demo
from tegotae.cli import main


def test_a_film_and_a_picture_of_a_hop_over_a_drop_are_in_the_folder(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    main(["demo"])
    assert "5 apexes" in capsys.readouterr().out
    assert (tmp_path / "demo/hop.png").read_bytes().startswith(b"\x89PNG")
    assert (tmp_path / "demo/hop.gif").read_bytes().startswith(b"GIF89a")


@pytest.fixture(scope="module")
def shown():
    return demo()


def test_it_may_run_again_in_the_same_folder(shown, tmp_path):
    first = shown.save(tmp_path / "twice")
    assert [path.name for path in shown.save(tmp_path / "twice")] == [x.name for x in first]


def test_every_next_step_is_a_command(shown, capsys):
    steps = [line for line in shown.notes if line.startswith("tegotae ")]
    assert len(steps) == 3
    for step in steps:
        command = shlex.split(step, comments=True)[1]
        assert main([command, "--help"] if command != "--help" else ["--help"]) == 0


def test_a_robot_that_is_no_file_is_refused_before_anything_is_written(
    tmp_path, monkeypatch, capsys
):
    monkeypatch.chdir(tmp_path)
    assert main(["demo", "--robot", "nosuch.toml"]) == 2
    assert "there is no file nosuch.toml" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())
