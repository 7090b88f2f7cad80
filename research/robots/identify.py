"""Measure the accuracy of `tegotae identify` on hoppers: 50 random legs, 60 s at 200 Hz.

    python -m research.robots.identify [--bodies 50] [--out docs/_static/identify]

Every leg is a `HiddenLeg` of `research/robots/hidden_leg.py`, whose physics are not the package's.
Its numbers are drawn log-uniformly, over its length, weight and stiffness: mass 0.1 to 10 kg, rest
length 0.2 to 1.2 m, k l0 / (m g) 4 to 20, damping ratio 0.05 to 0.25, largest force 2.5 to 5
weights, delay 2 to 25 ms. The noise is 3 % of the weight and of the rest length. A leg that breaks,
since its first landing presses it to nothing, is drawn again, and counted.

`bodies.csv` has a row a leg and number; `identify.csv` a row a number; `failed.csv` the legs that
were refused, with the reason. Legs that are there are not computed again.
"""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np
import pandas as pd

from research.frame import Table, main, write_rows
from research.robots.hidden_leg import GRAVITY_M_PER_S2, HiddenLeg
from tegotae._support.errors import TegotaeError
from tegotae.measures.recordings import QUANTITIES, read_columns, recording
from tegotae_robots.identification import FITTED, identify, log_of

ROOT = Path(__file__).parents[2]

SECONDS = 60.0


def drawn(rng: np.random.Generator) -> dict[str, float]:
    """Draw the numbers of a leg, by the names of `FITTED`."""

    def between(low: float, high: float) -> float:
        return float(np.exp(rng.uniform(np.log(low), np.log(high))))

    mass, length = between(0.1, 10.0), between(0.2, 1.2)
    stiffness = between(4.0, 20.0) * mass * GRAVITY_M_PER_S2 / length
    return {
        "mass_kg": mass,
        "stiffness_n_per_m": stiffness,
        "damping_ns_per_m": between(0.05, 0.25) * 2.0 * np.sqrt(stiffness * mass),
        "rest_length_m": length,
        "max_force_n": between(2.5, 5.0) * mass * GRAVITY_M_PER_S2,
        "delay_s": round(between(0.002, 0.025), 4),
    }


def recorded(seed: int, file: Path) -> tuple[dict[str, float], int]:
    """Return the numbers of a leg whose log is written, and the number of failed draws before
    it.
    """
    rng = np.random.default_rng(seed)
    for broken in range(100):
        numbers = drawn(rng)
        try:
            HiddenLeg(**numbers, seed=seed).log(file, SECONDS)
        except SystemExit:
            continue
        return numbers, broken
    raise SystemExit(f"all legs of seed {seed} break")


def rows_of(seed: int, folder: Path) -> list[dict[str, object]]:
    """Return one row per number of one leg: the truth, the fit and its interval."""
    file = folder / "log.csv"
    truth, broken = recorded(seed, file)
    fit = identify(log_of(recording(read_columns(file), quantities=QUANTITIES)))
    ahead = fit.prediction.iloc[-1]
    return [
        {
            "body": seed,
            "number": name,
            "truth": truth[name],
            "fit": fit.values[name],
            "low": fit.low[name],
            "high": fit.high[name],
            "hops": sum(fit.hops),
            "hops ahead": ahead.iloc[0],
            "height error / noise": ahead.iloc[1],
            "broken before": broken,
        }
        for name in FITTED
    ]


def summary(bodies: pd.DataFrame) -> list[dict[str, object]]:
    """Return one row per number: errors in per cent, and the share of cases within the interval and
    5 %.
    """
    error = 100.0 * (bodies.fit / bodies.truth - 1.0)
    bodies = bodies.assign(
        error=error,
        within=error.abs() <= 5.0,
        covered=(bodies.low <= bodies.truth) & (bodies.truth <= bodies.high),
        half=50.0 * (bodies.high - bodies.low) / bodies.truth,
    )
    rows = []
    for name in FITTED:
        estimates = bodies[bodies.number == name]
        rows.append(
            {
                "number": name,
                "bodies": len(estimates),
                "bias_percent": estimates.error.mean(),
                "median_error_percent": estimates.error.abs().median(),
                "largest_error_percent": estimates.error.abs().max(),
                "within_5_percent": int(estimates.within.sum()),
                "covered": int(estimates.covered.sum()),
                "half_interval_percent": estimates.half.median(),
            }
        )
    return rows


def run(bodies: int = 50, out: Path = ROOT / "docs" / "_static" / "identify") -> None:
    """Fit the missing legs, and write the tables.

    Args:
        bodies: number of legs.
        out: folder of the tables.
    """
    file, failed = out / "bodies.csv", out / "failed.csv"
    finished = {int(body) for file in (file, failed) for body in Table(file, ("body",)).read().body}
    with tempfile.TemporaryDirectory() as folder:
        for seed in sorted({*range(bodies)} - finished):
            try:
                rows = rows_of(seed, Path(folder))
                write_rows(file, rows, digits=6, by=["body"])
            except TegotaeError as error:
                write_rows(failed, [{"body": seed, "why": str(error)}], digits=6, by=["body"])
            print(seed, flush=True)
    write_rows(out / "identify.csv", summary(pd.read_csv(file)), digits=4)


if __name__ == "__main__":
    main(run)
