"""The study of the integrator reads and solves the zoo's trained laws."""

import pytest


def test_the_errors_of_the_zoos_trained_laws_are_measured(study, monkeypatch):
    convergence = study("convergence.run")
    monkeypatch.setattr(convergence, "DESIGNS", ("AR-rF-both",))
    monkeypatch.setattr(convergence, "LEARNED_RUNS", (0,))
    monkeypatch.setattr(convergence, "DURATION_S", 2.0)
    rows = convergence.study_of_learned()
    assert {row["law"] for row in rows} == {"AR-rF-both-w4/0", "AR-rF-both-w8/0"}
    assert all(row["largest_apex_error_mm"] < 1.0 for row in rows)


@pytest.mark.thorough
def test_half_the_tick_tells_which_of_twenty_laws_of_all_families_are_a_millimetre_off(study):
    resolved = study("convergence.resolved")
    laws = resolved.drawn_laws(20, seed=1)
    rows = [row for law in laws for row in resolved.law_rows(law)]
    assert len({row["family"] for row in rows}) == 17
    regular = [row for row in rows if row["kind"] == "regular"]
    assert len(regular) >= 10
    wrong = {row["law"] for row in regular if row["error_mm_1"] > 1.0}
    assert wrong <= {row["law"] for row in regular if row["change_mm_1"] > 0.5}
    assert len(wrong) < len(regular) / 3


def test_the_pages_tables_are_those_of_the_kept_rows(study, monkeypatch, tmp_path):
    resolved = study("convergence.resolved")
    kept = {path.name: path.read_text() for path in resolved.FOLDER.glob("resolved_*.md")}
    monkeypatch.setattr(resolved, "FOLDER", tmp_path)
    resolved.report()
    assert {path.name: path.read_text() for path in tmp_path.iterdir()} == kept
