"""A fitness: how high the body gets at the end of an episode."""

from dataclasses import dataclass

import jax

from tegotae import TegotaeError
from tegotae.measures.objectives.objective import Objective
from tegotae.parts import require_finite
from tegotae.systems.recipe import recipe


@dataclass(frozen=True, kw_only=True)
class Jump(Objective):
    """The greatest height of the last seconds [m]."""

    last_s: float = 2.0
    """How many seconds count [s]."""

    needs = ("height_m",)  # all that is recorded for it

    def __post_init__(self) -> None:
        require_finite("last_s", self.last_s, above=0.0)

    def check(self, timing) -> None:
        """Refuse an episode that is too short, before anything is trained."""
        if timing.duration_s < self.last_s:
            raise TegotaeError(
                f"an episode of {timing.duration_s:g} s is shorter than the {self.last_s:g} s that "
                "count; make it longer"
            )

    def outcome(self, trajectory, scenario, body, timing) -> jax.Array:
        """One number per lane: the larger, the better."""
        frames = round(self.last_s / timing.frame_s)
        return trajectory.height_m[-frames:].max(axis=0)


experiment = recipe("AR").experiment(budget=40, objective=Jump(), name="AR-jumps")
"""What `tegotae train jump.py:experiment` trains."""
