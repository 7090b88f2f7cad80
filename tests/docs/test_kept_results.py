"""The results that come with the project: pages show what their tables say."""

from __future__ import annotations

import re

import pytest

from places import ROOT
from tegotae.figures.report.verdicts import verdict_texts
from tegotae.figures.study import ARCHITECTURES, architectures
from tegotae.studies.paper.claims import NOT_MEASURED, all_verdicts
from tegotae.studies.paper.export import read_csv
from tegotae.systems.models import all_models

KEPT = ROOT / "docs" / "_static"


@pytest.fixture(scope="module")
def table():
    return read_csv(KEPT / "study" / "paper.csv")


@pytest.fixture(scope="module")
def verdicts(table):
    return all_verdicts(table, KEPT / "experiments")


def kept_beside() -> dict:
    """The tables that stand beside that of the study, where there are some."""
    budgets = KEPT / "study" / "paper-budgets.csv"
    others = sorted((KEPT / "study").glob("paper-[!b]*.csv"), reverse=True)
    return {
        "budgets": read_csv(budgets) if budgets.exists() else None,
        "beside": {path.stem: read_csv(path) for path in others},
    }


def test_the_table_has_fifteen_runs_of_every_model(table):
    for name in all_models():
        assert (table["model"] == name).sum() == 15


def test_all_models_of_the_table_are_the_papers(table):
    assert len(table.of_the_paper()) == len(table)
    assert architectures(table)[: len(ARCHITECTURES)] == ARCHITECTURES
    assert set(architectures(table)) == set(table["architecture"].tolist())


def test_every_claim_is_measured(verdicts):
    assert [verdict.number for verdict in verdicts] == list(range(1, 12))
    assert all(verdict.verdict != NOT_MEASURED for verdict in verdicts)


def test_the_page_of_the_claims_shows_what_the_tables_say(table):
    texts = verdict_texts(table, KEPT / "experiments", **kept_beside())
    for name, text in texts.items():
        assert (KEPT / "study" / name).read_text(encoding="utf-8") == text, name


@pytest.mark.parametrize("page", ["README.md", "docs/claims.md"])
def test_verdicts_in_prose_are_those_of_the_tables(page, verdicts):
    text = (ROOT / page).read_text(encoding="utf-8")
    pattern = {
        "README.md": r"^\| (\d+) \|.*?\*\*(\w+)\*\*",
        "docs/claims.md": r"^\*\*(\d+)\. .*?: (holds|fails|undecided)",
    }[page]
    said = {int(number): word for number, word in re.findall(pattern, text, re.MULTILINE)}
    assert said == {verdict.number: verdict.verdict for verdict in verdicts}


def test_the_multiverses_shares_follow_from_its_kept_tables():
    from tegotae.figures.report.multiverse import shares_table
    from tegotae.studies.paper.multiverse.tables import read_tables

    kept = ROOT / "docs" / "_static" / "multiverse"
    readings, judged = read_tables(kept)
    assert shares_table(readings, judged, "all") == (kept / "multiverse.md").read_text()
