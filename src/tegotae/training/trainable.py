"""What a training asks of an experiment, wherever its episodes take place."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from tegotae._support.documents import JsonObject
from tegotae.parts.controller import Controller
from tegotae.systems.env_task import EnvTask
from tegotae.systems.system import System


class Trainable(Protocol):
    """An experiment on the engine (`tegotae.systems.experiment`), or on an environment."""

    @property
    def name(self) -> str:
        """What it is called, in files, tables and figures."""
        ...

    @property
    def controller(self) -> Controller:
        """The structure whose weights are learned."""
        ...

    @property
    def omega(self) -> float | None:
        """Prescribed frequency [rad/s]; None without an oscillator."""
        ...

    @property
    def system(self) -> System:
        """The closed loop, as controller files have it."""
        ...

    @property
    def task(self) -> EnvTask | None:
        """The task on an environment; None on the engine."""
        ...

    @property
    def document(self) -> JsonObject:
        """The experiment as plain JSON values."""
        ...

    @property
    def episodes(self) -> int:
        """How many episodes each candidate has."""
        ...

    @property
    def duration_s(self) -> float:
        """Length of an episode [s], if nothing ends it before."""
        ...

    @property
    def cot_unit(self) -> str:
        """The unit of CoT⁻¹ in which its fitness measures it."""
        ...

    @property
    def is_searched(self) -> bool:
        """Whether all there is to learn is a constant gain, which a search finds."""
        ...

    @property
    def gains(self) -> np.ndarray:
        """The gains that such a search tries."""
        ...

    def check(self) -> None:
        """Raise `TegotaeError` if it cannot be trained."""
        ...
