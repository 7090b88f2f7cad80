"""PPO on Go1's feet, in the laws' own foot space and under the disturbances of their tuning.

    python research/studies/go1_ppo.py --senses loads            # half an hour of one core
    python research/studies/go1_ppo.py --senses imu --seed 1
    python research/studies/go1_ppo.py --senses imu --pace speed
    python research/studies/go1_ppo.py --senses imu --pace further

A network of Stable-Baselines3 moves the feet, x, y and z, from the ellipse that the laws' tunings
begin with, every 10 ms. It reads a clock at the command and its senses: `contacts`, which feet
bear, the booleans that CPG-RL's policies see; `loads`; `imu`, those and roll, pitch, heading and
their rates; `all`, those and every joint's angle and velocity, and the trunk's. Conditions,
commands, time and reward are those of `go1_tuned.py`: each step pays the share of an episode that
it lasts, less 0.3 |v / v* - 1| and 0.05 P / (m g v*), and a fall ends all. A law is mirrored and a
network is not: half of its episodes are pushed to the right.
With the pace `speed` speeds are the commands, the stride of the ellipse is theirs, 0.05 is 0.1, and
0.3 |ψ| of the heading, up to 1 rad, is lost; with `further` that training goes on as the law's.
`docs/_static/go1_feet` keeps the actor, `ppo-SENSES-SEED.npz` or `ppo-SENSES-PACE-SEED.npz`, and
what its episodes were worth, `.csv`. A training goes on where it was stopped.
"""

from __future__ import annotations

import dataclasses
import sys
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import torch
import tyro
from gymnasium.spaces import Box
from stable_baselines3 import PPO
from stable_baselines3.common.vec_env import VecEnv

from go1_feet import FOLDER, ROOT, Course
from go1_policy import PACED, REACH_M, STEADY, Inputs, Senses, places_of
from go1_tuned import ALSO_MET, AT_FREQUENCIES, BEFORE, MET, OMEGAS, PRICES, SECONDS, SPEEDS
from kept import write_rows
from tegotae._support.errors import TegotaeError
from tegotae._support.files import output_folder
from tegotae.cli.console import exit_status

LANES = 6
"""Episodes side by side under each condition and to each side, two at each command."""
Pace = Literal["tuned", "speed", "further"]
STEPS = {"tuned": 2_160_000, "speed": 2_160_000, "further": 3_888_000}
"""Number of steps of 10 ms in all: the time that a law's tuning simulates."""
MEMORY_S = 0.3
"""Time constant of the average of the rewarded speed."""
TUNED: dict[str, Any] = {"n_steps": 128, "batch_size": 512, "policy_kwargs": {"log_std_init": -2.0}}
"""Settings that differ from Stable-Baselines3's defaults."""


class Feet(VecEnv):
    """Training's episodes, `LANES` under each of the conditions that a tuning meets, to each side.

    Args:
        senses: what is read.
        key: of the starts.
        pace: which speed is wanted.
    """

    def __init__(self, senses: Senses, key: tuple[int, ...], pace: Pace) -> None:
        met, speeds = (*MET, *ALSO_MET.get(pace, ())), pace in PRICES
        right = [dataclasses.replace(item, push_m_per_s=-item.push_m_per_s) for item in met]
        sides = (met, range(LANES)), (right, range(LANES, 2 * LANES))
        self.courses = [
            Course(condition, layouts, SECONDS) for side, layouts in sides for condition in side
        ]
        self.inputs = Inputs(self.courses[0], senses)
        self._speed = self.courses[0].names.index("root_speed")
        self._work = self.courses[0].names.index("work")
        self._yaw_rate = self.courses[0].names.index("root_yaw_rate")
        self._pace = PACED if speeds else STEADY
        self._prices = PRICES.get(pace, AT_FREQUENCIES)
        commands = PACED.omega_at(np.array(SPEEDS)) if speeds else OMEGAS
        self._omega = np.resize(commands, LANES)
        self._drawn, n = np.random.default_rng(key), LANES * len(self.courses)
        self.paid: list[float] = []
        """What each episode that is over was worth."""
        self._done, self._sum, self._fast = np.zeros(n, int), np.zeros(n), np.zeros(n)
        self._phase, self._worked, self._heading = np.zeros(n), np.zeros(n), np.zeros(n)
        bounds = Box(-np.inf, np.inf, (self.inputs.width,)), Box(-1.0, 1.0, (len(REACH_M),))
        super().__init__(n, *bounds)

    def reset(self) -> np.ndarray:
        for k in range(len(self.courses)):
            self._begin(k, np.ones(LANES, bool))
        self.inputs.begin(self.courses[0].seen.mean(axis=0))
        return self._inputs()

    def _begin(self, k: int, over: np.ndarray) -> None:
        course, lanes = self.courses[k], slice(k * LANES, (k + 1) * LANES)
        course.reset(self._drawn.integers(2**31, size=LANES), over)
        begun = np.where(over, course.phases[0], self._phase[lanes])
        self._phase[lanes] = begun
        for state in (self._done, self._sum, self._fast, self._heading):
            state[lanes][over] = 0
        self._worked[lanes][over] = course.seen[over, self._work]

    def _inputs(self) -> np.ndarray:
        felt = np.concatenate([course.felt(self.inputs.read) for course in self.courses])
        return self.inputs(felt, self._phase, np.tile(self._omega, len(self.courses)))

    def step_async(self, actions: np.ndarray) -> None:
        self._actions = actions

    def step_wait(self):
        step_s, omega = self.courses[0].step_s, np.tile(self._omega, len(self.courses))
        stands, observations = np.zeros(self.num_envs, bool), []
        for k, course in enumerate(self.courses):
            lanes = slice(k * LANES, (k + 1) * LANES)
            stride_m = self._pace.stride_at(self._omega)
            places = places_of(self._actions[lanes], self._phase[lanes], stride_m)
            stands[lanes] = course.step(places, np.ones(LANES, bool))
            entries = [self._speed, self._work, self._yaw_rate]
            observations.append(np.nan_to_num(course.seen[:, entries]))
        speed, work, turns = np.concatenate(observations).T
        target, weight_n = self._pace.wanted_m_per_s(omega), self.courses[0].weight_n
        self._fast += (speed - self._fast) * step_s / MEMORY_S
        self._heading += turns * step_s
        off = np.minimum(np.abs(self._fast / target - 1.0), 1.0)
        cost = np.minimum((work - self._worked) / (weight_n * target * step_s), 8.0)
        penalty = self._prices[0] * cost + self._prices[1] * np.minimum(np.abs(self._heading), 1.0)
        paid = np.where(stands, 1.0 - 0.3 * off - penalty, 0.0) * step_s / SECONDS
        self._worked, self._phase = work, self._phase + omega * step_s
        self._sum, self._done = self._sum + paid, self._done + 1
        cut = stands & (self._done * step_s >= SECONDS - 1e-9)
        over, infos = ~stands | cut, [{} for _ in range(self.num_envs)]
        inputs = self._inputs()
        if over.any():
            self.paid += self._sum[over].tolist()
            for lane in map(int, np.flatnonzero(over)):
                infos[lane] = {
                    "terminal_observation": inputs[lane],
                    "TimeLimit.truncated": bool(cut[lane]),
                }
            for k in range(len(self.courses)):
                self._begin(k, over[k * LANES : (k + 1) * LANES])
            inputs = self._inputs()
        return inputs, (100.0 * paid).astype(np.float32), over, infos

    def close(self) -> None:
        for course in self.courses:
            course.close()

    def env_is_wrapped(self, wrapper_class, indices=None):
        return [False] * self.num_envs

    def env_method(self, name, *args, indices=None, **kwargs):
        raise NotImplementedError

    def get_attr(self, name, indices=None):
        return [getattr(self, name, None)] * self.num_envs

    def set_attr(self, name, value, indices=None):
        raise NotImplementedError


@dataclass(frozen=True)
class Trained:
    """Train one network."""

    senses: Senses = "imu"
    """Senses that the network reads."""
    seed: int = 0
    """Seed of the network and its starts."""
    pace: Pace = "tuned"
    """Commands: `tuned` means frequencies; `speed`, speeds of 0.3 to 2.5 m/s; `further`, the latter
    under the conditions of a law's second tuning."""

    def run(self) -> None:
        """Train, and write the actor."""
        torch.set_num_threads(1)
        name, steps = self.name_of(self.pace), STEPS[self.pace]
        folder = output_folder(ROOT / "runs" / "go1_ppo")
        stopped, table = folder / f"{name}.zip", FOLDER / f"{name}.csv"
        begun = folder / f"{self.name_of(BEFORE.get(self.pace, self.pace))}.zip"
        begun = stopped if stopped.exists() else begun
        if begun != stopped and not begun.exists():
            raise TegotaeError(f"--pace {self.pace} goes on from {begun}: --pace speed first")
        if begun.exists():
            previous_steps = PPO.load(begun, device="cpu").num_timesteps
            env = Feet(self.senses, (self.seed, previous_steps), self.pace)
            model = PPO.load(begun, env=env, device="cpu")
        else:
            previous_steps, env = 0, Feet(self.senses, (self.seed, 0), self.pace)
            model = PPO("MlpPolicy", env, seed=self.seed, device="cpu", **TUNED)
        while model.num_timesteps < steps:
            env.paid.clear()
            model.learn(
                20 * TUNED["n_steps"] * env.num_envs, reset_num_timesteps=previous_steps == 0
            )
            previous_steps = model.num_timesteps
            model.save(stopped)
            write_rows(
                table,
                [{"steps": previous_steps, "score": np.mean(env.paid)}],
                digits=4,
                by=("steps",),
            )
            np.savez_compressed(FOLDER / f"{name}.npz", **actor_of(model, env))
            print(f"{name}: {previous_steps} of {steps} steps, {np.mean(env.paid):.3f}", flush=True)
        env.close()

    def name_of(self, pace: str) -> str:
        """Return the stem of the files of a pace."""
        suffix = "" if pace == "tuned" else f"-{pace}"
        return f"ppo-{self.senses}{suffix}-{self.seed}"


def actor_of(model: PPO, env: Feet) -> dict[str, np.ndarray]:
    """Return the actor's arrays: weights w0, w1, w2 and biases b0, b1, b2; and the angles at
    rest."""
    net = model.policy.mlp_extractor.policy_net
    layers = [net[0], net[2], model.policy.action_net]
    arrays: dict[str, np.ndarray] = {"rest": env.inputs._rest.astype(np.float32)}
    for k, layer in enumerate(layers):
        arrays[f"w{k}"] = layer.weight.detach().numpy().T.astype(np.float32)
        arrays[f"b{k}"] = layer.bias.detach().numpy().astype(np.float32)
    return arrays


if __name__ == "__main__":
    sys.exit(exit_status(lambda: tyro.cli(Trained, description=__doc__).run()))
