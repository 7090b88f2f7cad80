"""Evaluate vanilla feedback, learned laws and agents on Go1 under conditions that no training
had."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from stable_baselines3 import PPO

from go1_agents import Body, by_agent
from go1_plan import (
    AGENTS,
    BEST,
    CONDITIONS,
    JUDGED_S,
    LAWS,
    OMEGAS,
    OUT,
    OWN_STRIDE,
    RUNS,
    SPEC,
    STARTS,
    UNSEEN,
    Outcome,
    Trial,
    best_at,
    best_stride,
    by_law,
    experiment,
    learned,
    sigma_of,
    tried,
    vanilla_law,
)
from kept import write_rows
from tegotae.envs.mujoco.sensing import sensing
from tegotae.systems.controller_file import load


def trials(law: int, *omegas: float) -> Iterator[tuple[str, Trial]]:
    """Generate the trials that evaluate a law, with the condition's name; at some frequencies
    alone."""
    for name, (every, change) in CONDITIONS.items():
        for omega in every:
            if omegas and omega not in omegas:
                continue
            for k, start in enumerate(STARTS):
                changes = {n: x * (-1) ** k if n == "push" else x for n, x in change.items()}
                yield name, Trial(law, omega, start, **changes)


def rows_of(
    law: str, seed: int | str, trials_by_condition: list[tuple[str, Trial]], results: Outcome
) -> Iterator[dict[str, Any]]:
    """A row for each condition and frequency, means over the starts."""
    cells = [(name, trial.omega) for name, trial in trials_by_condition]
    for condition, omega in dict.fromkeys(cells):
        matches = np.array([cell == (condition, omega) for cell in cells])
        yield {
            "law": law,
            "seed": seed,
            "condition": condition,
            "omega": omega,
            "return_per_s": float(results.paid[matches].mean()),
            "speed_m_per_s": float(results.speed_m_per_s[matches].mean()),
            "cost_of_transport": results.cost_of_transport(matches),
            "fell": float(results.fell[matches].mean()),
            "fell_early": float(results.fell_early[matches].mean()),
        }


def of_vanilla() -> Iterator[dict[str, Any]]:
    """The best at each frequency, and with the stride that is best over all."""
    common = best_stride()
    for name in (BEST, OWN_STRIDE):
        for omega in sorted(OMEGAS + UNSEEN):
            stride, sigma = best_at(omega) if name == BEST else (common, sigma_of(common, omega))
            task, pairs = experiment("vanilla", vanilla_law(), stride), list(trials(0, omega))
            drives = by_law(task, np.array([[sigma]]))
            yield from rows_of(name, "", pairs, tried([t for _, t in pairs], drives, JUDGED_S))


def of_law(name: str) -> Iterator[dict[str, Any]]:
    """A law that was learned by PGPE, every seed."""
    for file in sorted((RUNS / name).glob("*/*-seed*.json")):
        saved, pairs = load(file), list(trials(0))
        drives = by_law(learned(name), np.asarray(saved.weights)[None])
        results = tried([trial for _, trial in pairs], drives, JUDGED_S)
        yield from rows_of(name, int(str(saved.training["seed"])), pairs, results)


def of_agent(name: str) -> Iterator[dict[str, Any]]:
    """An agent, every seed."""
    body = Body(sensing(SPEC.model_settings), AGENTS[name])
    for file in sorted((RUNS / name).glob("seed?.zip")):
        pairs = list(trials(0))
        drives = by_agent(PPO.load(file, device="cpu"), body)
        results = tried([trial for _, trial in pairs], drives, JUDGED_S)
        yield from rows_of(name, int(file.stem.removeprefix("seed")), pairs, results)


def judge(*names: str) -> None:
    """Evaluate all or the named controllers; rows of the others remain."""
    evaluations = {"vanilla": of_vanilla}
    evaluations |= {name: lambda name=name: of_law(name) for name in LAWS}
    evaluations |= {name: lambda name=name: of_agent(name) for name in AGENTS}
    for name in names or evaluations:
        rows = list(evaluations[name]())
        write_rows(OUT / "go1_judged.csv", rows, digits=5, by=("law",))
        print(name, len(rows), "rows", flush=True)
