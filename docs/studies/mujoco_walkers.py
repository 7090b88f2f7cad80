"""Gymnasium's Hopper, Walker2d and Ant, and this package's leg: no torque, vanilla, learned.

    python docs/studies/mujoco_walkers.py learn WORK     # some minutes of one core; it can go on
    python docs/studies/mujoco_walkers.py table WORK

Writes `docs/_static/mujoco/walkers.csv`: of each way its return and how far it went, from starts
that nothing was chosen by.
"""

from __future__ import annotations

import dataclasses
import sys
from pathlib import Path
from typing import Any

import numpy as np

from tegotae import find
from tegotae.controller_file import load
from tegotae.envs.pilot import Pilot
from tegotae.envs.wiring_file import load_wiring
from tegotae.tables import write_csv
from tegotae.training.run import Run, train
from tegotae.training.settings import tuned
from tegotae.training.stopping import Stopping
from tegotae.training.wired.experiment import WiredExperiment
from tegotae.training.wired.measures import Own, Return
from tegotae.training.wired.place import Place
from tegotae.training.wired.stage import lanes_of, play

ROOT = Path(__file__).resolve().parents[2]
OUT = ROOT / "docs" / "_static" / "mujoco"
WHERE = {
    "Hopper-v5": ("hopper-v5.toml", 14.0, ()),
    "Walker2d-v5": ("walker2d-v5.toml", 10.0, ()),
    # Without the reward for standing alive, which a body that lies still earns.
    "Ant-v5": ("ant-v5.toml", 12.0, (("healthy_reward", 0.0),)),
    "leg": ("leg", 12.0, (("duration_s", 8.0),)),
}
"""Wiring, ω [rad/s] and what the environment is made with."""
SECONDS, POPULATION, GENERATIONS = 8.0, 16, 20
STARTS = (100, 101, 102, 103, 104)


def experiment(name: str, model: str) -> WiredExperiment:
    """A model of the paper on one of the bodies, judged by its return over two starts."""
    file, omega, made = WHERE[name]
    place = Place(env=name, settings=made)
    wiring = load_wiring(file if name == "leg" else ROOT / "examples" / "wirings" / file)
    env = place.make()
    wiring = wiring.with_scales(env)
    env.close()
    # The leg is always released alike: a second episode would be the first again.
    episodes = 1 if name == "leg" else 2
    settings: dict[str, Any] = {"omega": omega, "duration_s": SECONDS, "episodes": episodes}
    own = WiredExperiment.of_model(find(model), place, wiring, **settings)
    return dataclasses.replace(own, measure=Return())


def learn(work: Path) -> None:
    """What is not done yet: σ by search, and ART by PGPE."""
    for name in WHERE:
        for model in ("V-sector-w8", "ART"):
            run = Run(
                experiment=experiment(name, model),
                seeds=(0,),
                algorithm=dataclasses.replace(tuned("pgpe"), population=POPULATION),
                stopping=Stopping.after(GENERATIONS),
                workers=0,
            )
            (path,) = train(run, work / f"{name}-{model}")
            print(name, model, load(path).training["best_fitness"], flush=True)


def seen(own: WiredExperiment, weights: np.ndarray) -> list[tuple[float, float, float]]:
    """Return, distance [m] and time [s] of each of the starts."""
    lanes = lanes_of(own, 1)
    pilot = Pilot(own.wires, own.wiring, weights[:, None])
    names, found = own.wires.observed, []
    for start in STARTS:
        record = play(
            lanes, pilot, own.wires, Own("all:kept"), own.wiring, seed=start, tried=np.ones(1, bool)
        )
        episode = record.episode(0)
        speed = next(
            n for n in ("rootx_velocity", "root_velocity", "root_velocity[0]") if n in names
        )
        went = float(episode[speed].sum() * own.wires.step_s)
        found.append((float(episode.reward.sum()), went, float(episode.time_s[-1])))
    lanes.close()
    return found


def table(work: Path) -> None:
    """All ways on all bodies."""
    rows: list[tuple[Any, ...]] = []
    for name in WHERE:
        vanilla = experiment(name, "V-sector-w8")
        still = tuple(
            dataclasses.replace(limb, rest=0.0, push=1e-6) for limb in vanilla.wiring.limbs
        )
        idle = dataclasses.replace(vanilla, wiring=dataclasses.replace(vanilla.wiring, limbs=still))
        ways: dict[str, tuple[WiredExperiment, np.ndarray]] = {
            "no torque": (idle, np.zeros(1)),
            "no feedback": (vanilla, np.zeros(1)),
        }
        for way, model in (("vanilla", "V-sector-w8"), ("learned ART", "ART")):
            own = experiment(name, model)
            file = next((work / f"{name}-{model}").glob("*-seed0.json"))
            ways[way] = own, np.asarray(load(file).weights)
        for way, (own, weights) in ways.items():
            found = np.array(seen(own, weights))
            rows.append((name, way, *found.mean(axis=0), found[:, 0].min(), found[:, 0].max()))
            print(rows[-1])
    header = ("body", "way", "return", "distance_m", "time_s", "least_return", "most_return")
    OUT.mkdir(parents=True, exist_ok=True)
    columns = dict(zip(header, zip(*rows, strict=True), strict=True))
    write_csv(OUT / "walkers.csv", columns, digits=4)


if __name__ == "__main__":
    {"learn": learn, "table": table}[sys.argv[1]](Path(sys.argv[2]))
