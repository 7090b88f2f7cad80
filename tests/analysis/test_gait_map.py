"""Maps of gaits over two parameters: what a cell is, which bodies cannot be, and what is kept."""

from __future__ import annotations

import dataclasses
import json

import numpy as np
import pytest
from matplotlib.image import imread

from tegotae import TegotaeError, Timing
from tegotae._support.tables import numbers, read_csv
from tegotae.analysis.gaits import Coordination, system
from tegotae.analysis.gaits.basin import find_basin
from tegotae.analysis.gaits.checkpoint import in_parts
from tegotae.analysis.gaits.map import (
    NO_BODY,
    Axis,
    check_axis,
    fields_at,
    gait_map,
    lanes_at,
    majority,
    settings,
)
from tegotae.cli import main
from tegotae.measures.gaits.lags import apart

BAR = system("bar-light").with_system(timing=Timing(duration_s=40.0))
WALKER = system("quadruped-c")


@pytest.fixture(scope="module")
def bars():
    """Over the inertia ratio, of which -1 cannot be, and the gain."""
    return gait_map(
        BAR, Axis("inertia_ratio", (-1.0, 0.6, 1.6)), Axis("sigma", (0.0, 1.0)), starts=3
    )


# Cells


def test_light_bars_are_in_antiphase_heavy_ones_in_phase_and_without_feedback_nothing_moves(bars):
    cells = bars.cells
    assert cells.gait.tolist() == [
        [NO_BODY, "as released", "as released"],
        [NO_BODY, "antiphase", "in phase"],
    ]
    assert (cells.share == 1.0).all()
    np.testing.assert_allclose(cells.lag[1, 1:, 1] % 1.0, [0.49, 0.0], atol=0.02)


def test_a_body_that_cannot_be_is_marked_and_stops_nothing(bars):
    assert bars.refused[0].tolist() == [
        "inertia_ratio is -1; it must be greater than 0", "", "",
    ]  # fmt: skip
    assert np.isnan(bars.found.lag[:, 0]).all()
    assert np.isnan(bars.cells.lag[:, 0]).all()


def test_a_cell_is_what_a_basin_finds_there(bars):
    body = dataclasses.replace(BAR.body, inertia_ratio=1.6)
    basin = find_basin(BAR.with_system(body=body), 3)
    np.testing.assert_array_equal(bars.phase_rad, basin.phase_rad)
    assert np.abs(apart(bars.found.lag[1, 2], basin.found.lag)).max() < 1e-4  # but for rounding
    np.testing.assert_allclose(bars.found.power_w[1, 2], basin.found.power_w, rtol=1e-4)


def test_a_map_without_any_body_says_why():
    with pytest.raises(TegotaeError, match="no cell of this map has a body: inertia_ratio is -2"):
        gait_map(BAR, Axis("inertia_ratio", (-2.0, -1.0)), Axis("sigma", (0.0, 1.0)))


def test_the_same_parameter_twice_is_refused():
    with pytest.raises(TegotaeError, match="both parameters are sigma"):
        gait_map(BAR, Axis("sigma", (0.0, 1.0)), Axis("sigma", (2.0, 3.0)))


def test_of_starts_that_disagree_the_majority_has_the_cell():
    found = {name: np.zeros((1, 2, 3)) for name in Coordination._fields}
    found |= {name: np.full((1, 2, 3), np.nan) for name in ("cost_of_transport", "fall_time_s")}
    found["cost_of_transport"][0, 0] = [1.0, 9.0, 3.0]
    found["fall_time_s"][0, 1] = [1.0, np.nan, np.nan]
    found["lag"] = np.zeros((1, 2, 2, 3))
    found["lag"][0, 0, 1] = [0.95, 0.5, 0.05]
    gait = np.array([[["trot", "walk", "trot"], ["pace", "bound", "walk"]]])
    cells = majority(Coordination(**found), gait)
    assert cells.gait.tolist() == [["trot", "bound"]]  # the first by letters, of equals
    np.testing.assert_allclose(cells.share, [[2 / 3, 1 / 3]])
    assert cells.cost_of_transport[0, 0] == 2.0  # the median of the majority alone
    assert min(cells.lag[0, 0, 1], 1.0 - cells.lag[0, 0, 1]) < 1e-9  # on the circle
    np.testing.assert_allclose(cells.fallen, [[0.0, 1 / 3]])


# Axes


def test_a_field_with_a_number_a_leg_is_multiplied():
    (wide,) = settings(WALKER, [{"hips_y_m": 2.0}])
    assert wide.body is not None
    assert wide.body.hips_y_m == tuple(2.0 * y for y in WALKER.body.hips_y_m)
    weights, scenario = lanes_at(WALKER, [wide, wide], np.zeros((4, 2)))
    assert scenario.changes["hips_y_m"].shape == (4, 2)
    assert weights.shape == (2, 1)


def test_a_body_is_released_as_high_over_its_touchdown_as_the_systems_own():
    low, usual = settings(WALKER, [{"com_z_m": -0.5}, {"com_z_m": -0.39}])
    _, scenario = lanes_at(WALKER, [low, usual], np.zeros((4, 2)))
    own_m = WALKER.system.release.height_m
    np.testing.assert_allclose(scenario.height_m, [own_m - 0.11, own_m])


def test_an_inertia_that_no_body_has_and_a_tick_too_long_are_refused_by_the_body():
    flat, stiff = settings(WALKER, [{"inertia_z_kg_m2": 9.0}, {"stiffness_z_n_per_m": 1e6}])
    assert flat.body is None
    assert "which no body has" in flat.refused
    assert stiff.body is None
    assert "tick" in stiff.refused


@pytest.mark.parametrize(
    ("name", "line"),
    [
        ("com_x", "no parameter of this system is called 'com_x'; did you mean com_x_m"),
        ("terrain", "no parameter of this system is called 'terrain'"),
    ],
)
def test_a_parameter_that_is_no_number_of_the_body_is_refused(name, line):
    with pytest.raises(TegotaeError, match=line):
        check_axis(WALKER, Axis(name, (0.0, 1.0)))


@pytest.mark.parametrize(
    ("values", "line"),
    [((1.0,), "it must be a whole number of at least 2"), ((2.0, 1.0), "do not rise")],
)
def test_values_that_are_no_axis_are_refused(values, line):
    with pytest.raises(TegotaeError, match=line):
        Axis("omega", values)


def test_omega_and_sigma_are_no_fields_of_the_body():
    assert fields_at(BAR.body, {"omega": 8.0, "sigma": 1.0}) == {}
    with pytest.raises(TegotaeError, match="a value of omega is -1; it must be greater than 0"):
        check_axis(BAR, Axis("omega", (-1.0, 1.0)))


# Long work


def work(done: list[int], stop_at: int | None = None):
    def part(number: int):
        if number == stop_at:
            raise KeyboardInterrupt
        done.append(number)
        return {"x": np.array([number, number + 0.5])}

    return part


def test_interrupted_work_goes_on_where_it_was(tmp_path):
    kept, done = tmp_path / "kept.npz", []
    with pytest.raises(KeyboardInterrupt, match=r"keeps 2 of 4 parts"):
        in_parts(4, work(done, stop_at=2), kept=kept, settings={"a": 1})
    parts = in_parts(4, work(done), kept=kept, settings={"a": 1})
    assert done == [0, 1, 2, 3]
    assert [part["x"].tolist() for part in parts] == [[n, n + 0.5] for n in range(4)]
    assert not kept.exists()


def test_other_work_begins_anew(tmp_path):
    kept, done = tmp_path / "kept.npz", []
    with pytest.raises(KeyboardInterrupt):
        in_parts(2, work(done, stop_at=1), kept=kept, settings={"a": 1})
    in_parts(2, work(done), kept=kept, settings={"a": 2})
    assert done == [0, 0, 1]


def test_a_kept_file_that_cannot_be_read_is_told(tmp_path):
    (tmp_path / "kept.npz").write_text("no such thing")
    with pytest.raises(TegotaeError, match="cannot be read; remove it to start again"):
        in_parts(1, work([]), kept=tmp_path / "kept.npz")


# The command


def test_the_command_writes_a_picture_and_the_same_rows_twice(tmp_path, capsys):
    words = ["gait", "map", "bar-light", "--x", "inertia_ratio", "-0.4", "1.6", "--y", "sigma", "0"]
    words += ["1", "--cells", "3", "2", "--starts", "3", "--duration", "40", "--out", str(tmp_path)]
    assert main(words) == 0
    assert "antiphase" in capsys.readouterr().out
    table = read_csv(tmp_path / "map.csv")
    document = json.loads((tmp_path / "map.json").read_text())
    assert [row["gait"] for row in document["rows"]] == table["gait"].tolist()
    lags = [row["lag_cycles_F"] for row in document["rows"]]
    known = numbers(table["lag_cycles_F"])
    np.testing.assert_array_equal([np.nan if x is None else x for x in lags], known)
    assert table["gait"].tolist().count(NO_BODY) == 2
    assert imread(tmp_path / "map.png").std() > 0.01
    assert not (tmp_path / "map.partial.npz").exists()


@pytest.mark.parametrize(
    ("options", "line"),
    [
        (["--x", "mass", "1", "2", "--y", "omega", "7", "8"], "no parameter of this system"),
        (["--x", "omega", "7", "8", "--y", "omega", "7", "8"], "both parameters are omega"),
        (["--x", "omega", "8", "7", "--y", "sigma", "0", "1"], "omega goes from 8 to 7"),
        (
            ["--x", "omega", "7", "8", "--y", "sigma", "0", "1", "--omega", "8"],
            "--omega is one value, and the map is over omega",
        ),
        (
            ["--x", "omega", "7", "8", "--y", "sigma", "0", "1", "--cells", "1", "5"],
            "the number of values of omega is 1",
        ),
    ],
)
def test_what_cannot_be_mapped_is_told_in_one_line(tmp_path, capsys, options, line):
    assert main(["gait", "map", "bar-light", *options, "--out", str(tmp_path)]) == 2
    told = capsys.readouterr().err.strip()
    assert line in told
    assert "\n" not in told
