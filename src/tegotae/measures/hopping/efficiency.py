"""How high for how much: the inverse cost of transport."""

from __future__ import annotations

import jax
import jax.numpy as jnp

from tegotae._support.errors import TegotaeError
from tegotae.parts._shapes import AnyArray, Numeric
from tegotae.simulation.rollout import Trajectory

WORK = ("absolute", "positive", "net")
"""Definitions of the actuator's work: ∫ |F_a ẏ| dt, ∫ max(0, F_a ẏ) dt, ∫ F_a ẏ dt."""


def check_work(definition: str, name: str = "work") -> None:
    """Raise `TegotaeError` for a definition of work, a setting of that name, none of `WORK`."""
    if definition not in WORK:
        raise TegotaeError(f"{name} is {definition!r}; it must be one of {', '.join(WORK)}")


def work_total(trajectory: Trajectory, definition: str = "absolute") -> AnyArray:
    """Running total of the actuator's work [J], shape [frames, lanes].

    Args:
        trajectory: which has the channel `work_absolute_j`, or that of the definition.
        definition: one of `WORK`.

    Raises:
        TegotaeError: for a definition that is none of `WORK`.
    """
    check_work(definition)
    return getattr(trajectory, f"work_{definition}_j")


def cot_inverse(climb_m: Numeric, work_j: Numeric) -> jax.Array:
    """Inverse cost of transport, `CoT⁻¹ = Σ heights climbed / E` [m/J] (paper equation 12).

    Zero where nothing was climbed or no work was done.

    Args:
        climb_m: climbed height [m], any shape: in flight (variant A) or in all (variant B).
        work_j: work over the same time [J], same shape.

    Example:
        >>> float(cot_inverse(1.5, 2.0)), float(cot_inverse(1.5, 0.0))
        (0.75, 0.0)
    """
    climb_m, work_j = jnp.asarray(climb_m), jnp.asarray(work_j)
    moves = (climb_m > 0.0) & (work_j > 1e-6)
    return jnp.where(moves, climb_m / jnp.where(moves, work_j, 1.0), 0.0)
