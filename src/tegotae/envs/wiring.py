"""Which observation a limb's oscillator listens to, and which action entry it drives."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import gymnasium
import numpy as np
from gymnasium.spaces import Box

from tegotae.controller import Controller
from tegotae.envs.naming import action_names, flat, observation_names
from tegotae.errors import TegotaeError, require_finite, unknown
from tegotae.models import build


@dataclass(frozen=True, kw_only=True)
class Limb:
    """One limb: an oscillator with what it senses and what it drives.

    Args:
        senses: for each signal that the controller reads (such as `spring_force`, `velocity`), the
            name of the observation entry that it is. The contact force goes under `spring_force`.
        drives: name of the action entry.
        rest: value of that entry where the actuator force is zero; the middle of its bounds if
            None.
        push: its value at full force; its upper bound if None.
        phase_rad: phase at reset [rad].
    """

    senses: Mapping[str, str]
    drives: str
    rest: float | None = None
    push: float | None = None
    phase_rad: float = 0.0


@dataclass(frozen=True, kw_only=True)
class Wiring:
    """How Tegotae control is wired into an environment: `TegotaeWrapper(env, wiring)`.

    Every limb has a phase oscillator `φ̇ = ω + f` with the feedback `f = G · A′(φ) · R(s)` of its
    own senses, and the controller's actuation makes of them a force in [0, α], which becomes the
    action `rest + (push - rest) · F_a / α`.
    """

    limbs: Sequence[Limb]
    """The limbs."""
    weights: Any
    """The controller's weights, shape [n_weights], or [limbs, n_weights]; σ for the vanilla one."""
    omega: float
    """Prescribed frequency ω [rad/s]."""
    controller: Controller = field(default_factory=lambda: build("V-sector-w8"))
    """Terms, oscillator and actuation, the same for all limbs; the vanilla sector by default."""
    scales: Mapping[str, float] = field(default_factory=dict)
    """What a network divides each signal by, such as the weight for `spring_force`, and √(g/l0) for
    `feedback`; 1 if not named."""
    max_force: float = 4.0
    """The force α at which the action is `push`, in the units of the actuation's force."""
    max_feedback_rad_per_s: float = 10.0
    """What an agent's action of 1 adds to a limb's feedback [rad/s]."""
    step_s: float | None = None
    """Time between two steps of the environment [s]; its own `dt` if None."""
    observation_names: Sequence[str] | None = None
    """Names of the observation's entries, if those of `naming.observation_names` do not do."""
    action_names: Sequence[str] | None = None
    """Names of the action's entries, likewise."""


@dataclass(frozen=True)
class Wires:
    """A wiring that has been looked up in an environment."""

    sensed: dict[str, np.ndarray]
    """For each signal, the observation's entry of each limb, shape [limbs]."""
    driven: np.ndarray
    """The action's entry of each limb, shape [limbs]."""
    free: np.ndarray
    """Entries of the action that no limb drives."""
    rest: np.ndarray
    """Action at no force, shape [limbs]."""
    push: np.ndarray
    """Action at full force, shape [limbs]."""
    weights: np.ndarray
    """Shape [n_weights, limbs]."""
    step_s: float
    """Time between two steps [s]."""


def check_wiring(
    env: gymnasium.Env[Any, Any], wiring: Wiring, *, steps: int = 200, seed: int = 0
) -> list[str]:
    """What is missing before this environment can be controlled so: one plain sentence each.

    First the names, shapes and numbers are looked up; if all are there, the environment is run for
    some steps of random actions, to see whether what is wired as the contact force looks like one:
    finite, never negative, zero in flight and not always zero.

    Args:
        env: any Gymnasium environment.
        wiring: the wiring.
        steps: how many steps to run it for; 0 to look only.
        seed: seed of the run.

    Returns:
        The problems; an empty list if there are none.

    Example:
        >>> limb = Limb(senses={"spring_force": "touch"}, drives="action[0]")
        >>> env = gymnasium.make("Pendulum-v1")
        >>> check_wiring(env, Wiring(limbs=[limb], weights=[2.0], omega=4.0))
        ["limb 0: no observation entry is called 'touch'; known: observation[0], observation[1], \
observation[2]"]
    """
    _, problems = look_up(env, wiring)
    if problems or steps <= 0:
        return problems
    return _run(env, wiring, steps, seed)


def look_up(env: gymnasium.Env[Any, Any], wiring: Wiring) -> tuple[Wires | None, list[str]]:
    """The wires, or what stands in their way."""
    problems: list[str] = []
    try:
        observed = _names("observation", wiring.observation_names, observation_names(env))
        driven = _names("action", wiring.action_names, action_names(env))
    except TegotaeError as error:
        return None, [str(error)]
    limbs = list(wiring.limbs)
    if not limbs:
        problems.append("there are no limbs; name at least one Limb(senses=..., drives=...)")
    if wiring.controller.limbs > 1:
        problems.append(
            f"the controller has {wiring.controller.limbs} units; here it is that of one limb, and "
            "each of the wiring's limbs has a unit of its own"
        )
    reads = _reads(wiring.controller, problems)
    for i, limb in enumerate(limbs):
        problems += _limb_problems(i, limb, reads, observed, driven)
    for name in {limb.drives for limb in limbs}:
        if sum(limb.drives == name for limb in limbs) > 1:
            problems.append(f"several limbs drive {name!r}; an action entry takes one limb")
    step_s = getattr(env.unwrapped, "dt", None) if wiring.step_s is None else wiring.step_s
    if step_s is None:
        problems.append("the environment has no dt; give the time between two steps as step_s [s]")
    numbers = {
        "omega": (wiring.omega, None),
        "step_s": (step_s, 0.0),
        "max_force": (wiring.max_force, 0.0),
        "max_feedback_rad_per_s": (wiring.max_feedback_rad_per_s, 0.0),
        **{f"scales[{name!r}]": (scale, 0.0) for name, scale in wiring.scales.items()},
    }
    for name, (value, above) in numbers.items():
        if value is not None:
            _try(problems, require_finite, name, value, above=above)
    n_weights = wiring.controller.n_weights
    weights = np.asarray(wiring.weights, np.float32)
    if weights.shape not in ((n_weights,), (len(limbs), n_weights)):
        problems.append(
            f"the weights have shape {weights.shape}; this controller needs ({n_weights},) or "
            f"({len(limbs)}, {n_weights})"
        )
    elif not np.isfinite(weights).all():
        problems.append("the weights are not all finite")
    if problems or step_s is None:
        return None, problems
    at = [driven.index(limb.drives) for limb in limbs]
    ends = [_ends(env, i, limb, at[i], problems) for i, limb in enumerate(limbs)]
    if problems:
        return None, problems
    return (
        Wires(
            {
                signal: np.array([observed.index(limb.senses[signal]) for limb in limbs])
                for signal in reads
            },
            np.array(at),
            np.array([k for k in range(len(driven)) if k not in at], np.intp),
            np.array([rest for rest, _ in ends]),
            np.array([push for _, push in ends]),
            np.ascontiguousarray(np.broadcast_to(weights, (len(limbs), n_weights)).T),
            float(step_s),
        ),
        [],
    )


def _names(what: str, given: Sequence[str] | None, found: Sequence[str]) -> list[str]:
    names = list(found if given is None else given)
    if len(names) != len(found):
        raise TegotaeError(
            f"there are {len(names)} {what} names for {len(found)} entries; give one per entry"
        )
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise TegotaeError(f"several {what} entries are called {twice[0]!r}; names must differ")
    return names


def _reads(controller: Controller, problems: list[str]) -> list[str]:
    """Signals that the environment must provide."""
    if controller.oscillator is None:
        problems.append("the controller has no oscillator; take one that has, such as V-sector-w8")
    own = {"sin_phase", "cos_phase", "feedback"}
    return sorted({name for term in controller.terms.values() for name in term.reads} - own)


def _limb_problems(
    i: int, limb: Limb, reads: Sequence[str], observed: Sequence[str], driven: Sequence[str]
) -> list[str]:
    problems = []
    for signal in reads:
        if signal not in limb.senses:
            problems.append(
                f"limb {i}: the controller reads {signal!r}; say in senses which observation entry "
                "that is"
            )
    for signal, name in limb.senses.items():
        if signal not in reads:
            problems.append(
                f"limb {i}: no term of the controller reads {signal!r}; it reads {', '.join(reads)}"
            )
        if name not in observed:
            problems.append(f"limb {i}: {unknown_entry('observation', name, observed)}")
    if limb.drives not in driven:
        problems.append(f"limb {i}: {unknown_entry('action', limb.drives, driven)}")
    _try(problems, require_finite, f"limb {i}: phase_rad", limb.phase_rad)
    return problems


def unknown_entry(what: str, name: str, known: Sequence[str]) -> TegotaeError:
    """The error for an entry that is not there; numbered entries have no nearest names."""
    if all(entry.startswith(f"{what}[") for entry in known):
        return TegotaeError(f"no {what} entry is called {name!r}; known: {', '.join(known)}")
    return unknown(f"{what} entry", name, known)


def _ends(
    env: gymnasium.Env[Any, Any], i: int, limb: Limb, entry: int, problems: list[str]
) -> tuple[float, float]:
    """The action at no force and at full force."""
    space = env.action_space
    assert isinstance(space, Box)
    low, high = float(space.low[entry]), float(space.high[entry])
    rest = 0.5 * (low + high) if limb.rest is None else limb.rest
    push = high if limb.push is None else limb.push
    for name, value in (("rest", rest), ("push", push)):
        if not np.isfinite(value):
            problems.append(
                f"limb {i}: {limb.drives!r} has no bounds to take {name} from; give {name}="
            )
        elif not low <= value <= high:
            problems.append(
                f"limb {i}: {name} is {value:g}; {limb.drives!r} takes {low:g} to {high:g}"
            )
    if rest == push:
        problems.append(f"limb {i}: rest and push are both {rest:g}, so that no push has an effect")
    return rest, push


def _run(env: gymnasium.Env[Any, Any], wiring: Wiring, steps: int, seed: int) -> list[str]:
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
        if name is None:
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


def _try(problems: list[str], check: Any, *arguments: Any, **options: Any) -> None:
    try:
        check(*arguments, **options)
    except TegotaeError as error:
        problems.append(str(error))
