"""A record keeps the gait of its best run, and the report draws that without a rollout."""

import base64
import dataclasses

import numpy as np
import pytest

from records import made_up
from research.reproduction import best_gait
from research.reproduction.plan import plan
from research.reproduction.record import Record, read_record
from research.reproduction.report.models import pages_of_models
from research.reproduction.table import tabulate
from tegotae import TegotaeError
from tegotae.measures.evaluation import Evaluation, Protocol, evaluate
from tegotae.simulation.rollout import Rollout
from tegotae.systems.recipe import recipe

MODEL = recipe("V-sector-w8")
SETTLES, WANDERS = 1.5, 3.0
"""Gains of the model: with the one it settles within seconds, with the other it does not."""


@pytest.fixture(scope="module")
def evaluation() -> Evaluation:
    """Evaluate both gains, at 1 rad/s below the training frequency and at it."""
    protocol = Protocol(undisturbed_s=12.0, disturbed_s=12.0, offsets=(-1.0, 0.0))
    inputs = MODEL.controller(), [[WANDERS], [SETTLES]], 8.0
    metrics = ("limit_cycle_period", "hop_rate")
    return evaluate(*inputs, protocol=protocol, metrics=metrics, recorded=best_gait.CHANNELS)


def record_of(evaluation: Evaluation, *fitness: float) -> Record:
    """A record with this evaluation, and otherwise made up."""
    unit = plan("smoke", MODEL.name).units[0]
    run = dataclasses.replace(unit.run, experiment=MODEL.experiment(protocol=evaluation.protocol))
    record = made_up(dataclasses.replace(unit, run=run))
    best = np.array(fitness, "float32")
    episodes = {name: values.astype("float32") for name, values in evaluation.episodes.items()}
    return dataclasses.replace(
        record,
        weights=np.array([[WANDERS], [SETTLES]], "float32"),
        best_fitness=best,
        omega=evaluation.omega,
        episodes=record.episodes | episodes,
        gait=best_gait.gait_channels(evaluation, best, 8.0),
    )


def test_it_is_that_of_the_best_run_at_the_training_frequency(evaluation):
    gait = record_of(evaluation, 0.1, 0.2).gait
    np.testing.assert_array_equal(gait["height_m"], evaluation.recording["height_m"][-400:, 1, 1])
    assert gait["time_s"][-1] == pytest.approx(12.0)


def test_the_cycles_laid_over_each_other_show_one_finely(evaluation):
    orbit = best_gait.recorded_orbit(record_of(evaluation, 0.1, 0.2))
    assert orbit is not None
    assert orbit.hops == 1
    assert orbit.period_s == pytest.approx(2 * np.pi / evaluation.episodes["hop_rate"][1, 1], 1e-2)
    frame_s = 0.02
    assert len(orbit.time_s) > 3.5 * orbit.period_s / frame_s
    assert 0.0 <= np.diff(orbit.time_s).min() <= np.diff(orbit.time_s).max() <= frame_s
    assert (orbit.spring_force_n > 0).tolist() == (orbit.height_m < 1.0).tolist()
    flies = orbit.height_m > 1.0
    fall_m = orbit.apex_height_m[0] - orbit.velocity_m_per_s[flies] ** 2 / (2 * 9.81)
    np.testing.assert_allclose(orbit.height_m[flies], fall_m, atol=0.01)


def test_a_gait_that_wanders_has_none(evaluation):
    assert best_gait.recorded_orbit(record_of(evaluation, 0.2, 0.1)) is None


def test_without_an_episode_at_the_training_frequency_none_is_kept(evaluation):
    assert best_gait.gait_channels(evaluation, np.array([0.1, 0.2]), 6.0) == {}


def test_it_is_in_the_file(evaluation, tmp_path):
    record = record_of(evaluation, 0.1, 0.2)
    record.result.write(tmp_path / "a.npz")
    np.testing.assert_equal(read_record(tmp_path / "a.npz").gait, record.gait)


class RolledOutError(Exception):
    """A rollout where there should be none."""


@pytest.fixture
def no_rollouts(monkeypatch):
    def refuse(*arguments, **options):
        raise RolledOutError

    monkeypatch.setattr(Rollout, "run", refuse)


def test_the_report_rolls_nothing_out(evaluation, no_rollouts):
    record = record_of(evaluation, 0.1, 0.2)
    page = pages_of_models([record], tabulate([record]), ("best_fitness",))[MODEL.name]
    assert page["run"] == 1
    assert page["metrics"] == [[0.1, 0.2]]
    assert page["has_cycle"]
    assert (page["hop"]["per_s"], page["hop"]["from_s"]) == (50, 4.0)
    height, phase = (unpacked(page["hop"]["channels"][name]) for name in ("height", "phase"))
    assert height == pytest.approx(record.gait["height_m"], abs=1e-3)
    assert len(phase) == 400
    assert phase.min() >= 0.0
    assert phase.max() <= 6.29


def unpacked(packed: dict) -> np.ndarray:
    """The numbers of a channel as the page reads them."""
    steps = np.frombuffer(base64.b64decode(packed["at"]), f"<u{packed['bits'] // 8}")
    return packed["low"] + (packed["high"] - packed["low"]) * steps / (2 ** packed["bits"] - 1)


def test_of_a_record_without_a_gait_it_is_rolled_out(evaluation, tmp_path, no_rollouts):
    dataclasses.replace(record_of(evaluation, 0.1, 0.2), gait={}).result.write(tmp_path / "a.npz")
    record = read_record(tmp_path / "a.npz")
    assert record.gait == {}
    with pytest.raises(RolledOutError):
        pages_of_models([record], tabulate([record]), ())


def test_a_channel_that_nobody_records_is_refused():
    with pytest.raises(TegotaeError, match="channel"):
        evaluate(MODEL.controller(), [1.0], 8.0, metrics=["hop_rate"], recorded=["colour"])
