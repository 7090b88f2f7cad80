"""Identify a controller from a log: the body behind a recording, and the needs of the recording."""

import importlib.util

import numpy as np
import pandas as pd
import pytest
from scipy.stats import t as student

import tegotae as tg
from places import ROOT
from refusals import refused
from tegotae import TegotaeError
from tegotae.api.experiments import with_parts
from tegotae.cli import main
from tegotae.systems.resolve import experiment_of
from tegotae_robots import identification
from tegotae_robots.api import identifying

TRUTH = {
    "mass_kg": 1.7,
    "stiffness_n_per_m": 310.0,
    "damping_ns_per_m": 5.5,
    "rest_length_m": 0.42,
    "max_force_n": 62.0,
}


def device(**numbers):
    """A leg of plain Python, which is no part of the package."""
    spec = importlib.util.spec_from_file_location(
        "hidden_leg", ROOT / "research" / "robots" / "hidden_leg.py"
    )
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module.HiddenLeg(**numbers), module.TICK_S


@pytest.fixture(scope="module")
def log(tmp_path_factory):
    file = tmp_path_factory.mktemp("log") / "log.csv"
    device()[0].log(file, 60.0)
    return file


@pytest.fixture(scope="module")
def identified(log):
    return tg.robots.identify(str(log))


def test_the_numbers_of_a_leg_are_found_within_five_percent_from_three_percent_noise(identified):
    result = identified.raw
    assert {n: result.values[n] for n in TRUTH} == pytest.approx(TRUTH, rel=0.05)
    for name, value in result.values.items():
        assert result.low[name] < value < result.high[name]
    assert result.noise[0] == pytest.approx(0.03 * 0.42, rel=0.1)
    assert result.noise[1] == pytest.approx(0.03 * 1.7 * 9.81, rel=0.1)


def test_hops_that_were_not_fitted_are_predicted_to_the_noise(identified):
    errors = identified.raw.prediction.set_index("hops ahead")
    assert (errors.loc[1] < 1.3).all()
    assert (errors < 3.0).all(axis=None)


def test_a_body_from_a_log_is_trained_for_exported_and_driven(identified, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    identified.save("leg.toml")
    words = "--body leg.toml --height-m 0.5 --hold --generations 2 --population 8 --seeds 1"
    words += " --duration-s 4 --settle-s 2 --budget 20 --out runs"
    assert main(["train", "AR-rF-reflex-w14", *words.split()]) == 0
    (file,) = (tmp_path / "runs").glob("*-seed0.json")
    assert main(["export", "c", str(file), "--out", "c"]) == 0
    assert (tmp_path / "c" / "tegotae.c").exists()
    live = tg.robots.export_native(str(file)).live()
    leg, tick_s = device()
    limit = identified.raw.values["max_force_n"]
    heights = []
    for _ in range(400):
        height, load = leg.sense()
        force = float(live.step({"spring_force": max(load, 0.0)}, tick_s)[0])
        assert 0.0 <= force <= limit
        leg.push(force / limit)
        heights.append(height)
    assert min(heights) > 0.0


@pytest.fixture
def leg(identified, tmp_path):
    identified.save(tmp_path / "leg.toml")
    return str(tmp_path / "leg.toml")


@pytest.mark.parametrize("name", ["AR-rF-reflex-w14", "V-reflex-w14"])
def test_pushes_and_gains_are_those_of_the_bodys_weight(name, leg):
    ours, second = (with_parts(experiment_of(name), body=body) for body in (None, leg))
    weights = second.body.weight_n / ours.body.weight_n
    assert weights == pytest.approx(17.0, rel=0.01)
    assert second.controller.actuation.newtons_per_feedback == pytest.approx(weights)
    np.testing.assert_allclose(second.gains, ours.gains / weights)


@pytest.mark.parametrize(
    ("name", "short"),
    [
        ("AR-rF-reflex-w14", {"generations": 1, "algorithm": {"population": 2}}),
        ("V-reflex-w2", {}),
    ],
)
def test_a_training_whose_result_does_not_hop_says_so_and_what_to_try(name, short, leg, tmp_path):
    timing = {"height_m": 0.5, "duration_s": 14.0, "seeds": 1, "out": tmp_path / "runs"}
    trained = tg.train(name, body=leg, **timing, **short)
    (message,) = (note for note in trained.notes if "do not hop" in note)
    assert message.startswith(
        "1 of 1 do not hop: CoT⁻¹ is 0 where they end. The body weighs 16.7 N"
    )
    assert "Try in this order: a name with ω near" in message


@pytest.mark.thorough
def test_the_leg_of_the_guide_hops_when_it_is_trained(leg, tmp_path):
    out = tmp_path / "runs"
    trained = tg.train("AR-rF-reflex-w14", body=leg, height_m=0.5, hold=True, seeds=1, out=out)
    assert not [note for note in trained.notes if "hop" in note]
    assert tg.load(str(trained.paths[0])).simulate().to_dict()["hops"] >= 20


def changed(**columns):
    """A hop a second for a minute, and what is wrong with it."""
    time_s = np.arange(12000) * 0.005
    wave = np.sin(2.0 * np.pi * time_s)
    good = {
        "time_s": time_s,
        "height_m": 0.4 + 0.1 * wave,
        "spring_force_n": 40.0 * np.maximum(-wave, 0.0),
        "command_share": (wave < -0.5) * 0.5,
    }
    return pd.DataFrame(good | columns)


TIME = np.arange(12000) * 0.005
NAN = np.where(np.arange(12000) == 7, np.nan, 0.4)


@pytest.mark.parametrize(
    ("samples", "message"),
    [
        (changed().head(400), "too short: it holds 0 whole hops"),
        (changed(spring_force_n=np.zeros(12000)), "no stance"),
        (changed(spring_force_n=np.full(12000, 16.0)), "no flight"),
        (changed(command_share=np.full(12000, 0.3)), "the command is constant at 0.3"),
        (changed(command_share=np.linspace(0.0, 100.0, 12000)), "a share of the actuator's"),
        (changed(time_s=TIME + 0.003 * (np.arange(12000) % 2)), "the time steps are uneven"),
        (changed(height_m=NAN), "height_m is nan at sample 7"),
        (changed().drop(columns="command_share"), "no column is the command"),
        (changed(spring_force_n=-40.0 * np.minimum(np.sin(7 * TIME), 0.0)), "not that of such a"),
    ],
)
def test_what_a_recording_lacks_is_said_in_one_line_and_nothing_written(
    samples, message, tmp_path, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    samples.to_csv("log.csv", index=False)
    refused(message, tg.robots.identify, "log.csv")
    assert [path.name for path in tmp_path.iterdir()] == ["log.csv"]


@pytest.fixture(scope="module")
def table(log):
    return pd.read_csv(log)


def held(column, period):
    rows = np.arange(len(column))
    return column.to_numpy()[(rows // period) * period]


def at_rate(table, name, hz):
    rows = np.searchsorted(table.time_s, np.floor(table.time_s * hz) / hz)
    return table[name].to_numpy()[rows]


def between(table, begin_s, end_s, value):
    time_s = table.time_s.to_numpy()
    return np.where((begin_s <= time_s) & (time_s < end_s), value, table.height_m.to_numpy())


DAMAGED = {
    "a command held for 20 samples": (
        lambda t: {"command_share": held(t.command_share, 20)},
        "below zero: no hopper explains|times the noise",
    ),
    "a load cell with an offset of 2 N": (
        lambda t: {"spring_force_n": t.spring_force_n + 2.0},
        r"the load is 1\.99 N in flight, .* where it must be 0",
    ),
    "a load cell that drifts by 2 N": (
        lambda t: {"spring_force_n": t.spring_force_n + np.linspace(-1.0, 1.0, len(t))},
        "N in flight, .* take the offset or drift",
    ),
    "a load cell at 80 Hz": (
        lambda t: {"spring_force_n": at_rate(t, "spring_force_n", 80)},
        "spring_force_n repeats its last value .* about 80 Hz in a log of 200 Hz",
    ),
    "a height at 50 Hz": (
        lambda t: {"height_m": at_rate(t, "height_m", 50)},
        "height_m repeats its last value .* about 50 Hz in a log of 200 Hz",
    ),
    "a load in grams": (
        lambda t: {"spring_force_n": t.spring_force_n * 101.97},
        r"more than a stone of its size .* spring_force=COLUMN\[gf\]",
    ),
    "a height that points down": (
        lambda t: {"height_m": -t.height_m},
        r"points downwards.*height=-COLUMN\[UNIT\]",
    ),
    "zeros for five samples": (
        lambda t: {"height_m": between(t, 30.0, 30.024, 0.0)},
        r"height_m goes from 0\.\d+ to 0 at sample 6000 \(30 s\)",
    ),
    "nines for five samples": (
        lambda t: {"height_m": between(t, 30.0, 30.024, 9.999)},
        r"height_m goes from 0\.\d+ to 9.999 at sample 6000",
    ),
    "a height that is frozen for a second": (
        lambda t: {"height_m": between(t, 30.0, 31.0, t.height_m[6000])},
        r"from sample 6000 to 6199 \(30 to 31 s\) .* the sensor was frozen",
    ),
    "time stamps that come twice": (
        lambda t: {"time_s": t.time_s.to_numpy()[np.maximum(0, t.index - (t.index % 50 == 0))]},
        "the times do not increase: 0.245 s at sample 49, and 0.245 s after it",
    ),
}


@pytest.mark.parametrize("kind", DAMAGED)
def test_a_damaged_log_is_refused_with_its_cause_and_no_body_is_written(
    kind, table, tmp_path, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    columns, message = DAMAGED[kind]
    table.assign(**columns(table)).to_csv("log.csv", index=False)
    refused(message, tg.robots.identify, "log.csv")


def test_a_hole_is_not_bridged_by_resampling(table, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    table[(table.time_s < 30.0) | (table.time_s >= 30.5)].to_csv("log.csv", index=False)
    for options in ({}, {"resample": 200.0}):
        with pytest.raises(TegotaeError, match=r"no sample for 0.505 s after sample 5999 \(30 s\)"):
            tg.robots.identify("log.csv", **options)


def fit(**numbers):
    """A fit that its checks find sound, but for the numbers."""
    values = {**TRUTH, "delay_s": 0.008, **numbers}
    low = {name: x - 0.001 * abs(x) for name, x in values.items()}
    high = {name: x + 0.001 * abs(x) for name, x in values.items()}
    errors = pd.DataFrame(
        [(1, 1.0, 1.0), (2, 1.0, 3.0)],
        columns=["hops ahead", "height error / noise", "load error / noise"],
    )
    return identification.Identified(values, low, high, (0.01, 0.5), (80, 20), errors)


@pytest.mark.parametrize(
    ("number", "value", "message"),
    [
        ("delay_s", -0.02, "delay from -0.02 to -0.02 s, below zero"),
        ("damping_ns_per_m", -0.4, "damping from -0.4 to -0.4 N s/m, below zero"),
        ("mass_kg", float("nan"), "does not determine mass"),
        ("mass_kg", 170.0, "170 kg to a leg of 0.42 m"),
    ],
)
def test_a_fit_that_no_hopper_has_is_refused(number, value, message):
    refused(message, lambda: identification.check_fit(fit(**{number: value})))


@pytest.mark.parametrize("column", [1, 2])
def test_a_prediction_that_errs_by_more_than_twice_the_noise_is_refused(column):
    sound = fit()
    identification.check_fit(sound)
    sound.prediction.iloc[0, column] = 2.1
    refused(r"2\.10 times ", identification.check_fit, sound)


def test_a_damping_that_noise_leaves_below_zero_is_none():
    body = identifying._body_of(fit(damping_ns_per_m=-1e-3), 9.81)
    assert body.body.damping_ns_per_m == 0.0


def test_intervals_of_few_hops_are_those_of_student(table, monkeypatch):
    """The sandwich of n hops times n / (n - 6), and the quantile of n - 6 degrees of freedom."""
    log = identification.log_of(table.head(3200))
    observation = {}
    solved = identification._solved
    monkeypatch.setattr(
        identification,
        "_solved",
        lambda s, *a, **k: (
            observation.setdefault(len(s.first), []).append(result := solved(s, *a, **k)) or result
        ),
    )
    fit = identification.identify(log)
    n = fit.hops[0]
    _, expected, shared = observation[n][2]
    inverse = np.linalg.inv(np.einsum("hri,hrj->ij", shared, shared))
    scores = np.einsum("hri,hr->hi", shared, expected)
    spread = inverse @ scores.T @ scores @ inverse
    factor = student.ppf(0.975, n - 6) * np.sqrt(n / (n - 6))
    half = 0.5 * (np.array([*fit.high.values()]) - np.array([*fit.low.values()]))
    assert n < 30
    np.testing.assert_allclose(half, factor * np.sqrt(np.diag(spread)), rtol=1e-6)


def test_the_state_that_predicts_is_not_fitted_to_the_hops_that_it_predicts(table, identified):
    """Then what is added to those heights is in the error, and nothing makes up for it."""
    log, result = identification.log_of(table), identified.raw
    middles, sides = (part[-5:] for part in identification.hop_middles(log))
    begun = identification._initial_states(log, middles, sides, 9.81)
    value, sigma, added_m = np.array([*result.values.values()]), np.array(result.noise), 0.05

    def errors(shift_m):
        height = log.height_m + np.where(np.arange(len(log.height_m)) < middles[1], 0.0, shift_m)
        shifted = log._replace(height_m=height)
        rows = identification._checked(shifted, middles, begun, value, sigma, 2, 9.81)
        return rows["height error / noise"].to_numpy() ** 2

    rise = 0.5 * (errors(added_m) + errors(-added_m)) - errors(0.0)
    np.testing.assert_allclose(rise, (added_m / sigma[0]) ** 2, rtol=1e-3)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"rate": "200"}, "rate is '200'; it must be a number"),
        ({"resample": True}, "resample is True; it must be a number"),
        ({"columns": "height=z[m]"}, r"columns is 'height=z\[m\]'; it must be a list"),
    ],
)
def test_an_option_of_another_type_is_refused(options, message):
    refused(message, tg.robots.identify, "log.csv", **options)


@pytest.mark.parametrize("subject", [3, None, b"log.csv", {"time_s": [0.0]}])
@pytest.mark.parametrize("verb", ["identify", "measure"])
def test_what_is_no_file_is_no_recording(verb, subject):
    with pytest.raises(TegotaeError, match=r"must be the name of a file, such as 'log\.csv'"):
        getattr(tg.robots if verb == "identify" else tg, verb)(subject)


def test_help_says_what_a_recording_is_in_whole_sentences(capsys):
    assert main(["identify", "--help"]) == 0
    text = " ".join(capsys.readouterr().out.split())
    assert "NAME: The log, FILE.csv, FILE.npz or FILE.parquet." in text


def test_a_body_is_not_written_over(identified, tmp_path):
    (tmp_path / "leg.toml").write_text("mine")
    refused("exists already", identified.save, tmp_path / "leg.toml")
    refused(r"must end in \.toml", identified.save, tmp_path / "leg.txt")
