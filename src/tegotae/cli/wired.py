"""In another simulator: simulate, evaluate, compare."""

from __future__ import annotations

import dataclasses
import json
import math
import re
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from tegotae._support import tables
from tegotae._support.errors import TegotaeError
from tegotae.cli.console import check_outputs, print_rows, print_text
from tegotae.cli.env_options import made_with
from tegotae.cli.hopping import show
from tegotae.measures.hopping.statistics import (
    UNBOUNDED,
    Interval,
    Range,
    difference,
    interval,
    paired_difference,
)
from tegotae.systems.controller_file import SavedController
from tegotae.systems.controller_set import ControllerSet
from tegotae.training.environments.experiment import EnvExperiment
from tegotae.training.environments.replay import Replay, lasting, replay

LABELS = {
    "fitness": ("fitness", ""),
    "return": ("return, sum of the rewards", ""),
    "lasted": ("share of the episode that it lasted", ""),
    "distance_m": ("distance", "m"),
    "speed_m_per_s": ("speed", "m/s"),
    "work_j": ("work of the actuators", "J"),
    "stride_hz": ("rate of the first oscillator", "Hz"),
    "duty": ("share of time on the ground", ""),
    "hops": ("hops", ""),
    "apex_m": ("height of the late apexes", "m"),
    "cot_inverse": ("CoT⁻¹", "m/J"),
    "limit_cycle_period": ("period of the limit cycle", "hops"),
    "w_peak": ("peak of the spectrum", "rad/s"),
    "t0_s": ("transient T0", "s"),
}
"""What the numbers of a replay are called, and their units."""


def simulate(
    saved: SavedController,
    *,
    name: str,
    duration_s: float | None,
    csv: Path | None,
    plot: Path | None,
    animate: Path | None,
    as_json: bool,
) -> None:
    """Play an episode, print its numbers, and write what was asked for.

    Raises:
        TegotaeError: for a file that cannot be written, before the episode; or an environment that
            cannot be made or drawn.
    """
    check_outputs(csv, plot, animate)
    experiment = lasting(EnvExperiment.of(saved), duration_s)
    (found,) = replay(experiment, [saved.weights])
    numbers = found.numbers()
    if as_json:
        print(json.dumps({n: x if math.isfinite(x) else None for n, x in numbers.items()}))
    else:
        print_rows(("quantity", "value"), [(LABELS[n][0], shown(n, x)) for n, x in numbers.items()])
        if why := found.why_on_ground():
            print(f"It {why}.")
    if csv is not None:
        tables.write_csv(csv, columns(found), digits=7)
    if plot is not None:
        _draw(found, plot, titled(Path(name).stem))
    if animate is not None:
        from tegotae.figures.animation import write_film

        write_film(found, animate)


def columns(found: Replay) -> dict[str, np.ndarray]:
    """The time series: what was observed and done, rewards, phases; a row a step."""
    episode, wires = found.episode, found.experiment.wires
    driven = [limb.entries[0] for limb in found.experiment.wiring.limbs]
    phases = {f"{limb}_phase_rad": episode.phase_rad[:, i] for i, limb in enumerate(driven)}
    actions = {f"action_{i}": episode.action[:, i] for i in range(len(wires.low))}
    observed = {name: episode[name] for name in episode.names}
    return {"time_s": episode.time_s, **observed, **phases, **actions, "reward": episode.reward}


def shown(name: str, value: float) -> str:
    """A number of a replay with its unit."""
    return "–" if math.isnan(value) else f"{value:.4g} {LABELS[name][1]}".strip()


def titled(stem: str) -> str:
    """A controller file's name as a title.

    Example:
        >>> titled("AR-rF-reflex-w8-seed1")
        'AR-rF-reflex-w8, seed 1'
    """
    return re.sub(r"-seed(\d+)$", r", seed \1", stem)


def _draw(found: Replay, plot: Path, name: str) -> None:
    """The gait as that of a recording where its hops can be measured, else loads and phases."""
    from tegotae.figures.recording import recording_figure
    from tegotae.figures.rollout import episode_figure
    from tegotae.figures.style import literal, save_figure

    measured, rest = found.measured(), found.experiment.wiring.rest_length_m
    if measured is None or rest is None:
        save_figure(episode_figure(found, note=literal(name)), plot)
        return
    save_figure(recording_figure(measured, rest_length_m=rest, note=literal(name)), plot)
    beside = plot.with_name(f"{plot.stem}-loads{plot.suffix}")
    save_figure(episode_figure(found, note=literal(name)), beside)


Rows = list[tuple[str, str, int, dict[str, float]]]
"""Set, run, start, and its numbers."""


def evaluate_all(
    sets: Sequence[ControllerSet],
    starts: int,
    settings: Sequence[str] = (),
    omegas: Sequence[float] = (),
) -> Rows:
    """Play episodes of every run.

    Args:
        sets: the runs; each set on its own environment.
        starts: episodes of each, from other starts where the environment has several.
        settings: NAME=VALUE each, in which the environment is to differ from the training.
        omegas: frequencies [rad/s], a set each if there are several; the training's by default.
    """
    rows: Rows = []
    for runs in sets:
        experiment = EnvExperiment.of_set(runs)
        changed = dict(made_with((), None, settings, is_model=True))
        own = tuple({**dict(experiment.spec.settings), **changed}.items())
        experiment = replace(experiment, spec=replace(experiment.spec, settings=own))
        varied = not experiment.spec.is_model or experiment.spec.model_settings.noise > 0.0
        at = omegas or experiment.omegas or (experiment.wiring.omega,)
        for omega in at:
            own = replace(experiment, wiring=replace(experiment.wiring, omega=omega))
            name = f"{runs.name} at ω {omega:g}" if len(at) > 1 else runs.name
            for start in range(starts if varied else 1):
                found = replay(own, runs.weights, seed=experiment.seed + start)
                rows += [
                    (name, label, start, each.numbers())
                    for label, each in zip(runs.labels, found, strict=True)
                ]
    return rows


def print_table(rows: Rows) -> None:
    """A line a quantity, a column a set: mean and 95 % interval over runs."""
    names = list(dict.fromkeys(name for name, *_ in rows))
    measured = [n for n in LABELS if any(n in numbers for *_, numbers in rows)]
    print_rows(
        ("quantity", *(f"{name} ({len(_labels(rows, name))} runs)" for name in names)),
        [
            (
                f"{LABELS[n][0]} [{LABELS[n][1]}]" if LABELS[n][1] else LABELS[n][0],
                *(show(interval(per_run(rows, name, n), within=range_of(n))) for name in names),
            )
            for n in measured
        ],
    )
    print_text(
        "Mean over runs [95 % interval]; the mean of a run is over its starts. – is undefined: "
        "without a limit cycle there is neither CoT⁻¹ nor a transient. * means that some runs are."
    )


def per_run(rows: Rows, name: str, quantity: str) -> np.ndarray:
    """Of every run of a set the mean over its starts; NaN where all are undefined."""
    values = []
    for label in _labels(rows, name):
        own = [
            numbers.get(quantity, math.nan) for n, r, _, numbers in rows if (n, r) == (name, label)
        ]
        sound = [x for x in own if not math.isnan(x)]
        values.append(sum(sound) / len(sound) if sound else math.nan)
    return np.array(values)


def write(rows: Rows, csv: Path) -> None:
    """A row per run and start."""
    measured = [n for n in LABELS if any(n in numbers for *_, numbers in rows)]
    columns: dict[str, list[object]] = {
        "controller": [name for name, *_ in rows],
        "run": [label for _, label, *_ in rows],
        "start": [start for _, _, start, _ in rows],
        **{n: [numbers.get(n, math.nan) for *_, numbers in rows] for n in measured},
    }
    tables.write_csv(csv, columns, digits=6)  # type: ignore[arg-type]


def print_json(rows: Rows) -> None:
    """All rows as one JSON object."""
    listed = [
        {"name": name, "run": label, "start": start,
         **{n: x if math.isfinite(x) else None for n, x in numbers.items()}}
        for name, label, start, numbers in rows
    ]  # fmt: skip
    print(json.dumps({"episodes": listed}))


def require_environment(sets: Sequence[ControllerSet], place: str) -> None:
    """Raise `TegotaeError` where some runs were trained elsewhere."""
    if any(runs.task is None for runs in sets):
        raise TegotaeError(
            f"{place} has controllers that were trained on an environment and others; name their "
            "folders apart"
        )


def range_of(quantity: str) -> Range:
    """Least and largest possible value."""
    if quantity in ("lasted", "duty"):
        return (0.0, 1.0)
    signed = ("fitness", "return", "distance_m", "speed_m_per_s", "stride_hz")
    return UNBOUNDED if quantity in signed else (0.0, math.inf)


def _labels(rows: Rows, name: str) -> list[str]:
    return list(dict.fromkeys(label for n, label, *_ in rows if n == name))


STARTS = 8
"""Episodes of each run, on an environment with noise."""

IsPaired = Callable[[ControllerSet, ControllerSet], bool]


def compare_on_environment(
    sets: Sequence[ControllerSet], paired: IsPaired, *, as_json: bool
) -> None:
    """Play all, and print what each is and how it differs from the first.

    Args:
        sets: the runs, under names of their own.
        paired: whether the runs of two sets are to be paired, seed by seed.
        as_json: whether to print one JSON object.

    Raises:
        TegotaeError: for sets on different environments.
    """
    require_one_environment(sets)
    rows = [evaluate_all([runs], STARTS) for runs in sets]
    rows = [[(runs.name, label, start, x) for _, label, start, x in own]
            for runs, own in zip(sets, rows, strict=True)]  # fmt: skip
    whole: Rows = [row for own in rows for row in own]
    quantities = [name for name in LABELS if any(name in numbers for *_, numbers in whole)]
    base = sets[0]
    found: dict[str, dict[str, Interval]] = {}
    for runs in sets[1:]:
        take = paired_difference if paired(runs, base) else difference
        found[runs.name] = {
            name: take(
                per_run(whole, runs.name, name),
                per_run(whole, base.name, name),
                within=range_of(name),
            )
            for name in quantities
        }
    if as_json:
        print(json.dumps(_document(base.name, whole, found)))
        return
    print_table(whole)
    print_rows(
        (f"minus {base.name}", *found),
        [
            (_label(name), *(show(by_name[name]) for by_name in found.values()))
            for name in quantities
        ],
    )
    print_text(
        "Runs are paired, seed by seed, where they share what is random: controller and algorithm."
    )


def require_one_environment(sets: Sequence[ControllerSet]) -> None:
    """Raise `TegotaeError` unless all sets were trained on the same environment."""
    first, *others = sets
    for runs in others:
        if first.task is None or runs.task is None:
            ours = first if first.task is None else runs
            raise TegotaeError(f"{ours.name} is on this package's engine, and others are not")
        if runs.task.env != first.task.env or runs.task.settings != first.task.settings:
            raise TegotaeError(
                f"{first.name} is on {first.task.env} and {runs.name} on {runs.task.env}, or with "
                "other settings; controllers are compared on one environment"
            )


def _label(name: str) -> str:
    what, unit = LABELS[name]
    return f"{what} [{unit}]" if unit else what


def _document(base: str, rows: Rows, found: dict[str, dict[str, Interval]]) -> dict[str, object]:
    def plain(value: Interval) -> dict[str, object]:
        entries = dataclasses.asdict(value).items()
        return {k: None if isinstance(v, float) and math.isnan(v) else v for k, v in entries}

    return {
        "episodes": [
            {"name": name, "run": label, "start": start,
             **{n: x if math.isfinite(x) else None for n, x in numbers.items()}}
            for name, label, start, numbers in rows
        ],
        "differences": [
            {"name": name, "minus": base, **{n: plain(x) for n, x in each.items()}}
            for name, each in found.items()
        ],
    }  # fmt: skip
