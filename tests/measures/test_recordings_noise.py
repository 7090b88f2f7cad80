"""Recordings with noise are measured rightly, or it is said what cannot be told."""

import csv
import importlib.util
import json
import sys

import numpy as np
import pandas
import pytest

from places import ROOT
from synthetic import Hopping, seconds
from tegotae import TegotaeError
from tegotae.cli import main
from tegotae.measures.hopping import LimitCycle, measure
from tegotae.measures.hopping.recording import cleaned, denoised, noise_std, work_under_noise

GUIDES = ROOT / "docs" / "guides"
TIME = seconds(20.0, 0.01)
HEIGHT = 1.0 + 0.3 * np.sin(6.0 * TIME)
FORCE = 2.0 * (1.0 + np.cos(6.0 * TIME))


def white(level):
    return level * np.random.default_rng(0).standard_normal(len(TIME))


@pytest.fixture(scope="module")
def script():
    spec = importlib.util.spec_from_file_location("noisy", GUIDES / "noisy_recordings.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def hopper(script):
    """A simulated hopper, and what it measures without noise."""
    walk = script.recorded(*script.GAITS["reflex, 8 rad/s"])
    return walk, script.measured(walk)


@pytest.mark.parametrize("level", [0.01, 0.05])
@pytest.mark.parametrize("seed", [0, pytest.param(1, marks=pytest.mark.thorough)])
def test_up_to_five_per_cent_of_noise_changes_no_number_by_more(script, hopper, level, seed):
    walk, right = hopper
    noise = script.noisy(walk, level, seed)
    result = script.measured(noise)
    assert result.regime == right.regime
    assert result.limit_cycle_period == right.limit_cycle_period
    for name, error in script.errors(result, right).items():
        assert abs(error) < 0.05, name
    raw = script.errors(script.measured(noise, lowpass_hz=np.inf), right)
    assert abs(raw["apex"]) > 0.005


@pytest.mark.parametrize("cutoff_hz", [4.0, 6.0])
def test_a_cutoff_that_fits_does_as_well(script, hopper, cutoff_hz):
    walk, right = hopper
    result = script.measured(script.noisy(walk, 0.03, 2), lowpass_hz=cutoff_hz)
    assert f"low-passed at {cutoff_hz:g} Hz" in " ".join(result.notes)
    for name, error in script.errors(result, right).items():
        assert abs(error) < 0.05, name


def test_the_kept_table_says_five_per_cent_up_to_five_per_cent_of_noise():
    with (GUIDES.parent / "_static" / "guides" / "noise.csv").open(encoding="utf-8") as file:
        rows = [row for row in csv.DictReader(file) if float(row["noise %"]) <= 5.0]
    assert len(rows) == 10
    for row in rows:
        assert float(row["CoT⁻¹, noisy force"].split()[0]) <= 3.0
        for column in ("CoT⁻¹", "apex heights", "hops", "period"):
            largest = float(row[column].partition("(")[2].rstrip(")"))
            assert largest <= 5.0, (row["gait"], column)


@pytest.mark.parametrize("level", [0.001, 0.01, 0.1])
def test_the_noise_is_told_apart_from_a_smooth_gait(level):
    assert noise_std(HEIGHT) < 1e-6
    assert noise_std(HEIGHT + white(level)) == pytest.approx(level, rel=0.1)
    hopping = Hopping(np.full(16, 1.3)).height_m(TIME)
    assert noise_std(hopping) < 1e-5
    assert noise_std(hopping + white(level)) == pytest.approx(level, rel=0.1)


def test_a_recording_without_noise_is_left_as_it_is():
    columns = {"time_s": TIME, "height_m": HEIGHT, "force_n": FORCE, "phase_rad": 6.0 * TIME}
    result = denoised(columns, rest_length_m=1.0, limit_cycle=LimitCycle(), work="absolute")
    for name, column in columns.items():
        np.testing.assert_array_equal(result.samples[name], column)
    assert result.notes == ()
    assert result.prominence_m == 0.0
    assert result.limit_cycle == LimitCycle()


def test_the_low_pass_shifts_no_phase():
    clean = cleaned(HEIGHT + white(0.03), 0.01, floor=1e-4)
    lags = np.arange(-10, 11)
    inside = slice(50, -50)
    products = [np.dot(np.roll(clean.samples, lag)[inside] - 1, HEIGHT[inside] - 1) for lag in lags]
    assert lags[np.argmax(products)] == 0
    assert np.std(clean.samples - HEIGHT) < 0.01


def test_a_force_of_short_bursts_does_all_its_work_in_spite_of_noise_on_the_height():
    push = np.where(np.arange(len(TIME)) % 105 < 3, 4.0, 0.0)
    up = np.sign(np.diff(HEIGHT))
    right = np.abs(0.5 * (push[1:] + push[:-1]) * np.diff(HEIGHT)).sum()
    assert work_under_noise(push, HEIGHT, up, 0.01, "absolute")[-1] == pytest.approx(right)


def test_noise_of_a_force_is_no_work():
    """A motor that is off half of the time: |F Δy| would count its noise there."""
    push = np.where(np.cos(6.0 * TIME) > 0.0, 2.0, 0.0)
    up = np.sign(np.diff(HEIGHT))
    for definition, right in (("absolute", 1.0), ("positive", 1.0), ("net", 1.0)):
        work = work_under_noise(push + white(0.2), HEIGHT, up, 0.01, definition)[-1]
        assert work == pytest.approx(right * work_under_noise(push, HEIGHT, up, 0.01, "net")[-1],
                                     rel=0.02)  # fmt: skip
    absolute = work_under_noise(-push + white(0.2), HEIGHT, up, 0.01, "absolute")[-1]
    assert absolute == pytest.approx(work_under_noise(push, HEIGHT, up, 0.01, "net")[-1], rel=0.02)


def test_what_noise_hides_is_said(tmp_path, capsys):
    path = tmp_path / "walk.csv"
    table = {"time_s": TIME, "height_m": HEIGHT + white(0.02), "force_n": FORCE + white(0.1)}
    pandas.DataFrame(table).to_csv(path, index=False)
    assert main(["measure", str(path), "--rest-length-m", "1", "--json"]) == 0
    height, force, repeat = json.loads(capsys.readouterr().out)["notes"]
    assert "the height holds noise of about 19 mm" in height
    assert "low-passed at" in height
    assert "the force holds noise of about 0.096 N" in force
    assert "hops that differ by less than 30 mm count as alike" in repeat
    assert main(["measure", str(path), "--rest-length-m", "1", "--lowpass", "5"]) == 0
    assert "low-passed at 5 Hz" in capsys.readouterr().out


def test_hops_climb_and_spectrum_that_contradict_each_other_are_said_to():
    noise = HEIGHT + white(0.05)
    assert not any("contradict" in note for note in measure(TIME, noise, rest_length_m=1.0).notes)
    raw = measure(TIME, noise, rest_length_m=1.0, lowpass_hz=np.inf).notes
    assert any("hops and climb contradict each other" in note for note in raw)
    # Every other swing stays below what counts as a hop.
    low = 0.93 + 0.1 * np.sin(6.0 * TIME) + 0.05 * np.sin(3.0 * TIME)
    bounces = measure(TIME, low, rest_length_m=1.0).notes
    assert any("hops and spectrum contradict each other" in note for note in bounces)


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        ("0", "lowpass is 0; it must be greater than 0"),
        ("50", "lowpass is 50 Hz; it must be below half of the sampling rate, 50 Hz"),
        ("nan", "lowpass is nan"),
    ],
)
def test_a_cutoff_that_cannot_be_used_is_refused(tmp_path, one_line_error, arguments, says):
    path = tmp_path / "walk.csv"
    pandas.DataFrame({"time_s": TIME, "height_m": HEIGHT}).to_csv(path, index=False)
    assert says in one_line_error(
        "measure", str(path), "--rest-length-m", "1", "--lowpass", arguments
    )


def test_too_few_samples_for_a_low_pass_are_refused():
    with pytest.raises(TegotaeError, match="lowpass takes at least 50 samples"):
        measure(TIME[:30], HEIGHT[:30], rest_length_m=1.0, lowpass_hz=5.0)
