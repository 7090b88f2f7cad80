"""`simulate … --view`: MuJoCo's viewer shows an episode on a robot."""

import os
import shutil
import subprocess
import sys

import pytest

from tegotae.cli import main

pytest.importorskip("mujoco")

SCRIPT = """
import tegotae
from tegotae.figures.viewer import view
view(tegotae.load("leg.json").simulate(duration_s=0.2).raw, repeats=1)
print("viewed")
"""


@pytest.fixture
def leg(tmp_path, monkeypatch):
    """A folder with an untrained controller of the package's MuJoCo leg, as the present one."""
    monkeypatch.chdir(tmp_path)
    words = ["train", "V-sector-w8", "--env", "leg", "--duration-s", "2", "--seeds", "1"]
    assert main([*words, "--out", "runs"]) == 0
    shutil.copy(next((tmp_path / "runs").glob("*-seed0.json")), tmp_path / "leg.json")
    return tmp_path


@pytest.fixture
def screen(tmp_path):
    """The name of a virtual screen."""
    if shutil.which("Xvfb") is None:
        pytest.skip("Xvfb is not installed")
    with subprocess.Popen(
        ["Xvfb", "-displayfd", "1", "-nolisten", "tcp"],
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
    ) as server:
        assert server.stdout is not None
        yield f":{server.stdout.readline().strip()}"
        server.terminate()


def test_a_window_shows_an_episode_to_its_end(leg, screen):
    paths = os.pathsep.join(sys.path)
    run = subprocess.run(
        [sys.executable, "-c", SCRIPT],
        env={**os.environ, "PYTHONPATH": paths, "DISPLAY": screen, "LIBGL_ALWAYS_SOFTWARE": "1"},
        capture_output=True,
        text=True,
        timeout=300,
    )
    assert run.returncode == 0, run.stderr
    assert run.stdout.endswith("viewed\n")


def test_a_screen_that_is_not_there_is_told_in_one_line(leg, monkeypatch, capsys):
    monkeypatch.setenv("DISPLAY", ":987654")
    assert main(["simulate", "leg.json", "--duration-s", "0.2", "--view"]) == 2
    assert "no window can be opened" in capsys.readouterr().err


def test_without_a_screen_it_says_so_in_one_line(leg, monkeypatch, capsys):
    monkeypatch.setattr(sys, "platform", "linux")
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    assert main(["simulate", "leg.json", "--duration-s", "0.2", "--view"]) == 2
    assert "there is no screen for a window" in capsys.readouterr().err


def test_a_hopper_of_the_engine_has_no_viewer(capsys):
    assert main(["simulate", "paper", "--duration-s", "1", "--view"]) == 2
    assert "is on no MuJoCo model" in capsys.readouterr().err
