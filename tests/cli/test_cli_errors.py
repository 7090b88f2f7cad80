"""The command as a whole: help for people, one line for what goes wrong, and the exit status."""

import errno
import inspect
import os
import subprocess
import sys
from collections.abc import Iterator

import pytest
from jax.errors import JaxRuntimeError

from programs import PROGRAMS, main, parsed, words_of
from tegotae import Rollout, TegotaeError
from tegotae.cli import split_parts
from tegotae.cli.commands import COMMANDS, SECTIONS
from tegotae.cli.console import exit_status
from tegotae.cli.program import Command, CommandGroup


def explanation(capsys, *words: str) -> str:
    assert main([*words, "--help"]) == 0
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
        assert getattr(asked, "function", type(asked)) is command.load()


@pytest.mark.parametrize("words", ["cite", "figure surface", "export"])
def test_the_help_of_a_command_ends_with_its_examples(capsys, words):
    *_, title, first, second = explanation(capsys, *words.split()).splitlines()
    assert title == "Examples:"
    assert first.startswith(f"  tegotae {words}")
    assert second.startswith(f"  tegotae {words}")


@pytest.mark.parametrize("words", ["train", "robustness", "gait map"])
def test_the_options_of_a_command_fit_80_columns_and_show_no_empty_default(capsys, words):
    out = explanation(capsys, *words.split())
    boxes = [line for line in out.splitlines() if line[:1] in "╭│╰"]
    assert max(map(len, boxes)) <= 80
    assert "(default: )" not in out


LISTING = """
import sys
from tegotae.cli import main, parsed, split_parts
assert main({words}) == 0
heavy = "jax numpy scipy pandas matplotlib rich.progress gymnasium torch evosax".split()
print([name for name in heavy if name in sys.modules])
"""


@pytest.mark.parametrize("words", [["--help"], ["figure", "--help"], ["--version"]])
def test_the_list_of_commands_is_there_at_once(words):
    program = [sys.executable, "-c", LISTING.format(words=words)]
    subprocess.run(program, capture_output=True)  # which keeps the text, the first time
    done = subprocess.run(program, capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.splitlines()[-1] == "[]", "help needs none of these"


def test_of_all_commands_the_one_that_is_named_is_imported():
    program = LISTING.format(words=["models", "--help"])
    program += "print([name for name in sys.modules if name.startswith('tegotae.api.training')])"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert done.stdout.splitlines()[-1] == "[]"


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

    monkeypatch.setattr(Rollout, "run", interrupt)
    monkeypatch.setattr("research.benchmarks.engine.engine_speed", interrupt)
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


@pytest.mark.parametrize(
    ("words", "option"),
    [("train", "--seeds INT"), ("identify", "--rate FLOAT"), ("explain", "--releases INT")],
)
def test_the_help_of_a_command_without_a_name_lists_what_every_name_has(capsys, words, option):
    assert option in explanation(capsys, words)
