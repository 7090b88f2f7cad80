"""The effect of a claim, computed from a study's table in one way to count."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from research.reproduction.claims.counting import ALL, FIGURE_2, Count
from research.reproduction.claims.designs import DRIVES, MODELS, within_omega
from research.reproduction.claims.effects import (
    ArchitectureGroup,
    Correlation,
    Difference,
    DoubleDifference,
    Effect,
    OfGaits,
)
from research.reproduction.claims.random_effects import complete, crossed
from research.reproduction.claims.resampling import Resampled
from tegotae.measures.statistics import mean_defined

LEVEL = (2.5, 97.5)
"""The percentiles of an interval's ends."""


@dataclass(frozen=True)
class EffectEstimate:
    """An effect with its 95 % intervals: over runs, drawn anew, and over designs and ω_t.

    Args:
        effect: the effect; NaN if it is not measured.
        low: lower end of its interval; NaN without one.
        high: upper end.
        size: what the effect is to be compared with: the level of what it is a difference to. NaN
            if there is none.
        designs_low: lower end of the interval in which design (architecture and drive of what the
            effect is about) and ω_t are random (`research.reproduction.claims.random_effects`); NaN
            where it is over none of them.
        designs_high: upper end.
    """

    effect: float
    low: float
    high: float
    size: float = np.nan
    designs_low: float = np.nan
    designs_high: float = np.nan

    @property
    def is_known(self) -> bool:
        """True if there is an effect with an interval."""
        return bool(np.isfinite([self.effect, self.low, self.high]).all())

    @property
    def over_designs(self) -> EffectEstimate:
        """The effect with the interval over designs and ω_t in place of that over runs."""
        return replace(self, low=self.designs_low, high=self.designs_high)


NOT_KNOWN = EffectEstimate(np.nan, np.nan, np.nan)


def estimate_effect(effect: Effect, runs: Resampled, count: Count) -> EffectEstimate:
    """Estimate an effect from a study's table, or return `NOT_KNOWN` if the table lacks its data.

    Args:
        effect: the claim's effect.
        runs: the table, resampled.
        count: the way to count.
    """
    if isinstance(effect, Correlation):
        return _correlation(effect, runs, count)
    metric = effect.measure if isinstance(effect, OfGaits) else getattr(effect, "metric", "")
    if metric not in runs.table.columns:
        return NOT_KNOWN
    cells = _DesignCells(runs, metric, count)
    if isinstance(effect, Difference):
        return cells.difference(effect.ours, effect.theirs, lowest=effect.lowest)
    if isinstance(effect, OfGaits):
        return cells.difference(effect.ours, effect.theirs)
    if isinstance(effect, DoubleDifference):
        return cells.gain(effect)
    return NOT_KNOWN


@dataclass(frozen=True)
class _Gap:
    """A difference of groups, and its reference, [1 + resamples].

    `of_designs` has it for each design at each ω_t, of the runs as they are, [designs, ω_t].
    """

    values: np.ndarray
    base: np.ndarray
    of_designs: np.ndarray


_NO_DESIGNS = np.empty((0, 0))
_NO_GAP = _Gap(np.full(1, np.nan), np.full(1, np.nan), _NO_DESIGNS)


class _DesignCells:
    """A metric by architecture, senses and place in the design, [1 + resamples] each."""

    def __init__(self, runs: Resampled, metric: str, count: Count) -> None:
        self._count = count
        models, values = runs.models, runs.values(metric, count)
        self._range = np.nan
        if np.isfinite(values[0]).any():
            self._range = float(np.nanmax(values[0]) - np.nanmin(values[0]))
        self._places: dict[tuple[str, str], dict[tuple, np.ndarray]] = {}
        columns: dict[tuple, list[int]] = {}
        for i, (architecture, senses, actuation, omega) in enumerate(
            zip(
                models.architecture.tolist(),
                models.observation.tolist(),
                models.actuation.tolist(),
                models.omega_t.tolist(),
                strict=True,
            )
        ):
            if count.omega_t != ALL and np.isfinite(omega) and f"{omega:g}" != count.omega_t:
                continue
            place = (omega, DRIVES.get(actuation, "")) if np.isfinite(omega) else ANYWHERE
            columns.setdefault((architecture, senses, place), []).append(i)
        for (architecture, senses, place), positions in columns.items():
            mean = mean_defined(values[:, positions])
            self._places.setdefault((architecture, senses), {})[place] = mean
        self._all = {
            cell: mean_defined(
                values[
                    :,
                    [i for key, positions in columns.items() if key[:2] == cell for i in positions],
                ]
            )
            for cell in self._places
        }

    def _cells(self, group: ArchitectureGroup) -> list[tuple[str, str]]:
        return [
            cell
            for cell in self._places
            if cell[0] in group.architectures and group.observation in ("", cell[1])
        ]

    def difference(
        self, ours: ArchitectureGroup, theirs: ArchitectureGroup | None, *, lowest: bool = False
    ) -> EffectEstimate:
        """Return one group minus another."""
        return _interval(self._difference(ours, theirs, lowest=lowest))

    def gain(self, effect: DoubleDifference) -> EffectEstimate:
        """Return one difference minus another; its size is the second."""
        ours, theirs = (self._difference(*pair) for pair in (effect.ours, effect.theirs))
        same_shape = theirs.of_designs.shape == ours.of_designs.shape
        designs = ours.of_designs - (theirs.of_designs if same_shape else theirs.values[0])
        return _interval(_Gap(ours.values - theirs.values, theirs.values, designs))

    def _difference(
        self, ours: ArchitectureGroup, theirs: ArchitectureGroup | None, *, lowest: bool = False
    ) -> _Gap:
        mine, reference = self._cells(ours), [] if theirs is None else self._cells(theirs)
        if not mine or (theirs is not None and not reference):
            return _NO_GAP
        if self._count.average == FIGURE_2:
            return self._normalised(mine, reference, lowest)
        places = [{p for cell in cells for p in self._places[cell]} for cells in (mine, reference)]
        shared = self._shared(*places) if reference else sorted(places[0])
        level = [self._level(mine, place) for place in shared]
        base = (
            [
                self._lowest(reference, place, shared) if lowest else self._level(reference, place)
                for place in shared
            ]
            if reference
            else [np.zeros(1)] * len(shared)
        )
        gaps = [a - b for a, b in zip(level, base, strict=True)]
        # The designs that count are those that the runs as they are define.
        defined = [i for i, gap in enumerate(gaps) if np.isfinite(gap[0])]
        if not defined:
            return _NO_GAP
        base_values = {shared[i]: float(base[i][0]) for i in defined}
        return _Gap(
            _mean_of_rows([gaps[i] for i in defined]),
            _mean_of_rows([base[i] for i in defined]),
            self._design_differences(mine, base_values),
        )

    def _design_differences(
        self, mine: list[tuple[str, str]], base: dict[tuple, float]
    ) -> np.ndarray:
        """Return each architecture and drive minus the base, where all have numbers, [designs,
        ω_t].
        """
        if ANYWHERE in base:
            return _NO_DESIGNS
        omegas, drives = ({place[i] for place in base} for i in (0, 1))
        gaps = np.array(
            [
                [
                    self._level([cell], (omega, drive))[0] - base.get((omega, drive), np.nan)
                    for omega in sorted(omegas)
                ]
                for cell in mine
                for drive in sorted(drives)
            ]
        )
        return complete(gaps)

    def _shared(self, a: set[tuple], b: set[tuple]) -> list[tuple]:
        """Return the places that both have; a value without a place is repeated at those of the
        other.
        """
        if a == {ANYWHERE} or b == {ANYWHERE}:
            return sorted((a | b) - {ANYWHERE}) or [ANYWHERE]
        return sorted((a & b) - {ANYWHERE})

    def _level(self, cells: list[tuple[str, str]], place: tuple) -> np.ndarray:
        values = [self._places[cell].get(place, self._places[cell].get(ANYWHERE)) for cell in cells]
        # A small study may have a design of one architecture and not of another.
        return _mean_of_rows(
            [value for value in values if value is not None] or [np.full(1, np.nan)]
        )

    def _lowest(
        self, cells: list[tuple[str, str]], place: tuple, shared: list[tuple]
    ) -> np.ndarray:
        """Return the architecture that is lowest over all cells at a place of the design."""
        means = _stacked(
            [_mean_of_rows([self._level([cell], p) for p in shared]) for cell in cells]
        )
        ranked = np.where(np.isnan(means), np.inf, means)
        levels = _stacked([self._level([cell], place) for cell in cells])
        return np.take_along_axis(levels, ranked.argmin(axis=0)[None], axis=0)[0]

    def _normalised(
        self, mine: list[tuple[str, str]], reference: list[tuple[str, str]], lowest: bool
    ) -> _Gap:
        """Return the differences of means over all models, over the metric's range."""
        level = _mean_of_rows([self._all[cell] for cell in mine])
        rows = [self._all[cell] for cell in reference]
        if not rows:
            base = np.zeros_like(level)
        elif lowest:
            stacked = np.stack(rows)
            base = np.where(np.isnan(stacked), np.inf, stacked).min(axis=0)
        else:
            base = _mean_of_rows(rows)
        if not self._range > 0.0:
            return _NO_GAP
        return _Gap((level - base) / self._range, base / self._range, _NO_DESIGNS)


ANYWHERE = ()
"""The place of what has neither ω_t nor an input of the actuation."""


def _correlation(effect: Correlation, runs: Resampled, count: Count) -> EffectEstimate:
    models = runs.models
    if not {effect.a, effect.b} <= set(runs.table.columns):
        return NOT_KNOWN
    a, b = runs.values(effect.a, count), runs.values(effect.b, count)
    omega_t = models.omega_t
    if count.omega_t != ALL:
        keep = np.array([f"{x:g}" == count.omega_t for x in models.omega_t])
        a, b, omega_t = a[:, keep], b[:, keep], omega_t[keep]
    correlations = _correlated(a, b, omega_t)
    # Models are the designs: what varies beside them is ω_t.
    by_omega = [
        _correlated(a[:1, omega_t == omega], b[:1, omega_t == omega], omega_t[omega_t == omega])
        for omega in np.unique(omega_t[np.isfinite(omega_t)])
    ]
    estimate = _interval(
        _Gap(correlations, np.full(1, 1.0), complete(np.array(by_omega).reshape(1, -1)))
    )
    ends = np.clip([estimate.designs_low, estimate.designs_high], -1.0, 1.0)
    return replace(estimate, designs_low=float(ends[0]), designs_high=float(ends[1]))


def _correlated(a: np.ndarray, b: np.ndarray, omega_t: np.ndarray) -> np.ndarray:
    """Return the correlation within ω_t over the models that define both, of each row; NaN of
    too few.
    """
    defined = np.isfinite(a) & np.isfinite(b)
    a, b = (within_omega(np.where(defined, column, np.nan), omega_t) for column in (a, b))
    n = defined.sum(axis=1)
    if n[0] < MODELS:
        return np.full(1, np.nan)
    x, y = (np.where(defined, column, 0.0) for column in (a, b))
    x, y = (
        np.where(defined, column - column.sum(axis=1, keepdims=True) / n[:, None], 0.0)
        for column in (x, y)
    )
    scale = np.sqrt((x**2).sum(axis=1) * (y**2).sum(axis=1))
    return np.where(scale > 0.0, (x * y).sum(axis=1) / np.where(scale > 0.0, scale, 1.0), np.nan)


def _stacked(rows: list[np.ndarray], axis: int = 0) -> np.ndarray:
    """Return several [1 + resamples], or [1], as one array."""
    return np.stack(np.broadcast_arrays(*rows), axis=axis)


def _mean_of_rows(rows: list[np.ndarray]) -> np.ndarray:
    """Return the mean of the defined values of several [1 + resamples]."""
    return mean_defined(_stacked(rows, axis=-1))


def _interval(gap: _Gap) -> EffectEstimate:
    values = gap.values
    drawn = values[1:][np.isfinite(values[1:])]
    if not np.isfinite(values[0]) or len(drawn) < 0.5 * (len(values) - 1) or len(drawn) == 0:
        return NOT_KNOWN
    low, high = np.percentile(drawn, LEVEL)
    ends = (float(low), float(high)), crossed(gap.of_designs)
    return EffectEstimate(float(values[0]), *ends[0], float(gap.base[0]), *ends[1])
