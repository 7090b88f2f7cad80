"""Conditions of the gait analyses: ground, delay and noise of the senses, pushes."""

import dataclasses
import math

import numpy as np
import pytest

from refusals import refused
from tegotae.analysis.gaits.lesion import GaitLesion
from tegotae.analysis.gaits.map import (
    Axis,
    check_axis,
    lanes_at,
    settings,
)
from tegotae.analysis.gaits.releases import system_document
from tegotae.api import gaits
from tegotae.api.controllers import load
from tegotae.api.parameters import filled
from tegotae.api.walking import WalkerController
from tegotae.parts.bodies import Sensors
from tegotae.parts.controller import Controller
from tegotae.parts.fields import replace
from tegotae.parts.terrains import Rough, Slope
from tegotae.systems.recipe import recipe
from tegotae.systems.resolve import legged_system as system


def world(name="quadruped-c", **options):
    """The system with these options."""
    walker = load(name, WalkerController)
    defaults = {"terrain": (), "tolerance": 0.1}
    names = dict.fromkeys(("duration_s", "omega", "sigma", "delay_s", "noise", "body"))
    return walker.driven(filled({**names, **defaults, **options}, walker.defaults()))


def test_a_terrain_is_named_with_its_numbers():
    walker = world(terrain=("rough", "rms_m=0.05", "place=2"))
    assert walker.body.terrain == Rough(rms_m=0.05, place=2.0)
    assert world(terrain=("Slope", "along=0.1")).body.terrain == Slope(along=0.1)


def test_what_the_legs_feel_is_late_and_noisy():
    walker = world("bar-light", delay_s=0.02, noise=0.05)
    assert isinstance(walker.body, Sensors)
    assert (walker.body.delay_s, walker.body.noise) == (0.02, 0.05)
    assert walker.body.body == system("bar-light").body
    walker.body.check_tick(walker.timing.tick_s)


def test_fields_are_set_on_the_body_behind_its_sensors():
    walker = world("bar-light", delay_s=0.02, body={"inertia_ratio": 0.35})
    assert walker.body.body.inertia_ratio == 0.35


@pytest.fixture
def late():
    """A bar that is felt late."""
    bar = system("bar-light")
    return bar.on(Sensors(body=bar.body, delay_s=0.01))


def test_an_axis_reaches_the_body_behind_its_sensors(late):
    for axis in (Axis("inertia_ratio", (0.5, 1.5)), Axis("delay_s", (0.0, 0.01))):
        check_axis(late, axis)
        variants = settings(late, [{axis.name: value} for value in axis.values])
        assert not any(variant.refused for variant in variants)
        _, scenario = lanes_at(late, variants, np.zeros((2, 2)))
        (name,) = scenario.changes
        assert name == ("body.inertia_ratio" if axis.name == "inertia_ratio" else "delay_s")
        np.testing.assert_array_equal(scenario.changes[name], axis.values)
    assert variants[1].body.body == late.body.body


def test_a_field_of_a_body_behind_sensors_is_changed_by_a_lesion(late):
    changes = GaitLesion(at_s=10.0, fields=(("inertia_ratio", 1.5),)).scenario(late, 0.0).changes
    assert list(changes) == ["body.inertia_ratio"]


def test_a_push_passes():
    push = GaitLesion(at_s=10.0, fields=(("push_y_n", 0.3),), lasts_s=0.5)
    change = push.scenario(system("quadruped-c"), 0.0).changes["push_y_n"]
    assert (change.value, change.from_s, change.until_s) == (0.3, 10.0, 10.5)
    assert push.label == "push_y_n 0.3 for 0.5 s"
    for_good = GaitLesion(at_s=10.0, fields=(("push_y_n", 0.3),))
    assert for_good.scenario(system("quadruped-c"), 0.0).changes["push_y_n"].until_s == math.inf


def test_a_document_tells_the_world_that_a_gait_was_seen_in():
    walker = world(terrain=("rough", "rms_m=0.02"), delay_s=0.02, noise=0.05)
    body = system_document(walker)["system"]["body"]
    assert body["kind"] == "Sensors"
    assert body["delay_s"] == 0.02
    assert body["body"]["terrain"]["rms_m"] == 0.02


def test_releases_that_would_all_be_the_same_are_refused():
    controller = Controller(recipe("T-F").controller().actuation, limbs=2)  # of no oscillator
    bar = system("bar-light")
    pushed = dataclasses.replace(
        bar,
        system=replace(bar.system, {"controller": controller, "omega": None}),
        weights=(0.0,) * controller.n_weights,
    )
    refused("all would be the same one", gaits.basin, pushed, starts=8)


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ({"terrain": ("sand",)}, "no terrain is called 'sand'"),
        ({"terrain": ("slope", "up=1")}, "no number of the terrain slope is called 'up'"),
        ({"terrain": ("slope", "along")}, "along sets nothing"),
        ({"terrain": ("rough", "rms_m=-1")}, "rms_m is -1"),
        ({"name": "bar-light", "terrain": ("flat",)}, "no field of a Bar is called 'terrain'"),
        ({"delay_s": -1.0}, "delay is -1"),
        ({"delay_s": 1e6}, "delay is 1e"),
        ({"noise": math.nan}, "noise is nan"),
        ({"body": {"weight": 3.0}}, "no field of a Walker is called 'weight'"),
    ],
)
def test_a_world_that_cannot_be_is_refused_in_one_line(options, says):
    refused(says, world, **options)
