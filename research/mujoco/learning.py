"""PGPE, SAC and PPO on the MuJoCo hopper: the same limb, observations and simulated time.

    python -m research.mujoco.learning learn WORK           # hours of a core; it can go on
    python -m research.mujoco.learning tables WORK          # robustness, tables, picture

Writes `curves.csv`, `robustness.csv`, `learned.md`, `apart.md`, `robust.md` and `curves.png` to
`research/mujoco`.
"""

from __future__ import annotations

import dataclasses
import math
import time
from collections.abc import Iterator
from itertools import combinations, product
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import torch
from gymnasium.spaces import Box

from research.frame import Place, main, markdown_table, with_interval, write_rows, write_text
from research.lane_env import LaneEnv
from tegotae.envs import load_wiring
from tegotae.envs.env_spec import EnvSpec
from tegotae.envs.mujoco.sensing import sensing
from tegotae.envs.wrapper import Pilot
from tegotae.figures.style import COLOURS, COLUMN_IN, new_figure, save_figure, styled
from tegotae.parts.controller import Controller
from tegotae.systems.recipe import recipe
from tegotae.training.agents import agent_controller
from tegotae.training.agents.actor import Feedback, Observed
from tegotae.training.environments.experiment import EnvExperiment
from tegotae.training.environments.objectives import Hopping
from tegotae.training.environments.rollouts import ModelLanes, play
from tegotae.training.evaluator import Generation
from tegotae.training.evolution import Evolution, Stopping
from tegotae.training.learner import initial_weights
from tegotae.training.run import Run
from tegotae.training.scoring import evaluator_of
from tegotae.training.settings import tuned

OUT = Path(__file__).resolve().parents[2] / "research" / "mujoco"
ALGORITHMS = ("pgpe", "ppo", "sac")
KEY = ["model", "algorithm", "seed"]
SHARES = (0.25, 0.5, 1.0)
MODELS = ("AR-rF-sector-w8", "AR-rF-reflex-w8")
SEEDS = tuple(range(8))
EPISODE_S, SETTLE_S = 12.0, 4.0
TIME_S = 3072.0
"""Simulated time of one training [s], 256 episodes: twice what SAC and PPO were tuned for."""
POPULATION = 16
POINTS = 16
"""Number of evaluations of an agent."""
CONTROL_S, DECISION = 0.005, 2
"""Control period [s], and how many an agent's action is held for: 10 ms, as it was tuned for."""
LIMIT = 40.0
"""The feedback at which the policy saturates [rad/s]."""


def policy(model: str) -> Controller:
    """Return the policy that all three learn: f = L tanh(G A' R / L)."""
    return agent_controller(recipe(model).experiment(), tuned("sac"))


def experiment(model: str) -> EnvExperiment:
    """Return the experiment: the policy on the MuJoCo hopper, scored by CoT⁻¹ alone as in the
    paper's comparison.
    """
    wiring = dataclasses.replace(load_wiring("hopper").reading(policy(model)), omega=8.0)
    settings = {"duration_s": EPISODE_S, "control_s": CONTROL_S, "fallen_share": 0.0}
    return EnvExperiment(
        name=model,
        spec=EnvSpec(env="hopper", settings=tuple(settings.items())),
        wiring=wiring,
        objective=Hopping(settle_s=SETTLE_S, follow_omega=False),
        duration_s=EPISODE_S,
    )


class Feedbacks(LaneEnv):
    """Hoppers side by side whose action is the feedback, paid at apexes as the paper has it."""

    def __init__(self, task: EnvExperiment, lanes: int) -> None:
        self.hoppers = ModelLanes(task.spec.model_settings, lanes, threads=1)
        # The same oscillator and actuation; σ = 0 leaves the feedback to the agent.
        kind = recipe("V-reflex-w8" if "reflex" in task.name else "V-sector-w8").controller()
        bare = dataclasses.replace(task, wiring=task.wiring.reading(kind))
        self.pilot = Pilot(bare.wires, bare.wiring, np.zeros((1, lanes)))
        names = task.wires.observed
        self.at = {n: names.index(n) for n in ("root_height", "root_climb", "leg_spring", "work")}
        self.weight = task.wiring.scales["spring_force"]
        self.steps = self.hoppers.steps // DECISION
        super().__init__(lanes, Box(-np.inf, np.inf, (3,)), Box(-1.0, 1.0, (1,)))

    def _inputs(self) -> np.ndarray:
        load = np.maximum(self.seen[:, self.at["leg_spring"]], 0.0) / self.weight
        phase = self.pilot.phase[0]
        return np.stack([np.sin(phase), np.cos(phase), load], axis=1).astype(np.float32)

    def reset(self) -> np.ndarray:
        self.seen = self.hoppers.reset(0, np.ones(self.num_envs, bool))
        self.pilot.reset()
        self.done = 0
        self.paid_at = np.zeros(self.num_envs)
        self.sums, self.hops = np.zeros(self.num_envs), np.zeros(self.num_envs)
        return self._inputs()

    def step_wait(self):
        rewards, feedback = np.zeros(self.num_envs), np.clip(self.actions, -1.0, 1.0)
        for _ in range(DECISION):
            climbs = self.seen[:, self.at["root_climb"]] > 0.0
            acted = self.pilot.act(self.seen, added=LIMIT * feedback.T.astype(np.float32))
            self.seen, _, _ = self.hoppers.step(acted, np.ones(self.num_envs, bool))
            height, work = self.seen[:, self.at["root_height"]], self.seen[:, self.at["work"]]
            apex = climbs & (self.seen[:, self.at["root_climb"]] <= 0.0) & (height > 1.01)
            spent = work - self.paid_at
            pays = apex & (spent > 1e-6)
            hop = np.where(pays, (height - 1.0) / np.where(pays, spent, 1.0), 0.0)
            rewards += hop
            self.sums += hop
            self.hops += pays
            self.paid_at = np.where(apex, work, self.paid_at)
        self.done += 1
        over = self.done >= self.steps
        if over:
            rewards += self.sums / np.maximum(self.hops, 1.0)
        inputs = self._inputs()
        infos: list[dict[str, Any]] = [{} for _ in range(self.num_envs)]
        if over:
            infos = [
                {"terminal_observation": final, "TimeLimit.truncated": True} for final in inputs
            ]
            inputs = self.reset()
        return inputs, rewards.astype(np.float32), np.full(self.num_envs, over), infos

    def close(self) -> None:
        self.hoppers.close()


Point = tuple[float, float, np.ndarray]
"""Simulated time learned from [s], CoT⁻¹ of the deterministic policy [m/J], its weights."""


def by_pgpe(model: str, seed: int) -> Iterator[Point]:
    """Yield the centre of PGPE's distribution, generation by generation."""
    settings = dataclasses.replace(tuned("pgpe"), population=POPULATION)
    generations = round(TIME_S / (POPULATION * EPISODE_S))
    run = Run(
        experiment=experiment(model),
        seeds=(seed,),
        learner=Evolution(algorithm=settings, stopping=Stopping.after(generations)),
    )
    begun = run.learner.start(run.experiment, run.seeds)
    weights = np.asarray(begun.search.mean[0])
    for number, (progress, curves) in enumerate(
        run.learner.evolve(run.experiment, run.seeds, begun)
    ):
        yield number * POPULATION * EPISODE_S, float(curves.centre_cot_inverse[0]), weights
        weights = np.asarray(progress.search.mean[0])
    yield TIME_S, judged(model, weights), weights


def by_agent(algorithm: str, model: str, seed: int) -> Iterator[Point]:
    """Yield the agent's deterministic policy at intervals."""
    settings, task = tuned(algorithm), experiment(model)
    env = Feedbacks(task, settings.n_envs)
    observed = Observed(("sin_phase", "cos_phase", "spring_force"), {"spring_force": env.weight})
    feedback = Feedback(policy(model), observed, initial_weights(policy(model), seed))
    agent = settings.make(env, feedback, seed)
    torch.set_num_threads(1)
    decision_s = DECISION * task.wires.step_s
    yield 0.0, judged(model, feedback.flat()), feedback.flat()
    for point in range(1, POINTS + 1):
        target = round(point / POINTS * TIME_S / decision_s)
        if target > agent.num_timesteps:
            agent.learn(target - agent.num_timesteps, reset_num_timesteps=False)
        reached = agent.num_timesteps * decision_s
        yield reached, judged(model, feedback.flat()), feedback.flat()
    env.close()


_evaluators: dict[str, Any] = {}


def judged(model: str, weights: np.ndarray) -> float:
    """Return CoT⁻¹ of an undisturbed episode [m/J]."""
    evaluator = _evaluators.setdefault(model, evaluator_of(experiment(model), 0))
    return float(evaluator.evaluate(weights[None, None], Generation.alike()).cot_inverse[0, 0])


def learn(work: Place, models: tuple[str, ...] = MODELS) -> None:
    """Train the missing policies.

    Args:
        work: folder of the trainings.
        models: names of the policies.
    """
    work.mkdir(parents=True, exist_ok=True)
    for seed, model, algorithm in product(SEEDS, models, ALGORITHMS):
        file = work / f"{model}-{algorithm}-{seed}.npz"
        if file.exists():
            continue
        begun = time.process_time()
        pgpe = algorithm == "pgpe"
        source = by_pgpe(model, seed) if pgpe else by_agent(algorithm, model, seed)
        times, values, weights = zip(*source, strict=True)
        spent = time.process_time() - begun
        partial = file.with_suffix(".part.npz")
        np.savez(partial, time_s=times, cot=values, weights=weights, cpu_s=spent)
        partial.rename(file)
        print(f"{file.stem}: {max(values):.3f} m/J, {spent:.0f} s of CPU", flush=True)


# What the learned policies keep of it where nothing is as it was.

CONDITIONS = {
    "as trained": {},
    "mass -20 %": {"mass": 0.8},
    "mass +20 %": {"mass": 1.2},
    "push up": {"push": 1.0},
    "push down": {"push": -1.0},
    "noise 1 %": {"noise": 0.01},
    "noise 5 %": {"noise": 0.05},
    "delay 10 ms": {"delay": 2},
    "delay 20 ms": {"delay": 4},
}
"""Pushes of 1 N over 50 ms, half a metre per second, at 6 s; noise over the weight."""


class Disturbed(ModelLanes):
    """Lanes whose body, senses or peace are not as they were."""

    def __init__(self, settings, lanes, *, mass=1.0, push=0.0, noise=0.0, delay=0) -> None:
        model = sensing(settings).model
        model.body_mass[:] *= mass
        super().__init__(settings, lanes, threads=1, models=[model] * lanes)
        self.push, self.noise, self.delay = push, noise, delay
        self.at = self._sensing.names.index("leg_spring")
        self.rng = np.random.default_rng(0)

    def reset(self, seed, where):
        self.number, self.queue = 0, []
        return super().reset(seed, where)

    def step(self, actions, alive, push_n=None):
        time_s = self.number * self.batch.step_s
        self.number += 1
        if self.push and 6.0 <= time_s < 6.05:
            push_n = np.tile([0.0, 0.0, self.push], (self.lanes, 1))
        observation, reward, over = super().step(actions, alive, push_n)
        load = observation[:, self.at] + self.noise * 0.981 * self.rng.standard_normal(self.lanes)
        self.queue = [*self.queue, load][-(self.delay + 1) :]
        observation[:, self.at] = self.queue[0]
        return observation, reward, over


def robustness(model: str, weights: np.ndarray) -> dict[str, np.ndarray]:
    """Return CoT⁻¹ under each condition, times the weight over the usual one [m/J], [policies]."""
    task, results = experiment(model), {}
    for name, disturbance in CONDITIONS.items():
        lanes = Disturbed(task.spec.model_settings, len(weights), **disturbance)
        pilot = Pilot(task.wires, task.wiring, weights.T)
        record = play(lanes, pilot, task.wires, seed=0)
        # Of another mass the same climb is other work: over the usual weight all compare.
        results[name] = (
            disturbance.get("mass", 1.0) * task.objective.score(record, task.wiring).cot_inverse
        )
        lanes.close()
    return results


def tables(work: Place) -> None:
    """Write the curves, the robustness and the figure."""
    curves: list[dict[str, Any]] = []
    robust: list[dict[str, Any]] = []
    for model in MODELS:
        best, labels = [], []
        for file in sorted(work.glob(f"{model}-*[0-9].npz")):
            algorithm, seed = file.stem.removeprefix(f"{model}-").split("-")
            label = {"model": model, "algorithm": algorithm, "seed": int(seed)}
            with np.load(file) as record:
                for time_s, cot in zip(record["time_s"], record["cot"], strict=True):
                    curves.append({**label, "simulated_s": time_s, "cot_inverse": cot})
                best.append(record["weights"][int(np.argmax(record["cot"]))])
            labels.append(label)
        for name, values in (robustness(model, np.array(best)) if best else {}).items():
            robust += [
                {**label, "condition": name, "cot_inverse": x}
                for label, x in zip(labels, values, strict=True)
            ]
    write_rows(OUT / "curves.csv", curves, digits=5)
    write_rows(OUT / "robustness.csv", robust, digits=5)
    report()


def report() -> None:
    """Write texts and picture from the kept tables."""
    curves, robust = (pd.read_csv(OUT / f"{name}.csv") for name in ("curves", "robustness"))
    write_text(OUT / "learned.md", learned_text(curves))
    write_text(OUT / "apart.md", apart_text(curves))
    write_text(OUT / "robust.md", robust_text(robust))
    picture(curves)


def formatted(values: pd.Series) -> str:
    """Return a mean with its interval."""
    return with_interval(values, within=(0.0, math.inf))


def best_by(curves: pd.DataFrame, time_s: float = math.inf) -> pd.Series:
    """Return the best CoT⁻¹ up to a time [m/J], by model, algorithm and seed."""
    soon = curves[curves["simulated_s"] <= time_s + 1.0]
    return soon.groupby(KEY)["cot_inverse"].max()


def learned_text(curves: pd.DataFrame) -> str:
    """Tabulate the best result of each algorithm after a quarter, a half and all of the time, and
    at the end."""
    parts = {f"by {share * TIME_S:.0f} s": best_by(curves, share * TIME_S) for share in SHARES}
    parts["at the end"] = curves.sort_values("simulated_s").groupby(KEY)["cot_inverse"].last()
    lines = [["policy", "by", "runs", *parts]]
    for model, algorithm in product(MODELS, ALGORITHMS):
        if (model, algorithm) not in parts["at the end"].index:
            continue
        cells = [series[model, algorithm] for series in parts.values()]
        lines.append([model, algorithm.upper(), f"{len(cells[0])}", *map(formatted, cells)])
    return markdown_table(lines)


def apart_text(curves: pd.DataFrame) -> str:
    """Return the differences between algorithms, seed by seed."""
    lines = [["policy", "", "difference of the best [m/J]"]]
    best = best_by(curves)
    for model, (first, second) in product(MODELS, combinations(ALGORITHMS, 2)):
        if (model, first) not in best.index or (model, second) not in best.index:
            continue
        gain = best[model, first] - best[model, second]
        names = f"{first.upper()} - {second.upper()}"
        lines.append([model, names, with_interval(gain, "+.2f")])
    return markdown_table(lines)


def robust_text(robust: pd.DataFrame) -> str:
    """Return CoT⁻¹ under each condition: mean, interval, and the least of the runs."""
    columns = [
        (m, a) for m, a in product(MODELS, ALGORITHMS) if len(rows_of(robust, model=m, algorithm=a))
    ]
    heads = (f"{model.split('-')[2]}, {algorithm.upper()}" for model, algorithm in columns)
    lines = [["", *heads]]
    for name in CONDITIONS:
        cells = [rows_of(robust, model=m, algorithm=a, condition=name) for m, a in columns]
        means = (
            f"{formatted(group['cot_inverse'])}, {group['cot_inverse'].min():.2f}"
            for group in cells
        )
        lines.append([name, *means])
    return markdown_table(lines)


def rows_of(table: pd.DataFrame, **where: str) -> pd.DataFrame:
    """Return the rows in which these cells have these values."""
    return table[np.all([table[name] == value for name, value in where.items()], axis=0)]


def picture(curves: pd.DataFrame) -> None:
    """Draw learning curves: the best so far, one line per seed, and their median."""
    models = [model for model in MODELS if model in set(curves["model"])]
    with styled():
        figure = new_figure(COLUMN_IN * len(models), 2.5)
        for ax, model in zip(
            figure.subplots(1, len(models), squeeze=False)[0], models, strict=True
        ):
            for name, colour in zip(ALGORITHMS, COLOURS, strict=False):
                rows = rows_of(curves, model=model, algorithm=name)
                wide = rows.pivot(index="simulated_s", columns="seed", values="cot_inverse")
                best = wide.sort_index().cummax()
                ax.plot(best.index, best, color=colour, lw=0.5, alpha=0.5)
                ax.plot(best.index, best.median(axis=1), color=colour, lw=2.0, label=name.upper())
            ax.set(xlabel="simulated time [s]", title=model.removesuffix("-w8"))
            ax.set_ylim(bottom=0.0)
            ax.set_ylabel("best CoT$^{-1}$ so far [m/J]")
            ax.legend()
        save_figure(figure, OUT / "curves.png")


if __name__ == "__main__":
    main(learn, tables)
