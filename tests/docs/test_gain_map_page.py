"""The page on the gain map says what its command says."""

import re

import pytest

from pages import DOCS
from programs import main

PAGE = DOCS / "reproduction" / "gain-map.md"
ROW = re.compile(
    r"^\| (\w+) \| ([\w ]+) \| (\S+) ± (\S+) \| (\S+) \[(\S+), (\S+)\] \| (\d+) \| (\d+) \|$",
    re.MULTILINE,
)
LINE = re.compile(
    r"^(\w+), ([\w ]+): best σ = \S+ \+ \((\S+) ± (\S+)\) ω, R² = (\S+) \[(\S+), (\S+)\], "
    r"(\d+) frequencies(?:; (\d+) more)?",
    re.MULTILINE,
)


@pytest.mark.thorough
def test_the_table_of_the_page_is_what_the_command_prints(tmp_path, capsys):
    assert main(["reproduction", "gain-map", "--out", str(tmp_path / "map.png")]) == 0
    rows = ROW.findall(PAGE.read_text(encoding="utf-8").replace("−", "-"))
    printed = LINE.findall(capsys.readouterr().out)
    assert [row[:2] for row in rows] == [line[:2] for line in printed]
    assert len(rows) == 4
    for row, line in zip(rows, printed, strict=True):
        notes = [float(number or 0) for number in line[2:]]
        assert [float(number) for number in row[2:]] == pytest.approx(notes, abs=0.0051)
