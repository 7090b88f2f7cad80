"""`python -m research.reproduction learning`: what learning adds, judged from common releases."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from tegotae._support import tables
from tegotae._support.errors import TegotaeError
from tegotae._support.files import output_folder, write_atomically
from tegotae.api.parameters import POSITIONAL

if TYPE_CHECKING:
    from pandas import DataFrame

    from research.reproduction.record import Record


@dataclass(frozen=True)
class _OfStudy:
    dir: Path
    """The study's folder; what is missing is measured into it."""
    out: Path
    """Folder of the tables: NAME.csv with a row a run, NAME.md, and of an atlas NAME.png."""
    name: str = "runs"
    """Name of these files."""
    models: str = "*"
    """Only models with such names, with * and ? as in a shell."""

    @property
    def records(self) -> list[Record]:
        """The study's complete records of such names; errors of others are printed."""
        from fnmatch import fnmatchcase

        from research.reproduction.folder import Folder

        records, damaged = Folder(self.dir).all()
        for message in damaged:
            print(message)
        records = [record for record in records if fnmatchcase(record.model, self.models)]
        if not records:
            raise TegotaeError(f"{self.dir} has no whole record of {self.models}; run the study")
        return records

    def write(self, runs: DataFrame, page: str) -> None:
        """Write one row per run, and the page about them."""
        text = tables.csv_text({name: runs[name].tolist() for name in runs}, digits=5)
        write_atomically(self.out / f"{self.name}.csv", text)
        write_atomically(self.out / f"{self.name}.md", page)
        print(f"{len(runs)} runs in {self.out / self.name}.csv")


@dataclass(frozen=True)
class StudyLearning(_OfStudy):
    """Judge every run of a study whole, with its feedback cut, and with it frozen."""

    undisturbed: float | None = None
    """Duration of an episode [s]; by default that of the study's evaluation."""
    tick: float | None = None
    """Control period [s], likewise."""
    searched: bool = False
    """Search the study's short laws, too, by differential evolution and by CMA-ES."""

    def run(self) -> None:
        """Judge what is missing, and write."""
        from research.reproduction.learning.judged import EvaluatedRuns
        from research.reproduction.learning.page import feedback_table
        from research.reproduction.learning.runs import concatenate_runs, run_rows, searched_rows
        from research.reproduction.learning.searched import SearchedLaw
        from tegotae.study import Study
        from tegotae.systems.recipe import recipe
        from tegotae.systems.term_sets import ShortLaw

        records = self.records
        output_folder(self.out)
        cells = [EvaluatedRuns(record, self.undisturbed, self.tick) for record in records]
        study = Study(self.dir / "judged", cells, title="judge", suffix=".judged.npz")
        study.run()
        runs = [
            run_rows(record.experiment, record.best_fitness, result.arrays)
            for record, result in zip(records, study.results(), strict=True)
        ]
        if self.searched:
            laws = [
                SearchedLaw(record.experiment)
                for record in records
                if isinstance(recipe(record.model).terms, ShortLaw)
            ]
            search = Study(self.dir / "searched", laws, title="search", suffix=".searched.npz")
            search.run()
            runs += [
                searched_rows(law, result.arrays)
                for law, result in zip(laws, search.results(), strict=True)
            ]
        table = concatenate_runs(runs)
        self.write(table, feedback_table(table))


@dataclass(frozen=True)
class StudyPrimary:
    """Write the primary analysis: what learned feedback adds to V, and to the best short law."""

    sources: Annotated[tuple[Path, ...], POSITIONAL]
    """Tables of `python -m research.reproduction learning`, one a body, which its file names."""
    out: Path | None = None
    """Folder for NAME.md, NAME-by-omega.md and NAME.png."""
    name: str = "primary"
    """Name of these files."""

    def run(self) -> None:
        """Compute, print, and write if asked to."""
        from research.reproduction.figures.learning import learning_figure
        from research.reproduction.learning.page import primary_tables
        from research.reproduction.learning.runs import read_runs
        from tegotae.figures.style import save_figure

        readings = {path.stem: read_runs(path) for path in self.sources}
        if self.out is not None:
            output_folder(self.out)
        overall, by_omega = primary_tables(readings)
        if self.out is not None:
            write_atomically(self.out / f"{self.name}.md", overall)
            write_atomically(self.out / f"{self.name}-by-omega.md", by_omega)
            save_figure(learning_figure(readings), self.out / f"{self.name}.png")
        print(f"{overall}\n{by_omega}")


@dataclass(frozen=True)
class StudyContrasts:
    """Compare learned feedback, short laws and the clock with the best V, all chosen alike."""

    sources: Annotated[tuple[Path, ...], POSITIONAL]
    """Tables of `python -m research.reproduction learning`, one a body, called as its file."""
    out: Path | None = None
    """Folder for NAME.csv and NAME.md."""
    name: str = "contrasts"
    """Name of these files."""

    def run(self) -> None:
        """Compute, print, and write if asked to."""
        from research.reproduction.learning.contrasts import contrast_rows, contrast_table
        from research.reproduction.learning.runs import read_runs

        rows = contrast_rows({path.stem: read_runs(path) for path in self.sources})
        table = contrast_table(rows)
        if self.out is not None:
            output_folder(self.out)
            text = tables.csv_text({name: rows[name].tolist() for name in rows}, digits=5)
            write_atomically(self.out / f"{self.name}.csv", text)
            write_atomically(self.out / f"{self.name}.md", table)
        print(table)


@dataclass(frozen=True)
class StudyAtlas(_OfStudy):
    """Classify the feedback of every run of a study, and find the short form with its score."""

    generations: int = 60
    """Generations for which a short form is retuned."""
    seeds: int = 1
    """Number of runs of each, of which the one of highest training fitness is taken."""

    def run(self) -> None:
        """Measure what is missing, and write."""
        from research.reproduction.figures.atlas import atlas_figure
        from research.reproduction.learning.atlas import atlas_tables, measure_atlas
        from research.reproduction.learning.forms import Retuning
        from tegotae.figures.style import save_figure

        retuning, records = Retuning(self.generations, self.seeds), self.records
        output_folder(self.out)
        runs = measure_atlas(self.dir, records, retuning)
        self.write(runs, atlas_tables(runs))
        save_figure(atlas_figure(runs), self.out / f"{self.name}.png")
