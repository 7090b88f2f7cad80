"""The kept limit, its table and its figure, from what the search has found."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from research.frame import markdown_table, write_rows, write_text
from research.legs_limit.gaits import Space
from research.legs_limit.known import FEET, KEPT, bound, limit_table
from research.legs_limit.search import GAITS, kept_gaits, losses
from research.legs_limit.strategies import Found
from tegotae.figures.gaits.style import by_side, gait_colour, gait_marker
from tegotae.figures.style import COLOURS, PAGE_IN, new_figure, save_figure, styled
from tegotae.measures.fronts import front
from tegotae.measures.gaits.lags import stances
from tegotae.measures.gaits.names import nearest_pattern
from tegotae.parts.bodies import Walker
from tegotae.simulation.recorder import needing
from tegotae.simulation.rollout import Timing
from tegotae.systems.vanilla import legged_named

ROOT = Path(__file__).resolve().parents[2]
FINE = Timing(duration_s=108.0, tick_s=0.004, frame_s=0.04)
"""Timing of the kept rollouts: ticks of a third, three times as long."""
TOP = 4
"""Gaits of every speed that are simulated finely."""
NAMES = legged_named("quadruped-c").names
Stages = dict[str, tuple[Space, np.ndarray, Found]]


class Gait(NamedTuple):
    """A gait that was found, simulated finely."""

    space: Space
    target: float
    x: np.ndarray
    speed: float
    cost: float
    loss: float


def report(stages: Stages) -> None:
    """Write the kept gaits and the table, text and figure of their costs.

    Kept gaits stay until there is a cheaper one, and so do learned walkers that are cheaper than
    the search.

    Args:
        stages: by name, the space, the target speeds and the results.
    """
    every = []
    for space, targets, result in stages.values():
        every += finely(space, targets, result.x, result.loss)
    for group in (group for feet in FEET for group in kept_gaits(feet)):
        every += finely(*group, np.zeros(len(group[1])))
    best = {
        feet: [min(group, key=lambda gait: gait.loss) for group in by_speed(every, feet)]
        for feet in FEET
    }
    looked_at = {feet: [look(gait) for gait in gaits] for feet, gaits in best.items()}
    rows = with_controllers(
        [
            row(feet, *pair)
            for feet in FEET
            for pair in zip(best[feet], looked_at[feet], strict=True)
        ]
    )
    write_rows(KEPT, rows, digits=5)
    write_text(GAITS, json.dumps([document(g) for f in FEET for g in best[f]]))
    limit_table.cache_clear()
    write_text(KEPT.parent / "limit.md", markdown(rows))
    with styled():
        save_figure(draw(rows, looked_at), KEPT.parent / "limit.png")


def finely(space: Space, targets: np.ndarray, x: np.ndarray, coarse: np.ndarray) -> list[Gait]:
    """Evaluate the best gait of every speed with short ticks and for longer.

    Args:
        space: of the vectors.
        targets: speeds [starts].
        x: vectors [starts, size].
        coarse: their losses in the search [starts].
    """
    indices = [
        k
        for speed in np.unique(targets)
        for k in np.flatnonzero(targets == speed)[np.argsort(coarse[targets == speed])][:TOP]
        if coarse[k] < 50.0
    ]
    if not indices:
        return []
    loss, speed, cost = losses(space, x[indices], targets[indices], FINE)
    return [
        Gait(space, targets[k], x[k], speed[position], cost[position], loss[position])
        for position, k in enumerate(indices)
    ]


def by_speed(gaits: list[Gait], feet: str) -> list[list[Gait]]:
    """Group the gaits of such feet that reach the target speed, speed by speed."""
    matches = [g for g in gaits if g.space.feet == feet and abs(g.speed / g.target - 1.0) < 0.02]
    return [[g for g in matches if g.target == v] for v in sorted({g.target for g in matches})]


SLOWEST = 0.01
"""Speed below which a walker stands [√(g l0)]."""
ON_ELLIPSE = ("V", "cos", "VG-gF", "AR-rF", "ARG-rF-gF")
"""Families whose feet stay on the ellipse."""


def with_controllers(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return the rows, with learned walkers where they are cheaper than the search's result.

    Those that the kept table has stay, as long as nothing cheaper is found. The cheapest come
    first: of walkers of about one speed only the best is a row.
    """
    kept, walkers = limit_table(), learned()
    walkers = walkers[walkers.cell.str.split("@|\\+|-w", n=1, regex=True).str[0].isin(ON_ELLIPSE)]
    walkers = walkers.assign(feet="ellipse", source=walkers.cell + " run " + walkers.run)
    walkers = walkers[["feet", "speed", "cost_of_transport", "gait", "source"]]
    walkers = pd.concat([kept[kept.source != "search"], walkers])
    walkers = walkers.drop_duplicates(["source", "speed"], keep="last").to_dict("records")
    on_ellipse = [row for row in rows if row["feet"] == "ellipse"]

    def over_found(walker: dict[str, Any]) -> float:
        """Return the cost over that of the rows so far at the same speed."""
        ordered = sorted(on_ellipse, key=lambda row: row["speed"])
        speed, cost = ([row[n] for row in ordered] for n in ("speed", "cost_of_transport"))
        reference = np.exp(np.interp(walker["speed"], speed, np.log(cost)))
        return float(walker["cost_of_transport"] / reference)

    for walker in sorted(walkers, key=over_found):
        if over_found(walker) < 1.0:
            on_ellipse.append(walker)
    free = [row for row in rows if row["feet"] == "free"]
    return free + sorted(on_ellipse, key=lambda row: row["speed"])


class Look(NamedTuple):
    """A gait's last stride."""

    lag: np.ndarray
    """Lag of the middles of stances behind that of LH [cycles], [legs]."""
    gait: str
    duty: np.ndarray
    longest_s: float
    flight: float
    omega: float
    intervals: list[list[tuple[float, float]]]
    """Stances of each leg as shares of a stride, from a stance of LH on."""


@needing("time_s", "stance_time_s")
def _watch(trajectory, scenario, body, timing):
    return {"time": trajectory.time_s, "stance": trajectory.stance_time_s}


def look(gait: Gait) -> Look:
    """Return the times at which the feet of a gait are on the ground."""
    weights, scenario = gait.space.decoded(gait.x[None], np.array([gait.target]))
    rollout = gait.space.rollout(_watch, FINE)
    path = rollout.run(weights, scenario, Walker(), dtype="float64")
    time = np.asarray(path["time"], float).reshape(len(path["time"]), -1)[:, 0]
    total = np.asarray(path["stance"], float)[:, :, 0]
    omega = float(np.ravel(scenario.omega)[0])
    stride = 2.0 * np.pi / omega
    late = time > time[-1] - 8.0 * stride
    gained = np.diff(total, axis=0, prepend=total[:1])[late]
    angle = omega * time[late]
    middle = np.angle((gained * np.exp(1j * angle)[:, None]).sum(axis=0)) / (2.0 * np.pi)
    lag = (middle - middle[2]) % 1.0
    duty = gained.sum(axis=0) / (late.sum() * FINE.frame_s)
    start = time[-1] - 2.5 * stride
    every = stances(time, total)
    longest = max((b - a for leg in every for a, b in leg if a > 0.5 * time[-1]), default=0.0)
    window = [
        [((a - start) / stride, (b - start) / stride) for a, b in leg if b > start] for leg in every
    ]
    return Look(
        lag=lag,
        gait=str(nearest_pattern(lag[:, None], NAMES, 0.1)[0]),
        duty=duty,
        longest_s=longest,
        flight=float((gained.max(axis=1) <= 0.0).mean()),
        omega=omega,
        intervals=window,
    )


def row(feet: str, gait: Gait, stances: Look) -> dict[str, Any]:
    """Return a row of the kept table."""
    return {
        "feet": feet,
        "speed": gait.speed,
        "cost_of_transport": gait.cost,
        "omega": stances.omega,
        "gait": stances.gait,
        "duty_factor": stances.duty.mean(),
        "longest_stance": stances.longest_s,
        "hind_lag": stances.lag[0],
        "flight": stances.flight,
        "source": "search",
    }


def document(gait: Gait) -> dict[str, Any]:
    """Return the document of a gait, from which it can be released again: its space, wanted speed
    and vector.
    """
    space = gait.space
    return {
        "feet": space.feet,
        "harmonics": space.harmonics,
        "speed": gait.target,
        "cost_of_transport": round(gait.cost, 6),
        "x": [round(float(a), 7) for a in gait.x],
    }


def markdown(rows: list[dict[str, Any]]) -> str:
    """Return the limits as a table."""
    head = ["CoT", "ω", "gait", "duty"]
    free, tied = (
        [["speed, free feet", *head, "flight", "proved bound"]],
        [["speed, C's ellipse", *head]],
    )
    for r in rows:
        cells = [
            f"{r['speed']:.2f}",
            f"**{r['cost_of_transport']:.3f}**",
            f"{r['omega']:.2f}",
            r["gait"],
            f"{r['duty_factor']:.2f}",
        ]
        if r["feet"] == "free":
            lower = float(bound(Walker(), r["speed"], r["longest_stance"]))
            cells += [f"{100.0 * r['flight']:.0f} %", f"{lower:.3f}"]
            free.append(cells)
        elif r["omega"] > 0.0:  # those of controllers are rows of their own
            tied.append(cells)
    return f"{markdown_table(free)}\n{markdown_table(tied)}"


def draw(rows: list[dict[str, Any]], looked_at: dict[str, list[Look]]) -> Figure:
    """Draw the limits over speed with the costs of controllers, and footfalls of the free ones."""
    figure = new_figure(PAGE_IN, 4.2)
    left_axes, right_axes = figure.subplots(1, 2, width_ratios=(3, 2))
    lines = {
        "free": ("limit, free feet", "black", "-"),
        "ellipse": ("limit, C's ellipse", "0.45", "--"),
    }
    for feet, (label, colour, line) in lines.items():
        points = [r for r in rows if r["feet"] == feet]
        left_axes.plot(
            [r["speed"] for r in points],
            [r["cost_of_transport"] for r in points],
            line,
            color=colour,
            lw=1.2,
            label=label,
        )
        for r in points:
            if r["source"] != "search":
                continue
            left_axes.plot(r["speed"], r["cost_of_transport"], gait_marker(r["gait"]), ms=4.5,
                      color=gait_colour(r["gait"]))  # fmt: skip
    speeds = np.linspace(0.05, 2.0, 100)
    left_axes.plot(
        speeds, bound(Walker(), speeds, 0.8 / speeds), ":", color="0.3", label="proved, even speed"
    )
    controllers(left_axes)
    for gait in dict.fromkeys(r["gait"] for r in rows if r["source"] == "search"):
        left_axes.plot([], [], gait_marker(gait), color=gait_colour(gait), ms=4.5, label=gait)
    left_axes.set(yscale="log", xlim=(0.0, 2.05), ylim=(1e-3, 3.0))
    left_axes.set_xlabel("speed [√(g l0)]")
    left_axes.set_ylabel("cost of transport")
    footfalls(right_axes, [r for r in rows if r["feet"] == "free"], looked_at["free"])
    figure.legend(*left_axes.get_legend_handles_labels(), loc="outside lower center", ncols=4)
    return figure


def controllers(axes: Axes) -> None:
    """Draw the reach of controllers: the vanilla front, and the kept learned walkers."""
    curve = front("quadruped-c", "vanilla")
    axes.plot(
        curve["speed"], curve["cost_of_transport"], "-", color=COLOURS[0], label="vanilla front"
    )
    axes.plot(
        "speed", "cost_of_transport", ".", data=learned(), ms=3, color=COLOURS[1],
        label="learned walkers",
    )  # fmt: skip


def learned() -> pd.DataFrame:
    """Return the kept learned walkers of quadruped C that did not fall."""
    table = pd.read_csv(ROOT / "research" / "learned_legs" / "range.csv", dtype={"run": str})
    table = table.rename(columns={"speed_m_per_s": "speed"}).dropna(subset="cost_of_transport")
    return table[(table.upright == 1.0) & (table.speed > SLOWEST)]


def footfalls(axes: Axes, rows: list[dict[str, Any]], looks: list[Look]) -> None:
    """Draw two strides of every speed, one bar per stance."""
    order, height, ticks = by_side(NAMES), 0.0, []
    for r, stance in list(zip(rows, looks, strict=True)):
        for place, leg in enumerate(order):
            for a, b in stance.intervals[leg]:
                a, b = max(a, 0.0), min(b, 2.0)
                if b > a:
                    axes.barh(
                        height + 0.2 * place,
                        b - a,
                        left=a,
                        height=0.17,
                        color=gait_colour(r["gait"]),
                    )
        ticks.append((height + 0.3, f"{r['speed']:.2f}"))
        height += 1.1
    axes.set_yticks([place for place, _ in ticks], [speed for _, speed in ticks])
    axes.set_ylim(height - 0.1, -0.3)
    axes.set_xlim(0.0, 2.0)
    axes.set_xlabel("strides")
    axes.set_ylabel("speed")
    axes.set_title("stances, free feet: LH, LF, RF, RH")
