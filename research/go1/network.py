"""A network on Go1's feet: its inputs and outputs, and its training by PPO.

The network moves the feet, x, y and z, from the ellipse that the laws' trainings begin with, every
10 ms. It reads a clock at the command, the loads, and an IMU. Conditions, commands, time and score
are those of the laws: a step pays the share of an episode that it lasts, less 0.3 |v / v* - 1|, the
price of its cost and 0.3 |ψ| of the heading, and a fall ends all. A law is mirrored and a network
is not: half of its episodes are pushed to the right.
"""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import torch
from gymnasium.spaces import Box
from stable_baselines3 import PPO

from research.frame import write_rows
from research.go1.episodes import FEET, ROOT, Course, course_of
from research.go1.plan import LAWS_FOLDER, OFF_COURSE, PHASES, TRAINED_S, TRAINED_SPEEDS, Phase
from research.lane_env import LaneEnv
from tegotae._support.files import output_folder

LENGTH_M, TIME_S = 0.265, 0.1644
"""Units of length and time in the laws: l0 and √(l0 / g)."""
REACH_M = np.tile([0.12, 0.08, 0.08], len(FEET))
"""Range by which the network's ±1 move the feet from the ellipse that all trainings begin with."""
LIFT_M, PRESS_M, SHIFT_RAD = LENGTH_M * 0.2, LENGTH_M * 0.03, 0.4
"""Lift, press and shift of that ellipse; the stride varies."""
TROT_RAD = np.array([0.0, np.pi, np.pi, 0.0])
MIDDLE_RAD_PER_S = 16.0
"""Divisor of commands."""
IMU = {"roll": 0.3, "pitch": 0.3, "yaw": 0.5, "roll_rate": 3.0, "pitch_rate": 3.0, "yaw_rate": 3.0}
"""Divisors of an IMU's readings."""
SCALES = {f"{foot}_estimated_force": 60.0 for foot in FEET} | {
    f"root_{name}": scale for name, scale in IMU.items()
}
"""Divisors of the inputs."""
LANES = 6
"""Episodes side by side under each condition and to each side, two at each command."""
MEMORY_S = 0.3
"""Time constant of the average of the rewarded speed."""
SETTINGS: dict[str, Any] = {
    "n_steps": 128,
    "batch_size": 512,
    "policy_kwargs": {"log_std_init": -2.0},
}
"""Settings that differ from Stable-Baselines3's defaults."""


@dataclass(frozen=True)
class Pace:
    """Meaning of commands: the stride B (1 - ω0 / ω), and the wanted speed c (ω - ω0).

    Args:
        stride_m: B.
        still_rad_per_s: ω0.
        slope_m: c.
    """

    stride_m: float
    still_rad_per_s: float
    slope_m: float

    def stride_at(self, omega: np.ndarray) -> np.ndarray:
        """Return the half of the stride [m] at commands [rad/s]."""
        return self.stride_m * (1.0 - self.still_rad_per_s / omega)

    def wanted_m_per_s(self, omega: np.ndarray) -> np.ndarray:
        """Return the speed that corresponds to commands [rad/s]."""
        return self.slope_m * (omega - self.still_rad_per_s)

    def omega_at(self, speed_m_per_s: np.ndarray) -> np.ndarray:
        """Return the commands [rad/s] that correspond to a speed."""
        return self.still_rad_per_s + speed_m_per_s / self.slope_m


@dataclass(frozen=True)
class MeasuredPace:
    """Meaning of commands whose speed is no straight line over them: measured speeds, interpolated.

    Args:
        omega: commands [rad/s], ascending.
        speed: mean speeds at them [m/s], ascending.
    """

    omega: np.ndarray
    speed: np.ndarray

    def omega_at(self, speed_m_per_s: np.ndarray) -> np.ndarray:
        """Return the commands [rad/s] that correspond to a speed."""
        return np.interp(speed_m_per_s, self.speed, self.omega)


START = {"stride_m": 0.7, "still_rad_per_s": 1.97}
"""Initial values of all trainings: the foot steps on the spot at 12 rad/s, and reaches 2.5 m/s at
33."""
PACED = Pace(
    START["stride_m"] * LENGTH_M,
    START["still_rad_per_s"] / TIME_S,
    2.0 * START["stride_m"] * LENGTH_M / math.pi,
)


def places_of(outputs: np.ndarray, phase: np.ndarray, stride_m: np.ndarray) -> np.ndarray:
    """Return the places of the feet [m] of a network's outputs, [lanes, 12], at the clock's
    phase and half of the stride, [lanes].
    """
    angle = phase[:, None] + TROT_RAD
    up = np.where(np.sin(angle) > 0.0, LIFT_M, PRESS_M) * np.sin(angle)
    ahead = -stride_m[:, None] * np.cos(angle + SHIFT_RAD)
    ellipse = np.stack([ahead, np.zeros_like(angle), up], axis=2)
    return ellipse.reshape(len(phase), -1) + REACH_M * np.clip(outputs, -1.0, 1.0)


def entries_of(course: Course) -> list[int]:
    """Return the entries of the observation that the network reads."""
    return [course.names.index(name) for name in SCALES]


def inputs_of(readings: np.ndarray, phase: np.ndarray, omega: np.ndarray) -> np.ndarray:
    """Return the network's inputs, [lanes, inputs], of readings [lanes, entries]."""
    body = readings / np.array(list(SCALES.values()))
    clock = [np.sin(phase), np.cos(phase), omega / MIDDLE_RAD_PER_S]
    return np.clip(np.column_stack([*clock, body]), -10.0, 10.0).astype(np.float32)


class Policy:
    """Trained actor as a driver, without its noise.

    Args:
        actor: its arrays, as the file has them.
        course: of the robot, begun.
        omega: commands [rad/s], [lanes].
    """

    def __init__(self, actor: dict[str, np.ndarray], course: Course, omega: np.ndarray) -> None:
        self._actor, self._omega, self._step_s = actor, omega, course.step_s
        self.read = entries_of(course)
        self._stride_m = PACED.stride_at(omega)
        self._clock = course.phases[0].copy()
        self.phase = self._clock + TROT_RAD[:, None]

    def act(self, observed: np.ndarray) -> np.ndarray:
        """Return the places of the feet [m], [lanes, actions]."""
        x = inputs_of(observed[:, self.read], self._clock, self._omega)
        for k in range(2):
            x = np.tanh(x @ self._actor[f"w{k}"] + self._actor[f"b{k}"])
        outputs = x @ self._actor["w2"] + self._actor["b2"]
        places = places_of(outputs, self._clock, self._stride_m)
        self._clock = self._clock + self._omega * self._step_s
        self.phase = self._clock + TROT_RAD[:, None]
        return places


class Feet(LaneEnv):
    """Episodes of a phase of training, `LANES` under each of its conditions, to each side.

    Args:
        phase: of the training.
        key: of the starts.
    """

    def __init__(self, phase: Phase, key: tuple[int, ...]) -> None:
        left = phase.conditions
        right = [dataclasses.replace(item, push_m_per_s=-item.push_m_per_s) for item in left]
        sides = (left, range(LANES)), (right, range(LANES, 2 * LANES))
        self.courses = [
            course_of(item, layouts, TRAINED_S) for side, layouts in sides for item in side
        ]
        names = self.courses[0].names
        self._read, self._price = entries_of(self.courses[0]), phase.price
        self._entries = [names.index(f) for f in ("root_speed", "work", "root_yaw_rate")]
        self._omega = np.resize(PACED.omega_at(np.array(TRAINED_SPEEDS)), LANES)
        self._drawn, n = np.random.default_rng(key), LANES * len(self.courses)
        self.paid: list[float] = []
        """Sum of the rewards of each episode that is over."""
        self._steps, self._sum, self._fast = np.zeros(n, int), np.zeros(n), np.zeros(n)
        self._phase, self._worked, self._heading = np.zeros(n), np.zeros(n), np.zeros(n)
        bounds = Box(-np.inf, np.inf, (3 + len(SCALES),)), Box(-1.0, 1.0, (len(REACH_M),))
        super().__init__(n, *bounds)

    def reset(self) -> np.ndarray:
        for k in range(len(self.courses)):
            self._begin(k, np.ones(LANES, bool))
        return self._inputs()

    def _begin(self, k: int, over: np.ndarray) -> None:
        course, lanes = self.courses[k], slice(k * LANES, (k + 1) * LANES)
        course.reset(self._drawn.integers(2**31, size=LANES), over)
        self._phase[lanes] = np.where(over, course.phases[0], self._phase[lanes])
        for state in (self._steps, self._sum, self._fast, self._heading):
            state[lanes][over] = 0
        self._worked[lanes][over] = course.seen[over, self._entries[1]]

    def _inputs(self) -> np.ndarray:
        felt = np.concatenate([course.felt(self._read) for course in self.courses])
        return inputs_of(felt[:, self._read], self._phase, np.tile(self._omega, len(self.courses)))

    def step_wait(self):
        step_s, omega = self.courses[0].step_s, np.tile(self._omega, len(self.courses))
        stands, observations = np.zeros(self.num_envs, bool), []
        for k, course in enumerate(self.courses):
            lanes = slice(k * LANES, (k + 1) * LANES)
            stride_m = PACED.stride_at(self._omega)
            places = places_of(self.actions[lanes], self._phase[lanes], stride_m)
            stands[lanes] = course.step(places, np.ones(LANES, bool))
            observations.append(np.nan_to_num(course.seen[:, self._entries]))
        speed, work, turns = np.concatenate(observations).T
        target, weight_n = PACED.wanted_m_per_s(omega), self.courses[0].weight_n
        self._fast += (speed - self._fast) * step_s / MEMORY_S
        self._heading += turns * step_s
        off = np.minimum(np.abs(self._fast / target - 1.0), 1.0)
        cost = np.minimum((work - self._worked) / (weight_n * target * step_s), 8.0)
        penalty = self._price * cost + OFF_COURSE * np.minimum(np.abs(self._heading), 1.0)
        paid = np.where(stands, 1.0 - 0.3 * off - penalty, 0.0) * step_s / TRAINED_S
        self._worked, self._phase = work, self._phase + omega * step_s
        self._sum, self._steps = self._sum + paid, self._steps + 1
        cut = stands & (self._steps * step_s >= TRAINED_S - 1e-9)
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


def train_network(seed: int) -> None:
    """Train a network by PPO in all phases, from where its training was stopped."""
    torch.set_num_threads(1)
    stopped = output_folder(ROOT / "runs" / "go1") / f"ppo-{seed}.zip"
    for phase in PHASES:
        steps = PPO.load(stopped, device="cpu").num_timesteps if stopped.exists() else 0
        env = Feet(phase, (seed, steps))
        if steps:
            model = PPO.load(stopped, env=env, device="cpu")
        else:
            model = PPO("MlpPolicy", env, seed=seed, device="cpu", **SETTINGS)
        while model.num_timesteps < phase.steps:
            env.paid.clear()
            model.learn(20 * SETTINGS["n_steps"] * env.num_envs, reset_num_timesteps=steps == 0)
            steps = model.num_timesteps
            model.save(stopped)
            row = {"steps": steps, "score": np.mean(env.paid)}
            write_rows(LAWS_FOLDER / f"ppo-{seed}.csv", [row], digits=4, by=("steps",))
            np.savez_compressed(LAWS_FOLDER / f"ppo-{seed}.npz", **actor_of(model))
            print(f"ppo-{seed}: {steps} of {phase.steps} steps, {row['score']:.3f}", flush=True)
        env.close()


def actor_of(model: PPO) -> dict[str, np.ndarray]:
    """Return the actor's arrays: weights w0, w1, w2 and biases b0, b1, b2."""
    net = model.policy.mlp_extractor.policy_net
    arrays: dict[str, np.ndarray] = {}
    for k, layer in enumerate((net[0], net[2], model.policy.action_net)):
        arrays[f"w{k}"] = layer.weight.detach().numpy().T.astype(np.float32)
        arrays[f"b{k}"] = layer.bias.detach().numpy().astype(np.float32)
    return arrays
