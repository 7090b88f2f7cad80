"""The sidebar is short, pages are arranged by need, studies begin with results; no wide tables."""

import re
from collections import Counter
from pathlib import Path

import pytest

from pages import DOCS
from places import ROOT
from research_pages import source_of

MOST = 7
"""Entries of a group on the front page."""


def contents(page: Path) -> dict[str, list[Path]]:
    """The pages of each table of contents of a page, by its caption."""
    sections: dict[str, list[Path]] = {}
    for block in re.findall(r"^```\{toctree\}\n(.*?)^```$", page.read_text(), re.M | re.S):
        caption = re.search(r":caption: (.*)", block)
        entries = [line for line in block.splitlines() if line and not line.startswith(":")]
        pages = [(page.parent / f"{entry}.md").resolve() for entry in entries]
        sections.setdefault(caption[1] if caption else page.stem, []).extend(pages)
    return sections


def test_pages_are_arranged_by_need():
    needs = ["Tutorials", "How to", "Explanation", "Evidence", "Reference"]
    assert list(contents(DOCS / "index.md")) == needs


@pytest.mark.parametrize("group", contents(DOCS / "index.md"))
def test_a_group_of_the_sidebar_has_few_entries(group):
    assert len(contents(DOCS / "index.md")[group]) <= MOST


def test_the_front_page_does_not_repeat_the_sidebar():
    text = (DOCS / "index.md").read_text(encoding="utf-8")
    assert text.count("```{toctree}") == text.count(":hidden:")


def test_every_page_is_in_the_sidebar_once():
    pages = {page for page in DOCS.rglob("*.md") if not {"_static", "_build"} & {*page.parts}}
    listed = Counter(
        entry for page in pages for group in contents(page).values() for entry in group
    )
    assert {page for page, times in listed.items() if times > 1} == set()
    assert pages - listed.keys() == {DOCS / "index.md"}


STUDIES = sorted(
    source_of(page) for page in (DOCS / "studies").glob("*.md") if page.stem != "index"
)


@pytest.mark.parametrize("page", STUDIES, ids=lambda page: page.stem)
def test_a_study_begins_with_its_readers_and_its_result(page):
    opening = page.read_text(encoding="utf-8").partition("\n\n")[2].partition("\n\n")[0]
    assert opening.startswith("This page is for readers who ")
    assert "**Result:**" in opening


def test_tables_have_at_most_eight_columns():
    wide = [
        f"{page.relative_to(ROOT)}: {row}"
        for place in (DOCS, ROOT / "research")
        for page in place.rglob("*.md")
        for row in re.findall(r"^\|(?: ?:?-+:? ?\|){9,}$", page.read_text(encoding="utf-8"), re.M)
    ]
    assert wide == []
