"""Blocks of lanes of a fixed size: no lane's arithmetic then depends on how many go with it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import jax
import numpy as np


def filled(tree: Any, lanes: slice, size: int) -> Any:
    """Some lanes of every array, with the last of them again until there are `size`.

    Args:
        tree: a pytree of arrays, lanes last.
        lanes: which of them.
        size: how many there are then.

    Example:
        >>> filled(np.arange(5), slice(3, 7), 4).tolist()
        [3, 4, 4, 4]
    """

    def block(x: np.ndarray) -> np.ndarray:
        part = x[..., lanes]
        if part.shape[-1] == size:
            return part
        more = np.broadcast_to(part[..., -1:], (*part.shape[:-1], size - part.shape[-1]))
        return np.concatenate([part, more], axis=-1)

    return jax.tree.map(block, tree)


def by_blocks(function: Callable[[Any], Any], lanes: Any, size: int) -> Any:
    """What a function makes of each block of lanes, put together: NumPy arrays, lanes last.

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
        function(filled(lanes, slice(first, first + size), size)) for first in range(0, count, size)
    ]
    return jax.tree.map(lambda *x: np.concatenate(x, axis=-1)[..., :count], *parts)
