"""Claims that have experiments of their own: made-up tables with known effects."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from refusals import refused
from research.reproduction.claims.counting import Count
from research.reproduction.claims.designs import MODELS, correlation_within_omega
from research.reproduction.claims.effects import OfGainMap, OfTrainings
from research.reproduction.claims.experiments import EXPERIMENTS, command_for
from research.reproduction.claims.findings import findings
from research.reproduction.claims.kept import measure_kept
from research.reproduction.table import StudyTable
from study_tables import results
from tegotae.figures.learning_curves import algorithms_tables
from tegotae.figures.style import write_tables
from tegotae.training.curves import COLUMNS


def curves(algorithm: str, late: float, *, points: int = 100, model: str = "m"):
    """Three runs that rise to `late` along a line; an episode is 10 s."""
    episode = np.arange(points, dtype=float)
    rise = np.linspace(0.0, late, points)
    columns = {"algorithm": algorithm, "model": model, "episode": episode}
    columns |= {"simulated_s": 10.0 * episode, "cot_inverse": rise}
    return [pd.DataFrame({**columns, "seed": seed}, columns=COLUMNS) for seed in range(3)]


def of_algorithms(folder: Path, ours: float, theirs: float):
    runs = [*curves("pgpe", ours), *curves("sac", theirs)]
    write_tables(folder / "figure3.png", algorithms_tables(pd.concat(runs)))
    return measure_kept(OfTrainings("figure3.csv", "cot_inverse", "pgpe", "sac"), folder)


def test_algorithms_are_compared_by_what_they_have_late_in_training(tmp_path):
    assert of_algorithms(tmp_path, 1.0, 0.5).effect == pytest.approx(0.5, rel=0.1)
    assert of_algorithms(tmp_path, 0.1, 0.5).effect < 0.0


def test_gaits_are_compared_with_zero_over_the_runs_of_each_policy(tmp_path):
    rows = [("pgpe", "a", 1.0), ("pgpe", "a", 1.2), ("pgpe", "b", 3.0), ("pgpe", "b", 3.2)]
    rows += [("pgpe", "b", np.nan), ("other", "a", -9.0)]
    text = "".join(f"{algorithm},{model},{value}\n" for algorithm, model, value in rows)
    (tmp_path / "gaits.csv").write_text("algorithm,model,nearer_resonance\n" + text)
    estimate = measure_kept(OfTrainings("gaits.csv", "nearer_resonance", "pgpe"), tmp_path)
    assert estimate.effect == pytest.approx(2.1)
    assert 0.0 < estimate.low < 2.1 < estimate.high


def test_a_best_gain_at_the_edge_of_the_map_is_not_fitted(tmp_path):
    omega = np.linspace(2.0, 10.0, 60)
    best = np.minimum(1.3 * omega, 6.0)
    ridge = {
        "actuation": np.repeat(["sector", "reflex"], 60),
        "omega_rad_per_s": np.tile(omega, 2),
        "best_sigma_rad_per_s_n": np.concatenate([best, np.sin(5.0 * omega)]),
        "censored": np.concatenate([best == 6.0, np.zeros(60, bool)]).astype(int),
    }
    write_tables(tmp_path / "gain_map.png", {"ridge": ridge})
    assert measure_kept(OfGainMap("slope", "sector"), tmp_path).effect == pytest.approx(1.3)


def few() -> StudyTable:
    return results({}).where(model=("V-sector-w8", "VG-gF-sector-w8"))


def test_a_folder_that_is_not_there_is_refused_before_anything_is_computed(tmp_path):
    refused("there is no folder", lambda: findings(few(), tmp_path / "nowhere"))


def test_every_experiment_has_a_command_that_measures_it():
    for experiment in EXPERIMENTS:
        for table in experiment.tables:
            assert "here" in command_for(table, Path("here"))


@pytest.mark.parametrize("table", [table for e in EXPERIMENTS for table in e.tables])
@pytest.mark.parametrize("content", ["", "a,b\n1,2\n", "\x00\x01", "actuation,way\nsector\n"])
def test_a_table_that_is_none_is_named_in_one_line(tmp_path, table, content):
    (tmp_path / table).write_text(content)
    refused(table, lambda: findings(few(), tmp_path, resamples=20, options=[Count()]))


@pytest.mark.parametrize("models", [3, MODELS - 1, MODELS])
def test_a_correlation_needs_enough_models(models):
    table = results({"VG": {"cot_inverse": 1.0, "t0_s": 1.0, "t1_s": 1.0}})
    some = table.where(model=tuple(dict.fromkeys(table["model"].tolist()))[:models])
    estimate = correlation_within_omega(some.per_model(), "cot_inverse", "t0_s")
    assert np.isfinite(estimate.mean) == (models >= MODELS)


def test_the_correlation_of_a_line_is_one_and_its_interval_knows_its_sample():
    x = np.arange(20.0)
    omega_t = np.full(20, 8.0)
    line = StudyTable({"a": x, "b": 2.0 * x + 1.0, "omega_t": omega_t})
    assert correlation_within_omega(line, "a", "b").mean == pytest.approx(1.0)
    with_holes = StudyTable({"a": x, "b": np.where(x < 2, np.nan, x), "omega_t": omega_t})
    estimate = correlation_within_omega(with_holes, "a", "b")
    assert (estimate.count, estimate.undefined) == (18, 2)


def test_what_two_frequencies_differ_by_is_no_correlation():
    x, omega_t = np.arange(20.0), np.repeat([4.0, 8.0], 10)
    falls = StudyTable({"a": x + 10.0 * omega_t, "b": 10.0 * omega_t - x, "omega_t": omega_t})
    assert np.corrcoef(falls["a"], falls["b"])[0, 1] > 0.5
    assert correlation_within_omega(falls, "a", "b").mean == pytest.approx(-1.0)
