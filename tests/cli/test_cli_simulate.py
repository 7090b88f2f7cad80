"""`tegotae simulate`: numbers, a plot, an animation; and one line for what it cannot simulate."""

import csv
import dataclasses
import json
import math
import xml.etree.ElementTree
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

import tiny
from tegotae import Hopper, Rollout, System, TegotaeError, Timing
from tegotae.analysis.simulation import simulate as rolled_out
from tegotae.cli import main
from tegotae.systems import controller_file
from tegotae.systems.system import Release
from tegotae.systems.vanilla import preset

SHORT = ("--duration-s", "4")
"""One duration for all: another one compiles another program."""


@pytest.fixture
def simulate(capsys):
    """A function that runs `tegotae simulate --json` and returns the object."""

    def run(*options: str) -> dict[str, Any]:
        first = next((i for i, word in enumerate(options) if word[:2] == "--"), len(options))
        words = [*options[:first], "--json", *SHORT, *options[first:]]
        assert main(["simulate", *words]) == 0
        out, err = capsys.readouterr()
        assert err == ""
        assert len(out.splitlines()) == 1
        return json.loads(out)

    return run


@pytest.fixture
def no_rollouts(monkeypatch):
    """Makes any rollout fail the test."""

    def run(*_, **__):
        raise AssertionError("a rollout was started before the input was checked")

    monkeypatch.setattr(Rollout, "run", run)


# What comes out.


def test_json_is_one_object_with_the_result_and_the_parameters_used(simulate):
    found = simulate()
    assert found["apex_time_s"]
    assert len(found["apex_time_s"]) == len(found["apex_height_m"]) == len(found["apex_phase_rad"])
    assert found["work_j"] > 0.0
    assert found["cot_inverse_total"] > found["cot_inverse_flight"] > 0.0
    assert found["window_s"] == [found["apex_time_s"][-1 - found["hops"]], found["apex_time_s"][-1]]
    assert (found["failed"], found["failed_time_s"]) == (False, None)
    assert (found["name"], found["work"]) == ("paper", "absolute")
    used = found["settings"]
    assert (used["omega"], used["sigma"], used["release"]["height_m"]) == (5.0, 2.753, 1.2)
    assert used["body"] == dataclasses.asdict(Hopper())


def test_without_json_people_read_apexes_cot_and_work(capsys, simulate):
    found = simulate()
    assert main(["simulate", *SHORT]) == 0
    out = capsys.readouterr().out
    heights = ", ".join(f"{height:.4f}" for height in found["apex_height_m"][-4:])
    assert f"{len(found['apex_height_m'])} apexes; the last at {heights} m" in out
    begin, end = found["window_s"]
    assert f"from {begin:.2f} to {end:.2f} s" in out
    for label, name in (("CoT⁻¹ (flight) [m/J]", "cot_inverse_flight"), ("work [J]", "work_j")):
        (line,) = [line for line in out.splitlines() if label in line]
        assert line.split()[-1] == f"{found[name]:.4g}"


def test_every_option_reaches_the_rollout(simulate):
    options = {
        "--omega": "6",
        "--sigma": "1.5",
        "--height-m": "1.3",
        "--velocity-m-per-s": "0.1",
        "--phase-rad": "0.5",
        "--drop-m": "0.2",
        "--drop-time-s": "2",
        "--mass-kg": "0.12",
        "--stiffness-n-per-m": "6",
        "--damping-ns-per-m": "0.15",
        "--flight-damping-ns-per-m": "0.05",
        "--rest-length-m": "0.9",
        "--gravity-m-per-s2": "9.8",
        "--max-force-n": "3.5",
        "--work": "positive",
        "--measure-from-s": "1",
        "--tick-s": "0.002",
    }
    words = (word for option in options.items() for word in option)
    found = simulate("pyTegotaeCPG-both", *words)
    system = System(
        controller=preset("pyTegotaeCPG").controller("both"),
        omega=6.0,
        release=Release(height_m=1.3, velocity_m_per_s=0.1, phase_rad=0.5),
        body=Hopper(
            mass_kg=0.12,
            stiffness_n_per_m=6.0,
            damping_ns_per_m=0.15,
            flight_damping_ns_per_m=0.05,
            rest_length_m=0.9,
            gravity_m_per_s2=9.8,
            max_force_n=3.5,
        ),
    )
    expected = rolled_out(
        system,
        [1.5],
        Timing(duration_s=4.0, tick_s=0.002, frame_s=0.01),
        drop_m=0.2,
        drop_time_s=2.0,
        work="positive",
        measure_from_s=1.0,
    )
    assert found == {**found, **json.loads(json.dumps(expected.summary()))}
    assert found["settings"]["body"] == dataclasses.asdict(system.body)


def test_a_vanilla_controller_may_have_another_oscillator(simulate):
    assert simulate("paper+van-der-pol")["apex_height_m"] != simulate("paper")["apex_height_m"]


def test_double_precision_is_an_option_and_agrees(simulate):
    single, double = simulate(), simulate("--float64")
    assert double["settings"]["float64"]
    np.testing.assert_allclose(single["apex_height_m"], double["apex_height_m"], atol=1e-4)


def test_the_time_series_has_units_in_its_names_and_a_row_a_frame(simulate, tmp_path):
    simulate("--csv", str(tmp_path / "hops.csv"))
    with (tmp_path / "hops.csv").open() as stream:
        rows = list(csv.DictReader(stream))
    assert list(rows[0])[:4] == ["time_s", "height_m", "velocity_m_per_s", "phase_rad"]
    assert {"spring_force_n", "feedback_rad_per_s", "actuator_force_n"} < set(rows[0])
    assert len(rows) == 400
    assert float(rows[-1]["time_s"]) == pytest.approx(4.0)
    for row in rows:
        spring = 5.0 * max(0.0, 1.0 - float(row["height_m"]))
        assert float(row["spring_force_n"]) == pytest.approx(spring, abs=1e-4)


def test_the_time_series_tells_work_and_climbs_as_the_summary_does(simulate, tmp_path):
    found = simulate("--csv", str(tmp_path / "hops.csv"), "--work", "positive")
    with (tmp_path / "hops.csv").open() as stream:
        rows = list(csv.DictReader(stream))
    begin, end = (rows[math.ceil(at / 0.01) - 1] for at in found["window_s"])
    for column, told in (
        ("work_j", "work_j"),
        ("climb_m", "climb_total_m"),
        ("climb_flight_m", "climb_flight_m"),
    ):
        assert float(end[column]) - float(begin[column]) == pytest.approx(found[told], rel=1e-5)


def test_a_held_rollout_says_so_and_hops_a_little_otherwise(simulate):
    held, continuous = simulate("--hold"), simulate()
    assert held["settings"]["hold"]
    assert not continuous["settings"]["hold"]
    gap = np.subtract(held["apex_height_m"][:2], continuous["apex_height_m"][:2])
    assert 0.0 < np.abs(gap).max() < 0.2


def test_a_failed_rollout_is_a_result_not_an_error(capsys, simulate):
    found = simulate("--stiffness-n-per-m", "0.5")
    assert found["failed"]
    assert 0.0 < found["failed_time_s"] < 2.0
    assert found["cot_inverse_flight"] is None
    assert main(["simulate", *SHORT, "--stiffness-n-per-m", "0.5"]) == 0
    out = capsys.readouterr().out
    assert f"failed at {found['failed_time_s']:.2f} s" in out
    assert "0 apexes\nno CoT⁻¹: the rollout failed\n" in out


# Trained controllers.


def test_a_controller_file_is_simulated_as_it_was_trained(simulate, tiny_training):
    for path in tiny.controllers(tiny_training):
        saved = controller_file.load(path)
        assert isinstance(saved.body, Hopper)
        found = simulate(str(path))
        expected = rolled_out(saved.system, saved.weights, Timing(duration_s=4.0, frame_s=0.01))
        assert found == {**found, **json.loads(json.dumps(expected.summary()))}
        assert (found["settings"]["omega"], found["settings"]["sigma"]) == (saved.omega, None)


def test_a_trained_controller_can_be_driven_at_another_frequency_on_another_hopper(
    simulate, tiny_training
):
    path = str(tiny.controllers(tiny_training)[0])
    found = simulate(path, "--omega", "6", "--mass-kg", "0.12")
    assert (found["settings"]["omega"], found["settings"]["body"]["mass_kg"]) == (6.0, 0.12)
    assert found["apex_height_m"] != simulate(path)["apex_height_m"]


def test_a_gain_is_refused_beside_a_trained_controller(tiny_training, one_line_error, no_rollouts):
    said = one_line_error("simulate", str(tiny.controllers(tiny_training)[0]), "--sigma", "2")
    assert "sigma belongs to vanilla controllers" in said


# Pictures.


def is_readable(path: Path) -> bool:
    """Return True if a picture has the format of its ending."""
    if path.suffix == ".svg":
        return xml.etree.ElementTree.parse(path).getroot().tag.endswith("svg")
    if path.suffix == ".pdf":
        return path.read_bytes().startswith(b"%PDF-") and b"%%EOF" in path.read_bytes()[-16:]
    with Image.open(path) as picture:
        picture.load()
        return min(picture.size) > 100


@pytest.mark.parametrize("ending", [".png", ".pdf", ".svg", ".PNG"])
def test_a_plot_is_written_in_the_format_of_its_ending(simulate, tmp_path, ending):
    path = tmp_path / "new" / f"hop{ending}"
    simulate("--plot", str(path))
    assert is_readable(path)


def test_an_animation_moves_and_reports_its_progress(tmp_path, capsys):
    path = tmp_path / "hop.gif"
    assert main(["simulate", "--duration-s", "0.4", "--animate", str(path)]) == 0
    assert "animation  10/10" in capsys.readouterr().err
    with Image.open(path) as picture:
        assert picture.n_frames == 10
        first = np.asarray(picture.convert("RGB"))
        picture.seek(5)
        assert (np.asarray(picture.convert("RGB")) != first).any()


def test_a_picture_that_cannot_be_drawn_costs_no_numbers(tmp_path, monkeypatch, capsys):
    def fails(*_):
        raise TegotaeError("the disk is full")

    monkeypatch.setattr("tegotae.figures.animation.write_animation", fails)
    words = ["simulate", "--duration-s", "0.4", "--animate", str(tmp_path / "hop.gif")]
    assert main(words) != 0
    assert "apexes" in capsys.readouterr().out


def test_a_controller_without_oscillator_has_pictures_too(simulate, tmp_path):
    from tegotae.systems.controller_file import SavedController, save
    from tegotae.systems.recipe import recipe

    single = recipe("T-Fv").controller(8)
    save(
        SavedController.from_weights(single, np.full(single.n_weights, 0.5), None),
        tmp_path / "t.json",
    )
    picture = tmp_path / "t.png"
    simulate(str(tmp_path / "t.json"), "--plot", str(picture))
    assert is_readable(picture)


def test_the_shortest_rollout_has_pictures_too(capsys, tmp_path):
    plot, film = tmp_path / "hop.png", tmp_path / "hop.gif"
    words = ["simulate", "--duration-s", "0.01", "--plot", str(plot), "--animate", str(film)]
    assert main(words) == 0
    assert is_readable(plot)
    assert is_readable(film)
    assert "0 apexes" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("option", "name", "said"),
    [
        ("--plot", "hop.xyz", "use an ending such as .png, .pdf or .svg"),
        ("--plot", "hop", "use an ending such as .png, .pdf or .svg"),
        ("--plot", "hop.html", "use an ending such as .png, .pdf or .svg"),
        ("--animate", "hop.avi", "use .gif, .webp, .mp4 or .webm"),
        ("--animate", "hop", "use .gif, .webp, .mp4 or .webm"),
        ("--plot", "file/hop.png", "cannot write to the folder"),
        ("--animate", "file/hop.gif", "cannot write to the folder"),
        ("--plot", "folder.png", "it is a folder"),
        ("--animate", "folder.gif", "it is a folder"),
    ],
)
def test_pictures_that_could_not_be_written_are_refused_before_the_rollout(
    tmp_path, one_line_error, no_rollouts, option, name, said
):
    (tmp_path / "file").touch()
    for folder in ("folder.png", "folder.gif"):
        (tmp_path / folder).mkdir()
    assert said in one_line_error("simulate", option, str(tmp_path / name))
