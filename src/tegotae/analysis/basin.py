"""Basins of attraction: which release ends in which limit cycle, or in none."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from tegotae.analysis.sweep import MAP_DURATION_S, Outcome, OutcomeSummary, as_maps, lanes
from tegotae.measures.hopping.episode import LIMIT_CYCLE
from tegotae.measures.hopping.signals import require_measurable
from tegotae.parts.bodies import require_one_limb
from tegotae.simulation.rollout import Timing
from tegotae.systems.controller_file import SavedController

SAME_HEIGHT_M = 0.02
"""Limit cycles of equal period and winding are the same if their mean apexes differ by less [m]."""


@dataclass(frozen=True)
class Attractor:
    """A limit cycle that releases end in."""

    hops: int
    """Period k [hops]."""
    turns: int | None
    """Turns of the oscillator in it; None without an oscillator."""
    apex_height_m: float
    """Mean height of its apexes [m]."""
    cot_inverse: float
    """CoT⁻¹ A [m/J], mean over the releases."""
    share: float
    """Share of the releases that end in it."""


@dataclass(frozen=True)
class HopperBasin:
    """What releases lead to."""

    height_m: np.ndarray
    """Release heights [m], shape [heights]."""
    phase_rad: np.ndarray | None
    """Phases at release [rad], shape [columns]; None without an oscillator."""
    velocity_m_per_s: np.ndarray
    """Release velocity [m/s]: zero, shape [1], or without an oscillator the columns'."""
    outcome: Outcome
    """Maps of shape [heights, columns]."""
    attractor: np.ndarray
    """Index into `attractors`, -1 without limit cycle, shape [heights, columns]."""
    attractors: tuple[Attractor, ...]
    """The limit cycles, by falling share."""


def map_basin(
    saved: SavedController,
    height_m: np.ndarray,
    across: np.ndarray,
    *,
    timing: Timing | None = None,
) -> HopperBasin:
    """Release the body at rest from every height at every phase, and see where it ends.

    A controller without oscillator has no phase: its body is released with every velocity instead.

    Args:
        saved: the system and its weights.
        height_m: release heights [m], shape [heights].
        across: phases [rad], or without an oscillator velocities [m/s], shape [columns].
        timing: 40 s by default, of the system's control period where that is held. What has not
            settled by its end counts as without limit cycle.

    Raises:
        TegotaeError: for values that the rollout refuses, or a body of several limbs.

    Example:
        >>> from tegotae import build
        >>> saved = SavedController.of(build("V-reflex-w8"), np.array([2.0]), 8.0)
        >>> found = map_basin(saved, np.array([1.1, 1.2]), np.array([0.0, 3.0]))
        >>> [(a.hops, a.turns, a.share) for a in found.attractors]
        [(1, 1, 1.0)]
    """
    require_one_limb(saved.body, "a map of basins")
    with_phase = saved.controller.oscillator is not None
    height, column = lanes(height_m, across)
    timing = saved.system.timing_over(MAP_DURATION_S) if timing is None else timing
    require_measurable(timing.tick_s)
    engine = saved.system.engine(OutcomeSummary(), timing)
    scenario = saved.system.scenario(
        height_m=height,
        velocity_m_per_s=0.0 if with_phase else column,
        phase_rad=column if with_phase else 0.0,
    )
    outcome = engine.run(saved.weights, scenario, saved.body)
    attractor, attractors = distinct(outcome)
    if not with_phase:
        attractors = tuple(replace(found, turns=None) for found in attractors)
    return HopperBasin(
        height_m=np.asarray(height_m),
        phase_rad=np.asarray(across) if with_phase else None,
        velocity_m_per_s=np.zeros(1) if with_phase else np.asarray(across),
        outcome=as_maps(outcome, height_m, across),
        attractor=attractor.reshape(len(height_m), len(across)),
        attractors=attractors,
    )


def distinct(outcome: Outcome) -> tuple[np.ndarray, tuple[Attractor, ...]]:
    """Distinguish limit cycles by period, turns of the oscillator, and mean apex height.

    Args:
        outcome: of rollouts of one controller, arrays of shape [lanes].

    Returns:
        Index of each lane's limit cycle, -1 without one, [lanes]; and the cycles by falling share.
    """
    settled = np.flatnonzero(outcome.regime == LIMIT_CYCLE)
    period = outcome.limit_cycle_period[settled]
    turns = np.round(outcome.winding_ratio[settled] * period)
    height = outcome.apex_height_m[settled]
    order = np.lexsort((height, turns, period))
    new = np.ones(len(settled), bool)
    new[1:] = (
        (np.diff(period[order]) != 0)
        | (np.diff(turns[order]) != 0)
        | (np.diff(height[order]) > SAME_HEIGHT_M)
    )
    groups = np.split(settled[order], np.flatnonzero(new)[1:]) if len(settled) else []
    groups.sort(key=len, reverse=True)
    index = np.full(len(outcome.regime), -1)
    attractors = []
    for number, members in enumerate(groups):
        index[members] = number
        k = int(outcome.limit_cycle_period[members[0]])
        attractors.append(
            Attractor(
                hops=k,
                turns=round(float(outcome.winding_ratio[members[0]]) * k),
                apex_height_m=float(outcome.apex_height_m[members].mean()),
                cot_inverse=float(outcome.cot_inverse[members].mean()),
                share=len(members) / len(index),
            )
        )
    return index, tuple(attractors)
