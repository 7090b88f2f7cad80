"""Laws on Go1's feet: what the page's tables say is what the kept episodes show."""

from __future__ import annotations

import pandas as pd
import pytest

pytest.importorskip("mujoco")


@pytest.fixture
def laws(study):
    """The study."""
    return study("go1_laws")


def test_the_table_of_headings_is_of_the_kept_episodes(laws):
    rows = pd.read_csv(laws.FOLDER / "speed_rows.csv")
    text = (laws.FOLDER / "headings.md").read_text(encoding="utf-8")
    assert laws.headings(laws.TABLES["speeds"], rows).strip() == text.strip()


def test_an_episode_that_falls_or_keeps_its_heading_is_not_astray(laws):
    ends = [float("nan"), 0.9 * laws.ASTRAY_RAD, -1.1 * laws.ASTRAY_RAD, 7.0 * laws.ASTRAY_RAD]
    assert laws.astray(pd.DataFrame({"heading_rad": ends})).tolist() == [False, False, True, True]
