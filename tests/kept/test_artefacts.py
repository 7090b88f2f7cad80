"""Every kept artefact belongs to a row that says how it is made; some checks of that."""

import json
import re
from collections import Counter

import pytest

import artefacts
from artefacts import CHECKS, Artefact, artefacts as rows, closure, code_of, tracked
from places import ROOT

_MADE = re.compile(
    r"\.(csv|npz|png|gif|svg|webp|json|wasm\.gz|onnx|c|h)$|^docs/_static/|^research/.*\.md$"
)
"""Files that programs make."""
_WRITTEN = re.compile(
    r"^(examples|src/tegotae_robots/c/templates|tests/helpers|\.github)/|^research/paper/.*\.md$"
    r"|^research/\w+/((\w+_)?page|plan)\.md$|^research/certificate/latch\.json$"
)
"""Files of such names that are written by hand."""


def test_every_kept_file_belongs_to_one_row():
    owners = Counter(path for row in rows() for path in row.paths)
    made = [path for path in tracked() if _MADE.search(path) and not _WRITTEN.search(path)]
    without_row = [path for path in made if owners[path] != 1]
    assert without_row == [], "name each in one row of an artefacts.toml"


@pytest.mark.parametrize("row", rows(), ids=lambda row: row.files[0])
def test_a_row_has_files_and_a_command_that_is_there(row: Artefact):
    pins = json.loads((ROOT / artefacts.PINS).read_text(encoding="utf-8"))["pins"]
    empty = [pattern for pattern in row.files if not artefacts.matching([pattern])]
    assert empty == []
    assert [pattern for pattern in row.needs if not artefacts.matching([pattern])] == []
    assert set(row.pins) <= set(pins)
    assert row.check in ("", *CHECKS)
    assert row.has_command, row.command


def test_what_a_command_runs_is_found_through_its_imports():
    reached = closure([ROOT / "research" / "gaits" / "walker_cost.py"])
    assert {"research/gaits/walker_cost.py", "src/tegotae/parts/bodies/base.py"} <= reached


def test_comments_and_docstrings_are_no_change_of_code():
    code = 'def speed(v):\n    """Return it."""\n    return v  # m/s\n'
    assert code_of(code) == code_of("def speed(v):\n    return v\n")
    assert code_of(code) != code_of("def speed(v):\n    return -v\n")
