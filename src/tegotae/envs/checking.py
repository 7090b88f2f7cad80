"""Whether an environment can be controlled as a wiring says."""

from __future__ import annotations

import numpy as np

from tegotae.envs._types import AnyEnv
from tegotae.envs.contact import flat, observation_names, with_contact
from tegotae.envs.wires import look_up, weights_of
from tegotae.envs.wiring import Wiring


def check_wiring(env: AnyEnv, wiring: Wiring, *, steps: int = 200, seed: int = 0) -> list[str]:
    """The problems of a wiring on this environment: one plain sentence each.

    First the names, shapes and numbers are looked up; if all are there, the environment is run for
    some steps of random actions, to see whether what is wired as the contact force looks like one:
    finite, never negative, zero in flight and not always zero. A wiring without weights is one that
    is yet to be trained, and nothing is missing for that.

    Args:
        env: any Gymnasium environment.
        wiring: the wiring.
        steps: how many steps to run it for; 0 to look only.
        seed: seed of the run.

    Returns:
        The problems; an empty list if there are none.

    Example:
        >>> import gymnasium
        >>> from tegotae.envs import Limb
        >>> limb = Limb(senses={"spring_force": "touch"}, drives="action[0]")
        >>> env = gymnasium.make("Pendulum-v1")
        >>> check_wiring(env, Wiring(limbs=[limb], weights=[2.0], omega=4.0))
        ["limb 0: no observation entry is called 'touch'; known: observation[0], observation[1], \
observation[2]"]
    """
    env = with_contact(env, wiring.contact_bodies)
    problems = missing(env, wiring)
    if problems or steps <= 0:
        return problems
    return _run(env, wiring, steps, seed)


def missing(env: AnyEnv, wiring: Wiring) -> list[str]:
    """The same without running the environment, whose contact forces are observed already."""
    _, problems = look_up(env, wiring)
    if wiring.weights is not None:
        problems += weights_of(wiring)[1]
        if wiring.omega is None:
            problems.append("the wiring has weights but no frequency; give omega= [rad/s]")
    return problems


def _run(env: AnyEnv, wiring: Wiring, steps: int, seed: int) -> list[str]:
    """Random actions, to see whether the contact forces look like such."""
    names = list(wiring.observation_names or observation_names(env))
    contacts = [limb.senses.get("spring_force") for limb in wiring.limbs]
    env.action_space.seed(seed)
    observation, _ = env.reset(seed=seed)
    rows = []
    for _ in range(steps):
        rows.append(flat(env.observation_space, observation))
        observation, _, terminated, truncated, _ = env.step(env.action_space.sample())
        if terminated or truncated:
            observation, _ = env.reset()
    seen = np.array(rows)
    problems = []
    for i, name in enumerate(contacts):
        # Below zero, what is turned or a spring's counts as zero.
        if name is None or name not in names or name.endswith("_spring"):
            continue
        force = seen[:, names.index(name)]
        about = f"limb {i}: {name!r} does not look like a contact force: in {steps} random steps it"
        if not np.isfinite(force).all():
            problems.append(f"{about} was not finite")
        elif (force < 0.0).any():
            problems.append(f"{about} was negative ({force.min():g})")
        elif (force == 0.0).all():
            problems.append(f"{about} never left zero")
        elif (force > 0.0).all():
            problems.append(f"{about} was never zero")
    return problems
