"""Contract of what can be trained: an experiment on the engine, or on an environment."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np

from tegotae._support.documents import JsonObject
from tegotae.parts.controller import Controller
from tegotae.systems.env_documents import EnvTask
from tegotae.systems.system import System


class Trainable(Protocol):
    """Experiment that can be trained, wherever its episodes take place."""

    @property
    def name(self) -> str:
        """Name in files and tables."""
        ...

    @property
    def controller(self) -> Controller:
        """Structure whose weights are learned."""
        ...

    @property
    def omega(self) -> float | None:
        """Prescribed frequency [rad/s]; None without an oscillator."""
        ...

    @property
    def system(self) -> System:
        """Closed loop, as far as a controller file has it."""
        ...

    @property
    def task(self) -> EnvTask | None:
        """Environment of the training; None on the engine."""
        ...

    @property
    def duration_s(self) -> float:
        """Duration of an episode [s]."""
        ...

    @property
    def episodes(self) -> int:
        """Number of episodes of each candidate."""
        ...

    @property
    def is_searched(self) -> bool:
        """True if the only trained parameter is a constant gain σ, which a search finds."""
        ...

    @property
    def gains(self) -> np.ndarray:
        """Values of σ that a search tries [rad/(s N)]."""
        ...

    @property
    def searched_in(self) -> Sequence[Trainable]:
        """Experiments whose mean fitness a search for the gain maximises."""
        ...

    def without_frequency(self) -> Trainable:
        """Return the experiment as agents learn it, without a reward for a frequency."""
        ...

    @property
    def cot_unit(self) -> str:
        """Unit of CoT⁻¹."""
        ...

    @property
    def document(self) -> JsonObject:
        """Experiment as plain JSON values."""
        ...

    def check(self) -> None:
        """Raise `TegotaeError`, before long work starts, for an experiment that cannot be
        trained.
        """
        ...
