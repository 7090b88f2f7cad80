"""The code of a user's part is part of all that was made with it: an edited one is refused."""

import dataclasses
import hashlib
import sys
from pathlib import Path

import pytest

from refusals import refused
from research.reproduction import runner
from research.reproduction.folder import Folder
from research.reproduction.plan import plan
from tegotae import TegotaeError
from tegotae._support.documents import differing
from tegotae._support.part_code import code_of_file
from tegotae.analysis.generalisation.on_engine import ControllersUnderTest
from tegotae.analysis.generalisation.run import Trial
from tegotae.cli import main
from tegotae.study import CellResult
from tegotae.systems import controller_file, registry
from tegotae.systems.controller_file import ControllerSet
from tegotae.systems.experiment import Experiment
from tegotae.systems.recipe import recipe
from tegotae.systems.registry import imported
from tegotae.training.agents.learner import AgentLearner
from tegotae.training.run import Run, claim

PART = '''"""A hopper and how to learn, by a user."""

from dataclasses import dataclass

from tegotae import Hopper, Timing
from tegotae.systems.recipe import recipe
from tegotae.parts.parameters import traceable
from tegotae.training.algorithms import PGPE
from tegotae.measures.objectives.fitness import Fitness
from tegotae.measures.evaluation import Protocol

from {helper} import factor


@traceable
@dataclass(frozen=True, kw_only=True)
class Edited{number}(Hopper):
    """A hopper whose sensor has a gain."""

    def sense(self, state, ground_m):
        felt = super().sense(state, ground_m)
        felt.values["spring_force"] = factor() * felt.values["spring_force"]
        return felt


@dataclass(frozen=True, kw_only=True)
class Learns{number}(PGPE):
    NAME = "learns{number}"


experiment = recipe("AR").experiment(
    timing=Timing(duration_s=2.0, tick_s=0.004),
    objective=Fitness(settle_s=1.0),
    name="edited",
    body=Edited{number}(),
)
'''
HELPER = "def factor():\n    return {factor}\n"


class Users:
    """A user's file of parts and a module beside it, which are edited and imported anew."""

    _count = 0

    def __init__(self, folder: Path) -> None:
        Users._count += 1
        self.number = Users._count
        self.file = folder / f"edited_part_{self.number}.py"
        self.helper = folder / f"edited_helper_{self.number}.py"
        self.file.write_text(PART.format(number=self.number, helper=self.helper.stem))
        self.edit("1.0")

    @property
    def body(self) -> str:
        return f"Edited{self.number}"

    def edit(self, factor: str) -> None:
        """Give the module beside it another factor, as if a new process met it."""
        self.helper.write_text(HELPER.format(factor=factor))
        self.forget()

    def forget(self) -> None:
        for file in (self.file, self.helper):
            sys.modules.pop(file.stem, None)

    @property
    def experiment(self) -> Experiment:
        return imported(str(self.file)).experiment

    @property
    def algorithm(self):
        return getattr(imported(str(self.file)), f"Learns{self.number}")()


@pytest.fixture
def users(tmp_path, monkeypatch):
    monkeypatch.setattr(sys, "path", list(sys.path))
    monkeypatch.setattr(sys, "dont_write_bytecode", True)  # two edits may be in one second
    (tmp_path / "own").mkdir()
    users = Users(tmp_path / "own")
    yield users
    users.forget()


# The hash.


@pytest.fixture
def hashed(tmp_path):
    """A function that writes files, and says what the code of the first of them is."""

    def hash_of_files(folder: str = "", **texts: str) -> str:
        folder_path = tmp_path / folder
        folder_path.mkdir(exist_ok=True)
        for name, text in texts.items():
            (folder_path / f"{name}.py").write_text(text)
        first = next(iter(texts))
        return code_of_file(folder_path / f"{first}.py", ".".join(filter(None, [folder, first])))

    return hash_of_files


def test_comments_docstrings_and_layout_are_no_code(hashed):
    plain = hashed(part="def f(x):\n    return {'a': x + 1}\n")
    reformatted = (
        '"""A part."""\n\n\ndef f( x ):  # adds\n    "One more."\n\n    return {\n"a": (x + 1)}'
    )
    assert hashed(part=reformatted) == plain
    assert hashed(part="def f(x):\n    return {'a': x + 2}\n") != plain
    assert hashed(part="def f(x):\n    return {'a': x - 1}\n") != plain


def test_a_module_beside_it_belongs_to_it_and_what_that_imports(hashed):
    files = {"part": "from aside import f", "aside": "import deep", "deep": "x = 1"}
    previous = hashed(**files, other="x = 1")
    assert hashed(part=files["part"], other="x = 2") == previous  # which nobody imports
    assert hashed(part=files["part"], deep="x = 2") != previous
    assert hashed(part=files["part"], deep="x = 1", aside="import deep, json") != previous


@pytest.mark.parametrize("line", ["from . import aside", "from own.aside import x"])
@pytest.mark.parametrize("marked", [{"__init__": ""}, {}])
def test_so_do_the_modules_of_its_package(hashed, line, marked):
    previous = hashed("own", part=line, aside="x = 1", **marked)
    assert hashed("own", part=line, aside="x = 2") != previous


def test_installed_packages_side_by_side_do_not_belong_together(hashed, tmp_path):
    folder = tmp_path / "site-packages"
    folder.mkdir()
    (folder / "other.py").write_text("x = 1")
    (folder / "part.py").write_text("import other")
    previous = code_of_file(folder / "part.py")
    (folder / "other.py").write_text("x = 2")
    assert code_of_file(folder / "part.py") == previous


def test_of_another_kind_of_file_it_is_that_of_its_bytes(tmp_path):
    (tmp_path / "leg.xml").write_text("<mujoco/>")
    expected = hashlib.sha256(b"<mujoco/>").hexdigest()
    assert code_of_file(tmp_path / "leg.xml") == expected


def test_the_packages_own_parts_are_described_without_a_hash():
    experiment = recipe("ART").experiment()
    assert registry.CODE not in repr(experiment.document)


def test_a_parts_fields_have_no_name_that_documents_need():
    from tegotae.parts.terms import VanillaAction

    part = dataclasses.make_dataclass(
        "Hashed", [("sha256", str, "")], bases=(VanillaAction,), frozen=True
    )
    refused("give its field another name", registry.register, part)


# What was made with it.


def test_a_training_is_not_gone_on_with_once_a_part_of_it_was_edited(
    users, tmp_path, one_line_error, capsys
):
    out = tmp_path / "out"
    words = ["--generations", "1", "--population", "4", "--seeds", "1", "--out", str(out)]
    train = ["train", f"{users.file}:experiment", *words]
    assert main(train) == 0
    users.helper.write_text(users.helper.read_text() + "# a word more\n")
    users.forget()
    assert main(train) == 0  # it is the same code
    users.edit("2.0")
    capsys.readouterr()
    message = one_line_error(*train)
    assert f"differs in code of {users.body}" in message
    assert "another folder" in message

    file = out / "edited-seed0.json"
    refused(f"was made with other code of {users.body}", controller_file.load, file)
    message = one_line_error("robustness", str(file), "--out", str(tmp_path / "tried"))
    assert f"was made with other code of {users.body}" in message
    users.edit("1.0")
    _ = users.experiment
    assert controller_file.load(file).body == users.experiment.body  # the code is back


def test_a_study_does_not_take_records_of_other_code_for_its_own(users, tmp_path):
    folder = Folder(tmp_path / "study")

    def mine():
        return plan("smoke", "V-*", [users.experiment])

    with folder.claimed(mine()):
        pass
    previous = [unit.key for unit in mine().units]
    users.edit("2.0")
    following = [unit.key for unit in mine().units]
    assert [a == b for a, b in zip(previous, following, strict=True)] == [True, False]
    with (
        pytest.raises(TegotaeError, match=f"another code of {users.body}"),
        folder.claimed(mine()),
    ):
        pass


def test_a_file_that_is_edited_while_a_study_runs_ends_it(users, tmp_path):
    full = plan("smoke", "", [users.experiment])

    def results(bundles):
        (unit,) = bundles[0]
        configuration = unit.configuration  # of a worker that read the file after it was edited
        configuration["experiment"]["system"]["body"][registry.CODE] = "other"
        yield unit, CellResult(configuration, {}, {})

    with pytest.raises(TegotaeError, match=f"another code of {users.body}: a file was edited"):
        runner.run_study(full, tmp_path / "study", results)


def test_the_code_of_an_algorithm_counts_as_well(users, tmp_path):
    def mine():
        return dataclasses.replace(plan("smoke", "V-*"), algorithm=users.algorithm)

    previous = mine().document
    users.edit("2.0")
    assert differing(previous, mine().document) == [f"code of learns{users.number}"]


def test_agents_do_not_go_on_with_other_code(users, tmp_path):
    def configuration():
        return Run(experiment=users.experiment, learner=AgentLearner()).configuration

    claim(tmp_path, configuration(), {"engine": "xla"})
    (tmp_path / "edited-seed0.json").write_text("{}")
    users.edit("2.0")
    with pytest.raises(TegotaeError, match=f"differs in code of {users.body}"):
        claim(tmp_path, configuration(), {"engine": "xla"})


def test_a_record_of_generalisation_is_one_of_its_code(users):
    def document():
        experiment = users.experiment
        tested = ControllersUnderTest(ControllerSet("edited", experiment.system, [[0.0]], ("0",)))
        return Trial(tested, ()).document

    previous = document()
    users.edit("2.0")
    assert differing(previous, document()) == [f"code of {users.body}"]
