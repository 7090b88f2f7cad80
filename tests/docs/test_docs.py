"""The documentation keeps its word: examples run, commands exist, pages build without a warning."""

import importlib
import importlib.util
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import tegotae
from pages import DOCS, blocks
from programs import parsed, words_of
from refusals import refused
from research_pages import source_of
from tegotae.api import gaits, plot
from tegotae.api.hopping import HopperController
from tegotae.api.walking import WalkerController
from tegotae.cli import split_parts
from tegotae.cli.functions import FunctionCall, options_by_subject
from tegotae.cli.words import flag_of
from tegotae.systems.controller_file import FORMAT, VERSION, SavedController, described
from tegotae.systems.recipe import recipe

PAGES = sorted(source_of(page) for page in DOCS.rglob("*.md") if "_static" not in page.parts)
EXAMPLE_FILES = sorted(DOCS.glob("extending/examples/*.py"))
PLAIN = (
    *("getting-started", "concepts", "legs", "generalisation", "architecture", "native"),
    *("oscillators", "api/functions", "benchmark", "figures/index", "gaits/index", "gaits/front"),
    *("studies/legs_limit", "tuning"),
)
"""Pages whose Python needs no file of the reader's."""
EXAMPLES = [DOCS / f"{name}.md" for name in PLAIN]
# The page on live control needs its commands, too: test_guides.py follows it whole.
EXAMPLES += [*DOCS.glob("extending/*.md"), DOCS / "deploy" / "controller-file.md"]


def commands(page: Path) -> list[list[str]]:
    """The words of the lines of a page's console blocks that start a program of the project."""
    joined = (block.replace("\\\n", "") for _, block in blocks(page, "console"))
    lines = (line for block in joined for line in block.splitlines())
    return [words for line in lines if (words := words_of(line))]


TAKEN = {plot.__name__: HopperController, gaits.__name__: WalkerController}
"""Controllers that the functions of a module take."""
SLOW = ("legs", "oscillator")
"""Pages whose examples simulate for long."""


@pytest.mark.parametrize(
    "page",
    [
        pytest.param(p, id=p.stem, marks=pytest.mark.thorough if p.stem in SLOW else ())
        for p in EXAMPLES
        if blocks(p, "python")
    ],
)
def test_the_python_examples_of_a_page_run_from_top_to_bottom(page, tmp_path, monkeypatch):
    # As one file, as a reader would paste them, with the page's own line numbers.
    lines: list[str] = []
    for start, text in blocks(page, "python"):
        lines += [""] * (start - len(lines)) + text.splitlines()
    file = tmp_path / f"example_{page.stem.replace('-', '_')}.py"
    file.write_text("\n".join(lines) + "\n", encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(EXAMPLE_FILES[0].parent)
    spec = importlib.util.spec_from_file_location(file.stem, file)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    monkeypatch.setitem(sys.modules, file.stem, module)
    spec.loader.exec_module(module)


def test_the_page_on_controller_files_names_every_entry_of_one():
    page = (DOCS / "deploy" / "controller-file.md").read_text(encoding="utf-8")
    tables = re.findall(r"^\| entry.*\n\|[-|]+\n((?:\|.*\n)+)", page, re.M)
    entries = [
        re.findall(r"`(\w+)`", "".join(re.findall(r"^\|([^|]*)\|", x, re.M))) for x in tables
    ]
    document = described(
        SavedController.from_weights(
            recipe("ART").controller(), np.zeros(recipe("ART").controller().n_weights), 8.0
        ),
        "",
    )
    system = document["system"]
    assert entries == [list(document), list(system), list(system["controller"])]
    assert f'`"{FORMAT}"`, {VERSION} |' in page
    assert list(system["controller"]["tegotae"])[:3] == ["action", "reaction", "gain"]


def test_the_constant_push_does_what_the_fidelity_page_says(capsys):
    exec("".join(text for _, text in blocks(DOCS / "reproduction/fidelity.md", "python")), {})
    efficiency, apex = map(float, capsys.readouterr().out.split())
    assert efficiency == pytest.approx(0.4, abs=0.03)
    assert apex < 1.01


def test_a_module_has_one_place_in_the_api():
    text = "".join(page.read_text(encoding="utf-8") for page in (DOCS / "api").glob("*.md"))
    modules = re.findall(r"^\.\. automodule:: (\S+)$", text, re.M)
    assert sorted(modules) == sorted(set(modules))
    for module in modules:
        importlib.import_module(module)


@pytest.mark.parametrize("page", [p for p in PAGES if commands(p)], ids=lambda p: p.stem)
def test_the_commands_of_a_page_are_understood(page):
    for words in commands(page):
        arguments, _ = split_parts(words)
        command = parsed(arguments)
        if isinstance(command, FunctionCall):  # of files that are not here
            kinds = options_by_subject(command.command).values()
            known = {flag_of(option) for options in kinds for option in options.values()}
            assert {flag for flag, _ in command.options} <= known


@pytest.mark.parametrize("page", [p for p in PAGES if commands(p)], ids=lambda p: p.stem)
def test_the_figures_and_gaits_of_a_page_are_of_bodies_with_as_many_legs_as_they_take(page):
    for words in commands(page):
        command = parsed(split_parts(words)[0])
        if not isinstance(command, FunctionCall) or command.function.__module__ not in TAKEN:
            continue
        for name in command.names:
            if not name.endswith(".json") and not name.startswith("runs/"):  # files of the reader
                assert isinstance(tegotae.load(name), TAKEN[command.function.__module__]), words


def test_a_command_with_an_option_that_does_not_exist_is_not_understood():
    refused("--no-such-option", lambda: parsed(["train", "ART", "--no-such-option"]).parsed())


@pytest.mark.thorough
def test_the_pages_build_without_a_warning(tmp_path):
    # Those of the documentation, and those of the environments that it documents.
    for extra in ("furo", "myst_parser", "gymnasium", "stable_baselines3"):
        pytest.importorskip(extra)
    completed = subprocess.run(
        [sys.executable, "-m", "sphinx", "-W", "--keep-going", "-q", DOCS, tmp_path / "html"],
        capture_output=True,
        text=True,
    )
    assert completed.returncode == 0, completed.stderr
    assert (tmp_path / "html" / "index.html").exists()
