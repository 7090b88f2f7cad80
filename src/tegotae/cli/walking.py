"""Several legs: simulate, evaluate, basin."""

from __future__ import annotations

import json
import math
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, SupportsFloat

import numpy as np

from tegotae._support import documents
from tegotae._support.documents import JsonObject, as_json
from tegotae._support.errors import TegotaeError
from tegotae._support.files import check_folder, output_file
from tegotae._support.tables import write_csv
from tegotae.cli.console import check_outputs, print_rows
from tegotae.cli.gait.options import LeggedSystemOptions

if TYPE_CHECKING:
    from tegotae.analysis.gaits.evaluation import GaitEvaluation
    from tegotae.analysis.gaits.simulate import GaitRun
    from tegotae.systems.legged import Legged
    from tegotae.systems.resolve import Resolved


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
    from tegotae.figures.gaits.lags import footfall_figure, lags_figure
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


def subjects(found: Resolved) -> list[tuple[str, tuple[str, ...], Legged, np.ndarray]]:
    """Sets of controllers: name, labels of its runs, system, weights [runs, n_weights].

    Raises:
        TegotaeError: if there is none, or its body has one leg.
    """
    from tegotae.systems.legged import require_legs, settling
    from tegotae.training.collection import sets_of

    if found.legged is not None:
        return [(found.name, ("",), found.legged, np.array([found.legged.weights]))]
    require_legs(found.body)
    return [
        (
            each.name,
            each.labels,
            settling(each.system, each.weights[0]),
            each.weights,
        )
        for each in sets_of(found)
    ]


def evaluate_all(
    sets: list[tuple[str, tuple[str, ...], Legged, np.ndarray]],
    omega: tuple[float, ...],
    starts: int,
    seed: int,
) -> list[tuple[str, tuple[str, ...], GaitEvaluation]]:
    """Release all from the same random phases."""
    from tegotae.analysis.gaits.evaluation import evaluate_gaits

    return [
        (name, labels, evaluate_gaits(legged, weights, omega, starts, seed=seed))
        for name, labels, legged, weights in sets
    ]


def print_table(found: list[tuple[str, tuple[str, ...], GaitEvaluation]]) -> None:
    """A row a set and frequency."""
    titles = ("controller", "ω", "runs", "upright", "locked", "locks in", "speed", "CoT")
    print_rows((*titles, "slip", "gait"), (row for each in found for row in _rows(*each)))
    units = {each.legged.units for _, _, each in found}
    print("Lengths and times are in " + " or ".join(" and ".join(pair) for pair in units) + ".")


def listed(found: list[tuple[str, tuple[str, ...], GaitEvaluation]]) -> list[JsonObject]:
    """The rows of `columns` as JSON objects, null for what is undefined."""
    table = columns(found)
    return [
        dict(zip(table, as_json(row), strict=True)) for row in zip(*table.values(), strict=True)
    ]


def columns(
    found: list[tuple[str, tuple[str, ...], GaitEvaluation]],
) -> dict[str, list[str | float]]:
    """A row per controller and frequency."""
    rows: dict[str, list[str | float]] = {"controller": [], "run": [], "omega": []}
    for name, labels, evaluated in found:
        measures = evaluated.measures
        for run, label in enumerate(labels):
            for at, omega in enumerate(evaluated.omega):
                gait, share = evaluated.commonest(run, at)
                own = {"controller": name, "run": label, "omega": float(omega)}
                own |= {title: float(x[run, at]) for title, x in measures.items()}
                for title, value in (own | {"gait": gait, "gait_share": share}).items():
                    rows.setdefault(title, []).append(value)
    return rows


def _rows(name: str, labels: tuple[str, ...], evaluated: GaitEvaluation) -> list[tuple[str, ...]]:
    from tegotae.measures.hopping.statistics import interval

    measures = evaluated.measures
    shown = ("upright", "locked", "lock_time_s", "speed_m_per_s", "cost_of_transport", "slip")
    rows = []
    for at, omega in enumerate(evaluated.omega):
        gaits = Counter(evaluated.commonest(run, at)[0] for run in range(len(labels)))
        shares_of_gaits = ", ".join(f"{gait} ({count})" for gait, count in gaits.most_common())
        numbers = []
        for title in shown:
            own = interval(measures[title][:, at])
            sure = "" if np.isnan(own.low) else f" ({own.low:.3g} … {own.high:.3g})"
            numbers.append("–" if np.isnan(own.mean) else f"{own.mean:.3g}{sure}")
        at_omega = "–" if np.isnan(omega) else f"{omega:g}"
        rows.append((name, at_omega, str(len(labels)), *numbers, shares_of_gaits))
    return rows


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
