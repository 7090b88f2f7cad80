"""A certificate is accepted by a checker of its own, which refuses what is not proved."""

import copy
import hashlib
import json
import subprocess
import sys
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

import tegotae as tg
from research.certificate import check as checker
from tegotae.parts.fields import replace
from tegotae.simulation.integrators import Hold
from tegotae.simulation.rollout import Timing

HERE = Path(checker.__file__).parent
LATCH = tg.load(HERE / "latch.json")
COARSE = {"least_m_per_s": 4.6, "most_m_per_s": 6.4, "speeds": 18, "phases": 60}


@pytest.fixture(scope="module")
def certificate():
    """Return a certificate of the latch on few cells, as its file has it."""
    return json.loads(json.dumps(LATCH.certify(**COARSE).to_dict()))


@pytest.fixture(scope="module")
def small(certificate):
    """Return its cells of the ranks 0 and 1 alone, which are quick to check."""
    ranks = np.array(certificate["ranks"])
    return certificate | {"ranks": np.where(ranks <= 1, ranks, -1).tolist()}


def test_the_checker_accepts_a_certificate_and_proves_at_least_its_claims(certificate):
    proved = checker.check(certificate)
    assert proved["cells"] == (np.array(certificate["ranks"]) >= 0).sum() > 500
    assert proved["cot_inverse_m_per_j"][0] >= certificate["claims"]["cot_inverse_m_per_j"] > 1.0


def test_a_larger_error_than_the_certificate_allows_is_refused(small):
    errors = small["errors"] | {"load": 0.2}
    with pytest.raises(checker.RefusedError):
        checker.check(small | {"errors": errors})


def test_the_checker_refuses_altered_weights(small):
    altered = copy.deepcopy(small)
    altered["law"]["weights"][0] += 1e-17
    with pytest.raises(checker.RefusedError, match="hash"):
        checker.check(altered)
    altered["law"]["weights"][3] += 0.5
    altered["sha256"] = hashlib.sha256(np.array(altered["law"]["weights"]).tobytes()).hexdigest()
    with pytest.raises(checker.RefusedError, match=r"lift-off|meets cells|leaves"):
        checker.check(altered)
    with pytest.raises(checker.RefusedError, match="those of the controller"):
        checker.check(small, {"weights": {"action": {"offset": 0.1}}})


def test_the_checker_refuses_a_set_without_one_of_the_cells_that_its_orbits_reach(small):
    ranks = np.array(small["ranks"])
    rows, columns = np.nonzero(ranks == 0)
    ranks[rows[len(rows) // 2], columns[len(rows) // 2]] = -1
    with pytest.raises(checker.RefusedError, match="meets cells of ranks -1"):
        checker.check(small | {"ranks": ranks.tolist()})


def test_the_checker_refuses_a_set_outside_of_the_basin(small):
    ranks = np.array(small["ranks"])
    moved = np.roll(ranks, ranks.shape[1] // 2, axis=1)
    with pytest.raises(checker.RefusedError):
        checker.check(small | {"ranks": moved.tolist()})


def test_the_checker_refuses_a_rank_that_is_too_low(certificate):
    ranks = np.array(certificate["ranks"])
    ranks[ranks == ranks.max()] = 1
    with pytest.raises(checker.RefusedError, match="of rank 1 meets"):
        checker.check(certificate | {"ranks": ranks.tolist()})


@pytest.mark.parametrize(
    ("claim", "value"),
    [
        ("apex_m", [2.6, 2.7]),
        ("least_height_m", 0.9),
        ("cot_inverse_m_per_j", 2.0),
        ("cot_inverse_m_per_j", float("nan")),
        ("speed", 1),
    ],
)
def test_the_checker_refuses_a_claim_that_it_does_not_prove(small, claim, value):
    with pytest.raises(checker.RefusedError, match=f"the claim {claim}"):
        checker.check(small | {"claims": {claim: value}})


@pytest.mark.parametrize(
    ("part", "name", "value"),
    [("errors", "load", -1.0), ("body", "mass_kg", float("inf")), ("body", "mass_kg", -0.1)],
)
def test_the_checker_refuses_numbers_that_prove_nothing(small, part, name, value):
    with pytest.raises(checker.RefusedError, match=r"out of range|not finite"):
        checker.check(small | {part: small[part] | {name: value}})


@pytest.fixture(scope="module")
def family():
    """Return a core for bodies with a mass and a stiffness within 0.5 %."""
    errors = {"stiffness_error": 0.005, "mass_error": 0.005, "splits": 2}
    family = json.loads(json.dumps(LATCH.certify(**COARSE, **errors).to_dict()))
    ranks = np.array(family["ranks"])
    return family | {"ranks": np.where(ranks == 0, 0, -1).tolist()}


def test_a_certificate_of_many_bodies_covers_the_ends_of_their_ranges(family):
    proved = checker.check(family)
    assert proved["cells"] == proved["core"] > 0
    members = list(checker.bodies(family["body"], family["errors"], family["splits"]))
    for name, entry in (("mass", "mass_kg"), ("stiffness", "stiffness_n_per_m")):
        nominal = family["body"][entry]
        for sign in (-1.0, 1.0):
            end = nominal * (1.0 + sign * family["errors"][name])
            distances = [abs(end - body[entry]) - body[entry] * e[name] for body, e in members]
            assert min(distances) <= 0.0


@pytest.mark.parametrize(
    ("part", "value"), [("stiffness", 0.03), ("mass", 0.03), ("mass", 0.5), ("splits", 0)]
)
def test_the_checker_refuses_more_bodies_than_were_certified(family, part, value):
    wider = {"errors": family["errors"] | {part: value}} if part != "splits" else {part: value}
    with pytest.raises(checker.RefusedError):
        checker.check(family | wider)


@pytest.mark.parametrize(("mass", "stiffness"), [(1.0, 1.0), (0.995, 1.005), (1.005, 0.995)])
def test_the_simulation_lands_where_the_checker_says(small, mass, stiffness):
    saved, body = LATCH.saved, small["body"]
    error = 0.0 if mass == 1.0 else 0.005 + 1e-9
    errors = small["errors"] | {"mass": error, "stiffness": error}
    tick_s, grid, ranks = 1e-3, small["grid"], np.array(small["ranks"])
    rows, columns = np.nonzero(ranks >= 0)
    speeds = np.linspace(grid["least_m_per_s"], grid["most_m_per_s"], grid["speeds"] + 1)
    phases = np.linspace(0.0, 2.0 * np.pi, grid["phases"] + 1)
    draw = np.random.default_rng(0).random((3, len(rows)))
    speed = speeds[rows] + draw[0] * (speeds[rows + 1] - speeds[rows])
    phase = phases[columns] + draw[1] * (phases[columns + 1] - phases[columns])
    timing = Timing(duration_s=2.0, tick_s=tick_s, frame_s=tick_s)
    changed = {
        "body.mass_kg": body["mass_kg"] * mass,
        "body.stiffness_n_per_m": body["stiffness_n_per_m"] * stiffness,
    }
    system = replace(saved.system, {"integrator": Hold(), "timing": timing, **changed})
    # The certified controller divides the load by the nominal weight, the simulation by its own.
    weights = np.array(saved.weights, float)
    weights[saved.system.controller.layout["reaction"]] *= mass
    height = 1.0 - draw[2] * speed * tick_s
    start = system.scenario(height_m=height, velocity_m_per_s=-speed, phase_rad=phase)
    y = system.run(weights, start, dtype="float64")
    cells = (speeds[rows], speeds[rows + 1]), (phases[columns], phases[columns + 1])
    law = checker.Law(small["law"], body)
    low_speed, high_speed, first, last, *_ = checker.hop(law, body, errors, *cells)
    for lane in range(len(rows)):
        off = np.flatnonzero(y.height_m[:, lane] >= 1.0)[0]
        lands = off + np.flatnonzero(y.height_m[off:, lane] < 1.0)[0]
        assert low_speed[lane] <= -y.velocity_m_per_s[lands, lane] <= high_speed[lane]
        beyond = (y.phase_rad[lands, lane] - first[lane]) % (2.0 * np.pi)
        assert beyond <= last[lane] - first[lane]


def test_balls_contain_exact_values():
    draw = np.random.default_rng(1).uniform(-3.0, 3.0, (2, 100))
    a, b = checker.Ball(draw[0], 1e-3), checker.Ball(draw[1], 1e-2)
    for sign in (-1.0, 1.0):
        x, y = draw[0] + sign * 1e-3, draw[1] - sign * 1e-2
        for value, ball in ((x + y, a + b), (x * y, a * b), (np.cos(x), checker.cosine(a))):
            assert (ball.lo <= value).all()
            assert (value <= ball.hi).all()
    assert checker.cosine(checker.Ball(0.0, 0.1)).hi >= 1.0
    assert checker.cosine(checker.Ball(np.pi, 0.1)).lo <= -1.0


def test_functions_of_numpy_are_as_exact_as_the_checker_assumes():
    x = np.random.default_rng(2).uniform(-8.0, 8.0, 64)

    def exponential(value: Fraction) -> Fraction:
        term = result = Fraction(1)
        for n in range(1, 80):
            term = Fraction(int(term * value / n * 2**120), 2**120)
            result += term
        return result

    for i, value in enumerate(map(Fraction, x)):
        turn, sine, cosine = Fraction(1), Fraction(0), Fraction(0)
        for n in range(80):
            part = turn if n % 4 < 2 else -turn
            cosine, sine = (cosine + part, sine) if n % 2 == 0 else (cosine, sine + part)
            turn = Fraction(int(turn * value / (n + 1) * 2**120), 2**120)
        square = exponential(2 * value)
        exact = {np.cos: cosine, np.sin: sine, np.tanh: (square - 1) / (square + 1)}
        for function, value_of in exact.items():
            assert abs(Fraction(float(function(x)[i])) - value_of) < Fraction(checker.LIBM)
        decay = np.exp(-np.abs(x))[i]
        assert abs(Fraction(float(decay)) - exponential(-abs(value))) < Fraction(checker.LIBM)


def test_the_command_writes_a_file_that_the_checker_reads(tmp_path):
    path = tmp_path / "certificate.json"
    LATCH.certify(**COARSE).save(path)
    command = [sys.executable, *map(str, (HERE / "check.py", path, HERE / "latch.json"))]
    completed = subprocess.run(command, capture_output=True, text=True, timeout=300, check=False)
    assert completed.stdout.splitlines()[-1:] == ["accepted"], completed.stderr


@pytest.mark.parametrize(
    ("spoil", "reason"),
    [
        (lambda text: text[:3000], "no whole certificate"),
        (lambda text: "[]", "no whole certificate"),
        (lambda text: text.replace('"grid"', '"net"'), "no whole certificate"),
        (lambda text: text.replace('"omega_rad_per_s":4', '"omega_rad_per_s":NaN'), "not a fin"),
        (lambda text: text.replace('"most_m_per_s":6.5', '"most_m_per_s":1e999'), "not a finite"),
    ],
)
def test_a_file_that_is_no_whole_certificate_is_refused_in_a_line(tmp_path, spoil, reason):
    path = tmp_path / "spoilt.json"
    text = (HERE / "latch-certificate.json").read_text("utf-8")
    path.write_text(spoil(text))
    assert path.read_text() != text
    command = [sys.executable, str(HERE / "check.py"), str(path)]
    completed = subprocess.run(command, capture_output=True, text=True, timeout=300, check=False)
    (line,) = completed.stderr.splitlines()
    assert line.startswith("refused: ")
    assert reason in line
    assert completed.returncode == 1


def test_the_checker_bounds_the_networks_of_a_trained_controller():
    kept = json.loads((HERE / "ART-rF-tphi-w4-certificate.json").read_text("utf-8"))
    ranks = np.array(kept["ranks"])
    core = kept | {"ranks": np.where(ranks == 0, 0, -1).tolist()}
    weights = tg.load("zoo:ART-rF-tphi-w4/4").saved.weights
    assert kept["law"]["weights"] == weights.tolist()
    assert checker.check(core)["cells"] == (ranks == 0).sum() > 0


def test_a_law_without_bounds_is_refused_in_a_line():
    with pytest.raises(tg.TegotaeError, match="certify has no bounds of Network, the gain"):
        tg.load("zoo:ARG-rF-gF-sector-w8").certify()
    with pytest.raises(tg.TegotaeError, match="no cell of V-reflex-w8 stays in a set"):
        tg.load("V-reflex-w8").certify(speeds=4, phases=4)
