"""A law trained on a user's model is swept, played again, measured, drawn and filmed."""

import csv
import dataclasses
import json
from typing import Any

import numpy as np
import pytest

pytest.importorskip("mujoco")
pytest.importorskip("gymnasium")

from refusals import refused
from tegotae import TegotaeError
from tegotae.analysis.generalisation.disturbances import disturbances_named, joined, of_lanes
from tegotae.analysis.generalisation.on_environment import EnvironmentUnderTest, _push
from tegotae.cli import main
from tegotae.envs.mujoco.env import ModelEnv
from tegotae.envs.wrapper import Pilot
from tegotae.figures import animation as filming
from tegotae.systems import controller_file
from tegotae.training.collection import read_runs
from tegotae.training.environments.experiment import EnvExperiment
from tegotae.training.environments.replay import replay
from tegotae.training.scoring import sweep_vanilla


@pytest.fixture(scope="module")
def swept(tmp_path_factory):
    """The folder of a baseline of the packaged leg."""
    out = tmp_path_factory.mktemp("swept")
    words = ["wiring", "baseline", "leg", "--frequencies", "9", "17", "--duration-s", "1"]
    assert main([*words, "--fitness", "return", "--out", str(out)]) == 0
    return out


@pytest.fixture(scope="module")
def file(swept):
    (result,) = swept.glob("*-seed0.json")
    return result


@pytest.fixture(scope="module")
def played(file):
    saved = controller_file.load(file)
    return replay(EnvExperiment.from_controller(saved), [saved.weights])[0]


def test_a_baseline_leaves_map_table_and_its_best_controller(swept, file):
    assert {"map.png", "numbers.csv"} < {path.name for path in swept.iterdir()}
    with (swept / "numbers.csv").open() as stream:
        rows = list(csv.DictReader(stream))
    assert {row["omega_rad_per_s"] for row in rows} == {"9", "17"}
    assert min(float(row["sigma_rad_per_s_n"]) for row in rows) == 0.0
    best = max(rows, key=lambda row: float(row["fitness"]))
    saved = controller_file.load(file)
    assert saved.omega == float(best["omega_rad_per_s"])
    assert saved.weights[0] == pytest.approx(float(best["sigma_rad_per_s_n"]))


def test_a_replay_repeats_the_fitness_of_the_training(file, played):
    trained = controller_file.load(file).training["best_fitness"]
    assert played.episode.fitness == pytest.approx(trained, abs=1e-4)
    assert played.numbers()["return"] == pytest.approx(trained, abs=1e-4)


def test_the_numbers_of_a_replay_are_those_of_its_episode(played):
    numbers, episode = played.numbers(), played.episode
    assert numbers["lasted"] == 1.0
    assert numbers["work_j"] == pytest.approx(float(episode["work"][-1]))
    assert 0.0 < numbers["duty"] <= 1.0


def test_a_baseline_takes_a_model_whose_only_weight_is_the_gain(file):
    learned = EnvExperiment.from_controller(controller_file.load(file))
    refused("omega is -1", sweep_vanilla, learned, [-1.0])


def test_simulate_writes_the_table_and_the_pictures_of_the_gait(file, tmp_path, capsys):
    table, plot = tmp_path / "leg.csv", tmp_path / "leg.png"
    words = ["simulate", str(file), "--duration-s", "1", "--json"]
    assert main([*words, "--csv", str(table), "--plot", str(plot)]) == 0
    assert json.loads(capsys.readouterr().out)["lasted"] == 1.0
    with table.open() as stream:
        rows = list(csv.DictReader(stream))
    assert len(rows) == 200
    assert {"time_s", "foot_force", "knee_phase_rad", "reward", "work"} < rows[0].keys()
    assert plot.exists()


def test_evaluate_measures_all_runs_of_a_folder(swept, tmp_path, capsys):
    assert main(["evaluate", str(swept), "--csv", str(tmp_path / "runs.csv")]) == 0
    assert "share of time on the ground" in capsys.readouterr().out
    with (tmp_path / "runs.csv").open() as stream:
        (row,) = csv.DictReader(stream)
    assert row["lasted"] == "1"


def test_evaluate_tries_what_was_learned_under_other_masses_and_starts(swept, capsys):
    words = ["evaluate", str(swept), "--json", "--starts", "2"]
    assert main([*words, "--settings", "mass_factor=1.3", "noise=0.02"]) == 0
    disturbed = json.loads(capsys.readouterr().out)["rows"]
    assert [entry["start"] for entry in disturbed] == [0, 1]
    assert disturbed[0]["return"] != disturbed[1]["return"]


def test_compare_plays_sets_of_one_environment(swept, file, tmp_path, capsys):
    saved, still = controller_file.load(file), tmp_path / "still.json"
    controller_file.save(dataclasses.replace(saved, weights=np.zeros(1, "float32")), still)
    assert main(["compare", str(swept), str(still), "--json"]) == 0
    result = json.loads(capsys.readouterr().out)
    assert len({row["controller"] for row in result["rows"]}) == 2
    assert result["differences"][0]["fitness"]["mean"] != 0.0


def test_compare_refuses_sets_of_different_worlds(swept, one_line_error):
    message = one_line_error("compare", "V-sector-w4", str(swept))
    assert "V-sector-w4 hops on one leg, and V-sector-w8 runs in another simulator" in message


@pytest.mark.thorough
def test_generalise_tries_what_was_learned_on_a_model_under_disturbances(swept, tmp_path, capsys):
    words = ["robustness", str(swept), "--out", str(tmp_path)]
    tried = [
        "wind-ahead=0.1",
        "mass=1.2/3",
        "push-ahead=0.3",
        "delay=0.008",
        "noise=0.1",
        "friction=0.5",
        "step",
    ]
    assert main([*words, "--conditions", *tried]) == 0
    assert 'left out of "step": "drop_m cannot be changed on a MuJoCo' in capsys.readouterr().out
    with (tmp_path / "curves.csv").open() as stream:
        rows = {row["condition"]: row for row in csv.DictReader(stream)}
    assert rows.keys() == {"wind-ahead", "mass", "push-ahead", "delay", "noise", "friction"}
    assert main([*words, "--conditions", *tried]) == 0  # from its records
    assert "1/1  done before" in capsys.readouterr().err


def test_a_model_is_changed_by_what_a_disturbance_says(file):
    runs = read_runs(file)[0]
    tested: Any = EnvironmentUnderTest.from_runs(runs)
    heavy, pushed = disturbances_named(["mass=2", "push-ahead=0.5"])
    met = [heavy, *disturbances_named(["slope=0.2"])]
    lanes = [tested.undisturbed(met), *tested.disturbed(met, np.zeros(1))]
    changes = of_lanes(vars(tested.body), 3, "float64") | joined(tested, met, lanes)
    changed = tested._models(tested.experiment.spec.model_settings, changes)
    assert changed[1].body_mass.sum() == pytest.approx(2.0 * tested.body.mass_kg)
    ahead, _, up = changed[2].opt.gravity  # ground that rises ahead pulls back along itself
    assert ahead / up == pytest.approx(0.2)
    assert ahead < 0.0
    assert heavy.changes(tested, np.array([2.0]), np.zeros(1))["mass_kg"] == pytest.approx(
        changed[1].body_mass.sum()
    )
    step = pushed.changes(tested, np.array([0.5]), np.zeros(1))["push_x_n"]
    impulse = step.value * step.until_s
    assert impulse == pytest.approx(0.5 * tested.speed_scale * tested.body.mass_kg)
    refused("mass_kg would be 0", lambda: tested.check([dataclasses.replace(heavy, levels=(0.0,))]))


def test_a_wind_that_rises_acts_on_a_model_and_blows_strike_it_once(file):
    tested: Any = EnvironmentUnderTest.from_runs(read_runs(file)[0])
    winds = disturbances_named(["wind-up=-0.5"])
    (wind,) = (x.changes(tested, np.array([-0.5]), np.array([1.0])) for x in winds)
    none = np.zeros(1)
    usual = {"push_x_n": none, "push_y_n": none, "at_s": none + 0.5, "impulse_ns": none + 0.2}
    changes = {**usual, **wind}
    end_s = wind["push_z_n"].until_s
    weight_n = tested.body.mass_kg * tested.body.gravity_m_per_s2
    for time_s, force_n in ((0.505, 20.0), (0.6, None), (0.5 * (1.0 + end_s), -0.25 * weight_n)):
        push = _push(changes, 0.01, time_s)
        assert (push is None) if force_n is None else push[0, 2] == pytest.approx(force_n)
    wiring = tested.experiment.wiring
    still = Pilot(tested.experiment.wires, wiring, np.zeros((1, 2)))
    played = tested.played(winds, lambda omega: still)
    assert played["lasted"].all()
    assert played["bounce_m"][1] != played["bounce_m"][0]


def test_a_heavier_leg_presses_harder():
    heights = []
    for factor in (1.0, 1.5):
        env = ModelEnv(model="leg", mass_factor=factor, release_m=0.0)
        env.reset()
        for _ in range(100):
            observation = env.step(np.zeros(2))[0]
            heights.append(float(observation[env.observation_names.index("root_height")]))
    assert heights[199] < heights[99]


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("simulate --height-m 2", "is called '--height-m"),
        ("simulate --animate leg.avi", "use .gif, .webp, .mp4 or .webm"),
        ("evaluate --drop-m 0.1", "is called '--drop-m"),
        ("evaluate --starts 0", "starts is 0; it must be a whole number of at least 1"),
        ("figure portrait", "runs in another simulator, and this figure is of one leg"),
    ],
)
def test_what_has_no_meaning_on_an_environment_is_refused(words, said, file, one_line_error):
    first, *options = words.split(" --")
    extra = [word for entry in options for word in f"--{entry}".split()]
    assert said in one_line_error(*first.split(), str(file), *extra)


def test_a_machine_that_cannot_draw_says_so_in_one_line(played, monkeypatch, tmp_path):
    def fails(name):
        raise ImportError(name)

    monkeypatch.setattr(filming, "import_module", fails)
    with pytest.raises(TegotaeError, match="needs EGL or OSMesa") as raised:
        filming.write_animation(lambda: filming.film_animation(played), tmp_path / "leg.gif")
    assert "\n" not in str(raised.value)


def test_a_film_shows_the_leg_moving(played):
    try:
        context = filming._context()
    except TegotaeError as error:
        pytest.skip(str(error))
    context.free()
    pictures = filming.film(played)
    assert len(pictures) == int(played.episode.time_s[-1] * 25)
    assert pictures[0].shape == (filming.HEIGHT, filming.WIDTH, 3)
    assert not np.array_equal(pictures[0], pictures[-1])
