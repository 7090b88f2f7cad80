"""Controllers that belong together: the weights that one training found, run by run."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from tegotae._support.documents import Json
from tegotae.measures.evaluation import Protocol
from tegotae.parts.bodies import Body
from tegotae.parts.controller import Controller
from tegotae.systems.env_task import EnvTask
from tegotae.systems.experiment import Experiment
from tegotae.systems.system import System


@dataclass(frozen=True)
class ControllerSet:
    """A system with several vectors of weights, such as one per seed of a training.

    Args:
        name: the model's name, or the file's; of several trainings also what differs in this one.
        system: the closed loop that the runs share.
        weights: shape [runs, n_weights].
        labels: one per run: its seed, or its file's name.
        training: how they were trained, the same for all, as JSON values; empty if not known.
        experiment: what was trained, and how it is evaluated; None if not known.
        task: the same of limbs that another simulator moves.
    """

    name: str
    system: System
    weights: np.ndarray
    labels: tuple[str, ...]
    training: Mapping[str, Json] = field(default_factory=dict[str, Json])
    experiment: Experiment | None = None
    task: EnvTask | None = None

    @property
    def controller(self) -> Controller:
        """The structure that they share."""
        return self.system.controller

    @property
    def omega_t(self) -> float | None:
        """The frequency they were trained at [rad/s]; None without an oscillator."""
        return self.system.omega

    @property
    def body(self) -> Body:
        """The body they were trained on."""
        return self.system.mechanics

    def replaced(self, **changes: object) -> ControllerSet:
        """The same weights in another system: other fields of the system or its release.

        Raises:
            TegotaeError: for what does not fit together.
        """
        return dataclasses.replace(self, system=self.system.replaced(changes))

    @property
    def protocol(self) -> Protocol:
        """How its hopping is evaluated: as its experiment says, from its system's release.

        What is held over a control period keeps that period (`System.evaluated_by`).
        """
        own = Protocol() if self.experiment is None else self.experiment.protocol
        return self.system.evaluated_by(own)
