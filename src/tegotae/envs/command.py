"""Commands of a robot on legs: forward, to the left, and turning, now or over time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

import numpy as np

from tegotae._support.errors import TegotaeError, require_finite
from tegotae.parts.parameters import Part, finite

_COLUMNS = ("time_s", "forward_m_per_s", "left_m_per_s", "yaw_rate_rad_per_s")
_HEADING = "heading_rad"
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
        heading_rad: heading that it is to turn to and to hold, from that at the start; without one
            it holds the heading that follows from the yaw rate.

    Raises:
        TegotaeError: for what is no finite number.

    Example:
        >>> VelocityCommand(forward_m_per_s=0.6, yaw_rate_rad_per_s=0.3).numbers
        (0.6, 0.0, 0.3)
    """

    forward_m_per_s: float = finite(0.0)
    left_m_per_s: float = finite(0.0)
    yaw_rate_rad_per_s: float = finite(0.0)
    heading_rad: float | None = None

    @property
    def numbers(self) -> tuple[float, ...]:
        """Forward and left [m/s], yaw rate [rad/s], and heading [rad] where it has one."""
        heading = () if self.heading_rad is None else (self.heading_rad,)
        return self.forward_m_per_s, self.left_m_per_s, self.yaw_rate_rad_per_s, *heading


def heading_rate(error_rad: np.ndarray | float) -> np.ndarray:
    """Return the yaw rate that turns to a heading [rad/s]: 2 ψ the shorter way, at most 1.

    Args:
        error_rad: heading set-point less the heading, ψ.

    Example:
        >>> heading_rate(0.2).round(3).tolist(), heading_rate(6.0).round(3).tolist()
        (0.4, -0.566)
    """
    shortest = (np.asarray(error_rad) + np.pi) % (2.0 * np.pi) - np.pi
    return np.clip(_TURN_PER_S * shortest, -_TURN_RAD_PER_S, _TURN_RAD_PER_S)


@dataclass(frozen=True, eq=False)
class CommandSchedule:
    """Commands over time: each holds from its time on.

    Args:
        time_s: when each begins, ascending from 0 [s], [commands].
        numbers: forward, left [m/s] and yaw rate [rad/s], [commands, 1, 3], or lane by lane,
            [commands, lanes, 3]; with a heading set-point [rad], NaN where there is none, four.

    Example:
        >>> schedule = CommandSchedule.from_command([0.6, 0.0, 0.3])
        >>> schedule.commands_at(np.array([5.0]))[:, :3].tolist()
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
            command: a `VelocityCommand`; its three or four numbers; or a file with the columns
                `time_s`, `forward_m_per_s`, `left_m_per_s`, `yaw_rate_rad_per_s` and, where it has
                set-points, `heading_rad`, which may be empty.

        Raises:
            TegotaeError: for other numbers, or a file that has none or no such columns.
        """
        if isinstance(command, str | Path):
            return cls._of_file(Path(command))
        numbers = command.numbers if isinstance(command, VelocityCommand) else tuple(command)
        if len(numbers) not in (3, 4):
            raise TegotaeError(
                f"command is {numbers!r}; it must be three numbers, forward, left [m/s] and yaw "
                "rate [rad/s], a heading [rad] as a fourth, or a file FILE.csv"
            )
        for name, number in zip((*_COLUMNS[1:], _HEADING), numbers, strict=False):
            require_finite(f"{name} of the command", number)
        return cls(np.zeros(1), np.array([[numbers]], float))

    @classmethod
    def _of_file(cls, path: Path) -> CommandSchedule:
        import pandas as pd

        if path.suffix != ".csv":
            raise TegotaeError(f"command is {path}; a file of commands must end in .csv")
        try:
            frame = cast(Any, pd.read_csv(path))
            columns = [*_COLUMNS, *([_HEADING] if _HEADING in frame else [])]
            table = frame[columns].astype(float).to_numpy()
        except OSError as error:
            raise TegotaeError(f"cannot read {path}: {error.strerror}") from None
        except (KeyError, ValueError, pd.errors.ParserError):
            raise TegotaeError(
                f"{path} is no table of commands; its columns must be {', '.join(_COLUMNS)}, of "
                "numbers"
            ) from None
        time_s = table[:, 0]
        finite_rows = np.isfinite(table[:, : len(_COLUMNS)]).all() and not np.isinf(table).any()
        if not len(table) or not finite_rows or not (np.diff(time_s) > 0.0).all():
            raise TegotaeError(f"{path}: time_s must ascend, and all numbers be finite")
        if time_s[0] != 0.0:
            raise TegotaeError(f"{path}: time_s begins at {time_s[0]:g}; it must begin at 0")
        return cls(time_s, table[:, None, 1:])

    def commands_at(self, time_s: np.ndarray) -> np.ndarray:
        """Return the commands at times [s], [lanes]: forward, left, yaw rate and heading, NaN
        without one, [lanes, 4].
        """
        row = np.searchsorted(self.time_s, time_s, side="right") - 1
        lane = np.arange(len(row)) % self.numbers.shape[1]
        commands = np.full((len(row), len(_COLUMNS)), np.nan)
        commands[:, : self.numbers.shape[2]] = self.numbers[row, lane]
        return commands


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
