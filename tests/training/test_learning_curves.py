"""Learning curves of any algorithm are read onto the same scales, compared, and drawn."""

import csv
import json

import numpy as np
import pandas as pd
import pytest

from refusals import refused
from tegotae.cli import main
from tegotae.figures.learning_curves import algorithms_figure, algorithms_tables
from tegotae.figures.style import write_tables
from tegotae.training.curves import COLUMNS, groups, late_mean, read_curves, shared
from tegotae.training.learner import CurvePoint
from tegotae.training.run import COLUMNS as POINT, write_curves

MODEL = "AR-rF-sector-w8"


def leave(folder, algorithm, points, model=MODEL):
    """Write the files of a training that its curves need."""
    folder.mkdir(parents=True)
    configuration = {"experiment": {"name": model}, "algorithm": algorithm}
    (folder / "run.json").write_text(
        json.dumps({"configuration": configuration, "software": {"engine": "native"}})
    )
    write_curves(folder / "curves.csv", points)


def leave_agent(folder, values, seed=0, **settings):
    points = [CurvePoint(seed, 5 * i, 50 * i, value, value) for i, value in enumerate(values)]
    leave(folder, {"name": "ppo", "gamma": 0.99, **settings}, points)


def leave_pgpe(folder, values, seed=0):
    points = [CurvePoint(seed, i, 40 * i, value, value) for i, value in enumerate(values)]
    leave(folder, {"name": "pgpe", "population": 4}, points)


def curve(values, algorithm="ppo", seed=0, model=MODEL, every=10.0):
    episode = every * np.arange(len(values))
    columns = (algorithm, model, seed, episode, 12.0 * episode, np.array(values))
    return pd.DataFrame(dict(zip(COLUMNS, columns, strict=True)))


# Reading.


def test_generations_and_episodes_are_on_the_same_scale_of_simulated_time(tmp_path):
    leave_pgpe(tmp_path / "a", [0.1, 0.2, 0.3])
    leave_agent(tmp_path / "b", [0.4, 0.5])
    runs = groups(read_curves([tmp_path]))
    assert [algorithm for _, algorithm in runs] == ["pgpe", "ppo"]
    (pgpe,), (ppo,) = runs.values()
    assert pgpe["simulated_s"].tolist() == [0.0, 40.0, 80.0]
    assert pgpe["episode"].tolist() == [0.0, 1.0, 2.0]
    assert pgpe["cot_inverse"].tolist() == [0.1, 0.2, 0.3]
    assert ppo["simulated_s"].tolist() == [0.0, 50.0]
    assert ppo["episode"].tolist() == [0.0, 5.0]


def test_settings_that_differ_are_part_of_the_name(tmp_path):
    leave_agent(tmp_path / "a", [0.1], critic_senses=[])
    leave_agent(tmp_path / "b", [0.2], critic_senses=["velocity", "height"])
    leave_agent(tmp_path / "c", [0.3], critic_senses=[], seed=1)
    curves = read_curves([tmp_path])
    assert list(zip(curves["algorithm"], curves["seed"], strict=True)) == [
        ("ppo, critic_senses none", 0),
        ("ppo, critic_senses none", 1),
        ("ppo, critic_senses velocity+height", 0),
    ]


def test_runs_that_cannot_be_told_apart_are_refused(tmp_path):
    leave_agent(tmp_path / "a", [0.1])
    leave_agent(tmp_path / "b", [0.2])
    refused(f"two runs of ppo on {MODEL} with seed 0", read_curves, [tmp_path])


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("run.json", "{"),
        ("run.json", '{"configuration": []}'),
        ("run.json", '{"configuration": {"algorithm": {}}}'),
        ("curves.csv", ""),
        ("curves.csv", "episode,simulated_s,cot_inverse,fitness,seed\n1,2,3,4,0\n"),
        ("curves.csv", ",".join(POINT) + "\n0,1,2\n"),
        ("curves.csv", ",".join(POINT) + "\n0,1,2,3,x,5,6,7\n"),
        ("curves.csv", ",".join(POINT) + "\n0,1,,3,4,5,6,7\n"),
    ],
)
def test_damage_is_named(tmp_path, name, text):
    leave_agent(tmp_path / "a", [0.1])
    (tmp_path / "a" / name).write_text(text)
    refused(r"a.* (is|are) damaged", read_curves, [tmp_path])


@pytest.mark.parametrize("place", ["nowhere", "nowhere.csv", "."])
def test_a_place_without_curves_is_named(tmp_path, place):
    refused(r"there is no|holds no learning|No such file", read_curves, [tmp_path / place])


def test_another_table_is_refused(tmp_path):
    (tmp_path / "a.csv").write_text("x,y\n1,2\n")
    refused(r"a\.csv is no table of learning curves", read_curves, [tmp_path / "a.csv"])


def test_a_written_table_is_read_back(tmp_path):
    curves = pd.concat([curve([0.0, 1 / 3, 0.5]), curve([0.1, 0.2], "sac, gamma 0.9", 3)])
    write_tables(tmp_path / "f.png", algorithms_tables(curves))
    again = read_curves([tmp_path / "f.csv"])
    pd.testing.assert_frame_equal(again, curves.reset_index(drop=True), rtol=1e-8)


# Comparing.


def test_the_late_mean_is_over_the_last_tenth_of_simulated_time():
    points = curve(np.arange(21.0))
    assert late_mean(points) == pytest.approx(np.mean([18, 19, 20]))
    # Of the first 10 points' time only: the last tenth begins at 9.
    assert late_mean(points, until_s=10 * 120.0) == pytest.approx(np.mean([9, 10]))
    assert late_mean(curve([0.7])) == 0.7


def test_runs_are_compared_where_all_have_points():
    episode, simulated_s, values = shared([curve([0.0, 1.0, 2.0]), curve([3.0, 4.0], seed=1)])
    assert episode.tolist() == [0.0, 10.0]
    assert simulated_s.tolist() == [0.0, 120.0]
    assert values.tolist() == [[0.0, 3.0], [1.0, 4.0]]


def test_runs_of_a_model_and_an_algorithm_belong_together():
    curves = [curve([0.0]), curve([0.0], seed=1), curve([0.0], "sac"), curve([0.0], model="AR")]
    assert {key: len(runs) for key, runs in groups(pd.concat(curves)).items()} == {
        (MODEL, "ppo"): 2,
        (MODEL, "sac"): 1,
        ("AR", "ppo"): 1,
    }


# Drawing.


def test_a_panel_a_model_and_algorithm_over_simulated_time_with_episodes_above():
    curves = [curve([0.0, 0.2, 0.4]), curve([0.0, 0.4, 0.8], seed=1), curve([0.1, 0.1], "sac")]
    curves.append(curve([0.0, 0.5], "pgpe", model="AR-rF-reflex-w8", every=1.0))
    figure = algorithms_figure(pd.concat(curves))
    panels = {panel.get_title(loc="left").replace("\n", " "): panel for panel in figure.axes}
    assert list(panels) == [
        f"{model}: {algorithm}"
        for model in ("AR-rF-reflex-w8", MODEL)
        for algorithm in ("PGPE", "PPO", "SAC")
    ]
    panel = panels[f"{MODEL}: PPO"]
    ppo = next(line for line in panel.get_lines() if line.get_linewidth() == 1.2)
    # The point before training has no place on a logarithmic axis.
    assert panel.get_xscale() == "log"
    np.testing.assert_allclose(ppo.get_xdata(), [120.0, 240.0])
    np.testing.assert_allclose(ppo.get_ydata(), [0.3, 0.6])
    # An episode is 12 s.
    (above,) = panel.child_axes
    panel.set_xlim(12.0, 1200.0)
    figure.draw_without_rendering()
    np.testing.assert_allclose(above.get_xlim(), [1.0, 100.0])
    assert "[m/J]" in panels[f"{MODEL}: PGPE"].get_ylabel()
    assert "[s]" in panel.get_xlabel()


def test_the_interval_of_one_algorithm_hides_no_other():
    curves = [curve([0.0, 0.2, 0.4], a, seed) for a in ("ppo", "sac") for seed in (0, 1)]
    for panel in algorithms_figure(pd.concat(curves)).axes:
        assert len(panel.collections) == 1
        grey = [line for line in panel.get_lines() if line.get_linewidth() == 0.8]
        assert len(grey) == 1


def test_more_algorithms_than_fit_side_by_side_go_on_below():
    curves = [curve([0.0, 0.2], name) for name in "abcde"]
    panels = [panel for panel in algorithms_figure(pd.concat(curves)).axes if panel.get_visible()]
    assert [p.get_title(loc="left") for p in panels] == [f"{MODEL}: {name}" for name in "abcde"]


def test_the_interval_of_the_mean_is_in_the_table_and_empty_for_a_single_run():
    curves = [curve([0.0, 0.2]), curve([0.0, 0.4], seed=1), curve([0.1, 0.1], "sac")]
    mean = algorithms_tables(pd.concat(curves))["mean"]
    rows = dict(zip(zip(mean["algorithm"], mean["episode"], strict=True), mean["low"], strict=True))
    # Of two runs, Student's t: 12.7 standard errors. No CoT⁻¹ is below zero.
    assert rows["ppo", 10.0] == 0.0
    assert mean["high"][1] == pytest.approx(0.3 + 12.706 * 0.1, abs=1e-3)
    assert np.isnan(rows["sac", 10.0])


def test_the_command_draws_and_says_how_far_pgpe_leads(tmp_path, capsys):
    for seed in (0, 1):
        leave_pgpe(tmp_path / f"pgpe{seed}", [0.0, 0.2, 0.9, 0.9], seed)
        leave_agent(tmp_path / f"ppo{seed}", [0.1, 0.4], seed)
    out = tmp_path / "figure.svg"
    assert main(["figure", "learning-curves", str(tmp_path), "--out", str(out)]) == 0
    assert out.exists()
    output = " ".join(capsys.readouterr().out.split())
    # At the end PGPE is at 0.9 and PPO at 0.4; after PPO's 50 s, PGPE is at 0.2.
    assert "ppo 2 50 s 0.400 [0.400, 0.400] 0.500 [0.500, 0.500]" in output
    assert "-0.200 [-0.200, -0.200]" in output
    with (tmp_path / "figure.csv").open() as stream:
        assert tuple(next(csv.reader(stream))) == COLUMNS


def test_the_legend_names_only_what_is_drawn():
    time = np.array([0.0, 10.0, 20.0])

    def run(algorithm: str, seed: int) -> pd.DataFrame:
        return curve(time / 20.0, algorithm, seed)

    def legend(*curves: pd.DataFrame) -> list[str]:
        return [
            text.get_text() for text in algorithms_figure(pd.concat(curves)).legends[0].get_texts()
        ]

    assert legend(run("pgpe", 0)) == ["run"]
    assert legend(run("pgpe", 0), run("sac", 0)) == ["run", "other algorithms"]
    assert legend(run("pgpe", 0), run("pgpe", 1)) == ["mean over runs", "its 95 % interval", "runs"]
