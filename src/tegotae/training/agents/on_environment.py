"""Limbs on an environment as an agent learns them: episodes side by side, feedback as action."""

from __future__ import annotations

import dataclasses
import warnings
from functools import partial

import numpy as np
from gymnasium.spaces import Box

from tegotae._support.errors import TegotaeError, require_known
from tegotae.envs._types import Info
from tegotae.envs.sb3 import LaneVecEnv
from tegotae.envs.settings import HopReward, feedback_controller
from tegotae.envs.wiring import read_by
from tegotae.envs.wrapper import Pilot
from tegotae.training.agents import AgentSettings, agent_controller
from tegotae.training.agents.actor import AgentTask, Observed
from tegotae.training.environments.evaluator import SampleWarning
from tegotae.training.environments.experiment import EnvExperiment
from tegotae.training.environments.objectives import (
    ENTRY_OF_WORK,
    EpisodeBatch,
    Hopping,
    Return,
)
from tegotae.training.environments.rollouts import EnvRollouts, environment_lanes


def task_on_environment(experiment: EnvExperiment, settings: AgentSettings) -> AgentTask:
    """Return an experiment on an environment as an agent learns it.

    The agent has the experiment's episodes: the same environment, starts and frequencies, of which
    every limb observes its phase and what its controller reads. What it is paid adds up to the
    experiment's objective (`StepReward`). The deterministic policy is judged by that objective over
    the evaluation set, as candidates of a population are.

    Raises:
        TegotaeError: for a controller without a meaning for agents.
    """
    controller, wiring = agent_controller(experiment, settings), experiment.wiring
    step_s, starts = experiment.wires.step_s, experiment.evaluation_starts
    hold = max(1, round(settings.tick_s * settings.decimation / step_s))
    names = ("sin_phase", "cos_phase", *read_by(controller))
    scales = {name: float(scale) for name, scale in wiring.scales.items()}
    rollouts: list[EnvRollouts] = []

    def judge(weights: np.ndarray) -> tuple[float, float]:
        if not rollouts:  # the environments are made when they are needed
            evaluated = dataclasses.replace(experiment, wiring=wiring.reading(controller))
            rollouts.append(EnvRollouts(evaluated, len(starts)))
        trials = rollouts[0].try_out(np.tile(weights, (len(starts), 1)), starts=starts)
        if troubles := [trouble for trouble in trials.troubles if trouble]:
            raise TegotaeError(f"{experiment.spec.env}: {troubles[0]}")
        return float(trials.fitness.mean()), float(trials.cot_inverse.mean())

    observed = Observed(names, scales)
    return AgentTask(
        settings,
        controller,
        observed,
        experiment.duration_s,
        -(-max(1, round(experiment.duration_s / step_s)) // hold),
        partial(LimbVecEnv, experiment, settings, observed, hold),
        judge,
    )


class LimbVecEnv(LaneVecEnv):
    """Episodes side by side whose action is the feedback of the limbs, in shares of its limit.

    Observed is of every limb in turn sin φ, cos φ and its senses over their scales; behind these is
    what critics sense besides. Episodes begin in turn as those of a candidate in a population; a
    lane's rounds draw starts of their own where generations do.

    Args:
        experiment: what is learned.
        settings: how the agent is set.
        observed: what a limb observes.
        hold: control periods for which an action is held.

    Raises:
        TegotaeError: for critics that sense what is not observed.
    """

    def __init__(
        self, experiment: EnvExperiment, settings: AgentSettings, observed: Observed, hold: int
    ) -> None:
        spec, wires, controller = experiment, experiment.wires, experiment.controller
        assert controller.oscillator is not None
        bare = feedback_controller(controller.actuation, controller.oscillator)
        bare = dataclasses.replace(bare, limbs=controller.limbs)
        self._own, self._hold, self._wires = spec, hold, wires
        self._limit = settings.max_feedback_rad_per_s
        lanes = settings.n_envs
        self._lanes = environment_lanes(spec, lanes)
        self._pilot = Pilot(
            dataclasses.replace(wires, controller=bare), spec.wiring, np.zeros((1, lanes))
        )
        self._reward = _step_reward(spec, settings, self._lanes.steps, self._pilot)
        self._scales = {name: float(spec.wiring.scales.get(name, 1.0)) for name in observed.names}
        for name in settings.critic_senses:
            require_known("entry of the observation", name, wires.observed)
        self._besides = [wires.observed.index(name) for name in settings.critic_senses]
        self._actions = np.zeros((lanes, wires.limbs), np.float32)
        self._warned: set[str] = set()
        self.render_mode = None  # Stable-Baselines3 warns of an environment that says nothing
        width = wires.limbs * len(observed.names) + len(self._besides)
        super().__init__(lanes, Box(-np.inf, np.inf, (width,)), Box(-1.0, 1.0, (wires.limbs,)))

    def reset(self) -> np.ndarray:
        """Begin an episode in every lane: the first in the first, the second in the second and so
        on.
        """
        self._episode = np.arange(self.num_envs) % self._own.episodes - 1
        self._begun = np.zeros(self.num_envs, int)
        self._length = np.zeros(self.num_envs, int)
        self._omega = np.zeros(self.num_envs)
        self._begin(np.ones(self.num_envs, bool))
        return self._observations()

    def _begin(self, where: np.ndarray) -> None:
        """Begin the next episode of some lanes."""
        experiment = self._own
        self._episode = np.where(where, (self._episode + 1) % experiment.episodes, self._episode)
        seeds = np.zeros(self.num_envs, np.int64)
        for lane in map(int, np.flatnonzero(where)):
            episode, begun = int(self._episode[lane]), int(self._begun[lane])
            seeds[lane] = experiment.starts(lane, begun // experiment.episodes)[0, episode]
            self._omega[lane] = experiment.wiring_in(episode).omega
        self._begun += where
        self._seen = self._lanes.reset(seeds, where)
        self._check(where)
        self._pilot.restart(where, self._omega)
        self._reward.begin(self._seen, where)
        self._length[where] = 0

    def _check(self, begun: np.ndarray) -> None:
        """Raise `TegotaeError` for an environment that cannot be reset; warn of other troubles."""
        for lane, trouble in enumerate(self._lanes.troubles):
            if not trouble:
                continue
            if begun[lane]:
                raise TegotaeError(f"{self._own.spec.env} cannot begin an episode: {trouble}")
            if trouble not in self._warned:
                self._warned.add(trouble)
                warnings.warn(
                    f"{self._own.spec.env}: {trouble}; the episode ends there, the training "
                    "continues",
                    SampleWarning,
                    stacklevel=2,
                )

    def _observations(self) -> np.ndarray:
        """Return the observations, [lanes, columns], limb by limb."""
        phase, observation = self._pilot.phase, self._seen
        columns = [np.sin(phase), np.cos(phase)]
        senses = self._wires.sensed
        columns += [self._wires.felt(name, observation) / self._scales[name] for name in senses]
        of_limbs = np.stack(columns, axis=-1)  # [limbs, lanes, columns]
        rows = np.swapaxes(of_limbs, 0, 1).reshape(self.num_envs, -1)
        return np.concatenate([rows, observation[:, self._besides]], axis=1).astype(np.float32)

    def step_async(self, actions: np.ndarray) -> None:
        """Take the actions, [lanes, limbs], for the step to come."""
        self._actions = np.clip(np.asarray(actions, np.float32), -1.0, 1.0)

    def step_wait(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, list[Info]]:
        """Hold the feedback for its control periods, and begin new episodes where one ended."""
        n = self.num_envs
        rewards, going, cut = np.zeros(n), np.ones(n, bool), np.zeros(n, bool)
        for _ in range(self._hold):
            acted = self._pilot.act(self._seen, added=self._limit * self._actions.T)
            observation, paid, over = self._lanes.step(acted, going)
            observation = np.nan_to_num(observation, posinf=0.0, neginf=0.0)
            self._seen = np.where(going[:, None], observation, self._seen)
            self._length += going
            paid = np.where(going, paid, 0.0)
            rewards += self._reward.of_step(self._seen, acted, paid, going)
            late = self._length >= self._lanes.steps
            cut |= going & (self._lanes.truncated | (late & ~over))
            going &= ~(over | late)
            if not going.any():
                break
        over = ~going
        rewards += self._reward.at_the_end(over)
        columns = self._observations()
        infos: list[Info] = [{} for _ in range(n)]
        if over.any():
            for lane in np.flatnonzero(over).tolist():
                infos[lane] = {
                    "terminal_observation": columns[lane],
                    "TimeLimit.truncated": bool(cut[lane]),
                }
            self._check(np.zeros(n, bool))
            self._begin(over)
            columns = self._observations()
        return columns, rewards.astype(np.float32), over, infos

    def close(self) -> None:
        """Close the environments."""
        self._lanes.close()


class StepReward:
    """Rewards of an agent: the environment's own, whose sum is the return."""

    def begin(self, observation: np.ndarray, where: np.ndarray) -> None:
        """Begin new episodes of some lanes.

        Args:
            observation: what is observed at their start, [lanes, entries].
            where: which lanes, [lanes].
        """

    def of_step(
        self, observation: np.ndarray, action: np.ndarray, paid: np.ndarray, alive: np.ndarray
    ) -> np.ndarray:
        """Return the rewards of a step of the environment, [lanes].

        Args:
            observation: what is observed after it, [lanes, entries].
            action: what was done, [lanes, entries].
            paid: the environment's own rewards, [lanes].
            alive: whose episode goes on or ends with this step, [lanes]; others stand still.
        """
        return paid

    def at_the_end(self, over: np.ndarray) -> np.ndarray:
        """Return the final rewards of lanes whose episode is over, [lanes]; 0 elsewhere."""
        return np.zeros(len(over))


_CLEARS = 1.01
"""Height of an apex over the rest length from which a flight is a hop."""


class PerHop(StepReward):
    """The paper's: CoT⁻¹ of each hop at its apex, and their mean at the end (`HopReward`).

    Args:
        experiment: whose wiring names height and work.
        lanes: how many.
        reward: which hops are paid.
    """

    def __init__(self, experiment: EnvExperiment, lanes: int, reward: HopReward) -> None:
        wiring, names = experiment.wiring, experiment.wires.observed
        work = getattr(wiring, ENTRY_OF_WORK[reward.work])
        assert wiring.height is not None
        assert wiring.rest_length_m is not None
        self._height, self._work = names.index(wiring.height), names.index(work)
        self._rest_m, self._reward = float(wiring.rest_length_m), reward
        self._was, self._spent_at = np.zeros(lanes), np.zeros(lanes)
        self._rises = np.zeros(lanes, bool)
        self._sum, self._hops = np.zeros(lanes), np.zeros(lanes)

    def begin(self, observation: np.ndarray, where: np.ndarray) -> None:
        self._was = np.where(where, observation[:, self._height], self._was)
        self._spent_at = np.where(where, observation[:, self._work], self._spent_at)
        self._rises = self._rises & ~where
        self._sum, self._hops = (np.where(where, 0.0, x) for x in (self._sum, self._hops))

    def of_step(
        self, observation: np.ndarray, action: np.ndarray, paid: np.ndarray, alive: np.ndarray
    ) -> np.ndarray:
        height, work = observation[:, self._height], observation[:, self._work]
        rises = height > self._was
        apex = alive & self._rises & ~rises & (self._was > _CLEARS * self._rest_m)
        climb = self._was - self._rest_m
        self._was, self._rises = height, rises
        if not apex.any():
            return np.zeros(len(apex))
        value, counts = map(
            np.asarray,
            self._reward.of_hop(climb_m=climb, work_j=work - self._spent_at, lost_j=0.0),
        )
        rewarded = apex & counts
        reward = np.where(rewarded, value, 0.0)
        self._spent_at = np.where(apex, work, self._spent_at)
        self._sum, self._hops = self._sum + reward, self._hops + rewarded
        return reward

    def at_the_end(self, over: np.ndarray) -> np.ndarray:
        return np.where(over, self._sum / np.maximum(self._hops, 1.0), 0.0)


class OnceAtTheEnd(StepReward):
    """The fitness of the episode, at its end: for a function of your own.

    Args:
        experiment: by whose objective.
        lanes: how many.
        steps: of the longest episode.
        pilot: whose phases the episode has.
    """

    def __init__(self, experiment: EnvExperiment, lanes: int, steps: int, pilot: Pilot) -> None:
        self._experiment, self._pilot, wires = experiment, pilot, experiment.wires
        self._record = EpisodeBatch(
            wires.step_s,
            wires.observed,
            observation=np.zeros((steps, lanes, len(wires.observed))),
            action=np.zeros((steps, lanes, len(wires.low))),
            reward=np.zeros((steps, lanes)),
            phase_rad=np.zeros((steps, wires.limbs, lanes), np.float32),
            ended=np.zeros(lanes, int),
            steps=steps,
            sound=np.zeros(lanes, bool),
            completed=np.zeros(lanes, bool),
        )

    def begin(self, observation: np.ndarray, where: np.ndarray) -> None:
        self._record.ended[where] = 0

    def of_step(
        self, observation: np.ndarray, action: np.ndarray, paid: np.ndarray, alive: np.ndarray
    ) -> np.ndarray:
        record, lanes = self._record, np.flatnonzero(alive)
        steps = record.ended[lanes]
        record.observation[steps, lanes], record.action[steps, lanes] = (
            observation[lanes],
            action[lanes],
        )
        record.reward[steps, lanes] = paid[lanes]
        record.phase_rad[steps, :, lanes] = self._pilot.phase.T[lanes]
        record.ended[lanes] += 1
        return np.zeros(len(paid))

    def at_the_end(self, over: np.ndarray) -> np.ndarray:
        record = dataclasses.replace(self._record, sound=over & (self._record.ended > 0))
        if not record.sound.any():
            return np.zeros(len(over))
        fitness = self._experiment.objective.score(record, self._experiment.wiring).fitness
        return np.where(record.sound & np.isfinite(fitness), fitness, 0.0)


def _step_reward(
    experiment: EnvExperiment, settings: AgentSettings, steps: int, pilot: Pilot
) -> StepReward:
    """Return the rewards of an agent's lanes, for an experiment's objective.

    Args:
        experiment: what is learned.
        settings: how the agent is set.
        steps: of the longest episode.
        pilot: whose phases an episode has.

    Raises:
        TegotaeError: for stored energy, which environments do not observe.
    """
    if settings.charge_stored:
        raise TegotaeError(
            "charge_stored needs the body's energy, which environments do not observe; leave it out"
        )
    objective = experiment.objective
    if isinstance(objective, Return):
        return StepReward()
    if isinstance(objective, Hopping):
        reward = HopReward(work=objective.work, least_work_j=settings.least_work_j)
        return PerHop(experiment, settings.n_envs, reward)
    return OnceAtTheEnd(experiment, settings.n_envs, steps, pilot)
