"""Fig. 3: PGPE, SAC and PPO on the same policies, with sector and with reflex actuation.

    python -m research.experiments.figure3 --out results/figure3              # all of it
    python -m research.experiments.figure3 --out results/figure3 --arms pgpe  # a few minutes
    python -m research.experiments.figure3 --scale 0.01 --seeds 2             # a trial

All train and are evaluated in the same episodes, by CoT⁻¹ alone. SAC, PPO and `pgpe-figure3` have
settings that were tuned within the same simulated time; `pgpe` has those of all other trainings.
SAC and PPO learn from 6000 s, which is 500 episodes; PGPE trains to its plateau, and is judged
after 6000 s and after the paper's 80 generations, too.

Trainings that are done are not done again, and those that were interrupted go on; `--arms` and
`--models` train a part, so that several processes can share the work. `figure3.csv` has every point
of every curve, `figure3.md` the comparison at equal time, after 80 generations and at the end,
`figure3_gaits.csv` what the best policies do over 40 s, `figure3.png` the curves.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from research.frame import main, markdown_table
from research.reproduction.hop_rates import nearer_resonance
from tegotae._support.errors import require_finite, require_known
from tegotae._support.files import output_folder
from tegotae._support.tables import write_csv
from tegotae.figures.learning_curves import algorithms_figure
from tegotae.figures.style import save_figure
from tegotae.measures.evaluation import Protocol, evaluate
from tegotae.measures.hopping.metrics import HOPPING
from tegotae.measures.objectives.fitness import Fitness
from tegotae.measures.statistics import Interval, difference, interval
from tegotae.simulation.rollout import Timing
from tegotae.systems.controller_file import load
from tegotae.systems.recipe import recipe
from tegotae.training.agents.learner import AgentLearner
from tegotae.training.curves import COLUMNS, COT, groups, late_mean, read_curves
from tegotae.training.evolution import Evolution, Stopping
from tegotae.training.run import Run, train
from tegotae.training.settings import configuration

MODELS = {"AR-rF-sector-w8": "sector", "AR-rF-reflex-w8": "reflex"}
"""The paper's policies I and II: learned A and R, constant gain, actuation (6) or (7)."""
EVOLUTIONS = ("pgpe", "pgpe-figure3")
AGENTS = ("sac", "ppo")
ARMS = (*EVOLUTIONS, *AGENTS)
"""Named configurations of the algorithms."""
EPISODE = Timing(duration_s=12.0, tick_s=0.002)
SETTLE_S = 4.0
"""Time at the start of an episode that fitness ignores [s]."""
GENERATIONS = 80
"""Number of generations after which the paper's training ends."""


@dataclass(frozen=True)
class Figure3:
    """Train and draw Fig. 3."""

    out: Path = Path("results/figure3")
    """Folder for controllers and curves."""
    tables: Path | None = None
    """Folder for the tables and the figure; the same by default."""
    seeds: int = 10
    """Runs per policy and algorithm; one of SAC takes about ten minutes, of PPO two."""
    episodes: int = 500
    """Episodes of SAC and PPO."""
    scale: float = 1.0
    """Share of the training that is done."""
    arms: tuple[str, ...] = ARMS
    """Algorithms to train."""
    models: tuple[str, ...] = tuple(MODELS)
    """Policies to train."""

    def run(self) -> None:
        """Run the whole study."""
        require_finite("scale", self.scale, above=0.0)
        output_folder(self.out)
        tables = output_folder(self.out if self.tables is None else self.tables)
        for arm in self.arms:
            require_known("algorithm", arm, ARMS)
            for model in self.models:
                begun = time.monotonic()
                self.train(arm, model)
                print(f"{arm} {model}: {(time.monotonic() - begun) / 60:.1f} min", flush=True)
        write(
            pd.concat([curves_of(self.out / arm, arm) for arm in ARMS], ignore_index=True), tables
        )
        write_csv(tables / "figure3_gaits.csv", gaits(self.out))
        print(text(read_curves([tables / "figure3.csv"])), end="")

    def train(self, arm: str, model: str) -> None:
        """Train one policy by one algorithm, from all seeds."""
        objective = Fitness(settle_s=SETTLE_S, follow_omega=False)
        learner = self._agent(arm) if arm in AGENTS else self._evolution(arm)
        experiment = recipe(model).experiment(timing=EPISODE, objective=objective)
        run = Run(experiment=experiment, seeds=tuple(range(self.seeds)), learner=learner)
        train(run, self.out / arm / model)

    def _evolution(self, arm: str) -> Evolution:
        settings: Any = configuration(arm).settings
        criterion = Stopping()
        generations = max(2, round(criterion.generations * self.scale))
        stopping = replace(
            criterion, generations=generations, least=min(criterion.least, generations)
        )
        return Evolution(algorithm=settings, stopping=stopping)

    def _agent(self, arm: str) -> AgentLearner:
        settings: Any = configuration(arm).settings
        episodes = max(2, round(self.episodes * self.scale))
        every = max(1, round(10 * self.scale))
        return AgentLearner(settings=settings, episodes=episodes, evaluate_every=every)


def curves_of(folder: Path, arm: str) -> pd.DataFrame:
    """Return the curves of an algorithm's trainings by its name here, or none for a missing
    folder.
    """
    if not folder.is_dir():
        return pd.DataFrame(columns=COLUMNS)
    return read_curves([folder]).assign(algorithm=arm)


def write(curves: pd.DataFrame, out: Path) -> None:
    """Write the table of all points, the comparison and the figure."""
    write_csv(out / "figure3.csv", curves, digits=6)
    (out / "figure3.md").write_text(text(curves), encoding="utf-8")
    selection = curves[curves["algorithm"].isin(["pgpe-figure3", *AGENTS])]
    save_figure(algorithms_figure(selection), out / "figure3.png")


def gaits(out: Path) -> dict[str, list[Any]]:
    """Measure the gait of the best policy of each training at ω_t, over 40 s undisturbed.

    CoT⁻¹ and hop rate of its limit cycle, and by how much the rate is nearer to the body's best one
    than to ω; none of a policy that does not settle.
    """
    metrics = ("cot_inverse", "hop_rate", "limit_cycle_period")
    columns = ("algorithm", "model", "seed", *metrics, "nearer_resonance")
    rows: dict[str, list[Any]] = {name: [] for name in columns}
    for arm in ARMS:
        for model in MODELS:
            for path in sorted((out / arm / model).glob("*.json")):
                if path.name == "run.json":
                    continue
                saved = load(path)
                at_omega_t = Protocol(offsets=(0.0,))
                results = evaluate(
                    saved.controller,
                    saved.weights,
                    saved.omega,
                    protocol=at_omega_t,
                    metrics=metrics,
                )
                seed = int(path.stem.rpartition("seed")[2])
                measured = [float(results.episodes[name][0, 0]) for name in metrics]
                nearer = float(nearer_resonance(results.omega, results.episodes["hop_rate"])[0])
                for name, value in zip(columns, (arm, model, seed, *measured, nearer), strict=True):
                    rows[name].append(value)
    return rows


def text(curves: pd.DataFrame) -> str:
    """Return the table of PGPE beside the agents: last and best policy, after some training, with
    95 % intervals.
    """
    by = groups(curves)
    labels, over = ("policy", "algorithm", "runs", "simulated [s]"), ("over SAC", "over PPO")
    cells, best = (
        [[*labels, f"CoT⁻¹ of the {policy} [m/J]", *over]] for policy in ("last", "best")
    )
    for model, policy in MODELS.items():
        agents = {arm: by[model, arm] for arm in AGENTS if (model, arm) in by}
        equal = min((_end_s(run) for runs in agents.values() for run in runs), default=np.inf)
        for arm in ARMS:
            runs = by.get((model, arm), [])
            for until, label in _marks(arm, runs, equal):
                for lines, value in ((cells, late_mean), (best, _best)):
                    ours = [value(run, until(run)) for run in runs]
                    over = [
                        "" if arm in AGENTS or agent not in agents
                        else _words(difference(ours, [value(r, np.inf) for r in agents[agent]]))
                        for agent in AGENTS
                    ]  # fmt: skip
                    cost = _words(interval(ours, within=HOPPING.range_of(COT)))
                    labels = (policy, arm.upper() if arm in AGENTS else arm, str(len(runs)), label)
                    lines.append([*labels, cost, *over])
    return f"{markdown_table(cells)}\n{markdown_table(best)}"


def _marks(arm: str, runs: Sequence[pd.DataFrame], equal: float) -> list[tuple[Any, str]]:
    """Return until when an algorithm is evaluated: a time of each run, and its name in the
    table.
    """
    if not runs:
        return []
    if arm in AGENTS:
        return [(lambda run: np.inf, f"{_end_s(runs[0]):.0f}")]

    def paper_s(run: pd.DataFrame) -> float:
        return float(run["simulated_s"].iloc[min(GENERATIONS, len(run) - 1)])

    mean_end_s = float(np.mean([_end_s(run) for run in runs]))
    return [
        (lambda run: equal, f"{equal:.0f}"),
        (paper_s, f"{paper_s(runs[0]):.0f}, {GENERATIONS} generations"),
        (lambda run: np.inf, f"{mean_end_s:.0f}, plateau"),
    ]


def _end_s(run: pd.DataFrame) -> float:
    return float(run["simulated_s"].iloc[-1])


def _best(run: pd.DataFrame, until_s: float) -> float:
    return float(np.nanmax(run.loc[run["simulated_s"] <= until_s, COT]))


def _words(estimate: Interval) -> str:
    if np.isnan(estimate.low):
        return f"{estimate.mean:.2f}"
    return f"{estimate.mean:.2f} [{estimate.low:.2f}, {estimate.high:.2f}]"


if __name__ == "__main__":
    main(Figure3)
