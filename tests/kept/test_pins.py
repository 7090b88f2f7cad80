"""Results are the same bits as before; `pins` says which, where, and how they are renewed."""

import json
import subprocess
import sys

import numpy as np
import pytest

from pins import KEPT, hash_of, unequal
from places import ROOT, TESTS

PROGRAM = TESTS / "helpers" / "pins.py"


@pytest.fixture(scope="module")
def pin_lines() -> dict[str, str]:
    """Return the program's line on each pin. It sets flags of XLA, so it is a process of its
    own."""
    outcome = subprocess.run(
        [sys.executable, str(PROGRAM)], cwd=ROOT, capture_output=True, text=True, timeout=900
    )
    assert outcome.returncode in (0, 1), outcome.stderr
    return dict(line.split(": ", 1) for line in outcome.stdout.splitlines())


@pytest.mark.thorough
@pytest.mark.parametrize("pin", json.loads(KEPT.read_text())["pins"])
def test_results_are_the_same_bits_as_before(pin_lines, pin):
    if "not compared" in pin_lines[pin]:
        pytest.skip(pin_lines[pin])
    assert pin_lines[pin].endswith("equal to the bit"), pin_lines[pin]


THREE = np.array([1.0, -0.0, np.nan])


@pytest.mark.parametrize(
    "changed",
    [
        pytest.param(np.array([np.nextafter(1.0, 2.0), -0.0, np.nan]), id="the last bit"),
        pytest.param(np.array([1.0, 0.0, np.nan]), id="the sign of zero"),
        pytest.param(THREE.astype(np.float32), id="the type"),
        pytest.param(THREE[None], id="the shape"),
        pytest.param(THREE[::-1], id="the order"),
        pytest.param("1.0 -0.0 nan", id="a text"),
    ],
)
def test_a_hash_sees(changed):
    assert hash_of(changed) != hash_of(THREE)
    assert hash_of(THREE.copy()) == hash_of(THREE)


def test_texts_of_other_widths_have_the_same_hash():
    gaits = np.array(["trot", "pace"])
    assert hash_of(gaits.astype("U20")) == hash_of(gaits.astype(object)) == hash_of(gaits)


def test_a_new_result_is_no_difference_and_one_that_is_gone_is_one():
    stored = {"speed": "1", "cost": "2", "lag": "3"}
    assert unequal(stored, {"speed": "1", "cost": "0", "power": "4"}) == ["cost", "lag"]
    assert unequal(stored, stored | {"power": "4"}) == []
