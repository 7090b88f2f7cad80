"""What counts as hopping."""

from __future__ import annotations

from typing import Any

HOP_CLEARANCE = 0.01
"""A hop clears the rest length of the leg by at least this share of it.

A constant push leaves a damped leg bouncing on the spot of touchdown, ever lower but for ever:
such a bounce is no hop.
"""


def hop_height_m(rest_length_m: Any, ground_m: Any = 0.0) -> Any:
    """The least height of a hop's apex, `(1 + 0.01) l0 + h` [m]."""
    return (1.0 + HOP_CLEARANCE) * rest_length_m + ground_m
