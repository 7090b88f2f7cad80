"""The physical optimum: the largest CoT⁻¹ that any force can have on the hopper."""

from reproduction.optimum.best import best, stances
from reproduction.optimum.certificate import Certificate, certify, upper_bound
from reproduction.optimum.exact import verify
from reproduction.optimum.problem import small_hop_limit
from reproduction.optimum.trajectory import OptimalGait, Stance, highest_frequency, optimise

__all__ = [
    "Certificate",
    "OptimalGait",
    "Stance",
    "best",
    "certify",
    "highest_frequency",
    "optimise",
    "small_hop_limit",
    "stances",
    "upper_bound",
    "verify",
]
