"""The atlas of the legs' laws: what the feedback of every learned quadruped does, and which short
form keeps its score.

    python -m research.experiments.legs_atlas --dir results/legs_atlas  # ten minutes of CPU time
    python -m research.experiments.legs_atlas --report-only             # tables of the kept rows

Every run of the zoo's study `legs` that has feedback is explained as `tegotae explain` does. Short
forms are tried for the run of each family that its study selects, with one seed. A folder keeps
every controller, so that an interrupted call goes on.

Written to `research/reproduction/kept/atlas` are `legs.csv`, a row a run, and `legs.md`.
"""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

import tegotae as tg
from research.frame import main, markdown_table, write_rows, write_text
from research.reproduction.learning.atlas import GOOD, NONE, feedback_kinds
from research.reproduction.learning.curves import FITS, curve_numbers
from tegotae._support.documents import Document
from tegotae.analysis.short_forms import SHARES, forms_of_legs
from tegotae.study import CellResult, Study
from tegotae.systems.controller_file import load
from tegotae.systems.resolve import resolve
from tegotae.systems.zoo import study_of

TABLES = Path(__file__).resolve().parents[2] / "research" / "reproduction/kept/atlas"
BODY, STUDY = "quadruped-c", "legs"
"""The quadruped, and the zoo's study of its laws."""
GENERATIONS = 60
"""Generations of the retuning of a form, as in the atlas of one leg."""
COLUMNS = {"merit": "CoT⁻¹", "merit_cut": "cut", "merit_frozen": "frozen", "following": "following"}
CURVES = ("one harmonic", "two", "N", "1 - k N", "e^(-k N)", "1 - k N / (1 + s N)")
"""Formulas of `FITS`."""


@dataclass(frozen=True)
class LegsAtlas:
    """Simplify the learned laws of the legs, and fit formulas to them."""

    dir: Path = Path("results/legs_atlas")
    """Folder of what was measured; what is missing is measured into it."""
    report_only: bool = False
    """Make the tables of what `legs.csv` holds."""

    def run(self) -> None:
        """Measure what is missing, and write."""
        if not self.report_only:
            write_rows(TABLES / "legs.csv", measured(self.dir), digits=5)
        records = pd.read_csv(TABLES / "legs.csv")
        write_text(TABLES / "legs.md", tables(records))
        print(tables(records))


@dataclass(frozen=True)
class Explained:
    """A controller of the zoo, as a cell of a study (`tegotae.study.Study`)."""

    model: str
    run: int

    @property
    def name(self) -> str:
        """Name in the zoo."""
        return f"zoo:{STUDY}:{self.model}/{self.run}"

    @property
    def document(self) -> Document:
        """Return the document of the controller's weights and the settings of its explanation."""
        weights = study_of(STUDY).weights(self.model)[self.run]
        return {"name": self.name, "weights": weights.tolist(), **self.settings}

    @property
    def settings(self) -> dict[str, int]:
        """Generations and seeds of the retuning; none but of the selected run."""
        selected = self.run == study_of(STUDY).best(self.model)
        return {"retune": GENERATIONS if selected else 0, "retune_seeds": 1}

    @property
    def program(self) -> Hashable:
        """Runs of a model share programs."""
        return self.model

    def prepare(self) -> None:
        """Prepare nothing: the package has all that it needs."""

    def measure(self) -> CellResult:
        """Measure the scores, the numbers of the curves, and the share that each form preserves."""
        page = tg.load(self.name).explain(**self.settings).raw
        complete = page.evaluated["whole"]
        numbers = {"following": complete.following, "sound": float(complete.sound.mean())}
        for variant, suffix in (("whole", ""), ("cut", "_cut"), ("frozen", "_frozen")):
            numbers[f"merit{suffix}"] = page.evaluated[variant].mean.mean
        omega = float(page.released.omega[page.released.middle])
        sets = [curve_numbers(v, omega) for v in page.visited]  # of units with weights of their own
        numbers |= {name: float(np.mean([x[name] for x in sets])) for name in sets[0]}
        for form in page.forms:
            numbers[f"kept {form.name}"] = form.evaluated.mean.mean / complete.mean.mean
            numbers[f"cloned {form.name}"] = form.cloned.mean.mean / complete.mean.mean
        arrays = {name: np.array(value) for name, value in numbers.items()}
        return CellResult(self.document, load(self.name).software, arrays)


def cells() -> list[Explained]:
    """Return the runs with feedback."""
    return [
        Explained(model, run)
        for model, count in study_of(STUDY).models.items()
        if load(f"zoo:{STUDY}:{model}").controller.tegotae is not None
        for run in range(count)
    ]


def measured(folder: Path) -> list[dict[str, object]]:
    """Measure the missing controllers of a folder, and return one row per controller."""
    selection = cells()
    study = Study(folder, selection, title="explain", suffix=".legs.npz")
    study.run()
    names = [f"{kind} {form}" for form in forms_of_legs() for kind in ("kept", "cloned")]
    rows = []
    for cell, result in zip(selection, study.results(), strict=True):
        numbers = {name: float(value) for name, value in result.arrays.items()}
        labels = {"model": cell.model, "run": cell.run}
        rows.append(dict.fromkeys((*labels, *names), np.nan) | labels | numbers)
    kind = feedback_kinds(pd.DataFrame(rows))
    return [{**row, "kind": name} for row, name in zip(rows, kind, strict=True)]


def tables(records: pd.DataFrame) -> str:
    """Return scores and curves of every family, and of how many runs each form is the shortest."""
    families = [(str(name), group) for name, group in records.groupby("model", sort=False)]
    names = {name: f"`{name.partition('@')[0]}`" for name, _ in families}
    scores = [["family", "runs", *COLUMNS.values(), "what the feedback does"]]
    curves = [["family", "runs", *CURVES]]
    for name, group in families:
        means = [f"{group[column].mean():.2f}" for column in COLUMNS]
        counts = [f"{kind} {n}" for kind, n in group.kind.value_counts().items()]
        scores.append([names[name], str(len(group)), *means, ", ".join(counts)])
        if group[list(FITS)].notna().any(axis=None):
            shares = [f"{(group[fit] >= GOOD).sum()}" for fit in FITS]
            curves.append([names[name], str(len(group)), *shares])
    parts = [
        "Means over the runs:",
        markdown_table(scores),
        f"Runs with R² of at least {GOOD:g} of a formula of A′(φ), and of G R(N):",
        markdown_table(curves),
        "Runs of which each form is the shortest:",
        markdown_table(forms_table(records)),
    ]
    return "\n\n".join(part.strip() for part in parts) + "\n"


def forms_table(records: pd.DataFrame) -> list[list[str]]:
    """Count for each form the runs in which it is the shortest that preserves a share; of equally
    short ones the best."""
    system = resolve(BODY).controller().system
    numbers = {
        name: form.controller(system).layout["actuation"].start
        for name, form in forms_of_legs().items()
    }
    ranked = sorted(numbers, key=lambda name: numbers[name])

    tried = records[records[f"kept {ranked[0]}"].notna()]

    def shortest(row: pd.Series, share: float) -> str:
        enough = [name for name in ranked if row[f"kept {name}"] >= share]
        candidates = [name for name in enough if numbers[name] == numbers[enough[0]]]
        return max(candidates, key=lambda name: row[f"kept {name}"], default=NONE)

    shortest_by_share = {share: tried.apply(shortest, axis=1, share=share) for share in SHARES}
    lines = [["form", "numbers", *(f"keeps {share:.0%}" for share in SHARES)]]
    for name in (*ranked, NONE):
        counts = [str((names == name).sum()) for names in shortest_by_share.values()]
        lines.append([name, str(numbers.get(name, "")), *counts])
    return lines


if __name__ == "__main__":
    main(LegsAtlas)
