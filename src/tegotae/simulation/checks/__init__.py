"""Checks of the contracts that a new term, oscillator, body or metric must keep.

Each check tries the part on a few lanes and raises `TegotaeError` with one line that names what is
wrong and how to put it right. A part that passes can go into a `Controller` or an `Engine`.
"""

from tegotae.simulation.checks.body import check_body
from tegotae.simulation.checks.parts import check_controller, check_oscillator, check_term

__all__ = ["check_body", "check_controller", "check_oscillator", "check_term"]
