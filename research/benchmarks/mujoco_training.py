"""Training on a MuJoCo model beside a plain loop of Stable-Baselines3 on the same environment.

Run as a program, `python -m research.benchmarks.mujoco_training`; needs the extras `mujoco`
and `sb3`. In both something decides at every control period: there the controllers of all
candidates, here the untrained policy of PPO. Nothing learns.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from tegotae._support.engines import available_cores
from tegotae._support.errors import require
from tegotae.envs.env_spec import EnvSpec
from tegotae.envs.mujoco.env import ModelEnv, ModelLanes
from tegotae.envs.mujoco.settings import compiled_model
from tegotae.envs.wiring import load_wiring
from tegotae.envs.wrapper import Pilot
from tegotae.systems.recipe import recipe
from tegotae.training.environments.experiment import EnvExperiment
from tegotae.training.environments.rollouts import GymLanes, Lanes

LANES = (16, 64)
ENVS = 8
"""Environments of the plain loop; one after the other, so that more make it no faster."""


class MujocoSpeed(NamedTuple):
    """Speed of stepping the hopper."""

    name: str
    lanes: int
    steps_per_s: float
    """Control periods per second, over all lanes."""
    steps_per_core_s: float
    """Control periods per second that a core is at work."""
    step_s: float
    """Control period [s]."""


def measure_environments(steps: int = 200) -> list[MujocoSpeed]:
    """Measure MuJoCo alone, training in threads, environments side by side in one process, and
    the plain loop, best of three.

    Raises:
        MissingExtraError: without MuJoCo or Stable-Baselines3.
    """
    spec = EnvSpec(env="hopper")
    experiment = EnvExperiment.from_recipe(recipe("ART"), spec, load_wiring("hopper"))
    step_s = experiment.wires.step_s

    def driven(lanes: Lanes, n: int) -> tuple[float, float]:
        weights = np.random.default_rng(0).normal(size=(experiment.controller.n_weights, n))
        pilot = Pilot(experiment.wires, experiment.wiring, weights)
        alive = np.ones(n, bool)
        observed = [lanes.reset(0, alive)]

        def step() -> None:
            observed[0] = lanes.step(pilot.act(observed[0]), alive)[0]

        rates = _rates(step, steps, n)
        lanes.close()
        return rates

    rows = [
        MujocoSpeed("mj_step alone, in threads", n, *_bare(spec, n, steps), step_s) for n in LANES
    ]
    for n in LANES:
        rates = driven(ModelLanes(spec.model_settings, n), n)
        rows.append(MujocoSpeed("rollouts in threads", n, *rates, step_s))
    rates = driven(GymLanes(spec.make, ENVS, 10**9), ENVS)
    rows.append(MujocoSpeed("environments, one process", ENVS, *rates, step_s))
    rows.append(MujocoSpeed("Stable-Baselines3, plain loop", ENVS, *_plain(steps), step_s))
    return rows


def _bare(spec: EnvSpec, lanes: int, steps: int) -> tuple[float, float]:
    """Return the control periods per second of the model without a controller, and without the
    sensors that are added to it: random commands are known beforehand."""
    mujoco, batched = require("mujoco", "mujoco"), require("mujoco.rollout", "mujoco")
    settings = spec.model_settings
    model = compiled_model(settings.spec())
    ticks = steps * round((settings.control_s or 0.0) / model.opt.timestep)
    low, high = model.actuator_ctrlrange.T
    commands = np.random.default_rng(0).uniform(low, high, (lanes, ticks, model.nu))
    threads = min(available_cores(), lanes)
    data = [mujoco.MjData(model) for _ in range(threads)]
    begun = np.empty(mujoco.mj_stateSize(model, kind := mujoco.mjtState.mjSTATE_FULLPHYSICS))
    mujoco.mj_getState(model, data[0], begun, kind)
    with batched.Rollout(nthread=threads) as rollout:
        return _rates(lambda: rollout.rollout(model, data, begun, commands), 1, lanes * steps)


def _plain(steps: int) -> tuple[float, float]:
    """Return the steps per second of PPO's policy in a `DummyVecEnv`."""
    ppo = require("stable_baselines3", "sb3").PPO
    torch = require("torch", "sb3")
    torch.set_num_threads(1)  # networks as small as these lose by sharing
    dummy = require("stable_baselines3.common.vec_env", "sb3").DummyVecEnv
    env = dummy([lambda: ModelEnv(model="hopper")] * ENVS)
    agent = ppo("MlpPolicy", env, device="cpu")
    observed = [env.reset()]

    def step() -> None:
        action, _ = agent.predict(observed[0])
        observed[0], *_ = env.step(action)

    return _rates(step, steps, ENVS)


def _rates(step: Callable[[], None], steps: int, lanes: int) -> tuple[float, float]:
    """Return the steps of all lanes per second, and per core-second; best of three."""
    step()  # which may compile
    times, work = [], []
    for _ in range(3):
        begun, begun_work = time.perf_counter(), time.process_time()
        for _ in range(steps):
            step()
        times.append(time.perf_counter() - begun)
        work.append(time.process_time() - begun_work)
    return lanes * steps / min(times), lanes * steps / min(work)


def main() -> None:
    """Print a table."""
    rows = measure_environments()
    for row in rows:
        print(
            f"{row.name:>30}, {row.lanes:3} lanes  {row.steps_per_s:9.3g} steps/s  "
            f"{row.steps_per_core_s:9.3g} per core-s  "
            f"{row.steps_per_core_s / rows[-1].steps_per_core_s:5.1f} x"
        )


if __name__ == "__main__":
    main()
