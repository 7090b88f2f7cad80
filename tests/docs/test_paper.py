"""The paper about the software has the form of its journal, and numbers of the tables."""

import re

import pytest

from pages import blocks
from places import ROOT
from programs import parsed, words_of
from prose_numbers import MARK, stale

PAPER = ROOT / "research" / "paper"
TEXT = (PAPER / "paper.md").read_text(encoding="utf-8")
SECTIONS = (
    *("Summary", "Statement of need", "State of the field", "Software design", "Research"),
    *("AI usage disclosure", "Acknowledgements", "References"),
)


def test_it_has_the_sections_and_the_length_that_the_journal_asks_for():
    assert re.findall(r"^# (.+)$", TEXT, re.M) == [*SECTIONS]
    body = MARK.sub("", TEXT.split("---\n", 2)[2])
    assert 750 <= len(body.split()) <= 1500


def test_every_work_that_it_cites_is_in_its_bibliography_and_the_other_way_round():
    listed = re.findall(r"^@\w+\{(\w+),", (PAPER / "paper.bib").read_text(encoding="utf-8"), re.M)
    assert {*re.findall(r"@([a-z]+\d{4}\w*)", TEXT)} == {*listed}
    assert len(listed) == len({*listed})


def test_its_numbers_are_those_of_the_tables():
    assert MARK.search(TEXT)
    assert stale(TEXT) == []


def test_its_commands_are_understood():
    ((_, block),) = blocks(PAPER / "paper.md", "console")
    assert len(block.splitlines()) == 3
    for line in block.splitlines():
        parsed(words_of(line))


def test_a_command_draws_its_figure():
    (picture,) = re.findall(r"\]\((\w+\.png)\)", TEXT)
    assert (PAPER / picture).is_file()
    (line,) = re.findall(rf"\$\(BIN\)/(tegotae .*paper/{picture})", (ROOT / "Makefile").read_text())
    parsed(words_of(line))


@pytest.mark.parametrize(
    "name",
    [
        "research/paper/paper.md",
        "research/paper/checklists.md",
        "CODE_OF_CONDUCT.md",
        "SUPPORT.md",
        "SECURITY.md",
    ],
)
def test_links_of_texts_about_the_project_lead_somewhere(name):
    text = (ROOT / name).read_text(encoding="utf-8")
    for target in re.findall(r"\]\((?!http)([^)#]+)", text):
        assert ((ROOT / name).parent / target).exists(), target


def test_forms_of_issues_are_valid():
    yaml = pytest.importorskip("yaml")
    forms = sorted((ROOT / ".github" / "ISSUE_TEMPLATE").glob("*.yml"))
    assert len(forms) == 3
    for form in forms:
        document = yaml.safe_load(form.read_text(encoding="utf-8"))
        assert {"name", "description", "body"} <= document.keys()
        assert all(part["attributes"]["label"] for part in document["body"])
