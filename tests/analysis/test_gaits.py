"""The gait laboratory on bodies that move: which gaits come about, and what the commands keep."""

import dataclasses
import json

import numpy as np
import pandas as pd
import pytest
from matplotlib.image import imread

from refusals import refused
from tegotae import System, TegotaeError, Timing
from tegotae._support.tables import parse_numbers, read_csv
from tegotae.analysis.gaits.lesion import GaitLesion
from tegotae.analysis.gaits.releases import release_all, simulate_gaits
from tegotae.analysis.gaits.sweep import GaitSweep, hysteresis, staircase_timing, sweep
from tegotae.cli import main
from tegotae.figures.gaits.animation import pose
from tegotae.figures.gaits.style import gait_colour
from tegotae.measures.gaits.lags import OfPhases, OfTouchdowns, lag_difference
from tegotae.measures.gaits.names import NO_GAIT, PATTERNS, gait_of
from tegotae.measures.gaits.summary import CoordinationSummary
from tegotae.measures.statistics import share_interval
from tegotae.parts.bodies import Bar, Hopper, Sensors
from tegotae.parts.fields import replace
from tegotae.systems.controller_file import SavedController, save
from tegotae.systems.legged import random_phases
from tegotae.systems.recipe import recipe, study_recipes
from tegotae.systems.resolve import legged_system as system
from tegotae.systems.vanilla import SYSTEMS

LIGHT = system("bar-light")
SHORT = replace(LIGHT, {"timing": Timing(duration_s=40.0)})


@pytest.fixture(scope="module")
def light():
    return release_all(SHORT, starts=24)


# Which gaits come about


def test_a_light_bar_comes_to_antiphase_from_every_start(light):
    (antiphase,) = light.outcomes.to_dict("records")
    assert (antiphase["gait"], antiphase["count"]) == ("antiphase", 24)
    assert antiphase["lag"][1] == pytest.approx(0.5, abs=0.01)
    assert antiphase["between"][1] < 0.01
    assert 0.0 < antiphase["lock_time_s"] < 30.0
    np.testing.assert_allclose(light.frame["touchdown_lag_cycles_F"], 0.5, atol=0.01)
    np.testing.assert_allclose(
        light.frame["cycle_frequency_hz"], light.frame["step_frequency_hz_H"], rtol=0.01
    )


def test_a_heavy_bar_comes_to_be_in_phase_and_legs_that_do_not_feel_each_other_to_nothing():
    ratios = np.repeat([1.6, 1.0], 24)  # one run of both
    scenario = SHORT.scenario(np.tile(random_phases(2, 24), 2), changes={"inertia_ratio": ratios})
    results = SHORT.run(SHORT.summary(), scenario)
    gait = gait_of(results, SHORT.names)
    assert set(gait[:24]) == {"in phase"}
    lag = np.sort(np.asarray(results.lag)[1, 24:])
    assert np.diff(lag).max() < 0.3  # all round the circle
    assert lag[-1] - lag[0] > 0.7


def test_lanes_do_not_know_of_each_other(light):
    for start in (0, 17):
        phase, lag = (
            light.frame[[f"{name}_H", f"{name}_F"]].to_numpy()[start]
            for name in ("release_phase_rad", "lag_cycles")
        )
        alone = SHORT.run(SHORT.summary(), SHORT.scenario(phase[:, None]))
        off = lag_difference(np.asarray(alone.lag)[:, 0], lag.astype("float32"))
        np.testing.assert_allclose(off, 0.0, atol=1e-4)


@pytest.mark.thorough
def test_a_body_whose_leg_collapses_has_fallen_and_no_lag():
    weak = replace(SHORT, {"body": Bar(inertia_ratio=0.6), "height_m": 12.0})
    frame = release_all(weak, starts=3).frame
    assert set(frame["gait"]) == {"fallen"}
    assert np.isfinite(frame["fall_time_s"]).all()
    assert frame["lag_cycles_F"].isna().all()


# Shares


def test_an_interval_of_a_share_holds_it_and_stays_within_zero_and_one():
    for count in (0, 1, 12, 24):
        share = share_interval(count, 24)
        assert 0.0 <= share.low <= count / 24 == share.mean <= share.high <= 1.0
    half = share_interval(12, 24)
    assert (half.low, half.high) == pytest.approx((0.3143, 0.6857), abs=1e-3)
    assert share_interval(0, 10).high == pytest.approx(0.2775, abs=1e-3)  # Wilson (1927), 0 of 10
    assert np.isnan(share_interval(0, 0).mean)
    refused("count is 25; it must be at most 24", share_interval, 25, 24)


def test_the_shares_of_what_starts_lead_to_add_up(light):
    frame = light.frame.assign(gait=["not locked"] * 5 + ["antiphase"] * 19)
    shares = dataclasses.replace(light, frame=frame).outcomes
    assert shares["count"].tolist() == [19, 5]
    assert shares["share"].sum() == pytest.approx(1.0)


# Sweeps


LEVELS = np.array([1.0, 1.5, 2.0, 2.5, 3.0, 3.5, 4.0])


def made_up_sweep(up, down, levels=LEVELS):
    """A made-up sweep: names of starts at rising levels, one text a start, on either way."""
    short = {"w": "walk", "t": "trot", "-": "in between", "x": "fallen"}
    frames = [
        pd.DataFrame({"omega_rad_per_s": levels, "start": start, "direction": direction})
        .assign(gait=[short[letter] for letter in names])
        for direction, starts in (("up", up), ("down", down))
        for start, names in enumerate(starts)
    ]  # fmt: skip
    return pd.concat(frames, ignore_index=True)


@pytest.mark.parametrize(
    ("up", "down", "between"),
    [
        # a bistable body: it trots above 3, walks below 2, and in between goes on as it was
        (["wwwwwtt"] * 3, ["wwttttt"] * 3, [(3.0, 3.5), (1.5, 2.0), (1.0, 2.0), (3, 3)]),
        # a start that flickers counts once, where it changes for the last time
        (["wtwtttt"], ["wwttttt"], [(2.0, 2.5), (1.5, 2.0), (0.0, 1.0), (1, 1)]),
        # without memory the hysteresis has no width
        (["wwwtttt"], ["wwwtttt"], [(2.0, 2.5), (2.0, 2.5), (-0.5, 0.5), (1, 1)]),
        # names are missing in between, and starts change at different levels
        (["ww---tt", "wwwtttt"], ["wwttttt"] * 2, [(1.5, 3.5), (1.5, 2.0), (-0.5, 2.0), (2, 2)]),
        (["wwx-ttt"], ["wwttttt"], [(1.5, 3.0), (1.5, 2.0), (-0.5, 1.5), (1, 1)]),
    ],
)
def test_changes_of_gait_lie_between_the_levels_at_which_both_were_seen(up, down, between):
    (row,) = hysteresis(made_up_sweep(up, down)).to_dict("records")
    assert (row["slow"], row["fast"]) == ("walk", "trot")
    for name, ends in zip(("up", "down", "width"), between[:3], strict=True):
        assert (row[f"{name}_low"], row[f"{name}_high"]) == ends
    assert (row["up_starts"], row["down_starts"]) == between[3]
    assert hysteresis(made_up_sweep(up, ["wwwwwww"] * len(up))).empty  # what does not come back


def test_two_ways_differ_where_their_lags_do_whatever_these_are_called():
    def bistable_levels(up, down):
        frame = made_up_sweep(["wwww"] * 5, ["wwww"] * 5, np.arange(1.0, 5.0))
        frame = frame.sort_values(["direction", "omega_rad_per_s"], ascending=[False, True])
        lag = np.repeat(np.concatenate([up, down]), 5)
        return GaitSweep(LIGHT, frame.assign(lag_cycles_H=0.0, lag_cycles_F=lag)).bistable

    up = np.full(4, 0.98)
    assert bistable_levels(up, [0.02, 0.1, 0.6, np.nan]).tolist() == [2.0, 3.0]
    shifted = GaitSweep(LIGHT, made_up_sweep(["w"], ["w"], [1.0]).assign(
        lag_cycles_H=[0.0, 0.3], lag_cycles_F=[0.98, 0.28]))  # fmt: skip
    assert shifted.bistable.size == 0  # a common shift is none


@pytest.fixture(scope="module")
def swept():
    return sweep(LIGHT, [7.0, 8.0], dwell_s=30.0, starts=3)


def test_a_sweep_goes_up_in_some_lanes_and_down_in_others(swept):
    assert len(swept.frame) == 2 * 2 * 3
    of_levels = swept.frame.groupby(["direction", "omega_rad_per_s"])
    hz = of_levels.cycle_frequency_hz.median().unstack()
    np.testing.assert_allclose(2.0 * np.pi * hz, [[7.0, 8.0]] * 2, rtol=0.05)
    assert (hz[7.0] < hz[8.0]).all()
    for direction, end in (("up", 8.0), ("down", 7.0)):
        assert set(of_levels.get_group((direction, end)).gait) == {"antiphase"}
    times = of_levels.get_group(("up", 8.0)).lock_time_s  # from the begin of the level
    assert (times.dropna() <= 15.0).all()
    deaf = sweep(LIGHT.with_numbers(sigma=0.0), [7.0, 8.0], dwell_s=30.0, starts=3)
    assert set(deaf.frame.gait) == {"as released"}  # legs do not feel each other


@pytest.mark.parametrize(
    ("levels", "says"),
    [
        ([8.0], "levels is 1; it must be a whole number of at least 2"),
        ([8.0, 7.0], "they must rise by equal steps"),
        ([7.0, 8.0, 10.0], "they must rise by equal steps"),
        ([0.0, 1.0], "a level of omega is 0; it must be greater than 0"),
    ],
)
def test_levels_that_cannot_be_are_refused(levels, says):
    refused(says, sweep, LIGHT, levels, dwell_s=30.0)


def test_a_dwell_is_of_whole_frames_and_not_too_short():
    timing = staircase_timing(Timing(frame_s=0.02), 3, 1.009)
    assert timing.n_frames == 150
    with pytest.raises(TegotaeError, match=r"dwell_s is 0\.1; it must be at least eight frames"):
        staircase_timing(Timing(frame_s=0.02), 3, 0.1)


# Systems


@pytest.mark.parametrize("name", SYSTEMS)
def test_every_system_has_legs_with_names_and_a_pattern_for_them(name):
    legged = system(name)
    legged.body.check_tick(legged.timing.tick_s)
    assert any(set(pattern.lags) == set(legged.names) for pattern in PATTERNS)
    assert legged.names[legged.reference] in ("H", "LH", "L")


def test_another_body_is_released_as_high_over_where_its_legs_touch_the_ground():
    four = system("quadruped-c")
    low = four.on(dataclasses.replace(four.body, com_z_m=four.body.com_z_m - 0.1))
    assert low.system.release.height_m == pytest.approx(four.system.release.height_m - 0.1)
    longer = LIGHT.on(dataclasses.replace(LIGHT.body, rest_length_m=1.5))
    over = longer.system.release.height_m - 1.5
    assert over == pytest.approx(LIGHT.system.release.height_m - LIGHT.body.rest_length_m)
    with pytest.raises(TegotaeError, match="this hopper cannot hop"):
        LIGHT.on(dataclasses.replace(LIGHT.body, mass_kg=50.0))


def test_a_walkers_controller_file_is_released_and_timed_as_the_named_walkers(tmp_path):
    walker = system("quadruped-a")
    weights = np.array(walker.weights)
    saved = SavedController.from_weights(
        walker.controller, weights, walker.omega, Sensors(body=walker.body)
    )
    save(saved, tmp_path / "walker.json")
    loaded = system(str(tmp_path / "walker.json"))
    assert loaded.system.release == walker.system.release
    for name in ("timing", "reference", "dimensionless", "names"):
        assert getattr(loaded, name) == getattr(walker, name)


@pytest.mark.thorough
def test_a_body_behind_sensors_has_the_gait_of_the_bare_one(light):
    behind = replace(SHORT, {"body": Sensors(body=SHORT.body, delay_s=0.002)})
    run = simulate_gaits(behind, (0.0, 2.0))
    assert run.gait == "antiphase"
    assert behind.names == ("H", "F")
    assert pose(behind.body, run.trajectory).hips_m.shape[1:] == (2, 3)
    longer = GaitLesion(at_s=1.0, fields=(("mass_kg", 0.2),))
    assert set(longer.scenario(behind, 0.0).changes) == {"body.mass_kg"}


def test_a_system_of_a_users_own_file_is_one(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "own_legs.py").write_text(
        "import dataclasses\n"
        "from tegotae.systems.resolve import legged_system as system\n"
        "mine = system('bar-light').with_numbers(omega=7.0)\n"
    )
    assert system("own_legs.py:mine").omega == 7.0


@pytest.mark.parametrize(
    ("entries", "says"),
    [
        (
            {"system": System(controller=recipe("V-sector-w8").controller(), omega=8.0)},
            "a gait command on a one",
        ),
        ({"weights": (1.0, 2.0)}, "2 weights are given; this controller has 1"),
        ({"legs": ("A", "A")}, "give each of 2 legs a name"),
        ({"reference": 2}, "reference is 2; it must be at most 1"),
    ],
)
def test_a_system_that_cannot_be_is_refused(entries, says):
    refused(says, dataclasses.replace, LIGHT, **entries)


def test_what_moves_without_oscillators_is_measured_by_its_footfalls():
    single = next(m for m in study_recipes().values() if m.controller().oscillator is None)
    legs = dataclasses.replace(single.controller(), limbs=2)
    assert CoordinationSummary.on(legs, Bar()).rhythm == OfTouchdowns()
    assert CoordinationSummary.on(LIGHT.controller, Bar()).rhythm == OfPhases()
    refused("a Hopper has one leg", lambda: CoordinationSummary.on(LIGHT.controller, Hopper()))


# Commands


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("gaits")
    common = ["gait", "basin", "bar-light", "--out", str(folder / "basin.png"), "--starts", "24"]
    assert main([*common, "--duration-s", "40"]) == 0
    return folder


def test_the_table_of_a_basin_agrees_with_its_document(folder):
    document = json.loads((folder / "basin.json").read_text())
    table = read_csv(folder / "basin.csv")
    assert len(document["rows"]) == len(table["gait"]) == 24
    assert list(document["rows"][0]) == list(table)
    for name, cells in table.items():
        values = [row[name] for row in document["rows"]]
        if name == "gait":
            assert cells.tolist() == values
        else:
            np.testing.assert_allclose(parse_numbers(cells), np.array(values, float), rtol=1e-8)


def test_the_document_says_what_was_run_and_what_came_about(folder, light):
    document = json.loads((folder / "basin.json").read_text())
    assert document["system"]["system"]["body"]["inertia_ratio"] == 0.6
    assert document["settings"]["starts"] == 24
    (outcome,) = document["outcomes"]
    assert (outcome["gait"], outcome["count"]) == ("antiphase", 24)
    assert outcome["lock_time_s"] == pytest.approx(light.outcomes["lock_time_s"][0])


@pytest.mark.thorough
def test_a_simulation_writes_its_footfalls_lags_and_an_animation(tmp_path, capsys):
    film = tmp_path / "walk.gif"
    words = ["simulate", "bar-light", "--out", str(tmp_path), "--duration-s", "20"]
    assert main([*words, "--phases", "0", "0.4", "--animate", str(film)]) == 0
    assert capsys.readouterr().out.startswith("antiphase\n")
    for name in ("footfall.png", "lags.png"):
        assert imread(tmp_path / name).std() > 0.0
    assert film.read_bytes()[:4] == b"GIF8"
    document = json.loads((tmp_path / "numbers.json").read_text())
    assert document["lag_cycles_F"] == pytest.approx(0.5, abs=0.01)
    # Duty factors by the stances and by the totals are the same.
    last = np.array(document["stances"]["F"][-8:-1])
    duty = (last[:, 1] - last[:, 0]).sum() / (last[-1, 0] - last[0, 0]) * 6 / 7
    assert duty == pytest.approx(document["duty_factor_F"], abs=0.01)


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["simulate", "bar-lihgt"], "no model or system is called 'bar-lihgt'; did you mean bar-"),
        (["simulate", "bar-light", "--phases", "0.1"], "1 phases are given; this body has 2 legs"),
        (["simulate", "bar-light", "--mas", "1"], "did you mean --mass-kg"),
        (
            ["simulate", "bar-light", "--duration-s", "0.04"],
            "a gait takes 8 frames at least (0.16 s)",
        ),
        (
            ["simulate", "bar-light", "--phases", "0", "0.1", "--seed", "2"],
            "seed is of random phases",
        ),
        (["simulate", "quadruped-c", "--present", *"1110"], "tegotae gait perturb --lose"),
        (
            [
                "gait",
                "sweep",
                "bar-light",
                "--levels",
                "7",
                "9",
                "--dwell-s",
                "9",
                "--duration-s",
                "9",
            ],
            "beside",
        ),
        (
            ["gait", "basin", "bar-light", "--starts", "0"],
            "starts is 0; it must be a whole number",
        ),
        (
            ["gait", "basin", "bar-light", "--tolerance", "0.7"],
            "tolerance is 0.7; it must be at most 0.5",
        ),
        (
            ["gait", "sweep", "bar-light", "--levels", "9", "7"],
            "omega goes from 9 to 7; the second must be greater",
        ),
        (
            ["gait", "sweep", "bar-light", "--levels", "7", "9", "--omega", "7.5"],
            "omega is one value, and it is varied",
        ),
    ],
)
def test_what_a_gait_command_cannot_do_is_said_in_one_line(words, says, tmp_path, capsys):
    assert main([*words, "--out", str(tmp_path / "out.png")]) == 2
    error = capsys.readouterr().err
    assert says in error
    assert error.count("\n") == 1


# Pictures


def test_every_gait_has_a_colour():
    for name in (*NO_GAIT, *(pattern.name for pattern in PATTERNS)):
        assert gait_colour(name)


def test_each_gait_of_a_quadruped_has_a_colour_of_its_own():
    names = {pattern.name for pattern in PATTERNS if len(pattern.lags) == 4}
    assert len({gait_colour(name) for name in names}) == len(names) > 5


@pytest.mark.parametrize(
    "name",
    [
        pytest.param("bar-light", marks=pytest.mark.thorough),
        pytest.param("plate-light-both", marks=pytest.mark.thorough),
        "quadruped-c",
    ],
)
def test_hips_are_where_the_body_has_them_and_feet_in_stance_on_the_ground(name, tmp_path):
    legged = system(name)
    timing = dataclasses.replace(legged.timing, duration_s=100 * legged.timing.frame_s)
    run = simulate_gaits(replace(legged, {"timing": timing}))
    shape = pose(legged.body, run.trajectory)
    assert shape.hips_m.shape == (100, legged.body.limbs, 3)
    middle = shape.hips_m[:, :, 2].mean(axis=1)
    above = -getattr(legged.body, "com_z_m", 0.0)
    np.testing.assert_allclose(middle, run.trajectory.height_m + above, atol=0.05)
    np.testing.assert_allclose(shape.feet_m[..., 2][shape.stands], 0.0, atol=1e-5)
    assert shape.stands.any()
    assert not shape.stands.all()


@pytest.mark.thorough
def test_a_body_of_which_nobody_has_told_how_it_looks_is_not_drawn():
    refused("a Hopper cannot be drawn: register its pose", lambda: pose(Hopper(), None))
