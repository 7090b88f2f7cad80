"""Weights of parts, and what each is called: in a controller file and in C."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import cast

import jax
import jax.numpy as jnp

from tegotae._support.documents import DamagedDocumentError, Json
from tegotae.parts._shapes import WeightVector
from tegotae.parts.parameters import Part

WeightName = tuple[str | int, ...]
"""Path of a weight: names, and indices from 0, such as ("neuron", 2, "bias")."""

_Tree = dict[str | int, object]
"""Intermediate tree of `nested`: objects by their steps, the lists not yet made."""


def numbered(count: int) -> tuple[WeightName, ...]:
    """Return the names for weights that have none: ("weight", 0), ("weight", 1) ..."""
    return tuple(("weight", i) for i in range(count))


class Weighted(Part):
    """A part with weights of its own, which are trained."""

    WEIGHTS: tuple[str, ...] = ()
    """Names of its weights, where they are always the same."""

    @property
    def n_weights(self) -> int:
        """Number of trained parameters."""
        return len(self.WEIGHTS)

    @property
    def weight_names(self) -> tuple[WeightName, ...]:
        """Names of the weights, in a controller file and in C; numbers by default."""
        return tuple((name,) for name in self.WEIGHTS) or numbered(self.n_weights)

    def initial(self, key: jax.Array) -> WeightVector:
        """Return random weights to start training from, shape [n_weights]."""
        return jnp.zeros((self.n_weights,))


def inside(prefix: WeightName, paths: Sequence[WeightName]) -> tuple[WeightName, ...]:
    """Return these paths below another path.

    Args:
        prefix: the path within which they are.
        paths: the paths.
    """
    return tuple((*prefix, *path) for path in paths)


def nested(paths: Sequence[WeightName], values: Sequence[Json]) -> dict[str, Json]:
    """Return the values as objects and lists within each other.

    Args:
        paths: of the values, in their order.
        values: as many.

    Example:
        >>> nested([("gain", "sigma"), ("neuron", 0), ("neuron", 1)], [2.0, 0.5, 0.25])
        {'gain': {'sigma': 2.0}, 'neuron': [0.5, 0.25]}
    """
    tree: _Tree = {}
    for path, value in zip(paths, values, strict=True):
        branch = tree
        for step in path[:-1]:
            branch = cast(_Tree, branch.setdefault(step, {}))
        branch[path[-1]] = value
    return cast(dict[str, Json], _with_lists(tree))


def _with_lists(tree: object) -> Json:
    if not isinstance(tree, dict):
        return cast(Json, tree)
    entries = {step: _with_lists(entry) for step, entry in cast(_Tree, tree).items()}
    numbers = entries and all(isinstance(step, int) for step in entries)
    return list(entries.values()) if numbers else cast(dict[str, Json], entries)


def flat(paths: Sequence[WeightName], tree: Json) -> list[Json]:
    """Return the values of a tree from `nested` in the order of the paths.

    Args:
        paths: of the values, in their order.
        tree: objects and lists within each other.

    Raises:
        DamagedDocumentError: if one is missing, or there are others.

    Example:
        >>> flat([("gain", "sigma"), ("neuron", 0)], {"neuron": [0.5], "gain": {"sigma": 2.0}})
        [2.0, 0.5]
        >>> flat([("gain", "sigma")], {"gain": {}})
        Traceback (most recent call last):
        tegotae.DamagedDocumentError: its weights lack gain.sigma
    """
    entries = dict(_entries(tree, ()))
    for path in paths:
        if path not in entries:
            raise DamagedDocumentError(f"its weights lack {spelled(path)}")
    wanted_paths = set(paths)
    for path in entries:
        if path not in wanted_paths:
            raise DamagedDocumentError(
                f"its weights have {spelled(path)}, which the controller has not"
            )
    return [entries[path] for path in paths]


def _entries(tree: Json, path: WeightName) -> list[tuple[WeightName, Json]]:
    if isinstance(tree, Mapping):
        return [
            entry for name, subtree in tree.items() for entry in _entries(subtree, (*path, name))
        ]
    if isinstance(tree, list):
        return [entry for i, subtree in enumerate(tree) for entry in _entries(subtree, (*path, i))]
    return [(path, tree)]


def spelled(path: WeightName) -> str:
    """Return a path as people and C write it.

    Example:
        >>> spelled(("gain", "neuron", 2, "bias"))
        'gain.neuron[2].bias'
    """
    text = "".join(f"[{step}]" if isinstance(step, int) else f".{step}" for step in path)
    return text.removeprefix(".")
