"""A training on disk: stopped in any way it goes on, and ends in the same numbers."""

import dataclasses
import errno
import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import tiny
from lowered import available_targets
from refusals import refused
from tegotae import Hopper, Rollout, Scenario, TegotaeError, Timing
from tegotae.measures.evaluation import Protocol
from tegotae.measures.objectives.fitness import Fitness
from tegotae.systems import controller_file
from tegotae.systems.experiment import GAINS
from tegotae.systems.recipe import recipe
from tegotae.training import run as training_run
from tegotae.training.algorithms import PGPE
from tegotae.training.evolution import Stopping
from tegotae.training.run import Run, train

# What is written.


def test_a_controller_per_seed_is_returned_with_how_it_was_trained_the_same_in_every_run(
    tiny_training, tmp_path
):
    paths = train(tiny.RUN, tmp_path)
    assert tiny.learned(tmp_path) == tiny.learned(tiny_training)
    assert [path.name for path in paths] == [p.name for p in tiny.controllers(tiny_training)]
    for seed, path in zip(tiny.SEEDS, paths, strict=True):
        saved = controller_file.load(path)
        assert saved.name == "ART-rF-tphif-w8"
        assert saved.controller == recipe("ART").controller(20)
        assert (saved.omega, saved.body) == (8.0, Hopper())
        assert saved.training["seed"] == seed
        assert saved.training["generations"] == tiny.GENERATIONS
        assert 0 <= saved.training["best_generation"] < tiny.GENERATIONS
        assert set(saved.software) == {"tegotae", "jax", "jaxlib", "numpy", "engine"}


def test_the_best_distribution_of_the_curves_is_the_one_kept(tiny_training):
    learned = tiny.learned(tiny_training)
    header, *rows = learned["curves"]
    assert header[:3] == ["seed", "step", "simulated_s"]
    for seed, outcome in zip(tiny.SEEDS, learned["training"], strict=True):
        fitness = [float(row[3]) for row in rows if int(row[0]) == seed]
        assert len(fitness) == tiny.GENERATIONS
        assert outcome["best_generation"] == int(np.argmax(fitness))
        assert outcome["best_fitness"] == pytest.approx(max(fitness), rel=1e-5)


def test_a_seeds_result_does_not_depend_on_the_others(tiny_training, tmp_path):
    (path,) = train(dataclasses.replace(tiny.RUN, seeds=(1,)), tmp_path)
    together = controller_file.load(tiny.controllers(tiny_training)[1])
    alone = controller_file.load(path)
    # Lanes are computed alike, but for rounding in a vector that is filled otherwise.
    np.testing.assert_allclose(alone.weights, together.weights, rtol=0.0, atol=1e-4)
    for name in ("best_fitness", "best_generation"):
        assert alone.training[name] == pytest.approx(together.training[name], abs=1e-3)


def test_every_generation_is_told(tmp_path):
    steps = []
    train(tiny.RUN, tmp_path, on_step=steps.append)
    assert [step.done for step in steps] == [1, 2, 3, 4]
    for generation, step in enumerate(steps):
        assert [point[:2] for point in step.new] == [(0, generation), (1, generation)]
        assert {point.simulated_s for point in step.new} == {generation * 8 * 3.0}


# Stopped and going on.


def stop_at(generation: int, stop):
    """A function that stops the training after that generation."""

    def on_step(step):
        if step.done == generation:
            stop()

    return on_step


def interrupt():
    raise KeyboardInterrupt


@pytest.mark.parametrize("generation", [1, 3])
def test_an_interrupted_training_keeps_what_it_learned_and_goes_on(
    tiny_training, tmp_path, generation
):
    with pytest.raises(KeyboardInterrupt):
        train(tiny.RUN, tmp_path, on_step=stop_at(generation, interrupt))
    interrupted = tiny.learned(tmp_path)
    complete = tiny.learned(tiny_training)
    header, *rows = complete["curves"]
    assert interrupted["curves"] == [header, *(row for row in rows if int(row[1]) < generation)]
    assert [t["generations"] for t in interrupted["training"]] == [generation] * 2

    steps = []
    train(tiny.RUN, tmp_path, on_step=lambda step: steps.append(step.done))
    assert steps == list(range(generation + 1, tiny.GENERATIONS + 1))
    assert tiny.learned(tmp_path) == complete


def test_a_finished_training_is_left_as_it_is(tiny_training):
    content = tiny.contents(tiny_training)
    train(tiny.RUN, tiny_training)
    assert tiny.contents(tiny_training) == content


KILLED = """
import os, signal, sys
from pathlib import Path
import conftest  # the tests' promotion rules: with others XLA may round otherwise
import tiny
from tegotae.training.evolution import Stopping
from tegotae.training.run import train

def kill(step):
    if step.done == 3:
        os.kill(os.getpid(), signal.SIGKILL)

train(tiny.RUN, Path(sys.argv[1]), on_step=kill)
"""


def test_a_killed_training_goes_on_and_ends_in_the_same_numbers(tiny_training, tmp_path):
    killed = subprocess.run(
        [sys.executable, "-c", KILLED, str(tmp_path)],
        env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)},
        capture_output=True,
    )
    assert killed.returncode == -signal.SIGKILL, killed.stderr
    with np.load(tmp_path / "checkpoint.npz", allow_pickle=False) as stored:
        assert 2 <= len(stored["points"]) < 2 * tiny.GENERATIONS
    record = json.loads((tmp_path / "run.json").read_text())
    assert record["software"]["engine"] == "native"
    train(tiny.RUN, tmp_path)
    assert tiny.learned(tmp_path) == tiny.learned(tiny_training)


WITH_VECTORS = """
import sys
from pathlib import Path
from lanewise import machine

chosen = machine.target_of(sys.argv[1])
machine._host = lambda name: chosen

import conftest
import tiny
from tegotae.training.run import train

train(tiny.RUN, Path(sys.argv[2]))
"""


@pytest.mark.thorough
@pytest.mark.skipif("avx512" not in available_targets(), reason="the processor has no AVX-512")
def test_a_training_is_the_same_bits_with_avx2_and_avx512(tmp_path):
    """Native code for either; XLA, which summarises and learns, without AVX-512 or as it likes."""
    for vectors, flags in (("avx512", ""), ("avx2", "--xla_cpu_max_isa=AVX2")):
        path = os.pathsep.join(sys.path)
        subprocess.run(
            [sys.executable, "-c", WITH_VECTORS, vectors, str(tmp_path / vectors)],
            env={**os.environ, "PYTHONPATH": path, "XLA_FLAGS": flags},
            check=True,
        )
    assert tiny.learned(tmp_path / "avx512") == tiny.learned(tmp_path / "avx2")


def test_an_interrupt_while_results_are_written_loses_nothing(tiny_training, tmp_path, monkeypatch):
    with monkeypatch.context() as patch:
        patch.setattr(training_run, "write_curves", lambda *_, **__: interrupt())
        with pytest.raises(KeyboardInterrupt):
            train(tiny.RUN, tmp_path)
    assert not list(tmp_path.glob("*-seed*.json"))
    train(tiny.RUN, tmp_path)
    assert tiny.learned(tmp_path) == tiny.learned(tiny_training)


# Whose folder it is.

OTHERS = {
    "name": tiny.changed(name="AR"),
    "seeds": dataclasses.replace(tiny.RUN, seeds=(0, 1, 2)),
    "algorithm.population": dataclasses.replace(
        tiny.RUN,
        learner=dataclasses.replace(
            tiny.RUN.learner,
            algorithm=dataclasses.replace(tiny.RUN.learner.algorithm, population=10),
        ),
    ),
    "timing.duration_s": tiny.changed(timing=Timing(duration_s=4.0, tick_s=0.002)),
    "objective.settle_s": tiny.changed(objective=Fitness(settle_s=0.5)),
    "objective.work": tiny.changed(objective=Fitness(settle_s=1.0, work="positive")),
    "controller": tiny.changed(controller=recipe("ART").controller(30)),
    "omega": tiny.changed(omega=7.0),
    "body.mass_kg": tiny.changed(body=Hopper(mass_kg=0.2)),
    "release.height_m": tiny.changed(height_m=1.1),
    "protocol.drop_m": tiny.changed(protocol=Protocol(drop_m=0.1)),
}


@pytest.mark.parametrize("name", OTHERS)
def test_a_folder_of_another_training_is_refused_and_left_as_it_is(tiny_training, name):
    content = tiny.contents(tiny_training)
    message = f"^{tiny_training} holds a training of ART-rF-tphif-w8 that differs in {name}; "
    refused(message, lambda: train(OTHERS[name], tiny_training))
    assert tiny.contents(tiny_training) == content


def test_a_training_that_learned_nothing_does_not_claim_its_folder(tmp_path, monkeypatch):
    with monkeypatch.context() as patch:
        patch.setattr("tegotae.training.evolution.Evolution.evolve", lambda *_, **__: interrupt())
        with pytest.raises(KeyboardInterrupt):
            train(tiny.changed(controller=recipe("ART").controller(30)), tmp_path)
    assert list(tiny.contents(tmp_path)) == ["run.json"]
    train(tiny.RUN, tmp_path)
    assert tiny.learned(tmp_path)["configuration"] == tiny.RUN.configuration


def copy_of(folder: Path, to: Path) -> Path:
    for name, content in tiny.contents(folder).items():
        (to / name).write_bytes(content)
    return to


def with_arrays(change):
    """A change of the arrays of a checkpoint."""

    def changed_file(folder: Path) -> None:
        with np.load(folder / "checkpoint.npz") as stored:
            arrays = dict(stored)
        change(arrays)
        np.savez(folder / "checkpoint.npz", **arrays)

    return changed_file


def without(section: str, entry: str):
    """A change of `run.json`: an entry is lacking."""

    def change(folder: Path) -> None:
        document = json.loads((folder / "run.json").read_text())
        del document[section][entry]
        (folder / "run.json").write_text(json.dumps(document))

    return change


def changed(name: str, change):
    """A change of a file's bytes."""
    return lambda folder: (folder / name).write_bytes(change((folder / name).read_bytes()))


CHECKPOINT, ACCOUNT = r"checkpoint\.npz is damaged; ", r"run\.json is damaged: "
DAMAGE = {
    "a checkpoint cut off": (changed("checkpoint.npz", lambda x: x[: len(x) // 2]), CHECKPOINT),
    "one without its end": (changed("checkpoint.npz", lambda x: x[:-1]), CHECKPOINT),
    "one of something else": (changed("checkpoint.npz", lambda x: b"hello"), CHECKPOINT),
    "one with bytes changed": (
        changed("checkpoint.npz", lambda x: x.replace(b"\x93NUMPY", b"\x93NUMPI")),
        CHECKPOINT,
    ),
    "one that does not say what it is of": (
        with_arrays(lambda arrays: arrays.pop("configuration")),
        CHECKPOINT,
    ),
    "one whose search has one more array": (
        with_arrays(lambda arrays: arrays.update(leaf8=np.zeros(1))),
        r"checkpoint\.npz is of another version of this learner, .* or start again with",
    ),
    **{
        f"an account that is {text!r}": (changed("run.json", lambda _, text=text: text), ACCOUNT)
        for text in (b"", b"{", b"[]", b"null", b'{"configuration": [1]}', b"\xff")
    },
    "an account without engine": (without("software", "engine"), ACCOUNT + ".*engine"),
    "one without experiment": (without("configuration", "experiment"), ACCOUNT + ".*experiment"),
    "no account": (lambda folder: (folder / "run.json").unlink(), r"but no run\.json"),
}


@pytest.mark.parametrize("name", DAMAGE)
def test_a_damaged_folder_is_refused_and_left_as_it_is(tiny_training, tmp_path, name):
    damage, message = DAMAGE[name]
    folder = copy_of(tiny_training, tmp_path)
    damage(folder)
    content = tiny.contents(folder)
    refused(f"^{folder}.*{message}[^\n]+$", train, tiny.RUN, folder)
    assert {**tiny.contents(folder), "run.json": b""} == {**content, "run.json": b""}


@pytest.mark.parametrize("name", OTHERS)
def test_a_checkpoint_of_another_training_is_refused_whatever_the_folder_says(
    tiny_training, tmp_path, name
):
    other_run = OTHERS[name]
    folder = copy_of(tiny_training, tmp_path)
    document = json.loads((folder / "run.json").read_text())
    document["configuration"] = other_run.configuration
    (folder / "run.json").write_text(json.dumps(document, indent=1) + "\n")
    content = tiny.contents(folder)
    message = f"^{folder / 'checkpoint.npz'} is of a training that differs in {name}; remove it "
    refused(message, train, other_run, folder)
    assert tiny.contents(folder) == content


def test_a_checkpoint_that_cannot_be_read_is_not_called_damaged(
    tiny_training, tmp_path, monkeypatch
):
    def denied(*_, **__):
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))

    folder = copy_of(tiny_training, tmp_path)
    monkeypatch.setattr(np, "load", denied)
    with pytest.raises(TegotaeError) as raised:
        train(tiny.RUN, folder)
    assert str(raised.value) == f"cannot read {folder / 'checkpoint.npz'}: Permission denied"


# The search of a pure V model.


def test_a_vanilla_models_gain_is_the_fittest_of_the_grid(tmp_path):
    experiment = recipe("V-sector-w4").experiment(**tiny.SETTINGS)
    run = dataclasses.replace(tiny.RUN, experiment=experiment)
    paths = train(run, tmp_path)
    # A search has no randomness: it is one run, whatever the seeds.
    assert [path.name for path in paths] == [f"V-sector-w4-seed{tiny.SEEDS[0]}.json"]
    (sigma,) = controller_file.load(paths[0]).weights
    fitness = Rollout(
        controller=experiment.controller, timing=experiment.timing, summary=Fitness(settle_s=1.0)
    ).run(GAINS[:, None], Scenario(omega=4.0))["fitness"]
    assert sigma == GAINS[np.argmax(fitness)]
    outcome = controller_file.load(paths[0]).training
    assert outcome["best_fitness"] == pytest.approx(fitness.max())
    configuration = json.loads((tmp_path / "run.json").read_text())["configuration"]
    assert configuration["experiment"]["name"] == "V-sector-w4"


# What is refused before anything is written.


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"seeds": ()}, "seeds is 0; it must be a whole number of at least 1"),
        ({"seeds": (0, 0)}, r"seeds are \(0, 0\); each may be given only once"),
        ({"seeds": (-1,)}, "seed is -1; it must be a whole number of at least 0"),
        ({"seeds": (2**31,)}, r"seed is 2147483648; it must be at most 2147483647"),
        ({"seeds": (0.5,)}, r"seed is 0\.5; it must be a whole number"),
    ],
)
def test_a_run_of_unusable_numbers_is_refused(changed, message):
    refused(f"^{message}", dataclasses.replace, tiny.RUN, **changed)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        (
            {"body": Hopper(mass_kg=0.5)},
            r"this hopper cannot hop: .* 4 N at most, .* 4\.905 N",
        ),
        ({"height_m": 0.9}, r"released from 0\.9 m this hopper does not fall onto its leg"),
        ({"height_m": 30.0}, "released from 30 m this hopper breaks its leg"),
    ],
)
def test_a_body_that_cannot_hop_is_refused_before_the_training(tmp_path, settings, message):
    refused(f"^{message}", lambda: train(tiny.changed(**settings), tmp_path / "new"))
    assert not (tmp_path / "new").exists()


def test_a_run_of_defaults_is_the_papers():
    run = Run(experiment=recipe("ART").experiment())
    assert isinstance(run.learner.algorithm, PGPE)
    assert run.learner.stopping == Stopping()
    assert run.experiment.measure == Fitness(work="absolute", follow_omega=True)
    alone = Run(experiment=recipe("T").experiment())
    assert alone.experiment.measure == Fitness(follow_omega=False)


def test_a_folder_of_the_other_engine_is_refused_and_left_as_it_is(tiny_training, monkeypatch):
    content = tiny.contents(tiny_training)
    assert json.loads((tiny_training / "run.json").read_text())["software"]["engine"] == "native"
    monkeypatch.setenv("TEGOTAE_ENGINE", "xla")
    with pytest.raises(TegotaeError, match="a training of the engine native, and this is xla") as e:
        train(dataclasses.replace(tiny.RUN), tiny_training)
    assert "set TEGOTAE_ENGINE=native, or choose another folder with --out" in str(e.value)
    assert tiny.contents(tiny_training) == content
