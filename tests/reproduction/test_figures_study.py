"""Fig. 2: metrics in their units, per architecture and training frequency."""

import numpy as np
import pytest

from research.reproduction.claims.counting import Count
from research.reproduction.claims.findings import findings
from research.reproduction.figures.study import (
    architecture_metrics,
    architectures,
    architectures_figure,
    correlation_figure,
    correlations,
    frequencies,
    pictograms_figure,
)
from research.reproduction.table import StudyTable, design_place, table_of_runs
from study_tables import table
from tegotae.measures.hopping.metrics import HOPPING
from tegotae.systems.recipe import study_recipes

HELD = ("V", "ART", "T")
"""The architectures of that table, in the order of the paper."""


def with_own() -> StudyTable:
    """The same, and an experiment of one's own beside them, which senses the velocity."""
    runs = {metric: np.linspace(0.8, 1.0, 5) for metric in HOPPING.names()}
    blank = dict.fromkeys(("learned", "reaction", "gain", "actuation"), "")
    place = {"model": "mine", "architecture": "mine", **blank, "observation": "Fv", "omega_t": 6.0}
    rows = table().columns | {}
    added = table_of_runs([(place, {"best_fitness": np.zeros(5)}, runs)]).columns
    return StudyTable({name: np.concatenate([rows[name], added[name]]) for name in rows})


def bars(panel) -> list[tuple[float, float]]:
    """Middle and height of the bars of a panel, from left to right."""
    return sorted((bar.get_x() + bar.get_width() / 2, bar.get_height()) for bar in panel.patches)


def panel(figure, metric: str, column: int):
    return figure.axes[2 * HOPPING.names("figure").index(metric) + column]


def test_a_frequency_does_not_dilute_another():
    intervals = architecture_metrics(table())
    assert frequencies(table()) == (4.0, 8.0, None)
    assert intervals["F", "cot_inverse", "ART", 4.0].mean == pytest.approx(1.2)
    assert intervals["F", "cot_inverse", "ART", 8.0].mean == pytest.approx(0.45)
    assert intervals["Fv", "cot_inverse", "T", None].mean == pytest.approx(1.3)
    assert ("F", "cot_inverse", "ART", None) not in intervals
    assert ("F", "cot_inverse", "ARG", 4.0) not in intervals


def test_bars_stand_side_by_side_in_the_unit_of_their_panel():
    figure = architectures_figure(table())
    left = panel(figure, "cot_inverse", 0)
    assert left.get_ylabel() == "CoT⁻¹ [m/J]"
    position = HELD.index("ART")
    (x4, four), (x8, eight) = [bar for bar in bars(left) if abs(bar[0] - position) < 0.5]
    assert x4 < position < x8
    assert (four, eight) == (pytest.approx(1.2), pytest.approx(0.45))
    right = panel(figure, "cot_inverse", 1)
    (single,) = [bar for bar in bars(right) if abs(bar[0] - HELD.index("T")) < 0.5]
    assert single == (HELD.index("T"), pytest.approx(1.3))
    assert right.get_ylim() == left.get_ylim()
    assert left.get_ylim()[1] > 1.3


@pytest.mark.thorough
def test_the_picture_says_what_its_colours_numbers_and_signs_mean():
    (legend,) = architectures_figure(table()).legends
    labels = [text.get_text() for text in legend.get_texts()]
    assert any("4 rad/s" in text for text in labels)
    assert any("8 rad/s" in text for text in labels)
    assert "95 % interval over runs" in labels
    assert "share of the runs in which the metric is undefined" in legend.get_title().get_text()


def test_above_a_bar_stands_the_share_of_runs_that_do_not_define_it():
    figure = architectures_figure(table(t0_s=np.array([9.0, 10.0, np.nan, 11.0, np.nan])))
    labels = {text.get_text() for text in panel(figure, "t0_s", 0).texts}
    assert labels == {"40"}
    assert not panel(figure, "t1_s", 0).texts


def test_what_is_possible_is_drawn_for_the_body_whose_optimum_is_known_alone():
    def drawn(rows: StudyTable) -> tuple[int, bool]:
        figure = architectures_figure(rows)
        (legend,) = figure.legends
        words = " ".join(text.get_text() for text in legend.get_texts())
        dashed = [line for axes in figure.axes for line in axes.lines if line.get_ls() == "--"]
        return len(dashed), "physically possible" in words

    assert drawn(table()) == (4, True)
    assert drawn(table(optimum_share=np.full(5, np.nan))) == (0, False)


def test_what_never_hops_has_a_zero_and_what_is_never_defined_a_dash():
    figure = architectures_figure(table(t0_s=np.full(5, np.nan)))
    assert [text.get_text() for text in panel(figure, "cot_inverse", 0).texts] == ["0"]
    assert {text.get_text() for text in panel(figure, "t0_s", 0).texts} == {"–"}


def test_intervals_of_shares_end_at_one():
    share = np.array([1.0, 1.0, 1.0, 0.2, 1.0])
    intervals = architecture_metrics(table(limit_cycle_share=share))
    interval = intervals["F", "limit_cycle_share", "ART", 4.0]
    assert interval.low < interval.mean < interval.high == 1.0


def test_an_experiment_beside_the_models_has_its_place_after_them():
    figure = architectures_figure(with_own())
    left, right = (panel(figure, "cot_inverse", column) for column in range(2))
    position = len(HELD)
    assert not [bar for bar in bars(left) if abs(bar[0] - position) < 0.5]
    assert [bar for bar in bars(right) if abs(bar[0] - position) < 0.5] == [
        (position, pytest.approx(0.9))
    ]
    lowest = figure.axes[2 * len(HOPPING.names("figure")) - 1]
    labels = [label.get_text() for label in lowest.get_xticklabels()]
    assert labels == [*HELD, "mine"]


def test_a_table_has_places_for_what_it_holds():
    assert architectures(with_own().where(model="mine")) == ("mine",)
    assert architectures(table()) == HELD


def test_an_experiment_beside_the_models_decides_no_claim_about_them():
    outcomes = [findings(rows, resamples=20, options=[Count()]) for rows in (with_own(), table())]
    assert repr(outcomes[0]) == repr(outcomes[1])  # NaN is not NaN


def test_a_table_of_one_frequency_has_bars_of_one():
    (legend,) = architectures_figure(table().where(omega_t=4.0)).legends
    assert len(legend.get_texts()) == 3  # bars, their intervals, the optimum


def some(*models: str, runs: int = 2) -> StudyTable:
    """A few runs of these models, each metric one."""
    values = {metric: np.ones(runs) for metric in HOPPING.names()}
    registry = study_recipes()
    return table_of_runs(
        (design_place(registry[model]), {"best_fitness": np.zeros(runs)}, values)
        for model in models
    )


@pytest.mark.parametrize("name", [name for name in study_recipes() if name.endswith("w8")][::7])
def test_every_model_of_a_table_is_drawn(name):
    rows = some("V-sector-w8", name)
    (architecture,) = set(rows.where(model=name)["architecture"].tolist())
    assert architecture in architectures(rows)
    of_it = [key for key in architecture_metrics(rows) if key[2] == architecture]
    assert of_it
    assert {key[1] for key in of_it} == {metric.name for metric in rows.metrics_shown("figure")}


def test_models_that_learn_one_term_stand_behind_those_that_the_paper_shows():
    rows = some("V-sector-w8", "A-sector-w8")
    assert architectures(rows) == ("V", "A")
    drawn = architectures_figure(rows).axes[-1]
    assert [label.get_text() for label in drawn.get_xticklabels()][-1] == "A"
    heights = [bar.get_height() for bar in panel(architectures_figure(rows), "t0_s", 0).patches]
    assert heights == [1.0, 1.0]
    pictures = pictograms_figure(rows).axes
    assert [p.get_title() for p in pictures if p.get_visible()] == ["V", "A"]


def test_a_metric_that_one_of_two_runs_defines_is_drawn_without_an_interval():
    rows = some("AR-rF-sector-w8")
    rows["t0_s"][0] = np.nan
    estimate = architecture_metrics(rows)["F", "t0_s", "AR", 8.0]
    assert (estimate.mean, estimate.count, estimate.undefined) == (1.0, 1, 1)
    assert np.isnan(estimate.low)


def test_of_too_few_models_the_figure_draws_no_correlation_and_says_so():
    rows = some("V-sector-w8", "AR-rF-sector-w8", "T-Fv")
    matrix = correlations(rows)
    assert np.isnan(matrix[~np.eye(len(matrix), dtype=bool)]).all()
    assert "fewer than 10 models" in correlation_figure(rows).axes[0].get_xlabel()
