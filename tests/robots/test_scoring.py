"""Entries that are code of their authors run apart, and end; a manifest describes its program."""

import json
import shutil

import numpy as np
import pytest

from brief_subjects import BriefHopper
from compiled import needs_gcc
from places import ROOT
from refusals import refused
from tegotae_robots.benchmark import scoring
from tegotae_robots.benchmark.bodies import HopperSubject
from tegotae_robots.benchmark.entries import read_entry
from tegotae_robots.benchmark.scoring import scored

ARG = ROOT / "research" / "benchmarks" / "entries" / "hopper" / "arg.c"


@pytest.fixture
def program(tmp_path):
    """A function that copies the program, with C at the beginning of each step, or a manifest."""

    def copied(statement="", **manifest):
        for ending in (".c", ".h", ".json"):
            shutil.copy(ARG.with_suffix(ending), tmp_path)
        file = tmp_path / "arg.c"
        previous, head, step = file.read_text().partition("void arg_step(")
        head, brace, body = (head + step).partition("{")
        file.write_text(f"#include <stdlib.h>\n{previous}{head}{brace}{statement}{body}")
        subject = json.loads(ARG.with_suffix(".json").read_text())
        file.with_suffix(".json").write_text(json.dumps(subject | manifest))
        return file

    return copied


@needs_gcc
def test_an_entry_scores_the_same_in_a_process_of_its_own_as_here():
    subject = BriefHopper()
    difference, spent_s = scored(ARG, subject, "load")
    np.testing.assert_array_equal(
        difference, subject.scores(read_entry(ARG, subject, "load"), "load")
    )
    assert spent_s > 0.0


@needs_gcc
def test_an_entry_that_ends_its_process_does_not_end_the_benchmark(program):
    refused("ended its process", lambda: scored(program("exit(0);"), BriefHopper(), "load"))


@needs_gcc
@pytest.mark.parametrize("place", ["arg.c", "slow.py:sleeps"])
def test_an_entry_that_never_ends_is_ended(program, tmp_path, monkeypatch, place):
    monkeypatch.setattr(scoring, "MOST_WALL_S", 1.0)
    program("for (;;) {}")
    (tmp_path / "slow.py").write_text(
        "import time\n\ndef sleeps(observed):\n    time.sleep(1e6)\n    return [0.0]\n"
    )
    refused("took more than 1 s", lambda: scored(f"{tmp_path}/{place}", BriefHopper(), "load"))


SENSES = {"senses": {"spring_force": "spring_force"}, "drives": "force", "rest": 0.0, "push": 1.0}
LEG = {"foot": "a", "joints": ["b"]}


@needs_gcc
@pytest.mark.parametrize(
    ("manifest", "said"),
    [
        ({"tick_s": float("nan")}, "tick_s is nan; it must be a number > 0"),
        ({"tick_s": "x"}, "tick_s is 'x'"),
        ({"tick_s": 0}, "tick_s is 0"),
        ({"limbs": 10**7}, "limbs is 10000000; it must be a whole number <= 32"),
        ({"limbs": None}, "limbs is None"),
        ({"limbs": 2}, "does not command force"),
        ({"inputs": []}, "describes another program"),
        ({"inputs": [{}]}, "no entry 'inputs.0..name'"),
        ({"inputs": None}, "inputs is None"),
        ({"inputs": [{"name": "spring_force_n; int y"}]}, "inputs.0..name is"),
        ({"inputs": [{"name": "spring_force_n"}] * 2}, "names an input or an output twice"),
        ({"outputs": []}, "has no commands"),
        ({"outputs": [{"name": "force_n"}]}, "describes another program"),
        ({"outputs": [{"name": "phase_rad"}, {"name": "force_n"}]}, "or others before them"),
        ({"outputs": 3}, "outputs is 3"),
        ({"state": []}, "describes another program"),
        ({"state": ["speed"]}, "describes another program"),
        ({"state": [1]}, "state.0. is 1"),
        ({"constants": [1]}, "constants is"),
        ({"wired": [1]}, "wired.0. is 1"),
        ({"wired": [SENSES] * 2}, "wires 2 limbs, and has 1"),
        ({"wired": [{**SENSES, "senses": {}}]}, "does not say what spring_force_n of limb 0 is"),
        ({"wired": [{**SENSES, "drives": ["force"] * 2}]}, "by 1 commands in limb 0"),
        ({"wired": [{**SENSES, "rest": None}]}, "does not say where limb 0 rests"),
        ({"wired": [SENSES], "constants": {}}, "has no max_force_n above 0"),
        ({"legs": [LEG]}, "has legs without a wiring"),
        ({"legs": [{}]}, "no entry 'legs.0..foot'"),
        ({"prefix": 1}, "prefix is 1"),
        ({"prefix": "exit"}, "has the prefix 'exit'"),
        ({"prefix": "leg"}, "describes another program"),
    ],
)
def test_a_manifest_that_does_not_describe_its_program_is_refused_in_a_line(
    program, manifest, said
):
    refused(said, lambda: read_entry(program(**manifest), HopperSubject(), "load"))
