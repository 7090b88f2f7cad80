"""Episodes of an environment, candidate by candidate."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import Any, NamedTuple, Protocol

import numpy as np

from tegotae._support.errors import formatted, require
from tegotae.envs._types import AnyEnv, Observation, Seeds
from tegotae.envs.contact import flat_observation, with_contact
from tegotae.envs.mujoco.env import ModelLanes
from tegotae.envs.wires import Wires
from tegotae.envs.wiring import Wiring
from tegotae.envs.wrapper import Pilot
from tegotae.measures.objectives.objective import FAILED_FITNESS, Scores
from tegotae.training.environments.experiment import EnvExperiment
from tegotae.training.environments.objectives import EpisodeBatch

Beat = Callable[[int], None]
"""Called with the lane that takes a step before it, and with -1 after: this shows a hang."""


class GymLanes:
    """Environments of any kind, each stepped in turn; one that fails ends its own lane alone.

    Args:
        make: makes an environment.
        lanes: how many.
        steps: of the longest episode.
        contact_bodies: bodies whose contact forces are observed (`MujocoContactForce`).
        beat: called before and after each step.
    """

    def __init__(
        self,
        make: Callable[[], AnyEnv],
        lanes: int,
        steps: int,
        contact_bodies: Sequence[str] = (),
        beat: Beat = lambda lane: None,
    ) -> None:
        self.lanes, self.steps, self._beat = lanes, steps, beat
        self._make = lambda: with_contact(make(), contact_bodies)
        self._envs: list[Any] = [self._make()]
        self._space, action = self._envs[0].observation_space, self._envs[0].action_space
        self._low, self._high, self._dtype = action.low, action.high, action.dtype
        self._entries = require("gymnasium", "gym").spaces.flatdim(self._space)
        self.troubles = [""] * lanes
        self.truncated = np.zeros(lanes, bool)
        self._seen = np.zeros((lanes, self._entries))
        self._done = np.zeros(lanes, int)

    def reset(self, seed: Seeds, where: np.ndarray) -> np.ndarray:
        """Begin a new episode of some lanes; return the observations of all, [lanes, entries].

        Args:
            seed: of the starts: lanes of the same seed have the same one.
            where: which lanes, [lanes]; the others stay as they are.
        """
        seeds = np.broadcast_to(np.asarray(seed), (self.lanes,))
        while len(self._envs) < self.lanes:
            self._envs.append(self._make())
        for lane in map(int, np.flatnonzero(where)):
            self.troubles[lane], self._done[lane] = "", 0
            begin = partial(self._envs[lane].reset, seed=int(seeds[lane]))
            begun = self._guarded(lane, lambda begin=begin: begin()[0])
            self._seen[lane] = 0.0 if begun is None else begun
        return self._seen.copy()

    def step(
        self, actions: np.ndarray, alive: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Advance every living lane by a step; the others stand still.

        Args:
            actions: [lanes, entries].
            alive: whose episode goes on, [lanes].

        Returns:
            observations [lanes, entries], rewards and whether an episode is over, [lanes].
        """
        self._done += 1
        self.truncated = np.zeros(self.lanes, bool)
        rewards, over = np.zeros(self.lanes), np.zeros(self.lanes, bool)
        for lane in map(int, np.flatnonzero(alive)):
            action = np.clip(actions[lane], self._low, self._high).astype(self._dtype)

            def once(lane: int = lane, action: np.ndarray = action) -> Observation:
                observation, reward, ends, cut, _ = self._envs[lane].step(action)
                if not np.isfinite(reward):
                    raise _Trouble(f"its reward was {reward}")
                rewards[lane], over[lane] = reward, bool(ends) or bool(cut)
                self.truncated[lane] = bool(cut) and not bool(ends)
                return observation

            result = self._guarded(lane, once)
            if result is None:
                rewards[lane], over[lane] = 0.0, True
                continue
            self._seen[lane] = result
            if over[lane] and self._done[lane] == 1:
                self.troubles[lane] = "it ended at its first step"
        return self._seen.copy(), rewards, over

    def _guarded(self, lane: int, act: Callable[[], Observation]) -> np.ndarray | None:
        """Return the observation after an action, or None and the error after a failure."""
        self._beat(lane)
        try:
            observation = np.asarray(flat_observation(self._space, act()), float)
            shape = (self._entries,)
            if observation.shape != shape:
                raise _Trouble(
                    f"its observation has shape {observation.shape}; its space said {shape}"
                )
            if not np.isfinite(observation).all():
                raise _Trouble("its observation was not finite")
            return observation
        except _Trouble as trouble:
            self.troubles[lane] = str(trouble)
        except (Exception, SystemExit) as error:  # anything may go wrong in somebody else's program
            self.troubles[lane] = f"it raised {formatted(error)}"
            # What raised may be in any state; the next episode begins in a new one.
            self._envs[lane] = self._make()
        finally:
            self._beat(-1)
        return None

    def close(self) -> None:
        """Close the environments."""
        for env in self._envs:
            env.close()


class _Trouble(Exception):  # noqa: N818 - never seen outside
    """An environment violated its contract."""


class Lanes(Protocol):
    """Episodes that are stepped together, in any simulator.

    A lane that cannot go on has a trouble, a plain sentence, and is not stepped again until its
    reset.
    """

    lanes: int
    """Number of episodes."""
    steps: int
    """Steps of the longest episode."""
    troubles: list[str]
    """Trouble of each lane; empty without one."""
    truncated: np.ndarray
    """True where the last step ended an episode by its time alone, [lanes]."""

    def reset(self, seed: Seeds, where: np.ndarray) -> np.ndarray:
        """Begin a new episode of some lanes; return the observations of all, [lanes, entries]."""
        ...

    def step(
        self, actions: np.ndarray, alive: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Step the lanes that are alive; return observations, rewards, and which are over."""
        ...

    def close(self) -> None:
        """Release its resources."""
        ...


class LanePilot(Protocol):
    """Driver of lanes that are stepped together, such as a `Pilot`."""

    @property
    def phase(self) -> np.ndarray:
        """Phases of oscillators [rad], [limbs, lanes]."""
        ...

    def reset(self) -> None:
        """Begin an episode."""
        ...

    def act(self, observed: np.ndarray) -> np.ndarray:
        """Return the actions for observations [lanes, entries], [lanes, actions]."""
        ...


class Trials(NamedTuple):
    """Results of candidates, [candidates] each."""

    fitness: np.ndarray
    cot_inverse: np.ndarray
    failed: np.ndarray
    troubles: np.ndarray
    """Errors, a sentence each; empty where there was none."""

    @classmethod
    def joined(cls, parts: Sequence[Trials]) -> Trials:
        """Join several of them to one."""
        return cls(*map(np.concatenate, zip(*parts, strict=True)))


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
        self._experiment, self.lanes = experiment, lanes
        self._played = environment_lanes(experiment, lanes, beat)

    def try_out(
        self,
        weights: np.ndarray,
        starts: np.ndarray | None = None,
        troubles: Sequence[str] | None = None,
    ) -> Trials:
        """Evaluate candidates.

        Args:
            weights: [candidates, n_weights].
            starts: seeds of the resets, [candidates, episodes]; those of the first set by default.
            troubles: of candidates that are not to be tried again, and count as failed.
        """
        experiment, count = self._experiment, len(weights)
        if starts is None:
            starts = np.tile(experiment.evaluation_starts[:1], (count, 1))
        if count > self.lanes:
            blocks = [slice(i, i + self.lanes) for i in range(0, count, self.lanes)]
            return Trials.joined([self.try_out(weights[x], starts[x]) for x in blocks])
        # Always as many lanes, so that arithmetic is the same; spare ones are not played.
        rows = np.minimum(np.arange(self.lanes), count - 1)
        wrong = np.full(self.lanes, "", object)
        wrong[:count] = troubles or ""
        tried = (np.arange(self.lanes) < count) & (wrong == "")
        scores: list[Scores] = []
        for episode in range(experiment.episodes):
            wiring = experiment.wiring_in(episode)
            record = self.record(
                weights[rows],
                starts[rows, episode],
                wiring=wiring,
                tried=tried,
                entries=experiment.objective.entries(wiring),
            )
            scores.append(experiment.objective.score(record, wiring))
            current = np.array(self.troubles, object)
            wrong = np.where(tried & (wrong == ""), current, wrong)
        fitness, cot_inverse, failed = (np.stack(column) for column in zip(*scores, strict=True))
        unjudged = tried & (wrong == "") & ~np.isfinite(fitness).all(axis=0)
        wrong[unjudged] = "its fitness was not finite"
        bad = wrong != ""
        # A sample that went wrong is worse than any that did not, and says nothing else.
        trials = Trials(
            np.where(bad, FAILED_FITNESS, fitness.mean(axis=0)),
            np.where(bad, np.nan, cot_inverse.mean(axis=0)),
            bad | failed.any(axis=0),
            wrong,
        )
        return Trials(*(column[:count] for column in trials))

    @property
    def troubles(self) -> list[str]:
        """Trouble of each lane in the last episode; empty without one."""
        return self._played.troubles

    def record(
        self,
        weights: np.ndarray,
        seed: Seeds,
        *,
        wiring: Wiring | None = None,
        tried: np.ndarray | None = None,
        entries: tuple[str, ...] | None = None,
    ) -> EpisodeBatch:
        """Play and record an episode of every lane.

        Args:
            weights: [lanes, n_weights].
            seed: of the reset: one for all lanes, or one a lane, [lanes].
            wiring: of the limbs, with their frequency; the experiment's by default.
            tried: which lanes are played, [lanes]; all by default.
            entries: of the observation, which are kept; by default all, with actions and phases.
        """
        wires = self._experiment.wires
        pilot = Pilot(wires, self._experiment.wiring if wiring is None else wiring, weights.T)
        return play(self._played, pilot, wires, seed=seed, tried=tried, entries=entries)

    def close(self) -> None:
        """Close the environments."""
        self._played.close()


def environment_lanes(
    experiment: EnvExperiment, lanes: int, beat: Beat = lambda lane: None
) -> Lanes:
    """Return the lanes of an experiment's environment."""
    if experiment.spec.is_model:
        settings = replace(experiment.spec.model_settings, duration_s=experiment.duration_s)
        return ModelLanes(settings, lanes)
    steps = max(1, round(experiment.duration_s / experiment.wires.step_s))
    bodies = experiment.wiring.contact_bodies
    return GymLanes(experiment.spec.make, lanes, steps, bodies, beat)


def play(
    lanes: Lanes,
    pilot: LanePilot,
    wires: Wires,
    *,
    seed: Seeds,
    tried: np.ndarray | None = None,
    entries: tuple[str, ...] | None = None,
) -> EpisodeBatch:
    """Play one episode of every evaluated lane.

    Args:
        lanes: where.
        pilot: who drives.
        wires: names and step of the environment.
        seed: of the reset: one for all lanes, or one a lane, [lanes].
        tried: which lanes, [lanes]; all by default.
        entries: of the observation, which are kept; by default all, with actions and phases.
    """
    names = wires.observed if entries is None else entries
    indices = [wires.observed.index(name) for name in names]
    steps, n = lanes.steps, lanes.lanes
    frames = steps if entries is None else 0
    observation = np.zeros((steps, n, len(indices)), np.float32)
    action = np.zeros((frames, n, len(wires.low)), np.float32)
    phase = np.zeros((frames, wires.limbs, n), np.float32)
    reward = np.zeros((steps, n))
    alive = np.ones(n, bool) if tried is None else tried.copy()
    state = lanes.reset(seed, alive)
    alive &= np.array([not trouble for trouble in lanes.troubles])
    pilot.reset()
    ended, cut = np.zeros(n, int), np.zeros(n, bool)
    for step in range(steps):
        if not alive.any():
            # What ended stands still.
            observation[step:] = state[:, indices]
            break
        acted = pilot.act(state)
        observed, paid, over = lanes.step(acted, alive)
        finite = np.where(np.isfinite(observed), observed, 0.0)
        state = np.where(alive[:, None], finite, state)
        observation[step] = state[:, indices]
        reward[step] = np.where(alive, paid, 0.0)
        if frames:
            action[step], phase[step] = acted, pilot.phase
        ended += alive
        cut |= alive & over & lanes.truncated
        alive &= ~over
    sound = (ended > 0) & np.array([not trouble for trouble in lanes.troubles])
    return EpisodeBatch(
        wires.step_s, names, observation, action, reward, phase, ended, steps, sound, cut | alive
    )
