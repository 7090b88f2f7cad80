"""Quadruped G changes from walk to trot to gallop by its frequency alone."""

import dataclasses

import numpy as np
import pytest

from places import ROOT
from tegotae._support.tables import parse_numbers, read_csv
from tegotae.measures.gaits.names import gait_of
from tegotae.systems.legged import lanes_of, random_phases
from tegotae.systems.resolve import legged_system as system

KEPT = ROOT / "docs" / "_static" / "gaits"


@pytest.mark.thorough
def test_it_walks_trots_and_gallops_from_random_starts():
    legged = system("quadruped-g")
    phase = np.tile(random_phases(4, 4), 3)
    scenario = legged.scenario(phase)._replace(omega=np.repeat([3.4, 4.6, 7.2], 4))
    timing = dataclasses.replace(legged.timing, duration_s=150.0)
    results = lanes_of(legged.run(legged.summary(), scenario, timing))
    names = ["diagonal-sequence walk"] * 4 + ["trot"] * 4 + ["rotary gallop"] * 4
    assert gait_of(results, legged.names).tolist() == names
    assert (results.flight_share[8:] > 0.15).all()
    assert (results.flight_share[:8] < 0.01).all()


def test_the_kept_account_has_trots_where_heave_and_pitch_push_legs_apart():
    table = read_csv(KEPT / "gallop-modes.csv")
    gait = table["gait"]
    heave, pitch = parse_numbers(table["kappa_heave"]), parse_numbers(table["kappa_pitch"])
    trot, gallop = gait == "trot", gait == "rotary gallop"
    assert trot.sum() > 5
    assert gallop.sum() > 4
    assert (np.maximum(heave, pitch)[trot] < 0.0).all()
    assert (np.minimum(heave, pitch)[gallop] > 0.0).all()
