"""Episodes of an environment, candidate by candidate."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from tegotae._support.errors import formatted, require
from tegotae.envs._types import AnyEnv, MjModel, Observation
from tegotae.envs.contact import flat, with_contact
from tegotae.envs.mujoco.env import ModelBatch
from tegotae.envs.mujoco.sensing import is_sound
from tegotae.envs.mujoco.settings import Fate, ModelSettings
from tegotae.envs.pilot import Pilot
from tegotae.envs.wires import Wires
from tegotae.envs.wiring import Wiring
from tegotae.measures.objectives.objective import FAILED_FITNESS
from tegotae.training.environments.objectives import EnvObjective, EpisodeBatch, Scores

if TYPE_CHECKING:
    from tegotae.training.environments.experiment import EnvExperiment


Beat = Callable[[int], None]
"""Called with the lane that takes a step before it, and with -1 after: this shows a hang."""
Seeds = int | np.ndarray
"""Of the starts of episodes: one for all lanes, or one a lane, [lanes]."""


class Lanes(ABC):
    """So many episodes that are stepped together.

    A lane that cannot go on has a trouble: a plain sentence. It is not stepped again.
    """

    lanes: int
    steps: int
    """Steps of the longest episode."""
    troubles: list[str | None]
    """Of each lane, since the reset."""
    truncated: np.ndarray
    """Whether the last step ended an episode by its time alone, [lanes]."""

    @abstractmethod
    def reset(self, seed: Seeds, alive: np.ndarray) -> np.ndarray:
        """Begin the episodes of the lanes that are alive; what is observed, [lanes, entries]."""

    @abstractmethod
    def restart(self, seed: Seeds, where: np.ndarray) -> np.ndarray:
        """Begin a new episode of some lanes alone; what all observe, [lanes, entries]."""

    @abstractmethod
    def step(
        self, actions: np.ndarray, alive: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Observations [lanes, entries], rewards and whether an episode is over, [lanes]."""

    @abstractmethod
    def close(self) -> None:
        """Give back what they hold."""


class GymLanes(Lanes):
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
        self._space = self._envs[0].observation_space
        self._low, self._high = self._envs[0].action_space.low, self._envs[0].action_space.high
        self._dtype = self._envs[0].action_space.dtype
        self.troubles = [None] * lanes
        self.truncated = np.zeros(lanes, bool)
        self._entries = require("gymnasium", "gym").spaces.flatdim(self._space)
        self._seen = np.zeros((lanes, self._entries))

    def reset(self, seed: Seeds, alive: np.ndarray) -> np.ndarray:
        """Begin the episodes of the lanes that are alive."""
        self.troubles = [None] * self.lanes
        self._seen = np.zeros((self.lanes, self._entries))
        self._done = np.zeros(self.lanes, int)
        return self.restart(seed, alive)

    def restart(self, seed: Seeds, where: np.ndarray) -> np.ndarray:
        """Begin a new episode of some lanes alone."""
        seeds = np.broadcast_to(seed, (self.lanes,))
        while len(self._envs) < self.lanes:
            self._envs.append(self._make())
        for lane in map(int, np.flatnonzero(where)):
            self.troubles[lane], self._done[lane] = None, 0
            own = int(seeds[lane])
            begun = self._guarded(
                lane, lambda lane=lane, own=own: self._envs[lane].reset(seed=own)[0]
            )
            self._seen[lane] = 0.0 if begun is None else begun
        return self._seen.copy()

    def step(
        self, actions: np.ndarray, alive: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Every lane that is alive one step on."""
        self._done += 1
        self.truncated = np.zeros(self.lanes, bool)
        rewards, over = np.zeros(self.lanes), np.zeros(self.lanes, bool)
        for lane in map(int, np.flatnonzero(alive)):
            outcome: dict[str, Any] = {}

            def once(lane: int = lane, outcome: dict[str, Any] = outcome) -> Observation:
                action = np.clip(actions[lane], self._low, self._high).astype(self._dtype)
                seen, outcome["reward"], ends, cut, _ = self._envs[lane].step(action)
                outcome["over"] = bool(ends) or bool(cut)
                self.truncated[lane] = bool(cut) and not bool(ends)
                if not np.isfinite(outcome["reward"]):
                    raise _Trouble(f"its reward was {outcome['reward']}")
                return seen

            seen = self._guarded(lane, once)
            if seen is None:
                over[lane] = True
                continue
            self._seen[lane], rewards[lane], over[lane] = seen, outcome["reward"], outcome["over"]
            if over[lane] and self._done[lane] == 1:
                self.troubles[lane] = "it ended at its first step"
        return self._seen.copy(), rewards, over

    def _guarded(self, lane: int, act: Callable[[], Observation]) -> np.ndarray | None:
        """The observation after an action; None, and the trouble, after a failure."""
        self._beat(lane)
        try:
            seen = np.asarray(flat(self._space, act()), float)
            shape = (self._entries,)
            if seen.shape != shape:
                raise _Trouble(f"its observation has shape {seen.shape}; its space said {shape}")
            if not np.isfinite(seen).all():
                raise _Trouble("its observation was not finite")
            return seen
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
    """What an environment did that it must not."""


class ModelLanes(Lanes):
    """Lanes of a MuJoCo model: its physics in threads, rewards and ends as `ModelEnv` has them.

    Args:
        settings: of the model.
        lanes: how many.
        threads: how many threads step them; one a core by default.
        models: other models of the same shape, one a lane.
    """

    def __init__(
        self,
        settings: ModelSettings,
        lanes: int,
        *,
        threads: int | None = None,
        models: Sequence[MjModel] | None = None,
    ) -> None:
        self._settings, self.lanes = settings, lanes
        self._sensing = settings.sensed
        self.batch = ModelBatch(
            self._sensing, lanes, settings.control_s, threads=threads, models=models
        )
        self._fate = Fate(settings, self._sensing, self.batch.step_s)
        self.steps = self._fate.steps
        self.troubles = [None] * lanes
        self.truncated = np.zeros(lanes, bool)
        self._seen = np.zeros((lanes, 0))

    def reset(self, seed: Seeds, alive: np.ndarray) -> np.ndarray:
        """Begin all episodes; lanes of the same seed have the same start."""
        self._seen = self.batch.reset(self._settings.release_m, self._noise(seed))
        self._fate.begin(self._seen)
        self.troubles = [None] * self.lanes
        return self._whole(self._seen)

    def _noise(self, seed: Seeds) -> np.ndarray | None:
        """What is added to the positions of the start, [lanes, nv]."""
        own, nv = self._settings.noise, self._sensing.model.nv
        if not own:
            return None
        seeds, lane_of = np.unique(np.broadcast_to(seed, (self.lanes,)), return_inverse=True)
        drawn = [np.random.default_rng(int(each)).standard_normal(nv) for each in seeds]
        return own * np.stack(drawn)[lane_of]

    def restart(self, seed: Seeds, where: np.ndarray) -> np.ndarray:
        """Begin a new episode of some lanes alone."""
        self._seen = self.batch.reset(self._settings.release_m, self._noise(seed), where)
        self._fate.begin(self._seen, where)
        self.troubles = [None if w else t for w, t in zip(where, self.troubles, strict=True)]
        return self._whole(self._seen)

    def step(
        self, actions: np.ndarray, alive: np.ndarray, push_n: np.ndarray | None = None
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Every lane that is alive one step on; the others stand still.

        Args:
            actions: commands, [lanes, actuators].
            alive: whose episode goes on, [lanes].
            push_n: an external force on the first body [N], [lanes, 3]; none by default.
        """
        seen = self.batch.step(actions, push_n, alive)
        self._seen = seen
        reward, fallen, over = self._fate.after(seen, self.batch.work_j)
        self.truncated = over & ~fallen
        sound = is_sound(seen).all(axis=1)
        for lane in np.flatnonzero(alive & ~sound):
            self.troubles[lane] = "its state was not finite"
        return self._whole(seen), np.where(sound, reward, 0.0), fallen | over

    def _whole(self, seen: np.ndarray) -> np.ndarray:
        return np.concatenate([seen, self.batch.work_j[:, None]], axis=1)

    def close(self) -> None:
        """End the threads."""
        self.batch.close()


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
