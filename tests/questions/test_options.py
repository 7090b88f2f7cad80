"""Options are the subject's own values: every body's fields, by a name without unit."""

from __future__ import annotations

import dataclasses

import pytest

from tegotae import Hopper, TegotaeError
from tegotae.parts.bodies import Sensors, Walker
from tegotae.questions.options import changed, options_of
from tegotae.questions.tasks import tasks_of
from tegotae.systems.legged import SYSTEMS

QUESTIONS = ("simulate", "evaluate")


@pytest.mark.parametrize("name", ["paper", "pyTegotaeCPG-both+matsuoka", "zoo:ART", *SYSTEMS])
def test_every_number_of_a_body_is_an_option_that_says_what_it_is(name):
    (task,) = tasks_of(name)
    for question in QUESTIONS:
        known = options_of(getattr(task, f"{question}_options")())
        assert {"mass", "gravity", "omega"} < {*known}
        assert [name for name, option in known.items() if not option.about] == []


def test_a_unit_may_be_left_out_and_a_part_of_the_options_replaced():
    (task,), (heavier,) = tasks_of("paper"), tasks_of("paper", body=Hopper(mass_kg=0.2))
    for name in ("mass", "mass_kg"):
        options = changed(task.simulate_options(), {name: 0.2}, task.name)
        assert options == heavier.simulate_options()


def test_one_number_holds_for_every_leg_and_of_wrappers_the_outer_one_is_meant():
    wrapped = Sensors(body=Walker(), delay_s=0.1)
    found = changed(wrapped, {"hips_x": 0.5, "delay": 0.2}, "a walker")
    assert (found.body.hips_x_m, found.delay_s) == ((0.5,) * 4, 0.2)


def test_a_new_field_of_a_body_is_an_option():
    @dataclasses.dataclass(frozen=True, kw_only=True)
    class Heavier(Hopper):
        load_kg: float = 1.0
        """Its load [kg]."""

    option = options_of(Heavier())["load"]
    assert (option.path, option.kind, option.about) == ("load_kg", float, "Its load [kg].")


def test_an_unknown_option_is_named_with_the_nearest_one():
    (task,) = tasks_of("quadruped-c")
    with pytest.raises(TegotaeError, match=r"no option of quadruped-c is called 'drap'; did you"):
        changed(task.simulate_options(), {"drap": 1.0}, task.name)
