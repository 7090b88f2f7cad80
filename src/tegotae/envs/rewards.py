"""The step reward of the paper's comparison: the efficiency of each hop."""

from __future__ import annotations

from dataclasses import dataclass

import jax
import jax.numpy as jnp

from tegotae._support.errors import require_finite
from tegotae.measures.hopping.signals import check_work, cot_inverse
from tegotae.parts._shapes import Numeric


@dataclass(frozen=True, kw_only=True)
class HopReward:
    """Zero but at each apex of a hop, where it is CoT⁻¹ of the hop just ended [m/J].

        r = (height climbed in flight since the last hop's apex) / (work since then),

    if any work was done, and, with the last step of an episode that ran its time, the mean over
    the rewarded hops. A hop is a flight that clears the rest length by 1 %. (The paper gives
    no formula: `CoT⁻¹` is its equation 12, taken hop by hop.)

    Args:
        work: definition of work, one of "absolute", "positive", "net".
        least_work_j: work that counts as none [J]. The paper's reward can be had for almost
            nothing: the first hops after a release need no work, and so pay the more the less is
            done in them. A greater value, or `charge_stored`, closes that door.
        charge_stored: whether energy that the body lost between the two apexes is charged as
            work too, so that hops on stored energy are not free.

    Raises:
        TegotaeError: for an unknown definition of work or a least work that is negative.

    Example:
        >>> reward = HopReward()
        >>> float(reward.of_hop(climb_m=0.2, work_j=0.4, lost_j=0.1)[0])
        0.5
    """

    work: str = "absolute"
    least_work_j: float = 1e-6
    charge_stored: bool = False

    def __post_init__(self) -> None:
        require_finite("least_work_j", self.least_work_j, least=0.0)
        check_work(self.work)

    def counted(self, work_j: Numeric) -> Numeric:
        """What counts of the actuator's signed work over a tick [J]."""
        if self.work == "net":
            return work_j
        return jnp.abs(work_j) if self.work == "absolute" else jnp.maximum(work_j, 0.0)

    def of_hop(
        self, *, climb_m: Numeric, work_j: Numeric, lost_j: Numeric
    ) -> tuple[jax.Array, jax.Array]:
        """CoT⁻¹ of a hop [m/J] and whether it is rewarded, each of the shape of the lanes."""
        paid = jnp.asarray(work_j) > self.least_work_j
        spent = work_j + jnp.maximum(lost_j, 0.0) if self.charge_stored else work_j
        return jnp.where(paid, cot_inverse(climb_m, spent), 0.0), paid
