"""Rolls out a few ticks of every body while annotated shapes and types are checked.

Run as a program with names of bodies, in a process of its own: checked modules are other modules.
"""

import dataclasses
import functools
import importlib.util
import operator
import sys
import types
from pathlib import Path
from typing import Annotated, Any, Union, get_args, get_origin

import jax
from beartype import BeartypeConf, FrozenDict, beartype
from jaxtyping import Bool, Float, Int, PyTree, install_import_hook

# What is a number for a user is an array inside a compiled program (`parameters.traceable`).
checked = beartype(conf=BeartypeConf(hint_overrides=FrozenDict({float: float | int | jax.Array})))

_KINDS = {"float": Float, "bool": Bool, "int": Int}


def checkable(annotation: Any) -> Any:
    """An annotation of `tegotae.parts._shapes` as jaxtyping has it."""
    origin, arguments = get_origin(annotation), get_args(annotation)
    if origin is Annotated:
        array, kind, shape = arguments
        return PyTree[checkable(shape)] if kind == "tree" else _KINDS[kind][array, shape]
    if origin in (Union, types.UnionType):
        return functools.reduce(operator.or_, map(checkable, arguments))
    return origin[checkable(*arguments)] if arguments else annotation


def _make_shapes_checkable() -> None:
    # The module alone, before the modules that take the names from it.
    package = importlib.util.find_spec("tegotae.parts")
    name, path = "tegotae.parts._shapes", Path(package.origin).with_name("_shapes.py")
    spec = importlib.util.spec_from_file_location(name, path)
    module = sys.modules[name] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    for alias, annotation in vars(module).copy().items():
        if get_args(annotation):
            setattr(module, alias, checkable(annotation))


def main(names: list[str]) -> None:
    """Print the shape of each body's recorded heights."""
    _make_shapes_checkable()
    install_import_hook(["tegotae.parts", "tegotae.simulation"], "shapes.checked")
    from tegotae.parts.bodies import Actuators, Blows, Hopper, Plate, Sensors
    from tegotae.simulation.rollout import Timing
    from tegotae.systems.recipe import recipe
    from tegotae.systems.system import System
    from tegotae.systems.vanilla import SYSTEMS, hopping as legs_under

    def hopping(body):
        return System(controller=recipe("V-reflex-w8").controller(), body=body, omega=8.0), (1.0,)

    def legged(result):
        return result.system, result.weights

    created = {
        "hopper": lambda: hopping(Hopper()),
        "wrapped hopper": lambda: hopping(Blows(body=Actuators(body=Sensors(body=Hopper())))),
        "bar": lambda: legged(SYSTEMS["bar-light"]()),
        "plate": lambda: legged(legs_under("", Plate(twist_inertia_ratio=1.0))),
        "walker": lambda: legged(SYSTEMS["quadruped-c"]()),
    }
    for name in names:
        system, weights = created[name]()
        results = dataclasses.replace(system, timing=Timing(duration_s=0.04)).run(weights)
        print(name, results.height_m.shape)


if __name__ == "__main__":
    main(sys.argv[1:])
