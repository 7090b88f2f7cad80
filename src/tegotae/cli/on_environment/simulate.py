"""One episode of a controller on the environment that it was trained on."""

from __future__ import annotations

import json
import math
import re
from pathlib import Path

import numpy as np

from tegotae._support import tables
from tegotae.cli.outputs import check_outputs
from tegotae.cli.tables import print_rows
from tegotae.systems.controller_file import SavedController
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
        from tegotae.figures.film import write_film

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
    from tegotae.figures.episode import episode_figure
    from tegotae.figures.recording import recording_figure
    from tegotae.figures.style import literal, save_figure

    measured, rest = found.measured(), found.experiment.wiring.rest_length_m
    if measured is None or rest is None:
        save_figure(episode_figure(found, note=literal(name)), plot)
        return
    save_figure(recording_figure(measured, rest_length_m=rest, note=literal(name)), plot)
    beside = plot.with_name(f"{plot.stem}-loads{plot.suffix}")
    save_figure(episode_figure(found, note=literal(name)), beside)
