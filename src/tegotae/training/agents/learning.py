"""Learning by agents: from random weights, a point of the learning curve now and then."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple, Protocol

import jax.numpy as jnp
import numpy as np

from tegotae._support.errors import TegotaeError, require, require_count
from tegotae.measures.hopping.signals import WORK
from tegotae.measures.objectives.objective import Objective
from tegotae.parts.bodies import Body
from tegotae.parts.controller import Controller
from tegotae.simulation.rollout import Engine, Scenario, Timing
from tegotae.systems.experiment import Experiment
from tegotae.training.agents.actor import Feedback, Observed
from tegotae.training.agents.settings import AgentSettings, agent_controller, initial_weights

require("stable_baselines3", "sb3")  # before the environments ask for Gymnasium, which it installs

import torch  # noqa: E402
from stable_baselines3.common.base_class import BaseAlgorithm  # noqa: E402
from stable_baselines3.common.vec_env import VecEnv, VecNormalize  # noqa: E402

from tegotae.envs.sb3 import HopperVecEnv  # noqa: E402
from tegotae.envs.settings import HopReward, TegotaeHopperSettings  # noqa: E402


class AgentTask(Protocol):
    """What an agent learns in, and how its policy is judged: the hopper, or an environment."""

    @property
    def settings(self) -> AgentSettings:
        """The algorithm and how it is set."""
        ...

    @property
    def controller(self) -> Controller:
        """The policy, with a limit to its feedback (`agent_controller`)."""
        ...

    @property
    def actions_per_episode(self) -> int:
        """Actions in a whole episode."""
        ...

    @property
    def duration_s(self) -> float:
        """Length of an episode [s]."""
        ...

    @property
    def observed(self) -> Observed:
        """What the columns of an observation are, of one limb."""
        ...

    def make_env(self) -> VecEnv:
        """The episodes side by side in which the agent acts: its action is the feedback."""
        ...

    def judge(self, weights: np.ndarray) -> tuple[float, float]:
        """CoT⁻¹ [m/J] and fitness of the deterministic policy with these weights [n_weights]."""
        ...


@dataclass(frozen=True)
class AgentTraining:
    """An experiment as an agent learns it, by some settings.

    The deterministic policy is evaluated by the experiment's objective without ΔΩ, in episodes of
    the engine; their control period is the experiment's, that of the learning is the settings'.

    Args:
        experiment: what is learned.
        settings: the algorithm and how it is set.

    Raises:
        TegotaeError: for a controller without a meaning for agents.
    """

    experiment: Experiment
    settings: AgentSettings

    def __post_init__(self) -> None:
        _ = self.controller

    @property
    def controller(self) -> Controller:
        """The policy, with a limit to its feedback (`agent_controller`)."""
        return agent_controller(self.experiment, self.settings)

    @property
    def hopper(self) -> Body:
        """The body."""
        return self.experiment.body

    @property
    def timing(self) -> Timing:
        """An episode."""
        return self.experiment.timing

    @property
    def fitness(self) -> Objective:
        """The measure of the deterministic policy."""
        return self.experiment.objective.without_frequency()

    @property
    def release_m(self) -> float:
        """Height of the release [m], at rest."""
        return self.experiment.system.release.height_m

    @property
    def environment(self) -> TegotaeHopperSettings:
        """The settings of the environment that the agent acts in."""
        settings, tegotae = self.settings, self.controller.tegotae
        oscillator = self.controller.oscillator
        assert oscillator is not None
        assert tegotae is not None
        assert tegotae.limit_rad_per_s is not None
        read = [name for term in self.controller.terms.values() for name in term.reads]
        senses = [name for name in self.hopper.SENSES if name in read]
        senses += [name for name in settings.critic_senses if name not in senses]
        return TegotaeHopperSettings(
            body=self.hopper,
            tick_s=settings.tick_s,
            decimation=settings.decimation,
            duration_s=self.timing.duration_s,
            height_m=self.release_m,
            observation=("phase", *senses),
            omega=self.scenario.omega,
            actuation=self.controller.actuation,
            oscillator=oscillator,
            max_feedback_rad_per_s=tegotae.limit_rad_per_s,
            reward=HopReward(
                work=self.work,
                least_work_j=settings.least_work_j,
                charge_stored=settings.charge_stored,
            ),
        )

    @property
    def scenario(self) -> Scenario:
        """An episode on which the policy is evaluated."""
        return Scenario.of(self.experiment.omega, height_m=self.release_m)

    @property
    def work(self) -> str:
        """The definition of work in the reward: the fitness's, if it has one."""
        return getattr(self.fitness, "work", WORK[0])

    @cached_property
    def engine(self) -> Engine:
        """The engine that evaluates a policy."""
        return Engine(controller=self.controller, timing=self.timing, summary=self.fitness)

    @property
    def actions_per_episode(self) -> int:
        """Actions in a whole episode."""
        return self.environment.n_steps

    @property
    def duration_s(self) -> float:
        """Length of an episode [s]."""
        return self.timing.duration_s

    @property
    def observed(self) -> Observed:
        """What the columns of an observation are."""
        at_rest = self.hopper.release(jnp.ones(()), jnp.zeros(()))
        scales = self.hopper.sense(at_rest, jnp.zeros(())).scales
        named = {name: float(scale) for name, scale in scales.items()}
        return Observed(self.environment.observed, named)

    def make_env(self) -> VecEnv:
        """The hoppers."""
        return HopperVecEnv(self.environment, self.settings.n_envs)

    def judge(self, weights: np.ndarray) -> tuple[float, float]:
        """CoT⁻¹ of an undisturbed episode on the engine [m/J], and its fitness."""
        outcome = self.engine.run(weights, self.scenario, self.hopper)
        return float(outcome["cot_inverse"][0]), float(outcome["fitness"][0])


class DivergedError(TegotaeError):
    """The learning led to weights that are no numbers."""


class Point(NamedTuple):
    """A point of a learning curve: the deterministic policy, evaluated."""

    episode: float
    """Simulated time learned from, in whole episodes: one that failed early counts in part."""
    simulated_s: float
    """Simulated time learned from [s]."""
    cot_inverse: float
    """CoT⁻¹ of an undisturbed episode [m/J]."""
    fitness: float
    """Its fitness."""
    weights: np.ndarray
    """The policy's weights, shape [n_weights]."""


def make_agent(
    task: AgentTask, *, seed: int, weights: np.ndarray | None = None
) -> tuple[BaseAlgorithm, Feedback]:
    """The Stable-Baselines3 agent, not yet trained, and the part of it that is the policy.

    Args:
        task: what and how.
        seed: of the weights and of all that is drawn.
        weights: of the policy, shape [n_weights]; `initial_weights` of the seed by default.
    """
    if weights is None:
        weights = initial_weights(task.controller, seed)
    settings = task.settings
    feedback = Feedback(task.controller, task.observed, weights)
    env = task.make_env()
    if settings.normalize_reward:
        env = VecNormalize(env, norm_obs=False, norm_reward=True, gamma=settings.gamma)
    return settings.make(env, feedback, seed), feedback


def learn(
    task: AgentTask, *, seed: int, episodes: int, evaluate_every: int = 10
) -> Iterator[Point]:
    """Learn from random weights; the same seed gives the same points.

    Args:
        task: what and how.
        seed: of the weights and of all that is drawn.
        episodes: how long, in simulated time of so many whole episodes. Agents that update
            between such times end a little later.
        evaluate_every: episodes between points, or the next update after so many.

    Yields:
        the policy before training, then one point after the other.

    Raises:
        TegotaeError: for a count that is none.
        DivergedError: if the learning leads to weights that are no numbers.
    """
    require_count("seed", seed, least=0)
    require_count("episodes", episodes)
    require_count("evaluate_every", evaluate_every)
    agent, feedback = make_agent(task, seed=seed)
    per_episode = task.actions_per_episode
    try:
        while True:
            yield _point(task, feedback.flat(), agent.num_timesteps / per_episode)
            done = agent.num_timesteps // per_episode
            if done >= episodes:
                return
            target = min(episodes, done - done % evaluate_every + evaluate_every)
            with _one_thread(), _noticing_divergence(feedback, seed, done):
                agent.learn(target * per_episode - agent.num_timesteps, reset_num_timesteps=False)
    finally:
        if agent.env is not None:
            agent.env.close()


def _point(task: AgentTask, weights: np.ndarray, episode: float) -> Point:
    cot_inverse, fitness = task.judge(weights)
    return Point(episode, episode * task.duration_s, cot_inverse, fitness, weights)


@contextmanager
def _one_thread() -> Iterator[None]:
    """torch on one thread: networks as small as these lose by sharing."""
    threads = torch.get_num_threads()
    torch.set_num_threads(1)
    try:
        yield
    finally:
        torch.set_num_threads(threads)


@contextmanager
def _noticing_divergence(feedback: Feedback, seed: int, done: int) -> Iterator[None]:
    """Weights that are no numbers any more, named as what they mean."""
    try:
        yield
    except ValueError:  # torch's and the environment's for actions that are no numbers
        if np.isfinite(feedback.flat()).all():
            raise
    if not np.isfinite(feedback.flat()).all():
        raise DivergedError(
            f"seed {seed} diverged after {done} episodes: its weights are not finite any more; a "
            "smaller learning_rate or normalize_reward may help"
        )
