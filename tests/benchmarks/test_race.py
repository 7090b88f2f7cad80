"""The race: rivals have the same rollouts, and a table says what each needs to the same fitness."""

import numpy as np
import pandas as pd
import pytest

from research.benchmarks import race, rivals
from tegotae.parts.fields import replace
from tegotae.training.learner import initial_weights


def runs(program: str, core_s: list[float], fitness: list[float], seed: int = 0) -> pd.DataFrame:
    table = pd.DataFrame({"core_s": core_s, "fitness": fitness, "cot_inverse": fitness})
    return table.assign(program=program, seed=seed, step=np.arange(len(table)))


def test_the_textbook_program_has_the_fitness_of_the_package():
    trained = replace(
        rivals.experiment(), {"system.timing.duration_s": 4.0, "objective.settle_s": 1.0}
    )
    weights = np.stack([initial_weights(trained.controller, seed) for seed in range(6)])
    with trained.evaluator() as evaluator:
        ours = evaluator.alike(weights)
    theirs = rivals.textbook_scores(trained, weights)
    for name in ("fitness", "cot_inverse"):
        np.testing.assert_allclose(theirs[name], getattr(ours, name), rtol=2e-3, atol=2e-3)


def test_a_run_counts_from_its_start_to_the_fitness():
    rows = pd.concat(
        [runs("tegotae", [5.0, 6.0, 7.0], [0.1, 0.5, 0.7]), runs("ppo", [9.0, 11.0], [0.0, 0.3])]
    )
    ours, agent = race.summarise(rows).to_dict("records")
    assert (ours["start_s"], ours["step_s"], ours["steps"], ours["core_s"]) == (4.0, 1.0, 3, 7.0)
    assert np.isnan(agent["core_s"]), "it has not reached the fitness"
    assert "0 of 1" in race.tabulate(rows)


def test_a_part_of_an_episode_is_extrapolated_to_our_generations():
    rows = pd.concat(
        [runs("tegotae", [5.0, 6.0, 7.0], [0.1, 0.5, 0.7]), runs("mjx", [9.0, 9.5], [np.nan] * 2)]
    )
    _, mjx = race.summarise(rows).to_dict("records")
    assert mjx["step_s"] == pytest.approx(0.5 / rivals.SHARE)
    assert mjx["core_s"] == pytest.approx(8.5 + 3 * 0.5 / rivals.SHARE)


def test_a_program_whose_library_is_missing_is_left_out_with_a_line(tmp_path, monkeypatch, capsys):
    absent = rivals.Rival("a rival", rivals.learn_natively, "no_such_library", seeds=1)
    present = rivals.Rival("tegotae", rivals.learn_natively, seeds=1)
    monkeypatch.setattr(race, "RIVALS", {"tegotae": present, "absent": absent})
    row = {"program": "tegotae", "seed": 0, "fitness": 0.7, "cot_inverse": 0.7}
    rows = [row | {"step": k, "core_s": 5.0 + k} for k in range(3)]
    monkeypatch.setattr(race, "_measured", lambda name, seed: rows)
    assert race.race(tmp_path).exists()
    assert "needs no_such_library is left out" in " ".join(capsys.readouterr().out.split())
    assert "a rival" not in (tmp_path / "race.md").read_text(encoding="utf-8")
