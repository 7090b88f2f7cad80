"""The table of judged runs: a row a run, with what the analysis asks of it."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import numpy as np
import pandas as pd

from research.reproduction.claims.designs import DRIVES
from research.reproduction.claims.effects import LEARNED_FEEDBACK
from research.reproduction.hop_rates import rate_slope
from research.reproduction.learning.judged import VARIANTS, episode_merits
from research.reproduction.learning.searched import CMA, DE, SearchedLaw
from research.reproduction.table import design_place
from tegotae._support import tables
from tegotae._support.errors import TegotaeError
from tegotae.measures.statistics import mean_defined
from tegotae.study import Arrays
from tegotae.systems.experiment import Experiment
from tegotae.systems.recipe import recipe
from tegotae.systems.term_sets import ShortLaw

DESIGN = ("model", "architecture", "senses", "drive", "omega_t")
LAW = "law"
"""The architecture of short laws in this table."""
LOCKED = 0.05
"""Largest deviation of the hop rate from ω of an episode that follows the command, over ω."""
_COLUMNS = (*DESIGN, "fitness", "settled", "merit", "merit_chosen", "merit_judged")
_KIND = "table that python -m research.reproduction learning wrote"


SEARCHED = {DE: "law by DE", CMA: "law by CMA-ES"}
"""The architectures of searched laws in this table."""


def run_rows(experiment: Experiment, fitness: np.ndarray, arrays: Arrays) -> pd.DataFrame:
    """Return the table of the runs of an experiment.

    Args:
        experiment: what was trained.
        fitness: of the training, [runs].
        arrays: of `research.reproduction.learning.judged.judge_runs`.

    Returns:
        A row a run: `model`, `architecture` (of short laws `LAW`), `senses`, `drive` (what the
        actuation follows; of short laws the law), `omega_t` [rad/s], `run`, `fitness` of the
        training; `settled`, the share of episodes with a limit cycle; `cot_inverse` of those [m/J];
        `merit`, `merit_cut`, `merit_frozen`, the mean of CoT⁻¹ with unsettled episodes as 0 [m/J];
        `merit_chosen` and `merit_judged`, of the first half of the releases and of the others;
        `locked_chosen` and `locked_judged`, the same with episodes as 0 whose hop rate is further
        from ω than `LOCKED`; `following`, the slope of the hop rate over ω.
    """
    settled, cot = arrays["limit_cycle_share"].astype(float), arrays["cot_inverse"].astype(float)
    paid = episode_merits(settled, cot)
    merit = paid.mean(axis=(2, 3))
    half = paid.shape[2] // 2
    rates = mean_defined(np.moveaxis(arrays["hop_rate"][0].astype(float), 1, -1))
    runs = merit.shape[1]
    table = pd.DataFrame({"run": np.arange(runs), "fitness": fitness[:runs]})
    for i, (name, value) in enumerate(_design(experiment.name).items()):
        table.insert(i, name, value)
    table["settled"] = settled[0].mean(axis=(1, 2))
    cells = np.where(settled[0] == 1.0, cot[0], np.nan).reshape(runs, -1)
    table["cot_inverse"] = mean_defined(cells)
    for variant, values in zip(VARIANTS, merit, strict=False):
        table["merit" if variant == VARIANTS[0] else f"merit_{variant}"] = values
    omega = np.array(experiment.omega + np.asarray(experiment.protocol.offsets), float)
    follows = np.abs(arrays["hop_rate"][0].astype(float) - omega) <= LOCKED * omega
    for name, values in (("merit", paid[0]), ("locked", np.where(follows, paid[0], 0.0))):
        table[f"{name}_chosen"] = values[:, :half].mean(axis=(1, 2))
        table[f"{name}_judged"] = values[:, half:].mean(axis=(1, 2))
    table["following"] = rate_slope(omega, rates)
    return table


def searched_rows(law: SearchedLaw, arrays: Arrays) -> pd.DataFrame:
    """Return the table of the laws of a search: that of differential evolution first."""
    table = run_rows(law.experiment, arrays["best_fitness"], arrays)
    table["architecture"] = [SEARCHED[DE], *[SEARCHED[CMA]] * (len(table) - 1)]
    return table


def _design(name: str) -> dict[str, object]:
    trained = recipe(name)
    if isinstance(trained.terms, ShortLaw):
        keys = name, LAW, "F", trained.terms.name, trained.omega_t
    else:
        model = design_place(trained)
        drive = DRIVES.get(model["actuation"], "")
        keys = (
            *(name, model["architecture"], model["observation"]),
            *(drive, model["omega_t"]),
        )
    return dict(zip(DESIGN, keys, strict=True))


def read_runs(path: Path) -> pd.DataFrame:
    """Return the table of a file.

    Raises:
        TegotaeError: if it cannot be read, is no such table, or lacks V or learned feedback.
    """
    cells = tables.read_csv(path, _COLUMNS, kind=_KIND)
    try:
        columns = {
            name: column if name in DESIGN[:-1] else tables.parse_numbers(column)
            for name, column in cells.items()
        }
    except ValueError:
        raise TegotaeError(f"{path} is no {_KIND}: it holds what is no number") from None
    runs = pd.DataFrame(columns)
    for architecture in (*LEARNED_FEEDBACK, "V"):
        if not (runs.architecture == architecture).any():
            raise TegotaeError(f"{path} has no runs of {architecture}; judge a whole study")
    return runs


def where(runs: pd.DataFrame, mask: pd.Series) -> pd.DataFrame:
    """Return the rows of a table that meet a condition."""
    return pd.DataFrame(runs[mask])


def concatenate_runs(tables: Iterable[pd.DataFrame]) -> pd.DataFrame:
    """Join tables of several records, in the order of ω_t, architecture and drive."""
    table = pd.concat(list(tables), ignore_index=True)
    return table.sort_values(["omega_t", "architecture", "drive", "model", "run"], kind="stable")
