"""The tests mirror the rooms, and share by helpers alone."""

import re

from places import ROOT, TESTS

ROOMS = {
    folder.name.lstrip("_")
    for folder in (ROOT / "src" / "tegotae").iterdir()
    if any(folder.glob("*/*.py")) or any(folder.glob("*.py"))
}
BESIDE = {"lanewise", "robots", "reproduction", "studies", "playground", "benchmarks"}
"""The compiler below the package, robots above it, and folders of programs beside it."""
OTHERS = {"docs", "helpers", "kept", "users"}
"""Pages, what tests share, what must not change, and parts of a user."""
FILES = sorted(TESTS.rglob("test_*.py"))


def test_every_folder_of_tests_is_that_of_a_room():
    folders = {file.relative_to(TESTS).parts[0] for file in FILES}
    assert folders <= ROOMS | BESIDE | OTHERS


def test_every_file_of_tests_is_in_a_room():
    assert [file.name for file in FILES if file.parent == TESTS] == []


def test_no_two_files_of_tests_have_one_name():
    assert len({file.name for file in TESTS.rglob("*.py")}) == len(list(TESTS.rglob("*.py")))


def test_no_file_of_tests_imports_another():
    pattern = re.compile(r"^\s*(?:from|import) (test_\w+)", re.MULTILINE)
    by_file = {file.name: pattern.findall(file.read_text(encoding="utf-8")) for file in FILES}
    assert {name: modules for name, modules in by_file.items() if modules} == {}
