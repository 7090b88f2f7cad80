"""The basin of several legs, for `tegotae figure basin`."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from tegotae.cli.console import print_rows
from tegotae.cli.gait.options import LeggedSystemOptions


def draw_basin(legs: LeggedSystemOptions, starts: int, out: Path) -> None:
    """Release a body at random phases, write a figure with its table and document beside it, and
    print which gaits emerged, how often, and how soon.

    Args:
        legs: the system.
        starts: how many releases.
        out: the figure's file.
    """
    from tegotae.analysis.gaits.basin import find_basin
    from tegotae.analysis.gaits.simulate import coordination_columns, write
    from tegotae.figures.gaits.maps import basin_figure
    from tegotae.figures.style import figure_file, save_figure

    legged = legs.legged()
    figure_file(out)
    found = find_basin(legged, starts, seed=legs.seed, tolerance=legs.tolerance)
    names = legged.names
    rows = {
        "start": np.arange(starts),
        **{f"release_phase_rad_{leg}": found.phase_rad[i] for i, leg in enumerate(names)},
        "gait": found.gait,
        **coordination_columns(found.found, names),
    }
    document = legs.document(legged, "figure basin", starts=starts, outcomes=found.outcomes)
    written = [
        save_figure(basin_figure(found, legs.title(legged)), out),
        *write(out.parent, out.stem, document, rows),
    ]
    others = [leg for leg in range(len(names)) if leg != legged.reference]
    print_rows(
        ("gait", "starts", "share", "95 %", *(f"lag {names[i]}" for i in others), "locks in"),
        (
            (
                each.gait,
                str(each.count),
                f"{each.share:.3f}",
                f"{each.low:.3f} … {each.high:.3f}",
                *(_lag(each.lag[i], each.between[i]) for i in others),
                "–" if np.isnan(each.lock_time_s) else f"{each.lock_time_s:.3g}",
            )
            for each in found.outcomes
        ),
    )
    print(
        f"Lags behind {names[legged.reference]} in cycles, circular mean ± deviation over the "
        f"starts; median time to lock in {legged.units[1]}."
    )
    print("wrote " + ", ".join(map(str, written)))


def _lag(mean: float, between: float) -> str:
    if np.isnan(mean):
        return "–"
    return f"{round(mean, 3) % 1.0:.3f} ± " + (f"{between:.3f}" if between < 1.0 else "all round")
