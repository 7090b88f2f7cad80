"""An agent of Stable-Baselines3 learns on top of the oscillators of a MuJoCo leg.

Run: python sb3.py [ppo | sac] [STEPS] [CONTROLLER.json, of a MuJoCo model of yours]"""

import sys
from dataclasses import replace

import numpy as np
from stable_baselines3 import PPO, SAC
from stable_baselines3.common.monitor import Monitor

from tegotae.envs import TegotaeWrapper, Wiring
from tegotae.envs.env_spec import EnvSpec
from tegotae.envs.mujoco.settings import ModelSettings
from tegotae.figures.style import new_figure, save_figure, styled
from tegotae.systems.controller_file import load
from tegotae.training.environments.experiment import EnvExperiment
from tegotae_robots.models.suggesting import suggest_wiring

name, steps, *file = [*sys.argv[1:], *["ppo", "1200"][len(sys.argv) - 1 :]]
if file:
    wiring, trained = Wiring.from_controller(file[0]), EnvExperiment.from_controller(load(file[0]))
    spec, seconds = trained.spec, trained.duration_s
else:  # the vanilla feedback with a gain that `tegotae wiring baseline` found; the agent adds to it
    suggested = suggest_wiring(ModelSettings(model="leg")).wiring
    wiring = replace(suggested.reading(suggested.controller), weights=[1.52], omega=17.5)
    spec, seconds = EnvSpec(env="leg").for_wiring(wiring), 1.0
spec = replace(spec, settings=(*spec.settings, ("duration_s", seconds)))


def leg() -> Monitor:
    """The leg, whose action is an added feedback of each limb."""
    return Monitor(TegotaeWrapper(spec.make(), wiring))


def paid(act) -> np.ndarray:
    """The rewards of an episode, added up."""
    env, rewards, over = leg(), [], False
    observation, _ = env.reset(seed=0)
    while not over:
        observation, reward, fallen, late, _ = env.step(act(observation))
        rewards.append(reward)
        over = fallen or late
    return np.cumsum(rewards)


options = {"ppo": {"n_steps": 400, "batch_size": 100}, "sac": {"learning_starts": 200}}[name]
agent = {"ppo": PPO, "sac": SAC}[name]("MlpPolicy", leg(), seed=0, device="cpu", **options)
agent.learn(int(steps))
alone = paid(lambda seen: np.zeros(len(wiring.limbs)))
learned = paid(lambda seen: agent.predict(seen, deterministic=True)[0])
print(f"return alone {alone[-1]:.3f}, with {name} of {steps} steps {learned[-1]:.3f}")
with styled():
    axes = (figure := new_figure()).add_subplot(xlabel="control period", ylabel="return")
    for label, curve in {"without the agent": alone, f"with {name}": learned}.items():
        axes.plot(curve, label=label)
    axes.legend()
    save_figure(figure, "sb3.png")
assert agent.num_timesteps >= int(steps)
assert alone[-1] > 0.0
