"""What a training maximises."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import Any, ClassVar

import jax.numpy as jnp

from tegotae._support.errors import TegotaeError
from tegotae.parts.bodies import Body
from tegotae.simulation.rollout import Scenario, Timing, Trajectory

FAILED_FITNESS = -1e6
"""Fitness of a rollout that failed: below any that did not."""


def with_failures(fitness: Any, failed: Any, survived: Any) -> Any:
    """The fitness, and of rollouts that failed one below all: the later, the better, [lanes]."""
    return jnp.where(failed, FAILED_FITNESS + survived, fitness)


class Objective(ABC):
    """The measure by which an episode is judged, a frozen dataclass of its settings.

    An objective of your own has one method, `score`. `Fitness` is the paper's; it does more, so
    that its settings are data of the compiled program and another value compiles nothing anew.
    """

    needs: ClassVar[tuple[str, ...] | None] = None
    """The channels of the trajectory that it reads; all are recorded for it by default."""

    COT_UNIT: ClassVar[str] = "m/J"
    """Unit of its CoT⁻¹: height climbed over work; empty of what has none, as of a walk."""

    def __init_subclass__(cls) -> None:
        super().__init_subclass__()
        if cls.needs is not None and "failed" not in cls.needs:
            cls.needs = (*cls.needs, "failed")  # by which failures are put below all others

    @abstractmethod
    def score(self, trajectory: Trajectory, scenario: Scenario, body: Body, timing: Timing) -> Any:
        """The fitness of every lane, [lanes]: the larger, the better.

        Args:
            trajectory: arrays of shape [frames, lanes].
            scenario: arrays of shape [lanes].
            body: the body, its numbers traced.
            timing: of the episode.
        """

    def check(self, timing: Timing) -> None:  # noqa: B027 - optional
        """Raise `TegotaeError` if an episode of this timing cannot be judged."""

    def without_frequency(self) -> Objective:
        """The same for what has no prescribed frequency."""
        return self

    @property
    def program(self) -> Objective:
        """The part that is compiled: what it shares, programs share."""
        return self

    @property
    def data(self) -> Any:
        """The part that is data of the compiled program: arrays."""
        return ()

    @property
    def judged(self) -> Callable[[Trajectory, Scenario, Body, Timing], Any]:
        """What of an episode counts: an `Engine`'s summary, of what `weigh` is given then."""
        return self

    def weigh(self, judged: Any, data: Any) -> dict[str, Any]:
        """`fitness`, `cot_inverse` (NaN where it is not measured) and `failed`, each [lanes]."""
        return judged

    def __call__(
        self, trajectory: Trajectory, scenario: Scenario, body: Body, timing: Timing
    ) -> dict[str, Any]:
        """Fitness and its parts, each of shape [lanes]: an `Engine`'s summary."""
        failed = trajectory.failed[-1]
        survived = jnp.mean(jnp.where(trajectory.failed, 0.0, 1.0), axis=0)
        fitness = self.score(trajectory, scenario, body, timing)
        if jnp.shape(fitness) != jnp.shape(failed):
            raise TegotaeError(
                f"{type(self).__name__}.score returned shape {jnp.shape(fitness)}; it must be one "
                f"number per lane, {jnp.shape(failed)}"
            )
        return {
            "fitness": with_failures(fitness, failed, survived),
            "cot_inverse": jnp.full_like(fitness, jnp.nan),
            "failed": failed,
        }
