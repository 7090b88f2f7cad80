"""The physical optimum: CoT⁻¹ over hop frequency, and the best force beside a learned one."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from research.reproduction.optimum.problem import small_hop_limit
from tegotae.figures.style import COLOURS, PAGE_IN, literal_text, new_figure, styled
from tegotae.measures.optimum import Curve
from tegotae.parts.bodies import Hopper

Points = Mapping[str, tuple[np.ndarray, np.ndarray]]
"""Hop frequencies [rad/s] and CoT⁻¹ [m/J] of some gaits, by what they are called."""
Stances = Mapping[str, dict[str, np.ndarray]]
"""Time since touchdown [s] and force [N] by what they are called: `time_s`, `force_n`."""

_MARKS = ("o", "s", "^", "D", "v", "P")


def draw_optimum(axes: Axes, curve: Curve, *, bound: bool = True, **style: Any) -> None:
    """Draw the optimum of period 1 as a line over hop frequency, and its upper bound.

    For any panel whose axes are frequency [rad/s] and CoT⁻¹ [m/J].
    """
    if bound:
        axes.fill_between(
            curve["omega"],
            curve["cot_inverse"],
            curve["upper_bound"],
            color="0.9",
            lw=0,
            label="open: up to the bound proved",
        )
    style = {"color": "black", "lw": 1.2, "label": "best gait of one hop a cycle"} | style
    axes.plot(curve["omega"], curve["cot_inverse"], **style)


def optimum_figure(
    curve: Curve,
    points: Points,
    stances: Stances,
    *,
    max_force_n: float,
    note: str = "",
    longer: Points = MappingProxyType({}),
) -> Figure:
    """Draw CoT⁻¹ over hop frequency with that of controllers; forces over a stance beside it.

    Filled points are gaits that repeat with every hop, under the solid line; open ones have cycles
    of several hops, under the dashed one.

    Args:
        curve: the kept table.
        points: what controllers reach.
        stances: forces over a stance, drawn in this order.
        max_force_n: largest actuator force α [N].
        note: title of the second panel.
        longer: of `points` those whose cycle has several hops, by the same names.
    """
    with styled():
        figure = new_figure(PAGE_IN, 3.4)
        left, right = figure.subplots(1, 2, width_ratios=(3, 2))
        draw_optimum(left, curve)
        left.plot(
            curve["omega"], curve["cot_inverse_two"], color="0.35", lw=0.9, ls="--",
            label="best gait of two hops, mean frequency",
        )  # fmt: skip
        left.plot(
            curve["omega"], curve["upper_bound_any"], color="0.35", lw=0.9, ls=":",
            label="no gait has more (proved)",
        )  # fmt: skip
        limit = small_hop_limit(Hopper())
        left.plot(
            [15.0, 16.0], [limit, limit], color=COLOURS[4], lw=2.0, label="limit of small hops"
        )
        colours = (COLOURS[0], COLOURS[1], COLOURS[5], COLOURS[6], COLOURS[3], COLOURS[4])
        for number, name in enumerate(dict.fromkeys((*points, *longer))):
            style: Any = {
                "ls": "",
                "marker": _MARKS[number % len(_MARKS)],
                "ms": 3,
                "color": colours[number % len(colours)],
            }
            if name in points:
                if len(points[name][0]) == 1:  # one among many
                    style |= {"ms": 7, "mec": "white", "mew": 0.6, "zorder": 5}
                left.plot(
                    *points[name], **{"mew": 0, "alpha": 0.9} | style, label=literal_text(name)
                )
            if name in longer:
                label = literal_text(f"{name}, cycle of several hops")
                left.plot(*longer[name], **{"mew": 0.6} | style | {"mfc": "none"}, label=label)
        left.set(xlim=(1.0, 16.0), ylim=(0.0, 1.4))
        left.set_xlabel("hop frequency ω [rad/s]")
        left.set_ylabel("CoT$^{-1}$ A  [m/J]")
        lines = ("-", "--", "-.", ":")
        for number, (name, stance) in enumerate(stances.items()):
            right.step(
                stance["time_s"],
                stance["force_n"],
                where="post",
                ls=lines[number % 4],
                color=("black", COLOURS[0], COLOURS[4], COLOURS[5])[number % 4],
                label=literal_text(name),
            )
        right.set_ylim(0.0, (1.1 + 0.1 * len(stances)) * max_force_n)
        right.set_xlim(left=0.0)
        right.set_xlabel("time since touchdown [s]")
        right.set_ylabel("actuator force $F_a$ [N]")
        right.set_title(note)
        if stances:
            right.legend(loc="upper left")
        figure.legend(
            handles=left.get_legend_handles_labels()[0], loc="outside lower left", ncols=3
        )
    return figure


def optimum_tables(
    curve: Curve, points: Points, stances: Stances, longer: Points = MappingProxyType({})
) -> dict[str, dict[str, np.ndarray]]:
    """Return the data of the figure: the curve, `points`, and `stances`."""
    tables: dict[str, dict[str, np.ndarray]] = {"": dict(curve.columns)}
    several = {f"{name}, cycle of several hops": gaits for name, gaits in longer.items()}
    points = {**points, **several}
    if points:
        tables["points"] = {
            "gaits": np.repeat(list(points), [len(omega) for omega, _ in points.values()]),
            "hop_rate_rad_per_s": np.concatenate([omega for omega, _ in points.values()]),
            "cot_inverse_a_m_per_j": np.concatenate([value for _, value in points.values()]),
        }
    if stances:
        tables["stances"] = {
            "force": np.repeat(list(stances), [len(s["time_s"]) for s in stances.values()]),
            **{
                name: np.concatenate([s[name] for s in stances.values()])
                for name in ("time_s", "force_n")
            },
        }
    return tables
