"""PPO on Go1: a network of Stable-Baselines3 that commands the joints itself."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import torch
from gymnasium.spaces import Box
from stable_baselines3 import PPO
from stable_baselines3.common.vec_env import VecEnv

from go1_plan import (
    CONTROL_S,
    FEET,
    LOAD_N,
    MIDDLE,
    OMEGAS,
    SELECTION,
    SPEC,
    TRAINED_S,
    WIDEST,
    Driver,
    Trial,
    tried,
)
from tegotae.envs.mujoco.sensing import Sensing
from tegotae.training.environments.rollouts import ModelLanes

LANES = 24
"""Episodes side by side, eight at each frequency."""
SETTINGS: dict[str, Any] = {
    "n_steps": 100,
    "batch_size": 240,
    "n_epochs": 10,
    "policy_kwargs": {"log_std_init": -1.0},
}
"""Settings that differ from Stable-Baselines3's defaults."""
UPDATES = 8
"""Updates between two evaluations: twice a generation's simulated time."""


class Body:
    """Observation and action spaces of a network on Go1.

    Args:
        sensing: of the model.
        senses: `loads`, which is what the limbs of a Tegotae law see: a clock, sin ω t and cos ω t,
            with ω, and the loads of the feet; or `all`, which is besides every joint's angle and
            velocity, and the torso's orientation and its rate.
    """

    def __init__(self, sensing: Sensing, senses: str) -> None:
        names = sensing.names
        forces: list[tuple[str, float, float]] = [(f"{foot}_force", 0.0, LOAD_N) for foot in FEET]
        if senses == "all":
            for leg in ("FL", "FR", "RL", "RR"):
                for joint, middle in {"hip": 0.0, **MIDDLE}.items():
                    forces.append((f"{leg}_{joint}_joint", middle, 0.3))
                    forces.append((f"{leg}_{joint}_joint_velocity", 0.0, 10.0))
            forces += [(f"imu_quat[{i}]", 0.0, 1.0) for i in range(4)]
            forces += [(f"imu_gyro[{i}]", 0.0, 3.0) for i in range(3)]
        self._at = [names.index(name) for name, _, _ in forces]
        self._middle = np.array([middle for _, middle, _ in forces])
        self._scale = np.array([scale for _, _, scale in forces])
        self._driven = [k for k, name in enumerate(sensing.actuators) if "hip" not in name]
        self._still = np.zeros(len(sensing.actuators))
        for k, name in enumerate(sensing.actuators):
            self._still[k] = MIDDLE.get(name.partition("_")[2], 0.0)
        self.width = len(forces) + 3

    def inputs(self, observation: np.ndarray, time_s: np.ndarray, omega: np.ndarray) -> np.ndarray:
        """The network's inputs, [lanes, width]."""
        clock = np.stack([np.sin(omega * time_s), np.cos(omega * time_s), omega / OMEGAS[1]], 1)
        body = (observation[:, self._at] - self._middle) / self._scale
        return np.clip(np.concatenate([clock, body], 1), -10.0, 10.0).astype(np.float32)

    def commands(self, outputs: np.ndarray) -> np.ndarray:
        """Places of all joints; the network's ±1 are the ends of the widest range."""
        action = np.tile(self._still, (len(outputs), 1))
        action[:, self._driven] += WIDEST * np.clip(outputs, -1.0, 1.0)
        return action


class Joints(VecEnv):
    """Training's episodes of Go1 side by side, whose action is the places of thighs and calves.

    Args:
        senses: what is seen (`Body`).
        key: every episode has a start of its own, which this decides together with its number.
    """

    def __init__(self, senses: str, key: tuple[int, ...]) -> None:
        settings = SPEC.model_settings
        settings = type(settings)(**{**vars(settings), "duration_s": TRAINED_S})
        self._lanes = ModelLanes(settings, LANES)
        self.body = Body(self._lanes._sensing, senses)
        self._omega = np.resize(OMEGAS, LANES)
        self._drawn = np.random.default_rng(key)
        bounds = Box(-np.inf, np.inf, (self.body.width,)), Box(-1.0, 1.0, (8,))
        super().__init__(LANES, *bounds)

    def _inputs(self) -> np.ndarray:
        return self.body.inputs(self._seen, CONTROL_S * self._done, self._omega)

    def reset(self) -> np.ndarray:
        self._seen = self._lanes.reset(self._starts(), np.ones(LANES, bool))
        self._done = np.zeros(LANES)
        return self._inputs()

    def _starts(self) -> np.ndarray:
        """Seeds of new starts, one a lane."""
        return self._drawn.integers(2**32, size=LANES)

    def step_async(self, actions: np.ndarray) -> None:
        self._actions = actions

    def step_wait(self):
        every = np.ones(LANES, bool)
        observation, paid, over = self._lanes.step(self.body.commands(self._actions), every)
        self._seen = np.nan_to_num(observation)
        self._done += 1
        cut = over & self._lanes.truncated
        inputs = self._inputs()
        infos: list[dict[str, Any]] = [{} for _ in range(LANES)]
        if over.any():
            for lane in map(int, np.flatnonzero(over)):
                infos[lane] = {
                    "terminal_observation": inputs[lane],
                    "TimeLimit.truncated": bool(cut[lane]),
                }
            self._seen = self._lanes.reset(self._starts(), over)
            self._done[over] = 0
            inputs = self._inputs()
        return inputs, paid.astype(np.float32), over, infos

    def close(self) -> None:
        self._lanes.close()

    def env_is_wrapped(self, wrapper_class, indices=None):
        return [False] * self.num_envs

    def env_method(self, name, *args, indices=None, **kwargs):
        raise NotImplementedError

    def get_attr(self, name, indices=None):
        return [getattr(self, name, None)] * self.num_envs

    def set_attr(self, name, value, indices=None):
        raise NotImplementedError


class Network:
    """An agent's deterministic policy as a driver of trials."""

    def __init__(self, agent: PPO, body: Body, omega: np.ndarray) -> None:
        self._agent, self._body, self._omega = agent, body, omega
        self.reset()

    def reset(self) -> None:
        self._step = 0

    def act(self, observed: np.ndarray) -> np.ndarray:
        time_s = np.full(len(observed), CONTROL_S * self._step)
        self._step += 1
        inputs = self._body.inputs(observed, time_s, self._omega)
        return self._body.commands(self._agent.predict(inputs, deterministic=True)[0])


def by_agent(agent: PPO, body: Body) -> Callable[[Sequence[Trial]], Driver]:
    """A trained agent as a driver of trials."""
    return lambda trials: Network(agent, body, np.array([trial.omega for trial in trials]))


def of_selection(agent: PPO, body: Body) -> float:
    """Mean return of the episodes by which the best law of a population, too, is chosen."""
    count = SELECTION * len(OMEGAS)
    trials = [Trial(0, OMEGAS[start % len(OMEGAS)], start) for start in range(count)]
    return float(TRAINED_S * tried(trials, by_agent(agent, body), TRAINED_S).paid.mean())


def learn_ppo(senses: str, seed: int, seconds: float, file: Path) -> None:
    """Train for so much simulated time; kept are the policy that is judged best, and the curve.

    An interrupted training goes on from the last judgement, and one that has ended if more time is
    asked for.
    """
    torch.set_num_threads(1)
    last, table = file.with_name(f"{file.stem}-last.zip"), file.with_suffix(".npz")
    times, values, spent = [], [], 0.0
    if table.exists():
        with np.load(table) as record:
            times, values, spent = [*record["time_s"]], [*record["fitness"]], float(record["cpu_s"])
    if times and times[-1] >= seconds:
        return
    begun = time.process_time()
    env = Joints(senses, (seed, len(times)))
    if times:
        agent = PPO.load(last, env=env, device="cpu")
    else:
        agent = PPO("MlpPolicy", env, seed=seed, device="cpu", **SETTINGS)
    per_update_s = LANES * SETTINGS["n_steps"] * CONTROL_S
    while not times or times[-1] < seconds:
        if times:
            agent.learn(UPDATES * LANES * SETTINGS["n_steps"], reset_num_timesteps=False)
        times.append(times[-1] + UPDATES * per_update_s if times else 0.0)
        values.append(of_selection(agent, env.body))
        agent.save(last)
        if values[-1] == max(values):
            agent.save(file)
        cpu_s = spent + time.process_time() - begun
        np.savez(table, time_s=times, fitness=values, cpu_s=cpu_s)
        print(f"{senses} {file.stem}: {times[-1]:.0f} s, {values[-1] / TRAINED_S:.2f}", flush=True)
    env.close()
