"""A second look at claim 1: do SAC and PPO catch up with what suits them?

    python -m research.experiments.second_look --first research/experiments/figure3.csv

The policies, episodes and measure are those of Fig. 3 (`research/experiments/figure3.py`), whose
table is needed for comparison. What a sceptic would change:

- the critics sense the whole state of the body, not only what the policy does;
- an action is held for 50 ms: exploration is slower than what it excites, and a hop is tens of
  actions instead of hundreds;
- the horizon is 5 s, several hops;
- SAC takes twice as many gradient steps per action, and PPO updates after as much simulated time as
  in Fig. 3;
- rewards are honest: energy that the body lost since the last apex is charged as work too (with the
  paper's reward, a first hop that lives on the release pays most).

PGPE beside them is `pgpe-figure3` of Fig. 3.

Trainings that are done are not done again. Writes `second_look.png` and `second_look.csv`.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from research.experiments.figure3 import EPISODE, MODELS, SETTLE_S
from research.frame import main
from tegotae._support.files import output_folder
from tegotae.figures.learning_curves import (
    algorithms_compared,
    algorithms_figure,
    algorithms_tables,
)
from tegotae.figures.style import save_figure, write_tables
from tegotae.measures.objectives.fitness import Fitness
from tegotae.systems.recipe import recipe
from tegotae.training.agents import AgentSettings, PPOSettings, SACSettings
from tegotae.training.agents.learner import AgentLearner
from tegotae.training.curves import read_curves
from tegotae.training.run import Run, train
from tegotae.training.settings import tuned

LABELS = {"sac": "sac, suited", "ppo": "ppo, suited"}
DECIMATION = 50
HORIZON_S = 5.0


def suited(settings: AgentSettings) -> AgentSettings:
    """Return the tuned settings with those that suit an agent."""
    changed = dataclasses.replace(
        settings,
        critic_senses=("velocity", "height"),
        decimation=DECIMATION,
        gamma=1.0 - DECIMATION * settings.tick_s / HORIZON_S,
        charge_stored=True,
        normalize_reward=True,
    )
    if isinstance(changed, SACSettings):
        return dataclasses.replace(changed, gradient_steps=4, learning_starts=2_400)
    assert isinstance(changed, PPOSettings)
    n_steps = changed.n_steps * settings.decimation // DECIMATION
    return dataclasses.replace(changed, n_steps=n_steps, gae_lambda=0.95)


@dataclass(frozen=True)
class SecondLook:
    """Train, compare, draw."""

    first: Path = Path("research/experiments/figure3.csv")
    """Table of Fig. 3."""
    out: Path = Path("results/second_look")
    """Folder for controllers and curves."""
    figure: Path = Path("research/experiments/second_look.png")
    """The figure; its table goes beside it."""
    seeds: int = 3
    """Runs per policy and algorithm."""
    episodes: int = 1000
    """Episodes of each run."""
    algorithms: tuple[str, ...] = tuple(LABELS)
    """Algorithms to train."""

    def run(self) -> None:
        """Run the whole study."""
        output_folder(self.out)
        for algorithm in self.algorithms:
            for model in MODELS:
                self.train(algorithm, model, self.out / algorithm / model)
        first = read_curves([self.first])
        second = read_curves([self.out]).replace({"algorithm": LABELS})
        curves = pd.concat([first[first["algorithm"] == "pgpe-figure3"], second], ignore_index=True)
        save_figure(algorithms_figure(curves), self.figure)
        write_tables(self.figure, algorithms_tables(second))
        print(algorithms_compared(pd.concat([first, second], ignore_index=True)).to_string())

    def train(self, algorithm: str, model: str, out: Path) -> None:
        """Train one policy by one algorithm, from all seeds."""
        objective = Fitness(settle_s=SETTLE_S, follow_omega=False)
        run = Run(
            experiment=recipe(model).experiment(timing=EPISODE, objective=objective),
            seeds=tuple(range(self.seeds)),
            learner=AgentLearner(settings=suited(tuned(algorithm)), episodes=self.episodes),
        )
        train(run, out)


if __name__ == "__main__":
    main(SecondLook)
