"""Saved controllers played again on their environment, and what is measured of their episodes."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from tegotae._support.errors import TegotaeError
from tegotae.envs.wrapper import Pilot
from tegotae.measures.hopping.gait import Measured, measure
from tegotae.training.environments.experiment import EnvExperiment
from tegotae.training.environments.objectives import EnvEpisode, Hopping
from tegotae.training.environments.rollouts import environment_lanes, play

_LONGEST_STEP_S = 0.02
"""Between samples of a height whose hops can be measured."""
HOPPING = ("cot_inverse", "limit_cycle_period", "w_peak", "t0_s")
"""Metrics of hopping that a replay has, where the wiring says what height and rest length are."""


@dataclass(frozen=True, eq=False)
class Replay:
    """An episode of a controller on its environment."""

    experiment: EnvExperiment
    """Experiment: environment and wiring."""
    episode: EnvEpisode
    """All that was observed, done and paid."""
    fitness: float
    """Fitness by the objective of the experiment."""
    seed: int
    """Seed of the reset."""

    @property
    def loads(self) -> dict[str, np.ndarray]:
        """Observations that represent the load of the limbs, by the entry's name, [steps] each."""
        names = {limb.senses.get("spring_force", "") for limb in self.experiment.wiring.limbs}
        loads = {}
        for name in sorted(filter(None, names)):
            sign = 1.0 if name in self.episode.names else -1.0
            loads[name] = np.maximum(sign * self.episode[name.removeprefix("-")], 0.0)
        return loads

    @property
    def flies(self) -> bool:
        """True if no limb bears load at some time of the second half, or if loads are unknown."""
        late = len(self.episode.time_s) // 2
        loads = list(self.loads.values())
        return not loads or bool((np.max(loads, axis=0)[late:] <= 0.0).any())

    def why_on_ground(self) -> str:
        """Return the reason why a body that is to hop never leaves the ground, after "it"; empty if
        it does.

        A body of several feet is to hop if its fitness is of hopping.
        """
        wiring = self.experiment.wiring
        to_hop = isinstance(self.experiment.objective, Hopping) or len(wiring.contact_bodies) == 1
        if self.flies or not to_hop:
            return ""
        return (
            "never leaves the ground; tegotae wiring baseline shows at which gain and frequency it "
            "hops"
        )

    def measured(self) -> Measured | None:
        """The gait as that of a recording; None where height, rest length or hops are not known.

        It is none on a robot's legs, which walk.
        """
        wiring, episode = self.experiment.wiring, self.episode
        if wiring.height is None or wiring.rest_length_m is None or wiring.units is not None:
            return None
        if self.experiment.wires.step_s > _LONGEST_STEP_S:
            return None
        try:
            return measure(
                episode.time_s - episode.time_s[0],
                episode[wiring.height].astype(float),
                rest_length_m=wiring.rest_length_m,
                phase_rad=episode.phase_rad[:, 0].astype(float),
                omega=wiring.omega,
                work_j=None if wiring.work is None else episode[wiring.work].astype(float),
            )
        except TegotaeError:  # an episode that ended at once is no recording
            return None

    def numbers(self) -> dict[str, float]:
        """Numbers of the gait, in SI units; what is not known is left out or NaN.

        `duty` is the share of the second half in which a foot bears load, `stride_hz` the rate of
        the first limb's oscillator there. Distance is along the heading where that is observed, and
        `cost_of_transport` is work over the wiring's weight and distance.
        """
        episode = self.episode
        numbers = {
            "fitness": self.fitness,
            "return": float(episode.reward.sum()),
            "lasted": episode.lasted,
        }
        if "root_speed" in episode.names:
            numbers["distance_m"] = float(np.trapezoid(episode["root_speed"], episode.time_s))
        elif "root_forward" in episode.names:
            went = episode["root_forward"]
            numbers["distance_m"] = float(went[-1] - went[0])
        if "distance_m" in numbers:
            numbers["speed_m_per_s"] = numbers["distance_m"] / float(episode.time_s[-1])
        wiring = self.experiment.wiring
        if wiring.work is not None:
            numbers["work_j"] = float(episode[wiring.work][-1])
        if numbers.get("distance_m", 0.0) > 0.0 and wiring.work and wiring.units:
            carried = wiring.units.force_n * numbers["distance_m"]
            numbers["cost_of_transport"] = numbers["work_j"] / carried
        late = len(episode.time_s) // 2
        turned = np.unwrap(episode.phase_rad[late:, 0].astype(float))
        span = self.experiment.wires.step_s * max(1, len(turned) - 1)
        numbers["stride_hz"] = float(turned[-1] - turned[0]) / (2.0 * math.pi * span)
        if self.loads:
            numbers["duty"] = float(np.mean([(x[late:] > 0.0).mean() for x in self.loads.values()]))
        if (gait := self.measured()) is not None:
            numbers |= {name: float(getattr(gait, name)) for name in HOPPING}
            hops = np.asarray(gait.hops.height_m)
            numbers["hops"] = float(len(hops))
            numbers["apex_m"] = float(hops[len(hops) // 2 :].mean()) if len(hops) else math.nan
        return numbers


def replay(
    experiment: EnvExperiment,
    weights: ArrayLike,
    *,
    seed: int | None = None,
) -> list[Replay]:
    """Play an episode of each of some controllers, side by side from the same start.

    Args:
        experiment: where and how they were trained (`EnvExperiment.from_controller`).
        weights: [controllers, n_weights].
        seed: of the reset; the experiment's by default.

    Raises:
        TegotaeError: for an environment that cannot be made or wired so, or that fails.

    Example:
        >>> from tegotae.systems.controller_file import load
        >>> from tegotae.training.environments.experiment import EnvExperiment
        >>> saved = load("leg.json")  # doctest: +SKIP
        >>> experiment = EnvExperiment.from_controller(saved)  # doctest: +SKIP
        >>> replay(experiment, [saved.weights])[0].numbers()  # doctest: +SKIP
    """
    seed = experiment.seed if seed is None else seed
    table, wiring = np.asarray(weights, np.float32), experiment.wiring
    lanes = environment_lanes(experiment, len(table))
    try:
        pilot = Pilot(experiment.wires, wiring, table.T)
        record = play(lanes, pilot, experiment.wires, seed=seed)
        if troubles := [trouble for trouble in lanes.troubles if trouble]:
            raise TegotaeError(f"{experiment.spec.env}: {troubles[0]}")
    finally:
        lanes.close()
    fitness = np.asarray(experiment.objective.score(record, wiring).fitness)
    return [
        Replay(experiment, record.episode(lane), float(fitness[lane]), seed)
        for lane in range(len(table))
    ]


def lasting(experiment: EnvExperiment, duration_s: float | None) -> EnvExperiment:
    """The same in episodes of another length, of which the same share is left to settle."""
    if duration_s is None:
        return experiment
    objective = experiment.objective
    if isinstance(objective, Hopping):
        settle_s = objective.settle_s / experiment.duration_s * duration_s
        objective = dataclasses.replace(objective, settle_s=settle_s)
    return dataclasses.replace(experiment, duration_s=duration_s, objective=objective)
