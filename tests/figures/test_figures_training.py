"""Figures of how far training got, and of what that does to the verdicts."""

import numpy as np
import pytest

from refusals import refused
from research.reproduction.claims.atomic import ATOMIC_CLAIMS
from research.reproduction.claims.counting import Count
from research.reproduction.claims.estimates import NOT_KNOWN, EffectEstimate
from research.reproduction.claims.findings import OPPOSITE, REPRODUCED, TOO_SMALL, Finding
from research.reproduction.figures.budgets import budgets_figure
from research.reproduction.figures.convergence import (
    Trainings,
    convergence_figure,
    convergence_table,
)
from tegotae.figures.style import COLOURS, PAGE_IN, save_figure

EPISODES = np.array([64.0, 128.0, 256.0, 512.0])


def trainings(**changes) -> Trainings:
    """Three runs: one goes on to the cap, one stops half way, one never hops."""
    fitness = np.array(
        [
            [0.2, -1e6, -20.0],
            [0.6, 0.4, -21.0],
            [0.5, np.nan, -19.0],
            [1.0, np.nan, -22.0],
        ]
    )
    columns = {
        "episodes": EPISODES,
        "fitness": fitness,
        "stop_episode": np.array([512.0, 128.0, 512.0]),
        "reason": ("cap", "plateau", "cap"),
    }
    return Trainings(**(columns | changes))


def texts(panel) -> str:
    return " ".join(text.get_text() for text in panel.texts)


def labels(figure) -> list[str]:
    return [text.get_text() for text in figure.legends[0].get_texts()]


def test_the_best_fitness_never_falls_and_outlasts_the_run():
    best = trainings().best()
    np.testing.assert_array_equal(best[:, 0], [0.2, 0.6, 0.6, 1.0])
    # A failed rollout has no fitness; and a run that stopped keeps what it had.
    np.testing.assert_array_equal(best[:, 1], [np.nan, 0.4, 0.4, 0.4])


def test_lines_end_where_runs_stop_and_the_mean_goes_on_with_all_that_hop():
    figure = convergence_figure({"ART": trainings()})
    assert figure.get_figwidth() == PAGE_IN
    panel = figure.axes[0]
    thin = [line for line in panel.lines if line.get_linewidth() == 0.4]
    assert [line.get_xdata().tolist() for line in thin] == [
        EPISODES.tolist(),
        EPISODES[:2].tolist(),
        EPISODES.tolist(),
    ]
    mean = next(line for line in panel.lines if line.get_linewidth() == 1.3)
    assert {line.get_color() for line in (*thin, mean)} == {COLOURS[0]}
    np.testing.assert_allclose(mean.get_ydata(), [0.2, 0.5, 0.5, 0.7])
    assert panel.get_xscale() == "log"
    assert panel.get_ylim()[0] == 0.0


def test_why_and_where_runs_stopped_is_marked_and_those_that_never_hop_are_counted():
    figure = convergence_figure({"ART": trainings()})
    panel = figure.axes[0]
    assert panel.get_title(loc="left") == "ART: 2 cap, 1 plateau"
    assert "1 of 3 end below 0" in texts(panel)
    marks = {}
    for line in panel.lines:
        if np.ptp(line.get_xdata()) == 0.0 and len(line.get_xdata()) == 2:
            marks.setdefault(line.get_color(), []).append(float(line.get_xdata()[0]))
    assert sorted(marks.values()) == [[128.0], [512.0, 512.0]]
    assert {"stopped: plateau", "stopped: cap"} <= set(labels(figure))


def test_any_other_reason_is_named_and_every_kind_has_its_panel():
    odd = trainings(reason=("never hops", "plateau", "plateau"))
    figure = convergence_figure({"V": trainings(), "VG": odd, "T": trainings(), "AR": trainings()})
    panels = [panel for panel in figure.axes if panel.get_visible()]
    assert [p.get_title(loc="left").split(":")[0] for p in panels] == ["V", "VG", "T", "AR"]
    assert "stopped: never hops" in labels(figure)


def test_runs_that_all_never_hop_have_a_panel_without_a_mean(tmp_path):
    never = trainings(fitness=np.full((4, 3), -20.0))
    figure = convergence_figure({"T-F": never})
    assert "3 of 3 end below 0" in texts(figure.axes[0])
    assert save_figure(figure, tmp_path / "f.png").exists()
    assert np.isnan(convergence_table({"T-F": never})["best_fitness"]).all()


def test_the_table_of_convergence_holds_the_means_and_how_many_stopped():
    table = convergence_table({"ART": trainings()})
    assert table["name"].tolist() == ["ART"] * 4
    np.testing.assert_allclose(table["best_fitness"], [0.2, 0.5, 0.5, 0.7])
    assert table["stopped_runs"].tolist() == [0, 1, 1, 3]
    assert table["runs_below"].tolist() == [1] * 4


# Verdicts by budget.

CLAIMS = {claim.name: claim for claim in ATOMIC_CLAIMS}


def finding(claim: str, effect: float | None, half: float = 0.1) -> Finding:
    estimate = NOT_KNOWN if effect is None else EffectEstimate(effect, effect - half, effect + half)
    return Finding(CLAIMS[claim], {Count(): estimate})


def by_budget() -> dict[str, list[Finding]]:
    """VG's CoT⁻¹ over V's, which turns; one that is alike, and one that is not measured."""
    effects = [finding("vt-cot", 0.3), finding("t-t0", None)]
    return {
        "1280 episodes": [finding("vg-cot", -0.5), *effects],
        "12800 episodes": [finding("vg-cot", 0.05), *effects],
        "plateau": [finding("vg-cot", 0.5), *effects],
    }


def test_effects_stand_over_their_budgets_coloured_by_outcome_with_the_plateau_last(tmp_path):
    figure = budgets_figure(by_budget())
    (panel,) = [axes for axes in figure.axes if axes.get_visible()]
    assert panel.get_title(loc="left").split() == CLAIMS["vg-cot"].title.split()
    points = [line for line in panel.lines if line.get_marker() in ("o", "X", "s")]
    assert [float(line.get_ydata()[0]) for line in points] == [-0.5, 0.05, 0.5]
    assert [float(line.get_xdata()[0]) for line in points] == [0.0, 1.0, 2.0]
    assert [line.get_marker() for line in points] == ["X", "s", "o"]
    assert [label.get_text() for label in panel.get_xticklabels()] == ["1280", "12800", "plateau"]
    assert labels(figure)[:3] == [REPRODUCED, OPPOSITE, TOO_SMALL]
    assert save_figure(figure, tmp_path / "f.png").exists()


def test_an_effect_that_is_not_known_at_a_budget_leaves_a_gap():
    figure = budgets_figure({"a": [finding("vg-cot", None)], "b": [finding("vg-cot", 0.5)]})
    points = [line for line in figure.axes[0].lines if line.get_marker() == "o"]
    assert [float(line.get_xdata()[0]) for line in points] == [1.0]


@pytest.mark.parametrize("estimate", [{}, {"a": [finding("t-t0", None)]}])
def test_nothing_to_draw_is_said(estimate):
    refused("no claim has an effect to draw", budgets_figure, estimate)
    refused("no trainings to draw", convergence_figure, {})
