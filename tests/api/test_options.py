"""Options are the subject's own values: every parameter of a method, and every body's fields."""

import dataclasses
import inspect
from collections.abc import Mapping
from typing import Any, get_args

import numpy as np
import pytest

import tegotae as tg
from tegotae import Hopper, TegotaeError
from tegotae.api.controllers import HopperName, WalkerName, kinds, load
from tegotae.api.hopping import HopperController
from tegotae.api.parameters import leaves, options_of, with_options
from tegotae.cli.commands import COMMANDS
from tegotae.cli.program import Command, CommandGroup
from tegotae.parts.bodies import Sensors, Walker
from tegotae.systems.recipe import study_recipes
from tegotae.systems.vanilla import PRESETS, SYSTEMS


@pytest.mark.parametrize("name", ["paper", "pyTegotaeCPG-both+matsuoka", "zoo:ART", *SYSTEMS])
def test_every_number_of_a_body_is_an_option_that_says_what_it_is(name):
    controller = load(name)
    for method in (controller.simulate, controller.evaluate):
        options = options_of(method, controller.defaults())
        assert {"mass_kg", "gravity_m_per_s2", "omega"} < {*options}
        assert [name for name, option in options.items() if not option.description] == []


def test_a_body_is_an_object_or_changes_of_the_controllers_own():
    heavier = Hopper(mass_kg=0.2)
    runs = [
        load("paper").simulate(duration_s=1.0, body=heavier),
        load("paper").simulate(duration_s=1.0, body={"mass_kg": 0.2}),
        load("paper", body=heavier).simulate(duration_s=1.0),
    ]
    assert all(run.settings == runs[0].settings for run in runs)
    assert all(run.table.equals(runs[0].table) for run in runs)


def test_one_number_holds_for_every_leg_and_of_wrappers_the_outer_one_is_meant():
    wrapped = Sensors(body=Walker(), delay_s=0.1)
    made = with_options(wrapped, {"hips_x_m": 0.5, "delay_s": 0.2})
    assert (made.body.hips_x_m, made.delay_s) == ((0.5,) * 4, 0.2)


def test_a_new_field_of_a_body_is_an_option():
    @dataclasses.dataclass(frozen=True, kw_only=True)
    class Heavier(Hopper):
        load_kg: float = 1.0
        """Its load [kg]."""

    (option,) = (option for option in leaves(Heavier()) if option.name == "load_kg")
    assert (option.path, option.kind, option.description) == ("load_kg", float, "Its load [kg].")


def test_an_unknown_field_is_named_with_the_nearest_one():
    with pytest.raises(TegotaeError, match="no field of a Walker is called 'fricton'; did you"):
        load("quadruped-c").simulate(body={"fricton": 1.0})


def functions(entry: Command | CommandGroup | Mapping[str, Any]) -> list[Any]:
    """The functions of commands, and the methods of every kind of controller."""
    if isinstance(entry, Command):
        function = entry.load()
        if not inspect.isfunction(function):
            return []
        if next(iter(inspect.signature(function).parameters), "") != "self":
            return [function]
        return [getattr(kind, function.__name__) for kind, _ in kinds().values()]
    below = entry.commands if isinstance(entry, CommandGroup) else entry
    return [function for inner in below.values() for function in functions(inner)]


FUNCTIONS = functions(COMMANDS)


PAPER, WALKER = tg.load("paper"), tg.load("quadruped-c")


@pytest.mark.parametrize(
    ("verb", "options", "message"),
    [
        (PAPER.simulate, {"duration_s": "4"}, "duration_s is '4'; it must be a number"),
        (PAPER.simulate, {"omega": True}, "omega is True; it must be a number"),
        (PAPER.simulate, {"hold": 1}, "hold is 1; it must be True or False"),
        (PAPER.simulate, {"body": 3}, "body is 3; it must be a Body or a mapping of changes"),
        (PAPER.simulate, {"work": 3}, "work is 3; it must be one of absolute, positive, net"),
        (PAPER.evaluate, {"metric": "cot"}, "metric is 'cot'; it must be a list of texts"),
        (PAPER.evaluate, {"protocol": 3}, "protocol is 3; it must be a Protocol or a mapping"),
        (PAPER.explain, {"releases": 2.5}, "releases is 2.5; it must be a whole number"),
        (PAPER.compare, {"omega": [4.0]}, r"omega is \[4.0\]; it must be a number"),
        (PAPER.robustness, {"out": 5}, "out is 5; it must be a path or a text"),
        (WALKER.simulate, {"seed": "1"}, "seed is '1'; it must be a whole number"),
        (tg.train, {"seeds": 4.0}, "seeds is 4.0; it must be a whole number"),
        (tg.train, {"tuned_over": "1"}, "tuned_over is '1'; it must be a list of numbers"),
        (tg.plot.basin, {"resolution": "20"}, "resolution is '20'; it must be a whole number"),
        (tg.gaits.map, {"x": ("sigma", 1)}, "it must be a list of a text, a number, a number"),
        (tg.gaits.map, {"cells": (3.5, 2)}, "it must be a list of a whole number, a whole number"),
        (tg.robots.export_c, {"tick_s": "1"}, "tick_s is '1'; it must be a number"),
    ],
)
def test_an_option_of_another_type_is_refused_with_its_value_and_the_right_type(
    verb, options, message
):
    with pytest.raises(tg.TegotaeError, match=message):
        verb("paper", **options)


@pytest.mark.parametrize("number", [np.float32(0.2), np.array(0.2), np.float64(0.2)])
def test_a_number_of_numpy_is_a_number(number):
    assert len(PAPER.simulate(duration_s=number, hold=np.bool_(True)).table) == 20


@pytest.mark.parametrize("function", FUNCTIONS, ids=lambda x: f"{x.__module__}.{x.__qualname__}")
def test_every_function_of_a_command_has_typed_keywords_that_its_docstring_explains(function):
    said = inspect.getdoc(function) or ""
    for name, parameter in inspect.signature(function).parameters.items():
        assert name == "self" or parameter.annotation is not parameter.empty
        assert parameter.kind is not parameter.VAR_KEYWORD
        assert parameter.annotation != "Any" or name == "entry"
        assert name == "self" or f"    {name}: " in said, name


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: PAPER.simulate(omga=5.0), "simulate is called 'omga'; did you mean omega"),
        (lambda: tg.train("ART", sedes=3), "train is called 'sedes'; did you mean seeds"),
        (lambda: tg.train(modle="ART"), "train is called 'modle'; did you mean model"),
        (lambda: tg.list_models(zo=True), "list_models is called 'zo'; did you mean zoo"),
        (lambda: tg.gaits.basin("bar-light", strats=8), "'strats'; did you mean starts"),
    ],
    ids=["simulate", "train", "a name", "list_models", "basin"],
)
def test_a_wrong_keyword_is_refused_with_the_nearest_ones(call, message):
    with pytest.raises(TypeError, match=message):
        call()


def test_options_that_functions_share_have_their_defaults_in_the_signature():
    assert inspect.signature(tg.gaits.basin).parameters["seed"].default == 0


def test_the_names_that_a_type_checker_knows_are_those_of_the_registries():
    assert {*get_args(WalkerName)} == {*SYSTEMS}
    models = study_recipes()
    vanilla = {"V", *(name for name, model in models.items() if model.terms.architecture == "V")}
    drives = ("", "-sector", "-reflex", "-both")
    presets = {f"{name}{drive}" for name in PRESETS for drive in drives}
    architectures = {f"zoo:{model.terms.architecture}" for model in models.values()}
    assert {*get_args(HopperName)} == vanilla | presets | architectures
    assert all(isinstance(load(name), HopperController) for name in get_args(HopperName))
