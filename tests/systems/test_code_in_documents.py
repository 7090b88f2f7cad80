"""A document is data: what it refers to runs after the user has named it, and not before."""

import contextlib
import copy
import json
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import controller_files
import tegotae
from refusals import refused
from tegotae import Hopper, TegotaeError
from tegotae._support import documents
from tegotae.envs import load_wiring
from tegotae.envs.wiring import wiring_document
from tegotae.parts.bodies import Body
from tegotae.systems import controller_file, registry
from tegotae.systems.controller_file import SavedController
from tegotae.systems.descriptions import restore
from tegotae.systems.parts_by_name import body_text
from tegotae.systems.resolve import resolve
from tegotae.systems.vanilla import legged_of
from tegotae.training.environments.experiment import EnvExperiment
from tegotae.training.environments.objectives import UserObjective
from tegotae.training.settings import load_configuration
from wired_experiment import WIRING, experiment

CODE = """
open("ran", "w").close()
def run(*args, **settings):
    pass
"""
REFERENCES = ("evil.py:run", "evil:run", "paper+evil.py:run", "AR@evil.py:run", "./evil.py:run")


@pytest.fixture(autouse=True)
def place(tmp_path, monkeypatch):
    """The user's folder, with code of somebody else's in it, `evil.py`, which leaves `ran`."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", [str(tmp_path), *sys.path])
    monkeypatch.setattr(registry, "_loaded", set())
    monkeypatch.delitem(sys.modules, "evil", raising=False)
    Path("evil.py").write_text(CODE)
    Path("evil.py:run").touch()  # a file of this name makes a reference of no other
    yield tmp_path
    sys.modules.pop("evil", None)


def trained(**settings: Any) -> dict[str, Any]:
    """The document of a controller that was trained on an environment."""
    trainee = experiment(env="CartPole-v1", made={"render_mode": "rgb_array"}, **settings)
    weights = np.zeros(trainee.controller.n_weights)
    saved = SavedController(trainee.system, weights, "AR", task=trainee.task)
    return json.loads(json.dumps(controller_file.described(saved, "leg.json")))


def use_file(path: Path) -> None:
    """All that a controller of an environment is read for."""
    EnvExperiment.from_controller(controller_file.load(path)).spec.make()


DOCUMENTS = {
    "controller of an environment": (trained, use_file),
    "controller": (lambda: json.loads(controller_files.text()), resolve),
    "wiring": (lambda: {**wiring_document(WIRING), "controller": "paper"}, load_wiring),
    "experiments": (lambda: [tegotae.recipe("ART").experiment().document], resolve),
    "study": (lambda: {"experiments": {"a": tegotae.recipe("ART").experiment().document}}, resolve),
    "settings": (
        lambda: {"algorithm": "pgpe", "settings": {"population": 8}, "found": {"by": "hand"}},
        load_configuration,
    ),
    "body": (
        lambda: documents.parse_toml(body_text(Hopper())),
        lambda path: restore(documents.read(path), Body, "body"),
    ),
    "walker": (
        lambda: {"about": "mine", "sigma": 1.0, "omega": 2.0, "foot": {"stride_m": 0.2}},
        lambda path: legged_of(documents.read(path)),
    ),
}
"""Every kind of document with references, or names, as JSON values, and what reads its file."""


def with_reference(document: Any, reference: str) -> Iterator[Any]:
    """The document with the reference in place of each of its texts in turn."""
    if isinstance(document, str):
        yield reference
    elif isinstance(document, (dict, list)):
        entries = document.items() if isinstance(document, dict) else enumerate(document)
        for key, value in entries:
            for changed in with_reference(value, reference):
                altered = copy.copy(document)
                altered[key] = changed
                yield altered


@pytest.mark.parametrize("kind", DOCUMENTS)
def test_no_text_of_a_document_runs_code(kind, place):
    make, read = DOCUMENTS[kind]
    document = make()
    for reference in REFERENCES:
        for changed in with_reference(document, reference):
            Path("document.json").write_text(json.dumps(changed))
            with contextlib.suppress(TegotaeError):
                read(Path("document.json"))
            assert not Path("ran").exists(), changed


def with_task(**changes: Any) -> Path:
    """A controller file with other entries of its task."""
    document = trained()
    document["task"] |= changes
    Path("leg.json").write_text(json.dumps(document))
    return Path("leg.json")


@pytest.mark.parametrize(
    ("changes", "reference"),
    [
        ({"env": "subprocess:run", "settings": {"args": ["touch", "ran"]}}, "subprocess:run"),
        ({"env": "evil:CartPole-v1"}, "evil:CartPole-v1"),
        ({"env": "evil.py:run"}, "evil.py:run"),
        ({"env": "GymV21Environment-v0", "settings": {"env_id": "evil:a-v0"}}, "evil:a-v0"),
        ({"objective": {"kind": "UserObjective", "function": "evil.py:run"}}, "evil.py:run"),
        ({"wiring": {**wiring_document(WIRING), "controller": "evil:run"}}, "evil:run"),
    ],
)
@pytest.mark.parametrize("command", ["simulate", "evaluate"])
def test_a_command_refuses_code_that_a_controller_file_names(
    one_line_error, command, changes, reference
):
    message = one_line_error(command, str(with_task(**changes)))
    module = reference.rpartition(":")[0]
    assert f"refers to code, {reference!r}, which no file may run by itself" in message
    assert f"add --parts {module}, or tegotae.register({module!r})" in message
    assert not Path("ran").exists()


@pytest.mark.parametrize("name", ["./evil.py", "evil"])
def test_code_of_a_file_runs_after_the_user_has_registered_it(name):
    reference = f"{name.removeprefix('./')}:run"
    path = with_task(objective={"kind": "UserObjective", "function": reference})
    with pytest.raises(TegotaeError, match="the objective of AR refers to code"):
        EnvExperiment.from_controller(controller_file.load(path))
    tegotae.register(name)
    assert EnvExperiment.from_controller(controller_file.load(path)).objective == UserObjective(
        reference
    )
    assert Path("ran").exists()


def test_a_reference_that_the_user_named_is_of_no_other_object():
    registry.load_object("evil.py:run", object, "function")
    registry.require_named(f"{Path.cwd()}/evil.py:run", "leg.json")
    refused(r"'evil\.py:stop'", registry.require_named, "evil.py:stop", "leg.json")


def test_a_registered_environment_and_a_model_are_data():
    use_file(with_task())
    use_file(with_task(env="leg", settings={}))
