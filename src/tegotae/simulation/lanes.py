"""Weights and scenario as arrays, lanes last: what a user may write, and what engines take."""

from __future__ import annotations

import reprlib
from functools import partial
from typing import Any

import jax
import numpy as np

from tegotae._support.errors import TegotaeError
from tegotae.parts.bodies import Body
from tegotae.parts.controller import Controller
from tegotae.parts.fields import path_of
from tegotae.simulation.episode import LaneInputs
from tegotae.simulation.world import Scenario, map_change
from tegotae.simulation.world.scenario import GROUND, OMEGA


def as_lanes(
    controller: Controller, body: Body, weights: Any, scenario: Scenario, dtype: str
) -> LaneInputs:
    """Weights [n_weights, lanes] and a scenario of arrays [lanes], its changes named by paths.

    Args:
        controller: whose weights.
        body: the body.
        weights: shape [lanes, n_weights] or [n_weights].
        scenario: numbers, or arrays of shape [lanes] or [limbs, lanes].
        dtype: the type of all arrays.

    Raises:
        TegotaeError: for what is no number, of another shape, or of another number of lanes.
    """
    weights = _numbers("weights", weights, dtype)
    if weights.ndim == 1:
        weights = weights[None, :]
    if weights.ndim != 2 or weights.shape[1] != controller.n_weights:
        raise TegotaeError(
            f"weights have shape {weights.shape}; this controller needs "
            f"[lanes, {controller.n_weights}]"
        )
    shape = controller.limb_shape

    def entry(name: str, value: Any) -> np.ndarray:
        return _entry(name, value, shape, dtype)

    entries = {name: entry(name, x) for name, x in scenario._asdict().items() if name not in _MORE}
    initial_pose = {name: entry(name, x) for name, x in dict(scenario.initial_pose).items()}
    oscillator_state = {name: entry(name, x) for name, x in dict(scenario.oscillator_state).items()}
    changes = {
        _path(body, name): map_change(partial(entry, name), change)
        for name, change in dict(scenario.changes).items()
    }
    whole = Scenario(
        **entries, initial_pose=initial_pose, oscillator_state=oscillator_state, changes=changes
    )
    sizes = [x.shape[-1:] for x in jax.tree.leaves(whole)]
    try:
        (lanes,) = np.broadcast_shapes((len(weights),), *sizes)
    except ValueError:
        shapes = ", ".join(str(x.shape) for x in jax.tree.leaves(whole))
        raise TegotaeError(
            f"weights for {len(weights)} lanes do not go with scenario entries of shapes {shapes}; "
            "each must be a number or have one entry per lane"
        ) from None
    columns = np.broadcast_to(weights, (lanes, weights.shape[1])).T

    def of_lanes(x: np.ndarray) -> np.ndarray:
        return np.broadcast_to(x, (*x.shape[:-1], lanes))

    return LaneInputs(columns, jax.tree.map(of_lanes, whole))


def _path(body: Body, name: str) -> str:
    """What a change is called in a compiled program."""
    return name if name in (GROUND, OMEGA) else path_of(body, name)


_MORE = ("initial_pose", "oscillator_state", "changes")
"""Entries of a scenario that are made of several."""
_OF_BODY = ("height_m", "velocity_m_per_s", "drop_m", "drop_time_s")
"""Entries of which a body has one, however many limbs."""


def _numbers(name: str, value: Any, dtype: str) -> np.ndarray:
    try:
        return np.asarray(value, dtype)
    except (TypeError, ValueError):
        raise TegotaeError(
            f"{name} is {reprlib.repr(value)}; it must be a number or an array of numbers"
        ) from None


def _entry(name: str, value: Any, limb_shape: tuple[int, ...], dtype: str) -> np.ndarray:
    """An entry of a scenario as an array whose last axis is that of the lanes."""
    entry = _numbers(name, value, dtype)
    by_limb = name not in _OF_BODY and limb_shape == entry.shape[:-1]
    if entry.ndim > 1 and not by_limb:
        limbs = f" or [{limb_shape[0]}, lanes]" if limb_shape else ""
        raise TegotaeError(f"{name} has shape {entry.shape}; it must be a number, [lanes]{limbs}")
    return entry if entry.ndim else entry[None]
