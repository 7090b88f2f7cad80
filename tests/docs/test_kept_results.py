"""The results that come with the project: pages show what their tables say."""

import re

import numpy as np
import pytest

from pages import prose
from places import ROOT
from research.reproduction.calibration.scores import EVALUATED_AS
from research.reproduction.claims.atomic import ATOMIC_CLAIMS
from research.reproduction.claims.budgets import by_budget
from research.reproduction.claims.counting import Count, with_sampled
from research.reproduction.claims.effect_table import effects_csv, read_effects
from research.reproduction.claims.findings import NOT_MEASURED, OPPOSITE, REPRODUCED, findings
from research.reproduction.endings import endings_by_architecture
from research.reproduction.export import read_study_csv
from research.reproduction.figures.claims import claims_figure
from research.reproduction.figures.study import ARCHITECTURES, architectures
from research.reproduction.readings.tables import read_tables
from research.reproduction.report.atomic import beside_table, by_budget_table, outcomes_table
from research.reproduction.report.markdown import endings_table
from research.reproduction.report.multiverse import counts_by_claim, shares_table
from tegotae.systems.recipe import study_recipes

KEPT = ROOT / "research" / "reproduction" / "kept"
RESEARCH = ROOT / "research"
CLAIMS = RESEARCH / "reproduction" / "claims_page.md"


@pytest.fixture(scope="module")
def table():
    return read_study_csv(KEPT / "study" / "paper.csv")


@pytest.fixture(scope="module")
def effects():
    """Estimates of each claim, of the study and of those beside it."""
    return {name: read_effects(KEPT / "study" / f"effects{name}.csv") for name in ("", *BESIDE)}


SELECTED = frozenset(EVALUATED_AS.values())
BESIDE = ("-paper-deviation-0.2", "-paper-80x16", "-calibrated")


def folder_of(name: str):
    """Return the folder of a study's table."""
    return KEPT / ("study-calibrated" if name == "calibrated" else "study")


def runs_of(name: str):
    """A study's runs, and the controllers drawn from their distributions where it has them."""
    drawn = folder_of(name) / f"{name}-sampled.csv"
    runs = read_study_csv(folder_of(name) / f"{name}.csv")
    return with_sampled(runs, read_study_csv(drawn) if drawn.exists() else None)


def test_the_table_has_fifteen_runs_of_every_model(table):
    for name in study_recipes():
        assert (table["model"] == name).sum() == 15


def test_all_models_of_the_table_are_the_papers(table):
    assert len(table.of_the_paper()) == len(table)
    assert architectures(table)[: len(ARCHITECTURES)] == ARCHITECTURES
    assert set(architectures(table)) == set(table["architecture"].tolist())


def test_the_pages_tables_follow_from_the_kept_effects(effects):
    beside = {name.removeprefix("-"): effects[name] for name in BESIDE}
    assert (KEPT / "study" / "claims.md").read_text() == outcomes_table(effects[""])
    columns = counts_by_claim(*read_tables(KEPT / "multiverse"))
    beside_text = (KEPT / "study" / "claims-beside.md").read_text()
    assert beside_text == beside_table(effects[""], beside, columns)


@pytest.mark.thorough
def test_the_table_of_readings_follows_from_the_kept_effects():
    readings, result = read_tables(KEPT / "multiverse")
    assert (KEPT / "multiverse" / "multiverse.md").read_text() == shares_table(readings, result)


def test_what_chose_the_calibrated_body_is_never_reproduced_in_it(effects):
    by_name = {finding.claim.name: finding for finding in effects["-calibrated"]}
    assert {name for name, finding in by_name.items() if finding.selected} == SELECTED
    assert not [name for name in SELECTED if by_name[name].tally[REPRODUCED]]
    assert not [finding for finding in effects[""] if finding.selected]


def test_the_page_counts_the_outcomes_of_the_kept_effects(effects):
    tallies = [finding.tally for finding in effects[""]]
    reproduced = sum(bool(t[REPRODUCED] and not t[OPPOSITE]) for t in tallies)
    opposite = [sum(bool(t[OPPOSITE] and bool(t[REPRODUCED]) == is_both) for t in tallies)
                for is_both in (False, True)]  # fmt: skip
    assert (len(tallies), reproduced, opposite) == (53, 30, [10, 7])
    page = prose("reproduction/claims.md")
    assert "of 53 statements, 50 can be measured. 30 are reproduced in at least one way and" in page


def test_the_figure_has_a_row_for_every_claim_with_an_effect(effects):
    rows = claims_figure(effects[""]).axes[0].get_yticklabels()
    drawn = {finding.claim.title for finding in effects[""] if finding.outcome != NOT_MEASURED}
    assert {row.get_text() for row in rows} == drawn


def test_kept_effects_are_those_of_the_kept_tables(effects):
    """Compare a few claims, counted in every way; all claims where time does not matter."""
    few = ("learned-beats-v", "vg-t1", "v-input-cpgu")
    claims = [claim for claim in ATOMIC_CLAIMS if claim.name in few]
    stored = [finding for finding in effects[""] if finding.claim in claims]
    results = findings(runs_of("paper"), RESEARCH / "experiments", claims)
    assert effects_csv(results) == effects_csv(stored)


@pytest.mark.thorough
@pytest.mark.parametrize("name", ["", *BESIDE])
def test_all_kept_effects_are_those_of_the_kept_tables(effects, name):
    study_name = name.removeprefix("-") or "paper"
    experiments = folder_of(study_name) if name else RESEARCH / "experiments"
    results = findings(
        runs_of(study_name), experiments, selected=SELECTED if "calib" in name else ()
    )
    assert effects_csv(results) == effects_csv(effects[name])


@pytest.mark.thorough
def test_verdicts_after_each_budget_are_those_of_the_kept_tables(table):
    by_heading = {
        name: findings(runs, options=[Count()])
        for name, runs in by_budget(
            read_study_csv(KEPT / "study" / "paper-budgets.csv"), table
        ).items()
    }
    assert (KEPT / "study" / "claims-by-budget.md").read_text() == by_budget_table(by_heading)


def test_how_trainings_ended_is_what_the_table_says(table):
    assert (KEPT / "study" / "endings.md").read_text() == endings_table(
        endings_by_architecture(table)
    )


def test_effects_in_prose_are_those_of_the_tables(effects):
    intervals = {
        f"{estimate.effect:+.2f} [{estimate.low:.2f}, {estimate.high:.2f}]"
        for results in effects.values()
        for finding in results
        for estimate in finding.by_count.values()
    }
    text = CLAIMS.read_text(encoding="utf-8")
    # Contrasts and further statements have tables of their own, which test_prose_numbers reads.
    other_tables = r'(?!<!-- = (?:contrast|effect\("statements"))'
    interval = r"[+-]\d+\.\d\d \[-?\d+\.\d\d, -?\d+\.\d\d\]"
    quoted = re.findall(interval + other_tables, text)
    assert len(quoted) >= 10
    assert set(quoted) - intervals == set()


def test_no_statement_of_the_paper_is_contradicted_in_every_way_to_count(effects):
    assert not [e for e in effects[""] if e.is_robust and e.outcome == OPPOSITE]
    assert [e for e in effects[""] if e.outcome.startswith("depends")], "several, it says"


def test_a_learned_force_on_the_phase_is_smoother_than_the_sectors_at_8_rad_per_s(table):
    def ratio(omega, learned, fixed):
        pair = (
            table.where(omega_t=omega, architecture=("V", "VT"), actuation=name)["smoothness"]
            for name in (learned, fixed)
        )
        first, second = map(np.nanmean, pair)
        return first / second

    assert ratio(8.0, "tphi", "sector") < 0.95
    assert ratio(8.0, "tf", "reflex") > 2.0
    assert ratio(4.0, "tphi", "sector") == pytest.approx(1.0, abs=0.04)
    assert ratio(4.0, "tf", "reflex") == pytest.approx(1.0, abs=0.04)


def test_the_shares_that_the_page_gives_are_those_of_the_table(table):
    page = CLAIMS.read_text(encoding="utf-8")
    for omega in (4.0, 8.0):
        settled = table.where(architecture="V", omega_t=omega)["limit_cycle_share"].mean()
        assert f"{100 * (1 - settled):.0f} %" in page
    assert np.nanmax(table.where(model="T-Fv")["recovery_share"]) == 0.0
