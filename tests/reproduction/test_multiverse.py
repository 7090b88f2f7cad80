"""The claims over what the paper leaves open: readings, verdicts under them, what decides them."""

import math
import os
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import study_runs
from places import ROOT
from programs import main
from refusals import refused
from research.reproduction.calibration.prior import PRIOR
from research.reproduction.calibration.scores import EVALUATED_AS
from research.reproduction.claims.counting import Count
from research.reproduction.claims.estimates import EffectEstimate
from research.reproduction.claims.findings import OPPOSITE, REPRODUCED, TOO_SMALL, Finding
from research.reproduction.figures.multiverse import curve_figure, overview_figure
from research.reproduction.readings.designs import (
    calibrated_readings,
    cells_of,
    reading_of,
    selecting,
    selecting_body,
)
from research.reproduction.readings.folder import MultiverseFolder
from research.reproduction.readings.influence import decisive, influences
from research.reproduction.readings.named import reading_named
from research.reproduction.readings.plan import multiverse
from research.reproduction.readings.readings import (
    ALLOWED,
    Reading,
)
from research.reproduction.readings.tables import read_tables, write_multiverse_tables
from research.reproduction.readings.verdicts import (
    CLAIMS,
    FindingsByReading,
    claim_margin,
    findings_by_reading,
    of_claim,
    outcome_counts,
)
from research.reproduction.report.multiverse import counts_by_claim, shares_table
from study_tables import results
from tegotae.measures.hopping.metrics import HOPPING
from tegotae.measures.objectives.fitness import Fitness
from tegotae.parts.bodies import Hopper
from tegotae.parts.fields import replace
from tegotae.parts.terms import Reflex, Sector, SectorAndReflex
from tegotae.simulation.rollout import Timing
from tegotae.systems.recipe import recipe
from tegotae.training.scoring import best_gain

NAMES = tuple(choice.name for choice in PRIOR)

# Readings.


def test_the_standard_reading_is_the_study():
    hopper, standard = Reading().hopper, Hopper()
    for name in ("stiffness_n_per_m", "damping_ns_per_m", "max_force_n", "mass_kg"):
        assert getattr(hopper, name) == pytest.approx(getattr(standard, name), rel=0.0)


def test_the_body_has_the_ratios_that_it_was_made_of():
    hopper = Reading(natural_frequency=2.5, damping_ratio=0.2, force_ratio=3.0).hopper
    assert hopper.natural_frequency_rad_per_s * math.sqrt(1.0 / 9.81) == pytest.approx(2.5)
    critical = 2.0 * math.sqrt(hopper.stiffness_n_per_m * hopper.mass_kg)
    assert hopper.damping_ns_per_m / critical == pytest.approx(0.2)
    assert hopper.max_force_n / hopper.weight_n == pytest.approx(3.0)


@pytest.mark.parametrize(
    ("choice", "says"),
    [
        ({"force_ratio": 0.9}, "force_ratio is 0.9; an actuator that is to lift the body needs"),
        ({"natural_frequency": 0.9}, "natural_frequency is 0.9; this leg has no length left"),
        ({"release": 2.5}, r"the fall presses the leg by 1\.\d+ of its length"),
        ({"drop": 2.0}, "the fall presses the leg"),
        ({"damping_ratio": -0.1}, "damping_ratio is -0.1"),
        ({"work": "electric"}, "electric"),
        ({"mass_kg": 0.0}, "mass_kg is 0"),
        ({"newtons_per_feedback": -1.0}, "newtons_per_feedback is -1"),
        ({"frequency_weight": -0.1}, "frequency_weight is -0.1"),
        ({"sector_s": 0.0}, "sector_s is 0"),
    ],
)
def test_readings_that_the_body_does_not_allow_or_that_mean_nothing_are_refused(choice, says):
    refused(says, Reading, **choice)


# Designs of readings.


def test_the_calibrated_readings_differ_in_what_v_depends_on():
    readings = calibrated_readings(24)
    assert len(set(readings)) == 24
    assert readings[:5] == calibrated_readings(5)
    for reading in readings:
        assert reading_of(dict(zip(NAMES, cells_of(reading), strict=True))) == reading
    refused("the calibrated sample has 24", calibrated_readings, 25)


def test_a_multiverse_runs_over_the_calibrated_readings():
    plan = multiverse("calibrated", 2)
    assert [reading for reading, _ in plan.by_reading] == calibrated_readings(2)
    assert list(plan.document["choices"]) == list(NAMES)
    for reading, units in plan.by_reading:
        for unit in units.values():
            experiment = unit.run.experiment
            assert experiment.body == reading.hopper
            assert experiment.objective.frequency_weight == reading.frequency_weight
            assert experiment.search_offsets == reading.tuned_over
            assert len(unit.run.seeds) == 8
    refused("the calibrated sample has 24", multiverse, "calibrated", 25)


# The work.


def test_a_reading_is_in_every_unit_that_it_is_about():
    plan = multiverse("calibrated", 9)
    for reading, units in plan.by_reading:
        assert list(units) == list(plan.models)
        for unit in units.values():
            experiment, protocol = unit.run.experiment, unit.run.experiment.protocol
            assert experiment.body == reading.hopper
            assert experiment.objective.work == reading.work
            release_m = reading.release * reading.rest_length_m
            assert experiment.system.release.height_m == protocol.release_m == release_m
            assert protocol.work == reading.work
            assert protocol.drop_m == reading.drop * reading.rest_length_m


def test_mass_scales_the_body_and_keeps_its_ratios():
    light, heavy = Reading().hopper, Reading(mass_kg=0.2).hopper
    assert heavy.mass_kg == 2.0 * light.mass_kg
    assert heavy.natural_frequency_rad_per_s == pytest.approx(light.natural_frequency_rad_per_s)
    assert heavy.max_force_n / heavy.weight_n == pytest.approx(light.max_force_n / light.weight_n)


def test_a_reading_changes_vanilla_actuations_alone():
    reading = Reading(newtons_per_feedback=2.0, sector_s=0.05)
    sector = reading.actuation(Sector())
    assert (sector.width_rad, sector.duration_s) == (0.0, 0.05)
    changed = reading.actuation(SectorAndReflex())
    assert (changed.duration_s, changed.newtons_per_feedback) == (0.05, 2.0)
    assert reading.actuation(Reflex()) == Reflex(2.0)
    learned = recipe("ART").experiment().controller.actuation
    assert reading.actuation(learned) == learned
    for actuation in (Sector(), Reflex(), SectorAndReflex(), learned):
        assert Reading().actuation(actuation) == actuation


def test_a_gain_is_tuned_at_one_frequency_or_over_several():
    """The gain of the mean fitness is no gain of either frequency's own."""
    plain = recipe("V-sector-w8").experiment(
        timing=Timing(duration_s=6.0, tick_s=0.002), objective=Fitness(settle_s=3.0)
    )
    over = replace(plain, {"search_offsets": (-1.0, 1.0)})
    gains = [best_gain(replace(plain, {"omega": omega})) for omega in (7.0, 9.0)]
    gain, fitness = best_gain(over)
    assert fitness <= np.mean([best for _, best in gains])
    assert gain in plain.gains
    refused("search_offsets is empty", replace, plain, {"search_offsets": ()})


def test_every_claim_has_the_models_that_it_is_about():
    table = results({}).where(model=multiverse("calibrated").models)
    names = {metric.name for metric in HOPPING.metrics()}
    for omega, claimed in findings_by_reading({0: table}, draws=20)[0].items():
        for finding in claimed:
            reads = getattr(finding.claim.effect, "metric", None)
            if reads in names:
                assert finding.outcome in (REPRODUCED, TOO_SMALL, OPPOSITE), (finding, omega)


def test_a_claim_is_judged_as_soon_as_all_of_its_models_are_there():
    models = multiverse("calibrated").models
    few = [name for name in models if name.startswith(("V-", "VG-", "AR-rF-"))]
    by_reading = findings_by_reading({0: results({}).where(model=few)}, draws=20, models=models)
    judged = {finding.claim.name for finding in by_reading[0][AT_BOTH]}
    assert {"vg-cot", "ar-cot", "ar-t1"} <= judged
    # AR alone is not learned feedback, and a correlation is over all models.
    assert not judged & {"learned-beats-v", "art-cot", "t-par", "v-t1", "efficient-is-slow"}


def test_more_readings_go_on_in_the_same_folder():
    few, many = multiverse("smoke", 2), multiverse("smoke", 5)
    assert few.document == many.document
    assert {unit.key for unit in few.units} < {unit.key for unit in many.units}


# Verdicts.

AT_BOTH = "both"


@pytest.fixture(scope="module")
def trained() -> tuple[list[Reading], FindingsByReading]:
    """ART is better than AR by absolute work, and worse by net work."""
    readings = calibrated_readings(24)
    better = {"net": -0.4, "positive": 0.0, "absolute": 0.5}
    models = multiverse("calibrated").models
    tables = {
        i: results({"ART": {"cot_inverse": better[x.work]}}, noise=0.05, seed=100 + i).where(
            model=models
        )
        for i, x in enumerate(readings)
    }
    return readings, findings_by_reading(tables, draws=100)


def test_shares_count_the_readings_in_which_a_claim_is_reproduced_and_opposite(trained):
    readings, by_reading = trained
    worse, better = (sum(x.work == work for x in readings) for work in ("net", "absolute"))
    for omega in (AT_BOTH, "4", "8"):
        counts = outcome_counts(of_claim(by_reading, "art-cot", omega).values())
        assert counts[OPPOSITE] >= worse
        assert counts[REPRODUCED] >= better
        assert sum(counts.values()) == len(readings)


def test_the_choice_that_decides_a_claim_is_found_and_no_other(trained):
    readings, by_reading = trained
    clear = decisive(influences(readings, of_claim(by_reading, "art-cot", AT_BOTH)))
    assert [influence.choice.name for influence in clear] == ["work"]
    assert clear[0].correlation > 0.8
    assert clear[0].p < 0.001


def test_where_nothing_decides_chance_seldom_does():
    """Claims on noise: at most one in twenty has a choice that passes for decisive."""
    random = np.random.default_rng(0)
    readings = calibrated_readings(24)

    def noise() -> dict[int, Finding]:
        return {i: finding_of(random.normal(), 1.0) for i in range(24)}

    false = sum(bool(decisive(influences(readings, noise()))) for _ in range(60))
    assert false <= 8  # 3 expected; more than 8 has a chance of 1 in 250


def finding_of(effect: float, half: float, name: str = "art-cot") -> Finding:
    claim = next(claim for claim in CLAIMS if claim.name == name)
    return Finding(claim, {Count(): EffectEstimate(effect, effect - half, effect + half)})


@pytest.mark.parametrize("effect", [-3.0, -1.01, -0.5, 0.0, 0.5, 1.01, 3.0])
@pytest.mark.parametrize("name", ["art-cot", "arg-cot"])
def test_a_margin_says_what_the_outcome_says(effect, name):
    finding = finding_of(effect, 1.0, name)
    assert (claim_margin(finding) > 1.0) == (finding.outcome == REPRODUCED)
    assert (claim_margin(finding) < -1.0) == (finding.outcome == OPPOSITE)


# Tables and figures.


def test_tables_hold_readings_and_what_comes_of_the_claims(trained, tmp_path):
    readings, by_reading = trained
    write_multiverse_tables(readings, by_reading, tmp_path)
    again, read = read_tables(tmp_path)
    assert again == readings
    for number, by_omega in by_reading.items():
        for omega, by_claim in by_omega.items():
            outcomes = [(finding.claim.name, finding.outcome) for finding in read[number][omega]]
            assert outcomes == [(finding.claim.name, finding.outcome) for finding in by_claim]


def refused_with(tmp_path, one_line_error, trained, name, change) -> str:
    """The error of figures from a table whose text was changed."""
    write_multiverse_tables(*trained, tmp_path)
    (tmp_path / name).write_text(change((tmp_path / name).read_text()))
    words = ["reproduction", "readings", "figures", str(tmp_path), "--out", str(tmp_path / "out")]
    return one_line_error(*words)


@pytest.mark.parametrize("name", ["readings.csv", "effects.csv"])
@pytest.mark.parametrize("content", ["", "a,b\n1,2\n"])
def test_what_is_no_table_is_refused(trained, tmp_path, one_line_error, name, content):
    message = refused_with(tmp_path, one_line_error, trained, name, lambda text: content)
    assert f"{tmp_path / name} is no table that" in message


@pytest.mark.parametrize(("name", "row"), [("readings.csv", "0"), ("effects.csv", "0, omega_t")])
def test_a_row_that_is_there_twice_is_refused(trained, tmp_path, one_line_error, name, row):
    def again(text):
        return text + text.splitlines()[1] + "\n"

    message = refused_with(tmp_path, one_line_error, trained, name, again)
    assert f"{tmp_path / name} has 2 rows of reading {row}" in message


def test_the_table_of_shares_names_what_decides(trained):
    readings, verdicts = trained
    rows = shares_table(readings, verdicts).splitlines()[2:]
    measured = [claim for claim in CLAIMS if of_claim(verdicts, claim.name, AT_BOTH)]
    assert len(rows) == len(measured)
    gains = next(row for row in rows if "`art-cot`" in row)
    assert "| work (+0." in gains
    assert " of 24 [" in gains


def test_readings_that_the_text_allows_are_counted_beside_all():
    readings, by_reading = read_tables(ROOT / "research" / "reproduction" / "kept" / "multiverse")
    assert [sum(map(allowed, readings)) for allowed in ALLOWED.values()] == [17, 11]
    only = {number: by_reading[number] for number in (0, 20)}  # 20 damps in flight
    row = next(row for row in shares_table(readings, only).splitlines() if "learned-beats-v" in row)
    assert row.endswith("| 0 / 0 / 1 | 0 / 0 / 1 | – |")


def test_readings_and_bodies_that_statements_chose_say_so():
    readings, by_reading = read_tables(ROOT / "research" / "reproduction" / "kept" / "multiverse")
    every, allowed = counts_by_claim(readings, by_reading).values()
    assert every["v-cpgu"] == "22 / 1 / 0, selected for"
    assert sum(map(int, allowed["learned-beats-v"].split(" / "))) == 11
    assert selecting(readings) == selecting_body(readings[20].hopper) == {*EVALUATED_AS.values()}
    assert not selecting([Reading()])
    assert not selecting_body(Hopper())
    rounded = reading_named("calibrated").overrides
    assert selecting_body(Hopper(**rounded))


def test_figures_show_every_claim_that_is_measured_and_every_reading(trained):
    readings, by_reading = trained
    overview = overview_figure(readings, by_reading)
    measured = [claim for claim in CLAIMS if of_claim(by_reading, claim.name, AT_BOTH)]
    assert len(overview.axes[0].get_yticks()) == len(measured) > 20
    curve = curve_figure(readings, of_claim(by_reading, "art-cot", AT_BOTH))
    effects, choices = curve.axes
    heights = [float(np.ravel(x.get_ydata())[0]) for x in effects.lines if x.get_marker() == "o"]
    assert len(heights) == len(readings)
    assert heights == sorted(heights)
    assert len(choices.get_yticks()) == len(PRIOR)


# From the command line: killed, resumed, misused.


def start(folder: Path) -> subprocess.Popen[str]:
    words = ["reproduction", "readings", "run", "--dir", str(folder), "--scale", "smoke"]
    return subprocess.Popen(
        [sys.executable, "-m", *words, "--readings", "2", "--workers", "1"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )


@pytest.mark.thorough
def test_a_killed_multiverse_goes_on_and_loses_nothing(tmp_path, capsys):
    folder = tmp_path / "multiverse"
    process = start(folder)
    study_runs.wait_for(lambda: study_runs.records(folder), "a record", process)
    workers = study_runs.workers(process)
    os.kill(process.pid, signal.SIGKILL)
    process.communicate(timeout=900)
    study_runs.assert_ended(workers)
    stored = {path.name: path.read_bytes() for path in study_runs.records(folder)}
    words = ["reproduction", "readings", "status", "--dir", str(folder), "--readings", "2"]
    if len(stored) < 4:
        assert main(words) == 0
        assert f"{len(stored)} of 4 models done" in capsys.readouterr().out
    out, _ = study_runs.finish(start(folder))
    assert out.startswith(f"4 records in {folder}")
    current = {path.name: path.read_bytes() for path in study_runs.records(folder)}
    assert stored.items() <= current.items()
    assert set(current) == {f"{u.key}.record.npz" for u in multiverse("smoke", 2).units}
    assert main(words) == 0
    message = capsys.readouterr().out
    assert message == "scale smoke: 4 of 4 models done, 2 of 2 readings complete\n"
    # That readings are not whole is said.
    out = tmp_path / "out"
    assert (
        main(["reproduction", "readings", "export", "--dir", str(folder), "--out", str(out)]) == 0
    )
    assert "2 of 3 readings are complete" in capsys.readouterr().out
    assert main(["reproduction", "readings", "figures", str(out), "--out", str(out)]) == 0
    assert {"multiverse.png", "multiverse.md"} <= set(os.listdir(out))


def test_a_study_is_no_multiverse_and_a_multiverse_no_study(smoke_study, tmp_path, one_line_error):
    message = one_line_error("reproduction", "readings", "status", "--dir", str(smoke_study))
    assert "is a folder of python -m research.reproduction; look at it with that" in message
    folder = MultiverseFolder(tmp_path / "multiverse")
    with folder.claimed(multiverse("smoke")):
        pass
    message = one_line_error("reproduction", "status", "--dir", str(folder.path))
    assert (
        "is a folder of python -m research.reproduction readings; look at it with that" in message
    )


def test_an_unknown_frequency_is_refused(trained, tmp_path, one_line_error):
    readings, verdicts = trained
    write_multiverse_tables(readings, verdicts, tmp_path)
    words = ["reproduction", "readings", "figures", str(tmp_path), "--out", str(tmp_path / "out")]
    assert "omega is '5'; it must be one of 4, 8, both" in one_line_error(*words, "--omega", "5")


def test_a_claim_without_runs_has_no_share():
    table = results({}).where(architecture=("V", "VG"))
    by_reading = findings_by_reading({0: table, 1: table}, draws=20)
    assert of_claim(by_reading, "art-cot", AT_BOTH) == {}
    assert len(of_claim(by_reading, "vg-cot", AT_BOTH)) == 2
    assert not any(outcome_counts(()).values())
