"""The physical optimum: the largest CoT⁻¹ that any force can have on the hopper."""

from research.reproduction.optimum.best import largest_cot_inverse, optimal_stances
from research.reproduction.optimum.certificate import Certificate, certify, upper_bound
from research.reproduction.optimum.exact import verify
from research.reproduction.optimum.problem import small_hop_limit
from research.reproduction.optimum.trajectory import (
    OptimalGait,
    Stance,
    highest_frequency,
    optimise,
)

__all__ = [
    "Certificate",
    "OptimalGait",
    "Stance",
    "certify",
    "highest_frequency",
    "largest_cot_inverse",
    "optimal_stances",
    "optimise",
    "small_hop_limit",
    "upper_bound",
    "verify",
]
