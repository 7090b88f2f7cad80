"""A log of a training for TensorBoard."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

from tegotae._support.errors import require
from tegotae.training.learner import TrainingState


def tensorboard_log(out: Path) -> Callable[[TrainingState], None]:
    """Return a function that logs the points of a step, into a folder that is there by then.

    Args:
        out: folder of the training.

    Raises:
        TegotaeError: at once, if tensorboardX is not installed.
    """
    tensorboard = require("tensorboardX", "tensorboard")

    @cache
    def writer() -> Any:
        return tensorboard.SummaryWriter(str(out / "tensorboard"))

    def log(step: TrainingState) -> None:
        for point in step.new:
            for name, value in point._asdict().items():
                if name not in ("seed", "step") and not math.isnan(value):
                    writer().add_scalar(f"{name}/seed{point.seed}", value, round(point.step))
        writer().flush()

    return log
