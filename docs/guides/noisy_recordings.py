"""How right `tegotae measure` is about recordings with noise.

    python docs/guides/noisy_recordings.py

writes `noise.csv` to `docs/_static/guides`, in some minutes.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import tyro

from tegotae import Rollout, Scenario, Timing
from tegotae._support.files import output_folder
from tegotae._support.tables import write_csv
from tegotae.cli.console import exit_status
from tegotae.measures.hopping import measure
from tegotae.measures.hopping.gait import Measured
from tegotae.systems.vanilla import preset

GUIDES = Path(__file__).resolve().parent

GAITS = {"sector, 5 rad/s": ("sector", 5.0, 2.753), "reflex, 8 rad/s": ("reflex", 8.0, 2.0)}
"""Actuation, ω [rad/s] and σ of gaits on limit cycles."""
LEVELS = (0.0, 0.01, 0.02, 0.03, 0.05, 0.07, 0.1)
"""Standard deviations of the noise, as shares."""


@dataclass(frozen=True, kw_only=True)
class Noisy:
    """Measure gaits with noise on the height, and on the height and the force."""

    out: Path = GUIDES.parent / "_static" / "guides"
    """Folder for the table."""
    levels: tuple[float, ...] = LEVELS
    """Deviations of the noise: shares of the height's range, or of the rest length if that is more,
    and of the largest force."""
    seeds: int = 20
    """Recordings of each gait at each level."""

    def run(self) -> None:
        """Measure, and write the table."""
        folder = output_folder(self.out)
        rows = [row for name in GAITS for row in rows_of(name, self.levels, self.seeds)]
        write_csv(folder / "noise.csv", {key: [row[key] for row in rows] for key in rows[0]})


def rows_of(name: str, levels: tuple[float, ...], seeds: int) -> list[dict[str, Any]]:
    """A row per level: errors in per cent, typical (root mean square) and largest."""
    walk = recorded(*GAITS[name])
    right = measured(walk)
    return [_row(name, walk, right, level, seeds) for level in levels]


def recorded(actuation: str, omega: float, sigma: float) -> dict[str, np.ndarray]:
    """Half a minute of a gait, in samples of 10 ms."""
    path = Rollout(
        controller=preset("paper").controller(actuation),
        timing=Timing(duration_s=30.0, frame_s=0.01),
    ).run([sigma], Scenario(omega=omega))
    names = {"time_s": "time_s", "height_m": "height_m", "force_n": "actuator_force_n"}
    return {name: np.asarray(getattr(path, channel))[:, 0] for name, channel in names.items()}


def noisy(
    walk: dict[str, np.ndarray], level: float, seed: int, *, force: bool = False
) -> dict[str, np.ndarray]:
    """The same with white noise on the height, and on the force if wanted."""
    draw = np.random.default_rng(seed)
    scale_m = max(float(np.ptp(walk["height_m"])), 1.0)
    of = {"height_m": scale_m, "force_n": 4.0 if force else 0.0}
    return walk | {
        name: walk[name] + level * scale * draw.standard_normal(len(walk[name]))
        for name, scale in of.items()
    }


def measured(walk: dict[str, np.ndarray], **settings: Any) -> Measured:
    """What `measure` prints of it, all but the smoothness."""
    return measure(**walk, rest_length_m=1.0, **settings)


def errors(found: Measured, right: Measured) -> dict[str, float]:
    """How far what was found is off, as shares of what is right."""
    assert found.efficiency is not None
    assert right.efficiency is not None
    nearest = np.abs(found.hops.time_s[:, None] - right.hops.time_s[None]).argmin(axis=1)
    apexes = found.hops.height_m / right.hops.height_m[nearest] - 1.0
    return {
        "cot_inverse": found.efficiency.cot_inverse / right.efficiency.cot_inverse - 1.0,
        "apex": float(apexes[np.abs(apexes).argmax()]),
        "hops": len(found.hops.time_s) / len(right.hops.time_s) - 1.0,
        "period": period_s(found) / period_s(right) - 1.0,
    }


def period_s(found: Measured) -> float:
    """Mean time from hop to hop of the last ten [s]."""
    return float(np.diff(found.hops.time_s[-11:]).mean())


def _row(
    name: str, walk: dict[str, np.ndarray], right: Measured, level: float, seeds: int
) -> dict[str, Any]:
    seeds = seeds if level else 1
    height = [errors(measured(noisy(walk, level, seed)), right) for seed in range(seeds)]
    both = [errors(measured(noisy(walk, level, s, force=True)), right) for s in range(seeds)]
    raw = [
        errors(measured(noisy(walk, level, seed), lowpass_hz=np.inf), right)
        for seed in range(seeds)
    ]
    return {
        "gait": name,
        "noise %": f"{100 * level:g}",
        "CoT⁻¹": _shown([each["cot_inverse"] for each in height]),
        "CoT⁻¹, noisy force": _shown([each["cot_inverse"] for each in both]),
        "apex heights": _shown([each["apex"] for each in height]),
        "hops": _shown([each["hops"] for each in height]),
        "period": _shown([each["period"] for each in height]),
        "CoT⁻¹, not filtered": _shown([each["cot_inverse"] for each in raw]),
    }


def _shown(shares: list[float]) -> str:
    """Root mean square and largest of some shares, in per cent."""
    per_cent = 100.0 * np.abs(shares)
    return f"{np.sqrt(np.mean(per_cent**2)):.1f} ({per_cent.max():.1f})"


if __name__ == "__main__":
    sys.exit(exit_status(tyro.cli(Noisy, description=__doc__).run))
