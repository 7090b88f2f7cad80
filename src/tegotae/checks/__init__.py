"""Checks of the contracts that a new term, oscillator, body or metric must keep.

Each check tries the part on a few lanes and raises `TegotaeError` with one line that names what is
wrong and how to put it right. A part that passes can go into a `Controller` or an `Engine`.
"""

from tegotae.checks.body import check_body
from tegotae.checks.controller import check_controller
from tegotae.checks.metric import check_metric
from tegotae.checks.oscillator import check_oscillator
from tegotae.checks.term import check_term

__all__ = ["check_body", "check_controller", "check_metric", "check_oscillator", "check_term"]
