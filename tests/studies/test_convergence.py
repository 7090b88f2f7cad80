"""The study of the integrator reads and solves the zoo's trained laws."""


def test_the_errors_of_the_zoos_trained_laws_are_measured(study, monkeypatch):
    convergence = study("convergence.run")
    monkeypatch.setattr(convergence, "DESIGNS", ("AR-rF-both",))
    monkeypatch.setattr(convergence, "LEARNED_RUNS", (0,))
    monkeypatch.setattr(convergence, "DURATION_S", 2.0)
    rows = convergence.study_of_learned()
    assert {row["law"] for row in rows} == {"AR-rF-both-w4/0", "AR-rF-both-w8/0"}
    assert all(row["largest_apex_error_mm"] < 1.0 for row in rows)
