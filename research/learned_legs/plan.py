"""Plan of the study of learned feedback on legs: trainings and their lengths, fixed before any
result."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from tegotae._support.tables import read_csv
from tegotae.measures.fronts import front
from tegotae.measures.objectives.walking import CommandedWalking
from tegotae.parts.bodies import Sensors
from tegotae.simulation.rollout import Timing
from tegotae.simulation.world import Uniform
from tegotae.systems.experiment import Experiment
from tegotae.systems.recipe import Recipe, recipe
from tegotae.systems.term_sets import LAWS_OF_LEGS, nominal_speed_m_per_s
from tegotae.training.evolution import Evolution, Stopping
from tegotae.training.run import Run
from tegotae.training.settings import tuned

FOLDER = Path("runs/learned_legs")
"""Folder of the controllers."""
TABLES = Path(__file__).resolve().parents[2] / "research" / "learned_legs"
"""Folder of the tables and figures."""
ZOO = Path(__file__).resolve().parents[2] / "src/tegotae/systems/zoo/data/legs.npz"
"""Archive of the learned laws for names such as `zoo:legs:AR-rF+range@quadruped-c`."""

OMEGA = (0.9, 3.6)
"""Commands that a law is trained for, a little beyond those that it is evaluated at [rad/s]."""
HURRY = 1.2
"""The wanted speed over 2 B ω / π, at which a foot crosses its stride in half a turn. In a pilot
that wanted just this, the one run of ten that walked cheaply at all speeds was a fifth too fast."""
VARIED = (
    Uniform("omega", low=OMEGA[0], high=OMEGA[1]),
    Uniform("phase_rad", low=0.0, high=2.0 * math.pi),
    Uniform("mass_kg", low=0.8, high=1.2),
    Uniform("friction", low=0.5, high=1.1),
    Uniform("delay_s", low=0.0, high=0.032),
)
"""Quantities that every episode draws anew: command, release, mass, friction and the delay of the
senses."""
DELAY_TICKS = 4
"""The longest delay, in control ticks."""
EPISODE = Timing(duration_s=48.0, tick_s=0.0125, frame_s=0.1)
"""An episode for a range [√(l0/g)]; the second half counts. The evaluation has shorter ticks."""
CAREFUL = {"std": 0.05, "learning_rate": 0.06, "max_speed": 0.12}
"""The search for a range. Steps as on the hopper, six times as long, throw away a gait that was
found: the legs then lock in another way, or not."""
TO_THE_PLATEAU = Stopping(least=100, share=0.4, tolerance=0.02)
"""Criterion that ends a training for a range before its cap."""
EPISODES = 4
"""Episodes of a candidate; all candidates of a generation meet the same ones."""


def training_front() -> tuple[tuple[float, float], ...]:
    """Return the speed and cost of transport of the vanilla front with which the fitness compares.

    The front as it was when the trainings began (`tegotae.measures.fronts`): a better one, found
    later, would else be another training.
    """
    table = read_csv(TABLES / "training_front.csv")
    pairs = zip(table["speed_m_per_s"], table["cost_of_transport"], strict=True)
    return tuple((float(speed), float(cost)) for speed, cost in pairs)


def baseline_cost(speed_m_per_s: np.ndarray) -> np.ndarray:
    """Return the vanilla front's cost of transport at a speed; beyond its ends the last value."""
    return np.interp(speed_m_per_s, *baseline())


def baseline() -> tuple[np.ndarray, np.ndarray]:
    """Return the speeds and costs of transport of the vanilla front, [points] each."""
    curve = front("quadruped-c", "vanilla")
    return np.asarray(curve["speed"]), np.asarray(curve["cost_of_transport"])


@dataclass(frozen=True)
class Cell:
    """A design that is trained from several seeds."""

    recipe: str
    """The design's name."""
    generations: int = 100
    """Largest number of generations, of 32 candidates each."""
    seeds: int = 5
    """Runs from random weights."""
    deviation: float = 0.1
    """First deviation of the search."""
    ranged: bool = False
    """True if the law is trained for a range of commands, under changing conditions."""

    @cached_property
    def design(self) -> Recipe:
        """The recipe."""
        return recipe(self.recipe)

    @property
    def name(self) -> str:
        """The design's name, with `+range` before the @ if it is trained for a range."""
        return self.experiment.name

    @cached_property
    def experiment(self) -> Experiment:
        """Return the experiment of the training."""
        experiment = self.design.experiment()
        return for_a_range(experiment, self.design) if self.ranged else experiment

    @property
    def run(self) -> Run:
        """Return the training run: for a range to the plateau, else for a number of generations."""
        if not self.ranged:
            algorithm = dataclasses.replace(tuned("pgpe"), std=self.deviation)
            stopping = Stopping.after(self.generations)
        else:
            algorithm = dataclasses.replace(tuned("pgpe"), **CAREFUL)
            stopping = dataclasses.replace(TO_THE_PLATEAU, generations=self.generations)
        return Run(
            experiment=self.experiment,
            seeds=tuple(range(self.seeds)),
            learner=Evolution(algorithm=algorithm, stopping=stopping),
        )


def advance_m_per_rad(design: Recipe) -> float:
    """Return the wanted distance per radian of the command [m/rad]."""
    nominal = nominal_speed_m_per_s(design.system, 1.0)
    assert nominal is not None  # all have ellipses
    return HURRY * nominal


def for_a_range(experiment: Experiment, design: Recipe) -> Experiment:
    """Return the experiment for a range of commands from any release, on bodies that differ."""
    objective = CommandedWalking(
        front=training_front(),
        advance_m_per_rad=advance_m_per_rad(design),
        settle_s=0.5 * EPISODE.duration_s,
    )
    return design.experiment(
        body=Sensors(body=experiment.body, most_ticks=DELAY_TICKS),
        name=experiment.name.replace("@", "+range@"),
        timing=EPISODE,
        objective=objective,
        conditions=VARIED,
        episodes=EPISODES,
    )


RANGE = tuple(
    Cell(f"{family}@quadruped-c", generations=600, seeds=10, ranged=True)
    for family in ("V", "cos", *LAWS_OF_LEGS, "decay-t", "VG", "AR", "ARG", "ART-t+phif", "W+phi-F")
)
"""Laws for every speed; V has one σ for all of them, and short laws have three or four numbers,
with the ellipse's eight."""
HEXAPOD = tuple(Cell(f"{family}@hexapod", seeds=3) for family in ("V", "AR"))
"""Trained at one frequency, from one release."""
PLATE = tuple(
    Cell(f"{family}@plate-light-pitch", seeds=4, deviation=0.2)
    for family in ("V", "AR", "ART", "Wphi-F")
)
"""Trainings of legs that hop."""
CELLS = (*RANGE, *HEXAPOD, *PLATE)
"""All cells, in the order in which they are trained."""


def is_trained(cell: Cell, folder: Path) -> bool:
    """Return True if a cell has all its controllers, trained to the end."""
    from tegotae.systems.controller_file import load

    searched = cell.experiment.is_searched
    files = sorted((folder / cell.name).glob("*-seed*.json"))
    if len(files) < (1 if searched else cell.seeds):
        return False
    return all(load(file).training["ended"] for file in files)
