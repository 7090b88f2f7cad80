"""A controller from elsewhere on the limbs of an environment, without training."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from tegotae.envs.env_spec import EnvSpec
from tegotae.envs.robot_file import load_robot
from tegotae.envs.wiring import Wiring
from tegotae.systems.controller_file import SavedController
from tegotae.training.environments.experiment import EnvExperiment
from tegotae.training.environments.objectives import Return

DURATION_S = 8.0
"""Duration of an episode [s]."""


def on_robot(saved: SavedController, robot: Path | str) -> SavedController:
    """Return a controller on the robot of a file.

    Args:
        saved: the controller.
        robot: the robot's file.

    Raises:
        TegotaeError: for a file that is no robot's, or a controller that does not fit on it.
    """
    name = f"{saved.name or 'mine'}-on-{Path(robot).stem}"
    return transferred(saved, *load_robot(robot), name=name)


def transferred(
    saved: SavedController,
    spec: EnvSpec,
    wiring: Wiring,
    *,
    name: str,
    omega: Sequence[float] = (),
    duration_s: float = DURATION_S,
) -> SavedController:
    """Return a controller on the limbs of an environment, in the units of its wiring.

    Args:
        saved: the controller.
        spec: the environment.
        wiring: the wiring of its limbs.
        name: name of the controller there.
        omega: frequencies of the oscillators [rad/s]; the controller's by default. With several an
            evaluation has an episode at each.
        duration_s: duration of an episode [s].

    Raises:
        TegotaeError: for a controller that does not fit there.
    """
    wiring = wiring.holding(saved)
    if len(omega) == 1:
        wiring = dataclasses.replace(wiring, omega=omega[0])
    experiment = EnvExperiment(
        name=name,
        spec=spec,
        wiring=dataclasses.replace(wiring, weights=None),
        objective=Return(),
        duration_s=duration_s,
        omegas=tuple(omega) if len(omega) > 1 else (),
        episodes=max(1, len(omega)),
    )
    experiment.check()
    return SavedController(
        experiment.system,
        np.ravel(np.asarray(wiring.weights, float)),
        name=name,
        task=experiment.task,
        training={"transferred_from": saved.name or name},
        software=saved.software,
    )
