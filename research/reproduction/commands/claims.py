"""`python -m research.reproduction claims`: what results say of each of the paper's claims."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from tegotae._support.errors import TegotaeError
from tegotae._support.files import output_folder, write_atomically
from tegotae.api.parameters import POSITIONAL

if TYPE_CHECKING:
    from research.reproduction.claims.findings import Finding


@dataclass(frozen=True)
class StudyClaims:
    """Evaluate the paper's claims one by one, in every way of counting the results."""

    source: Annotated[Path, POSITIONAL]
    """A table of `python -m research.reproduction export` (.csv), or a study's folder."""
    out: Path | None = None
    """Folder for claims.md, claims-by-design.md, claims.png, and effects.csv with the effect of
    every claim in every way of counting."""
    experiments: Path | None = None
    """Folder of the experiments beside the study: figure3.csv, parameter_limit.csv and
    gain_map.ridge.csv."""
    budgets: Path | None = None
    """Table of the same runs by training budget (.csv), from `python -m research.reproduction
    export`; a study's folder contains it."""
    sampled: Path | None = None
    """Table of controllers drawn from the final distribution of each run (.csv), from `tegotae
    study export`; it adds a way of counting. A study's folder contains it."""
    beside: tuple[Path, ...] = ()
    """Tables of other studies (.csv), or their folders, with outcomes to show beside. Drawn
    controllers (RUNS-sampled.csv for RUNS.csv) and experiments are read from the table's folder."""
    calibrated: tuple[Path, ...] = ()
    """Tables of a body that was chosen to agree with statements on V: such a statement is then
    *selected for*, not reproduced. A study's folder names its body."""
    readings: Path | None = None
    """Folder of a multiverse's tables, from `python -m research.reproduction readings export`. It
    adds the number of readings with each verdict."""

    def run(self) -> None:
        """Judge, print, and write if asked to."""
        from research.reproduction.claims.budgets import by_budget
        from research.reproduction.claims.counting import Count, with_sampled
        from research.reproduction.claims.effect_table import effects_csv
        from research.reproduction.claims.findings import findings
        from research.reproduction.commands.study import tables_of
        from research.reproduction.figures.claims import claims_figure, has_effects
        from research.reproduction.readings.tables import read_tables
        from research.reproduction.report.atomic import (
            beside_table,
            by_budget_table,
            designs_table,
            outcomes_table,
        )
        from research.reproduction.report.multiverse import counts_by_claim
        from tegotae.figures.style import save_figure

        if strangers := {*self.calibrated}.difference({self.source, *self.beside}):
            raise TegotaeError(
                f"--calibrated names {min(strangers)}; it must be one of the tables given"
            )
        tables = tables_of(self.source, self.budgets, self.sampled)
        selected = tables.selected | self._selected(self.source)
        runs = with_sampled(tables.runs, tables.sampled)
        results = findings(runs, self.experiments, selected=selected)
        beside = {path.stem: self._beside(path) for path in self.beside}
        for finding in results:
            print(f"{finding.claim.name:26} {finding.outcome}")
        if self.out is None:
            return
        texts = {
            "claims.md": outcomes_table(results),
            "claims-by-design.md": designs_table({self.source.stem: results, **beside}),
            "effects.csv": effects_csv(results),
        }
        texts |= {f"effects-{name}.csv": effects_csv(finding) for name, finding in beside.items()}
        columns = {}
        if self.readings is not None:
            columns = counts_by_claim(*read_tables(self.readings))
        if beside or columns:
            texts["claims-beside.md"] = beside_table(results, beside, columns)
        if tables.budgets is not None:
            budgets = {
                name: findings(runs, options=[Count()], selected=selected)
                for name, runs in by_budget(tables.budgets, tables.runs).items()
            }
            texts["claims-by-budget.md"] = by_budget_table(budgets)
        output_folder(self.out)
        for name, text in texts.items():
            write_atomically(self.out / name, text)
        pictures = {"claims.png": claims_figure(results)} if has_effects(results) else {}
        for name, figure in pictures.items():
            save_figure(figure, self.out / name)
        print(f"wrote {', '.join([*texts, *pictures])} to {self.out}")

    def _selected(self, table: Path) -> frozenset[str]:
        from research.reproduction.calibration.scores import EVALUATED_AS

        return frozenset(EVALUATED_AS.values() if table in self.calibrated else ())

    def _beside(self, path: Path) -> list[Finding]:
        """Return the findings of another study; experiments of another body do not count."""
        from research.reproduction.claims.counting import with_sampled
        from research.reproduction.claims.findings import findings
        from research.reproduction.commands.study import tables_of

        drawn = path.with_name(f"{path.stem}-sampled{path.suffix}")
        tables = tables_of(path, sampled=drawn if drawn.is_file() else None)
        runs = with_sampled(tables.runs, tables.sampled)
        folder = path if path.is_dir() else path.parent
        return findings(runs, folder, selected=tables.selected | self._selected(path))
