"""Training of Go1's laws by CMA-ES under disturbances.

A candidate's score is the share of its lanes that do not fall, less 0.3 |v / v* - 1|, the price of
its cost of transport, and 0.3 |ψ| of the heading at the end, from starts of its generation.
"""

from __future__ import annotations

import dataclasses
import math
from functools import partial

import numpy as np

from research.frame import write_rows
from research.go1.episodes import ROOT, SETTINGS, WIRING, by_law, evaluate
from research.go1.network import START, Pace
from research.go1.plan import (
    ADAPTATION,
    LAWS_FOLDER,
    OFF_COURSE,
    PHASES,
    POPULATION,
    TRAINED_S,
    TRAINED_SPEEDS,
    Phase,
)
from research.search import search
from tegotae._support.files import output_folder
from tegotae.envs.env_spec import EnvSpec
from tegotae.envs.wiring import Wiring, load_wiring
from tegotae.parts.terms import EllipticFoot
from tegotae.systems.controller_file import SavedController, save
from tegotae.systems.recipe import recipe
from tegotae.systems.resolve import resolve
from tegotae.training.algorithms import CMAES
from tegotae.training.environments.experiment import EnvExperiment

ELLIPSE = {"lift_m": 0.2, "press_m": 0.03, "shift_rad": 0.4, **START}
"""Numbers of the ellipse that all trainings begin with, without balance reflexes."""
BALANCE = ("roll_m", "roll_rate_ms", "pitch_m", "yaw")
"""Numbers that the training of the open-loop trot leaves at 0."""
SLOWEST, FASTEST = 5.0, 50.0
"""No law is commanded to step slower or faster [rad/s]."""


def untrained() -> Wiring:
    """Return the robot's limbs under the ellipse with which all trainings begin."""
    controller = recipe("clock-p@quadruped-c").controller()
    base = resolve("quadruped-c").controller()
    system = dataclasses.replace(base.system, controller=controller)
    numbers = np.array([ELLIPSE.get(path[-1], 0.0) for path in controller.weight_names])
    return load_wiring(WIRING).holding(SavedController(system, numbers, "paced"))


def wiring_of(law: SavedController) -> Wiring:
    """Return the robot's limbs under a law that was trained on it."""
    return dataclasses.replace(EnvExperiment.from_controller(law).wiring, weights=law.weights)


def trained(stem: str) -> dict[int, SavedController]:
    """Return the runs of a trained law, by their seeds."""
    files = sorted(LAWS_FOLDER.glob(f"{stem}-*.json"))
    return {int(f.stem.rpartition("-")[2]): resolve(str(f)).controller() for f in files}


def pace_of(wiring: Wiring) -> Pace:
    """Return the meaning of a law's commands: the speed of its feet on the bearing half of the
    ellipse."""
    controller, units = wiring.controller, wiring.units
    assert controller is not None
    assert units is not None
    actuation = controller.actuation
    ellipse = getattr(actuation, "ellipse", actuation)
    names = [path[-1] for path in controller.weight_names]
    numbers = dict(zip(names, np.ravel(wiring.weights), strict=True))
    stride = ellipse.stride_m if isinstance(ellipse, EllipticFoot) else math.nan
    stride_m = abs(numbers.get("stride_m", stride)) * units.length_m
    still = numbers.get("still_rad_per_s", 0.0) / units.time_s
    return Pace(stride_m, still, 2.0 * stride_m / math.pi)


def train_law(stem: str, seed: int) -> None:
    """Train a law in its phases, from where its training was stopped, and keep it.

    Args:
        stem: "open-loop", which has the first phase alone, or "clock-p".
        seed: of the search and of its starts.
    """
    phases, wiring = PHASES[:1] if stem == "open-loop" else PHASES, untrained()
    assert wiring.controller is not None
    names = [path[-1] for path in wiring.controller.weight_names]
    free = ~np.isin(names, BALANCE if stem == "open-loop" else ())
    weights = np.ravel(wiring.weights)
    for k, phase in enumerate(phases):
        place = output_folder(ROOT / "runs" / "go1") / f"{stem}-{k}-{seed}.npz"
        score = partial(_score, wiring, free, weights, phase, 10_000 * (1 + seed) + 100 * k)
        algorithm = CMAES(population=POPULATION, std=phase.std)
        mean, scores = search(place, algorithm, weights, phase.generations, score, seed)
        weights = np.where(free, mean, weights)
        rows = [{"generation": i, "mean": x.mean(), "best": x.max()} for i, x in enumerate(scores)]
        write_rows(LAWS_FOLDER / f"{stem}-{seed}.csv", rows, digits=4)
    keep(wiring, weights, stem, seed)


def _score(
    wiring: Wiring,
    free: np.ndarray,
    weights: np.ndarray,
    phase: Phase,
    start: int,
    candidates: np.ndarray,
    generation: int,
) -> np.ndarray:
    """Return the fitness of candidates in their free numbers, from the generation's start."""
    return fitness(wiring, np.where(free, candidates, weights), start + generation, phase)


def fitness(wiring: Wiring, candidates: np.ndarray, start: int, phase: Phase) -> np.ndarray:
    """Return the fitness of every candidate, [candidates]."""
    weights = np.repeat(candidates, len(TRAINED_SPEEDS), axis=0)
    target = np.tile(TRAINED_SPEEDS, len(candidates))
    paces = [pace_of(dataclasses.replace(wiring, weights=x)) for x in weights]
    omegas = np.array([pace.omega_at(v) for pace, v in zip(paces, target, strict=True)])
    omegas = np.clip(omegas, SLOWEST, FASTEST)
    laws, total = by_law(wiring, weights), np.zeros(len(weights))
    for condition in phase.conditions:
        results = evaluate(laws, omegas, [start] * len(weights), condition, TRAINED_S)
        off = np.minimum(np.abs(np.nan_to_num(results.speed_m_per_s) / target - 1.0), 1.0)
        cost = np.minimum(np.nan_to_num(results.cost_of_transport, nan=8.0), 8.0)
        astray = np.minimum(np.abs(np.nan_to_num(results.heading_rad, nan=1.0)), 1.0)
        total += ~results.fell - 0.3 * off - phase.price * cost - OFF_COURSE * astray
    return total.reshape(-1, len(TRAINED_SPEEDS)).mean(axis=1) / len(phase.conditions)


def adapt(seed: int) -> None:
    """Add tilt-triggered step adaptation to a trained trot with balance reflexes, and keep it."""
    wiring, law = wiring_of(trained("clock-p")[seed]), recipe("wary@quadruped-c").controller()
    share = ADAPTATION["lift"]
    assert wiring.controller is not None
    lift = np.array([path[-1] == "lift_m" for path in wiring.controller.weight_names])
    lower = np.where(lift, share, 1.0) * np.ravel(wiring.weights)
    weights = np.concatenate([[ADAPTATION["sigma"]], lower, [1.0 / share - 1.0]])
    limbs = load_wiring(WIRING).reading(law).limbs
    keep(dataclasses.replace(wiring, controller=law, limbs=limbs), weights, "wary", seed)


def keep(wiring: Wiring, weights: np.ndarray, stem: str, seed: int) -> None:
    """Write a law with its robot."""
    settings = {
        field.name: getattr(SETTINGS, field.name)
        for field in dataclasses.fields(SETTINGS)
        if getattr(SETTINGS, field.name) != field.default and field.name != "model"
    }
    experiment = EnvExperiment(
        name=stem,
        spec=EnvSpec(env=str(SETTINGS.model), settings=tuple(settings.items())),
        wiring=dataclasses.replace(wiring, weights=None),
    )
    system, task = experiment.system, experiment.task
    law = SavedController(system, weights, name=stem, task=task, training={"seed": seed})
    save(law, LAWS_FOLDER / f"{stem}-{seed}.json")
