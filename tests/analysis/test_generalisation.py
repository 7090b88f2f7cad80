"""Trained controllers in conditions that they never met: what is tried, kept, told and refused."""

import csv
import dataclasses

import numpy as np
import pandas as pd
import pytest

import tegotae
from refusals import refused
from tegotae import Hopper, System, TegotaeError, Timing
from tegotae.analysis.generalisation.disturbances import CATALOGUE, disturbances_named, joined
from tegotae.analysis.generalisation.on_engine import ControllersUnderTest
from tegotae.analysis.generalisation.retention import GaitRetention, Walked
from tegotae.analysis.generalisation.run import (
    Retention,
    Trial,
    generalise,
    margin,
    margins,
    measure_retention,
    retention_curve,
)
from tegotae.api.robustness import Robustness
from tegotae.cli import main
from tegotae.figures.generalisation import groups_figure
from tegotae.parts.bodies.base import Interface
from tegotae.parts.channels import FOOT
from tegotae.parts.fields import replace
from tegotae.simulation.integrators import Hold
from tegotae.simulation.schedules import SecondClock
from tegotae.systems import controller_file
from tegotae.systems.controller_file import ControllerSet, SavedController
from tegotae.systems.recipe import recipe
from tegotae.systems.resolve import legged_system as system

REFLEX = recipe("V-reflex-w8").controller()
CHOSEN = disturbances_named(
    ["mass=0.9/3.5", "release=0.1", "delay=0.004", "lost-leg", "omega=1.01", "wind-up=0.02/1.5"]
)
TIMING = Timing(duration_s=24.0, tick_s=0.002)


def hopper(weights=((2.0,), (0.0,)), **options) -> ControllersUnderTest:
    labels = tuple(map(str, range(len(weights))))
    settings = {"looked_at": TIMING, **options}
    system = System(controller=REFLEX, omega=8.0)
    return ControllersUnderTest(ControllerSet("V", system, np.array(weights), labels), **settings)


def replaced(tested, **changes) -> ControllersUnderTest:
    """The same runs in another system."""
    return dataclasses.replace(tested, controllers=replace(tested.controllers, changes))


@pytest.fixture(scope="module")
def outcome() -> Retention:
    return measure_retention(hopper(), CHOSEN)


def row_of(outcome, condition, level, run=0):
    table = outcome.table
    rows = (table["condition"] == condition) & np.isclose(table["level"], level)
    return table[rows & (table["run"] == run)].iloc[0]


# What is tried, and what comes of it.


def test_every_run_meets_every_level_once(outcome):
    assert (outcome.table.groupby(["condition", "level"])["run"].apply(list) == [[0, 1]] * 7).all()


def test_a_gait_is_kept_under_little_and_lost_where_the_actuator_cannot_lift_the_weight(outcome):
    little, much = row_of(outcome, "mass", 0.9), row_of(outcome, "mass", 3.5)
    assert [little["had"], little["keeps"], little["moves"]] == [True, True, True]
    assert [much["had"], much["keeps"], much["moves"]] == [True, False, False]
    assert np.isnan(much["efficiency"])
    still = row_of(outcome, "mass", 0.9, run=1)  # had no gait, and so lost none
    assert [still["had"], still["moved"], still["keeps"]] == [False, False, False]
    assert outcome.left_out == {"lost-leg": "a Hopper cannot lose a leg"}


def test_where_it_is_released_from_does_not_change_what_a_limit_cycle_costs(outcome):
    lower = row_of(outcome, "release", 0.1)
    assert lower["keeps"]
    assert lower["efficiency"] == pytest.approx(1.0, abs=0.02)


def test_a_breath_of_wind_changes_no_gait_and_a_storm_carries_the_hopper_away(outcome):
    assert row_of(outcome, "wind-up", 0.02)["keeps"]
    assert not row_of(outcome, "wind-up", 1.5)["moves"]


def test_the_same_is_found_again_whatever_else_is_tried(outcome):
    alone = measure_retention(hopper(weights=((2.0,),)), CHOSEN)
    for condition, level in (("mass", 0.9), ("delay", 0.004)):
        first, second = row_of(outcome, condition, level), row_of(alone, condition, level)
        assert first["efficiency"] == pytest.approx(second["efficiency"], rel=1e-4)
        assert first["keeps"] == second["keeps"]


@pytest.mark.thorough
def test_walkers_are_pushed_lose_legs_and_meet_slopes_and_keep_a_share_of_their_speed():
    walker = system("quadruped-c")
    timing = dataclasses.replace(walker.timing, duration_s=60.0)
    weights = np.array([walker.weights])
    tested = ControllersUnderTest(
        ControllerSet("C", walker.system, weights, ("0",)), 2, looked_at=timing
    )
    disturbances = disturbances_named(
        ["push-aside=0.001/9", "lost-leg=1", "slope=-9", "rough=0.001", "strength"]
    )
    got = measure_retention(tested, disturbances)
    assert got.left_out == {"strength": "its actuators take places, not forces"}
    columns = got.table
    pushed = columns["condition"] == "push-aside"
    masks = {level: pushed & (columns["level"] == level) for level in (0.001, 9.0)}
    np.testing.assert_allclose(columns["speed"][masks[0.001]], 1.0, atol=0.02)
    assert columns["moves"][masks[0.001]].all()
    assert not columns["moves"][masks[9.0]].any()
    by = {name: columns["moves"][columns["condition"] == name] for name in ("slope", "rough")}
    assert not by["slope"].any()
    assert by["rough"].all()
    assert set(columns["start"]) == {0, 1}


def test_a_push_and_a_wind_of_one_direction_act_on_lanes_of_their_own():
    tested, met = quadruped(), disturbances_named(["push-ahead=0.3", "wind-ahead=0.1"])
    lanes = tested.disturbed(met, np.full(tested.size, 2.0))
    change = joined(tested, met, lanes)["push_x_n"]
    weight_n = tested.mass_kg * tested.nominal("gravity_m_per_s2")
    for time_s, pushed, blown_n in ((1.0, False, 0.0), (2.01, True, None), (99.0, False, 0.1)):
        push_n, wind_n = np.split(change.at(SecondClock(time_s), 0.0), 2)
        assert (push_n > 0.0).all() == pushed
        if blown_n is not None:
            np.testing.assert_allclose(wind_n, blown_n * weight_n)


# Who walks.


STAYS = {
    "lag": np.zeros((2, 1, 1)),
    "lock_time_s": np.ones((1, 1)),
    "fall_time_s": np.full((1, 1), np.nan),
    "cost_of_transport": np.ones((1, 1)),
    "step_frequency_hz": np.ones((2, 1, 1)),
    "ahead_m_per_s": np.full((1, 1), 0.4),
}


def walks(**values) -> dict[str, np.ndarray]:
    retention = GaitRetention(Walked(looks=True), 1.0).shares_kept(
        STAYS, STAYS | values, np.ones(1)
    )
    return {name: x.item() for name, x in retention.items()}


def test_who_loses_the_reference_leg_walks_on_if_another_leg_steps():
    frequency = np.array([np.nan, 0.9]).reshape(2, 1, 1)
    unknown_lags = {"lag": np.full((2, 1, 1), np.nan), "lock_time_s": np.full((1, 1), np.nan)}
    result = walks(step_frequency_hz=frequency, **unknown_lags)
    assert result["moves"]
    assert not result["keeps"]
    assert not walks(step_frequency_hz=frequency * np.nan)["moves"]


def test_who_walks_slowly_or_backwards_does_not_walk_on():
    assert walks(ahead_m_per_s=np.full((1, 1), 0.2))["speed"] == pytest.approx(0.5)
    for speed in (0.05, -0.4):
        assert not walks(ahead_m_per_s=np.full((1, 1), speed))["moves"]


def quadruped(starts=4, **options) -> ControllersUnderTest:
    walker = system("quadruped-c")
    weights = np.array([walker.weights])
    settings = {"looked_at": dataclasses.replace(walker.timing, duration_s=60.0), **options}
    labels = ("0",)
    return ControllersUnderTest(
        ControllerSet("C", walker.system, weights, labels), starts, **settings
    )


def test_what_a_release_meets_is_the_same_for_every_run_and_level():
    for text, entry in (("noise", "seed"), ("rough", "place"), ("lost-leg", "present")):
        (disturbance,) = disturbances_named([text])
        lanes = np.repeat(np.array(disturbance.levels[:2]), 3 * 4)  # levels, runs, releases
        changes = disturbance.changes(quadruped(), lanes, np.zeros(len(lanes)))
        (drawn,) = [x for name, x in changes.items() if name.endswith(entry)]
        drawn = np.asarray(drawn.value if entry == "present" else drawn)
        by_run = drawn.reshape(-1, 2, 3, 4)[:, 0]
        np.testing.assert_array_equal(by_run, np.repeat(by_run[:, :1], 3, axis=1))
        assert len(np.unique(by_run[:, 0], axis=1).T) == 4


def test_senses_can_be_as_late_as_the_levels_that_are_asked_for():
    long = disturbances_named(["delay=0.004/0.064"])
    assert not hopper().lacks(long[0])
    hopper().check(long)
    assert hopper().meeting(long).prepared.most_ticks == 32
    with pytest.raises(TegotaeError, match=r"delay=1 on V is 500 control ticks; 128 are the most"):
        hopper().check(disturbances_named(["delay=1"]))


def test_a_small_leg_is_looked_at_for_a_shorter_time():
    small = hopper(looked_at=None)
    assert small.timing.duration_s == 32.0
    body = Hopper(rest_length_m=0.25)
    assert replaced(small, body=body).timing.duration_s == pytest.approx(16.0)


# Tables.


LAG = dataclasses.replace(CATALOGUE["lag"], levels=(0.005, 0.01, 0.02))


def outcome_of(keeps: list[list[bool]], had=True) -> Retention:
    """Runs that keep their gait or not at rising levels of a lag."""
    levels = LAG.levels
    runs, n = len(keeps), len(levels)
    columns = {
        "condition": np.full(runs * n, "lag"),
        "level": np.tile(levels, runs),
        "run": np.repeat(np.arange(runs), n),
        "start": np.zeros(runs * n, int),
        "keeps": np.ravel(keeps),
        "moves": np.ravel(keeps),
        "had": np.full(runs * n, had),
        "moved": np.full(runs * n, had),
        "efficiency": np.ones(runs * n),
        "speed": np.full(runs * n, np.nan),
    }
    return Retention(pd.DataFrame(columns), {})


def test_a_margin_is_the_last_tested_level_that_is_survived_and_the_next():
    keeps = [[True, False, True], [True, True, False], [False, False, False]]
    (limits,) = margins(outcome_of(keeps), (LAG,))
    # One, two and no level: what comes back after a failure does not count.
    assert (limits.side, limits.runs) == ("above", 3)
    assert (limits.survived, limits.failed) == (0.005, 0.01)
    assert (limits.low, limits.high) == (0.0, 0.02)
    (alone,) = margins(outcome_of([[True, False, False]]), (LAG,))
    (half,) = margins(outcome_of([[True, False, False], [True] * 3]), (LAG,))
    assert alone[3:5] == half[3:5] == (0.005, 0.01)
    assert np.isnan([alone.low, alone.high]).all()  # a single run has no interval


def test_a_margin_below_the_usual_level_goes_downwards():
    mass = dataclasses.replace(CATALOGUE["mass"], levels=(0.5, 0.85, 1.2, 1.5))
    below = margin(mass, True, np.array([0.0, 1.0, 1.0]))
    assert below[:5] == ("mass", "below", 3, 0.85, 0.5)
    assert (below.low, below.high) == (0.5, 1.0)
    assert margin(mass, True, np.array([2.0]))[3:5] == (0.5, -np.inf)


def test_a_margin_beyond_the_last_level_is_infinite_and_of_no_gait_undefined():
    (beyond,) = margins(outcome_of([[True] * 3] * 3), (LAG,))
    assert (beyond.survived, beyond.failed) == (0.02, np.inf)
    assert (beyond.low, beyond.high) == (0.02, np.inf)
    (none,) = margins(outcome_of([[False] * 3] * 2, had=False), (LAG,))
    assert none.runs == 0
    assert np.isnan(none.survived)


def test_a_curve_has_the_share_of_those_that_had_a_gait():
    first = retention_curve(outcome_of([[True, False, True], [False, False, True]])).iloc[0]
    assert (first["level"], first["had"], first["keeps"]) == (0.005, 2, 0.5)
    assert 0.0 < first["keeps_low"] < 0.5 < first["keeps_high"] < 1.0


def test_releases_of_one_run_do_not_make_the_interval_narrower():
    once = outcome_of([[True] * 3, [False] * 3])
    often = Retention(pd.concat([once.table] * 4), {})
    single, four = retention_curve(once), retention_curve(often)
    assert (four["lanes"] == 4 * single["lanes"]).all()
    assert (four.filter(like="keeps") == single.filter(like="keeps")).all(axis=None)


def test_a_line_has_a_band_where_it_has_more_than_one_run():
    runs = {count: outcome_of([[True] * 3] * count) for count in (1, 3, 9)}
    figure = groups_figure({f"{n} runs": [(hopper(), runs[n])] for n in runs}, (LAG,))
    assert len(figure.axes[0].collections) == 2
    assert figure.legends[0].get_title().get_text() == "bands: 95 % intervals"


# The folder and the command.


def test_what_is_done_is_kept_and_not_done_again(outcome, tmp_path, monkeypatch):
    ((_, first),) = generalise([hopper()], CHOSEN, tmp_path)
    np.testing.assert_array_equal(first.table["keeps"], outcome.table["keeps"])

    def again(*_):
        raise AssertionError("it was done again")

    monkeypatch.setattr("tegotae.analysis.generalisation.run.measure_retention", again)
    ((_, second),) = generalise([hopper()], CHOSEN, tmp_path)
    pd.testing.assert_frame_equal(first.table, second.table)
    (record,) = (tmp_path / "records").iterdir()
    record.write_bytes(record.read_bytes()[:100])  # cut short
    with pytest.raises(AssertionError, match="again"):
        generalise([hopper()], CHOSEN, tmp_path)


def test_the_command_writes_margins_curves_and_a_picture(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr("tegotae.analysis.generalisation.on_engine.HOPPING", TIMING)
    file = tmp_path / "mine.json"
    controller_file.save(
        SavedController.from_weights(REFLEX, np.array([2.0]), 8.0, name="mine"), file
    )
    names = "mass=0.9/3.5,release=0.1,delay=0.004,lost-leg,omega=1.01"
    words = ["robustness", str(file), "--conditions", names, "--out", str(tmp_path / "out")]
    assert main(words) == 0
    output = capsys.readouterr().out
    assert "survived" in output
    assert "a Hopper cannot lose a leg" in output
    with (tmp_path / "out" / "margins.csv").open() as stream:
        rows = [row for row in csv.DictReader(stream) if row["measure"] == "keeps"]
    assert {(row["condition"], row["side"]) for row in rows} >= {
        ("mass", "below"),
        ("mass", "above"),
    }
    assert (tmp_path / "out" / "curves.png").stat().st_size > 10_000


def test_runs_that_are_the_same_are_tried_once():
    runs = ControllerSet(
        "V",
        System(controller=REFLEX, omega=8.0),
        np.array([[2.0], [2.0], [1.0]]),
        ("0", "1", "2"),
    )
    assert ControllersUnderTest.from_runs(runs).controllers.labels == ("0", "2")


# What is refused.


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["massive"], "no condition is called 'massive'; did you mean mass"),
        (["mass", "mass"], "named twice"),
        (["mass=a"], "has no levels; write mass=LEVEL/LEVEL"),
        (["mass=1"], "1 is no mass at all"),
        (["mass=2/2"], "each once"),
        (["lost-leg=0.5"], "0.5 is no number of legs"),
        (["lost-leg=-1"], "-1 is no number of legs"),
        (["omega=0"], "must be greater than 0"),
        (["release=-2"], "must be at least 0"),
    ],
)
def test_conditions_that_are_none_are_refused(words, says):
    refused(says, disturbances_named, words)


def test_a_level_that_makes_no_body_is_refused_before_work(tmp_path):
    with pytest.raises(TegotaeError, match=r"mass=-1 on V: mass_kg is -0.1"):
        generalise([hopper()], disturbances_named(["mass=-1"]), tmp_path)


def test_a_subject_that_can_meet_nothing_is_refused_before_work(tmp_path):
    with pytest.raises(TegotaeError, match="V can meet none of these conditions: lost-leg"):
        generalise([hopper()], disturbances_named(["lost-leg", "friction"]), tmp_path)


def test_one_that_can_meet_nothing_is_left_out_beside_others(tmp_path):
    reason = {"omega": "it has no oscillator"}
    two = disturbances_named(["omega=1.01"])
    single = System(controller=recipe("T-F").controller(10))
    weights = np.zeros((1, single.controller.n_weights))
    neighbour = dataclasses.replace(
        hopper(), controllers=ControllerSet("N", single, weights, ("0",))
    )
    assert measure_retention(neighbour, two).left_out == reason
    (tmp_path / "left_out.csv").write_text("of another run")
    empty = measure_retention(neighbour, two)
    assert retention_curve(empty).empty
    held = (hopper(), outcome_of([[True] * 3]))
    files = Robustness(outcomes=[(neighbour, empty), held], disturbances=(LAG,)).save(tmp_path)
    assert [path.name for path in files][:3] == ["margins.csv", "curves.csv", "left_out.csv"]
    Robustness(outcomes=[held], disturbances=(LAG,)).save(tmp_path)
    assert not (tmp_path / "left_out.csv").exists()


def test_a_body_of_another_simulator_is_refused_in_one_line():
    refused("V cannot be tested: ", lambda: replaced(hopper(), body=Interface()))
    with pytest.raises(TegotaeError, match=r"C cannot be tested: .*its body is not here"):
        replaced(quadruped(), body=Interface(limbs=4, commands=FOOT))


def test_the_command_tries_those_whose_names_match(tmp_path):
    file = tmp_path / "mine.json"
    controller_file.save(
        SavedController.from_weights(REFLEX, np.array([2.0]), 8.0, name="mine"), file
    )
    with pytest.raises(TegotaeError, match=r"no model matches T-\*; there are mine"):
        tegotae.load(file).robustness(only="T-*", out=tmp_path / "out")


def test_who_is_held_over_the_control_period_is_tried_so():
    held = replaced(
        hopper(looked_at=None), integrator=Hold(), timing=Timing(tick_s=0.004), phase_rad=1.0
    )
    assert held.timing.tick_s == 0.004
    assert held.phase_rad.tolist() == [1.0]
    baseline, held_document = (Trial(controllers, ()).document for controllers in (hopper(), held))
    assert {name for name in held_document if held_document[name] != baseline[name]} >= {
        "integrator",
        "release",
    }
