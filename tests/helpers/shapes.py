"""Rolls out a few ticks of every body while annotated shapes and types are checked.

Run as a program with names of bodies, in a process of its own: checked modules are other modules.
"""

from __future__ import annotations

import dataclasses
import sys

import jax
from beartype import BeartypeConf, FrozenDict, beartype
from jaxtyping import install_import_hook

# What is a number for a user is an array inside a compiled program (`parameters.traceable`).
checked = beartype(conf=BeartypeConf(hint_overrides=FrozenDict({float: float | int | jax.Array})))


def main(names: list[str]) -> None:
    """Print the shape of each body's recorded heights."""
    with install_import_hook(["tegotae.parts", "tegotae.simulation"], "shapes.checked"):
        pass
    from tegotae.parts.bodies import Actuators, Blows, Hopper, Sensors
    from tegotae.simulation.rollout import Timing
    from tegotae.systems.legged_systems import bar, plate, quadruped_c
    from tegotae.systems.models import build
    from tegotae.systems.system import System

    def hopping(body):
        return System(controller=build("V-reflex-w8"), body=body, omega=8.0), (1.0,)

    def legged(found):
        return found.system, found.weights

    made = {
        "hopper": lambda: hopping(Hopper()),
        "wrapped hopper": lambda: hopping(Blows(body=Actuators(body=Sensors(body=Hopper())))),
        "bar": lambda: legged(bar(1.0)),
        "plate": lambda: legged(plate(1.0, 1.0, 1.0)),
        "walker": lambda: legged(quadruped_c()),
    }
    for name in names:
        system, weights = made[name]()
        found = dataclasses.replace(system, timing=Timing(duration_s=0.04)).run(weights)
        print(name, found.height_m.shape)


if __name__ == "__main__":
    main(sys.argv[1:])
