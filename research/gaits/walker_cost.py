"""Test what the walker's cost of transport counts, and what it omits.

    python -m research.gaits.walker_cost

Its work is the sum over legs of ∫ |F·ċ| dt: what gives and what takes is counted alike, and the two
axes of a leg are netted at every instant. Here the same gaits are counted in other ways; and it is
measured how often a foot on the ground bears no load, how often it slides, and how large forces
are. Written to `walker_cost.csv` and `.md` in `docs/_static/gaits`, in about a minute of a core.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pandas as pd

from research.frame import main, markdown_table, write_rows, write_text
from tegotae.measures.gaits.names import gait_of
from tegotae.parts.bodies import Walker
from tegotae.parts.channels import Channel, Latest, Total
from tegotae.parts.parameters import traceable
from tegotae.simulation.recorder import needing
from tegotae.systems.legged import lanes_of, random_phases
from tegotae.systems.vanilla import legged_named

OUT = Path(__file__).resolve().parents[2] / "docs" / "_static" / "gaits"
CASES = (
    ("quadruped-c", 1.0),
    ("quadruped-c", 2.0),
    ("quadruped-c", 3.0),
    ("quadruped-a", 2.0),
    ("hexapod", 2.0),
)
"""Systems and frequencies [rad/s] that are looked at."""
STARTS = 8


@traceable
@dataclass(frozen=True, kw_only=True)
class Watched(Walker):
    """A walker that also records how its feet bear load and slide."""

    @property
    def channels(self) -> tuple[Channel, ...]:
        """Channels of the walker, and the recorded ones."""
        return (*super().channels, *WATCHED)


@traceable
@dataclass(frozen=True, kw_only=True)
class ByAxis(Watched):
    """Cost whose work is that of each axis of a leg by itself, |F_x ċ_x| + |F_z ċ_z|."""

    def leg_work(self, force_n, previous_rate, rate, tick_s):
        """Return the work of each leg in a tick, each axis by itself [J]."""
        along, _, down = force_n
        return tick_s * (jnp.abs(along * rate[0]) + jnp.abs(down * rate[1]))


def _stands(tick: Any) -> jax.Array:
    return tick.contact.stance_share >= 1.0


def _spent(tick: Any, holds: jax.Array) -> jax.Array:
    return jnp.where(holds, tick.tick_s, 0.0)


WATCHED: tuple[Channel, ...] = (
    Total("stands_s", "Whole ticks on the ground [s], a limb.", lambda t: _spent(t, _stands(t))),
    Total(
        "unloaded_s",
        "Of these, those without load [s], a limb.",
        lambda t: _spent(t, _stands(t) & (t.contact.force_n <= 0.0)),
    ),
    Total(
        "slides_s",
        "Of these, those in which the loaded foot slides [s], a limb.",
        lambda t: _spent(
            t, _stands(t) & (t.contact.force_n > 0.0) & (jnp.abs(t.end.body.slip).max(axis=0) > 0.0)
        ),
    ),
    Latest(
        "load_n", "Load in a tick on the ground [N], a limb.", _stands, lambda t: t.contact.force_n
    ),
)
"""Recorded channels."""
TOTALS = ("work_positive_j", "work_net_j", "stands_s", "unloaded_s", "slides_s")


@needing("x_m", "y_m", "load_n", *TOTALS)
def watched(trajectory, scenario, body, timing):
    """Return totals of the last quarter, summed over legs, the distance, and the largest load."""
    begins = 3 * timing.n_frames // 4
    channels = {name: getattr(trajectory, name, None) for name in TOTALS}
    channels |= {name: x for name, x in trajectory.channels.items() if name in TOTALS}
    totals = {name: x[-1] - x[begins] for name, x in channels.items() if x is not None}
    place = [trajectory.channels[name] for name in ("x_m", "y_m")]
    distance = jnp.sqrt(sum((x[-1] - x[begins]) ** 2 for x in place))
    load = jnp.nanmax(trajectory.channels["load_n"][begins:], axis=0).max(axis=0)
    summed = {n: x.sum(axis=0) if x.ndim == 2 else x for n, x in totals.items()}
    return {"way": distance, "load": load, **summed}


def row(name: str, omega: float) -> dict[str, Any]:
    """Measure one system at a frequency: medians over the starts."""
    legged = legged_named(name).with_numbers(omega=omega)
    scenario = legged.scenario(random_phases(legged.body.limbs, STARTS, 1))
    body_fields = {field.name: getattr(legged.body, field.name) for field in fields(legged.body)}
    results = legged.rollout(legged.summary()).run(legged.weights, scenario, legged.body)
    gaits = gait_of(lanes_of(results), legged.names).tolist()
    netted, by_axis = (
        jax.tree.map(
            lambda x: np.asarray(x, float),
            legged.rollout(watched).run(legged.weights, scenario, body(**body_fields)),
        )
        for body in (Watched, ByAxis)
    )
    price = legged.body.weight_n * netted["way"]
    results = {
        "cost_of_transport": (2.0 * netted["work_positive_j"] - netted["work_net_j"]) / price,
        "each_axis": by_axis["work_positive_j"] / price,
        "positive_only": netted["work_positive_j"] / price,
        "net": netted["work_net_j"] / price,
        "unloaded": netted["unloaded_s"] / netted["stands_s"],
        "slides": netted["slides_s"] / netted["stands_s"],
        "largest_load": netted["load"] / legged.body.weight_n,
    }
    medians = {title: float(np.median(values)) for title, values in results.items()}
    return {"system": name, "omega": omega, "gait": max(gaits, key=gaits.count), **medians}


def run() -> None:
    """Measure and write."""
    write_rows(OUT / "walker_cost.csv", [row(*case) for case in CASES], digits=3)
    write_text(OUT / "walker_cost.md", table_text())


def table_text() -> str:
    """Return the table of the page, from the kept one."""
    lines = [
        ["system, ω [rad/s]", "gait", "CoT as reported", "each axis by itself",
         "positive work alone", "without load", "sliding", "largest load [m g]"]
    ]  # fmt: skip
    for row in pd.read_csv(OUT / "walker_cost.csv").itertuples():
        costs = (row.cost_of_transport, row.each_axis, row.positive_only)
        shares = (f"{100.0 * share:.0f} %" for share in (row.unloaded, row.slides))
        cells = (*(f"{cost:.2f}" for cost in costs), *shares, f"{row.largest_load:.1f}")
        lines.append([f"{row.system}, {row.omega:g}", row.gait, *cells])
    return markdown_table(lines)


if __name__ == "__main__":
    main(run)
