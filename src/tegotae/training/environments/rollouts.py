"""Where candidates are tried: weights in, episodes played, a score for each."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from tegotae.envs.pilot import Pilot
from tegotae.envs.wires import Wires
from tegotae.envs.wiring import Wiring
from tegotae.measures.objectives.objective import FAILED_FITNESS
from tegotae.training.environments.episode import EpisodeBatch
from tegotae.training.environments.lanes import Beat, GymLanes, Lanes, ModelLanes, Seeds
from tegotae.training.environments.objectives import EnvObjective, Scores

if TYPE_CHECKING:
    from tegotae.training.environments.experiment import EnvExperiment


class Trials(NamedTuple):
    """What came of candidates; one entry each."""

    fitness: np.ndarray
    cot_inverse: np.ndarray
    failed: np.ndarray
    troubles: list[str | None]


class EnvRollouts:
    """Plays candidates of an experiment, `lanes` at a time.

    Args:
        experiment: what is trained.
        lanes: how many candidates are tried side by side.
        beat: called with the lane whose environment is at work, to detect a hang.

    Raises:
        TegotaeError: for an environment that cannot be made or wired so.
    """

    def __init__(
        self, experiment: EnvExperiment, lanes: int, beat: Beat = lambda lane: None
    ) -> None:
        self._experiment = experiment
        self._wires = experiment.wires
        self.lanes = lanes
        self._played = lanes_of(experiment, lanes, beat)

    def try_out(
        self,
        weights: np.ndarray,
        alive: np.ndarray | None = None,
        starts: np.ndarray | None = None,
    ) -> Trials:
        """Scores of candidates.

        Args:
            weights: [candidates, n_weights], at most `lanes` of them.
            alive: which of them to try; all by default. Others have no result.
            starts: seeds of the resets, [candidates, episodes]; those of the first set by default.
        """
        wanted = len(weights)
        padded = np.repeat(weights[-1:], self.lanes, axis=0)
        padded[:wanted] = weights
        tried = np.zeros(self.lanes, bool)
        tried[:wanted] = True if alive is None else alive
        found: list[Scores] = []
        troubles: list[str | None] = [None] * self.lanes
        experiment = self._experiment
        if starts is None:
            starts = np.tile(experiment.evaluation_starts[:1], (wanted, 1))
        seeds = np.concatenate([starts, np.repeat(starts[-1:], self.lanes - wanted, axis=0)])
        for episode in range(experiment.episodes):
            wiring = experiment.wiring_in(episode)
            pilot = Pilot(self._wires, wiring, padded.T)
            record = play(
                self._played,
                pilot,
                self._wires,
                experiment.objective,
                wiring,
                seed=seeds[:, episode],
                tried=tried,
            )
            found.append(experiment.objective.score(record, wiring))
            own = self._played.troubles
            troubles = [one or other for one, other in zip(troubles, own, strict=True)]
        bad = np.array([trouble is not None for trouble in troubles])
        fitness, cot_inverse, failed = (np.stack(each) for each in zip(*found, strict=True))
        unjudged = ~np.isfinite(fitness).all(axis=0)
        for lane in map(int, np.flatnonzero(unjudged & tried)):
            troubles[lane] = troubles[lane] or "its fitness was not finite"
        bad |= unjudged
        # A sample that went wrong is worse than any that did not, and says nothing else.
        return Trials(
            np.where(bad, FAILED_FITNESS, fitness.mean(axis=0))[:wanted],
            np.where(bad, np.nan, cot_inverse.mean(axis=0))[:wanted],
            (bad | failed.any(axis=0))[:wanted],
            troubles[:wanted],
        )

    def close(self) -> None:
        """Close the environments."""
        self._played.close()


def lanes_of(experiment: EnvExperiment, lanes: int, beat: Beat = lambda lane: None) -> Lanes:
    """The lanes of an experiment's environment."""
    if experiment.spec.is_model:
        settings = replace(experiment.spec.model_settings, duration_s=experiment.duration_s)
        return ModelLanes(settings, lanes)
    steps = max(1, round(experiment.duration_s / experiment.wires.step_s))
    bodies = experiment.wiring.contact_bodies
    return GymLanes(experiment.spec.make, lanes, steps, bodies, beat)


def play(
    lanes: Lanes,
    pilot: Pilot,
    wires: Wires,
    objective: EnvObjective,
    wiring: Wiring,
    *,
    seed: Seeds,
    tried: np.ndarray,
) -> EpisodeBatch:
    """One episode of every lane that is tried.

    Args:
        lanes: where.
        pilot: who drives.
        wires: names and step of the environment.
        objective: which says what is to be kept.
        wiring: the wiring.
        seed: of the reset: one for all lanes, or one a lane, [lanes].
        tried: which lanes, [lanes].
    """
    kept = objective.entries(wiring, wires.observed)
    at = [wires.observed.index(name) for name in kept]
    steps, n = lanes.steps, lanes.lanes
    whole = objective.whole
    observation = np.zeros((steps, n, len(at)), np.float32)
    action = np.zeros((steps if whole else 0, n, len(wires.low)), np.float32)
    phase = np.zeros((steps if whole else 0, wires.limbs, n), np.float32)
    reward = np.zeros((steps, n))
    alive = tried.copy()
    seen = lanes.reset(seed, alive)
    alive &= np.array([trouble is None for trouble in lanes.troubles])
    pilot.reset()
    ended = np.zeros(n, int)
    for step in range(steps):
        if not alive.any():
            # What ended stands still.
            observation[step:] = seen[:, at]
            break
        acted = pilot.act(seen)
        observed, paid, over = lanes.step(acted, alive)
        seen = np.where(alive[:, None], np.nan_to_num(observed, posinf=0.0, neginf=0.0), seen)
        observation[step] = seen[:, at]
        reward[step] = np.where(alive, paid, 0.0)
        if whole:
            action[step], phase[step] = acted, pilot.phase
        ended += alive
        alive &= ~over
    sound = (ended > 0) & np.array([trouble is None for trouble in lanes.troubles])
    return EpisodeBatch(wires.step_s, kept, observation, action, reward, phase, ended, steps, sound)
