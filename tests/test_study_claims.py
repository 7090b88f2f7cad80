"""Each claim is judged by its effects' intervals: made-up results with known verdicts."""

from __future__ import annotations

import numpy as np
import pytest

from tegotae.evaluation import METRICS
from tegotae.models import all_models
from tegotae.study.claims import FAILS, HOLDS, UNDECIDED, correlation, verdicts
from tegotae.study.table import Table, design


def results(effects: dict[str, dict[str, float]], *, noise: float = 0.02, seed: int = 0) -> Table:
    """Three runs of every model; `effects` adds to metrics by architecture (and observation)."""
    random = np.random.default_rng(seed)
    rows: dict[str, list] = {}
    for model in all_models().values():
        place = design(model)
        for run in range(3):
            row = {**place, "run": run, "best_fitness": 0.0}
            for metric in METRICS:
                value = 1.0 + noise * random.normal()
                for key in (
                    place["architecture"],
                    f"{place['architecture']}/{place['observation']}",
                ):
                    value += effects.get(key, {}).get(metric, 0.0)
                row[metric] = value
            for key, value in row.items():
                rows.setdefault(key, []).append(value)
    return Table({key: np.array(values) for key, values in rows.items()})


def verdict(table: Table, number: int) -> str:
    return next(v.verdict for v in verdicts(table) if v.number == number)


def test_a_clear_effect_in_the_claimed_direction_holds() -> None:
    table = results({"VG": {"cot_inverse": 1.0, "t0_s": 1.0, "t1_s": 1.0}})
    assert verdict(table, 2) == HOLDS


def test_a_clear_effect_against_the_claim_fails() -> None:
    table = results({"VG": {"cot_inverse": 1.0, "t0_s": -0.5, "t1_s": 1.0}})
    assert verdict(table, 2) == FAILS


def test_no_effect_is_undecided_or_fails_but_never_holds() -> None:
    table = results({}, noise=0.5)
    assert all(v.verdict != HOLDS for v in verdicts(table) if v.number in (4, 5, 6, 8))


def test_nearness_is_an_equivalence_and_not_a_missing_difference() -> None:
    smoother = {"VT": {"smoothness": -0.5}}
    assert verdict(results(smoother), 3) == HOLDS
    assert verdict(results({"VT": {"smoothness": -0.5, "cot_inverse": 0.5}}), 3) == FAILS


def test_the_single_network_fails_without_velocity_and_is_on_par_with_it() -> None:
    table = results({"T/F": {"limit_cycle_share": -1.0}, "T/Fv": {"t0_s": 1.0}})
    assert verdict(table, 7) == HOLDS


def test_runs_without_a_limit_cycle_are_counted_and_left_out() -> None:
    table = results({"VG": {"cot_inverse": 1.0, "t0_s": 1.0, "t1_s": 1.0}})
    lost = (table["architecture"] == "VG") & (table["run"] == 0)
    table["t1_s"][lost] = np.nan
    claim = next(v for v in verdicts(table) if v.number == 2)
    counts = {part.what: part.effect for part in claim.parts}
    assert counts["T1, VG - V [s]"].undefined == (lost & (table["observation"] == "F")).sum()
    assert claim.verdict == HOLDS


def test_without_results_every_claim_is_undecided() -> None:
    empty = Table({name: column[:0] for name, column in results({}).columns.items()})
    assert {v.verdict for v in verdicts(empty)} == {UNDECIDED}


def test_the_correlation_of_a_line_is_one_and_its_interval_knows_its_sample() -> None:
    x = np.arange(10.0)
    line = Table({"a": x, "b": 2.0 * x + 1.0})
    assert correlation(line, "a", "b").mean == pytest.approx(1.0)
    with_holes = Table({"a": x, "b": np.where(x < 2, np.nan, x)})
    found = correlation(with_holes, "a", "b")
    assert (found.count, found.undefined) == (8, 2)
