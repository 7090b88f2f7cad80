"""Ways to count the same records: what is done with which episodes, runs, frequencies and models.

The paper does not say. A run's table has a row per model and run, its metrics being means over the
episodes that define them; a table with the column `omega` has a row per episode as well.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass, fields

import numpy as np

from research.reproduction.table import StudyTable
from tegotae.measures.evaluation import Protocol

DROPPED, WORST, AT_REST = "dropped", "worst", "at rest"
MEAN, BEST, SAMPLED = "mean of runs", "best run", "sampled"
ALL = "both"
BY_DESIGN, FIGURE_2 = "by design", "as in Fig. 2"


@dataclass(frozen=True)
class Count:
    """One way to count.

    Args:
        unsettled: what becomes of an episode without a limit cycle. `DROPPED`: it is left out, and
            a body at rest has a CoT⁻¹ of zero. `WORST`: it has a CoT⁻¹ of zero, and transients as
            long as the episode. `AT_REST`, of a table that does not say how many episodes are at
            rest, whose zeros are in the run's mean already: all but the failed are taken to be,
            which is the largest that CoT⁻¹ can be, as `WORST` is the least.
        run: what a model's number is. `MEAN`: the mean of its runs. `BEST`: the run of highest
            fitness in training, or the mean of those that share it. `SAMPLED`: a controller drawn
            from the final distribution of that run, if the table has such rows (`sample` ≥ 1).
        omega_t: the training frequency that counts, such as "4" [rad/s], or `ALL`.
        average: `BY_DESIGN`: differences at equal ω_t and input of the actuation, averaged over
            these, in the metric's unit. `FIGURE_2`: differences of means over all models of an
            architecture, over the range that the metric has among all models.
    """

    unsettled: str = DROPPED
    run: str = MEAN
    omega_t: str = ALL
    average: str = BY_DESIGN

    @property
    def label(self) -> str:
        """Label in tables.

        Example:
            >>> Count(omega_t="4").label
            'dropped, mean of runs, ω_t 4, by design'
        """
        omega = "all ω_t" if self.omega_t == ALL else f"ω_t {self.omega_t}"
        return f"{self.unsettled}, {self.run}, {omega}, {self.average}"


CHOICES = {
    "unsettled": "unsettled episodes",
    "run": "which run",
    "omega_t": "ω_t",
    "average": "averaging",
}
"""The choices that counts differ in, in words."""


def counts(table: StudyTable) -> list[Count]:
    """Return every way to count a table, the study's own first.

    Example:
        >>> import numpy as np
        >>> len(counts(StudyTable({"model": np.array(["a"]), "omega_t": np.array([4.0])})))
        24
    """
    omegas = np.unique(table["omega_t"][np.isfinite(table["omega_t"])])
    has_rest = has_episodes(table) or _REST in table.columns
    unsettled = (DROPPED, WORST) if has_rest else (DROPPED, WORST, AT_REST)
    sampled = (SAMPLED,) if (table.columns.get("sample", np.zeros(1)) > 0).any() else ()
    return [
        Count(*options)
        for options in itertools.product(
            unsettled,
            (MEAN, BEST, *sampled),
            (ALL, *(f"{omega:g}" for omega in omegas)),
            (BY_DESIGN, FIGURE_2),
        )
    ]


def differ_in(a: Count, b: Count) -> list[str]:
    """Return the choices in which two counts differ."""
    return [f.name for f in fields(Count) if getattr(a, f.name) != getattr(b, f.name)]


def with_sampled(table: StudyTable, sampled: StudyTable | None) -> StudyTable:
    """Return the runs and, as a second sample of each, the controller drawn from its distribution.

    Args:
        table: a row a run.
        sampled: the same of the drawn controllers; None of a study that has none.
    """
    if sampled is None:
        return table
    samples = [
        {**part.columns, "sample": np.full(len(part), i)} for i, part in enumerate((table, sampled))
    ]
    shared = [name for name in samples[0] if name in samples[1]]
    return StudyTable({name: np.concatenate([part[name] for part in samples]) for name in shared})


def has_episodes(table: StudyTable) -> bool:
    """Return whether a table has a row per episode."""
    return "omega" in table.columns


def metric_per_run(
    table: StudyTable, metric: str, unsettled: str, protocol: Protocol | None = None
) -> StudyTable:
    """Return the rows of the runs with one metric, as the way to count requires.

    Args:
        table: of runs or of episodes.
        metric: the metric's name.
        unsettled: `DROPPED`, `WORST` or `AT_REST`.
        protocol: of the evaluation; its times are what the worst transients are.

    Returns:
        a row per model and run (and sample, if there are any); the metric is NaN where undefined.
    """
    protocol = protocol or Protocol()
    values = table[metric]
    settled = table.columns.get("limit_cycle_share", np.ones(len(table)))
    if metric == "cpgu":  # without a gait of its own no clamped phase gives one either
        values = np.where((settled > 0.0) | (unsettled != DROPPED), values, np.nan)
    elif metric in _WORST and unsettled != DROPPED:
        share = np.ones(len(table)) if has_episodes(table) else _share(table, metric, unsettled)
        worst = _WORST[metric](protocol)
        defined = np.isfinite(values)
        values = np.where(defined, share * np.nan_to_num(values) + (1.0 - share) * worst, worst)
    columns = {**table.columns, metric: values}
    return _episodes_averaged(columns, metric) if has_episodes(table) else StudyTable(columns)


_REST = "at_rest_share"

_WORST = {
    "cot_inverse": lambda protocol: 0.0,
    "cot_inverse_total": lambda protocol: 0.0,
    "t0_s": lambda protocol: protocol.undisturbed_s,
    "t1_s": lambda protocol: protocol.disturbed_s,
}
"""The worst values of the metrics that have one; others are left out where undefined."""


def _share(table: StudyTable, metric: str, unsettled: str) -> np.ndarray:
    """Return the share of a run's episodes over which its mean is taken."""
    settled = table["limit_cycle_share"]
    if metric == "t1_s":
        return settled * np.nan_to_num(table["recovery_share"])
    if metric.startswith("cot") and _REST in table.columns:
        return settled + table[_REST]
    if metric.startswith("cot") and unsettled == AT_REST:
        return 1.0 - table["failed_share"]
    return settled


def _episodes_averaged(columns: dict[str, np.ndarray], metric: str) -> StudyTable:
    """Return one row per run: the mean of one metric over the episodes that define it."""
    names = ["model", "run", *(["sample"] if "sample" in columns else [])]
    keys = list(zip(*(columns[name].tolist() for name in names), strict=True))
    rows: dict[tuple, list[int]] = {}
    for row, key in enumerate(keys):
        rows.setdefault(key, []).append(row)
    first = [indices[0] for indices in rows.values()]
    averaged = {name: column[first] for name, column in columns.items()}
    values = columns[metric]
    means = []
    for indices in rows.values():
        defined = values[indices][np.isfinite(values[indices])]
        means.append(defined.mean() if len(defined) else np.nan)
    averaged[metric] = np.array(means)
    return StudyTable(averaged)
