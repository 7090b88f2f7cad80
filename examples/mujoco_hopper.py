"""Gymnasium's MuJoCo hopper with a Tegotae oscillator on each of its three joints.

Run: python examples/mujoco_hopper.py        (needs: pip install 'tegotae[mujoco]')
"""

import gymnasium
import numpy as np

from tegotae.envs import Limb, MujocoContactForce, TegotaeWrapper, Wiring, check_wiring


def controlled() -> gymnasium.Env:
    """Hopper-v5 whose joints are driven by oscillators that listen to its foot."""
    # Its observation has no contact force: add the upward force on the foot [N] as `foot_force`.
    env = MujocoContactForce(gymnasium.make("Hopper-v5"), "foot")

    # Three oscillators in phase; in their sector of the phase each joint gets its push.
    torques = {"leg_joint": (0.05, -0.5), "foot_joint": (0.1, -0.3), "thigh_joint": (0.2, 1.0)}
    limbs = [
        Limb(
            senses={"spring_force": "foot_force"}, drives=name, rest=rest, push=push, phase_rad=2.3
        )
        for name, (rest, push) in torques.items()
    ]
    wiring = Wiring(limbs=limbs, weights=[0.03], omega=14.0)  # the vanilla feedback, σ = 0.03

    problems = check_wiring(env, wiring)
    assert not problems, problems
    return TegotaeWrapper(env, wiring)


def episode(env: gymnasium.Env, seed: int) -> tuple[int, float]:
    """Steps until the hopper falls over, and how far it got [m], all actions being zero."""
    assert env.action_space.shape is not None
    rest = np.zeros(env.action_space.shape, np.float32)
    env.reset(seed=seed)
    for step in range(1, 1001):  # noqa: B007
        *_, fallen, _, info = env.step(rest)
        if fallen:
            break
    return step, float(info["x_position"])


def main(seeds: int = 10) -> None:
    """Compare it with the same hopper whose joints get no torque."""
    environments = {"no torque": gymnasium.make("Hopper-v5"), "Tegotae": controlled()}
    distance = {}
    for name, env in environments.items():
        steps, metres = np.mean([episode(env, seed) for seed in range(seeds)], axis=0)
        print(f"{name}: {steps:.0f} steps, {metres:.2f} m")
        distance[name] = metres
    assert distance["Tegotae"] > distance["no torque"] + 0.3


if __name__ == "__main__":
    main()
