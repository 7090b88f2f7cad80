"""A wiring looked up in an environment: names become places in arrays, or faults are reported;
and whether what is wired there looks as it should."""

from __future__ import annotations

import dataclasses
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from gymnasium.spaces import Box

from tegotae._support.errors import TegotaeError, require_finite, unknown
from tegotae.envs._types import AnyEnv
from tegotae.envs.contact import action_names, flat_observation, observation_names, with_contact
from tegotae.envs.wiring import NOTHING, Limb, Wiring, misnamed_scales, read_by
from tegotae.parts.controller import Controller
from tegotae.parts.terms import Network


class WiringWarning(UserWarning):
    """Something that a wiring leaves to a default, or wires to a stand-in."""


@dataclass(frozen=True)
class Wires:
    """A wiring that has been looked up in an environment."""

    controller: Controller
    """Controller of all limbs."""
    sensed: dict[str, tuple[np.ndarray, np.ndarray]]
    """For each signal, the observation's entry of each limb and its sign, shape [limbs] each."""
    driven: np.ndarray
    """The action's entries of each limb, shape [commands, limbs]."""
    free: np.ndarray
    """Entries of the action that no limb drives."""
    still: np.ndarray
    """Action at which the environment keeps its start, or else 0, shape [entries]."""
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
    force_limits: Mapping[str, tuple[float, float]]
    """Least and largest force of actuators by the observation's entry [N or N m], as far as the
    environment says them (`force_limits`)."""

    @property
    def limbs(self) -> int:
        """Number of limbs."""
        return self.driven.shape[1]

    def felt(self, signal: str, observed: np.ndarray) -> np.ndarray:
        """Return a signal of all limbs, [limbs, lanes], of observations [lanes, entries].

        What is below zero of a force counts as zero.
        """
        columns, sign = self.sensed[signal]
        felt = sign[:, None] * observed[:, columns].T
        return np.maximum(felt, 0.0) if signal == "spring_force" else felt


def controller_of_wiring(wiring: Wiring) -> Controller:
    """Return the controller of all limbs: one unit each, with weights in common or of their own.

    One whose units share their weights, and do not see each other, fits any number of limbs.

    Raises:
        TegotaeError: for a controller of another number of limbs, or one without an oscillator.
    """
    limbs, controller = len(wiring.limbs), wiring.controller
    if controller.oscillator is None:
        raise TegotaeError(
            "the controller has no oscillator; take one that has, such as V-sector-w8"
        )
    if controller.limbs == limbs:
        return controller
    if controller.sets > 1 or controller.coupling is not None:
        raise TegotaeError(
            f"the controller has {controller.limbs} units and the wiring {limbs} limbs; give one "
            "unit a limb, or a controller whose uncoupled units share their weights"
        )
    free = controller.limbs == 1 and wiring.weights is not None and np.ndim(wiring.weights) == 2
    return dataclasses.replace(
        controller, limbs=limbs, sharing=tuple(range(limbs)) if free else None, wiring=None
    )


def weights_of(wiring: Wiring) -> tuple[np.ndarray, list[str]]:
    """Return the weights as one vector of the controller of all limbs, and the problems that
    prevent their use.
    """
    if wiring.weights is None:
        return np.zeros(0), ["the wiring has no weights; train it, or give weights="]
    count, limbs = wiring.controller.n_weights, len(wiring.limbs)
    weights = np.asarray(wiring.weights, np.float32)
    shapes = [(count,)] if wiring.controller.limbs > 1 else [(count,), (limbs, count)]
    problems = []
    if weights.shape not in shapes:
        problems.append(
            f"the weights have shape {weights.shape}; this controller needs "
            f"{' or '.join(map(str, shapes))}"
        )
    elif not np.isfinite(weights).all():
        problems.append("the weights are not all finite")
    if wiring.omega is None:
        problems.append("the wiring has weights but no frequency; give omega= [rad/s]")
    return weights.ravel(), problems


def look_up(env: AnyEnv, wiring: Wiring) -> tuple[Wires | None, list[str]]:
    """Return the wires, or the problems that prevent them; weights and frequency apart."""
    limbs = list(wiring.limbs)
    try:
        observed = _names("observation", wiring.observation_names, observation_names(env))
        driven = _names("action", wiring.action_names, action_names(env))
        if not limbs:
            raise TegotaeError("there are no limbs; name at least one Limb(senses=..., drives=...)")
        controller = controller_of_wiring(wiring)
    except TegotaeError as error:
        return None, [str(error)]
    entries = {entry for limb in limbs for entry in limb.entries}
    if not entries & {*driven} and all(entry[-2:] in ("_x", "_y", "_z") for entry in entries):
        return None, [
            f"the wiring commands places of feet, such as {min(entries)}, and the environment's "
            "actions are of joints; add --settings legs=true"
        ]
    step_s = getattr(env.unwrapped, "dt", None) if wiring.step_s is None else wiring.step_s
    problems = [*_name_faults(wiring, observed, driven), *_number_faults(wiring, step_s)]
    if problems or step_s is None:
        return None, problems
    commands = range(len(controller.actuation.COMMANDS))
    columns = np.array([[driven.index(limb.entries[c]) for limb in limbs] for c in commands])
    rests, pushes = [limb.rest for limb in limbs], [limb.push for limb in limbs]
    space = env.action_space
    assert isinstance(space, Box)
    low, high = space.low[columns[0]].astype(float), space.high[columns[0]].astype(float)
    with np.errstate(invalid="ignore"):  # the middle of an entry without bounds
        middle = 0.5 * (low + high)
    rest = np.array([x if x is not None else middle[i] for i, x in enumerate(rests)], float)
    push = np.array([x if x is not None else high[i] for i, x in enumerate(pushes)], float)
    if controller.actuation.commands_force:
        problems = list(_end_faults(limbs, rest, push, low, high))
    if problems:
        return None, problems
    wires = Wires(
        controller=controller,
        sensed={name: _places(limbs, name, observed) for name in read_by(wiring.controller)},
        driven=columns,
        free=np.array([k for k in range(len(driven)) if k not in columns], np.intp),
        still=np.asarray(getattr(env.unwrapped, "still_action", np.zeros(len(driven)))),
        rest=rest,
        push=push,
        low=space.low,
        high=space.high,
        step_s=float(step_s),
        observed=tuple(observed),
        force_limits=getattr(env.unwrapped, "force_limits", {}),
    )
    return wires, []


def _unknown_entry(role: str, name: str, names: Sequence[str]) -> str:
    """Return the message about an unknown entry; numbered entries have no nearest names."""
    if all(entry.startswith(f"{role}[") for entry in names):
        return f"no {role} entry is called {name!r}; known: {', '.join(names)}"
    return str(unknown(f"{role} entry", name, names))


def _places(
    limbs: Sequence[Limb], signal: str, observed: Sequence[str]
) -> tuple[np.ndarray, np.ndarray]:
    """Return, for every limb, the observation's entry that is this signal, and its sign."""
    names = [limb.senses[signal] for limb in limbs]
    sign = [1.0 if name in observed else -1.0 if name != NOTHING else 0.0 for name in names]
    entries = [name if name in observed else name.removeprefix("-") for name in names]
    return np.array([observed.index(x) if x != NOTHING else 0 for x in entries]), np.array(sign)


def _names(role: str, overrides: Sequence[str] | None, defaults: Sequence[str]) -> list[str]:
    names = list(defaults if overrides is None else overrides)
    if len(names) != len(defaults):
        raise TegotaeError(
            f"there are {len(names)} {role} names for {len(defaults)} entries; give one per entry"
        )
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise TegotaeError(f"several {role} entries are called {twice[0]!r}; names must differ")
    return names


def _name_faults(wiring: Wiring, observed: Sequence[str], driven: Sequence[str]) -> Iterator[str]:
    """List faults in the names of the quantities that limbs sense and drive, or that are
    measured.
    """
    reads, commands = read_by(wiring.controller), wiring.controller.actuation.COMMANDS
    for i, limb in enumerate(wiring.limbs):
        for signal in reads:
            if signal not in limb.senses:
                yield (
                    f"limb {i}: the controller reads {signal!r}; say in senses which observation "
                    "entry that is"
                )
        for signal, name in limb.senses.items():
            if name not in (*observed, NOTHING) and name.removeprefix("-") not in observed:
                yield f"limb {i}: {_unknown_entry('observation', name, observed)}"
            # A wiring that is yet to be trained may offer more.
            if wiring.weights is not None and signal not in reads:
                yield (
                    f"limb {i}: no term of the controller reads {signal!r}; it reads "
                    f"{', '.join(reads)}"
                )
        if len(limb.entries) != len(commands):
            yield (
                f"limb {i} drives {', '.join(limb.entries) or 'nothing'}; the controller commands "
                f"{' and '.join(commands)}, one action entry each"
            )
        for name in limb.entries:
            if name not in driven:
                yield f"limb {i}: {_unknown_entry('action', name, driven)}"
    entries = [name for limb in wiring.limbs for name in limb.entries]
    for name in sorted(set(entries)):
        if entries.count(name) > 1:
            yield f"several limbs drive {name!r}; an action entry takes one limb"
    for role in ("height", "work", "work_positive", "work_net"):
        name = getattr(wiring, role)
        if name is not None and name not in observed:
            yield f"{role}: {_unknown_entry('observation', name, observed)}"
    yield from misnamed_scales(wiring.scales, [*reads, "feedback"])


def _number_faults(wiring: Wiring, step_s: float | None) -> Iterator[str]:
    """List faults in the numbers."""
    if step_s is None:
        yield "the environment has no dt; give the time between two steps as step_s [s]"
    phases = {f"limb {i}: phase_rad": limb.phase_rad for i, limb in enumerate(wiring.limbs)}
    positive = {
        "omega": wiring.omega,
        "step_s": step_s,
        "max_force": wiring.max_force,
        "max_feedback_rad_per_s": wiring.max_feedback_rad_per_s,
        "rest_length_m": wiring.rest_length_m,
        **{f"scales[{name!r}]": scale for name, scale in wiring.scales.items()},
    }
    for name, value in {**phases, **positive}.items():
        try:
            if value is not None:
                require_finite(name, value, above=None if name in phases else 0.0)
        except TegotaeError as error:
            yield str(error)


def _end_faults(
    limbs: Sequence[Limb], rest: np.ndarray, push: np.ndarray, low: np.ndarray, high: np.ndarray
) -> Iterator[str]:
    """List faults in the actions at no force and at full force."""
    for i, limb in enumerate(limbs):
        for name, value in (("rest", rest[i]), ("push", push[i])):
            if not np.isfinite(value) and getattr(limb, name) is not None:
                yield f"limb {i}: {name} is {value}; it must be finite"
            elif not np.isfinite(value):
                yield f"limb {i}: {limb.drives!r} has no bounds to take {name} from; give {name}="
            elif not low[i] <= value <= high[i]:
                yield (
                    f"limb {i}: {name} is {value:g}; {limb.drives!r} takes {low[i]:g} to "
                    f"{high[i]:g}"
                )
        if rest[i] == push[i]:
            yield f"limb {i}: rest and push are both {rest[i]:g}, so that no push has an effect"


def check_wiring(env: AnyEnv, wiring: Wiring, *, steps: int = 200, seed: int = 0) -> list[str]:
    """Return the problems of a wiring on this environment, one plain sentence each.

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
    _, problems = look_up(env, wiring)
    if wiring.weights is not None:
        problems += weights_of(wiring)[1]
    return problems if problems or steps <= 0 else _run(env, wiring, steps, seed)


def _run(env: AnyEnv, wiring: Wiring, steps: int, seed: int) -> list[str]:
    """Take random actions, to see whether the contact forces look plausible."""
    names = list(wiring.observation_names or observation_names(env))
    contacts = [limb.senses.get("spring_force") for limb in wiring.limbs]
    env.action_space.seed(seed)
    observation, _ = env.reset(seed=seed)
    rows = []
    for _ in range(steps):
        rows.append(flat_observation(env.observation_space, observation))
        observation, _, terminated, truncated, _ = env.step(env.action_space.sample())
        if terminated or truncated:
            observation, _ = env.reset()
    observations = np.array(rows)
    problems = []
    for i, name in enumerate(contacts):
        # Below zero, what is turned or a spring's counts as zero.
        if name is None or name not in names or name.endswith("_spring"):
            continue
        force = observations[:, names.index(name)]
        subject = (
            f"limb {i}: {name!r} does not look like a contact force: in {steps} random steps it"
        )
        if not np.isfinite(force).all():
            problems.append(f"{subject} was not finite")
        elif (force < 0.0).any():
            problems.append(f"{subject} was negative ({force.min():g})")
        elif (force == 0.0).all():
            problems.append(f"{subject} never left zero")
        elif (force > 0.0).all():
            problems.append(f"{subject} was never zero")
    return problems


def remarks(wiring: Wiring, contacts: Collection[str] = ()) -> list[str]:
    """List remarks on a wiring that is valid but may not be meant: one plain sentence each.

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
    sentences = []
    felt = sorted({limb.senses.get("spring_force", "") for limb in wiring.limbs} & {*contacts})
    if felt:
        names = ", ".join(map(repr, felt[:4]))
        sentences.append(
            f"{names} stand{'s' if len(felt) == 1 else ''} in for F_k: it is the whole contact "
            "force, with damper, actuator and impacts, where the paper's law feels the spring alone"
        )
    networks = [t for t in wiring.controller.terms.values() if isinstance(t, Network)]
    signals = {name for term in networks for name in term.reads} - {"sin_phase", "cos_phase"}
    if unscaled := sorted(signals - set(wiring.scales)):
        sentences.append(
            f"no scale is given for {', '.join(unscaled)}: networks see "
            f"{'it' if len(unscaled) == 1 else 'them'} over 1, whatever the body's size; "
            "give scales=, or take a MuJoCo model's with with_scales(env)"
        )
    return sentences
