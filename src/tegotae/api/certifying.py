"""The verb `certify`: a set of landings from which a hopper hops for ever."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from tegotae._support.errors import TegotaeError, require_count, require_finite
from tegotae._support.files import write_atomically
from tegotae._support.limits import MOST_POINTS
from tegotae.analysis.certificate import FREE, Grid, bounded_law, certificate
from tegotae.api.controller import LoadedController
from tegotae.api.hopping import HopperController
from tegotae.api.results import JsonFile

_HEADINGS = {
    "cells": ("certified cells of the grid", "{:.1%}"),
    "core": ("cells of the core, where orbits of ranked cells stay", "{:d}"),
    "hops": ("most hops from a ranked cell to the core", "{:d}"),
    "free": ("cells without a rank", "{:d}"),
    "least_apex_m": ("least apex [m]", "{:.3f}"),
    "most_apex_m": ("largest apex [m]", "{:.3f}"),
    "least_height_m": ("least height [m]", "{:.3f}"),
    "cot_inverse_m_per_j": ("least CoT⁻¹ in the long run [m/J]", "{:.3f}"),
}


def certify(controller: LoadedController, options: Any) -> JsonFile:
    """Certify a set of landings (`LoadedController.certify`).

    Args:
        controller: the controller.
        options: parameters of the method.

    Raises:
        TegotaeError: for a law or a body without known bounds, or if no set is certified.
    """
    hopper = controller.require(
        HopperController, "certify bounds the hops of a body with one leg of this package"
    )
    require_finite("tick_s", options.tick_s, above=0.0)
    require_finite("least_m_per_s", options.least_m_per_s, above=0.0)
    require_finite("most_m_per_s", options.most_m_per_s, above=options.least_m_per_s)
    require_count("speeds", options.speeds, most=MOST_POINTS)
    require_count("phases", options.phases, most=MOST_POINTS)
    grid = Grid(options.least_m_per_s, options.most_m_per_s, options.speeds, options.phases)
    errors = {"load": options.load_error}
    errors |= {"stiffness": options.stiffness_error, "mass": options.mass_error}
    for name, most in (("load", 1e3), ("stiffness", 0.1), ("mass", 0.1)):
        require_finite(f"{name}_error", errors[name], least=0.0, most=most)
    law = bounded_law(hopper.saved, **errors)
    if law.fastest_rad_per_s * options.tick_s > 0.1:
        raise TegotaeError(
            f"tick_s is {options.tick_s:g}; bounds of stance need a tick of at most "
            f"{0.1 / law.fastest_rad_per_s:.2g} s on this leg"
        )
    require_count("splits", options.splits, most=64)
    document: Any = certificate(law, options.tick_s, grid, hopper.name, options.splits)
    ranks, claims = np.array(document["ranks"]), document["claims"]
    numbers = {
        "cells": float((ranks >= 0).mean()),
        "core": int((ranks == 0).sum()),
        "hops": int(ranks[ranks != FREE].max()),
        "free": int((ranks == FREE).sum()),
        "least_apex_m": claims["apex_m"][0],
        "most_apex_m": claims["apex_m"][1],
        "least_height_m": claims["least_height_m"],
        "cot_inverse_m_per_j": claims["cot_inverse_m_per_j"],
    }
    rows = [(heading, text.format(numbers[name])) for name, (heading, text) in _HEADINGS.items()]

    def write(path: Path) -> None:
        write_atomically(path, json.dumps(document) + "\n")

    return JsonFile(
        raw=document,
        write=write,
        title=f"{hopper.name} hops for ever from {numbers['cells']:.1%} of {ranks.size} landings",
        rows=pd.DataFrame([numbers]),
        views=[pd.DataFrame(rows, columns=["claim", "value"]).set_index("claim")],
        notes=[
            f"Weights: SHA-256 {document['sha256']}",
            "To prove the file, run research/certificate/check.py on it.",
        ],
        data=document,
    )
