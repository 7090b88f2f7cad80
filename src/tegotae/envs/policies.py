"""Anyone's policy on the hopper: a function, a Stable-Baselines3 model, an ONNX file.

What a policy sees and does is a `Meaning`. With it any callable is a `Policy`, of which
`tegotae.analysis` makes surfaces and portraits, as of a controller.
"""

from __future__ import annotations

import inspect
import io
import json
import math
import re
import warnings
import zipfile
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from tegotae._support.errors import TegotaeError, other_code, require, require_known
from tegotae._support.files import require_short, require_small
from tegotae.envs.settings import Chosen, HopperSettings, TegotaeHopperSettings
from tegotae.parts.bodies import Hopper
from tegotae.parts.controller import Controller
from tegotae.parts.oscillators import PhaseOscillator
from tegotae.parts.parameters import Part, finite, positive
from tegotae.parts.terms import Signals
from tegotae.parts.terms.actuation import CommandedForce
from tegotae.systems.registry import is_reference, load_object

_TICK_S = 0.001
_ACTS = ("force", "feedback")
"""Meanings of an answer: the actuator force, or the feedback of an oscillator."""


class ClippedFeedbackWarning(UserWarning):
    """A policy's feedback is larger than what is passed on."""


@dataclass(frozen=True, kw_only=True)
class _ClockedHopperSettings(HopperSettings):
    """A hopper whose action is the actuator force, beside a clock `φ̇ = ω` that may be observed."""

    observation: tuple[str, ...] = ("phase", "spring_force")
    omega: Chosen = 8.0
    """Frequency ω of the clock [rad/s]."""
    phase_rad: Chosen = 0.0
    """Its phase at release [rad]."""

    CHOSEN = (*HopperSettings.CHOSEN, "omega", "phase_rad")

    @property
    def controller(self) -> Controller:
        """A clock, and the force as the one weight."""
        return Controller(CommandedForce(), PhaseOscillator())


@dataclass(frozen=True, kw_only=True)
class Meaning(Part):
    """Meaning of a policy's observations and answers.

    Args:
        acts: meaning of its answer: force of the actuator, or feedback f of `φ̇ = ω + f`, of which
            `actuation` makes the force.
        observes: its observations, in its order: `spring_force`, `velocity`, `height`, and `phase`
            as (sin φ, cos φ). By default those of the package's environment of this kind of action:
            `spring_force` and `velocity`, or `phase` and `spring_force`.
        si: observations are in N, m/s and m, and not relative to m g, √(g l0) and l0, as in the
            package's environments. A function always has these units.
        answer_scale: force [N] or feedback [rad/s] for an answer of 1; by default α or 40 rad/s,
            and 1 for a function.
        omega: frequency ω of the oscillator [rad/s], where there is one.
        actuation: actuation that makes a force of a feedback: sector, reflex or both.
        body: the hopper.
        step_s: time for which an answer is held [s], in whole ticks of 1 ms.

    Raises:
        TegotaeError: for an unknown kind, observation or actuation, or a number that cannot be.

    Example:
        >>> Meaning(acts="feedback").settings.observed
        ('sin_phase', 'cos_phase', 'spring_force')
    """

    acts: str = "force"
    observes: tuple[str, ...] = ()
    si: bool = False
    answer_scale: float | None = positive(None)
    omega: float = 8.0
    actuation: str = "sector"
    body: Hopper = field(default_factory=Hopper)
    step_s: float = finite(0.01, least=_TICK_S, most=0.02)

    def __post_init__(self) -> None:
        require_known("kind of action", self.acts, _ACTS)
        super().__post_init__()
        ticks = self.step_s / _TICK_S
        if abs(ticks - round(ticks)) > 1e-6:
            raise TegotaeError(
                f"step_s is {self.step_s:g}; it must be a whole number of ticks of {_TICK_S:g} s"
            )
        _ = self.settings  # which checks the rest

    @cached_property
    def settings(self) -> HopperSettings:
        """The environment in which the policy acts."""
        kind: type[HopperSettings] = HopperSettings
        fields: dict[str, Any] = {}
        if self.acts == "feedback":
            kind, fields = TegotaeHopperSettings, {"omega": self.omega, "actuation": self.actuation}
        elif "phase" in self.observes:
            kind, fields = _ClockedHopperSettings, {"omega": self.omega}
        if self.observes:
            fields["observation"] = self.observes
        return kind(
            body=self.body,
            dimensionless=not self.si,
            tick_s=_TICK_S,
            decimation=round(self.step_s / _TICK_S),
            **fields,
        )

    @property
    def with_phase(self) -> bool:
        """True if there is an oscillator."""
        return self.settings.controller.oscillator is not None


@dataclass(frozen=True)
class Policy:
    """A policy on a hopper.

    Args:
        answer: from observations [n, entries] to answers [n].
        meaning: what both are.
        name: for people.

    Example:
        >>> push_up = Policy(lambda seen: 0.5 * (seen[:, 1] > 0.0), Meaning(), "push up")
        >>> push_up.actions(np.array([[1.0, -2.0], [1.0, 2.0]]))
        array([0. , 0.5])
    """

    answer: Callable[[np.ndarray], ArrayLike]
    meaning: Meaning
    name: str = "policy"

    @property
    def controller(self) -> Controller:
        """The controller of its environment, whose only weight is the action."""
        return self.meaning.settings.controller

    @property
    def body(self) -> Hopper:
        """The hopper."""
        return self.meaning.body

    @property
    def omega(self) -> float | None:
        """Frequency ω of the oscillator [rad/s]; None without one."""
        return self.meaning.omega if self.meaning.with_phase else None

    def weights(self, signals: Signals) -> list[np.ndarray]:
        """Return the policy's answers to signals, as the one weight of the controller, [points]."""
        settings = self.meaning.settings
        read = signals.dimensionless if settings.dimensionless else signals.__getitem__
        observed = np.stack([np.asarray(read(name)) for name in settings.observed], axis=-1)
        return [self.actions(observed) * settings.action_scale]

    def actions(self, observed: np.ndarray) -> np.ndarray:
        """Return the policy's actions in [-1, 1] of its environment, shape [n].

        What is beyond is cut off: a force at what the actuator can do, and a feedback, which warns
        of it (`ClippedFeedbackWarning`), at 40 rad/s.

        Args:
            observed: shape [n, entries].

        Raises:
            TegotaeError: for answers of another number, or that are not finite.
        """
        with other_code(f"{self.name} failed on observations of shape {observed.shape}"):
            answer = np.asarray(self.answer(observed), float)
        if answer.size != len(observed):
            raise TegotaeError(
                f"{self.name} answers {len(observed)} observations by an array of shape "
                f"{answer.shape}; it must give one number for each"
            )
        answer = answer.reshape(len(observed))
        if not np.isfinite(answer).all():
            where = observed[int(np.argmin(np.isfinite(answer)))]
            raise TegotaeError(f"{self.name} answers no finite number to {where.tolist()}")
        limit = self.meaning.settings.action_scale
        scale = self.meaning.answer_scale
        actions = answer if scale is None else scale / limit * answer
        if self.meaning.acts == "feedback" and (np.abs(actions) > 1.0 + 1e-6).any():
            warnings.warn(
                f"{self.name} returns a feedback of more than {limit:g} rad/s, which is clipped",
                ClippedFeedbackWarning,
                stacklevel=2,
            )
        return np.clip(actions, -1.0, 1.0)


_ARGUMENTS = {
    "phase_rad": "phase",
    "spring_force_n": "spring_force",
    "velocity_m_per_s": "velocity",
    "height_m": "height",
}
"""Observation behind each argument that a function may have."""


def from_function(
    function: Callable[..., Any], meaning: Meaning | None = None, *, name: str = ""
) -> Policy:
    """Return a policy made from a function of phase, spring force, velocity and height, in SI
    units.

    Its answer is the actuator force [N], or, where `meaning.acts` is "feedback", the feedback
    [rad/s]. It is given arrays; one that takes single numbers alone is asked number by number.

    Args:
        function: with arguments of the names in `_ARGUMENTS`, in any order.
        meaning: what its answer is, frequency and body; what it observes is the function's to say.
            Its scale, 1 by default, multiplies the answer.
        name: for people; the function's own by default.

    Raises:
        TegotaeError: for an argument of another name, none at all, or a meaning that says that it
            observes something else.

    Example:
        >>> def reflex(phase_rad, spring_force_n):
        ...     return np.maximum(0.0, 2.0 * np.cos(phase_rad) * spring_force_n)
        >>> policy = from_function(reflex, Meaning(omega=5.0))
        >>> policy.meaning.settings.observed
        ('sin_phase', 'cos_phase', 'spring_force')
    """
    name = name or getattr(function, "__name__", type(function).__name__)
    try:
        arguments = tuple(inspect.signature(function).parameters)
    except (TypeError, ValueError):
        raise TegotaeError(f"{name} does not say which arguments it has") from None
    strange = [argument for argument in arguments if argument not in _ARGUMENTS]
    if strange or not arguments:
        raise TegotaeError(
            f"{name} asks for {', '.join(strange) or 'nothing'}; the arguments of a policy are "
            f"{', '.join(_ARGUMENTS)}, any of them"
        )
    meaning = Meaning() if meaning is None else meaning
    observes = tuple(_ARGUMENTS[argument] for argument in arguments)
    if meaning.observes and set(meaning.observes) != set(observes):
        raise TegotaeError(
            f"{name} is declared to observe {', '.join(meaning.observes)}, and its arguments say "
            f"{', '.join(observes)}; leave out what it observes"
        )
    scale = 1.0 if meaning.answer_scale is None else meaning.answer_scale

    def answer(observed: np.ndarray) -> np.ndarray:
        columns = iter(np.asarray(observed, float).T)
        values = {
            name: np.arctan2(next(columns), next(columns)) % (2.0 * np.pi)
            if name == "phase_rad"
            else next(columns)
            for name in arguments
        }
        try:
            answer = np.asarray(function(**values), float)
        except (TypeError, ValueError):  # of a function of single numbers
            answer = np.vectorize(function, otypes=[float])(**values)
        return np.broadcast_to(answer, (len(observed),)) if answer.ndim == 0 else answer

    return Policy(answer, replace(meaning, observes=observes, si=True, answer_scale=scale), name)


def load_policy(place: Any, meaning: Meaning | None = None) -> Policy:
    """Load the policy of a .zip of Stable-Baselines3, an .onnx file, or a function of your own
    file.

    Of a model of Stable-Baselines3 (SAC, PPO, TD3, DDPG, A2C) the deterministic policy is taken,
    and only its numbers are read: its file has pickled parts, too, which could run code. An ONNX
    network has one input [n, entries] of float32, and its first output is the answer, [n, 1].

    Args:
        place: a path, or `FILE.py:OBJECT` or `MODULE:OBJECT`, of a function or a `Policy`; or that
            function or policy itself.
        meaning: what it observes and does; what the environment tegotae/Hopper-v0 means by default.
            A `Policy` has its own.

    Raises:
        TegotaeError: for another ending, a file that is no policy, one that observes another number
            of numbers, or one with parts of its author's.
        MissingExtraError: without the package that reads the file.
    """
    path = Path(str(place))
    if path.suffix.lower() in _NETWORKS:
        answer, entries = network(path)
        meaning = Meaning() if meaning is None else meaning
        observed = meaning.settings.observed
        if entries not in (None, len(observed)):
            raise TegotaeError(
                f"{path} observes {entries} numbers, and it is declared to observe {len(observed)} "
                f"({', '.join(observed)}); name what it observes"
            )
        return Policy(answer, meaning, path.stem)
    policy, name = place, ""
    if isinstance(place, str | Path):
        if not is_reference(str(place)):
            raise TegotaeError(
                f"{place} is no policy: write a .zip of Stable-Baselines3, an .onnx file, or "
                "FILE.py:FUNCTION"
            )
        policy, name = load_object(str(place), object, "policy"), str(place).rpartition(":")[2]
    if isinstance(policy, Policy):
        return policy
    if not callable(policy):
        raise TegotaeError(f"{place} is no policy: a {type(policy).__name__} cannot be called")
    return from_function(policy, meaning, name=name)


Answers = Callable[[np.ndarray], ArrayLike]
"""Map from observations [n, entries] to answers [n], or [n, numbers]."""


def network(path: Path) -> tuple[Answers, int | None]:
    """Read a network from a file: its function, and its number of observed entries if the file has
    it.

    Args:
        path: a .zip of Stable-Baselines3, or an .onnx file.

    Raises:
        TegotaeError: for a file that is not there or no network.
        MissingExtraError: without the package that reads it.
    """
    require_short(path)
    if not path.is_file():
        raise TegotaeError(f"there is no file {path}")
    return _NETWORKS[path.suffix.lower()](path)


def _onnx(path: Path) -> tuple[Answers, int | None]:
    """Read a network from an .onnx file: its function, and its number of observed entries if
    fixed."""
    runtime = require("onnxruntime", "onnx")
    with other_code(f"{path} is no ONNX network"):
        session = runtime.InferenceSession(str(path), providers=["CPUExecutionProvider"])
    inputs = session.get_inputs()
    if len(inputs) != 1 or len(inputs[0].shape) != 2:
        shapes = ", ".join(f"{entry.name} {entry.shape}" for entry in inputs)
        raise TegotaeError(f"{path} takes {shapes}; it must take one input of shape [n, entries]")
    name, (batch, entries) = inputs[0].name, inputs[0].shape

    def answer(observed: np.ndarray) -> np.ndarray:
        rows = observed.astype(np.float32)
        if batch == 1:  # exported for one observation at a time
            return np.concatenate([session.run(None, {name: row[None]})[0] for row in rows])
        return session.run(None, {name: rows})[0]

    return answer, entries if isinstance(entries, int) else None


_MOST_BYTES = 2**28
"""Bytes that a network's file may unpack to, and that the network may have."""


def _stable_baselines(path: Path) -> tuple[Answers, int]:
    """Read the default policy of a model from a .zip: its function with the file's weights, and its
    number of observed entries."""
    try:
        with zipfile.ZipFile(path) as archive:
            require_small(map(archive.getinfo, ("data", "policy.pth")), _MOST_BYTES)
            document, weights = json.loads(archive.read("data")), archive.read("policy.pth")
        module = document["policy_class"]["__module__"]
        # PPO and A2C share a policy, and TD3 and DDPG another.
        algorithm = {"common": "PPO"}.get(part := module.split(".")[1], part.upper())
    except Exception as error:  # a flipped bit in a zip archive may raise nearly anything
        reason = (str(error).splitlines() or [type(error).__name__])[0]
        raise TegotaeError(f"{path} is no model of Stable-Baselines3: {reason}") from None
    if algorithm not in ("SAC", "PPO", "TD3") or not module.startswith("stable_baselines3."):
        raise TegotaeError(f"{path} holds a policy of {module}; known are SAC, PPO, TD3, DDPG, A2C")
    sb3 = require("stable_baselines3", "sb3")
    import torch

    settings = _settings(path, document["policy_kwargs"])
    if algorithm == "PPO":  # the others have it among these
        settings["use_sde"] = document["use_sde"]
    with other_code(f"{path} cannot be loaded as {algorithm}"):
        observes = _box("observes", document["observation_space"])
        acts = _box("acts by", document["action_space"])
        policy = getattr(sb3, algorithm).policy_aliases["MlpPolicy"](
            observes, acts, lambda _: 0.0, **settings
        )
        with zipfile.ZipFile(io.BytesIO(weights)) as archive:  # as torch writes it
            require_small(archive.infolist(), _MOST_BYTES)
        numbers = torch.load(io.BytesIO(weights), map_location="cpu", weights_only=True)
        policy.load_state_dict(numbers)

    def answer(observed: np.ndarray) -> np.ndarray:
        return policy.predict(observed.astype(np.float32), deterministic=True)[0]

    return answer, policy.observation_space.shape[0]


def _settings(path: Path, saved: dict[str, Any]) -> dict[str, Any]:
    """Return the settings of a policy: plain values, and the activation by its name; not its
    optimiser.
    """
    from torch import nn

    settings = {
        name: value
        for name, value in saved.items()
        if name[0] != ":" and not name.startswith("optimizer_")
    }
    units, limit = sum(map(abs, _numbers(settings))), math.isqrt(_MOST_BYTES // 4)
    if units > limit:  # and so more weights than could be in the file
        raise TegotaeError(
            f"{path} has a policy of {units} units; its layers must have at most {limit}, all "
            "together"
        )
    for name, value in settings.items():
        if isinstance(value, str):  # of an object, which is also there as a pickle
            activation = re.fullmatch(r"<class 'torch\.nn\.modules\.activation\.(\w+)'>", value)
            if activation is None:
                raise TegotaeError(
                    f"{path} has a policy with {name} {value}, which only code within the file "
                    "can restore; load the model in a function of your own, FILE.py:FUNCTION"
                )
            settings[name] = getattr(nn, activation[1])
    return settings


def _numbers(value: Any) -> list[int]:
    """Return all whole numbers in a JSON value.

    Example:
        >>> _numbers({"net_arch": {"pi": [64, 64]}, "n_critics": 2})
        [64, 64, 2]
    """
    if isinstance(value, dict | list):
        entries = value.values() if isinstance(value, dict) else value
        return [number for entry in entries for number in _numbers(entry)]
    return [value] if isinstance(value, int) else []


def _box(does: str, saved: dict[str, Any]) -> Any:
    """Return a space from the text of its limits."""
    from gymnasium.spaces import Box

    kind = saved.get(":type:", "")
    if not kind.endswith("spaces.box.Box'>") or len(saved["_shape"]) != 1:
        raise TegotaeError(
            f"it {does} {kind} of shape {saved.get('_shape')}; it must be one row of Box"
        )
    low, high = (np.array(saved[end].strip("[]").split(), np.float32) for end in ("low", "high"))
    return Box(low, high)


_NETWORKS = {".zip": _stable_baselines, ".onnx": _onnx}
"""Reader of a network's file, by its ending."""
