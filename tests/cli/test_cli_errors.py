"""The command as a whole: help for people, one line for what goes wrong, and the exit status."""

from __future__ import annotations

import errno
import inspect
import os
import subprocess
import sys
from collections.abc import Iterator

import pytest
from jax.errors import JaxRuntimeError

from programs import PROGRAMS, main, parsed, words_of
from tegotae import Engine, TegotaeError
from tegotae.cli import split_parts
from tegotae.cli.commands import COMMANDS, SECTIONS
from tegotae.cli.console import exit_status
from tegotae.cli.program import Command, CommandGroup


def test_without_a_subcommand_they_are_listed(one_line_error):
    said = one_line_error()
    assert all(name in said for name in COMMANDS)
    assert "--help" in said


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["simulate", "--sgima", "2"], "--sgima, 2; perhaps you meant --sigma FLOAT"),
        (
            ["simulate", "--duration", "long"],
            "--duration is 'long'; write --duration FLOAT",
        ),
        (["simulate", "--duration"], "Missing value for argument '--duration'"),
        (
            ["gait", "sweep", "bar-light", "--levels", "1"],
            "for argument '--levels'. Expected 2 values",
        ),
        (["simulate", "paper", "--extra"], "Unrecognized options: --extra"),
        (["models", "--zoo", "ART"], "Unrecognized options: ART; names come before options"),
        (["doctor", "x"], "'x' is one word too many; no name is asked for"),
        (["train"], "names come first: tegotae train NAME [OPTIONS]"),
        (["train", "ART", "--seeds", "1.5"], "--seeds is '1.5'; write --seeds INT"),
        (["gait", "sweep"], "names come first: tegotae gait sweep NAME"),
        (
            ["gait", "sweep", "bar-light", "--levels", "1", "b"],
            "--levels is '1 b'; write --levels FLOAT",
        ),
        (["models", "--json", "true", "false"], "false"),
        (["figure", "--foo"], "tegotae figure has no option '--foo'; tegotae figure takes one of"),
        (["completion", "fish"], "invalid choice 'fish' for argument 'shell'"),
        (["benchmarks", "--lanes", "1e3"], "--lanes is '1e3'; write --lanes INT"),
        (["models", "x" * 999, "y" * 999], "models takes one name; xxx"),
        (["simulate", "x" * 999], "File name too long"),
        (["--parts", "tests", "models"], "there is no module tests; for a file write FILE"),
    ],
)
@pytest.mark.parametrize("columns", ["20", None])
def test_words_that_make_no_command_are_refused_with_what_was_meant(
    one_line_error, monkeypatch, words, said, columns
):
    if columns:
        monkeypatch.setenv("COLUMNS", columns)
    else:
        monkeypatch.delenv("COLUMNS", raising=False)
    found = one_line_error(*words)
    assert said in found
    assert len(found) < 640
    assert os.environ.get("COLUMNS") == columns


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["simulat"], "no command of tegotae is called 'simulat'; did you mean simulate"),
        (["figure", "surfac"], "no command of tegotae figure is called 'surfac'; did you mean"),
        (["simulate", "a" * 5000], "an argument has 5000 characters; it must have at most 1000"),
        (["train", "ART", "--vary", "mass_kg=0.0_8:0.1"], "is no condition"),
        (["generalise", "V", "--conditions", "delay=0.0_1/0.02"], "has no levels"),
        (["simulate", "front:quadruped-c/0.4_0"], "is no speed"),
        (["generalise", "V-sector-w4", "--conditions", ""], "no condition is called ''; some that"),
        (["gait", "front", "quadruped-c", "--walkers", "10000000000"], "must be at most 1000000"),
        (["train", "ART", "--algorithm", "pgp"], "did you mean pgpe"),
        (["reproduction", "optimum-table", "--starts", "0"], "starts is 0; it must be a whole"),
        (["simulate", "{empty}:nothing"], "is called 'nothing'; there is none"),
    ],
)
def test_words_that_nothing_is_called_by_are_refused_in_one_line(
    one_line_error, tmp_path, monkeypatch, words, said
):
    monkeypatch.chdir(tmp_path)  # a folder of results is made here
    empty = tmp_path / "nothing_in_it.py"
    empty.touch()
    found = one_line_error(*(word.format(empty=empty) for word in words))
    assert said in found
    assert "pgpe, pgpe" not in found


def explanation(capsys, *words: str) -> str:
    with pytest.raises(SystemExit) as raised:
        main([*words, "--help"])
    assert raised.value.code == 0
    return capsys.readouterr().out


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_explains_itself_and_its_options(capsys, command):
    entry = COMMANDS[command]
    out = explanation(capsys, command)
    assert out.startswith(f"usage: tegotae {command} ")
    if isinstance(entry, CommandGroup):
        assert all(f"  {part} " in out for part in entry.commands)
        out += "".join(explanation(capsys, command, part) for part in entry.commands)
    assert "None" not in out  # plain words, no Python


def test_the_program_lists_its_commands_by_purpose_within_80_columns(capsys):
    out = explanation(capsys)
    assert all(f"\n  {name} " in out for name in COMMANDS)
    assert all(f"\n{title}\n" in out for title in SECTIONS)
    assert max(map(len, out.splitlines())) <= 80


def test_every_command_has_one_place_in_the_list():
    assert sorted(name for names in SECTIONS.values() for name in names) == sorted(COMMANDS)


def commands_of(entry: Command | CommandGroup) -> Iterator[Command]:
    if isinstance(entry, Command):
        yield entry
    else:
        for below in entry.commands.values():
            yield from commands_of(below)


EVERY_COMMAND = [command for program, _ in PROGRAMS.values() for command in commands_of(program)]


@pytest.mark.parametrize("command", EVERY_COMMAND, ids=lambda each: each.name)
def test_the_line_about_a_command_is_the_first_of_its_docstring(command):
    whole = inspect.cleandoc(command.load().__doc__)
    assert command.summary == " ".join(whole.split("\n\n")[0].split())
    assert command.summary.endswith(".")


@pytest.mark.parametrize("command", EVERY_COMMAND, ids=lambda each: each.name)
def test_every_command_has_two_examples_that_are_understood(command):
    assert len(command.examples) == 2
    for example in command.examples:
        words = words_of(example)
        assert words
        asked = parsed(split_parts(words)[0])
        assert getattr(asked, "question", type(asked)) is command.load()


@pytest.mark.parametrize("words", ["cite", "figure surface", "export"])
def test_the_help_of_a_command_ends_with_its_examples(capsys, words):
    *_, title, first, second = explanation(capsys, *words.split()).splitlines()
    assert title == "Examples:"
    assert first.startswith(f"  tegotae {words}")
    assert second.startswith(f"  tegotae {words}")


@pytest.mark.parametrize("words", ["train", "generalise", "gait map"])
def test_the_options_of_a_command_fit_80_columns_and_show_no_empty_default(capsys, words):
    out = explanation(capsys, *words.split())
    boxes = [line for line in out.splitlines() if line[:1] in "╭│╰"]
    assert max(map(len, boxes)) <= 80
    assert "(default: )" not in out


LISTING = """
import sys
from tegotae.cli import main, parsed, split_parts
try:
    main({words})
except SystemExit as end:
    assert end.code == 0
heavy = ("jax", "numpy", "matplotlib", "scipy", "pandas", "gymnasium", "torch", "evosax")
print([name for name in heavy if name in sys.modules])
"""


@pytest.mark.parametrize("words", [["--help"], ["figure", "--help"], ["--version"]])
def test_the_list_of_commands_is_there_at_once(words):
    program = LISTING.format(words=words)
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.splitlines()[-1] == "[]", "help needs none of these"


def test_of_all_commands_the_one_that_is_named_is_imported():
    program = LISTING.format(words=["models", "--help"])
    program += (
        "print([name for name in sys.modules if name.startswith('tegotae.questions.training')])"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert done.stdout.splitlines()[-1] == "[]"


def test_it_can_be_run_as_a_module():
    done = subprocess.run(
        [sys.executable, "-m", "tegotae", "models", "T-F"], capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines()[-1] == "1 models"


# How a command ends.


def raising(error: BaseException):
    def command() -> None:
        raise error

    return command


OUT_OF_MEMORY = "RESOURCE_EXHAUSTED: Out of memory allocating 77000003792 bytes."


@pytest.mark.parametrize(
    ("error", "status", "line"),
    [
        (TegotaeError("mass_kg is 0"), 2, "mass_kg is 0"),
        (MemoryError(), 2, "out of memory; ask for less, or free some"),
        (
            MemoryError("Unable to allocate 7 GiB for an array"),
            2,
            "out of memory: Unable to allocate 7 GiB for an array; ask for less, or free some",
        ),
        (JaxRuntimeError(OUT_OF_MEMORY), 2, "out of memory; use fewer lanes or a shorter duration"),
        (OSError(errno.ENOSPC, "No space left on device"), 1, "[Errno 28] No space left on device"),
        (KeyboardInterrupt(), 130, "interrupted"),
        (KeyboardInterrupt("interrupted; runs keeps it"), 130, "interrupted; runs keeps it"),
    ],
)
def test_what_goes_wrong_is_said_in_one_line(capsys, error, status, line):
    assert exit_status(raising(error)) == status
    assert capsys.readouterr() == ("", f"tegotae: {line}\n")


def test_a_reader_that_has_seen_enough_is_no_error(capsys):
    assert exit_status(raising(BrokenPipeError())) == 141
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize(
    "error", [ValueError("a bug"), JaxRuntimeError("INTERNAL: a bug"), KeyError(), AssertionError()]
)
def test_a_bug_is_one_line_and_its_traceback_for_those_who_ask(capsys, monkeypatch, error):
    named = ": ".join(filter(None, [type(error).__name__, str(error)]))
    monkeypatch.delenv("TEGOTAE_DEBUG", raising=False)
    assert exit_status(raising(error)) == 70
    assert capsys.readouterr() == (
        "",
        f"tegotae: unexpected {named}; run again with --debug for details, and please report it\n",
    )
    monkeypatch.setenv("TEGOTAE_DEBUG", "1")
    assert exit_status(raising(error)) == 70
    said = capsys.readouterr().err
    assert said.startswith("Traceback (most recent call last):")
    assert said.endswith(f"\ntegotae: unexpected {named}; please report it\n")


@pytest.mark.parametrize(
    "command", ["simulate", "evaluate V-reflex-w8", "compare V-sector-w4 paper", "benchmarks"]
)
def test_ctrl_c_anywhere_ends_in_one_line(capsys, monkeypatch, command):
    def interrupt(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr(Engine, "run", interrupt)
    monkeypatch.setattr("benchmarks.engine.speed", interrupt)
    assert main(command.split()) == 130
    assert capsys.readouterr() == ("", "tegotae: interrupted\n")


LEAVING = """
import os, sys, threading
from tegotae.cli.console import leave
threading.Thread(target=threading.Event().wait).start()  # work that would never let Python end
print("kept", end="")
leave(130)
"""


def test_after_ctrl_c_nothing_that_still_works_holds_the_process_up():
    done = subprocess.run(
        [sys.executable, "-c", LEAVING], capture_output=True, text=True, timeout=900
    )
    assert (done.returncode, done.stdout, done.stderr) == (130, "kept", "")


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="this system has no full device")
def test_a_full_disk_behind_stdout_is_said_in_one_line():
    with open("/dev/full", "w") as full:
        done = subprocess.run(
            [sys.executable, "-m", "tegotae", "models", "V", "--json"],
            stdout=full,
            stderr=subprocess.PIPE,
            text=True,
        )
    assert done.returncode == 1
    assert done.stderr == "tegotae: [Errno 28] No space left on device\n"


def test_bench_refuses_lanes_that_are_none(one_line_error):
    assert "lanes is 0; it must be a whole number of at least 1" in one_line_error(
        "benchmarks", "--lanes", "0"
    )


def test_a_study_refuses_workers_that_are_none(tmp_path, one_line_error):
    words = ["--dir", str(tmp_path / "study"), "--workers", "0"]
    assert "workers is 0; it must be a whole number" in one_line_error(
        "reproduction", "run", *words
    )
    assert not (tmp_path / "study").exists()


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("gait map bar-light --x sigma 1 2 --y sigma 1 2 --out new/map", "a map is over two"),
        ("gait stability bar-light --over nothing 0 1 --out new/map", "called 'nothing'"),
        ("simulate V-sector-w4 --omega -1 --plot new/a.png --csv new/a.csv", "omega is -1"),
        ("figure surface V-sector-w4 --omega -1 --out new/a.png", "omega is -1"),
    ],
)
def test_a_refused_command_leaves_no_folder(tmp_path, monkeypatch, one_line_error, words, said):
    monkeypatch.chdir(tmp_path)
    assert said in one_line_error(*words.split())
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["evaluate", "V-sector-w4", "--work", "kinetic"], "work is 'kinetic'"),
        (["evaluate", "V-sector-w4", "--undisturbed", "nan"], "undisturbed_s is nan"),
        (["evaluate", "runs/none"], "no controller file at runs/none"),
        (["evaluate", "ART"], "has weights to train and no file was given"),
        (["compare"], "names come first: tegotae compare NAME [OPTIONS]"),
        (["compare", "V-sector-w4", "V-reflex-w4", "--drop", "-1"], "drop_m is -1"),
    ],
)
def test_an_evaluation_of_nothing_is_refused_before_any_rollout(
    monkeypatch, one_line_error, words, said
):
    def run(*_, **__):
        raise AssertionError("a rollout was started before the input was checked")

    monkeypatch.setattr(Engine, "run", run)
    assert said in one_line_error(*words)
