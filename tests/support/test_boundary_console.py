"""Input of any console: plain spellings, closed streams, Ctrl-C before anything is loaded."""

import importlib.metadata
import io
import os
import subprocess
import sys

import pytest

from tegotae._support import compiled
from tegotae.cli import main
from tegotae.cli.console import PLAIN, make_safe, one_line, print_rows, printable


@pytest.mark.parametrize("encoding", ["ascii", "cp1252", "latin-1", "utf-8"])
@pytest.mark.parametrize("text", ["CoT⁻¹ [m/J], ω = 2π ± 1 – φ̇", "\udcff", "│ 日本 │", "🦘"])
def test_whatever_is_printed_has_a_spelling(encoding, text):
    stream = io.TextIOWrapper(io.BytesIO(), encoding=encoding, errors=PLAIN)
    print(text, file=stream, flush=True)


def test_plain_spellings_are_readable():
    assert printable("CoT⁻¹ – ω_t ≥ 4", "ascii") == "CoT^-1 - omega_t >= 4"
    assert printable("CoT⁻¹ – ω_t ≥ 4", "utf-8") == "CoT⁻¹ – ω_t ≥ 4"
    assert printable("日", "ascii") == "\\u65e5"


def test_the_programs_streams_are_made_safe(monkeypatch):
    out = io.TextIOWrapper(io.BytesIO(), encoding="ascii")
    monkeypatch.setattr(sys, "stdout", out)
    monkeypatch.setattr(sys, "stderr", io.StringIO())  # which takes everything as it is
    make_safe()
    print("ω", end="", flush=True)
    assert out.buffer.getvalue() == b"omega"


def test_an_error_is_one_line_whatever_is_in_it():
    assert one_line("a\nb\r\n  c") == "a b c"
    assert one_line("\x1b]0;title\x07 \udcff \u2028ω") == r"\x1b]0;title\x07 \udcff ω"


NAMES = ["[red]", "[/]", "$x_", ":smile:", "\x1b[31m", "\udcff", "a\tb\nc", "\u202e"]


@pytest.mark.parametrize("name", NAMES)
def test_a_name_is_shown_in_a_table_as_it_is(capsys, name):
    print_rows(["name", "value"], [[name, "1"]])
    assert printable(name, "utf-8") in capsys.readouterr().out


@pytest.mark.parametrize("encoding", ["ascii", "latin-1"])
def test_a_plain_table_is_aligned(monkeypatch, encoding):
    out = io.TextIOWrapper(io.BytesIO(), encoding=encoding, errors=PLAIN)
    monkeypatch.setattr(sys, "stdout", out)
    print_rows(["CoT⁻¹ [m/J]", "ω_t"], [["1", "8"], ["–", "4"]])
    out.flush()
    lines = out.buffer.getvalue().decode(encoding).splitlines()
    assert len({len(line) for line in lines if line.strip()}) == 1


def test_the_version_is_told(capsys):
    assert main(["--version"]) == 0
    assert capsys.readouterr().out == f"tegotae {importlib.metadata.version('tegotae')}\n"


def test_debug_stands_anywhere_and_shows_where_an_error_arose(capsys, monkeypatch):
    def bug(*_):
        raise KeyError("a bug")

    monkeypatch.setattr("tegotae.api.listing.study_recipes", bug)
    monkeypatch.setenv("TEGOTAE_DEBUG", "0")
    assert main(["models", "T"]) == 70
    assert "Traceback" not in capsys.readouterr().err
    assert main(["models", "--debug", "T"]) == 70
    assert "Traceback" in capsys.readouterr().err


def test_help_ends_as_it_did_before_when_it_was_kept(tmp_path, monkeypatch):
    monkeypatch.setenv(compiled.VARIABLE, str(tmp_path))
    for words in (["completion", "--help"], ["--help"]) * 2:
        assert main(words) == 0
    reader, writer = os.pipe()
    os.close(reader)
    with open(writer, "w") as out:
        monkeypatch.setattr(sys, "stdout", out)
        assert main(["--help"]) == 141


@pytest.mark.parametrize("words", [["models", "T-*"], ["--help"], ["cite"]])
def test_what_nobody_reads_ends_in_silence(capsys, monkeypatch, words):
    reader, writer = os.pipe()
    os.close(reader)
    with open(writer, "w") as out:
        monkeypatch.setattr(sys, "stdout", out)
        assert main(words) == 141
    assert capsys.readouterr().err == ""


LOADING = """
import os, signal, sys
signal.signal(signal.SIGINT, signal.default_int_handler)
class Impatient:
    def find_spec(self, name, *_):
        if name == "jax":
            os.kill(os.getpid(), signal.SIGINT)
sys.meta_path.insert(0, Impatient())
sys.argv = ["tegotae", "models", "T"]
{program}
"""


@pytest.mark.parametrize(
    ("program", "status", "message"),
    [
        ("from tegotae.cli import entry; entry()", 130, ""),
        ("import tegotae.simulation.rollout", 1, "K"),
    ],
)
def test_ctrl_c_while_the_program_is_loaded_ends_it_in_silence(program, status, message):
    """A program that imports the package sees its `KeyboardInterrupt` as always."""
    words = [sys.executable, "-c", LOADING.format(program=program)]
    completed = subprocess.run(words, capture_output=True, text=True)
    assert (completed.returncode in (status, -2), completed.stdout) == (True, "")
    assert (message in completed.stderr) if message else completed.stderr == ""


CLOSED = """
import os, sys
sys.stdin = sys.stdout = sys.stderr = None
for number in (0, 1, 2):
    os.close(number)
from tegotae._start import open_streams
open_streams()
kept = open(sys.argv[1], "w")
print("lost")
print("lost", file=sys.stderr)
kept.write("kept")
"""


def test_what_is_printed_to_a_closed_stream_goes_into_no_other_file(tmp_path):
    path = tmp_path / "file"
    completed = subprocess.run([sys.executable, "-c", CLOSED, str(path)], capture_output=True)
    assert (completed.returncode, completed.stdout, completed.stderr) == (0, b"", b"")
    assert path.read_text() == "kept"


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("TEGOTAE_CORES", "99999", "TEGOTAE_CORES is '99999'; on this machine of"),
        ("TEGOTAE_CORES", "0", "it must be a whole number from 1 to"),
        ("TEGOTAE_CORES", "many", "TEGOTAE_CORES is 'many'"),
        ("LANEWISE_OPT", "fast", "LANEWISE_OPT is 'fast'; it must be 0, 1, 2 or 3"),
    ],
)
def test_an_environment_that_cannot_be_had_is_told(
    monkeypatch, one_line_error, name, value, message
):
    monkeypatch.setenv(name, value)
    assert message in one_line_error("models", "T")


@pytest.mark.parametrize("variable", ["JAX_PLATFORMS", "JAX_PLATFORM_NAME"])
@pytest.mark.parametrize("error", [AssertionError(), RuntimeError("Unable to ...\nmore")])
def test_a_platform_that_is_not_there_is_told(monkeypatch, one_line_error, error, variable):
    def start():
        raise error

    monkeypatch.setenv(variable, "cuda")
    monkeypatch.setattr("jax.local_devices", start)
    message = one_line_error("models", "T")
    assert f"{variable} is 'cuda', which JAX cannot start here: " in message
