"""The front page of the repository is short, and its commands do what it shows."""

import re
import shlex

import pytest

from places import ROOT
from programs import main, parsed
from prose_numbers import MARK
from research_pages import source_of

README = MARK.sub("", (ROOT / "README.md").read_text(encoding="utf-8"))
MOST_WORDS = 700
SHOWN = re.findall(r"^\$ (tegotae .*)\n((?:(?!\$|```).*\n)*)", README, re.M)


def test_it_is_read_in_three_minutes():
    assert len(README.split()) <= MOST_WORDS


def test_it_begins_with_a_hopper_and_a_walker():
    first = README.partition("\n\n`tegotae`")[0]
    pictures = re.findall(r"!\[[^]]+\]\(([^)]+)\)", first)
    assert pictures == ["docs/_static/hopper.gif", "docs/_static/gaits/animation.gif"]


def test_its_links_lead_to_pages_with_their_text():
    for target in re.findall(r"\]\(([^)#]+)", README):
        assert (ROOT / target).exists(), target
        if target.endswith(".md"):
            assert source_of(ROOT / target) == ROOT / target, f"{target} only says where it is"


@pytest.mark.parametrize("term", ["VG", "T0", "T1", "CPGu", "ART", "PGPE"])
def test_it_uses_no_term_that_it_does_not_define(term):
    prose = re.sub(r"```.*?```", "", README, flags=re.S)
    assert not re.search(rf"\b{term}\b", prose)


def test_its_commands_are_understood():
    assert len(SHOWN) == 3
    for command, _ in SHOWN:
        parsed(shlex.split(command)[1:])


@pytest.mark.parametrize("verb", ["simulate", "export"])
def test_a_command_prints_what_is_shown(verb, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    command, output = next(block for block in SHOWN if block[0].split()[1] == verb)
    arguments = shlex.split(command)[1:]
    if "--animate" in arguments:  # drawing takes longer than the rollout
        position = arguments.index("--animate")
        del arguments[position : position + 2]
    assert main(arguments) == 0
    printed = " ".join(capsys.readouterr().out.split())
    for line in output.splitlines():
        assert " ".join(line.split()) in printed
