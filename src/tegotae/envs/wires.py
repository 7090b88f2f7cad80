"""A wiring looked up in an environment: names become places in arrays, or faults are reported;
and whether what is wired there looks as it should."""

from __future__ import annotations

import dataclasses
from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np
from gymnasium.spaces import Box

from tegotae._support.errors import TegotaeError, require_finite, unknown
from tegotae.envs._types import AnyEnv
from tegotae.envs.contact import action_names, flat, observation_names, with_contact
from tegotae.envs.wiring import Limb, Wiring, misnamed_scales, read_by
from tegotae.parts.controller import Controller
from tegotae.parts.terms import Network


class WiringWarning(UserWarning):
    """Something that a wiring leaves to a default, or wires to a stand-in."""


@dataclass(frozen=True)
class Wires:
    """A wiring that has been looked up in an environment."""

    controller: Controller
    """Of all limbs."""
    sensed: dict[str, tuple[np.ndarray, np.ndarray]]
    """For each signal, the observation's entry of each limb and its sign, shape [limbs] each."""
    driven: np.ndarray
    """The action's entries of each limb, shape [commands, limbs]."""
    free: np.ndarray
    """Entries of the action that no limb drives."""
    rest: np.ndarray
    """Action at no force, shape [limbs]."""
    push: np.ndarray
    """Action at full force, shape [limbs]."""
    low: np.ndarray
    """Least action, [entries]."""
    high: np.ndarray
    """Largest action, [entries]."""
    step_s: float
    """Time between two steps [s]."""
    observed: tuple[str, ...]
    """Names of the observation's entries."""

    @property
    def limbs(self) -> int:
        """How many limbs there are."""
        return self.driven.shape[1]


def controller_of(wiring: Wiring) -> Controller:
    """The controller of all limbs: a unit each, with weights in common or of their own.

    Raises:
        TegotaeError: for a controller of another number of limbs.
    """
    limbs, own = len(wiring.limbs), wiring.controller
    if own.limbs == limbs:
        return own
    if own.limbs != 1:
        raise TegotaeError(
            f"the controller has {own.limbs} units and the wiring {limbs} limbs; give one unit a "
            "limb, or a controller of one limb, which each of them then has"
        )
    free = wiring.weights is not None and np.ndim(wiring.weights) == 2
    return dataclasses.replace(own, limbs=limbs, sharing=tuple(range(limbs)) if free else None)


def weights_of(wiring: Wiring) -> tuple[np.ndarray, list[str]]:
    """The weights as one vector of the controller of all limbs, and what is wrong with them."""
    if wiring.weights is None:
        return np.zeros(0), ["the wiring has no weights; train it, or give weights="]
    own, limbs = wiring.controller.n_weights, len(wiring.limbs)
    weights = np.asarray(wiring.weights, np.float32)
    shapes = [(own,)] if wiring.controller.limbs > 1 else [(own,), (limbs, own)]
    if weights.shape not in shapes:
        return weights, [
            f"the weights have shape {weights.shape}; this controller needs "
            f"{' or '.join(map(str, shapes))}"
        ]
    if not np.isfinite(weights).all():
        return weights, ["the weights are not all finite"]
    return weights.ravel(), []


def look_up(env: AnyEnv, wiring: Wiring) -> tuple[Wires | None, list[str]]:
    """The wires, or what stands in their way; weights and frequency apart."""
    problems: list[str] = []
    try:
        observed = _names("observation", wiring.observation_names, observation_names(env))
        driven = _names("action", wiring.action_names, action_names(env))
    except TegotaeError as error:
        return None, [str(error)]
    limbs = list(wiring.limbs)
    if not limbs:
        problems.append("there are no limbs; name at least one Limb(senses=..., drives=...)")
    reads = _reads(wiring.controller, problems)
    commands = wiring.controller.actuation.COMMANDS
    for i, limb in enumerate(limbs):
        problems += _limb_problems(i, limb, reads, observed, driven, commands)
        if wiring.weights is not None:  # one that is yet to be trained may offer more
            problems += _unread(i, limb, reads)
    entries = [name for limb in limbs for name in limb.entries]
    for name in sorted(set(entries)):
        if entries.count(name) > 1:
            problems.append(f"several limbs drive {name!r}; an action entry takes one limb")
    for what in ("height", "work", "work_positive", "work_net"):
        name = getattr(wiring, what)
        if name is not None and name not in observed:
            problems.append(f"{what}: {unknown_entry('observation', name, observed)}")
    step_s = getattr(env.unwrapped, "dt", None) if wiring.step_s is None else wiring.step_s
    if step_s is None:
        problems.append("the environment has no dt; give the time between two steps as step_s [s]")
    problems += _number_problems(wiring, step_s)
    problems += misnamed_scales(wiring.scales, [*reads, "feedback"])
    controller = wiring.controller
    if limbs:
        try:
            controller = controller_of(wiring)
        except TegotaeError as error:
            problems.append(str(error))
    if problems or step_s is None:
        return None, problems
    space = env.action_space
    assert isinstance(space, Box)
    at = np.array([[driven.index(limb.entries[c]) for limb in limbs] for c in range(len(commands))])
    places = not controller.actuation.commands_force
    ends = [(0.0, 1.0) if places else _ends(space, i, limb, int(at[0, i]), problems)
            for i, limb in enumerate(limbs)]  # fmt: skip
    if problems:
        return None, problems
    wires = Wires(
        controller=controller,
        sensed={signal: _places(limbs, signal, observed) for signal in reads},
        driven=at,
        free=np.array([k for k in range(len(driven)) if k not in at], np.intp),
        rest=np.array([rest for rest, _ in ends]),
        push=np.array([push for _, push in ends]),
        low=space.low,
        high=space.high,
        step_s=float(step_s),
        observed=tuple(observed),
    )
    return wires, []


def unknown_entry(what: str, name: str, known: Sequence[str]) -> TegotaeError:
    """The error for an entry that is not there; numbered entries have no nearest names."""
    if all(entry.startswith(f"{what}[") for entry in known):
        return TegotaeError(f"no {what} entry is called {name!r}; known: {', '.join(known)}")
    return unknown(f"{what} entry", name, known)


def _places(
    limbs: Sequence[Limb], signal: str, observed: Sequence[str]
) -> tuple[np.ndarray, np.ndarray]:
    """Of every limb the observation's entry that is this signal, and its sign."""
    names = [limb.senses[signal] for limb in limbs]
    sign = [-1.0 if name not in observed else 1.0 for name in names]
    at = [observed.index(name if name in observed else name[1:]) for name in names]
    return np.array(at), np.array(sign)


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
    return read_by(controller)


def _limb_problems(
    i: int,
    limb: Limb,
    reads: Sequence[str],
    observed: Sequence[str],
    driven: Sequence[str],
    commands: Sequence[str],
) -> list[str]:
    problems = []
    for signal in reads:
        if signal not in limb.senses:
            problems.append(
                f"limb {i}: the controller reads {signal!r}; say in senses which observation entry "
                "that is"
            )
    for name in limb.senses.values():
        if name not in observed and name.removeprefix("-") not in observed:
            problems.append(f"limb {i}: {unknown_entry('observation', name, observed)}")
    if len(limb.entries) != len(commands):
        problems.append(
            f"limb {i} drives {', '.join(limb.entries) or 'nothing'}; the controller commands "
            f"{' and '.join(commands)}, one action entry each"
        )
    for name in limb.entries:
        if name not in driven:
            problems.append(f"limb {i}: {unknown_entry('action', name, driven)}")
    _try(problems, f"limb {i}: phase_rad", limb.phase_rad)
    return problems


def _unread(i: int, limb: Limb, reads: Sequence[str]) -> list[str]:
    return [
        f"limb {i}: no term of the controller reads {signal!r}; it reads {', '.join(reads)}"
        for signal in limb.senses
        if signal not in reads
    ]


def _number_problems(wiring: Wiring, step_s: float | None) -> list[str]:
    problems: list[str] = []
    numbers = {
        "omega": wiring.omega,
        "step_s": step_s,
        "max_force": wiring.max_force,
        "max_feedback_rad_per_s": wiring.max_feedback_rad_per_s,
        "rest_length_m": wiring.rest_length_m,
        **{f"scales[{name!r}]": scale for name, scale in wiring.scales.items()},
    }
    for name, value in numbers.items():
        if value is not None:
            _try(problems, name, value, 0.0)
    return problems


def _ends(space: Box, i: int, limb: Limb, entry: int, problems: list[str]) -> tuple[float, float]:
    """The action at no force and at full force."""
    low, high = float(space.low[entry]), float(space.high[entry])
    rest = 0.5 * (low + high) if limb.rest is None else limb.rest
    push = high if limb.push is None else limb.push
    for name, value in (("rest", rest), ("push", push)):
        if not np.isfinite(value) and getattr(limb, name) is not None:
            problems.append(f"limb {i}: {name} is {value}; it must be finite")
        elif not np.isfinite(value):
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


def _try(problems: list[str], name: str, value: float, above: float | None = None) -> None:
    try:
        require_finite(name, value, above=above)
    except TegotaeError as error:
        problems.append(str(error))


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


def remarks(wiring: Wiring, contacts: Collection[str] = ()) -> list[str]:
    """What should be known of a wiring that could be used as it is: one plain sentence each.

    Args:
        wiring: the wiring.
        contacts: names of the observation entries that are contact forces (`contact_names`).

    Example:
        >>> from tegotae.envs import Limb
        >>> limb = Limb(senses={"spring_force": "foot_force"}, drives="knee")
        >>> for remark in remarks(Wiring(limbs=[limb]), ["foot_force"]):
        ...     print(remark)
        'foot_force' stands in for F_k: it is the whole contact force, with damper, actuator and \
impacts, where the paper's law feels the spring alone
    """
    found = []
    felt = sorted({limb.senses.get("spring_force", "") for limb in wiring.limbs} & {*contacts})
    if felt:
        named = ", ".join(map(repr, felt[:4]))
        found.append(
            f"{named} stand{'s' if len(felt) == 1 else ''} in for F_k: it is the whole contact "
            "force, with damper, actuator and impacts, where the paper's law feels the spring alone"
        )
    networks = [t for t in wiring.controller.terms.values() if isinstance(t, Network)]
    seen = {name for term in networks for name in term.reads} - {"sin_phase", "cos_phase"}
    if unscaled := sorted(seen - set(wiring.scales)):
        found.append(
            f"no scale is given for {', '.join(unscaled)}: networks see "
            f"{'it' if len(unscaled) == 1 else 'them'} over 1, whatever the body's size; "
            "give scales=, or take a MuJoCo model's with with_scales(env)"
        )
    return found
