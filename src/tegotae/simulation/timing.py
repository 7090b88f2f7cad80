"""The timing of a rollout, and lanes in blocks of one compiled size."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import jax
import numpy as np

from tegotae._support.errors import TegotaeError
from tegotae.parts.parameters import Part, positive


def padded_lanes(tree: Any, lanes: slice, size: int) -> Any:
    """Pad every array to `size` lanes with repeats of the last.

    Args:
        tree: a pytree of arrays, lanes last.
        lanes: which of them.
        size: how many there are then.

    Example:
        >>> padded_lanes(np.arange(5), slice(3, 7), 4).tolist()
        [3, 4, 4, 4]
    """

    def block(x: np.ndarray) -> np.ndarray:
        part = x[..., lanes]
        if part.shape[-1] == size:
            return part
        padding = np.broadcast_to(part[..., -1:], (*part.shape[:-1], size - part.shape[-1]))
        return np.concatenate([part, padding], axis=-1)

    return jax.tree.map(block, tree)


def by_blocks(function: Callable[[Any], Any], lanes: Any, size: int) -> Any:
    """Apply a function to blocks of lanes and concatenate its results: NumPy arrays, lanes last.

    Args:
        function: of a block of `size` lanes to a pytree of arrays, lanes last.
        lanes: a pytree of arrays, lanes last.
        size: of a block.

    Example:
        >>> by_blocks(lambda x: x + 1, np.arange(5), 4).tolist()
        [1, 2, 3, 4, 5]
    """
    count = jax.tree.leaves(lanes)[0].shape[-1]
    # All at once: XLA goes on with the next one while one is being computed.
    parts = [
        function(padded_lanes(lanes, slice(first, first + size), size))
        for first in range(0, count, size)
    ]
    return jax.tree.map(lambda *x: np.concatenate(x, axis=-1)[..., :count], *parts)


MOST_TICKS = 2**24
"""Control ticks of the longest rollout: up to here float32 counts them exactly."""


@dataclass(frozen=True, kw_only=True)
class Timing(Part):
    """Duration, time step and recording interval of a rollout.

    Raises:
        TegotaeError: for a period that is not positive and finite, a frame that is no multiple of
            the tick, or a duration shorter than a frame or longer than 2^24 ticks.
    """

    duration_s: float = positive(20.0)
    """Simulated time [s]; rounded to whole frames."""
    tick_s: float = positive(0.001)
    """Control period [s]."""
    frame_s: float = positive(0.02)
    """Recording period [s], a whole multiple of the tick."""

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.duration_s / self.tick_s > MOST_TICKS:
            raise TegotaeError(
                f"duration_s is {self.duration_s:g}; at {self.tick_s:g} s per control tick it must "
                f"be at most {MOST_TICKS * self.tick_s:g}"
            )
        ratio = self.frame_s / self.tick_s
        if abs(ratio - round(ratio)) > 1e-6 or round(ratio) < 1:
            raise TegotaeError(
                f"frame_s is {self.frame_s:g}; it must be a whole multiple of tick_s "
                f"({self.tick_s:g})"
            )
        if self.n_frames < 1:
            raise TegotaeError(
                f"duration_s is {self.duration_s:g}; it must be at least one frame "
                f"({self.frame_s:g} s)"
            )

    @property
    def ticks_per_frame(self) -> int:
        """Control ticks per recorded frame."""
        return round(self.frame_s / self.tick_s)

    @property
    def n_frames(self) -> int:
        """Number of recorded frames."""
        return round(self.duration_s / self.frame_s)
