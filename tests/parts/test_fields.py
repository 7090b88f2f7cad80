"""A body's numbers are found by name in one place, whatever is around the body."""

import numpy as np
import pytest

from refusals import refused
from tegotae import Rollout, Scenario, Timing
from tegotae._support.errors import TegotaeError
from tegotae.parts.bodies import (
    Actuators,
    Bar,
    Hopper,
    Sensors,
    Walker,
)
from tegotae.parts.fields import (
    number_of,
    numbers_of,
    path_of,
    replace,
    unwrapped,
    value_of,
)
from tegotae.parts.terrains import Slope
from tegotae.systems.recipe import recipe

WRAPPED = Sensors(body=Actuators(body=Hopper(mass_kg=0.2)), delay_s=0.01)


@pytest.mark.parametrize(
    ("name", "path"),
    [
        ("delay_s", "delay_s"),
        ("strength", "body.strength"),
        ("mass_kg", "body.body.mass_kg"),
        ("body.mass_kg", "body.body.mass_kg"),
        ("body.body.mass_kg", "body.body.mass_kg"),
    ],
)
def test_a_name_or_a_path_finds_the_same_field(name, path):
    assert path_of(WRAPPED, name) == path
    assert value_of(WRAPPED, name) == value_of(WRAPPED, path)


def test_a_field_of_a_terrain_is_found_through_the_wrappers():
    body = Sensors(body=Walker(terrain=Slope(along=0.1)))
    assert path_of(body, "terrain.along") == "body.terrain.along"
    assert replace(body, {"terrain.along": 0.2}).body.terrain.along == 0.2


def test_the_body_within_is_what_no_wrapper_is_around():
    assert unwrapped(WRAPPED) == Hopper(mass_kg=0.2)
    assert unwrapped(Bar()) == Bar()


def test_numbers_are_those_of_the_body_and_of_its_wrappers():
    numbers = numbers_of(Sensors(body=Bar()))
    assert numbers["inertia_ratio"] == 1.0
    assert numbers["delay_s"] == 0.0
    assert "body" not in numbers


def test_one_number_for_a_field_of_the_limbs_holds_for_each():
    assert replace(Walker(), {"present": 1.0}).present == (1.0,) * 4


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("mas_kg", "did you mean mass_kg"),
        ("body.body.body", "field of a Hopper"),
        ("terrain.along", "terrain"),
        ("mass_kg.value", "value"),
    ],
)
def test_a_field_that_is_not_there_is_refused_with_the_body_that_lacks_it(name, message):
    refused(message, path_of, WRAPPED, name)


def test_what_is_no_number_is_refused():
    refused("no change can make a number", lambda: number_of(Walker(), "terrain"))


def test_a_change_names_a_number_of_a_wrapped_body_as_of_the_body_alone():
    rollout = Rollout(controller=recipe("V-reflex-w8").controller(), timing=Timing(duration_s=0.5))

    def run(name):
        return rollout.run([2.0], Scenario(omega=8.0, changes={name: [0.1, 0.15]}), WRAPPED)

    np.testing.assert_array_equal(run("mass_kg").height_m, run("body.body.mass_kg").height_m)


def test_a_field_of_an_experiment_is_found_in_its_system_and_its_release():
    experiment = recipe("AR").experiment()
    other = replace(experiment, {"name": "low", "height_m": 1.1, "timing.duration_s": 30.0})
    assert (other.name, other.system.release.height_m, other.timing.duration_s) == ("low", 1.1, 30)
    assert replace(other, {"system.body.mass_kg": 0.2}).body == Hopper(mass_kg=0.2)


def test_a_new_part_and_a_field_in_it_are_replaced_at_once():
    experiment = recipe("AR").experiment()
    heavy = replace(experiment, {"body": Hopper(mass_kg=0.2), "body.damping_ns_per_m": 0.1})
    assert heavy.body == Hopper(mass_kg=0.2, damping_ns_per_m=0.1)


def test_a_field_that_no_part_of_an_experiment_has_is_refused_with_the_nearest_one():
    with pytest.raises(TegotaeError, match="no field of a Experiment is called 'heigth_m'"):
        replace(recipe("AR").experiment(), {"heigth_m": 1.1})
