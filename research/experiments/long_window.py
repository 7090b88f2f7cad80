"""Is what training pays for what a long window of the same gait makes?

    python -m research.experiments.long_window results/paper

compares, in the records of a study, CoT⁻¹ in the training episode of the distribution's mean that
was kept with CoT⁻¹ of the same weights at the same frequency in the evaluation: 40 s instead of
24, over whole cycles once settled, at ticks of 1 ms instead of 2.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from research.frame import Place, main
from research.reproduction.folder import Folder
from research.reproduction.record import Record
from tegotae._support.errors import TegotaeError

_LEAST = 0.05
"""CoT⁻¹ below which a relative difference says nothing [m/J]."""


@dataclass(frozen=True)
class LongWindow:
    """Compare, and print."""

    study: Place
    """A study's folder."""

    def run(self) -> None:
        """Print how many settled gaits agree, and those that agree least."""
        records = [record for record in Folder(self.study).all()[0] if record.curves]
        rows = [row for record in records for row in compared(record)]
        if not rows:
            raise TegotaeError(f"{self.study} holds no gaits that settle")
        excess = np.array([trained / long - 1.0 for *_, trained, long in rows])
        print(f"{len(rows)} gaits settle at the frequency of their training")
        for limit in (0.01, 0.02):
            print(f"training pays within {limit:.0%}: {np.mean(np.abs(excess) < limit):.1%}")
        low, middle, high = np.quantile(excess, (0.01, 0.5, 0.99))
        print(f"1 %, 50 % and 99 % of them: {low:+.2%}, {middle:+.2%}, {high:+.2%}")
        for i in np.argsort(-np.abs(excess))[:10]:
            model, run, trained, long = rows[i]
            print(f"{model}, run {run}: {trained:.3f} in training, {long:.3f} m/J over 40 s")


def compared(record: Record) -> list[tuple[str, int, float, float]]:
    """Return model, run, and CoT⁻¹ in training and over the long window [m/J], of gaits that
    settle.
    """
    fitness, cot = (record.curves[f"centre_{name}"] for name in ("fitness", "cot_inverse"))
    best = np.nanargmax(fitness, axis=0)
    at_omega_t = len(record.omega) // 2
    long = record.episodes["cot_inverse"][:, at_omega_t]
    settles = np.isfinite(record.episodes["limit_cycle_period"][:, at_omega_t])
    return [
        (record.model, run, float(cot[generation, run]), float(long[run]))
        for run, generation in enumerate(best)
        if settles[run] and long[run] > _LEAST
    ]


if __name__ == "__main__":
    main(LongWindow)
