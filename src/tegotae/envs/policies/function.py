"""A Python function as a policy: the names of its arguments are what it observes."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from tegotae._support.errors import TegotaeError
from tegotae.envs.policies.base import Meaning, Policy

ARGUMENTS = {
    "phase_rad": "phase",
    "spring_force_n": "spring_force",
    "velocity_m_per_s": "velocity",
    "height_m": "height",
}
"""What a function may ask for, and which observation it is."""


def from_function(
    function: Callable[..., Any], meaning: Meaning | None = None, *, name: str = ""
) -> Policy:
    """A function of some of phase, spring force, velocity and height, in SI units, as a policy.

    Its answer is the actuator force [N], or, where `meaning.acts` is "feedback", the feedback
    [rad/s]. It is given arrays; one that takes single numbers alone is asked number by number.

    Args:
        function: with arguments of the names in `ARGUMENTS`, in any order.
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
        asked = tuple(inspect.signature(function).parameters)
    except (TypeError, ValueError):
        raise TegotaeError(f"{name} does not say which arguments it has") from None
    strange = [argument for argument in asked if argument not in ARGUMENTS]
    if strange or not asked:
        raise TegotaeError(
            f"{name} asks for {', '.join(strange) or 'nothing'}; the arguments of a policy are "
            f"{', '.join(ARGUMENTS)}, any of them"
        )
    meaning = Meaning() if meaning is None else meaning
    observes = tuple(ARGUMENTS[argument] for argument in asked)
    if meaning.observes and set(meaning.observes) != set(observes):
        raise TegotaeError(
            f"{name} is declared to observe {', '.join(meaning.observes)}, and its arguments say "
            f"{', '.join(observes)}; leave out what it observes"
        )
    meaning = replace(
        meaning,
        observes=observes,
        dimensionless=False,
        scale=1.0 if meaning.scale is None else meaning.scale,
    )

    def answer(observed: np.ndarray) -> np.ndarray:
        given = _arguments(asked, observed)
        try:
            answer = np.asarray(function(**given), float)
        except (TypeError, ValueError):
            return np.array([float(function(**_one(given, i))) for i in range(len(observed))])
        return np.broadcast_to(answer, (len(observed),)) if answer.ndim == 0 else answer

    return Policy(answer, meaning, name)


def _arguments(asked: tuple[str, ...], observed: np.ndarray) -> dict[str, np.ndarray]:
    """The function's arguments of the observation's columns."""
    columns = iter(np.asarray(observed, float).T)
    given = {}
    for argument in asked:
        if argument == "phase_rad":
            sine, cosine = next(columns), next(columns)
            given[argument] = np.arctan2(sine, cosine) % (2.0 * np.pi)
        else:
            given[argument] = next(columns)
    return given


def _one(given: dict[str, np.ndarray], number: int) -> dict[str, float]:
    return {name: float(column[number]) for name, column in given.items()}
