"""The study's results as one table: a row per model and run."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import NotRequired, TypedDict

import numpy as np

from research.reproduction.hop_rates import nearer_resonance, rate_slope
from research.reproduction.record import Record
from tegotae._support.errors import TegotaeError
from tegotae.measures.hopping.metrics import HOPPING, Conditions, DerivedMetric, derived
from tegotae.measures.metric import Metric
from tegotae.measures.optimum import has_table
from tegotae.measures.statistics import mean_defined
from tegotae.systems.experiment import Experiment
from tegotae.systems.observations import OBSERVATIONS
from tegotae.systems.recipe import Recipe, study_recipe, study_recipes

ARCHITECTURES = ("V", "VG", "VT", "VGT", "AR", "ART", "ARG", "ARGT", "T")
"""The architectures that the paper shows, in its order. Models that learn A or R
alone have others, and a user's experiment one of its own, by its name."""

_DESIGN = (
    *("model", "architecture", "learned", "reaction", "gain", "actuation", "observation"),
    *("omega_t", "parameters", "run"),
)
_TRAINING = ("best_fitness", "episodes_trained", "ended", "training_budget")


@dataclass(frozen=True)
class StudyTable:
    """Columns of equal length. Metrics are means over a run's episodes, NaN where undefined.

    Args:
        columns: by name: `model`, `architecture`, `learned`, `reaction`, `gain`, `actuation`,
            `observation`, `omega_t` [rad/s], `parameters` (how many are learned), `run`,
            `best_fitness`, `episodes_trained`, `ended`, and the metrics that it holds; in a table
            of budgets also `training_budget` [episodes].
    """

    columns: dict[str, np.ndarray]

    def __len__(self) -> int:
        return len(self.columns["model"])

    def __getitem__(self, name: str) -> np.ndarray:
        try:
            return self.columns[name]
        except KeyError:
            raise TegotaeError(f"the table has no column {name}") from None

    @property
    def metrics(self) -> tuple[str, ...]:
        """The names of the metrics that it holds."""
        return tuple(name for name in self.columns if name not in (*_DESIGN, *_TRAINING))

    def metrics_shown(self, place: str) -> tuple[Metric, ...]:
        """Return its metrics that are shown at a place, such as "figure".

        One that follows from others but is undefined in every row is left out: the table is from
        before there was the metric, or there is none on this body.
        """
        return tuple(
            metric
            for metric in HOPPING.metrics(place)
            if metric.name in self.columns
            and not (isinstance(metric, DerivedMetric) and np.isnan(self[metric.name]).all())
        )

    def where(self, **values: str | float | tuple[str | float, ...]) -> StudyTable:
        """Return the rows in which each named column has the given value, or one of a tuple of
        values.
        """
        keep = np.ones(len(self), bool)
        for name, value in values.items():
            allowed = value if isinstance(value, tuple) else (value,)
            keep &= np.isin(self[name], allowed)
        return self._rows(keep)

    def _rows(self, keep: np.ndarray) -> StudyTable:
        return StudyTable({name: column[keep] for name, column in self.columns.items()})

    def of_the_paper(self) -> StudyTable:
        """Return the rows of the paper's models, at any ω_t, without those of experiments beside
        them.
        """
        return self._rows(self["architecture"] != self["model"])

    def beside_the_paper(self) -> StudyTable:
        """Return the rows of experiments that are none of the paper's models."""
        return self._rows(self["architecture"] == self["model"])

    def per_model(self) -> StudyTable:
        """Return one row per model: means over its runs of the defined values."""
        names, first = np.unique(self.columns["model"], return_index=True)
        order = np.argsort(first)
        names, first = names[order], first[order]
        columns = {}
        for name, column in self.columns.items():
            if column.dtype.kind == "f":
                groups = [column[self.columns["model"] == model] for model in names]
                columns[name] = np.array([float(mean_defined(group)) for group in groups])
            else:
                columns[name] = column[first]
        return StudyTable(columns)


def tabulate(records: Iterable[Record]) -> StudyTable:
    """Return the table of some records, in the order of the registry of models."""
    return table_of_runs(
        (record_place(record), _training(record), means(record, record.episodes))
        for record in registry_order(records)
    )


def tabulate_budgets(records: Iterable[Record]) -> StudyTable | None:
    """Return the table after each budget of training, in the column `training_budget`, or None
    without any.

    What is not trained is the same after each.
    """
    rows = []
    for record in registry_order(records):
        for i, budget in enumerate(record.budgets):
            training = _training(record)
            episodes = np.minimum(training.pop("episodes_trained"), budget)
            training |= {"training_budget": np.full(len(episodes), budget)}
            training |= {"episodes_trained": episodes, "best_fitness": _best(record, budget)}
            at_budget = {name: values[i] for name, values in record.at_budgets.items()}
            rows.append(
                (record_place(record), training, means(record, at_budget or record.episodes))
            )
    return table_of_runs(rows) if rows else None


def tabulate_sampled(records: Iterable[Record]) -> StudyTable:
    """Return the table of the controllers that were drawn from each run's final distribution."""
    return table_of_runs(
        (record_place(record), _training(record), means(record, record.sampled))
        for record in registry_order(records)
    )


def registry_order(records: Iterable[Record]) -> list[Record]:
    """Return records in the order of the registry of models, with those of other experiments
    behind them.
    """
    by_name = {record.model: record for record in records}
    extra = sorted(by_name.keys() - study_recipes().keys())
    return [by_name[name] for name in (*study_recipes(), *extra) if name in by_name]


def means(record: Record, episodes: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Return the means over the episodes of the defined values, of all known and derived
    metrics.
    """
    derived = with_derived(record, episodes)
    averaged = {name: mean_defined(values) for name, values in derived.items()}
    return averaged | _hop_rates(record, derived.get("hop_rate"))


def _hop_rates(record: Record, hop_rate: np.ndarray | None) -> dict[str, np.ndarray]:
    """Summarise the hop rates of a run's episodes, [runs] each by name."""
    if hop_rate is None:
        return {}
    rates, omega = np.asarray(hop_rate, float), np.asarray(record.omega, float)
    rates_by_name = {"rate_slope": rate_slope(omega, rates)}
    try:
        experiment = record.experiment
    except TegotaeError:  # of a part that is not registered here
        return rates_by_name
    if has_table(experiment.body, experiment.protocol.work):
        rates_by_name["nearer_resonance"] = nearer_resonance(omega, rates)
    return rates_by_name


def with_derived(record: Record, episodes: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Return the metrics of a record's episodes, and those that follow from them (`derived`).

    They are found episode by episode, as a mean's is another thing than the mean.
    """
    try:
        experiment = record.experiment
    except TegotaeError:  # of a part that is not registered here
        return episodes
    protocol = experiment.protocol
    conditions = Conditions(experiment.body, protocol.work, protocol.drop_m)
    return episodes | derived(episodes, conditions)


def _training(record: Record) -> dict[str, np.ndarray]:
    """Summarise each run's training, [runs] each."""
    return {
        "best_fitness": record.best_fitness,
        "episodes_trained": record.generations * record.population,
        "ended": record.ended,
    }


def _best(record: Record, budget: int) -> np.ndarray:
    """Return the best fitness of the distribution's mean within a budget of episodes, [runs]."""
    if not record.curves:
        return record.best_fitness
    generations = math.ceil(budget / record.population)
    return np.nanmax(record.curves["centre_fitness"][:generations], axis=0)


class DesignPlace(TypedDict):
    """Position of a model in the study's design: entries of a table's row."""

    model: str
    architecture: str
    learned: str
    reaction: str
    gain: str
    actuation: str
    observation: str
    omega_t: float
    """[rad/s]; NaN without an oscillator."""
    parameters: NotRequired[int]


def table_of_runs(
    sets: Iterable[tuple[DesignPlace, dict[str, np.ndarray], dict[str, np.ndarray]]],
) -> StudyTable:
    """Return the table of (place in the design, training of its runs, metrics of its runs), [runs]
    each.

    It has the metrics of any of them, in the order in which metrics are shown; a metric that a
    model lacks is undefined there.
    """
    sets = list(sets)
    reported = {name for _, _, values in sets for name in values}
    held = [
        *(name for name in HOPPING.names() if name in reported),
        *sorted(reported.difference(HOPPING.names())),
    ]
    rows: dict[str, list] = {}
    for place, training, measured in sets:
        for i in range(len(training["best_fitness"])):
            row = {
                **place,
                "run": i,
                **{key: values[i].item() for key, values in training.items()},
                **{m: float(measured[m][i]) if m in measured else np.nan for m in held},
            }
            for key, entry in row.items():
                rows.setdefault(key, []).append(entry)
    return StudyTable({key: np.array(values) for key, values in rows.items()})


def record_place(record: Record) -> DesignPlace:
    """Return the position of a record's experiment in the study's design; if in none, a row of its
    own."""
    name, omega = record.model, record.experiment.omega
    parameters = record.weights.shape[-1]
    if (model := study_recipe(name)) is not None:
        return {**design_place(model), "parameters": parameters}
    senses = _senses(record.experiment)
    observations = (
        x.name for x in OBSERVATIONS.values() if {*x.senses} == senses and not x.of_body
    )
    omega_t = np.nan if omega is None else omega
    return {
        "model": name,
        "architecture": name,
        "learned": "",
        "reaction": "",
        "gain": "",
        "actuation": "",
        "observation": next(observations, ""),
        "omega_t": omega_t,
        "parameters": parameters,
    }


def _senses(experiment: Experiment) -> set[str]:
    """Return the senses of the body that the controller's terms read."""
    reads = {name for term in experiment.controller.terms.values() for name in term.reads}
    return reads.intersection(experiment.body.SENSES)


def design_place(model: Recipe) -> DesignPlace:
    """Return a model's position in the study's design."""
    return {
        "model": model.name,
        "architecture": model.terms.architecture,
        "learned": "".join(model.terms.learned),
        "reaction": model.learned_terms.reaction or "",
        "gain": model.learned_terms.gain or "",
        "actuation": model.actuation,
        "observation": "Fv" if "velocity" in model.observation else "F",
        "omega_t": np.nan if model.omega_t is None else model.omega_t,
    }
