"""CSV files of loggers and spreadsheets are read, or refused with line, cause and cure."""

import numpy as np
import pandas as pd
import pytest

from refusals import refused
from tegotae.cli import main
from tegotae.measures.recordings import read_columns, read_recording, recording

TIME = np.arange(400) * 0.005
LOG = pd.DataFrame({"time_s": TIME, "height_m": 1.0 + 0.1 * np.sin(6.0 * TIME), "force_n": TIME})
TEXT = LOG.to_csv(index=False)
NAMES, ROWS = TEXT.split("\n", 1)
STAMPS = pd.Timestamp("2026-05-04 09:30") + pd.to_timedelta(TIME, unit="s")
SPARSE = LOG.where(LOG.index.to_series() % 2 == 0).assign(time_s=TIME)

READ = {
    "as it is": TEXT.encode(),
    "semicolons and decimal commas": LOG.to_csv(index=False, sep=";", decimal=",").encode("cp1252"),
    "tabs": LOG.to_csv(index=False, sep="\t").encode(),
    "a preamble": f"Recording of leg 2\nRate, 200 Hz\n\n{TEXT}".encode(),
    "a preamble in the code page of Windows": f"Länge;m\n{TEXT}".encode("cp1252"),
    "a row of units": f"time,height,force\ns,m,N\n{ROWS}".encode(),
    "a row of units in brackets": f"time,height,force\n[s],[m],[N]\n{ROWS}".encode(),
    "a row of units that the names have": f"{NAMES}\ns,m,N\n{ROWS}".encode(),
    "UTF-16": TEXT.encode("utf-16"),
    "UTF-16 without a mark": TEXT.encode("utf-16-le"),
    "UTF-8 with a mark": TEXT.encode("utf-8-sig"),
    "times of day": LOG.assign(time_s=STAMPS).to_csv(index=False).encode(),
    "times of day in a zone": LOG.assign(time_s=STAMPS.tz_localize("Asia/Tokyo"))
    .to_csv(index=False)
    .replace("time_s", "time")
    .encode(),
    "a force in gf": LOG.assign(force_n=LOG.force_n / 9.80665e-3)
    .to_csv(index=False)
    .replace("force_n", "force [gf]")
    .encode(),
    "a force in kgf": LOG.assign(force_n=LOG.force_n / 9.80665)
    .to_csv(index=False)
    .replace("force_n", "force_kgf")
    .encode(),
}


@pytest.mark.parametrize("kind", READ)
def test_a_log_of_any_format_is_read_as_the_same_recording(kind, tmp_path):
    path = tmp_path / "log.csv"
    path.write_bytes(READ[kind])
    read = recording(read_columns(path))
    for name in LOG:
        np.testing.assert_allclose(read[name], LOG[name], atol=1e-9)


def test_rows_without_a_value_are_left_out_where_the_others_are_uniform(tmp_path, capsys):
    path = tmp_path / "log.csv"
    SPARSE.to_csv(path, index=False)
    read = read_recording(path)
    np.testing.assert_allclose(read.time_s, TIME[::2])
    np.testing.assert_allclose(read.height_m, LOG.height_m[::2])
    assert "200 of 400 samples have an empty cell and are left out" in capsys.readouterr().err


def test_columns_of_two_rates_are_resampled_each_over_its_own_samples(tmp_path):
    path = tmp_path / "log.csv"
    rows = np.arange(400)
    log = LOG.assign(
        height_m=LOG.height_m.where(rows % 2 == 0), force_n=LOG.force_n.where(rows % 3 == 1)
    )
    log.to_csv(path, index=False)
    read = read_recording(path, resample_hz=150.0)
    np.testing.assert_allclose(read.force_n, read.time_s, atol=1e-9)
    np.testing.assert_allclose(read.height_m, 1.0 + 0.1 * np.sin(6.0 * read.time_s), atol=5e-4)


def test_a_minus_turns_a_column_that_points_down():
    table = {"time_s": TIME, "z": -LOG.height_m.to_numpy()}
    np.testing.assert_allclose(recording(table, ["height=-z[m]"]).height_m, LOG.height_m)


def test_a_column_is_named_without_the_unit_of_the_row_below(tmp_path):
    path = tmp_path / "log.csv"
    rows = LOG.assign(height_m=1e3 * LOG.height_m).to_csv(index=False, header=False)
    path.write_text(f"t,com,motor\ns,mm,N\n{rows}")
    read = recording(read_columns(path), ["height=com", "force=motor"])
    np.testing.assert_allclose(read.height_m, LOG.height_m)
    np.testing.assert_allclose(read.force_n, LOG.force_n)


LINES = TEXT.split("\n")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (ROWS, "line 1 holds numbers already; write a line of names with units above it"),
        (
            "\n".join([*LINES[:9], "0.04,1.0", *LINES[9:]]),
            "line 10 has 2 cells, .* the others .* 3",
        ),
        ("\n".join(["time_s,height_m", *LINES[1:]]), "line 1, the names, has 2 cells, .* have 3"),
        (TEXT.replace(LINES[5], "0.02,high,0"), "height_m is 'high' in line 6, .* no number; corr"),
        (f"{NAMES}\ns,m,m\n{ROWS}", "line 2 says that 'force_n' is in 'm', .* ends in 'n'; corr"),
        (
            TEXT.replace(",", ";").replace(LINES[5].replace(",", ";"), "0,02;1;0"),
            "line 6 has decimal commas, and line 2 has '0.0'; write all numbers with one",
        ),
        ("time_s,height_m\n", "it has no rows"),
        (
            LOG.assign(
                time_s=[*STAMPS[:7].astype(str), "half past nine", *STAMPS[8:].astype(str)]
            ).to_csv(index=False),
            "time_s is 'half past nine' in line 9, which is no time by ISO 8601",
        ),
    ],
)
def test_a_log_that_is_not_read_is_refused_with_line_cause_and_cure(text, message, tmp_path):
    path = tmp_path / "log.csv"
    path.write_text(text)
    refused(message, lambda: recording(read_columns(path)))


def altered(begin, end, value):
    height = LOG.height_m.to_numpy().copy()
    height[begin:end] = height[begin] if value is None else value
    return {"height_m": height}


@pytest.mark.parametrize(
    ("columns", "options", "message"),
    [
        (altered(200, 203, 0.0), "", "height_m goes from 0.969 to 0 at sample 200 (1 s)"),
        (altered(200, 205, 9.999), "", "to 9.999 at sample 200 (1 s)"),
        (altered(200, 300, None), "", "stays at 0.9721 from sample 200 to 299"),
        (altered(260, 400, None), "", "stays at 1.1 from sample 260 to 399"),
        ({"height_m": -LOG.height_m}, "", "it points downwards"),
        ({"force_n": 408.0 + LOG.force_n}, "--max-force-n 4", "102 times the actuator's largest"),
        ({"force_n": 408.0 + LOG.force_n}, "--mass-kg 0.1", "times the weight of 0.981 N"),
    ],
)
def test_what_no_body_does_is_not_measured(columns, options, message, tmp_path, one_line_error):
    path = tmp_path / "log.csv"
    LOG.assign(**columns).to_csv(path, index=False)
    assert message in one_line_error("measure", str(path), "--rest-length-m", "1", *options.split())


@pytest.mark.parametrize("resample", [(), ("--resample", "200")])
def test_a_hole_is_not_measured_over(resample, tmp_path, one_line_error):
    path = tmp_path / "log.csv"
    LOG.drop(index=range(200, 300)).to_csv(path, index=False)
    message = one_line_error("measure", str(path), "--rest-length-m", "1", *resample)
    assert "no sample for 0.505 s after sample 199 (0.995 s)" in message


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ("--rest-length-m 3", "the height moves by 0.2 m and never exceeds the rest length of 3 m"),
        ("--rest-length-m 1", "the force reaches 2 N; --mass-kg or --max-force-n checks its unit"),
    ],
)
def test_what_is_odd_is_named(options, message, tmp_path, capsys):
    path = tmp_path / "log.csv"
    LOG.to_csv(path, index=False)
    if "3" in options:  # a tenth of the rest length
        LOG.assign(height_m=1.0 + 2.0 * (LOG.height_m - 1.0)).to_csv(path, index=False)
        message = message.replace("0.2 m", "0.4 m")
    assert main(["measure", str(path), *options.split()]) == 0
    assert message in " ".join(capsys.readouterr().out.split())
