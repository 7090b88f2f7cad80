"""The margin of a walker's mass inside the polygon of its feet."""

import pytest

from refusals import refused
from tegotae.measures.gaits.lags import support_margin_m
from tegotae.parts.bodies import Walker
from tegotae.systems.vanilla import legged_named

MOVED = Walker(com_x_m=0.326, com_y_m=-0.206)


def test_the_mass_of_quadruped_c_is_on_the_edge_of_every_three_legs():
    assert [support_margin_m(Walker(), (leg,)) for leg in range(4)] == pytest.approx([0.0] * 4)


def test_no_place_of_the_mass_serves_the_loss_of_opposite_legs():
    margins = [support_margin_m(MOVED, (leg,)) for leg in range(4)]
    assert margins == pytest.approx([0.033, -0.333, 0.234, -0.033], abs=1e-3)


def test_a_hexapod_has_a_margin_whatever_leg_it_loses_and_most_without_a_middle_one():
    legged = legged_named("hexapod")
    margins = {n: support_margin_m(legged.body, (k,)) for k, n in enumerate(legged.names)}
    assert margins["LM"] == margins["RM"] == pytest.approx(0.44)
    assert margins["LF"] == margins["RH"] == pytest.approx(0.306, abs=1e-3)


@pytest.mark.parametrize(("missing", "says"), [((4,), "0 ... 3"), ((0, 1), "2 legs are left")])
def test_a_leg_that_there_is_not_or_too_few_legs_are_refused(missing, says):
    refused(says, lambda: support_margin_m(Walker(), missing))
