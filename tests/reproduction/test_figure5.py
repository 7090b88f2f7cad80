"""The eight panels of the paper's Fig. 5, of controllers made by hand."""

import numpy as np
import pytest

from records import made_up
from refusals import refused
from research.reproduction.figures.figure5 import (
    NORMALISED,
    PANELS,
    PolicyPanel,
    policies_figure,
    policies_table,
    policy_panels,
)
from research.reproduction.plan import plan
from research.reproduction.table import tabulate
from tegotae.analysis.orbit import find_orbit
from tegotae.analysis.surface import actuation_surface
from tegotae.systems.controller_file import SavedController
from tegotae.systems.recipe import recipe


@pytest.fixture(scope="module")
def panels() -> list[PolicyPanel]:
    saved = SavedController.from_weights(recipe("V-reflex-w8").controller(), np.array([2.0]), 8.0)
    surface = actuation_surface(saved, np.linspace(0.0, 2.0, 5), columns=6)
    orbit = find_orbit(saved, settle_s=20.0, tick_s=0.002)
    metrics = dict.fromkeys(NORMALISED, 0.25) | {"feedback_share": 0.07, "phase_share": np.nan}
    return [
        PolicyPanel(number, architecture, drive, "V-reflex-w8", 3, surface, orbit, metrics, 4.0)
        for number, architecture, drive in PANELS
    ]


def test_every_panel_has_its_surface_its_cycle_and_its_metrics(panels):
    figure = policies_figure(panels)
    titles = [axes.get_title() for axes in figure.axes if axes.get_title()]
    assert [title.split(".")[0] for title in titles] == [number for number, *_ in PANELS]
    assert "CoT⁻¹ 0.25" in titles[0]
    assert "by feedback 0.07" in titles[0]
    assert figure.axes[-1].get_ylabel() == "force $F_a/\\alpha$ of the surfaces"


def test_the_table_beside_it_names_model_and_run(panels):
    rows = policies_table(panels).splitlines()
    assert len(rows) == 2 + len(PANELS)
    assert rows[2].startswith("| I | V-reflex-w8, run 3 | 0.25 |")
    assert rows[2].endswith("| 0.07 | – |")


def test_a_study_without_settled_controllers_has_no_panel():
    records = [made_up(unit) for unit in plan("smoke").units]  # which keep no gait
    assert policy_panels(records, tabulate(records)) == []
    refused("no model of the study settles", policies_figure, [])
