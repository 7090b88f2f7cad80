"""Tables on the screen: split where a terminal is too narrow, whole elsewhere, never cut."""

import io
import re

import pytest

from tegotae.cli.console import print_rows

COLUMNS = ("controller", "CoT⁻¹ A [m/J]", "T0 [s]", "T1 [s]")
ROWS = [("ART-rF-tphif-w8", "0.421 [0.398, 0.444]", "12.3 [10.1, 14.5]", "8.88"), ("V", *"123")]


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


@pytest.fixture
def shown(monkeypatch):
    def show(width: int, stream: io.StringIO) -> list[str]:
        monkeypatch.setenv("COLUMNS", str(width))
        monkeypatch.setenv("TERM", "xterm")
        monkeypatch.setattr("sys.stdout", stream)
        print_rows(COLUMNS, ROWS)
        return re.sub("\x1b\\[[0-9;]*m", "", stream.getvalue()).splitlines()

    return show


@pytest.mark.parametrize("width", [20, 45, 60, 200])
def test_every_number_is_on_the_screen_whole_and_beside_its_row(shown, width):
    lines = shown(width, Terminal())
    for name, *cells in ROWS:
        own = " ".join(line for line in lines if line.split()[:1] == [name])
        assert all(cell in own for cell in cells)
    assert "…" not in "".join(lines)


@pytest.mark.parametrize(("width", "tables"), [(45, 3), (60, 2), (200, 1)])
def test_a_terminal_too_narrow_gets_several_tables_that_fit(shown, width, tables):
    lines = shown(width, Terminal())
    assert max(map(len, lines)) <= width
    assert sum("controller" in line for line in lines) == tables


def test_a_file_or_pipe_gets_one_wide_table(shown):
    lines = shown(30, io.StringIO())
    assert sum("controller" in line for line in lines) == 1
    assert max(map(len, lines)) > 30


def printed(columns, rows, capsys) -> list[str]:
    print_rows(columns, rows)
    return [line.rstrip() for line in capsys.readouterr().out.splitlines() if line.strip()]


WIDE = tuple(f"quantity {i}" for i in range(12))


def test_many_numbers_of_one_are_listed_below_each_other(capsys):
    lines = printed(("controller", *WIDE), [("V", *"0123456789ab")], capsys)
    assert lines[0].split() == ["controller", "V"]
    assert lines[3].split() == ["quantity", "1", "1"]
    assert max(map(len, lines)) <= 80


def test_a_table_of_several_rows_or_that_fits_has_a_line_a_row(capsys):
    lines = printed(("controller", "T0 [s]"), [("V", "1")], capsys)
    assert lines[0].split() == ["controller", "T0", "[s]"]
    lines = printed(
        ("controller", *WIDE), [("V", *"0123456789ab"), ("ART", *"cdefghijklmn")], capsys
    )
    assert [line.split()[0] for line in lines[2:]] == ["V", "ART"]


def test_each_part_begins_with_all_keys(monkeypatch, capsys):
    monkeypatch.setenv("COLUMNS", "16")
    monkeypatch.setattr("sys.stdout.isatty", lambda: True)
    print_rows(("a", "b", "first", "second"), [("1", "2", "3", "4"), tuple("5678")], key=2)
    lines = [line.split() for line in capsys.readouterr().out.splitlines()]
    assert [line for line in lines if line[:1] == ["1"]] == [["1", "2", "3"], ["1", "2", "4"]]
