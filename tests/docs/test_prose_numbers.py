"""Numbers in the prose of pages are those of their tables."""

import pytest

from places import ROOT
from prose_numbers import MARK, cell, cells, crossing, pages, rows, stale
from research_pages import source_of

MARKED = [path for path in pages() if MARK.search(path.read_text(encoding="utf-8"))]

WITHOUT_MARKS = {"tables"}
"""Studies that may have none: numbers of theirs are still to be held to tables."""


@pytest.mark.parametrize("path", MARKED, ids=lambda path: path.stem)
def test_a_page_says_what_its_tables_say(path):
    assert stale(path.read_text(encoding="utf-8")) == []


@pytest.mark.parametrize(
    ("text", "right"),
    [
        ("it is 5<!-- = 4 -->", "4"),
        ("it is 91 %<!-- = 0.902 -->", "90"),
        ("it is +0.19 [0.17, 0.20]<!-- = (0.19, 0.17, 0.21) -->", "+0.19 0.17 0.21"),
        ("it is −0.004<!-- = 0.004 -->", "0.004"),
        ("it is 0.19<!-- = (0.19, 0.17, 0.21) -->", "0.19"),
        ("it is 3 058<!-- = 3059 -->", "3 059"),
        ("between 1.2 and 2.5 %<!-- = [0.012, 0.03] -->", "1.2 3.0"),
        ("it is 5<!-- = [4, 5] -->", "4"),
    ],
)
def test_a_number_changed_by_hand_is_found(text, right):
    (fault,) = stale(text)
    assert fault.endswith(f" is {right}")


def test_a_mark_without_a_number_is_found():
    assert stale("some<!-- = 4 -->") == ["no number stands before the mark 4"]


def test_numbers_are_compared_as_they_are_written():
    assert stale("−0.004 [−0.016, 0.007]<!-- = (-0.0042, -0.0164, 0.0068) --> m/J") == []
    assert stale("-0.00<!-- = -0.001 -->") == ["-0.00 is shown, and -0.001 is 0.00"]
    assert stale("70 %<!-- = 0.704 --> of 3059<!-- = 3059 -->") == []
    assert stale("ω_t4 between 6 and 11.0 mm, −0.5<!-- = [6.2, 11, -0.52] -->") == []


def test_every_study_with_a_result_has_marks():
    studies = [source_of(page) for page in (ROOT / "docs" / "studies").glob("*.md")]
    with_results = {path for path in studies if "**Result" in path.read_text(encoding="utf-8")}
    assert {path.stem for path in with_results - set(MARKED)} <= WITHOUT_MARKS


def test_the_front_page_has_marks():
    assert ROOT / "README.md" in MARKED


def test_a_number_of_an_included_table_is_named_by_its_column_and_row():
    assert cell("learned_legs/robust", "mass 0.8", "cos+range") == 0.69
    assert cell("learned_legs/robust", "mass 0.8", "cos+range", part=3) == 0.82
    assert len(cells("legs_limit/limit", "CoT")) == 24


@pytest.mark.parametrize("key", [("mass 0.9", "cos+range"), ("mass 0.8", "sine+range")])
def test_a_column_or_row_that_is_not_there_is_refused(key):
    with pytest.raises(LookupError, match="has no"):
        cell("learned_legs/robust", *key)


def test_rows_have_one_of_the_values_that_are_asked_for():
    selected = rows("lost_leg/reacting", body="feels-tilt", run=[0, 2], leg="LH")
    assert selected.run.tolist() == [0, 2]


def test_a_multiplier_crosses_one_between_two_values():
    assert 1.0 < crossing("stability-bar", "in phase", "inertia_ratio", rises=False) < 1.05
