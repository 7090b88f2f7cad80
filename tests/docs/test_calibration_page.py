"""The page on the calibration says what its tables say."""

import importlib

import pytest

from pages import DOCS, prose
from research.reproduction.calibration.posterior import met
from research.reproduction.calibration.prior import candidates
from research.reproduction.readings.designs import CALIBRATED_TABLE
from research.reproduction.readings.named import reading_named
from tegotae._support.tables import read_csv

KEPT = DOCS.parent / "research" / "calibration"


@pytest.fixture(scope="module")
def study():
    return importlib.import_module("research.calibration.run")


@pytest.fixture(scope="module")
def measured(study):
    return study.read(KEPT)


@pytest.fixture(scope="module")
def page() -> str:
    return prose("reproduction/calibration.md")


def test_the_tables_of_the_page_follow_from_what_was_measured(study, measured):
    assert (KEPT / "statements.md").read_text(encoding="utf-8") == study.statements(measured)
    assert (KEPT / "scores.md").read_text(encoding="utf-8") == study.scores_table(measured)
    assert (KEPT / "choices.md").read_text(encoding="utf-8") == study.choices(measured)


def test_the_calibrated_readings_are_those_of_the_posterior(study, measured):
    assert CALIBRATED_TABLE.read_bytes() == (KEPT / "readings.csv").read_bytes()
    accepted = study.found_by(measured.scores)[study.LEVELS.name].accepted
    bodies = [int(row.split(",")[0]) for row in CALIBRATED_TABLE.read_text().splitlines()[1:]]
    assert len(bodies) == study.SAMPLE
    assert set(bodies) <= set(measured.bodies[accepted].tolist())


def test_the_calibrated_reading_meets_the_most_statements(study, measured, page):
    """V's own are of `vanilla.csv`; those of the maps, and the slowing, are of the fine look."""
    rows, counts = read_csv(KEPT / "vanilla.csv"), {}
    for body in dict.fromkeys(rows["body"]):
        is_body = rows["body"] == body
        scores = measured.fine[measured.bodies == int(body)][0].copy()
        scores[0] = rows["settled"][is_body].astype(float).mean() / 5.0
        scores[1:3] = [
            rows[name][is_body].astype(float).mean() for name in ("short_t0", "short_t1")
        ]
        counts[body] = int(met(scores, study.LEVELS.target).sum())
    best = max(counts, key=lambda body: counts[body])
    assert f"Number {best} of the prior meets" in page
    assert f"at the middle level, {counts[best]} of 8" in page
    hopper = candidates(int(best) + 1)[int(best)].hopper
    calibrated = reading_named("calibrated")
    numbers = (hopper.mass_kg, hopper.stiffness_n_per_m)
    assert (calibrated.mass, calibrated.stiffness) == pytest.approx(numbers, rel=1e-6)
    assert "--reading calibrated" in page
