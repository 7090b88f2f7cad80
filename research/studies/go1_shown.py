"""The best law that Go1 learned: its film, as C in closed loop, and the file of the zoo."""

from __future__ import annotations

import dataclasses
import sys
import tempfile
from pathlib import Path

import numpy as np
from matplotlib.image import imsave
from PIL import Image, ImageSequence

from go1_plan import FEET, JUDGED_S, LAWS, OUT, ROOT, RUNS, STARTS, learned
from go1_report import of_seeds
from kept import write_rows
from research.reproduction.zoo import ZooEntry, write_archive
from tegotae._support.documents import JsonObject
from tegotae.api.pictures import animate
from tegotae.envs.wrapper import Pilot
from tegotae.figures.animation import film
from tegotae.systems import controller_file
from tegotae.systems.controller_file import SavedController, load
from tegotae.training.environments.experiment import EnvExperiment
from tegotae.training.environments.replay import replay
from tegotae_robots.c import Export
from tegotae_robots.c.plan import usual_tick_s

ZOO = ROOT / "src" / "tegotae" / "systems" / "zoo" / "data" / "go1.npz"
SHOWN_OMEGA, SHOWN_S = 16.0, 4.0
PLACE = ("root_forward", "root_height")
"""Observations of the torso that are compared."""


def runs(name: str) -> list[SavedController]:
    """The runs of a law, in the order of their seeds."""
    controllers = [load(file) for file in (RUNS / name).glob("*/*-seed*.json")]
    return sorted(controllers, key=lambda saved: int(str(saved.training["seed"])))


def best() -> tuple[str, SavedController]:
    """The law and run of the best training fitness."""
    every = [(name, saved) for name in LAWS for saved in runs(name)]
    return max(every, key=lambda pair: float(str(pair[1].training["best_fitness"])))


def alone(name: str, omega: float, seconds: float) -> EnvExperiment:
    """A law's experiment with one episode, at one frequency."""
    task = learned(name)
    wiring = dataclasses.replace(task.wiring, omega=omega)
    return dataclasses.replace(task, wiring=wiring, omegas=(), episodes=1, duration_s=seconds)


def show() -> None:
    """A film of the best law, and six of its pictures in a row."""
    name, saved = best()
    (episode,) = replay(alone(name, SHOWN_OMEGA, SHOWN_S), saved.weights[None], seed=STARTS[0])
    smaller(animate(episode, OUT / "go1.gif"))
    pictures = film(episode)
    period = 2.0 * np.pi / SHOWN_OMEGA  # of the clock; 25 pictures a second
    frames = [round(25.0 * (2.0 + period * k / 5.0)) for k in range(6)]
    row = np.concatenate([pictures[k][60:330, 60:420] for k in frames], axis=1)
    imsave(OUT / "go1_stride.png", row[::2, ::2])
    print(name, {key: round(value, 3) for key, value in episode.numbers().items()})


def smaller(path: Path) -> None:
    """A film of half the pictures, at 300 pixels and 48 colours."""
    with Image.open(path) as film_of_all:
        frames = [frame.convert("RGB") for frame in ImageSequence.Iterator(film_of_all)]
    height = round(300 * frames[0].height / frames[0].width)
    first, *later = [frame.resize((300, height)).quantize(48) for frame in frames[::2]]
    first.save(path, save_all=True, append_images=later, duration=80, loop=0, optimize=True)


def as_c() -> None:
    """Print the distance between the torso under the C and under the package, over an episode."""
    sys.path.insert(0, str(ROOT / "tests" / "helpers"))
    from compiled import Compiled

    name, saved = best()
    task = alone(name, SHOWN_OMEGA, JUDGED_S)
    pilot = Pilot(task.wires, task.wiring, saved.weights[:, None])
    with tempfile.TemporaryDirectory() as folder:
        program = Compiled(Export(saved, usual_tick_s(saved), "go1"), Path(folder))
        env = task.spec.make()
        felt = [task.wires.observed.index(f"{foot}_force") for foot in FEET for _ in range(2)]
        neutral, push = task.wires.rest, task.wires.push
        phases = [limb.phase_rad for limb in task.wiring.limbs]

        def of_package(observation: np.ndarray) -> np.ndarray:
            return pilot.act(observation[None])[0]

        def of_c(observation: np.ndarray) -> np.ndarray:
            force = program.step(np.maximum(observation[felt], 0.0))[0]
            action = np.zeros(len(task.wires.low))
            action[task.wires.driven[0]] = (
                neutral + (push - neutral) * force / task.wiring.max_force
            )
            return action

        def path(act) -> np.ndarray:
            observation, _ = env.reset(seed=STARTS[0])
            pilot.reset()
            program.init(phases)
            program.state[-2] = SHOWN_OMEGA  # that of the state; the file's own is the middle one
            torso = []
            for _ in range(round(JUDGED_S / task.wires.step_s)):
                observation = env.step(act(observation))[0]
                torso.append([observation[task.wires.observed.index(n)] for n in PLACE])
            return np.array(torso)

        gap = np.linalg.norm(path(of_c) - path(of_package), axis=1)
    rows = []
    for until_s in (0.5, 1.0, 2.0, 4.0, JUDGED_S):
        steps = round(until_s / task.wires.step_s)
        rows.append({"law": name, "until_s": until_s, "gap_m": float(gap[:steps].max())})
        print(rows[-1])
    write_rows(OUT / "go1_c.csv", rows, digits=2)


def keep() -> None:
    """Keep all runs as a study of the zoo, `zoo:go1:LAW@go1`."""
    write_archive(ZOO, "go1", [entry(name) for name in LAWS if runs(name)])


def entry(name: str) -> ZooEntry:
    """The runs of a law, with what the judgement says of each: means over frequencies."""
    controllers = runs(name)
    document: JsonObject = controller_file.described(controllers[0], name)
    leave = {"seed", "best_fitness", "best_generation", "generations", "ended", "episodes"}
    training = {key: x for key, x in controllers[0].training.items() if key not in leave}
    document = {n: x for n, x in document.items() if n != "weights"}
    document |= {"name": f"{LAWS[name]}@go1", "training": training}
    return ZooEntry(
        document=document,
        weights=np.stack([run.weights for run in controllers]),
        **{
            n: np.array([run.training[n] for run in controllers])
            for n in ("seed", "generations", "ended")
        },
        fitness=np.array([run.training["best_fitness"] for run in controllers]),
        metrics={
            column: np.array(of_seeds(name, "unseen starts", column))
            for column in ("return_per_s", "speed_m_per_s", "fell")
        },
    )
