"""Short forms in place of learned feedback: those of many controllers retuned together in closed
loop, and judged from the common releases."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from research.reproduction.learning.curves import saved_runs
from research.reproduction.learning.judged import by_release, episode_merits, episodes_of
from research.reproduction.record import Record
from research.reproduction.unit import record_key
from tegotae._support.documents import Document
from tegotae._support.errors import require_count
from tegotae.analysis.short_forms import forms_of_a_leg, retuned, training_of
from tegotae.parts.controller import Controller
from tegotae.study import Arrays, CellResult
from tegotae.systems.vanilla import PRESETS


def leg_controller(form: str) -> Controller:
    """Return the controller of a short form on the paper's hopper."""
    return forms_of_a_leg()[form].controller(PRESETS["paper"].system("sector"))


@dataclass(frozen=True)
class Retuning:
    """Retuning of a form that starts from the curves of a controller.

    Args:
        generations: of its training.
        seeds: number of runs, of which the one of highest training fitness is taken.
    """

    generations: int = 60
    seeds: int = 1

    def __post_init__(self) -> None:
        require_count("generations", self.generations)
        require_count("seeds", self.seeds)


@dataclass(frozen=True)
class FormOfControllers:
    """One form, retuned from each of several controllers, as a cell of a study.

    Args:
        form: its name in the library.
        omega_t: frequency of the training of all of them [rad/s].
        records: what was trained.
        runs: which run of each.
        starts: the numbers that its curves give the form, [records, n_weights].
        retuning: how it is retuned.
    """

    form: str
    omega_t: float
    records: Sequence[Record]
    runs: Sequence[int]
    starts: np.ndarray
    retuning: Retuning

    @property
    def name(self) -> str:
        """The form and the frequency."""
        return f"{self.form}-w{self.omega_t:g}"

    @property
    def document(self) -> Document:
        """Return the form, its starting point and the settings of its retuning."""
        return {
            "form": self.form,
            "records": [record_key(record.configuration) for record in self.records],
            "runs": list(self.runs),
            "generations": self.retuning.generations,
            "seeds": list(range(self.retuning.seeds)),
        }

    @property
    def program(self) -> Hashable:
        """A form is a program."""
        return self.form

    def prepare(self) -> None:
        """Prepare nothing: the package has all that it needs."""

    def measure(self) -> CellResult:
        """Measure its numbers, `weights`, [records, n_weights], and `cloned` and `merit`,
        [records]: the merit with the numbers of the curves, and with those retuned.
        """
        controller = leg_controller(self.form)
        training = training_of(saved_runs(self.records[0])[0], controller)
        n = self.retuning.seeds
        seeds = np.tile(np.arange(n), len(self.records)).tolist()
        starts = np.repeat(self.starts, n, axis=0)
        runs, fitness = retuned(training, starts, self.retuning.generations, seeds)
        rows = np.arange(len(self.records)) * n + fitness.reshape(-1, n).argmax(axis=1)
        evaluated = replace(training, protocol=self.records[0].experiment.protocol)
        arrays: Arrays = {"weights": runs[rows]}
        for name, weights in (("cloned", self.starts), ("merit", runs[rows])):
            of_form = episodes_of(evaluated, controller, weights, evaluated.protocol)
            settled, cot = (by_release(of_form, x) for x in ("limit_cycle_share", "cot_inverse"))
            arrays[name] = episode_merits(settled, cot).mean(axis=(1, 2))
        return CellResult(self.document, self.records[0].software, arrays)
