"""Anyone's recordings are measured: files, columns, units, and a reason for what is undefined."""

import json
import math
import sys

import numpy as np
import pandas
import pytest

import peak_force
from refusals import refused
from synthetic import Hopping, seconds
from tegotae import Rollout, Scenario, TegotaeError, Timing
from tegotae.cli import main
from tegotae.figures.recording import recording_figure, recording_tables
from tegotae.measures.hopping import measure
from tegotae.measures.hopping.gait import GaitSummary
from tegotae.measures.recordings import read_columns, recording, resampled
from tegotae.parts.bodies import Hopper
from tegotae.systems.registry import register
from tegotae.systems.vanilla import preset

TIME = seconds(20.0, 0.01)
HEIGHT = 1.0 + 0.1 * np.sin(6.0 * TIME)
FORCE = 2.0 * (1.0 + np.cos(6.0 * TIME))
COLUMNS = {"time_s": TIME, "height_m": HEIGHT, "force_n": FORCE}


@pytest.fixture(scope="module")
def settled():
    """A sine with a phase that keeps step with it, measured with all that there is to say."""
    return measure(
        TIME,
        HEIGHT,
        rest_length_m=1.0,
        phase_rad=6.0 * TIME,
        omega=6.0,
        force_n=FORCE,
        max_force_n=4.0,
    )


@pytest.fixture(scope="module")
def wandering():
    """Hops of all heights."""
    hopping = Hopping(np.random.default_rng(1).uniform(1.1, 1.5, 40))
    return measure(TIME, hopping.height_m(TIME), rest_length_m=1.0, force_n=np.abs(FORCE))


def recording_file(folder, columns, ending):
    path = folder / f"walk{ending}"
    frame = pandas.DataFrame(columns)
    if ending == ".npz":
        np.savez(path, **columns)
    elif ending == ".parquet":
        frame.to_parquet(path)
    else:
        frame.to_csv(path, index=False)
    return path


@pytest.mark.parametrize("ending", [".csv", ".npz", ".parquet"])
def test_a_file_of_any_format_holds_the_same_recording(tmp_path, ending):
    if ending == ".parquet":
        pytest.importorskip("pyarrow")
    read = recording(read_columns(recording_file(tmp_path, COLUMNS, ending)))
    np.testing.assert_allclose(read.time_s, TIME)
    np.testing.assert_allclose(read.height_m, HEIGHT)
    np.testing.assert_allclose(read.force_n, FORCE)
    assert "phase_rad" not in read


@pytest.mark.parametrize(
    ("time", "height"),
    [("t_ms", "height_mm"), ("Time (ms)", "Height [mm]"), ("T [ms]", "y_mm")],
)
def test_a_unit_in_a_columns_name_is_understood(time, height):
    read = recording({time: 1e3 * TIME, height: 1e3 * HEIGHT})
    np.testing.assert_allclose(read.time_s, TIME)
    np.testing.assert_allclose(read.height_m, HEIGHT)


def test_a_column_of_any_name_can_be_said_to_be_what_it_is():
    table = {"com z": 1e2 * HEIGHT, "osc": np.degrees(TIME), "height_of_the_tail_m": HEIGHT}
    read = recording(table, ["height=com z[cm]", "phase=osc[deg]"], rate_hz=100.0)
    np.testing.assert_allclose(read.height_m, HEIGHT)
    np.testing.assert_allclose(read.phase_rad, TIME)
    np.testing.assert_allclose(read.time_s, TIME)


def test_of_two_columns_for_one_quantity_the_one_that_is_named_is_read():
    table = {"time_s": TIME, "height_m": HEIGHT, "y_m": 2.0 * HEIGHT}
    np.testing.assert_allclose(recording(table, ["height=y_m"]).height_m, 2.0 * HEIGHT)
    as_ground = recording(table, ["ground=y_m"])
    np.testing.assert_allclose(as_ground.height_m, HEIGHT)
    np.testing.assert_allclose(as_ground.ground_m, 2.0 * HEIGHT)


@pytest.mark.parametrize(
    ("force", "newton"),
    [("force [mN]", 1e-3), ("force [MN]", 1e6), ("force_mn", 1e-3), ("FORCE_KN", 1e3)],
)
def test_capitals_tell_mega_from_milli_and_count_nowhere_else(force, newton):
    read = recording({"TIME_S": TIME, "Height [M]": HEIGHT, force: FORCE})
    np.testing.assert_allclose(read.force_n, newton * FORCE)


def test_an_energy_is_no_work_of_the_actuators_unless_it_is_said_to_be():
    table = {**COLUMNS, "energy_j": TIME}
    assert "work_j" not in recording(table)
    np.testing.assert_allclose(recording(table, ["work=energy_j"]).work_j, TIME)


def test_a_column_whose_unit_nobody_tells_is_left_alone_and_that_is_said(tmp_path, capsys):
    table = {"time_s": TIME, "height_m": HEIGHT, "actuator_force": FORCE, "phase [turns]": TIME}
    path = recording_file(tmp_path, table, ".csv")
    assert main(["measure", str(path), "--rest-length-m", "1"]) == 0
    force, phase = capsys.readouterr().err.splitlines()
    assert "column 'actuator_force' is without a unit and is left alone" in force
    assert "force=actuator_force[N]" in force
    assert "column 'phase [turns]' is in 'turns'" in phase


def test_uneven_times_are_measured_after_resampling():
    uneven = TIME + 0.004 * np.sin(np.arange(len(TIME)))
    read = recording({"time_s": uneven, "height_m": 1.0 + 0.1 * np.sin(6.0 * uneven)})
    refused("resample", measure, **read, rest_length_m=1.0)
    even = resampled(read, 100.0)
    np.testing.assert_allclose(np.diff(even.time_s), 0.01)
    np.testing.assert_allclose(even.height_m, 1.0 + 0.1 * np.sin(6.0 * even.time_s), atol=1e-3)


def test_a_wrapped_phase_is_resampled_as_a_phase():
    phase = (6.0 * TIME) % (2.0 * math.pi)
    read = resampled(recording({"time_s": TIME, "height_m": HEIGHT, "phase_rad": phase}), 77.0)
    np.testing.assert_allclose(read.phase_rad, 6.0 * read.time_s, atol=1e-9)


@pytest.mark.parametrize(
    ("name", "ticks", "options"),
    [("time_s", 1.0, []), ("%time", 1e9, ["--columns", "time=%time[ns]"])],  # of Unix, of ROS
)
def test_time_stamps_count_from_the_first_sample_and_a_line_says_so(
    tmp_path, capsys, name, ticks, options
):
    def printed_by(times, *arguments):
        path = recording_file(tmp_path, {**times, "height_m": HEIGHT}, ".csv")
        assert main(["measure", str(path), "--rest-length-m", "1", "--json", *arguments]) == 0
        return json.loads(capsys.readouterr().out)

    stamped = printed_by(
        {name: np.round(ticks * (1.7e9 + TIME), 2 if ticks == 1.0 else 0)}, *options
    )
    plain = printed_by({"time_s": TIME})
    assert stamped.pop("notes") == ["times count from the first sample, stamped 1700000000 s"]
    assert plain.pop("notes") == []
    assert stamped["apex_time_s"] == pytest.approx(plain["apex_time_s"], abs=1e-5)
    assert stamped["hop_rate"] == pytest.approx(plain["hop_rate"], rel=1e-5)


def test_every_metric_has_a_value_or_a_reason(settled, wandering):
    for measured in (settled, wandering):
        undefined = {name for name, value in measured.values.items() if math.isnan(value)}
        assert undefined <= set(measured.reasons)
        assert all(measured.reasons.values())
        for name in set(measured.reasons) & set(measured.values):
            assert math.isnan(measured.values[name])


def test_the_reason_says_how_far_a_gait_is_from_a_limit_cycle(wandering):
    assert "mm in height (5 are allowed)" in wandering.reasons["t0_s"]
    few = measure(TIME[:400], HEIGHT[:400], rest_length_m=1.0)
    assert few.reasons["t0_s"] == "4 hops; a limit cycle has to show at least 5"
    resting = measure(TIME, np.full_like(TIME, 0.8), rest_length_m=1.0)
    assert resting.reasons["t0_s"] == "no hop"


def test_the_reason_names_what_was_not_given():
    result = measure(TIME, HEIGHT, rest_length_m=1.0, force_n=FORCE)
    assert "α is not given" in result.reasons["smoothness"]
    assert "ω is not given" in result.reasons["delta_omega"]
    assert "no disturbance" in result.reasons["t1_s"]
    assert "no recording" in result.reasons["cpgu"]
    assert "not given" in result.reasons["optimum_share"]


def test_what_takes_the_body_is_undefined_until_the_body_is_given():
    register(peak_force.peak_force)
    register(peak_force.peak_force_in_weights)
    bare = measure(TIME, HEIGHT, rest_length_m=1.0, force_n=FORCE)
    assert bare.peak_force_n == pytest.approx(4.0, rel=0.01)
    assert math.isnan(bare.peak_force_in_weights)
    assert bare.reasons["peak_force_in_weights"] == "it takes the body, which is not given"
    body = Hopper(mass_kg=0.2)
    result = measure(TIME, HEIGHT, rest_length_m=1.0, force_n=FORCE, body=body)
    assert result.peak_force_in_weights == pytest.approx(bare.peak_force_n / body.weight_n)
    assert result.reasons["optimum_share"] == "it has no value for such a gait of this body"


def test_the_efficiency_of_a_gait_that_settles_is_its_cost_of_transport(settled):
    efficiency = settled.efficiency
    assert efficiency.settled
    assert efficiency.cot_inverse == pytest.approx(settled.cot_inverse)
    assert efficiency.cot_inverse_total == pytest.approx(settled.cot_inverse_total)


def test_a_gait_that_does_not_settle_has_an_efficiency_that_is_marked(wandering):
    efficiency = wandering.efficiency
    assert math.isnan(wandering.cot_inverse)
    assert not efficiency.settled
    assert efficiency.start_s >= 10.0
    assert efficiency.cot_inverse > 0.0
    assert efficiency.cot_inverse == pytest.approx(efficiency.climb_flight_m / efficiency.work_j)


def test_work_that_was_recorded_is_not_computed_from_the_force(settled):
    """Half of the energy that the force's work would have been: twice the efficiency."""
    work = np.concatenate(
        [[0.0], np.cumsum(np.abs(0.5 * (FORCE[1:] + FORCE[:-1]) * np.diff(HEIGHT)))]
    )
    result = measure(TIME, HEIGHT, rest_length_m=1.0, phase_rad=6.0 * TIME, work_j=0.5 * work)
    assert result.cot_inverse == pytest.approx(2.0 * settled.cot_inverse)
    assert result.reasons["smoothness"] == "the actuator force was not recorded"


def counted():
    """Running totals of work and climbs, ten times what the samples tell."""
    climb = np.concatenate([[0.0], np.cumsum(np.maximum(np.diff(HEIGHT), 0.0))])
    flight = np.concatenate([[0.0], np.cumsum(np.maximum(np.diff(np.maximum(HEIGHT, 1.0)), 0.0))])
    return {"work_j": 10.0 * TIME, "climb_m": 10.0 * climb, "climb_flight_m": 10.0 * flight}


def test_running_totals_go_before_what_samples_tell_and_that_is_said(settled):
    totals = counted()
    result = measure(**recording({**COLUMNS, **totals}), rest_length_m=1.0)
    assert result.efficiency.climb_flight_m == pytest.approx(10 * settled.efficiency.climb_flight_m)
    assert result.efficiency.climb_m == pytest.approx(10 * settled.efficiency.climb_m)
    hops = result.efficiency
    assert hops.work_j == pytest.approx(10.0 * (hops.end_s - hops.start_s), rel=2e-3)
    assert "work_j, climb_flight_m and climb_m: the recording's own" in result.notes[0]
    assert settled.notes == ()


@pytest.mark.parametrize("name", ["work_j", "climb_m", "climb_flight_m"])
def test_a_running_total_that_starts_again_is_refused(name):
    total = counted()[name]
    total[1200:] -= total[1200]
    with pytest.raises(TegotaeError, match=f"{name} falls from .* to 0 at sample 1200"):
        measure(TIME, HEIGHT, rest_length_m=1.0, **{name: total})


def test_net_work_may_fall_since_a_brake_takes_it_back():
    net = np.concatenate([[0.0], np.cumsum((FORCE[1:] + 0.2) * np.diff(HEIGHT))])
    assert (np.diff(net) < 0.0).any()
    assert measure(TIME, HEIGHT, rest_length_m=1.0, work_j=net).efficiency is not None


@pytest.mark.parametrize("name", ["height_m", "force_n", "phase_rad", "work_j", "ground_m"])
def test_one_sample_without_any_sense_is_refused(name):
    columns = {**COLUMNS, "phase_rad": TIME, "work_j": TIME, "ground_m": 0.0 * TIME}
    columns[name] = columns[name].copy()
    columns[name][700] = 1e308
    with pytest.raises(TegotaeError, match=rf"{name} is 1e\+308 at sample 700"):
        measure(**recording(columns), rest_length_m=1.0)


def test_a_height_that_leaps_by_a_leg_and_back_is_refused():
    height = HEIGHT.copy()
    height[700] = 7.0
    with pytest.raises(TegotaeError, match=r"height_m is 7 at sample 700 .* rest length of 1 m"):
        measure(TIME, height, rest_length_m=1.0)


@pytest.mark.parametrize("with_phase", [False, True])
def test_the_picture_shows_what_was_measured(settled, wandering, with_phase):
    measured = settled if with_phase else wandering
    figure = recording_figure(measured, rest_length_m=1.0, note="walk")
    assert len(figure.axes) == (5 if with_phase else 4)
    if not with_phase:  # each apex over the one before, about the diagonal
        section = figure.axes[2]
        assert section.get_xlim() == section.get_ylim()
        assert section.get_box_aspect() == 1.0
    tables = recording_tables(measured)
    assert set(tables) == {"frames", "hops", "spectrum"}
    assert len(tables["hops"]["apex_height_m"]) == len(measured.hops.time_s)
    peak = np.argmax(tables["spectrum"]["power_share"])
    if with_phase:
        assert tables["spectrum"]["angular_frequency_rad_per_s"][peak] == pytest.approx(6, abs=0.1)


@pytest.mark.thorough
def test_a_simulations_file_measures_as_the_simulation_itself(tmp_path, capsys):
    """`simulate --csv`, then `measure`: the numbers of the engine's own summary."""
    path, picture = tmp_path / "hop.csv", tmp_path / "hop.png"
    arguments = ("paper", "--omega", "5", "--sigma", "2.753", "--duration-s", "20")
    assert main(["simulate", *arguments, "--csv", str(path)]) == 0
    previous = path.read_bytes()
    capsys.readouterr()
    measured = ["measure", str(path), "--preset", "paper", "--omega", "5", "--plot", str(picture)]
    assert main([*measured, "--json"]) == 0
    result = json.loads(capsys.readouterr().out)
    assert picture.stat().st_size > 0
    assert path.read_bytes() == previous  # not by the figure's tables
    inside = Rollout(
        controller=preset("paper").controller("sector"),
        timing=Timing(duration_s=20.0),
        summary=GaitSummary(),
    ).run([2.753], Scenario(omega=5.0))
    assert result["regime"] == "limit cycle"
    assert result["t0_s"] == pytest.approx(
        inside.t0_s[0], abs=0.011
    )  # its first sample is 10 ms in
    assert result["limit_cycle_period"] == inside.limit_cycle_period[0]
    for name, relative in {
        "cot_inverse": 0.01,
        "cot_inverse_total": 0.01,
        "delta_omega": 0.01,
        "delta_w": 0.01,
        "w_peak": 1e-3,
        "a_peak": 1e-3,
        "hop_rate": 1e-3,
        "smoothness": 0.05,
    }.items():
        assert result[name] == pytest.approx(getattr(inside, name)[0], rel=relative), name
    assert 0.9 < result["optimum_share"] < 1.0
    assert result["reasons"].keys() == {"t1_s", "cpgu", "feedback_while_pushing"}


def test_the_command_says_what_it_is_and_why_the_rest_is_undefined(tmp_path, capsys):
    path = recording_file(tmp_path, {"time_s": TIME, "height_m": HEIGHT}, ".csv")
    assert main(["measure", str(path), "--rest-length-m", "1", "--mass-kg", "2"]) == 0
    message = capsys.readouterr().out
    assert message.startswith("limit cycle; 19 hops in 20.00 s")
    assert "neither the actuator force nor its work was recorded" in message


@pytest.mark.parametrize(
    ("columns", "options", "says"),
    [
        ({"time_s": [0]}, [], r"no column is the height \(height_m/cm/mm\) among 'time_s'"),
        (
            {"height_m": [0]},
            [],
            "no column is the time .*: --columns time=COLUMN.* or .*: --rate",
        ),
        ({"time_s": [0], "height_m": [0], "y_mm": [0]}, [], "may both be the height; say which"),
        ({"time_s": [0], "z": [0]}, ["height=z"], r"column 'z' is without a unit; .*height=z\[m\]"),
        ({"time_s": [0], "z": [0]}, ["height=z[inch]"], "column 'z' is in 'inch'"),
        ({"time_s": [0], "z": [0]}, ["high=z[m]"], "no quantity is called 'high'"),
        ({"time_s": [0], "z": [0]}, ["height=zz[m]"], "no column is called 'zz'; did you mean z"),
        ({"time_s": [0], "z": [0]}, ["height"], "write QUANTITY=COLUMN"),
        (
            {"time_s": [0], "z": [0]},
            ["height=z[m]", "ground=z[m]"],
            "column 'z' is named for two quantities, height and ground",
        ),
        (
            {"time_s": [0], "z": [0], "y": [0]},
            ["height=z[m]", "height=y[m]"],
            "the height is named twice, 'z' and 'y'",
        ),
        ({"time_s": ["0"], "height_m": ["low"]}, [], "height_m is 'low' in row 0"),
        (
            {"time_s": [0, 1, 2], "height_m": [0, 1]},
            [],
            r"3 in 'time_s', 2 in 'height_m' samples; all must be of one length",
        ),
        ({"time_s": [], "height_m": []}, [], "the recording holds 0 samples; .* at least 3"),
    ],
)
def test_columns_that_make_no_recording_are_refused_in_one_line(columns, options, says):
    refused(says, recording, columns, options)


def test_a_rate_beside_times_is_refused():
    with pytest.raises(TegotaeError, match="'time_s' holds the times"):
        recording({"time_s": TIME, "height_m": HEIGHT}, rate_hz=100.0)


def test_times_that_go_back_cannot_be_resampled():
    with pytest.raises(TegotaeError, match="do not increase"):
        resampled(recording({"time_s": TIME[::-1], "height_m": HEIGHT}), 100.0)


@pytest.mark.parametrize("ending", [".csv", ".npz", ".parquet"])
def test_a_file_that_is_none_of_its_kind_is_refused_in_one_line(tmp_path, ending):
    if ending == ".parquet":
        pytest.importorskip("pyarrow")
    path = tmp_path / f"walk{ending}"
    path.write_bytes(b"\x00\xffno recording")
    refused("is no recording", read_columns, path)


def test_objects_in_a_file_of_numpy_are_not_unpickled(tmp_path):
    path = tmp_path / "walk.npz"
    np.savez(path, height_m=np.array([{"a": 1}], dtype=object))
    refused("plain arrays", read_columns, path)


@pytest.mark.parametrize(
    ("name", "says"), [("walk.mat", "must end in .csv, .npz, .parquet"), ("no.csv", "no file")]
)
def test_another_file_is_refused(tmp_path, name, says):
    refused(says, read_columns, tmp_path / name)


def test_two_columns_of_one_name_are_refused(tmp_path):
    path = tmp_path / "walk.csv"
    path.write_text("time_s,height_m,height_m\n0,1,2\n")
    refused("2 columns are called 'height_m'", read_columns, path)


def test_heights_of_several_legs_at_once_are_refused_with_their_shape(tmp_path):
    path = tmp_path / "walk.npz"
    np.savez(path, time_s=TIME, height_m=np.stack([HEIGHT, HEIGHT]))
    refused(r"height_m has the shape \(2, \d+\)", read_columns, path)


def test_parquet_without_its_package_names_the_extra(tmp_path, monkeypatch):
    path = tmp_path / "walk.parquet"
    path.write_bytes(b"")
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    refused(r"pip install 'tegotae\[study\]'", read_columns, path)


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ((), "set rest_length_m"),
        (("--rest-length-m", "-1"), "rest_length_m is -1"),
        (("--rest-length-m", "1e308"), "rest_length_m is 1e+308; it must be at most"),
        (("--rest-length-m", "1", "--omega", "0"), "omega is 0; it must be greater than 0"),
        (("--rest-length-m", "1", "--omega", "1e308"), "omega is 1e+308; it must be at most"),
        (("--rest-length-m", "1", "--max-force-n", "1e308"), "max_force_n is 1e+308"),
        (("--rest-length-m", "1", "--mass-kg", "1e308"), "mass is 1e+308; it must be at most"),
        (("--rest-length-m", "1", "--preset", "papers"), "no preset is called 'papers'"),
        (("--rest-length-m", "1", "--disturbed-at", "90"), "disturbed_at_s lies 90 s"),
        (
            ("--rest-length-m", "1", "--work", "much"),
            "--work is 'much'; write --work {absolute,positive,net}",
        ),
        (("--rest-length-m", "1", "--plot", "walk.txtt"), "cannot write a figure"),
        (("--rest-length-m", "1", "--rate", "50"), "holds the times"),
        (("--rest-length-m", "1", "--mass-kg", "-1"), "mass is -1; it must be greater than 0"),
        (("--rest-length-m", "1", "--mass-kg", "1", "--gravity-m-per-s2", "nan"), "gravity is nan"),
        (("--rest-length-m", "1", "--gravity-m-per-s2", "3.7"), "set mass_kg"),
        (
            ("--preset", "paper", "--rest-length-m", "0.5"),
            "rest_length_m is 0.5, and the preset paper has 1",
        ),
        (("--preset", "paper", "--mass-kg", "2"), "mass_kg is 2, and the preset paper has 0.1"),
    ],
)
def test_options_that_cannot_be_used_are_refused_in_one_line(
    tmp_path, one_line_error, options, says
):
    path = recording_file(tmp_path, COLUMNS, ".csv")
    assert says in one_line_error("measure", str(path), *options)
