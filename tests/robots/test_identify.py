"""From a log to a controller: the body behind a recording, and what a recording must hold."""

from __future__ import annotations

import importlib.util

import numpy as np
import pandas as pd
import pytest

import tegotae as tg
from places import ROOT
from tegotae import TegotaeError
from tegotae.cli import main

TRUTH = {
    "mass_kg": 1.7,
    "stiffness_n_per_m": 310.0,
    "damping_ns_per_m": 5.5,
    "rest_length_m": 0.42,
    "max_force_n": 62.0,
}


def device(**numbers):
    """A leg of plain Python, which is no part of the package."""
    spec = importlib.util.spec_from_file_location("hidden_leg", ROOT / "studies" / "hidden_leg.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module.HiddenLeg(**numbers), module.TICK_S


@pytest.fixture(scope="module")
def log(tmp_path_factory):
    file = tmp_path_factory.mktemp("log") / "log.csv"
    device()[0].log(file, 60.0)
    return file


@pytest.fixture(scope="module")
def identified(log):
    return tg.identify(str(log))


def test_the_numbers_of_a_leg_are_found_within_five_percent_from_three_percent_noise(identified):
    found = identified.raw
    assert {n: found.values[n] for n in TRUTH} == pytest.approx(TRUTH, rel=0.05)
    for name, value in found.values.items():
        assert found.low[name] < value < found.high[name]
    assert found.noise[0] == pytest.approx(0.03 * 0.42, rel=0.1)
    assert found.noise[1] == pytest.approx(0.03 * 1.7 * 9.81, rel=0.1)


def test_hops_that_were_not_fitted_are_predicted_to_the_noise(identified):
    errors = identified.raw.prediction.set_index("hops ahead")
    assert (errors.loc[1] < 1.3).all()
    assert (errors < 3.0).all(axis=None)


def test_a_body_from_a_log_is_trained_for_exported_and_driven(identified, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    identified.save("leg.toml")
    words = "--body leg.toml --height 0.5 --hold --generations 2 --population 8 --seeds 1"
    words += " --duration 4 --settle 2 --budget 20 --out runs"
    assert main(["train", "AR-rF-reflex-w14", *words.split()]) == 0
    (file,) = (tmp_path / "runs").glob("*-seed0.json")
    assert main(["export", "c", str(file), "--out", "c"]) == 0
    assert (tmp_path / "c" / "tegotae.c").exists()
    live = tg.export_native(str(file)).live()
    leg, tick_s = device()
    limit = identified.raw.values["max_force_n"]
    heights = []
    for _ in range(400):
        height, load = leg.sense()
        force = float(live.step({"spring_force": max(load, 0.0)}, tick_s)[0])
        assert 0.0 <= force <= limit
        leg.push(force / limit)
        heights.append(height)
    assert min(heights) > 0.0


def changed(**columns):
    """A hop a second for a minute, and what is wrong with it."""
    time_s = np.arange(12000) * 0.005
    wave = np.sin(2.0 * np.pi * time_s)
    good = {
        "time_s": time_s,
        "height_m": 0.4 + 0.1 * wave,
        "spring_force_n": 40.0 * np.maximum(-wave, 0.0),
        "command_share": (wave < -0.5) * 0.5,
    }
    return pd.DataFrame(good | columns)


TIME = np.arange(12000) * 0.005
NAN = np.where(np.arange(12000) == 7, np.nan, 0.4)


@pytest.mark.parametrize(
    ("samples", "message"),
    [
        (changed().head(400), "too short: it holds 0 whole hops"),
        (changed(spring_force_n=np.zeros(12000)), "no stance"),
        (changed(spring_force_n=np.full(12000, 16.0)), "no flight"),
        (changed(command_share=np.full(12000, 0.3)), "the command is constant at 0.3"),
        (changed(command_share=np.linspace(0.0, 100.0, 12000)), "a share of the actuator's"),
        (changed(time_s=TIME + 0.003 * (np.arange(12000) % 2)), "the time steps are uneven"),
        (changed(height_m=NAN), "height_m is nan at sample 7"),
        (changed().drop(columns="command_share"), "no column is the command"),
        (changed(spring_force_n=-40.0 * np.minimum(np.sin(7 * TIME), 0.0)), "not that of such a"),
    ],
)
def test_what_a_recording_lacks_is_said_in_one_line_and_nothing_written(
    samples, message, tmp_path, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    samples.to_csv("log.csv", index=False)
    with pytest.raises(TegotaeError, match=message) as refused:
        tg.identify("log.csv")
    assert "\n" not in str(refused.value)
    assert [path.name for path in tmp_path.iterdir()] == ["log.csv"]


def test_a_body_is_not_written_over(identified, tmp_path):
    (tmp_path / "leg.toml").write_text("mine")
    with pytest.raises(TegotaeError, match="exists already"):
        identified.save(tmp_path / "leg.toml")
    with pytest.raises(TegotaeError, match=r"must end in \.toml"):
        tg.identify("log.csv", out=tmp_path / "leg.csv")
