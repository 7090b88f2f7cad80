"""Controller files, made up."""

import dataclasses
import json
from functools import cache
from typing import Any

import numpy as np

from tegotae import Hopper
from tegotae.systems import controller_file
from tegotae.systems.controller_file import SavedController
from tegotae.systems.recipe import recipe


def example(name: str = "ART-rFv-tphif-w8", budget: int = 30) -> SavedController:
    """A controller with random weights and something in every entry."""
    model = recipe(name)
    controller = model.controller(budget)
    weights = np.random.default_rng(0).normal(size=controller.n_weights)
    return SavedController.from_weights(
        controller,
        weights.astype("float32"),
        model.omega_t,
        Hopper(mass_kg=0.2, flight_damping_ns_per_m=0.1),
        name=model.name,
        training={"seed": 3, "best_fitness": 1.25, "seeds": [0, 3], "note": None},
        software={"tegotae": "0.1.0"},
    )


@cache
def text() -> str:
    """A sound file."""
    saved = example()
    document: dict[str, Any] = {
        "format": controller_file.FORMAT,
        "version": controller_file.VERSION,
        "name": saved.name,
        "system": {
            "controller": {
                "actuation": {
                    "kind": "Sector",
                    "start_rad": 5.5,
                    "width_rad": 0.3,
                    "duration_s": 0.0,
                },
                "oscillator": {"kind": "PhaseOscillator", "slowest_rad_per_s": None},
                "tegotae": {
                    "action": {"kind": "Network", "inputs": ["phase"], "hidden": 1},
                    "reaction": {"kind": "VanillaReaction"},
                    "gain": {"kind": "ConstantGain", "start": 1.0},
                    "limit_rad_per_s": None,
                },
            },
            "body": {"kind": "Hopper", **dataclasses.asdict(Hopper())},
            "omega": saved.omega,
        },
        "weights": [0.5, -1, 2.0, 0.25, 3.0],
        "experiment": None,
        "training": {"seed": 0},
        "software": {},
    }
    return json.dumps(document, indent=1) + "\n"
