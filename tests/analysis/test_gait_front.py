"""Fronts: the least cost over speed, whose points can be released again by name."""

import dataclasses

import numpy as np
import pandas as pd
import pytest

from refusals import refused
from tegotae.analysis.gaits.front import FrontPart, Search, cheapest, evaluated, search_front
from tegotae.cli import main
from tegotae.measures.fronts import front
from tegotae.parts.fields import replace
from tegotae.systems.resolve import legged_system as system, resolve
from tegotae.systems.tuned import NUMBERS, front_family

WALKER = system("quadruped-c")
SHORT = replace(WALKER, {"timing": dataclasses.replace(WALKER.timing, duration_s=100.0)})


def test_points_of_the_front_do_again_from_new_releases_what_the_table_says():
    curve = front("quadruped-c")
    some = [int(np.abs(curve["speed"] - v).argmin()) for v in (0.2, 0.4)]
    numbers = {name: curve[name][some] for name in NUMBERS}
    results = evaluated(SHORT, front_family(WALKER, "vanilla"), numbers, starts=4, seed=7)
    np.testing.assert_array_equal(results["upright"], 1.0)
    np.testing.assert_allclose(results["speed"], curve["speed"][some], rtol=0.05)
    np.testing.assert_allclose(
        results["cost_of_transport"], curve["cost_of_transport"][some], rtol=0.1
    )


def test_a_walker_of_the_front_has_a_name():
    point = front("quadruped-c").nearest(0.4)
    walker = resolve("front:quadruped-c/0.4").legs()
    assert walker.omega == pytest.approx(point["omega"])
    assert walker.weights[0] == pytest.approx(point["sigma"])


@pytest.mark.parametrize(
    ("name", "says"),
    [
        ("front:quadruped-c", "names no walker; write front:SYSTEM/FAMILY/SPEED"),
        ("front:quadruped-c/fast", "'fast' is no speed"),
        ("front:quadruped-c/vanila/0.4", "front of quadruped-c is called 'vanila'"),
        ("front:quadruped-c/9", "no walker within 0.06 of that speed; the nearest has 1.97"),
        ("front:biped/0.4", "system with a front is called 'biped'"),
    ],
)
def test_a_walker_that_no_front_has_is_refused_in_a_line(name, says):
    refused(says, resolve, name)


def test_between_points_the_cost_is_linear_and_beyond_them_unknown():
    curve = front("quadruped-c")
    speed, cost = curve["speed"][:2], curve["cost_of_transport"][:2]
    assert curve.cost_at(speed.mean()) == pytest.approx(cost.mean())
    assert np.isnan(curve.cost_at([0.0, 9.0])).all()


def test_a_body_without_units_of_its_own_has_no_front():
    refused(r"under a bar, .* has no front", lambda: front_family(system("bar-light"), "vanilla"))


def test_every_bin_of_speed_keeps_its_cheapest():
    speed, cost = np.array([0.06, 0.12, 0.07, 0.08]), np.array([3.0, 1.0, 2.0, 5.0])
    assert cheapest(speed, cost, 2).tolist() == [2, 0, 1]


def test_a_search_finds_a_forced_trot_and_only_what_holds():
    search = Search(coarse=24, rounds=1, varied=8, starts=1, unseen=1, duration_s=40.0)
    results = search_front(SHORT, front_family(SHORT, "forced trot"), search)
    assert len(results["speed"]) > 3
    assert (results["upright"] == 1.0).all()
    assert (results["sigma"] == 0.0).all()


def test_a_body_of_which_no_walker_stays_up_has_no_front(tmp_path, capsys):
    words = "gait front biped --walkers 2 --rounds 0 --starts 1 --unseen 1 --duration-s 10 --out"
    assert main([*words.split(), str(tmp_path / "front")]) == 2
    assert "no walker of biped among 2 stays up" in capsys.readouterr().err


def test_an_interrupted_search_continues_from_what_its_parts_gave(tmp_path, monkeypatch):
    vanilla = front_family(SHORT, "forced trot")
    search = Search(coarse=6, rounds=2, varied=4, starts=1, unseen=1, duration_s=20.0)
    complete = search_front(SHORT, vanilla, search)
    measure, measured = FrontPart.measure, []

    def interrupted(part):
        if len(measured) == 2:
            measured.append("stop")
            raise KeyboardInterrupt
        measured.append(part.number)
        return measure(part)

    monkeypatch.setattr(FrontPart, "measure", interrupted)
    with pytest.raises(KeyboardInterrupt, match="keeps 2 of 3 parts"):
        search_front(SHORT, vanilla, search, tmp_path)
    pd.testing.assert_frame_equal(search_front(SHORT, vanilla, search, tmp_path), complete)
    assert measured == [0, 1, "stop", 2]
