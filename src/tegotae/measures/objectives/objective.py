"""Objectives that a training maximises."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple, Self

import jax
import jax.numpy as jnp
import numpy as np

from tegotae._support.errors import TegotaeError
from tegotae.parts.bodies import Body
from tegotae.parts.parameters import Part, changed
from tegotae.simulation.recorder import Trajectory
from tegotae.simulation.rollout import Scenario, Timing

FAILED_FITNESS = -1e6
"""Fitness of a rollout that failed: below any that did not."""


class Scores(NamedTuple):
    """Scores of episodes, or of candidates over theirs: arrays of one shape."""

    fitness: Any
    """The larger, the better."""
    cot_inverse: Any
    """CoT⁻¹ [m/J]; NaN where it is not measured."""
    failed: Any
    """True if the episode failed."""


class Objective(Part, ABC):
    """The measure by which an episode is evaluated, a frozen dataclass of its settings.

    It has two methods: `outcome` reduces the trajectory of an episode to what counts, and `score`
    makes the fitness of that:

        fitness = score(outcome(trajectory, scenario, body, timing), data).

    An objective of your own needs `outcome` alone, if that returns the fitness. Rollouts that
    failed are put below all others afterwards, whatever the objective.

    Settings that `score` alone reads (`DATA`) are data of the compiled program, so that another
    value compiles nothing anew; all others are the `program`.
    """

    needs: ClassVar[tuple[str, ...] | None] = None
    """The channels of the trajectory that it reads; all are recorded for it by default."""

    COT_UNIT: ClassVar[str] = "m/J"
    """Unit of its CoT⁻¹: height climbed over work; empty of what has none, as of a walk."""

    DATA: ClassVar[tuple[str, ...]] = ()
    """Fields that `score` alone reads, from its `data`."""

    def __init_subclass__(cls) -> None:
        super().__init_subclass__()
        if cls.needs is not None and "failed" not in cls.needs:
            cls.needs = (*cls.needs, "failed")  # by which failures are put below all others

    @abstractmethod
    def outcome(
        self, trajectory: Trajectory, scenario: Scenario, body: Body, timing: Timing
    ) -> Any:
        """Summarise an episode: the fitness, [lanes], or all values that `score` computes it from.

        Args:
            trajectory: arrays of shape [frames, lanes].
            scenario: arrays of shape [lanes].
            body: the body, its numbers traced.
            timing: of the episode.
        """

    def score(self, outcome: Any, data: Any) -> dict[str, jax.Array]:
        """Return the fitness and its parts, each of shape [lanes]; larger is better.

        Args:
            outcome: of the episode, from `outcome`.
            data: the settings of `DATA` by name; arrays of a compiled program.

        Returns:
            `fitness`; `cot_inverse` where it is measured; and whatever else is worth a name.
        """
        return {"fitness": outcome}

    @property
    def program(self) -> Self:
        """The compiled part, without the fields of `DATA`; equal ones share a program."""
        program = self
        for name in self.DATA:
            program = changed(program, name, lambda _: None)  # type: ignore[arg-type,return-value]
        return program

    @property
    def data(self) -> dict[str, np.ndarray]:
        """The fields of `DATA`, arrays of a compiled program."""
        return {name: np.asarray(getattr(self, name), "float32") for name in self.DATA}

    def check(self, timing: Timing) -> None:
        """Raise `TegotaeError` if an episode of this timing cannot be evaluated."""

    def check_frequencies(self, lower: float, upper: float) -> None:
        """Raise `TegotaeError` if an episode at one of these frequencies cannot be evaluated.

        Args:
            lower: the lowest ω of the episodes [rad/s].
            upper: the highest.
        """

    def without_frequency(self) -> Objective:
        """Return this objective for a body without a prescribed frequency."""
        return self

    def __call__(
        self, trajectory: Trajectory, scenario: Scenario, body: Body, timing: Timing
    ) -> dict[str, jax.Array]:
        """Return the scores of every episode (`scores`), [lanes], as the summary of a `Rollout`."""
        episode = EpisodeSummary(self)(trajectory, scenario, body, timing)
        return scores(self, episode, self.data)


def require_settled(timing: Timing, settle_s: float, least_s: float) -> None:
    """Raise `TegotaeError` if an episode leaves too little time after it has settled.

    Args:
        timing: of the episode.
        settle_s: time to settle [s].
        least_s: least time after that [s].
    """
    if timing.duration_s < settle_s + least_s:
        raise TegotaeError(
            f"an episode of {timing.duration_s:g} s leaves less than {least_s:g} s after settling "
            f"for {settle_s:g} s; make it at least {settle_s + least_s:g} s"
        )


class EpisodeOutcome(NamedTuple):
    """Summary of an episode for an objective, and its validity."""

    outcome: Any
    """Result of `Objective.outcome`."""
    survived: jax.Array
    """Share of the episode before the rollout failed, [lanes]; 1 if it did not."""
    failed: jax.Array
    """True if the episode failed, [lanes]."""


@dataclass(frozen=True)
class EpisodeSummary:
    """Summary of an episode for an objective, as a `Rollout`'s summary: an `EpisodeOutcome`.

    Args:
        objective: the objective; two are one program if their `Objective.program` is equal.
    """

    objective: Objective

    @property
    def needs(self) -> tuple[str, ...] | None:
        """The channels that it reads."""
        return self.objective.needs

    def __call__(
        self, trajectory: Trajectory, scenario: Scenario, body: Body, timing: Timing
    ) -> EpisodeOutcome:
        """Return the outcome of every lane."""
        return EpisodeOutcome(
            outcome=self.objective.outcome(trajectory, scenario, body, timing),
            survived=jnp.mean(jnp.where(trajectory.failed, 0.0, 1.0), axis=0),
            failed=trajectory.failed[-1],
        )


def scores(objective: Objective, episode: EpisodeOutcome, data: Any) -> dict[str, jax.Array]:
    """Return `Objective.score` of episodes, failed ones below all others, [lanes] each.

    Args:
        objective: the objective.
        episode: from its `EpisodeSummary`.
        data: its settings (`Objective.data`).

    Returns:
        the parts of the score; always `fitness`, `failed` and `cot_inverse`, which is NaN where it
        is not measured and 0 of an episode that failed.

    Raises:
        TegotaeError: for a fitness that is not one number per lane.
    """
    failed = episode.failed
    scored = objective.score(episode.outcome, data)
    fitness = scored["fitness"]
    if jnp.shape(fitness) != jnp.shape(failed):
        method = "outcome" if type(objective).score is Objective.score else "score"
        raise TegotaeError(
            f"{type(objective).__name__}.{method} returned a fitness of shape "
            f"{jnp.shape(fitness)}; it must be one number per lane, {jnp.shape(failed)}"
        )
    if "cot_inverse" in scored:
        cot_inverse = jnp.where(failed, 0.0, scored["cot_inverse"])
    else:
        cot_inverse = jnp.full_like(fitness, jnp.nan)
    return {
        **scored,
        # The later a rollout failed, the better.
        "fitness": jnp.where(failed, FAILED_FITNESS + episode.survived, fitness),
        "cot_inverse": cot_inverse,
        "failed": failed,
    }
