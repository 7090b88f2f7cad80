"""Saved controllers played again on their environment."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from tegotae._support.errors import TegotaeError
from tegotae.measures.metric import Metric
from tegotae.measures.robots import EnvEpisode, RobotEpisode, episode_numbers
from tegotae.training.environments.experiment import EnvExperiment
from tegotae.training.environments.objectives import Hopping
from tegotae.training.environments.rollouts import EnvRollouts


@dataclass(frozen=True, eq=False)
class Replay:
    """An episode of a controller on its environment."""

    experiment: EnvExperiment
    """Experiment: environment and wiring."""
    episode: RobotEpisode
    """All that was observed, done and paid."""
    seed: int
    """Seed of the reset."""

    @property
    def flies(self) -> bool:
        """True if no limb bears load at some time of the second half, or if loads are unknown."""
        late = len(self.episode.time_s) // 2
        loads = list(self.episode.loads.values())
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

    def numbers(self, metrics: tuple[Metric, ...] | None = None) -> dict[str, float]:
        """Return metrics of the episode by name, without those that the simulator does not show.

        Args:
            metrics: metrics of robots; all by default.
        """
        return episode_numbers(self.episode, metrics)


def replay(
    experiment: EnvExperiment,
    weights: ArrayLike,
    *,
    seed: int | None = None,
) -> list[Replay]:
    """Play an episode of each controller, side by side from the same start.

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
    rollouts = EnvRollouts(experiment, len(table))
    try:
        record = rollouts.record(table, seed)
        if troubles := [trouble for trouble in rollouts.troubles if trouble]:
            raise TegotaeError(f"{experiment.spec.env}: {troubles[0]}")
    finally:
        rollouts.close()
    fitness = np.asarray(experiment.objective.score(record, wiring).fitness)
    return [
        Replay(experiment, _measurable(experiment, record.episode(lane), float(value)), seed)
        for lane, value in enumerate(fitness)
    ]


def _measurable(experiment: EnvExperiment, episode: EnvEpisode, fitness: float) -> RobotEpisode:
    """Return an episode with the robot's data from the wiring."""
    wiring, wires = experiment.wiring, experiment.wires
    loads = {}
    for name in sorted({limb.senses.get("spring_force", "") for limb in wiring.limbs} - {""}):
        sign = 1.0 if name in episode.names else -1.0
        loads[name] = np.maximum(sign * episode[name.removeprefix("-")], 0.0)
    hops = wiring.height is not None and wiring.units is None
    return RobotEpisode(
        **{entry.name: getattr(episode, entry.name) for entry in dataclasses.fields(episode)},
        fitness=fitness,
        step_s=wires.step_s,
        loads=loads,
        force_limits=wires.force_limits,
        work_j=None if wiring.work is None else episode[wiring.work],
        weight_n=wiring.units and wiring.units.force_n,
        height_m=episode[wiring.height] if hops and wiring.height else None,
        rest_length_m=wiring.rest_length_m,
        omega=wiring.omega,
    )


def lasting(experiment: EnvExperiment, duration_s: float | None) -> EnvExperiment:
    """Return the same experiment with episodes of another length, of which the same share is left
    to settle.
    """
    if duration_s is None:
        return experiment
    objective = experiment.objective
    if isinstance(objective, Hopping):
        settle_s = objective.settle_s / experiment.duration_s * duration_s
        objective = dataclasses.replace(objective, settle_s=settle_s)
    return dataclasses.replace(experiment, duration_s=duration_s, objective=objective)
