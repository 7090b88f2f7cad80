"""Fig. 3: PGPE, SAC and PPO on the same policies, with sector and with reflex actuation.

    python studies/figure3.py --out results/figure3                  # all of it
    python studies/figure3.py --out results/figure3 --algorithms pgpe cma-es    # a minute or two
    python studies/figure3.py --out /tmp/figure3 --scale 0.01        # to see that everything works

PGPE, and CMA-ES beside it, train to the plateau with the settings and the episodes of all other
trainings; SAC and PPO as many episodes as the paper names, shorter ones, with settings that were
tuned on these policies. Fitness and reward are CoT⁻¹ alone.

Trainings that are done are not done again, and those that were interrupted go on; `--algorithms`
and `--models` train a part, so that several processes can share the work. The figure shows what
there is: `figure3.png`, with all its numbers in `figure3.csv`.
"""

from __future__ import annotations

import sys
import time
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import tyro

from tegotae._support.errors import require_finite, unknown
from tegotae._support.files import output_folder
from tegotae.cli.console import exit_status
from tegotae.cli.figure.learning_curves import LearningCurves
from tegotae.measures.objectives.fitness import Fitness
from tegotae.simulation.rollout import Timing
from tegotae.systems.models import find
from tegotae.training.agents import AgentLearner
from tegotae.training.algorithms import CMAES, Algorithm
from tegotae.training.evolution import Evolution
from tegotae.training.evolve import Stopping
from tegotae.training.run import Run, train
from tegotae.training.settings import configuration, tuned

MODELS = ("AR-rF-sector-w8", "AR-rF-reflex-w8")
"""The paper's policies I and II: learned A and R, constant gain, actuation (6) or (7)."""
EVOLUTION: dict[str, Algorithm] = {
    "pgpe": tuned("pgpe"),
    "cma-es": CMAES(population=32, std=0.2),
}
AGENTS = ("sac", "ppo")
"""Named configurations of the agents."""
EPISODE = Timing(duration_s=12.0, tick_s=0.002)
SETTLE_S = 4.0
"""Of an agent's episode [s]. Shorter than in all other trainings: the agents' time is simulated
step by step, and is what the comparison costs."""


@dataclass(frozen=True)
class Figure3:
    """Train and draw Fig. 3."""

    out: Path = Path("results/figure3")
    """Folder for controllers, curves and the figure."""
    seeds: int = 8
    """Runs per policy of PGPE and CMA-ES."""
    agent_seeds: int = 3
    """Runs per policy of SAC and PPO, as the paper has them; one takes up to half an hour."""
    episodes: int = 1000
    """Episodes of SAC and PPO."""
    scale: float = 1.0
    """Share of the training that is done."""
    algorithms: tuple[str, ...] = (*EVOLUTION, *AGENTS)
    """Which to train."""
    models: tuple[str, ...] = MODELS
    """Which policies to train."""

    def run(self) -> None:
        """Do it all."""
        require_finite("scale", self.scale, above=0.0)
        output_folder(self.out)
        for algorithm in self.algorithms:
            if algorithm not in (*EVOLUTION, *AGENTS):
                raise unknown("algorithm", algorithm, (*EVOLUTION, *AGENTS))
            for model in self.models:
                begun = time.monotonic()
                self.train(algorithm, model)
                print(f"{algorithm} {model}: {(time.monotonic() - begun) / 60:.1f} min", flush=True)
        LearningCurves(runs=(self.out,), out=self.out / "figure3.png").run()

    def train(self, algorithm: str, model: str) -> None:
        """All seeds of one policy by one algorithm."""
        is_agent = algorithm in AGENTS
        if is_agent:
            objective = Fitness(settle_s=SETTLE_S, follow_omega=False)
            experiment = find(model).experiment(timing=EPISODE, objective=objective)
        else:
            experiment = find(model).experiment(objective=Fitness(follow_omega=False))
        train(
            Run(
                experiment=experiment,
                seeds=tuple(range(self.agent_seeds if is_agent else self.seeds)),
                learner=self._agent(algorithm) if is_agent else self._evolution(algorithm),
            ),
            self.out / algorithm / model,
        )

    def _evolution(self, algorithm: str) -> Evolution:
        whole = Stopping()
        generations = max(2, round(whole.generations * self.scale))
        stopping = replace(whole, generations=generations, least=min(whole.least, generations))
        return Evolution(algorithm=EVOLUTION[algorithm], stopping=stopping)

    def _agent(self, algorithm: str) -> AgentLearner:
        settings: Any = configuration(algorithm).settings
        episodes = max(2, round(self.episodes * self.scale))
        every = max(1, round(10 * self.scale))
        return AgentLearner(settings=settings, episodes=episodes, evaluate_every=every)


if __name__ == "__main__":
    sys.exit(exit_status(tyro.cli(Figure3).run))
