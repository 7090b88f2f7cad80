"""Certify controllers, check each certificate, and draw the sets beside the sampled basins.

python -m research.certificate.run
"""

from __future__ import annotations

import json
import time
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd

import tegotae as tg
from research.certificate.check import FREE, TURN, check
from tegotae.parts.fields import replace
from tegotae.simulation.integrators import Hold
from tegotae.simulation.rollout import Timing

HERE = Path(__file__).parent
SUBJECTS: dict[str, tuple[str, dict[str, float]]] = {
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
    "V-reflex-w8": (
        "V-reflex-w8",
        {"least_m_per_s": 0.3, "most_m_per_s": 3.0, "speeds": 64, "phases": 160},
    ),
    "ART-rF-tphi-w4": (
        "zoo:ART-rF-tphi-w4/4",
        {"least_m_per_s": 2.0, "most_m_per_s": 6.5, "speeds": 90, "phases": 200},
    ),
}
"""Name of the controller and grid of each certificate."""
MOST_RANK = {"ART-rF-tphi-w4": 1}
"""Largest rank that a certificate keeps; the checker's bounds are too wide for larger ones."""
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


def main() -> None:
    """Write the certificates, the table and the picture."""
    rows, drawn = [], []
    for name, (source, grid) in SUBJECTS.items():
        controller = tg.load(source)
        assert isinstance(controller, tg.HopperController)
        file = name.split(" %")[0].replace(", ", "-").replace(" ", "-")
        path, start_s = HERE / f"{file}-certificate.json", time.process_time()
        path.unlink(missing_ok=True)
        controller.certify(**grid).save(path)  # pyright: ignore[reportArgumentType]
        searched_s, certificate = time.process_time() - start_s, json.loads(path.read_text("utf-8"))
        if name in MOST_RANK:
            ranks = np.array(certificate["ranks"])
            kept = (ranks <= MOST_RANK[name]) | (ranks == FREE)
            certificate["ranks"] = np.where(kept, ranks, -1).tolist()
            path.write_text(json.dumps(certificate) + "\n", "utf-8")
        start_s = time.process_time()
        proved = check(certificate)
        checked_s = time.process_time() - start_s
        ranks = np.array(certificate["ranks"])
        hops, orbit = basin(controller, certificate)
        members = ranks >= 0
        rows.append(
            {
                "controller": name,
                "weights": len(certificate["law"]["weights"]),
                "cells": ranks.size,
                "certified": members.mean(),
                "basin": hops.mean(),
                "share_of_basin": (members & hops).sum() / hops.sum(),
                "core_cells": int((ranks == 0).sum()),
                "most_hops": int(ranks[ranks != FREE].max()),
                "free_cells": int((ranks == FREE).sum()),
                "least_apex_m": proved["apex_m"][0],
                "most_apex_m": proved["apex_m"][1],
                "lasting_least_apex_m": proved["lasting_apex_m"][0],
                "lasting_most_apex_m": proved["lasting_apex_m"][1],
                "least_height_m": proved["least_height_m"][0],
                "cot_inverse_m_per_j": proved["cot_inverse_m_per_j"][0],
                "search_s": searched_s,
                "check_s": checked_s,
            }
        )
        drawn.append((name, grid, ranks, hops, orbit))
    table = pd.DataFrame(rows)
    table.round(4).to_csv(HERE / "certificates.csv", index=False)
    _draw(drawn)


def _draw(drawn: list[tuple[Any, ...]]) -> None:
    """Draw the certified cells over the sampled basin, with the limit cycle."""
    figure, axes = plt.subplots(1, len(drawn), figsize=(5.2 * len(drawn), 4.2), squeeze=False)
    for axis, (name, grid, ranks, hops, (speed, phase)) in zip(axes[0], drawn, strict=True):
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
    main()
