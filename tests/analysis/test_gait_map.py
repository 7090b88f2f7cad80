"""Maps of gaits over two parameters: what a cell is, which bodies cannot be, and what is kept."""

import dataclasses
import json

import numpy as np
import pandas as pd
import pytest
from matplotlib.image import imread

from refusals import refused
from tegotae import Timing
from tegotae._support.tables import parse_numbers, read_csv
from tegotae.analysis.gaits.map import (
    NO_BODY,
    Axis,
    GaitMap,
    MapPart,
    lanes_at,
    map_gaits,
    settings,
)
from tegotae.analysis.gaits.releases import release_all
from tegotae.api import gaits
from tegotae.cli import main
from tegotae.measures.gaits.lags import lag_difference
from tegotae.parts.fields import replace
from tegotae.systems.resolve import legged_system as system

BAR = replace(system("bar-light"), {"timing": Timing(duration_s=40.0)})
WALKER = system("quadruped-c")


@pytest.fixture(scope="module")
def bars():
    """Over the inertia ratio, of which -1 cannot be, and the gain."""
    return map_gaits(
        BAR, Axis("inertia_ratio", (-1.0, 0.6, 1.6)), Axis("sigma", (0.0, 1.0)), starts=3
    )


# Cells


def test_light_bars_are_in_antiphase_heavy_ones_in_phase_and_without_feedback_nothing_moves(bars):
    cells = bars.cells
    assert cells.gait.tolist() == [
        *(NO_BODY, "as released", "as released"),
        *(NO_BODY, "antiphase", "in phase"),
    ]
    assert (cells.share == 1.0).all()
    np.testing.assert_allclose(cells.lag_cycles_F[4:] % 1.0, [0.49, 0.0], atol=0.02)


def test_a_body_that_cannot_be_is_marked_and_stops_nothing(bars):
    refused = ["inertia_ratio is -1; it must be greater than 0", "", ""]
    assert bars.cells.refused.tolist() == 2 * refused
    assert np.isnan(bars.grid("lag_cycles_F")[:, 0]).all()
    assert bars.cells.lag_cycles_F[[0, 3]].isna().all()


def test_a_cell_is_what_a_basin_finds_there(bars):
    body = dataclasses.replace(BAR.body, inertia_ratio=1.6)
    alone = release_all(replace(BAR, {"body": body}), starts=3).frame
    lag = bars.grid("lag_cycles_F")[1, 2]
    assert (
        np.abs(lag_difference(lag, alone["lag_cycles_F"].to_numpy())).max() < 1e-4
    )  # but for rounding
    np.testing.assert_allclose(bars.grid("power_w")[1, 2], alone["power_w"], rtol=1e-4)


def test_of_starts_that_disagree_the_majority_has_the_cell():
    x, y = Axis("sigma", (0.0, 1.0)), Axis("omega", (7.0, 8.0))
    frame = pd.DataFrame({"sigma": np.tile(np.repeat([0.0, 1.0], 3), 2), "refused": ""})
    frame["omega"] = np.repeat([7.0, 8.0], 6)
    frame["gait"] = ["trot", "walk", "trot", "pace", "bound", "walk"] * 2
    frame["cost_of_transport"] = [1.0, 9.0, 3.0, *[np.nan] * 9]
    frame["fall_time_s"] = [np.nan] * 3 + [1.0] + [np.nan] * 8
    frame["lag_cycles_F"] = [0.95, 0.5, 0.05, *[0.0] * 9]
    frame = frame.assign(lag_cycles_H=0.0, lock_time_s=0.0, speed_m_per_s=0.0)
    cells = GaitMap(BAR, x, y, frame).cells
    assert cells.gait[:2].tolist() == ["trot", "bound"]  # the first by letters, of equals
    np.testing.assert_allclose(cells.share[:2], [2 / 3, 1 / 3])
    assert cells.cost_of_transport[0] == 2.0  # the median of the majority alone
    assert np.isnan(cells.cost_of_transport[1])
    lag = cells.lag_cycles_F[0]
    assert min(lag, 1.0 - lag) < 1e-9  # on the circle
    np.testing.assert_allclose(cells.fallen_share[:2], [0.0, 1 / 3])


# Axes


def test_a_field_with_a_number_a_leg_is_multiplied():
    (wide,) = settings(WALKER, [{"hips_y_m": 2.0}])
    assert wide.body is not None
    assert wide.body.hips_y_m == tuple(2.0 * y for y in WALKER.body.hips_y_m)
    weights, scenario = lanes_at(WALKER, [wide, wide], np.zeros((4, 2)))
    assert scenario.changes["hips_y_m"].shape == (4, 2)
    assert weights.shape == (2, 1)


def test_a_body_is_released_as_high_over_its_touchdown_as_the_systems_own():
    low, standard = settings(WALKER, [{"com_z_m": -0.5}, {"com_z_m": -0.39}])
    _, scenario = lanes_at(WALKER, [low, standard], np.zeros((4, 2)))
    own_m = WALKER.system.release.height_m
    np.testing.assert_allclose(scenario.height_m, [own_m - 0.11, own_m])


def test_an_inertia_that_no_body_has_and_a_tick_too_long_are_refused_by_the_body():
    flat, stiff = settings(WALKER, [{"inertia_z_kg_m2": 9.0}, {"stiffness_z_n_per_m": 1e6}])
    assert flat.body is None
    assert "which no body has" in flat.refused
    assert stiff.body is None
    assert "tick" in stiff.refused


# Long work


def test_an_interrupted_map_goes_on_where_it_was_and_another_begins_anew(tmp_path, monkeypatch):
    monkeypatch.setattr("tegotae.analysis.gaits.map.LANES", 4)
    short = replace(BAR, {"timing": Timing(duration_s=2.0)})
    axes = Axis("inertia_ratio", (0.6, 1.6)), Axis("sigma", (0.0, 0.5, 1.0))
    measure, measured = MapPart.measure, []

    def interrupted(part):
        measured.append(len(part.where))
        if len(measured) == 3:
            raise KeyboardInterrupt
        return measure(part)

    monkeypatch.setattr(MapPart, "measure", interrupted)
    with pytest.raises(KeyboardInterrupt, match="keeps 2 of 3 parts"):
        map_gaits(short, *axes, starts=2, folder=tmp_path)
    result = map_gaits(short, *axes, starts=2, folder=tmp_path)
    assert measured == [2, 2, 2, 2]
    complete = map_gaits(short, *axes, starts=2)
    pd.testing.assert_frame_equal(result.frame, complete.frame)
    map_gaits(short, *axes, starts=2, seed=1, folder=tmp_path)
    assert len(measured) == 10


def test_values_of_an_axis_rise():
    refused("do not rise", Axis, "omega", (2.0, 1.0))


# The question


def test_the_command_writes_a_picture_and_the_same_rows_twice_and_keeps_its_parts(tmp_path, capsys):
    words = ["gait", "map", "bar-light", "--x", "inertia_ratio", "-0.4", "1.6", "--y", "sigma", "0"]
    words += [
        "1",
        "--cells",
        "3",
        "2",
        "--starts",
        "3",
        "--duration-s",
        "40",
        "--out",
        str(tmp_path),
    ]
    assert main(words) == 0
    assert "antiphase" in capsys.readouterr().out
    table = read_csv(tmp_path / "numbers.csv")
    document = json.loads((tmp_path / "numbers.json").read_text())
    assert [row["gait"] for row in document["rows"]] == table["gait"].tolist()
    lags = [row["lag_cycles_F"] for row in document["rows"]]
    expected = parse_numbers(table["lag_cycles_F"])
    np.testing.assert_allclose([np.nan if x is None else x for x in lags], expected, rtol=1e-8)
    assert table["gait"].tolist().count(NO_BODY) == 2
    assert imread(tmp_path / "figure.png").std() > 0.01
    assert len(list((tmp_path / "records").glob("*.map.npz"))) == 1


OMEGA = ("omega", 7.0, 8.0)


@pytest.mark.parametrize(
    ("options", "line"),
    [
        ({"x": ("mass", 1.0, 2.0), "y": OMEGA}, "no parameter of this system"),
        ({"x": OMEGA, "y": OMEGA}, "both parameters are omega"),
        ({"x": ("omega", 8.0, 7.0)}, "omega goes from 8 to 7"),
        ({"x": OMEGA, "omega": 7.0}, "omega is one value, and it is varied"),
        ({"x": OMEGA, "cells": (1, 5)}, "points along omega is 1"),
        ({"x": ("omega", -1.0, 1.0)}, "a value of omega is -1; it must be greater than 0"),
        ({"x": ("inertia_rato", 1.0, 2.0)}, "'inertia_rato'; did you mean inertia_ratio"),
        ({"x": ("inertia_ratio", -2.0, -1.0)}, "no cell of this map has a body: inertia_ratio is"),
    ],
)
def test_what_cannot_be_mapped_is_told(options, line):
    refused(line, gaits.map, "bar-light", **options)
