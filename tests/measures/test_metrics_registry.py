"""One file makes a metric known everywhere; what is asked for is computed, and no more."""

import dataclasses
import json

import numpy as np
import pytest

import peak_force
from refusals import refused
from research.reproduction.export import csv_of, read_study_csv
from research.reproduction.figures.study import architectures_figure
from study_tables import table
from tegotae import TegotaeError
from tegotae.cli import main
from tegotae.measures import evaluation
from tegotae.measures.check import check
from tegotae.measures.evaluation import Protocol, evaluate
from tegotae.measures.hopping import Conditions, DerivedMetric, GaitMetric
from tegotae.measures.hopping.metrics import HOPPING, derived
from tegotae.parts.bodies import Hopper
from tegotae.systems.recipe import recipe
from tegotae.systems.registry import register

SHORT = Protocol(undisturbed_s=15.0, disturbed_s=10.0, offsets=(0.0,))
PEAK, IN_WEIGHTS = peak_force.peak_force, peak_force.peak_force_in_weights


@pytest.fixture
def registered():
    """The two metrics of the user's file, for one test."""
    yield register(PEAK), register(IN_WEIGHTS)
    for metric in (PEAK, IN_WEIGHTS):
        HOPPING.forget(metric.name)


def rolled_out(monkeypatch) -> list[str]:
    """Record the rollouts that an evaluation asks for, without making them."""
    names_made: list[str] = []

    class StopHereError(Exception):
        pass

    def made_up(name):
        def rollouts(*_, **__):
            names_made.append(name)
            raise StopHereError

        return rollouts

    for name in ("disturbed", "undisturbed", "clamped"):
        monkeypatch.setattr(evaluation.EvaluatedEpisodes, name, made_up(name))
    for metric in ("cot_inverse", "optimum_share", "t1_s", "recovery_share", "cpgu"):
        with pytest.raises(StopHereError):
            evaluate(
                recipe("V-reflex-w8").controller(), [[2.0]], 8.0, protocol=SHORT, metrics=[metric]
            )
    return names_made


def test_what_no_metric_asked_for_needs_is_not_rolled_out(monkeypatch):
    assert rolled_out(monkeypatch) == [
        *("undisturbed", "undisturbed"),
        *("disturbed", "disturbed"),
        "clamped",
    ]


def test_a_users_metric_is_evaluated_beside_the_packages_own(registered):
    metrics = ["peak_force_in_weights", "cot_inverse", "peak_force_n"]
    result = evaluate(
        recipe("V-reflex-w8").controller(), [[2.0]], 8.0, protocol=SHORT, metrics=metrics
    )
    assert list(result.episodes) == ["cot_inverse", "peak_force_n", "peak_force_in_weights"]
    force_n = result.episodes["peak_force_n"][0, 0]
    assert 1.0 < force_n <= Hopper().max_force_n
    weights = result.summary()["peak_force_in_weights"].mean
    assert weights == pytest.approx(force_n / Hopper().weight_n)


def test_a_users_metric_is_in_tables_and_figures(registered):
    made_up = table(peak_force_n=np.linspace(1.0, 2.0, 5))
    assert "peak_force_n" in made_up.metrics
    panels = {axes.get_ylabel() for axes in architectures_figure(made_up).axes}
    assert r"$F_\mathrm{a,max}$ [N]" in panels


def test_a_table_of_a_metric_that_is_not_registered_here_stays_readable(registered, tmp_path):
    path = tmp_path / "table.csv"
    path.write_text(csv_of(table(peak_force_n=np.linspace(1.0, 2.0, 5))), encoding="utf-8")
    HOPPING.forget(PEAK.name)
    HOPPING.forget(IN_WEIGHTS.name)
    again = read_study_csv(path)
    assert again["peak_force_n"][0] == 1.0
    assert csv_of(again) == path.read_text(encoding="utf-8")
    assert PEAK.name not in {metric.name for metric in again.metrics_shown("figure")}


def test_the_command_line_takes_a_users_metric_from_its_file(monkeypatch, capsys):
    def made_up(controller, weights, omega_t, body, protocol, metrics, **_):
        names = [getattr(metric, "name", metric) for metric in metrics]
        episodes = {name: np.array([[2.5]]) for name in names}
        return evaluation.Evaluation(protocol, np.array([8.0]), episodes)

    monkeypatch.setattr("tegotae.api.hopping.evaluate", made_up)
    monkeypatch.setattr("tegotae.training.collection.best_gain", lambda *_: (2.0, 0.4))
    try:
        arguments = ["evaluate", "V-reflex-w8", "--metric", "cot_inverse", "peak_force:peak_force"]
        assert main(arguments) == 0
        message = capsys.readouterr().out
        assert "peak force [N]" in message
        assert "CoT⁻¹ [m/J]" in message
        assert "T0 [s]" not in message
        assert main([*arguments, "--json"]) == 0
        (document,) = json.loads(capsys.readouterr().out)["rows"]
        assert document["peak_force_n"] == 2.5
    finally:
        for metric in (PEAK, IN_WEIGHTS):  # all of the file's
            HOPPING.forget(metric.name)


def test_names_of_the_package_and_of_other_files_are_taken(registered):
    with pytest.raises(TegotaeError, match="'cpgu' is taken by the package"):
        register(dataclasses.replace(PEAK, name="cpgu"))
    with pytest.raises(TegotaeError, match="two metrics named 'peak_force_n'"):
        register(dataclasses.replace(PEAK, compute=lambda episode: episode.start_s))
    again = dataclasses.replace(PEAK, label="peak")  # its own file, run anew
    assert register(again) in HOPPING.metrics()
    assert PEAK not in HOPPING.metrics()


def test_a_metric_derived_from_what_is_not_there_is_refused():
    refused("no metric of hopping is called 'peak_force_n'", register, IN_WEIGHTS)


def test_a_metric_that_is_not_registered_is_not_evaluated():
    with pytest.raises(TegotaeError, match="no metric of hopping is called 'peak_force_n'"):
        evaluate(recipe("V-reflex-w8").controller(), [[2.0]], 8.0, metrics=[PEAK])


def test_metrics_follow_from_others_of_the_same_episodes():
    values = {
        "cot_inverse": np.array([0.6, 0.6, 0.0]),
        "hop_rate": np.array([4.0, np.nan, np.nan]),
        "limit_cycle_period": np.array([1.0, 1.0, np.nan]),
    }
    shares = derived(values, Conditions(Hopper()))["optimum_share"]
    assert shares[0] == pytest.approx(0.6 / 1.212, abs=1e-3)
    assert np.isnan(shares[1:]).all()
    for body in (Hopper(mass_kg=0.11), None):
        assert np.isnan(derived(values, Conditions(body))["optimum_share"]).all()
    assert derived({"cot_inverse": values["cot_inverse"]}, Conditions(Hopper())) == {}


def test_the_built_in_metrics_say_what_they_are():
    assert [metric.name for metric in HOPPING.built_in][:2] == ["cot_inverse", "optimum_share"]
    assert len({metric.label for metric in HOPPING.built_in}) == len(HOPPING.built_in)


@pytest.mark.parametrize("name", ["limit_cycle_share", "optimum_share", "cpgu", "t0_s"])
def test_metrics_of_each_kind_pass_the_check(name):
    check(HOPPING.find(name))


def test_a_users_metric_passes_the_check(registered):
    check(PEAK)
    check(IN_WEIGHTS)


@pytest.mark.parametrize(
    ("changed", "says"),
    [
        ({"name": "peak force"}, "it must be the name of a table's column"),
        ({"about": "two\nlines"}, "it must be one line of text"),
        ({"label": ""}, "it must be one line of text"),
        ({"math": "$x$$"}, "a text that matplotlib can draw"),
        ({"range": (1.0, 0.0)}, "the least first"),
        ({"range": (0.0, 0.1)}, "outside of the range"),
        ({"more_is_better": "yes"}, "it must be True, False, or None"),
        ({"shown": ("poster",)}, "it must be of .'table', 'figure', 'report'"),
        (
            {"channels": ("force",)},
            "channels that it declares .* 'actuator_force_n' was not recorded",
        ),
        ({"channels": "force"}, "it must be a tuple of names"),
        ({"channels": ()}, "'actuator_force_n' was not recorded"),
        ({"compute": lambda episode: 3.0}, "it must have the shape of the lanes"),
        ({"compute": lambda episode: episode.hops.time_s}, r"has shape \(700, 6\)"),
        (
            {"compute": lambda episode: episode.start_s + episode.start_s.mean()},
            "lets one lane change another",
        ),
        ({"compute": lambda episode: 1 / 0}, "raised ZeroDivisionError"),
    ],
    ids=lambda changed: next(iter(changed)) if isinstance(changed, dict) else None,
)
def test_the_check_says_what_is_wrong_with_a_metric(changed, says):
    refused(says, lambda: check(dataclasses.replace(PEAK, **changed)))


def test_the_check_refuses_what_is_no_metric():
    refused("GaitMetric is a class; check an instance", check, GaitMetric)
    refused("is no Term or Oscillator or Body or Metric", lambda: check(recipe("ART")))
    wrong = DerivedMetric(
        name="half_t0",
        label="half",
        about="half of T0",
        more_is_better=False,
        of=("t0",),
        compute=lambda values, conditions: values["t0"] / 2.0,
    )
    refused("no metric of hopping is called 't0'; did you mean", check, wrong)
