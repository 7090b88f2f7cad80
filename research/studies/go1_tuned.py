"""Laws on Go1's feet, tuned under disturbances: a clock, a load, a learned feedback, each balanced.

    python research/studies/go1_tuned.py                         # half an hour of one core
    python research/studies/go1_tuned.py --law load --seed 1
    python research/studies/go1_tuned.py --law AR-b              # the walker's weights, and balance
    python research/studies/go1_tuned.py --law clock-s --pace walk
    python research/studies/go1_tuned.py --law load-p --pace speed

CMA-ES from the walker's ellipse without balance. A candidate's score is the share of its lanes that
do not fall, less 0.3 |v / v* - 1| and 0.05 CoT, over pushes, blocks and any phases at three
commands, from starts of its generation. `docs/_static/go1_feet` keeps the mean of the
distribution, `LAW-tuned-SEED.json`, and the scores of every generation, `.csv`. A tuning goes on
where it was stopped. The wanted speed v* is that of a candidate's stride, which may shrink; with
`--pace walk` it is PPO's for all, and with `run` twice that, for laws that already walk; with
`speed` speeds are the commands, 0.3 to 2.5 m/s, CoT counts twice, and a score is less 0.3 |ψ|, of
the heading at the end, up to 1 rad; with `further` a run of that goes on, and CoT counts four
times. Such laws are `LAW-walk-SEED.json` and so on.
"""

from __future__ import annotations

import dataclasses
import pickle
import sys
from dataclasses import dataclass
from typing import Any, Literal

import jax
import jax.numpy as jnp
import numpy as np
import tyro

from go1_feet import FOLDER, ROOT, SETTINGS, WIRING, Condition, by_law, judged
from go1_laws import BALANCE, ELLIPSE, open_loop, pace_of
from go1_policy import BEGUN, WANTED_M
from kept import write_rows
from tegotae._support.errors import TegotaeError
from tegotae._support.files import output_folder, write_atomically
from tegotae.cli.console import exit_status
from tegotae.envs.env_spec import EnvSpec
from tegotae.envs.wiring import Wiring, load_wiring
from tegotae.parts.terms import BalancedFoot, TunedFoot
from tegotae.systems.controller_file import SavedController, save
from tegotae.systems.designs import design
from tegotae.systems.resolve import resolve
from tegotae.training.algorithms import CMAES
from tegotae.training.environments.experiment import EnvExperiment

OMEGAS = (10.0, 16.0, 24.0)
SECONDS = 8.0
MET = (
    Condition(push_m_per_s=1.0),
    Condition(blocks_m=0.04),
    Condition(random_phases=True, delay_s=0.02),
)
"""Conditions that every candidate is evaluated under; a push is to the left in all, and the law is
mirrored."""
ALSO_MET = {"further": (Condition(blocks_m=0.02),)}
"""Further conditions of the candidates of a pace."""
STD = 0.08
"""Initial standard deviation of the candidates; half of it with the pace `further`."""
Kind = Literal[
    "clock",
    "clock-t",
    "load",
    "AR-b",
    "clock-s",
    "load-s",
    "clock-p",
    "load-p",
    "clock-alone",
    "wary",
]
Pace = Literal["tuned", "walk", "run", "speed", "further"]
BEFORE = {"run": "walk", "further": "speed"}
"""Paces that go on from the run of another."""
FROZEN = {"clock-alone": BALANCE, "wary": ("sigma", "higher")}
"""Numbers of a law that a tuning leaves as they are."""
WANTED = {"walk": WANTED_M, "run": 2.0 * WANTED_M}
"""Wanted speed over ω [m]; that of `tuned` is of a candidate's own stride."""
SLOWEST, FASTEST = 5.0, 50.0
"""No law is commanded to step slower or faster [rad/s]."""
SPEEDS = (0.3, 1.3, 2.5)
"""The commands of the pace `speed` [m/s]."""
PRICES = {"speed": (0.1, 0.3), "further": (0.2, 0.3)}
"""Weights of CoT and of a heading error of 1 rad in the fitness, where speeds are the commands."""
AT_FREQUENCIES = (0.05, 0.0)
"""The same weights where frequencies are the commands."""


@dataclass(frozen=True)
class Tuned:
    """Tune one law."""

    law: Kind = "clock"
    """`clock`; `clock-t`, its ellipse alone; `load` with a place, an offset and σ; `AR-b`, the
    walker's learned one. The others balance; with `-s` they step aside, and with `-p` the stride
    is of the frequency, as that of `clock-alone`, which does not balance, and of `wary`, which is
    alarmed by a tilt."""
    seed: int = 0
    """Seed of the search and of its starts."""
    generations: int = 25
    """Generations of CMA-ES."""
    population: int = 12
    """Candidates of each."""
    pace: Pace = "tuned"
    """Wanted speed."""

    def run(self) -> None:
        """Tune, and write the law."""
        kind, wiring = f"{self.law}-{self.pace}", start_of(self.law)
        further = self.pace == "further"
        if self.law == "wary" and not further:
            raise TegotaeError(f"--law wary goes on from its run, --pace further; not {self.pace}")
        if self.pace in BEFORE:
            previous = FOLDER / f"{self.law}-{BEFORE[self.pace]}-{self.seed}.json"
            weights = np.ravel(resolve(str(previous)).controller().weights)
            wiring = dataclasses.replace(wiring, weights=weights)
        name = f"{kind}-{self.seed}"
        begun, std = np.asarray(wiring.weights), STD / 2 if further else STD
        algorithm = CMAES(population=self.population, std=std)
        assert wiring.controller is not None
        names = [path[-1] for path in wiring.controller.weight_names]
        free = ~np.isin(names, FROZEN.get(self.law, ()))
        search, parameters = algorithm.strategy(len(begun)), algorithm.parameters(len(begun))
        state = algorithm.start(jax.random.key(self.seed), jnp.asarray(begun, "float32"))
        rows: list[dict[str, Any]] = []
        stopped = output_folder(ROOT / "runs" / "go1_tuned") / f"{name}.pickle"
        if stopped.exists():
            rows, leaves = pickle.loads(stopped.read_bytes())
            state = jax.tree.unflatten(jax.tree.structure(state), leaves)
        for generation in range(len(rows), self.generations):
            keys = jax.random.split(jax.random.fold_in(jax.random.key(self.seed), generation))
            candidates, state = search.ask(keys[0], state, parameters)
            start = 10_000 * (1 + self.seed) + 100 * further + generation
            tried = np.where(free, np.asarray(candidates, float), begun)
            scores = scored(wiring, tried, start, self.pace)
            state, _ = search.tell(keys[1], candidates, jnp.asarray(-scores), state, parameters)
            mean = np.where(free, np.asarray(search.get_mean(state), float), begun)
            rows.append({"generation": generation, "mean": scores.mean(), "best": scores.max()})
            print(f"{name}: {generation}, {scores.mean():.3f}, {scores.max():.3f}", flush=True)
            leaves = [np.asarray(leaf) for leaf in jax.tree.leaves(state)]
            write_atomically(stopped, pickle.dumps((rows, leaves)))
            write_rows(FOLDER / f"{name}.csv", rows, digits=4)
            keep(wiring, mean, kind, self.seed)


def start_of(law: Kind) -> Wiring:
    """A law before its tuning: the walker's ellipse at a stride of 0.25 l0 without balance."""
    clock, wiring = open_loop(0.25), load_wiring(WIRING)
    begun = {"stride_m": 0.25}
    if law == "AR-b":
        learned = resolve("zoo:AR-rF+range@quadruped-c").controller()
        controller = dataclasses.replace(learned.controller, actuation=BalancedFoot())
        feedback = np.ravel(learned.weights)
    else:
        name = {"clock": "clock-b", "load": "load-b", "clock-alone": "clock-p"}.get(law, law)
        controller = design(f"{name}@quadruped-c").controller()
        begun = BEGUN if name.endswith("-p") else begun
        feedback = np.zeros(controller.n_weights - controller.actuation.n_weights)
    numbers = {**dict(zip(TunedFoot.WEIGHTS, ELLIPSE, strict=False)), **begun}
    foot = [numbers.get(path[-1], 0.0) for path in controller.actuation.weight_names]
    weights = np.concatenate([feedback, foot])
    readings = wiring.reading(controller)
    return dataclasses.replace(
        wiring.holding(clock), controller=controller, limbs=readings.limbs, weights=weights
    )


def scored(wiring: Wiring, candidates: np.ndarray, start: int, pace: Pace) -> np.ndarray:
    """Return the fitness of every candidate, [candidates]."""
    at_speeds, (price, off_course) = pace in PRICES, PRICES.get(pace, AT_FREQUENCIES)
    commands = SPEEDS if at_speeds else OMEGAS
    weights = np.repeat(candidates, len(commands), axis=0)
    wirings = [dataclasses.replace(wiring, weights=x) for x in weights]
    omegas = target = np.tile(commands, len(candidates))
    if at_speeds:
        paces = map(pace_of, wirings)
        omegas = np.array([p.omega_at(v) for p, v in zip(paces, target, strict=True)])
        omegas = np.clip(omegas, SLOWEST, FASTEST)
    elif pace == "tuned":
        paces = map(pace_of, wirings)
        target = np.array([p.wanted_m_per_s(x) for p, x in zip(paces, omegas, strict=True)])
    else:
        target = WANTED[pace] * omegas
    laws, total = by_law(wiring, weights), np.zeros(len(weights))
    met = (*MET, *ALSO_MET.get(pace, ()))
    for condition in met:
        results = judged(laws, omegas, [start] * len(weights), condition, SECONDS)
        off = np.minimum(np.abs(np.nan_to_num(results.speed_m_per_s) / target - 1.0), 1.0)
        cost = np.minimum(np.nan_to_num(results.cost_of_transport, nan=8.0), 8.0)
        astray = np.minimum(np.abs(np.nan_to_num(results.heading_rad, nan=1.0)), 1.0)
        total += ~results.fell - 0.3 * off - price * cost - off_course * astray
    return total.reshape(-1, len(commands)).mean(axis=1) / len(met)


def keep(wiring: Wiring, weights: np.ndarray, name: str, seed: int) -> None:
    """Write the law with its robot."""
    save(on_robot(wiring, weights, name, {"seed": seed}), FOLDER / f"{name}-{seed}.json")


def on_robot(
    wiring: Wiring, weights: np.ndarray, name: str, training: dict[str, Any]
) -> SavedController:
    """The law with its robot, as its file has it."""
    settings = {
        field.name: getattr(SETTINGS, field.name)
        for field in dataclasses.fields(SETTINGS)
        if getattr(SETTINGS, field.name) != field.default and field.name != "model"
    }
    experiment = EnvExperiment(
        name=name,
        spec=EnvSpec(env=str(SETTINGS.model), settings=tuple(settings.items())),
        wiring=dataclasses.replace(wiring, weights=None),
    )
    system, task = experiment.system, experiment.task
    return SavedController(system, weights, name=name, task=task, training=training)


if __name__ == "__main__":
    sys.exit(exit_status(lambda: tyro.cli(Tuned, description=__doc__).run()))
