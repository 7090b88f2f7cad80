"""The map of short laws: Tegotae's law is one of them, and a small map is whole and goes on."""

import numpy as np
import pandas as pd
import pytest

from tegotae.analysis.maps import OutcomeSummary
from tegotae.systems.recipe import recipe


@pytest.mark.thorough
def test_a_small_map_is_whole_holds_tegotaes_law_and_is_measured_once(study, monkeypatch, tmp_path):
    laws, law_map = study("law_map.laws"), study("law_map.run")
    small = law_map.LawMap(
        laws=32, subjects=("study",), sample=8, seeds=0, dir=tmp_path / "map", out=tmp_path / "out"
    )
    small.run()
    tables = {name: pd.read_csv(small.out / f"{name}.csv") for name in ("summary", "laws", "named")}
    assert tables["summary"].laws.tolist() == [8, 8, 16, 16, 8, 8]
    assert len(tables["laws"]) == 2 * 32  # all of so few
    assert (small.out / "law_map.png").exists()
    assert (small.out / "lecture.png").exists()

    # Tegotae's law in the terms of the map is the package's.
    vanilla = tables["named"].iloc[0]
    assert (vanilla.place_rad, vanilla.offset) == (0.0, 0.0)
    row = laws.Laws(*(np.array([vanilla[name]]) for name in laws.TITLES))
    weights = laws.weights_of("study", "load", row)
    system = recipe("V-sector-w8").experiment().system
    package = system.rollout(OutcomeSummary()).run(weights[:, 2:3], system.scenario())
    ours = laws.measured("study", "load", row, np.zeros((1, 1)), 8.0, system.timing)
    assert ours["merit"] == pytest.approx(np.nan_to_num(package.cot_inverse), abs=1e-3)

    monkeypatch.setattr(law_map, "measured", None)
    again = law_map.outcomes(small.dir, "study", "latch", 32)
    assert len(again.by_command[4.0]["merit"]) == 16


@pytest.mark.parametrize("form", ["load", "latch", "decay"])
def test_a_shape_lies_in_the_map_where_it_was_drawn(study, form):
    laws = study("law_map.laws")
    drawn, phases = laws.drawn("quadruped", form, 64, 64)
    height = laws.height_of(form, drawn.shape)
    assert phases.shape == (4, 64)
    assert np.all((height > 0.0) & (height < 1.0))
    # Of a sequence that is even, every sixteenth holds as many.
    assert np.histogram(height, 16, (0.0, 1.0))[0].tolist() == [4] * 16
