"""A task: controllers where they are tried. A body with one leg, with several, or another simulator
is each a task, with the same questions and options of its own."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from os import PathLike
from typing import TYPE_CHECKING, Any, ClassVar, Literal, Self

import numpy as np
import pandas as pd

from tegotae._support.errors import TegotaeError
from tegotae.parts.bodies import Body
from tegotae.questions.answer import Answer, Column, RecordedRun
from tegotae.systems.controller_file import ControllerSet, SavedController
from tegotae.systems.legged import Legged

if TYPE_CHECKING:
    from tegotae.analysis.generalisation.disturbances import Tested

Work = Literal["absolute", "positive", "net"]
"""Definitions of an actuator's work."""
Subject = str | PathLike[str] | SavedController | Legged | ControllerSet
"""What a question is about: a name (`tegotae.systems.resolve`), or an object with weights."""


@dataclasses.dataclass(frozen=True)
class Task:
    """Controllers where they are tried.

    Its options are those of the subject; a caller changes single ones
    (`tegotae.questions.options.changed`).
    """

    what: ClassVar[str]
    """What they do, after their name."""
    runs: ControllerSet

    def simulate(self, options: Any) -> RecordedRun:
        """One run, closely."""
        raise NotImplementedError

    def evaluate(self, options: Any) -> Answer:
        """What is measured of all runs."""
        raise NotImplementedError

    def check(self, options: Any) -> None:
        """Raise `TegotaeError` before long work for what cannot be evaluated."""

    def alike(self, options: Any) -> Mapping[str, Any]:
        """What must be equal for two answers to be compared."""
        return {}

    def tested(self, starts: int) -> Tested:
        """The runs, ready to be disturbed (`tegotae.analysis.generalisation.disturbances`)."""
        from tegotae.analysis.generalisation.on_engine import ControllersUnderTest

        return ControllersUnderTest.of(self.runs, starts)

    def on(self, body: Body) -> Self:
        """The same controllers on another body."""
        return dataclasses.replace(self, runs=self.runs.replaced(body=body))

    @property
    def name(self) -> str:
        """Of the controllers."""
        return self.runs.name

    @property
    def weights(self) -> np.ndarray:
        """Of the one controller, shape [n_weights].

        Raises:
            TegotaeError: if there are several.
        """
        if len(self.runs.weights) > 1:
            raise TegotaeError(
                f"{self.name} holds {len(self.runs.weights)} controllers; name one of them"
            )
        return self.runs.weights[0]

    @property
    def sigma(self) -> float | None:
        """The gain of a vanilla controller [rad/(s N)]; None of any other."""
        one = self.runs.controller.has_a_gain_alone and len(self.runs.weights) == 1
        return float(self.runs.weights[0, 0]) if one else None

    def weights_at(self, sigma: float | None) -> np.ndarray:
        """The weights of the one controller, with another gain if it is vanilla.

        Raises:
            TegotaeError: for a gain of any other.
        """
        if sigma is None:
            return self.weights
        if self.sigma is None:
            raise TegotaeError(f"sigma belongs to vanilla controllers; {self.name} is none")
        return np.array([sigma])

    def answer(self, rows: Any, columns: tuple[Column, ...], options: Any, **more: Any) -> Answer:
        """What was measured of the runs, with what is known of them.

        Args:
            rows: columns by name, or a dict a row.
            columns: what was measured.
            options: of the question.
            more: fields of the answer.
        """
        runs, training = self.runs, self.runs.training
        drawn = (training.get("conditions") or [], training.get("episodes", 1))
        how = (runs.labels, runs.controller, training.get("algorithm"), drawn)
        table = pd.DataFrame(rows)
        table.insert(0, "controller", self.name)
        single = len(runs.labels) == 1 and runs.controller.has_a_gain_alone
        return Answer(
            table,
            tuple(column for column in columns if column.name in table),
            trained={self.name: how if "algorithm" in training else None},
            exact=frozenset([self.name] if single else []),
            settings={self.name: options},
            **more,
        )
