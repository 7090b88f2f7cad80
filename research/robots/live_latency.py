"""Measure the jitter of a live controller's loop on this machine: a simulated leg at 1 kHz.

The page on driving hardware shows its figure:

    python -m research.robots.live_latency --duration 600 --out docs/_static/live
"""

from __future__ import annotations

import csv
import re
import time
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np

from research.frame import main
from tegotae_robots.api.robots import export_native
from tegotae_robots.live import LiveController, LoopReport, drive_hardware

matplotlib.use("Agg")
import matplotlib.pyplot as plt

PAGE = Path(__file__).resolve().parents[2] / "docs" / "deploy" / "live.md"
QUANTILES = (0.5, 0.9, 0.99, 0.999, 0.9999, 1.0)
STEPS = 100_000


def page_leg() -> Any:
    """Return the simulated leg of the page."""
    (source,) = re.findall(r"# my_leg\.py\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.S)
    namespace: dict = {}
    exec(source, namespace)
    return namespace["Leg"]()


def steps_alone_s(live: LiveController) -> np.ndarray:
    """Return the times of steps without a plant [s]."""
    times = np.empty(STEPS)
    for i in range(STEPS):
        begun = time.perf_counter()
        live.step({"spring_force": 3.0}, 0.001)
        times[i] = time.perf_counter() - begun
    return times


def draw(report: LoopReport, path: Path) -> None:
    """Draw both histograms."""
    figure, axes = plt.subplots(1, 2, figsize=(8, 3), sharey=True, layout="constrained")
    edges = np.geomspace(0.1, 1e7, 65)
    for ax, title, times in zip(
        axes,
        ("late", "read, step and write"),
        (report.late_s, report.busy_s),
        strict=True,
    ):
        ax.hist(np.clip(1e6 * times, 0.1, None), edges, color="tab:blue")
        ax.set(xscale="log", yscale="log", xlabel="time [µs]", title=title)
        ax.axvline(1000.0, color="k", lw=0.8, ls="--")
        ax.text(1100.0, 0.92, "a period", transform=ax.get_xaxis_transform(), fontsize=8)
    axes[0].set_ylabel("periods")
    figure.savefig(path)


def run(out: Path, duration: float = 600.0) -> None:
    """Drive, write the quantiles, draw the histograms.

    Args:
        out: folder of the table and the figure.
        duration: of the control [s].
    """
    out.mkdir(parents=True, exist_ok=True)
    live = export_native("V-sector-w4").live()
    alone = steps_alone_s(live)
    live.reset()
    leg = page_leg()
    report = drive_hardware(live, leg.read, leg.write, duration_s=duration, watchdog_s=5.0)
    print(report)
    rows = {"step alone": alone, "late": report.late_s, "busy": report.busy_s}
    with (out / "latency.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(("what", "count", *(f"quantile_{q:g}_us" for q in QUANTILES)))
        for name, times in rows.items():
            quantiles_us = 1e6 * np.quantile(times, QUANTILES)
            writer.writerow((name, len(times), *(f"{x:.1f}" for x in quantiles_us)))
    draw(report, out / "latency.svg")


if __name__ == "__main__":
    main(run)
