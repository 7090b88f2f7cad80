"""Fig. 3: PGPE, SAC and PPO on the same policies, with sector and with reflex actuation.

    python studies/figure3.py --out results/figure3              # the paper's size
    python studies/figure3.py --out /tmp/figure3 --scale 0.01    # to see that everything works

Trainings that are done are not done again, and those that were interrupted go on; `--algorithms`
and `--models` train a part, so that several processes can share the work. The figure shows what
there is: `figure3.png`, with all its numbers in `figure3.csv`. All algorithms have settings that
were tuned on these policies within the same simulated time.
"""

from __future__ import annotations

import sys
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import tyro

from tegotae._support.errors import require_finite, unknown
from tegotae._support.files import output_folder
from tegotae.cli.figure.learning_curves import LearningCurves
from tegotae.cli.status import exit_status
from tegotae.measures.objectives.fitness import Fitness
from tegotae.simulation.rollout import Timing
from tegotae.systems.models import find
from tegotae.training.agents import AgentLearner
from tegotae.training.evolution import Evolution
from tegotae.training.run import Run, train
from tegotae.training.settings import configuration
from tegotae.training.stopping import Stopping

MODELS = ("AR-rF-sector-w8", "AR-rF-reflex-w8")
"""The paper's policies I and II: learned A and R, constant gain, actuation (6) or (7)."""
SETTINGS = {"pgpe": "pgpe-figure3", "sac": "sac", "ppo": "ppo"}
"""Named configurations of the algorithms."""
EPISODE = Timing(duration_s=12.0, tick_s=0.002)
SETTLE_S = 4.0
"""Of an episode [s]. Shorter than in all other trainings: the agents' time is simulated step by
step, and is what the comparison costs."""


@dataclass(frozen=True)
class Figure3:
    """Train and draw Fig. 3."""

    out: Path = Path("results/figure3")
    """Folder for controllers, curves and the figure."""
    seeds: int = 3
    """Runs per policy and algorithm."""
    generations: int = 80
    """Generations of PGPE."""
    episodes: int = 1000
    """Episodes of SAC and PPO; 5120 are the simulated time of 80 generations."""
    scale: float = 1.0
    """Share of these that is done."""
    algorithms: tuple[str, ...] = tuple(SETTINGS)
    """Which to train."""
    models: tuple[str, ...] = MODELS
    """Which policies to train."""

    def run(self) -> None:
        """Do it all."""
        require_finite("scale", self.scale, above=0.0)
        output_folder(self.out)
        for algorithm in self.algorithms:
            if algorithm not in SETTINGS:
                raise unknown("algorithm", algorithm, SETTINGS)
            for model in self.models:
                begun = time.monotonic()
                self.train(algorithm, model)
                print(f"{algorithm} {model}: {(time.monotonic() - begun) / 60:.1f} min", flush=True)
        LearningCurves(runs=(self.out,), out=self.out / "figure3.png").run()

    def train(self, algorithm: str, model: str) -> None:
        """All seeds of one policy by one algorithm."""
        out = self.out / algorithm / model
        settings: Any = configuration(SETTINGS[algorithm]).settings
        shared: dict[str, Any] = {
            "experiment": find(model).experiment(
                timing=EPISODE, objective=Fitness(settle_s=SETTLE_S, follow_omega=False)
            ),
            "seeds": tuple(range(self.seeds)),
        }
        if algorithm == "pgpe":
            generations = max(2, round(self.generations * self.scale))
            train(
                Run(
                    **shared,
                    learner=Evolution(algorithm=settings, stopping=Stopping.after(generations)),
                ),
                out,
            )
            return
        episodes = max(2, round(self.episodes * self.scale))
        every = max(1, round(10 * self.scale))
        agent = AgentLearner(settings=settings, episodes=episodes, evaluate_every=every)
        train(Run(**shared, learner=agent), out)


if __name__ == "__main__":
    sys.exit(exit_status(tyro.cli(Figure3).run))
