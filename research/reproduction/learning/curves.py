"""Curves of trained runs: their formulas, where they wait and push, and starts of short forms."""

from __future__ import annotations

import math
from collections.abc import Hashable
from dataclasses import dataclass, replace

import numpy as np

from research.reproduction.learning.judged import releases
from research.reproduction.record import Record
from research.reproduction.unit import record_key
from tegotae._support.documents import Document
from tegotae.analysis.explanation import (
    ReleasedHopper,
    Visits,
    action_fits,
    parking,
    pushing,
    reaction_fits,
    visits,
)
from tegotae.analysis.short_forms import starting_forms
from tegotae.study import CellResult
from tegotae.systems.controller_file import SavedController
from tegotae.training.evolution import Evolution

FEW = 5
"""Number of common releases from which the curves are taken."""
FITS = ("action_1", "action_2", "load", "latch", "decay", "saturating")
"""The numbers of `curve_numbers` that are an R²."""
SWING = (5.0, 95.0)
"""Percentiles of the feedback between which it swings."""


def saved_runs(record: Record) -> list[SavedController]:
    """Return the runs of a record as controllers; a search has one."""
    experiment = record.experiment
    runs = record.weights[:1] if experiment.is_searched else record.weights
    return [
        SavedController(experiment.system, np.asarray(weights, float), record.model, experiment)
        for weights in runs
    ]


def curve_numbers(v: Visits, omega: float) -> dict[str, float]:
    """Return the curves of a run in numbers.

    Args:
        v: what its gait visits.
        omega: commanded ω [rad/s].

    Returns:
        `action_1` and `action_2`, R² of one and two harmonics of A′; of one harmonic `offset`, over
        its amplitude, and `place` [rad]; R² of G R by the name of the law whose reaction it is;
        `swing` of the feedback over ω; `waits_flight` and `waits_stance`, shares of the time;
        `pushes`, the share of the stance. NaN where there is no such term.
    """
    numbers = dict.fromkeys((*FITS, "offset", "place"), math.nan)
    if np.isfinite(v.action).all():
        single, double = action_fits(v)
        offset, a, b = single.numbers
        size = math.hypot(a, b)
        numbers |= {"action_1": single.explained, "action_2": double.explained}
        numbers |= {"offset": offset / size if size else math.nan, "place": math.atan2(b, a)}
    if np.isfinite(v.gain * v.reaction).all():
        numbers |= {name: fit.explained for name, fit in reaction_fits(v).items()}
    low, high = np.percentile(v.feedback_rad_per_s, SWING)
    waits = {f"waits_{where}": share for where, (share, _) in parking(v, omega).items()}
    pushes, _ = pushing(v, math.inf)
    return numbers | {"swing": (high - low) / omega, **waits, "pushes": pushes}


@dataclass(frozen=True)
class CurvesOfRuns:
    """All runs of one record with feedback, as a cell of a study (`tegotae.study.Study`).

    Args:
        record: what was trained.
    """

    record: Record

    @property
    def name(self) -> str:
        """Name of the model."""
        return self.record.model

    @property
    def document(self) -> Document:
        """The record, the source of its curves, and the seed of the first untrained run."""
        name = record_key(self.record.configuration)
        return {"record": name, "releases": FEW, "untrained_seed": 0}

    @property
    def program(self) -> Hashable:
        """Records of one controller share compiled programs."""
        return repr(self.record.experiment.controller)

    def prepare(self) -> None:
        """Prepare nothing: the package has all that it needs."""

    def measure(self) -> CellResult:
        """Measure their curves, [runs] each, and starts of every form, `start_FORM`, [runs,
        n_weights].

        Beside an R² stands that of a term before its training, `untrained_NAME`, over what the
        trained run visits.
        """
        saved = saved_runs(self.record)
        initial = Evolution().start(self.record.experiment, range(len(saved))).best_weights
        rows = []
        for run, untrained in zip(saved, np.asarray(initial, float), strict=True):
            v, as_before = visited(run, untrained)
            fits = curve_numbers(as_before, run.system.omega or math.nan)
            rows.append(
                curve_numbers(v, run.system.omega or math.nan)
                | {f"untrained_{name}": fits[name] for name in FITS}
                | {f"start_{name}": x for name, (_, x) in starting_forms(run, [v]).items()}
            )
        arrays = {name: np.array([row[name] for row in rows]) for name in rows[0]}
        return CellResult(self.document, self.record.software, arrays)


def visited(saved: SavedController, untrained: np.ndarray) -> tuple[Visits, Visits]:
    """Return the states that a run visits at ω_t from some common releases, and the same with the
    terms of untrained weights, [n_weights]."""
    assert saved.experiment is not None
    protocol, system = saved.experiment.protocol, saved.system
    start = releases(system.scenario())
    release = start._replace(height_m=start.height_m[:FEW], phase_rad=start.phase_rad[:FEW])
    timing = system.timing_over(protocol.undisturbed_s, tick_s=protocol.tick_s)
    released = ReleasedHopper(saved, np.array([saved.omega]), release, timing, protocol)
    evaluation, recorded = released.evaluated(saved.controller, saved.weights), released.recorded()
    initial = replace(released, saved=replace(saved, weights=untrained))
    (v,), (as_before,) = (visits(x, evaluation, recorded) for x in (released, initial))
    return v, as_before
