"""Help at hand: a report for bugs, the TAB key, silence, and names for pictures."""

import json
import shlex
import subprocess
from pathlib import Path
from typing import Any

import pytest

from tegotae import __version__
from tegotae._support.progress import QUIET, note, reporting
from tegotae.api import about
from tegotae.api.about import extras, installed
from tegotae.api.results import Table
from tegotae.cli import main, parsed
from tegotae.cli.commands import COMMANDS
from tegotae.cli.output import OutputOptions
from tegotae.cli.program import CommandGroup


def test_help_of_a_subject_has_its_options_and_examples_alone(capsys):
    assert main(["train", "ART", "--help"]) == 0
    text = capsys.readouterr().out
    assert "tegotae train ART --generations 40" in text
    assert "go1" not in text
    assert "--wiring" not in text
    assert "--no-follow-omega       Turn this off: " in text


@pytest.fixture
def diagnosis(capsys):
    assert main(["doctor", "--json"]) == 0
    return json.loads(capsys.readouterr().out)


def test_a_bug_report_has_versions_machine_and_engine(diagnosis):
    assert diagnosis["versions"]["tegotae"] == __version__
    assert diagnosis["versions"]["jax"] == installed("jax")
    assert diagnosis["machine"]["cores"] >= 1
    assert {"compiler", "system"} < diagnosis["machine"].keys()
    assert diagnosis["engine"]["engine"] == "native"


def test_a_bug_report_names_the_extra_that_is_missing_and_how_to_install_it(capsys, monkeypatch):
    monkeypatch.setattr(
        "tegotae.api.about.installed", lambda name: None if name == "casadi" else "1.0"
    )
    assert main(["doctor"]) == 0
    assert "not installed: casadi; pip install 'tegotae[optimum]'" in capsys.readouterr().out


def test_the_extras_of_a_bug_report_are_those_of_the_package():
    found = extras()
    assert found["optimum"] == ("casadi",)
    assert found["mujoco"] == ("mujoco",)
    assert not {"all", "dev", "docs", "test"} & found.keys()


def test_a_bug_report_has_what_the_environment_sets(capsys, monkeypatch):
    monkeypatch.setenv("TEGOTAE_DEBUG", "0")
    assert main(["doctor", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["settings"]["TEGOTAE_DEBUG"] == "0"


@pytest.fixture(scope="module")
def completed(tmp_path_factory):
    """A function: what bash offers for a line whose last word is being typed."""
    from tegotae.cli.completion import script

    file = tmp_path_factory.mktemp("completion") / "tegotae.bash"
    (file.parent / "my leg.json").touch()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(
            "tegotae.cli.completion.zoo_names", lambda: ("zoo:ART-w8", "zoo:AR-w8", "zoo:V")
        )
        file.write_text(script(), encoding="utf-8")

    def offers(line: str) -> list[str]:
        words = line.split(" ")
        program = (
            f"source {shlex.quote(str(file))}; COMP_WORDS=({shlex.join(words)}); "
            f'COMP_CWORD={len(words) - 1}; _tegotae; printf "%s\\n" "${{COMPREPLY[@]}}"'
        )
        done = subprocess.run(
            ["bash", "--norc", "-c", program], capture_output=True, text=True, cwd=file.parent
        )
        assert (done.returncode, done.stderr) == (0, "")
        return list(filter(None, done.stdout.splitlines()))

    return offers


@pytest.mark.parametrize(
    ("line", "offered"),
    [
        ("tegotae sim", ["simulate"]),
        ("tegotae figure po", ["portrait", "poincare"]),
        ("tegotae gait sta", ["stability"]),
        ("tegotae train ART --sto", []),
        ("tegotae train ART --see", ["--seeds"]),
        ("tegotae figure surface --resol", ["--resolution"]),
        ("tegotae simulate tegotae.b", ["tegotae.bash"]),
        ("tegotae simulate my", ["my leg.json"]),
        ("tegotae simulate 'my", ["my leg.json"]),
        ("tegotae simulate my\\", ["my leg.json"]),  # before its blank
        ("tegotae simulate zo", ["zoo:"]),
        ("tegotae simulate zoo:ART", ["zoo:ART-w8"]),
        ("tegotae simulate zoo :", ["ART-w8", "AR-w8", "V"]),  # as bash splits words
        ("tegotae evaluate zoo : AR", ["ART-w8", "AR-w8"]),
    ],
)
def test_the_tab_key_completes_commands_options_files_and_controllers(completed, line, offered):
    assert completed(line) == offered


def test_zsh_is_given_the_same_script_in_its_own_way(capsys):
    assert main(["completion", "zsh"]) == 0
    out = capsys.readouterr().out
    assert "bashcompinit" in out
    assert "complete -o filenames -F _tegotae tegotae" in out


@pytest.mark.parametrize(("switch", "shown"), [([], True), (["--quiet"], False)])
def test_a_quiet_command_prints_its_results_but_no_progress(capsys, monkeypatch, switch, shown):
    def work() -> Table:
        with reporting("work", 1) as report:
            report.update(1)
        note("a note")
        return Table(title="@software")

    monkeypatch.setenv(QUIET, "0")  # which the switch sets, until the test is over
    monkeypatch.setattr(about, "cite", work)
    assert main(["cite", *switch]) == 0
    out, err = capsys.readouterr()
    assert out.startswith("@software")
    assert ("1/1" in err, "a note" in err) == (shown, shown)


@pytest.mark.parametrize(
    ("name", "file"),
    [
        ("V-sector-w4", "surface-V-sector-w4.png"),
        ("runs/ART-rF-w8-seed0.json", "surface-ART-rF-w8-seed0.png"),
        ("zoo:ART/3", "surface-ART-3.png"),
        ("walker.zip", "surface-walker.png"),
        ("mine.py:hopper", "surface-hopper.png"),
    ],
)
def test_a_figure_without_a_file_is_called_after_what_it_shows(name, file):
    figure = COMMANDS["figure"]
    assert isinstance(figure, CommandGroup)
    command: Any = figure.commands["surface"]
    assert OutputOptions().with_default_file(command, name).out == Path(file)
    given = OutputOptions(out=Path("mine.pdf"))
    assert given.with_default_file(command, name) is given


def test_a_figure_is_written_under_its_own_name(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    words = "figure portrait paper-reflex --heights 1.2 --duration-s 2"
    assert main(words.split()) == 0
    assert (tmp_path / "portrait-paper-reflex.png").stat().st_size > 0
    assert "wrote portrait-paper-reflex.png" in capsys.readouterr().out


def test_a_gait_command_without_a_folder_makes_one_called_after_it():
    *_, output = parsed(["gait", "sweep", "bar-light", "--levels", "3", "4"]).parsed()
    assert output.out == Path("gait-sweep-bar-light")
