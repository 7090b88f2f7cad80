"""A hopper whose leg stiffens as it is compressed."""

import dataclasses
from dataclasses import dataclass

from tegotae import Hopper
from tegotae.parts.parameters import positive, traceable
from tegotae.systems.recipe import recipe


@traceable
@dataclass(frozen=True, kw_only=True)
class RubberHopper(Hopper):
    """A hopper on a spring of `F_k = k d + k3 d³`."""

    hardening_n_per_m3: float = positive(20.0)
    """Hardening k3 [N/m³]."""

    def spring(self, depth):
        """Return F_k [N] at a depth d [m]."""
        return depth * (self.stiffness_n_per_m + self.hardening_n_per_m3 * depth**2)


experiment = dataclasses.replace(
    recipe("AR").experiment(budget=40, body=RubberHopper()), name="AR-on-rubber"
)
"""What `tegotae train rubber_hopper.py:experiment` trains: a model of the paper on this body."""
