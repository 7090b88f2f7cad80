"""Certify controllers, check each certificate, and draw the sets beside the sampled basins.

python -m research.certificate.run [NAME ...]
"""

from __future__ import annotations

import json
import sys
import time
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd

import tegotae as tg
from research.certificate.check import FREE, TURN, Law, check, hop
from tegotae.analysis.certificate import Grid, Hop, largest_set, ranked
from tegotae.parts.fields import replace
from tegotae.simulation.integrators import Hold
from tegotae.simulation.rollout import Timing

HERE = Path(__file__).parent
SUBJECTS: dict[str, tuple[str, dict[str, Any]]] = {
    "latch": (
        str(HERE / "latch.json"),
        {"least_m_per_s": 0.5, "most_m_per_s": 6.5, "speeds": 60, "phases": 150},
    ),
    "latch, load within 1 %": (
        str(HERE / "latch.json"),
        {
            "least_m_per_s": 0.5,
            "most_m_per_s": 6.5,
            "speeds": 60,
            "phases": 150,
            "load_error": 0.01,
        },
    ),
    "latch, mass and stiffness within 2 %": (
        str(HERE / "latch.json"),
        {
            "least_m_per_s": 0.5,
            "most_m_per_s": 6.5,
            "speeds": 60,
            "phases": 150,
            "stiffness_error": 0.02,
            "mass_error": 0.02,
            "splits": 5,
        },
    ),
    "V-reflex-w8": (
        "V-reflex-w8",
        {"least_m_per_s": 0.3, "most_m_per_s": 3.0, "speeds": 64, "phases": 160},
    ),
    "ART-rF-tphi-w4": (
        "zoo:ART-rF-tphi-w4/4",
        {"least_m_per_s": 2.0, "most_m_per_s": 6.5, "speeds": 180, "phases": 400},
    ),
}
"""Name of the controller and grid of each certificate."""
RANKED_BY_CHECKER = {"ART-rF-tphi-w4"}
"""Certificates whose ranks come from the checker's bounds, which are wider for networks."""
BASIN_S = 12.0
"""Simulated time after which a landing counts as one of the basin if the body still hops."""


def basin(controller: tg.HopperController, certificate: dict[str, Any]) -> tuple[Any, Any]:
    """Return which centres of the cells hop on, [speeds, phases], and the landings of one orbit."""
    grid, tick_s = certificate["grid"], certificate["law"]["tick_s"]
    step = (grid["most_m_per_s"] - grid["least_m_per_s"]) / grid["speeds"]
    speed = grid["least_m_per_s"] + step * (np.arange(grid["speeds"]) + 0.5)
    phase = TURN / grid["phases"] * (np.arange(grid["phases"]) + 0.5)
    v, p = (x.ravel() for x in np.meshgrid(speed, phase, indexing="ij"))
    saved = controller.saved
    length = certificate["body"]["rest_length_m"]
    timing = Timing(duration_s=BASIN_S, tick_s=tick_s, frame_s=20 * tick_s)
    system = replace(saved.system, {"integrator": Hold(), "timing": timing})
    start = system.scenario(height_m=length - 0.5 * v * tick_s, velocity_m_per_s=-v, phase_rad=p)
    y = system.run(saved.weights, start, dtype="float64")
    late = y.height_m[-150:].max(axis=0) > length + 1e-3
    hops = (late & ~y.failed[-1]).reshape(grid["speeds"], grid["phases"])
    fine = replace(system, {"timing": Timing(duration_s=BASIN_S, tick_s=tick_s, frame_s=tick_s)})
    y = fine.run(saved.weights, fine.scenario(), dtype="float64")
    lands = np.flatnonzero((y.height_m[1:, 0] < length) & (y.height_m[:-1, 0] >= length))[-3:] + 1
    return hops, (-y.velocity_m_per_s[lands, 0], y.phase_rad[lands, 0] % TURN)


def ranks_by_checker(certificate: dict[str, Any]) -> Any:
    """Return the ranks that the checker's own images of the certified cells allow."""
    sizes = certificate["grid"]
    grid = Grid(*(sizes[x] for x in ("least_m_per_s", "most_m_per_s", "speeds", "phases")))
    members = np.flatnonzero(np.ravel(certificate["ranks"]) >= 0)
    (law, body, errors), bounds = (certificate[x] for x in ("law", "body", "errors")), grid.cells()
    parts = [
        hop(Law(law, body), body, errors, *[(lo[part], hi[part]) for lo, hi in bounds])
        for part in np.array_split(members, len(members) // 1024 + 1)
    ]
    image = np.full((4, sizes["speeds"] * sizes["phases"]), np.nan)
    image[:, members] = [np.concatenate(x) for x in list(zip(*parts, strict=True))[:4]]
    hops = np.isfinite(image[0])
    rectangles = grid.rectangles(Hop(image[:2], image[2:], image[:2], 0.0, 0.0, hops))
    return ranked(largest_set(grid, rectangles), rectangles)


def path_of(name: str) -> Path:
    """Return the file of a certificate."""
    file = name.split(" %")[0].replace(", ", "-").replace(" ", "-")
    return HERE / f"{file}-certificate.json"


def certified(name: str) -> dict[str, Any]:
    """Search, check and write a certificate; return its row of the table."""
    source, grid = SUBJECTS[name]
    start_s = time.process_time()
    certificate = json.loads(json.dumps(hopper(source).certify(**grid).to_dict()))
    if name in RANKED_BY_CHECKER:
        certificate |= {"ranks": ranks_by_checker(certificate).tolist(), "claims": {}}
    return checked(name, certificate, time.process_time() - start_s)


def checked(name: str, certificate: dict[str, Any], search_s: float) -> dict[str, Any]:
    """Check and write a certificate; return its row of the table."""
    start_s = time.process_time()
    proved = check(certificate)
    check_s = time.process_time() - start_s
    if not certificate["claims"]:  # what was proved, with room for another library's rounding
        room = {"apex_m": [-1e-6, 1e-6], "lasting_apex_m": [-1e-6, 1e-6]}
        certificate["claims"] = {
            claim: (np.array(proved[claim]) + room.get(claim, [-1e-6])).tolist()
            for claim in ("apex_m", "lasting_apex_m", "least_height_m", "cot_inverse_m_per_j")
        }
    path_of(name).write_text(json.dumps(certificate, separators=(",", ":")) + "\n", "utf-8")
    ranks = np.array(certificate["ranks"])
    hops, _ = basin(hopper(SUBJECTS[name][0]), certificate)
    return {
        "controller": name,
        "weights": len(certificate["law"]["weights"]),
        "cells": ranks.size,
        "certified": (ranks >= 0).mean(),
        "basin": hops.mean(),
        "share_of_basin": ((ranks >= 0) & hops).sum() / hops.sum(),
        "core_cells": int((ranks == 0).sum()),
        "most_hops": int(ranks[ranks != FREE].max()),
        "free_cells": int((ranks == FREE).sum()),
        "least_apex_m": proved["apex_m"][0],
        "most_apex_m": proved["apex_m"][1],
        "lasting_least_apex_m": proved["lasting_apex_m"][0],
        "lasting_most_apex_m": proved["lasting_apex_m"][1],
        "least_height_m": proved["least_height_m"][0],
        "cot_inverse_m_per_j": proved["cot_inverse_m_per_j"][0],
        "search_s": search_s,
        "check_s": check_s,
    }


def hopper(source: str) -> tg.HopperController:
    """Return a controller of one leg."""
    controller = tg.load(source)
    assert isinstance(controller, tg.HopperController)
    return controller


def main(names: list[str]) -> None:
    """Write certificates and their rows of the table, and draw all."""
    for name in names or list(SUBJECTS):
        keep(certified(name))
    _draw()


def keep(row: dict[str, Any]) -> None:
    """Put a row into the table in the place of an older one."""
    path = HERE / "certificates.csv"
    table = pd.read_csv(path).set_index("controller", drop=False)
    rows = {**table.to_dict("index"), row["controller"]: row}
    results = pd.DataFrame([rows[name] for name in SUBJECTS if name in rows])
    results.round(4).to_csv(path, index=False)


def _draw() -> None:
    """Draw the certified cells over the sampled basin, with the limit cycle."""
    names = [name for name in SUBJECTS if path_of(name).exists()]
    figure = plt.figure(figsize=(15.6, 8.4))
    for place, name in enumerate(names, 1):
        axis = figure.add_subplot(2, 3, place)
        source, grid = SUBJECTS[name]
        certificate = json.loads(path_of(name).read_text("utf-8"))
        ranks = np.array(certificate["ranks"])
        hops, (speed, phase) = basin(hopper(source), certificate)
        extent = (0.0, 2.0, grid["least_m_per_s"], grid["most_m_per_s"])
        layout = {"extent": extent, "origin": "lower", "aspect": "auto", "interpolation": "nearest"}
        axis.imshow(np.where(hops, 0.82, 1.0), cmap="gray", vmin=0.0, vmax=1.0, **layout)
        members = np.ma.masked_where((ranks < 0) | (ranks == FREE), ranks)
        image = axis.imshow(members, cmap="viridis_r", **layout)
        figure.colorbar(image, ax=axis, label="hops to the core")
        axis.plot(phase / np.pi, speed, "o", color="red", ms=4, label="landings of the simulation")
        axis.set(title=name, xlabel="phase φ at landing [π rad]", ylabel="landing speed [m/s]")
        axis.legend(loc="lower right", fontsize=8)
    figure.tight_layout()
    figure.savefig(HERE / "certificates.png", dpi=110)


if __name__ == "__main__":
    main(sys.argv[1:])
