"""A user's own parts, from a file outside the package, are trained, kept, judged and studied."""

import dataclasses
import json
import subprocess
import sys
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from places import ROOT, TESTS
from programs import main
from refusals import refused
from research.reproduction.folder import Folder
from research.reproduction.table import tabulate
from tegotae import TegotaeError, Timing, register
from tegotae._support.documents import kept_as, later
from tegotae.measures.evaluation import evaluate
from tegotae.measures.hopping import HOPPING
from tegotae.measures.objectives.fitness import Fitness
from tegotae.parts.bodies import Hopper, Sensors
from tegotae.parts.fields import replace
from tegotae.parts.parameters import Part, not_negative, positive
from tegotae.parts.terms import Network, Term
from tegotae.systems import controller_file, registry
from tegotae.systems.descriptions import describe, restore
from tegotae.systems.experiment import Experiment
from tegotae.systems.recipe import recipe
from tegotae.systems.registry import imported, kinds, load_object
from tegotae.training.algorithms import PGPE, Algorithm
from tegotae.training.collection import read_runs
from tegotae.training.evolution import Evolution, Stopping
from tegotae.training.learner import Learner
from tegotae.training.run import Run, curves_of, train

FILE = TESTS / "users" / "my_parts.py"
EXPERIMENT, ALGORITHM = f"{FILE}:experiment", f"{FILE}:Climb"
NAMES = {"HarmonicAction", "DriftingPhase", "LoadedHopper", "Height", "climb"}


@pytest.fixture(scope="module")
def parts():
    """The user's module, its parts registered."""
    return imported(str(FILE))


@pytest.fixture(scope="module")
def trained(parts, tmp_path_factory) -> Path:
    """A finished training on disk, by the command."""
    out = tmp_path_factory.mktemp("mine") / "training"
    words = ["--algorithm", ALGORITHM, "--seeds", "2", "--generations", "3", "--to-cap"]
    assert main(["train", EXPERIMENT, *words, "--out", str(out)]) == 0
    return out


# Documents.


def test_naming_a_file_registers_the_parts_in_it_and_no_others(parts):
    assert kinds().keys() >= NAMES
    assert "ConstantGain" in kinds()
    assert kinds()["ConstantGain"].__module__ == "tegotae.parts.terms.base"


def test_an_experiment_of_own_parts_is_read_back_from_its_document(parts):
    document = json.loads(json.dumps(parts.experiment.document))
    assert document["system"]["body"]["kind"] == "LoadedHopper"
    assert Experiment.from_document(document) == parts.experiment


# Training.


def test_python_and_the_command_train_to_the_same_numbers(parts, trained, tmp_path):
    learner = Evolution(algorithm=parts.Climb(), stopping=Stopping.after(3))
    paths = train(Run(experiment=parts.experiment, seeds=(0, 1), learner=learner), tmp_path)
    for path in paths:
        first, second = controller_file.load(path), controller_file.load(trained / path.name)
        np.testing.assert_array_equal(first.weights, second.weights)
        assert first.controller == second.controller == parts.experiment.controller
        assert first.body == parts.experiment.body


def test_the_search_finds_something_better_than_it_began_with(trained):
    for path in trained.glob("mine-seed*.json"):
        training = controller_file.load(path).training
        assert training["algorithm"]["name"] == "climb"
        assert training["generations"] == 3
        assert training["best_fitness"] > 1.0


def test_options_change_what_they_name_and_nothing_else(parts, tmp_path):
    words = ["--algorithm", ALGORITHM, "--seeds", "1", "--generations", "1", "--to-cap"]
    options = ["--body", f"{FILE}:LoadedHopper", "--mass-kg", "0.12", "--height-m", "1.3"]
    assert main(["train", EXPERIMENT, *words, *options, "--out", str(tmp_path)]) == 0
    (path,) = tmp_path.glob("mine-seed0.json")
    assert controller_file.load(path).body == parts.LoadedHopper(mass_kg=0.12)
    document = json.loads((tmp_path / "run.json").read_text())["configuration"]["experiment"]
    expected = replace(
        parts.experiment,
        {
            "body": parts.LoadedHopper(mass_kg=0.12),
            "height_m": 1.3,
            "protocol": dataclasses.replace(parts.experiment.protocol, release_m=1.3),
        },
    )
    assert Experiment.from_document(document) == expected


# Evaluation, study.


def test_what_was_trained_is_evaluated(parts, trained):
    (runs,) = read_runs(trained)
    result = evaluate(runs.controller, runs.weights, runs.omega, runs.body, _protocol(parts))
    assert np.isfinite(result.episodes["failed_share"]).all()


def test_a_controller_is_evaluated_on_another_body_than_it_was_trained_on(
    parts, trained, monkeypatch
):
    bodies = []

    def evaluate(controller, weights, omega, body, protocol, **_):
        bodies.append((body, protocol.work))
        raise KeyboardInterrupt

    monkeypatch.setattr("tegotae.api.hopping.evaluate", evaluate)
    words = ["evaluate", str(trained), "--mass-kg", "0.12"]
    main([*words, "--work", "positive"])
    main([*words, "--body", f"{FILE}:Hopper", "--work", "net"])
    heavier = parts.LoadedHopper(mass_kg=0.12), parts.Hopper(mass_kg=0.12)
    assert bodies == [(heavier[0], "positive"), (heavier[1], "net")]


def _protocol(parts):
    return parts.experiment.protocol


@pytest.mark.thorough
def test_it_stands_beside_the_papers_models_in_a_study(parts, tmp_path, monkeypatch):
    """Done in worker processes, which know nothing of the file but what they are sent."""
    words = ["--dir", str(tmp_path), "--scale", "smoke", "--models", "V-*", "--workers", "1"]
    assert main(["reproduction", "run", *words, "--experiments", EXPERIMENT]) == 0
    records, wrong = Folder(tmp_path).all()
    assert (wrong, [record.model for record in records]) == ([], ["V-sector-w8", "mine"])
    assert records[1].experiment == parts.experiment
    table = tabulate(records).where(model="mine")
    assert table["architecture"].tolist() == ["mine", "mine"]
    assert table["observation"].tolist() == ["F", "F"]
    assert table["omega_t"].tolist() == [8.0, 8.0]
    out = tmp_path / "table.csv"
    assert main(["reproduction", "export", "--dir", str(tmp_path), "--out", str(out)]) == 0
    assert "\nmine,mine," in out.read_text()
    monkeypatch.setattr(
        "research.reproduction.report.models._surface", lambda *_: {}
    )  # which take long
    monkeypatch.setattr("research.reproduction.report.models._hop", lambda *_: {})
    assert main(["reproduction", "report", "--dir", str(tmp_path)]) == 0
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert '["mine", "mine", "F_k", "its own", 8.0,' in page
    assert '"mine":{"run":' in page


def test_an_agent_learns_a_term_that_torch_does_not_know(parts):
    """Its value and its gradient are those of JAX."""
    torch = pytest.importorskip("torch")
    pytest.importorskip("stable_baselines3")
    from tegotae.training.agents import PPOSettings
    from tegotae.training.agents.learning import agent_task, make_agent

    settings = PPOSettings(n_steps=60, batch_size=120, n_envs=2)  # long enough to land
    training = agent_task(
        dataclasses.replace(parts.experiment, objective=Fitness(settle_s=0.5)),
        settings,
    )
    agent, feedback = make_agent(training, seed=0)
    previous = feedback.flat()
    agent.learn(120)
    assert feedback.flat().shape == previous.shape == (5,)
    assert (feedback.flat() != previous).any()
    observations = torch.randn(7, len(training.observed.names))
    feedback.zero_grad()
    feedback(observations).sum().backward()
    gradient = feedback.terms[0].weights.grad.numpy()
    step = np.zeros(4, "float32")
    step[2] = 1e-2
    with torch.no_grad():
        low = feedback(observations).sum().item()
        feedback.terms[0].weights += torch.from_numpy(step)
        high = feedback(observations).sum().item()
    assert (high - low) / 1e-2 == pytest.approx(gradient[2], rel=1e-2, abs=1e-4)


# The pages under Extending: files to copy.

PAGES = ROOT / "docs" / "extending" / "examples"
QUICK = ["--duration-s", "2", "--tick-s", "0.002", "--seeds", "1", "--generations", "1", "--to-cap"]


@pytest.mark.parametrize("name", sorted(path.name for path in PAGES.glob("*.py")))
def test_a_file_of_the_pages_is_imported_and_its_experiment_read_back(name):
    module = imported(str(PAGES / name))
    if hasattr(module, "experiment"):
        document = json.loads(json.dumps(module.experiment.document))
        assert Experiment.from_document(document) == module.experiment


def test_the_files_of_the_pages_train_together(tmp_path):
    """Term, body, fitness and algorithm of four files in one training."""
    words = ["--body", f"{PAGES / 'rubber_hopper.py'}:RubberHopper"]
    words += ["--fitness", f"{PAGES / 'jump.py'}:Jump"]
    words += ["--algorithm", f"{PAGES / 'hill_climb.py'}:HillClimb", "--population", "4"]
    place = f"{PAGES / 'fourier_action.py'}:experiment"
    assert main(["train", place, *words, *QUICK, "--out", str(tmp_path)]) == 0
    saved = controller_file.load(tmp_path / "fourier-seed0.json")
    assert type(saved.body).__name__ == "RubberHopper"
    assert type(saved.experiment.objective).__name__ == "Jump"


# A learner of a user's own.

LEARNER = f"{PAGES / 'pattern_search.py'}:PatternSearch"
SHORT = ["AR", "--budget", "12", "--seeds", "2", *QUICK[:4], "--settle-s", "0.5"]


def test_a_learner_of_a_user_trains_resumes_and_ends_in_the_same_numbers(tmp_path, capsys):
    words = ["train", *SHORT, "--algorithm", LEARNER, "--rounds", "3"]
    assert main([*words, "--out", str(tmp_path / "whole")]) == 0
    assert "best round" in capsys.readouterr().out
    whole = [controller_file.load(path) for path in sorted((tmp_path / "whole").glob("*-seed*"))]
    saved = whole[1]
    assert saved.training["algorithm"]["name"] == "pattern-search"
    assert saved.training["algorithm"]["rounds"] == 3
    curves = curves_of(tmp_path / "whole" / "curves.csv")
    assert (np.diff(curves["fitness"].to_numpy().reshape(2, 3)) >= 0.0).all()
    kind = type(load_object(LEARNER, Learner, "algorithm"))
    run = Run(
        experiment=recipe("AR").experiment(
            budget=12, timing=Timing(duration_s=2.0, tick_s=0.002), objective=Fitness(settle_s=0.5)
        ),
        learner=kind(rounds=3),
        seeds=(0, 1),
    )

    def stop(state):
        if state.done == 5:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        train(run, tmp_path / "again", on_step=stop)
    for path, other in zip(train(run, tmp_path / "again"), whole, strict=True):
        np.testing.assert_array_equal(controller_file.load(path).weights, other.weights)


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["--generations", "3"], "generations"),
        (["--rounds", "0"], "rounds is 0; it must be a whole number of at least 1"),
    ],
)
def test_a_learner_of_a_user_refuses_what_it_does_not_have(words, says, one_line_error, tmp_path):
    out = ["--out", str(tmp_path / "new")]
    assert says in one_line_error("train", *SHORT, "--algorithm", LEARNER, *words, *out)


# Misuse: one line each.


@dataclass(frozen=True)
class Unregistered(Network):
    """A term that nobody registered."""


def test_a_part_that_is_not_registered_is_refused_before_the_training(tmp_path):
    complete = recipe("AR").experiment()
    reference = dataclasses.replace(
        complete.controller.tegotae, reaction=Unregistered(("spring_force",), 2)
    )
    experiment = replace(
        complete, {"controller": dataclasses.replace(complete.controller, tegotae=reference)}
    )
    message = r"^a Unregistered cannot be saved: it is not registered; call tegotae\.register"
    refused(message, lambda: train(Run(experiment=experiment), tmp_path / "new"))
    assert not (tmp_path / "new").exists()


@dataclass(frozen=True)
class Spline(Network):
    """A term with a field that no file can hold."""

    knots: object = print


@dataclass(frozen=True)
class Rounded(Network):
    """A term with a field that a file holds, and that is not read again as its annotation says."""

    knots: np.ndarray | None = None


@pytest.mark.parametrize(
    ("part", "says"),
    [
        (Spline, "a Spline cannot be saved and read again: Object of type .* is not JSON"),
        (partial(Rounded, knots=np.arange(3.0)), "a Rounded cannot be saved and read again"),
    ],
)
def test_a_part_that_no_file_can_hold_is_refused_before_the_training(tmp_path, part, says):
    kind = part.func if isinstance(part, partial) else part
    register(kind)
    try:
        complete = recipe("AR").experiment()
        reference = dataclasses.replace(
            complete.controller.tegotae, reaction=part(("spring_force",), 2)
        )
        experiment = replace(
            complete, {"controller": dataclasses.replace(complete.controller, tegotae=reference)}
        )
        refused(says, lambda: train(Run(experiment=experiment), tmp_path / "new"))
        assert not (tmp_path / "new").exists()
    finally:
        registry._registered.pop(kind.__name__)


def test_a_loop_of_ones_own_is_warned_that_it_could_not_save_what_it_learns():
    complete = recipe("AR").experiment()
    reference = dataclasses.replace(
        complete.controller.tegotae, reaction=Unregistered(("spring_force",), 2)
    )
    controller = dataclasses.replace(complete.controller, tegotae=reference)
    with pytest.warns(
        UserWarning, match=r"could not be saved: .*tegotae\.register\(Unregistered\)"
    ):
        Evolution(algorithm=PGPE()).start(replace(complete, {"controller": controller}), [0])


def test_a_file_that_names_a_part_nobody_registered_is_refused_and_nothing_is_imported(trained):
    """A process of its own: this one knows the parts."""
    path = trained / "mine-seed0.json"
    words = ["simulate", str(path), "--duration-s", "2", "--json"]

    def call(*arguments: str) -> subprocess.CompletedProcess:
        command = [sys.executable, "-m", "tegotae", *words, *arguments]
        return subprocess.run(command, capture_output=True, text=True)

    refused = call()
    assert refused.returncode == 2
    assert refused.stderr == (
        f"tegotae: {path} needs your part DriftingPhase (oscillator): add --parts FILE.py, or "
        "register it\n"
    )
    assert call("--parts", str(FILE)).returncode == 0


def test_a_field_that_came_later_renames_no_document_at_its_default():
    @dataclass(frozen=True)
    class Tolerance:
        height_m: float = 0.005
        slope: float = later(0.0)

    assert describe(Tolerance()) == {"height_m": 0.005}
    assert restore({"height_m": 0.005}, Tolerance, "tolerance") == Tolerance()
    steep = Tolerance(slope=0.1)
    assert restore(describe(steep), Tolerance, "tolerance") == steep


def test_a_field_that_came_later_may_say_what_it_may_be():
    @dataclass(frozen=True)
    class Drag(Part):
        ns2_per_m2: float = later(not_negative(0.0))

    assert describe(Drag()) == {}
    assert describe(Drag(0.5)) == {"ns2_per_m2": 0.5}
    refused("ns2_per_m2 is -1; it must be at least 0", Drag, -1.0)


@dataclass(frozen=True)
class Spring(Part):
    stiffness_n_per_m: float = kept_as("stiffness", positive(5.0))
    damping_ns_per_m: float = kept_as("damping", later(0.0), written=False)


def test_a_renamed_field_reads_documents_of_both_names_and_writes_the_earlier_one():
    stiff = Spring(stiffness_n_per_m=7.0)
    assert describe(stiff) == {"stiffness": 7.0}
    for name in ("stiffness", "stiffness_n_per_m"):
        assert restore({name: 7.0}, Spring, "spring") == stiff
    refused("stiffness_n_per_m is -1", Spring, -1.0)


def test_a_renamed_field_may_be_written_by_its_present_name():
    damped = Spring(damping_ns_per_m=0.1)
    assert describe(damped) == {"stiffness": 5.0, "damping_ns_per_m": 0.1}
    assert restore({"damping": 0.1}, Spring, "spring") == damped


def test_a_document_with_both_names_of_a_field_is_refused():
    with pytest.raises(TegotaeError, match="'damping_ns_per_m' is there as 'damping', too"):
        restore({"damping": 0.1, "damping_ns_per_m": 0.1}, Spring, "spring")


def test_a_renamed_number_of_a_body_is_changed_under_its_earlier_name():
    @dataclass(frozen=True, kw_only=True)
    class Renamed(Hopper):
        drag_ns_per_m: float = kept_as("drag", 0.5)

    delayed = Sensors(body=Renamed())
    assert replace(delayed, {"drag": 0.7}).body == Renamed(drag_ns_per_m=0.7)


def test_what_is_no_part_cannot_be_registered():
    refused("dict is no part: a part is a subclass of one of Body", register, dict)

    class Loose(Algorithm):
        pass

    refused("Loose cannot be registered: it is no frozen dataclass", register, Loose)

    @dataclass(frozen=True, kw_only=True)
    class PGPE(Algorithm):
        NAME = "pgpe"

        def make(self, n_weights):
            raise NotImplementedError

    refused("has a part called pgpe already", register, PGPE)


FILES = {
    "from nowhere import x": "cannot be imported, line 1: ModuleNotFoundError",
    "\n\n1/0": "cannot be imported, line 3: ZeroDivisionError: division by zero",
    "def f(:": "cannot be imported, line 1: SyntaxError",
    "import sys\n\nsys.exit(0)": "cannot be imported, line 3: SystemExit: it ends the program",
}


@pytest.mark.parametrize("text", FILES)
def test_a_file_that_cannot_be_imported_is_told_with_its_line(tmp_path, text, one_line_error):
    path = tmp_path / f"broken_{len(text)}.py"
    path.write_text(text)
    assert FILES[text] in one_line_error("train", f"{path}:experiment")


LEAVING = """
import sys
from dataclasses import dataclass
from tegotae.parts.terms import VanillaAction
from tegotae.measures.objectives.objective import Objective

@dataclass(frozen=True)
class Leaving(VanillaAction):
    def __post_init__(self):
        sys.exit(0)

@dataclass(frozen=True, kw_only=True)
class LeavingLate(Objective):
    def outcome(self, trajectory, scenario, body, timing):
        sys.exit(0)

def environment():
    sys.exit(0)
"""
"""Code that ends the program wherever it is called."""


def test_code_of_a_part_does_not_end_a_command_as_if_it_had_done_its_work(tmp_path, one_line_error):
    path = tmp_path / "leaving.py"
    path.write_text(LEAVING)
    with pytest.raises(TegotaeError, match="cannot be made: SystemExit: it ends the program"):
        load_object(f"{path}:Leaving", Term, "term")
    assert "it ends the program" in one_line_error("train", "ART", "--env", f"{path}:environment")
    words = ["--generations", "1", "--seeds", "1", "--out", str(tmp_path / "out")]
    message = one_line_error("train", "V-sector-w8", "--fitness", f"{path}:LeavingLate", *words)
    assert "code of a part ended the command" in message


def test_a_name_that_another_module_has_is_refused(tmp_path):
    path = tmp_path / "json.py"
    path.write_text("x = 1\n")
    refused("there is a module json already", imported, str(path))


def test_an_experiments_name_is_one_of_a_file():
    with pytest.raises(TegotaeError, match="its name may have letters"):
        dataclasses.replace(recipe("AR").experiment(), name="../x")


def test_a_frequency_and_an_oscillator_go_together():
    with pytest.raises(TegotaeError, match=r"no oscillator, but omega is 8\.0 rad/s"):
        replace(recipe("T").experiment(), {"omega": 8.0})
    with pytest.raises(TegotaeError, match="has an oscillator; give omega"):
        replace(recipe("AR").experiment(), {"omega": None})


def test_a_class_stands_for_an_instance_with_its_defaults(parts):
    assert load_object(ALGORITHM, Algorithm, "algorithm") == parts.Climb()


def test_a_metric_of_a_users_file_is_known_by_its_name(tmp_path):
    path = tmp_path / "my_own_metric.py"
    path.write_text(
        "import jax.numpy as jnp\n"
        "from tegotae.measures.hopping import GaitMetric\n"
        "mine = GaitMetric(name='my_apex', label='my apex', unit='m', about='an apex',\n"
        "    more_is_better=True, compute=lambda e: jnp.nanmean(e.hops.height_m, axis=0))\n"
    )
    try:
        module = imported(str(path))
        assert HOPPING.find("my_apex") is register(module.mine)
    finally:
        HOPPING.forget("my_apex")
