"""Learning by agents: from random weights, a point of the learning curve now and then."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from typing import Any

import jax.numpy as jnp
import numpy as np

# First, for it says which extra is missing.
from tegotae.training.agents.actor import AgentTask, Feedback, Observed  # isort: split

import torch
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.vec_env import VecNormalize

from tegotae._support.errors import TegotaeError
from tegotae.envs.sb3 import HopperVecEnv
from tegotae.envs.settings import HopReward, TegotaeHopperSettings
from tegotae.measures.hopping.signals import WORK
from tegotae.simulation.rollout import Rollout, Scenario
from tegotae.systems.experiment import Experiment
from tegotae.training.agents import AgentSettings, agent_controller
from tegotae.training.learner import CurvePoint, initial_weights


def agent_task(experiment: Any, settings: AgentSettings) -> AgentTask:
    """Return an experiment as an agent learns it.

    On the engine the deterministic policy is judged by the experiment's objective without ΔΩ, in an
    undisturbed episode; its control period is the experiment's, that of the learning is the
    settings'.

    Raises:
        TegotaeError: for a controller without a meaning for agents.
    """
    if experiment.task is not None:
        from tegotae.training.agents.on_environment import task_on_environment

        return task_on_environment(experiment, settings)
    body, omega = experiment.body, experiment.omega
    controller = agent_controller(experiment, settings)
    objective = experiment.objective.without_frequency()
    rollout = Rollout(controller=controller, timing=experiment.timing, summary=objective)
    scenario = Scenario.at_frequency(omega, height_m=experiment.system.release.height_m)
    hoppers = hopper_settings(experiment, settings)
    scales = body.sense(body.release(jnp.ones(()), jnp.zeros(())), jnp.zeros(())).scales

    def judge(weights: np.ndarray) -> tuple[float, float]:
        outcome = rollout.run(weights, scenario, body)
        return float(outcome["fitness"][0]), float(outcome["cot_inverse"][0])

    return AgentTask(
        settings,
        controller,
        Observed(hoppers.observed, {name: float(scale) for name, scale in scales.items()}),
        experiment.duration_s,
        hoppers.n_steps,
        partial(HopperVecEnv, hoppers, settings.n_envs),
        judge,
    )


def hopper_settings(experiment: Experiment, settings: AgentSettings) -> TegotaeHopperSettings:
    """Return the environment in which an agent learns an experiment of the engine."""
    controller = agent_controller(experiment, settings)
    assert controller.oscillator is not None
    assert experiment.omega is not None
    read = [name for term in controller.terms.values() for name in term.reads]
    senses = [name for name in experiment.body.SENSES if name in read]
    senses += [name for name in settings.critic_senses if name not in senses]
    return TegotaeHopperSettings(
        body=experiment.body,
        tick_s=settings.tick_s,
        decimation=settings.decimation,
        duration_s=experiment.duration_s,
        height_m=experiment.system.release.height_m,
        observation=("phase", *senses),
        omega=experiment.omega,
        actuation=controller.actuation,
        oscillator=controller.oscillator,
        max_feedback_rad_per_s=settings.max_feedback_rad_per_s,
        reward=HopReward(
            work=getattr(experiment.objective, "work", WORK[0]),
            least_work_j=settings.least_work_j,
            charge_stored=settings.charge_stored,
        ),
    )


class DivergedError(TegotaeError):
    """The learning led to weights that are no numbers."""


def make_agent(
    task: AgentTask, *, seed: int, weights: np.ndarray | None = None
) -> tuple[BaseAlgorithm, Feedback]:
    """Make the Stable-Baselines3 agent, untrained, and return it with the part that is the policy.

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
) -> Iterator[tuple[CurvePoint, np.ndarray]]:
    """Learn from random weights; the same seed gives the same points.

    The step of a point is the simulated time learned from, in whole episodes: one that failed early
    counts in part.

    Args:
        task: what and how.
        seed: of the weights and of all that is drawn.
        episodes: how long, in simulated time of so many whole episodes. Agents that update
            between such times end a little later.
        evaluate_every: episodes between points, or the next update after so many.

    Yields:
        the policy before training, then one point after the other: its place in the learning curve
        and its weights, [n_weights].

    Raises:
        DivergedError: if the learning leads to weights that are no numbers.
    """
    agent, feedback = make_agent(task, seed=seed)
    per_episode = task.actions_per_episode
    try:
        while True:
            weights, episode = feedback.flat(), agent.num_timesteps / per_episode
            point = CurvePoint(seed, episode, episode * task.duration_s, *task.judge(weights))
            yield point, weights
            finished = agent.num_timesteps // per_episode
            if finished >= episodes:
                return
            target = min(episodes, finished - finished % evaluate_every + evaluate_every)
            with _on_one_thread(feedback, seed, finished):
                agent.learn(target * per_episode - agent.num_timesteps, reset_num_timesteps=False)
    finally:
        if agent.env is not None:
            agent.env.close()


@contextmanager
def _on_one_thread(feedback: Feedback, seed: int, episodes: int) -> Iterator[None]:
    """Compute on one thread, since such small networks lose by sharing; detect weights that are
    no numbers.
    """
    threads = torch.get_num_threads()
    torch.set_num_threads(1)
    try:
        yield
    except ValueError:  # torch's and the environment's for actions that are no numbers
        if np.isfinite(feedback.flat()).all():
            raise
    finally:
        torch.set_num_threads(threads)
    if not np.isfinite(feedback.flat()).all():
        raise DivergedError(
            f"seed {seed} diverged after {episodes} episodes: its weights are not finite any more; "
            "a smaller learning_rate or normalize_reward may help"
        )
