"""Texts for people use the field's words, and every term of the project is in the glossary."""

import inspect
import re
from collections.abc import Iterator

import pytest

from pages import DOCS
from places import ROOT
from programs import PROGRAMS
from research_pages import source_of
from tegotae.cli.functions import options_by_subject
from tegotae.cli.program import Command, CommandGroup, overview
from tegotae.cli.records import fields_of
from vocabulary import PROSE

_OF_THE_PAPER = ("research/paper/paper.md", "research/paper/checklists.md")
# Translations, NAME.ja.md, are not in English.
PAGES = sorted(
    [
        *(
            source_of(page)
            for page in DOCS.rglob("*.md")
            if "_static" not in page.parts and ".ja" not in page.suffixes
        ),
        *(ROOT / name for name in ("README.md", "CONTRIBUTING.md", "CODE_OF_CONDUCT.md")),
        *(ROOT / name for name in ("SUPPORT.md", "SECURITY.md", *_OF_THE_PAPER)),
    ]
)
TERMS = (
    *("Tegotae", "central pattern generator", "oscillator", "phase", "term", "action", "reaction"),
    *("gain", "actuation", "vanilla", "architecture", "model", "recipe", "coupling", "limb"),
    *("system", "experiment", "controller file", "preset", "release", "hop", "limit cycle"),
    *("CoT⁻¹", "ΔΩ", "Δw", "T0", "T1", "CPGu", "fitness", "PGPE", "plateau", "lane", "tick"),
    *("channel", "wiring", "gait", "lag", "CPG", "ω_t", "σ", "short law", "latch", "wary"),
    *("merit", "template", "zoo"),
)


def prose(text: str) -> Iterator[tuple[int, str]]:
    """The lines of a page, numbered, without code, links' targets and comments."""

    def blank(match: re.Match[str]) -> str:
        return re.sub(r"[^\n]", " ", match[0])

    text = re.sub(r"^(`{3,})(?!\{).*?^\1$", blank, text, flags=re.MULTILINE | re.DOTALL)
    text = re.sub(r"<!--.*?-->", blank, text, flags=re.DOTALL)
    text = re.sub(r"`[^`\n]*`|\]\([^)]*\)|\{\w+(:\w+)?\}", blank, text)
    yield from enumerate(text.splitlines(), 1)


def unplain(text: str) -> list[str]:
    """Words of a text that the project does not use, with line and advice."""
    faults = []
    for pattern, advice in PROSE.items():
        flags = re.IGNORECASE if pattern == pattern.lower() else 0
        word = re.compile(rf"(?<![\w-])(?:{pattern})(?![\w-])", flags)
        faults += [
            f"line {number}: {match[0]!r}: {advice}"
            for number, line in prose(text)
            for match in word.finditer(line)
        ]
    return faults


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_a_page_is_in_plain_english(page):
    assert unplain(page.read_text(encoding="utf-8")) == []


@pytest.mark.parametrize(
    "text",
    [
        "The paper tells nothing.",
        "This brings speed.",
        "## What is varied",
        "It hops. What is found is a gait.",
        "| option | what it is |",
    ],
)
def test_words_that_are_not_plain_are_found(text):
    assert len(unplain(text)) == 1


@pytest.mark.parametrize(
    "text",
    ["What is a lane?", "`tell` is a method.", "```console\nstudy.py tell\n```", "a storyteller"],
)
def test_questions_and_code_are_left_alone(text):
    assert unplain(text) == []


def helps(entry: Command | CommandGroup, prog: str) -> Iterator[str]:
    if isinstance(entry, Command):
        kind = entry.load()
        yield inspect.getdoc(kind) or ""
        if inspect.isfunction(kind):
            yield from (
                x.description
                for options in options_by_subject(entry).values()
                for x in options.values()
            )
        else:
            yield from (option.description for option in fields_of(kind))
        return
    yield overview(entry, prog)
    for name, below in entry.commands.items():
        yield from helps(below, f"{prog} {name}")


def test_help_is_in_plain_english():
    texts = [text for program in PROGRAMS.values() for text in helps(*program)]
    assert [unplain(text) for text in texts if unplain(text)] == []


def test_the_glossary_has_at_most_forty_entries():
    entries = re.findall(r"^\*\*", (DOCS / "glossary.md").read_text(encoding="utf-8"), re.M)
    assert len(entries) <= 40


@pytest.mark.parametrize("term", TERMS)
def test_a_term_of_the_project_is_in_the_glossary(term):
    defined = re.findall(
        r"^\*\*(.+?)\*\*", (DOCS / "glossary.md").read_text(encoding="utf-8"), re.M
    )
    assert term in {part for entry in defined for part in re.split(r", ", entry)}
