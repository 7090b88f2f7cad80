"""One release of legs: its footfalls and its lags."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, SupportsFloat

import numpy as np

from tegotae._support import documents
from tegotae._support.errors import TegotaeError
from tegotae._support.files import check_folder, output_file
from tegotae._support.tables import write_csv
from tegotae.cli.gait.options import LeggedSystemOptions
from tegotae.cli.outputs import check_outputs
from tegotae.cli.tables import print_rows

if TYPE_CHECKING:
    from tegotae.analysis.gaits.simulate import GaitRun


def simulate_legs(
    legs: LeggedSystemOptions,
    phases: Sequence[float],
    *,
    out: Path | None,
    csv: Path | None,
    plot: Path | None,
    animate: Path | None,
    as_json: bool,
) -> None:
    """Release a body once; write footfalls, lags and an animation, and print its gait.

    Args:
        legs: the system.
        phases: of the legs at release [cycles]; random ones if there are none.
        out: folder for all that there is, but for an animation.
        csv: file of the time series.
        plot: file of the footfalls.
        animate: file of an animation of the last strides (.gif).
        as_json: print the document in place of the table.
    """
    from tegotae.analysis.gaits.simulate import (
        DIGITS,
        columns,
        coordination_columns,
        simulate,
        write,
    )
    from tegotae.figures.gaits.footfall import footfall_figure
    from tegotae.figures.gaits.lags import lags_figure
    from tegotae.figures.style import save_figure

    if phases and legs.seed:
        raise TegotaeError("--seed is of random phases, and --phases says what they are")
    legged = legs.legged()
    if out is not None:
        check_folder(out)
    check_outputs(csv, plot, None)
    if animate is not None:
        if animate.suffix.lower() != ".gif":
            raise TegotaeError(f"cannot write legs as {str(animate)!r}; the name ends in .gif")
        output_file(animate)
    release = [2.0 * math.pi * phase for phase in phases] or None
    run = simulate(legged, release, seed=legs.seed, tolerance=legs.tolerance)
    title = f"{legs.title(legged)}: {run.gait}"
    document = legs.document(
        legged,
        "simulate",
        phases=list(phases),
        gait=run.gait,
        release_phase_rad=run.phase_rad,
        coordination={k: v[0] for k, v in coordination_columns(run.found, legged.names).items()},
        stances={
            name: [list(stance) for stance in leg]
            for name, leg in zip(legged.names, run.stances, strict=True)
        },
    )
    written = []
    if out is not None:
        written += [
            save_figure(footfall_figure(run, title), out / "footfall.png"),
            save_figure(lags_figure(run, title), out / "lags.png"),
            *write(out, "simulate", document, columns(run)),
        ]
    if csv is not None:
        write_csv(csv, columns(run), digits=DIGITS)
        written.append(csv)
    if plot is not None:
        written.append(save_figure(footfall_figure(run, title), plot))
    if animate is not None:
        from tegotae.figures.gaits.animation import write_animation

        written.append(write_animation(run, animate))
    if as_json:
        print(json.dumps(documents.as_json(document), allow_nan=False))
        return
    _print(run)
    if written:
        print("wrote " + ", ".join(map(str, written)))


def _print(run: GaitRun) -> None:
    length, time = run.legged.units
    found = run.found
    print(run.gait)
    print_rows(
        ("leg", "lag [cycles]", "footfall lag", "duty factor", f"steps [1/{time}]"),
        (
            (
                name,
                _number(found.lag[leg, 0] % 1.0),
                _number(found.touchdown_lag[leg, 0] % 1.0),
                _number(found.duty_factor[leg, 0]),
                _number(found.step_frequency_hz[leg, 0]),
            )
            for leg, name in enumerate(run.legged.names)
        ),
    )
    for what, values, unit in (
        ("locked after", found.lock_time_s, time),
        ("order parameter", found.order_parameter, ""),
        ("speed", found.speed_m_per_s, f"{length}/{time}"),
        ("cost of transport", found.cost_of_transport, ""),
        ("Froude number", found.froude, ""),
        ("fell at", found.fall_time_s, time),
    ):
        if np.isfinite(values[0]):
            print(f"{what} {values[0]:.3g} {unit}".rstrip())


def _number(value: SupportsFloat) -> str:
    return "–" if math.isnan(value) else f"{value:.3f}"
