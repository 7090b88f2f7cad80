"""What a family is: one way to control the legs of any legged system."""

from __future__ import annotations

from abc import ABC, abstractmethod

from tegotae._support.errors import TegotaeError, unknown
from tegotae.parts.bodies import Body
from tegotae.parts.controller import Controller
from tegotae.systems.legged import Legged


class Family(ABC):
    """A way to control a legged system: a frozen dataclass of what is learned, from what.

    What is not learned is as the system has it: its actuation, its oscillator. All legs have the
    same weights.
    """

    @property
    @abstractmethod
    def name(self) -> str:
        """Its part of a design's name, such as `ART-rF-tphif`."""

    @property
    @abstractmethod
    def about(self) -> str:
        """Its meaning, in a line."""

    @property
    def has_rhythm(self) -> bool:
        """Whether it has oscillators, and so a frequency."""
        return True

    @abstractmethod
    def controller(self, legged: Legged, budget: int) -> Controller:
        """The controller of a system, with as many weights as the budget allows.

        Raises:
            TegotaeError: for a budget too small, or a system that does not sense what is read.
        """


def require_system(legged: Legged) -> Legged:
    """The system itself, with oscillators and Tegotae feedback to learn from.

    Raises:
        TegotaeError: for one without.
    """
    if legged.controller.oscillator is None or legged.controller.tegotae is None:
        raise TegotaeError(
            "a design replaces the terms of a system's Tegotae controller, and this one has none"
        )
    return legged


OBSERVATIONS = {
    "F": "the leg's load",
    "Fv": "its load and how fast it changes",
    "Fa": "its load and the body's pitch and roll",
}
"""The short names, and what they stand for."""
_RATES = ("spring_force_rate", "velocity")
_ANGLES = ("pitch", "roll")


def of_leg(observation: str, body: Body) -> tuple[str, ...]:
    """The names of what each leg senses by itself.

    Args:
        observation: "F", "Fv" or "Fa".
        body: whose senses they are. The rate of the load is that of its spring, or the velocity of
            the hip where the body senses that.

    Raises:
        TegotaeError: for another observation, or one that the body does not sense.

    Example:
        >>> from tegotae.parts.bodies import Plate, Walker
        >>> of_leg("Fv", Walker()), of_leg("Fv", Plate())
        (('spring_force', 'spring_force_rate'), ('spring_force', 'velocity'))
    """
    if observation not in OBSERVATIONS:
        raise unknown("observation", observation, OBSERVATIONS)
    rates = [name for name in _RATES if name in body.SENSES][:1] if observation == "Fv" else []
    return _sensed(("spring_force", *rates), body, observation, rates or observation != "Fv")


def of_body(observation: str, body: Body) -> tuple[str, ...]:
    """The names of what is the same for all legs: the body's angles, if they are observed.

    Args:
        observation: what is observed, such as "F" or "Fa".
        body: the body.

    Example:
        >>> from tegotae.parts.bodies import Bar
        >>> of_body("Fa", Bar()), of_body("F", Bar())
        (('pitch',), ())
    """
    angles = [name for name in _ANGLES if name in body.SENSES] if observation == "Fa" else []
    return _sensed(tuple(angles), body, observation, angles or observation != "Fa")


def all_of(observation: str, body: Body) -> tuple[str, ...]:
    """What a leg's own network is given: what the leg senses, and what the body does.

    Args:
        observation: what is observed, such as "F" or "Fa".
        body: the body.
    """
    return (*of_leg(observation, body), *of_body(observation, body))


def _sensed(names: tuple[str, ...], body: Body, observation: str, found: object) -> tuple[str, ...]:
    if not found or not set(names) <= set(body.SENSES):
        raise TegotaeError(
            f"a {type(body).__name__} does not sense {OBSERVATIONS[observation]} ({observation}); "
            f"it senses {', '.join(body.SENSES)}"
        )
    return names
