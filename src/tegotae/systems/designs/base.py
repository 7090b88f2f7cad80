"""What a family is: one way to control the legs of any legged system."""

from __future__ import annotations

from abc import ABC, abstractmethod

from tegotae._support.errors import TegotaeError
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
