"""A controller whose feedback is held at a constant: what is left of it is a clock."""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import ArrayLike

from tegotae._support.errors import TegotaeError
from tegotae.parts.controller import Controller, Tegotae
from tegotae.parts.terms import ConstantGain, UnitAction


def with_held_feedback(
    controller: Controller, weights: ArrayLike, feedback_rad_per_s: ArrayLike = 0.0
) -> tuple[Controller, np.ndarray]:
    """Return the controller with its feedback replaced by a constant f: `φ̇ = ω + f`.

    Held at zero the feedback is cut (G := 0), held at its mean over the limit cycle it is frozen.
    An actuation that reads the feedback reads the constant.

    Args:
        controller: with Tegotae terms.
        weights: shape [..., n_weights].
        feedback_rad_per_s: f [rad/s], broadcast to the shape [...].

    Returns:
        A controller whose gain is f, with the actuation, oscillator and coupling as they are, and
        its weights, shape [..., its n_weights].

    Raises:
        TegotaeError: for a controller without feedback.

    Source: of this library.

    Example:
        >>> from tegotae.systems.recipe import recipe
        >>> clock, weights = with_held_feedback(recipe("V-sector-w8").controller(), [[2.0], [3.0]])
        >>> clock.n_weights, weights.tolist()
        (1, [[0.0], [0.0]])
    """
    if controller.tegotae is None:
        raise TegotaeError("the controller has no feedback that could be held; it is one network")
    constant = Tegotae(UnitAction(), UnitAction(), ConstantGain())
    clock = dataclasses.replace(controller, tegotae=constant)
    rows = np.asarray(weights)
    f = np.broadcast_to(np.asarray(feedback_rad_per_s, rows.dtype), rows.shape[:-1])[..., None]
    n, feedback = controller.unit_weights, controller.layout["actuation"].start
    units = [
        part
        for unit in range(controller.sets)
        for part in (f, rows[..., unit * n + feedback : (unit + 1) * n])
    ]
    return clock, np.concatenate([*units, rows[..., controller.sets * n :]], axis=-1)
