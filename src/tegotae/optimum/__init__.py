"""The physical optimum: the largest CoT⁻¹ that any force can have on the hopper."""

from tegotae.optimum.certificate import Certificate, certify, upper_bound
from tegotae.optimum.exact import verify
from tegotae.optimum.problem import small_hop_limit
from tegotae.optimum.table import COLUMNS, Curve, best, curve, has_table, share, stances
from tegotae.optimum.trajectory import OptimalGait, Stance, highest_frequency, optimise

__all__ = [
    "COLUMNS",
    "Certificate",
    "Curve",
    "OptimalGait",
    "Stance",
    "best",
    "certify",
    "curve",
    "has_table",
    "highest_frequency",
    "optimise",
    "share",
    "small_hop_limit",
    "stances",
    "upper_bound",
    "verify",
]
