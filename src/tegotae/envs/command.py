"""Commands of a robot on legs: forward, to the left, and turning, now or over time."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

import numpy as np

from tegotae._support.errors import TegotaeError, require_finite
from tegotae.parts.parameters import Part, finite

_COLUMNS = ("time_s", "forward_m_per_s", "left_m_per_s", "yaw_rate_rad_per_s")
_TURN_PER_S = 2.0
"""Yaw rate per heading error [1/s]."""
_TURN_RAD_PER_S = 1.0
"""Largest yaw rate towards a heading [rad/s]."""


@dataclass(frozen=True, kw_only=True)
class VelocityCommand(Part):
    """Velocity that a robot is to have, in the axes of its trunk.

    Args:
        forward_m_per_s: forward; backward below zero.
        left_m_per_s: to the left.
        yaw_rate_rad_per_s: turning to the left.

    Raises:
        TegotaeError: for what is no finite number.

    Example:
        >>> VelocityCommand(forward_m_per_s=0.6, yaw_rate_rad_per_s=0.3).numbers
        (0.6, 0.0, 0.3)
    """

    forward_m_per_s: float = finite(0.0)
    left_m_per_s: float = finite(0.0)
    yaw_rate_rad_per_s: float = finite(0.0)

    @property
    def numbers(self) -> tuple[float, float, float]:
        """Forward and left [m/s], and yaw rate [rad/s]."""
        return self.forward_m_per_s, self.left_m_per_s, self.yaw_rate_rad_per_s

    @classmethod
    def to_heading(cls, heading_rad: float, current_rad: float, **speeds: float) -> VelocityCommand:
        """Return the command that turns to a heading, at most by 1 rad/s.

        Args:
            heading_rad: set-point.
            current_rad: heading of the robot.
            speeds: `forward_m_per_s` and `left_m_per_s`.

        Example:
            >>> VelocityCommand.to_heading(0.3, 0.1, forward_m_per_s=0.6).numbers
            (0.6, 0.0, 0.4)
        """
        error = math.remainder(heading_rad - current_rad, 2.0 * math.pi)
        rate = float(np.clip(_TURN_PER_S * error, -_TURN_RAD_PER_S, _TURN_RAD_PER_S))
        return cls(yaw_rate_rad_per_s=round(rate, 12), **speeds)


@dataclass(frozen=True, eq=False)
class CommandSchedule:
    """Commands over time: each holds from its time on.

    Args:
        time_s: when each begins, ascending from 0 [s], [commands].
        numbers: forward, left [m/s] and yaw rate [rad/s], [commands, 1, 3], or lane by lane,
            [commands, lanes, 3].

    Example:
        >>> schedule = CommandSchedule.from_command([0.6, 0.0, 0.3])
        >>> schedule.commands_at(np.array([5.0])).tolist()
        [[0.6, 0.0, 0.3]]
    """

    time_s: np.ndarray
    numbers: np.ndarray

    @classmethod
    def from_command(
        cls, command: Sequence[float] | str | Path | VelocityCommand
    ) -> CommandSchedule:
        """Return the schedule of one command, or of a CSV file of them.

        Args:
            command: a `VelocityCommand`; its three numbers; or a file with the
                columns `time_s`, `forward_m_per_s`, `left_m_per_s` and `yaw_rate_rad_per_s`.

        Raises:
            TegotaeError: for other numbers, or a file that has none or no such columns.
        """
        if isinstance(command, str | Path):
            return cls._of_file(Path(command))
        numbers = command.numbers if isinstance(command, VelocityCommand) else tuple(command)
        if len(numbers) != 3:
            raise TegotaeError(
                f"command is {numbers!r}; it must be three numbers, forward, left [m/s] and yaw "
                "rate [rad/s], or a file FILE.csv"
            )
        for name, number in zip(_COLUMNS[1:], numbers, strict=True):
            require_finite(f"{name} of the command", number)
        return cls(np.zeros(1), np.array([[numbers]], float))

    @classmethod
    def _of_file(cls, path: Path) -> CommandSchedule:
        import pandas as pd

        if path.suffix != ".csv":
            raise TegotaeError(f"command is {path}; a file of commands must end in .csv")
        try:
            table = cast(Any, pd.read_csv(path))[list(_COLUMNS)].astype(float).to_numpy()
        except OSError as error:
            raise TegotaeError(f"cannot read {path}: {error.strerror}") from None
        except (KeyError, ValueError, pd.errors.ParserError):
            raise TegotaeError(
                f"{path} is no table of commands; its columns must be {', '.join(_COLUMNS)}, of "
                "numbers"
            ) from None
        time_s = table[:, 0]
        if not len(table) or not np.isfinite(table).all() or not (np.diff(time_s) > 0.0).all():
            raise TegotaeError(f"{path}: time_s must ascend, and all numbers be finite")
        if time_s[0] != 0.0:
            raise TegotaeError(f"{path}: time_s begins at {time_s[0]:g}; it must begin at 0")
        return cls(time_s, table[:, None, 1:])

    def commands_at(self, time_s: np.ndarray) -> np.ndarray:
        """Return the commands at times [s], [lanes]: forward, left and yaw rate, [lanes, 3]."""
        row = np.searchsorted(self.time_s, time_s, side="right") - 1
        lane = np.arange(len(row)) % self.numbers.shape[1]
        return self.numbers[row, lane]


def over_feet(velocity: np.ndarray, feet_m: np.ndarray) -> np.ndarray:
    """Return the velocity of a trunk over each of its feet, v + ω × r.

    Args:
        velocity: forward, left [m/s] and yaw rate [rad/s], [lanes, 3].
        feet_m: r, forward and to the left of the trunk's origin [m], [feet, 2].

    Returns:
        Forward and to the left [m/s], [lanes, feet, 2].

    Example:
        >>> over_feet(np.array([[0.5, 0.0, 1.0]]), np.array([[0.2, 0.1]])).round(3).tolist()
        [[[0.4, 0.2]]]
    """
    ahead, beside = feet_m.T
    forward, aside, turning = velocity.T[:, :, None]
    return np.stack([forward - turning * beside, aside + turning * ahead], axis=-1)
