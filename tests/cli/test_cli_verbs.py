"""One verb a question, whatever the number of legs."""

import dataclasses
import json
import sys
from pathlib import Path

import numpy as np
import pytest

from tegotae import System, Timing
from tegotae.cli import main
from tegotae.measures.evaluation import Protocol
from tegotae.parts.bodies import Interface
from tegotae.simulation.integrators import Hold
from tegotae.systems import controller_file
from tegotae.systems.controller_file import SavedController
from tegotae.systems.recipe import recipe
from tegotae.systems.system import Release
from tegotae.training.collection import read_runs


@pytest.fixture
def foreign(tmp_path):
    """The file of a controller whose limb a foreign simulator moves."""
    body = Interface()
    system = System(controller=recipe("V-reflex-w8").controller(), body=body, omega=8.0)
    controller_file.save(SavedController(system, np.ones(1)), tmp_path / "there.json")
    return str(tmp_path / "there.json")


@pytest.mark.parametrize(
    "words", ["simulate", "evaluate", "figure basin --out b.png", "figure surface --out s.png"]
)
def test_what_moves_in_a_foreign_simulator_is_said_not_to_be_here(foreign, words, one_line_error):
    first, *more = words.split(" --")
    options = [word for each in more for word in f"--{each}".split()]
    said = one_line_error(*first.split(), foreign, *options)
    assert "drives the limbs of another simulator, whose mechanics are not here" in said


@pytest.fixture
def held(tmp_path):
    """The file of a held controller with a release and a protocol of its own."""
    experiment = recipe("V-reflex-w8").experiment(
        integrator=Hold(),
        timing=Timing(duration_s=16.0, tick_s=0.004, frame_s=0.012),
        release=Release(height_m=1.1, phase_rad=0.5, velocity_m_per_s=0.1),
        protocol=Protocol(undisturbed_s=5.0, disturbed_s=5.0, drop_m=0.1, release_m=1.1),
    )
    path = tmp_path / "held.json"
    controller_file.save(
        SavedController(experiment.system, np.array([2.0]), "held", experiment), path
    )
    return path


def test_a_simulation_takes_release_hold_and_period_from_the_file(held, capsys):
    assert main(["simulate", str(held), "--duration-s", "2", "--json"]) == 0
    used = json.loads(capsys.readouterr().out)["settings"]
    release = {"height_m": 1.1, "velocity_m_per_s": 0.1, "phase_rad": 0.5}
    assert used["release"] == {**used["release"], **release}
    assert (used["tick_s"], used["hold"]) == (0.004, True)
    options = [
        "--height-m",
        "1.2",
        "--phase-rad",
        "0",
        "--tick-s",
        "0.002",
        "--duration-s",
        "2",
        "--json",
    ]
    assert main(["simulate", str(held), *options]) == 0
    used = json.loads(capsys.readouterr().out)["settings"]
    release = used["release"]
    assert (release["height_m"], release["phase_rad"], used["tick_s"]) == (1.2, 0.0, 0.002)


def test_an_evaluation_takes_the_system_and_the_protocol_of_the_file(held, monkeypatch):
    asked = []

    def evaluate(controller, weights, omega, body, protocol, *, metrics, start, integrator):
        asked.append((protocol, start, integrator))
        raise KeyboardInterrupt

    monkeypatch.setattr("tegotae.api.hopping.evaluate", evaluate)
    own = Protocol(undisturbed_s=5.0, disturbed_s=5.0, drop_m=0.1, release_m=1.1, tick_s=0.004)
    main(["evaluate", str(held)])
    main(["evaluate", str(held), "--drop-m", "0.3", "--work", "net"])
    (first, start, integrator), (second, *_) = asked
    assert first == own
    assert (start.phase_rad, start.velocity_m_per_s, integrator) == (0.5, 0.1, Hold())
    assert second == dataclasses.replace(own, drop_m=0.3, work="net")


def test_a_model_of_the_paper_is_evaluated_by_the_papers_protocol():
    (runs,) = read_runs("V-reflex-w8")
    assert runs.protocol == Protocol()


def test_sets_with_other_protocols_are_not_compared(held, one_line_error):
    said = one_line_error("compare", "V-reflex-w8", str(held))
    assert "are evaluated with another undisturbed_s" in said


def test_legs_are_simulated_into_the_files_that_are_named(tmp_path, capsys):
    table = tmp_path / "walk.csv"
    words = ["simulate", "bar-light", "--duration-s", "20", "--csv", str(table), "--json"]
    assert main([*words, "--mass-kg", "0.11"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["settings"]["body"]["mass_kg"] == 0.11
    assert table.exists()


def test_legs_are_evaluated_as_one_json_object(capsys):
    assert main(["evaluate", "bar-light", "--starts", "2", "--json"]) == 0
    (found,) = json.loads(capsys.readouterr().out)["rows"]
    assert (found["controller"], found["omega"], found["gait"]) == ("bar-light", 8.0, "antiphase")


def test_a_policy_is_drawn_by_the_command(tmp_path, monkeypatch):
    pytest.importorskip("gymnasium")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", [*sys.path])
    Path("drawn_policy.py").write_text("def push(spring_force_n):\n    return spring_force_n\n")
    words = ["--policy", "drawn_policy.py:push", "--settle-s", "1", "--resolution", "3"]
    assert main(["figure", "surface", *words, "--out", "surface.png"]) == 0
    assert Path("surface.png").exists()
