"""Details of figures: units, legends, frames and colours."""

from itertools import pairwise

import numpy as np
import pytest
from matplotlib.colors import to_rgb

from research.reproduction.figures.optimum import optimum_figure, optimum_tables
from tegotae.figures.gaits.animation import LegPositions
from tegotae.figures.style import COLOURS
from tegotae.measures.optimum import curve

RUN = (np.array([5.0]), np.array([0.7]))


def optimum():
    return optimum_figure(curve(), {"learned": RUN}, {}, max_force_n=4.0, longer={"learned": RUN})


def test_gaits_of_several_hops_are_open_points_beside_the_filled_ones_of_one_hop():
    lines = {str(line.get_label()): line for line in optimum().axes[0].lines}
    assert lines["learned"].get_markerfacecolor() != "none"
    assert lines["learned, cycle of several hops"].get_markerfacecolor() == "none"
    table = optimum_tables(curve(), {"learned": RUN}, {}, {"learned": RUN})["points"]
    assert table["gaits"].tolist() == ["learned", "learned, cycle of several hops"]


def test_the_first_colours_differ_from_their_neighbours_in_grey():
    grey = [float(np.dot(to_rgb(colour), (0.2126, 0.7152, 0.0722))) for colour in COLOURS[:5]]
    assert min(abs(a - b) for a, b in pairwise(grey)) > 0.15


def test_a_walker_that_turns_is_seen_from_its_own_side():
    # Half a circle of radius 2 m; one hip ahead of the other, and a foot on the ground beside them.
    heading = np.linspace(0.0, np.pi, 201)
    ahead = np.stack([np.cos(heading), np.sin(heading), 0.0 * heading], axis=-1)
    aside = np.stack([-np.sin(heading), np.cos(heading), 0.0 * heading], axis=-1)
    middle = -2.0 * aside + [0.0, 2.0, 1.0]
    hips = np.stack([middle - 0.3 * ahead, middle + 0.3 * ahead], axis=1)
    feet = np.stack([middle, middle + 0.1 * aside], axis=1)
    stands = np.ones((201, 2), bool)
    turned = LegPositions(hips, feet, stands, heading).along_torso()
    long = turned.hips_m[:, 1] - turned.hips_m[:, 0]
    np.testing.assert_allclose(long, np.broadcast_to([0.6, 0.0, 0.0], long.shape), atol=1e-9)
    np.testing.assert_allclose((turned.feet_m[:, 1] - turned.feet_m[:, 0])[:, 1], 0.1, atol=1e-9)
    distance = turned.hips_m[-1, :, 0].mean() - turned.hips_m[0, :, 0].mean()
    assert distance == pytest.approx(2.0 * np.pi, rel=1e-3)  # all that it walked is forward
    np.testing.assert_array_equal(turned.hips_m[..., 2], hips[..., 2])
    assert LegPositions(hips, feet, stands).along_torso().hips_m is hips
