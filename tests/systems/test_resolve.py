"""One name, one meaning, whatever the question: recipes, systems, files, own objects."""

import json

import numpy as np
import pytest

from refusals import refused
from tegotae import TegotaeError
from tegotae.systems import controller_file
from tegotae.systems.controller_file import SavedController
from tegotae.systems.recipe import recipe
from tegotae.systems.resolve import Trained, Untrained, experiment_of, resolve
from tegotae.training.collection import controller_of

PARTS = """
import numpy as np
from tegotae import Experiment, System
from tegotae.parts.fields import replace
from tegotae.systems.recipe import recipe
from tegotae.systems.controller_file import SavedController
from tegotae.systems.resolve import legged_system as system
hopper = System(controller=recipe("V-reflex-w8").controller(), omega=8.0)
training = Experiment(name="mine", system=System(controller=recipe("AR").controller(), omega=8.0))
several = [training, replace(training, {"name": "other"})]
saved = SavedController(hopper, np.array([2.0]))
robot = system("bar-light")
wrong = 7
"""


@pytest.fixture(scope="module")
def parts_file(tmp_path_factory):
    """A user's file, by a name of its own: modules are imported once a process."""
    path = tmp_path_factory.mktemp("own") / "resolved_parts.py"
    path.write_text(PARTS)
    return path


@pytest.fixture
def place(tmp_path, monkeypatch):
    """The working folder, with a controller file and a folder of two."""
    monkeypatch.chdir(tmp_path)
    experiment = recipe("V-reflex-w8").experiment()
    for seed, path in enumerate(("one.json", "runs/a.json", "runs/b.json")):
        (tmp_path / path).parent.mkdir(exist_ok=True)
        saved = SavedController(
            experiment.system, np.array([2.0]), "mine", experiment, training={"seed": seed}
        )
        controller_file.save(saved, tmp_path / path)
    (tmp_path / "plan.json").write_text(json.dumps(recipe("AR").experiment().document))
    return tmp_path


@pytest.mark.parametrize(
    ("name", "experiment"),
    [
        ("ART-rF-tphif-w8", "ART-rF-tphif-w8"),
        ("ART", "ART-rF-tphif-w8"),
        ("AR+hopf", "AR-rF-reflex-w8+hopf"),
        ("AR@quadruped-c", "AR-rF@quadruped-c"),
        ("plan.json", "AR-rF-reflex-w8"),
        ("one.json", "V-reflex-w8"),
        ("runs", "V-reflex-w8"),
    ],
)
def test_what_can_be_trained_has_an_experiment(place, name, experiment):
    assert resolve(name).experiment().name == experiment


@pytest.mark.parametrize(
    ("name", "omega", "limbs"),
    [("paper", 5.0, 1), ("one.json", 8.0, 1), ("quadruped-c", 2.0, 4), ("bar-light", 8.0, 2)],
)
def test_what_has_weights_is_a_controller(place, name, omega, limbs):
    result = resolve(name).controller()
    assert (result.omega, result.body.limbs) == (omega, limbs)
    assert result.weights.shape == (result.controller.n_weights,)


def test_objects_of_a_users_file_mean_what_they_are(parts_file):
    resolved = {name: resolve(f"{parts_file}:{name}") for name in ("training", "saved", "robot")}
    assert resolved["training"].experiment().name == "mine"
    assert resolved["saved"].controller().name == "saved"
    assert resolved["robot"].legs().names == ("H", "F")
    assert len(resolve(f"{parts_file}:several").experiments) == 2


def test_the_weights_of_a_model_are_in_the_folder_that_is_called_so(place):
    assert isinstance(resolve("AR"), Untrained)
    (place / "runs").rename(place / "AR")
    assert isinstance(resolve("AR"), Trained)
    assert len(resolve("AR").controllers) == 2


def test_a_folder_of_a_systems_name_leaves_it_what_it_is(place):
    (place / "quadruped-c").mkdir()
    (place / "paper").mkdir()
    assert resolve("quadruped-c").controller().body.limbs == 4
    assert resolve("paper").controller().omega == 5.0


def test_the_gain_of_a_pure_v_model_is_found_by_search():
    result = resolve("V-reflex-w8")
    refused("has weights to train and no file was given", result.controller)
    assert controller_of(result).weights.shape == (1,)


@pytest.mark.parametrize(
    ("name", "question", "message"),
    [
        ("ARTX", "controller", "no model or system is called 'ARTX'; did you mean ART"),
        ("quadruped-x", "legs", "is called 'quadruped-x'; did you mean quadruped-"),
        ("ART", "controller", "train it: tegotae train ART-rF-tphif-w8 --out FOLDER"),
        ("paper", "legs", "a gait command on a one-legged body: a Hopper has one leg"),
        ("AR@quadruped-c", "legs", "first: tegotae train AR-rF@quadruped-c --out FOLDER"),
        ("runs", "controller", "runs holds 2 controllers; name one of them, such as runs/a.json"),
        ("quadruped-c", "experiment", "name terms upon it, such as AR@quadruped-c"),
        ("paper", "experiment", "paper is no experiment: it is a controller"),
        ("nowhere.json", "controller", "no controller file at nowhere.json"),
        ("OWN:hopper", "controller", "is no controller or experiment: it is a System"),
        ("OWN:several", "experiment", "holds 2 experiments; name one"),
        ("OWN:training", "controller", "first: tegotae train"),
        ("OWN:wrong", "controller", "is no controller or experiment: it is a int"),
    ],
)
def test_what_a_question_cannot_use_is_refused_in_one_line(
    place, parts_file, name, question, message
):
    with pytest.raises(TegotaeError) as raised:
        getattr(resolve(name.replace("OWN", str(parts_file))), question)()
    assert message in str(raised.value)
    assert "\n" not in str(raised.value)


def test_a_budget_sizes_models_alone(place):
    assert experiment_of("AR", budget=20).controller.n_weights <= 20
    with pytest.raises(TegotaeError, match="--budget sizes the networks of the paper's models"):
        experiment_of("one.json", budget=20)


def test_a_file_of_something_else_is_refused(place):
    (place / "other.json").write_text('{"format": "something"}')
    refused("is not a controller file", resolve, "other.json")
    (place / "empty").mkdir()
    refused("holds no controller files", resolve, "empty")
