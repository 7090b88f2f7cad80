"""`python -m research.reproduction`: the whole study, from one command that survives anything."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from research.reproduction.commands.output import PictureFormat
from research.reproduction.folder import Folder
from research.reproduction.options import Several
from research.reproduction.plan import Plan, matching, plan
from research.reproduction.readings.named import STUDY, ReadingOptions, reading_named
from research.reproduction.record import Record
from tegotae._support.documents import Document
from tegotae._support.engines import require_workers
from tegotae._support.errors import TegotaeError
from tegotae._support.files import output_file, output_folder, write_atomically
from tegotae.api.parameters import POSITIONAL
from tegotae.measures.check import check
from tegotae.measures.hopping.metrics import HOPPING
from tegotae.systems.experiment import Experiment
from tegotae.systems.resolve import Untrained, experiment_of, resolve
from tegotae.training.algorithms import Algorithm
from tegotae.training.settings import settings_named

if TYPE_CHECKING:
    from research.reproduction.table import StudyTable


def experiments_at(place: str) -> list[Experiment]:
    """Return the experiments of a name: one, or a list in a user's own file or a file of documents.

    Raises:
        TegotaeError: if there are none, or they cannot be read.
    """
    resolved = resolve(place)
    return list(resolved.experiments) if isinstance(resolved, Untrained) else [experiment_of(place)]


@dataclass(frozen=True, kw_only=True)
class StudyRun(ReadingOptions):
    """Train and evaluate the missing models of a study; run it again to continue."""

    dir: Path
    """The study's folder."""
    scale: str = "quick"
    """Extent of the study: smoke (seconds), quick (all architectures, few runs), paper (218 models,
    15 runs, to the plateau), learning (seven frequencies, and short laws) or paper-80x16 (the
    paper's models with its budget)."""
    reading: str = STUDY
    """Reading of the paper's gaps, for all models: study, calibrated, or a file of options (.toml,
    .json). Options given beside it override its own."""
    models: Several = ()
    """Only models with these names, with * and ? as in a shell; an empty text for none."""
    experiments: Several = ()
    """Experiments of your own beside the models: FILE.py:OBJECT or MODULE:OBJECT, for an experiment
    or a list, or a file of documents (.json). Other options apply to models only."""
    algorithm: str | None = None
    """Learning algorithm: a name such as cma-es, or your own, FILE.py:OBJECT; by default the
    scale's."""
    seeds: int | None = None
    """Number of runs per experiment; by default the scale's."""
    workers: int | None = None
    """Number of worker processes with one core each; by default one per core."""
    cluster: str | None = None
    """Address of a Dask scheduler, or local."""
    restart: bool = False
    """Start again, and move an existing study to a folder beside this one."""

    def run(self) -> None:
        """Run the missing units."""
        from functools import partial

        from research.reproduction import runner
        from tegotae.study import on_cores

        study = self.plan
        if self.workers is not None:
            require_workers(self.workers)
        results = partial(on_cores, workers=self.workers)
        if self.cluster is not None:
            from research.reproduction.cluster import on_cluster

            results = on_cluster(self.cluster)
        total = runner.run_study(study, self.dir, results, restart=self.restart)
        print(
            f"{total} records in {self.dir}; next: "
            f"python -m research.reproduction report --dir {self.dir}"
        )

    @property
    def plan(self) -> Plan:
        """The plan of the run."""
        extra = [entry for name in chain(*self.experiments) for entry in experiments_at(name)]
        base = plan(self.scale)
        options = self._read
        patterns = [*chain(*self.models)] if self.models else "*"
        models = matching(options.at_frequencies(base.experiments), patterns, or_none=bool(extra))
        experiments = [*map(options.applied, models), *extra]
        for experiment in experiments:
            experiment.check()
        for metric in base.metrics:
            check(metric)
        settings: dict[str, Any] = {} if self.seeds is None else {"seeds": self.seeds}
        if self.algorithm is not None:
            settings["algorithm"] = settings_named(self.algorithm, Algorithm)
        return replace(base, experiments=tuple(experiments), **settings)

    @property
    def _read(self) -> ReadingOptions:
        """The options of the reading, except those on the command line."""
        reading = reading_named(self.reading)
        overrides = {
            field.name: getattr(self, field.name)
            for field in fields(ReadingOptions)
            if getattr(self, field.name) != field.default
        }
        return replace(reading, **overrides)


@dataclass(frozen=True)
class StudyStatus:
    """Show the state of a study's folder."""

    dir: Path
    """The study's folder."""

    def run(self) -> None:
        """Print it."""
        folder = Folder(self.dir)
        document = folder.document
        planned = planned_at(document)
        models = list(dict.fromkeys([*planned, *document["experiments"]]))
        records, damaged = folder.all()
        recorded = {record.model for record in records}
        missing = [name for name in models if name not in recorded]
        count = len(models) - len(missing)
        print(f"scale {document['scale']}: {count} of {len(models)} models done")
        if missing:
            print(f"missing: {', '.join(missing[:8])}{' ...' if len(missing) > 8 else ''}")
        for message in damaged:
            print(message)


def planned_at(document: Document) -> list[str]:
    """Return the names of a scale's models, at the frequencies of the study's own reading."""
    experiments = plan(document["scale"]).experiments
    usual = {experiment.omega for experiment in experiments}
    models = {_model(experiment.name) for experiment in experiments}
    omegas = {
        entry["system"]["omega"]
        for name, entry in document["experiments"].items()
        if _model(name) in models
    }
    if omegas - usual:
        reading = ReadingOptions(omega_t=tuple(sorted(omegas - {None})))
        experiments = reading.at_frequencies(experiments)
    return [experiment.name for experiment in experiments]


def _model(name: str) -> str:
    """Return the name of a model without its frequency."""
    return name.rpartition("-w")[0] or name


@dataclass(frozen=True)
class StudyReport:
    """Write the study's report: one self-contained HTML page."""

    dir: Path
    """The study's folder."""
    out: Path | None = None
    """File of the report; by default report.html in the study's folder."""
    experiments: Path | None = None
    """Folder of the experiments beside the study: figure3, parameter_limit and gain_map, as .csv
    and .png. Without it the report names the commands that run them."""

    def run(self) -> None:
        """Write it, and say where it is."""
        from research.reproduction.about import study_summary
        from research.reproduction.report.page import report_page
        from research.reproduction.table import tabulate_budgets

        folder = Folder(self.dir)
        records, document = _records(folder), folder.document
        path = output_file(self.out or self.dir / "report.html")
        described = study_summary(document, len(records))
        write_atomically(
            path, report_page(records, described, self.experiments, tabulate_budgets(records))
        )
        print(f"The report is {path.resolve()}")


@dataclass(frozen=True)
class StudyExport:
    """Write the study's results as a table with a row per model and run."""

    dir: Path
    """The study's folder."""
    out: Path
    """File of the table: .csv or .parquet."""
    budgets: Path | None = None
    """File of a second table, with a row per model, run and training budget."""
    sampled: Path | None = None
    """File of the same table for controllers drawn from the final distribution of each run."""

    def run(self) -> None:
        """Write it."""
        from research.reproduction.export import write_study_csv, write_study_parquet
        from research.reproduction.table import tabulate, tabulate_budgets, tabulate_sampled

        writers = {".csv": write_study_csv, ".parquet": write_study_parquet}
        for path in filter(None, (self.out, self.budgets, self.sampled)):
            if path.suffix not in writers:
                raise TegotaeError(f"cannot write a table as {path.name!r}; use .csv or .parquet")
        records = _records(Folder(self.dir))
        writers[self.out.suffix](tabulate(records), self.out)
        if self.sampled is not None:
            writers[self.sampled.suffix](tabulate_sampled(records), self.sampled)
        if self.budgets is not None:
            table = tabulate_budgets(records)
            if table is None:
                raise TegotaeError(
                    f"{self.dir} was evaluated at the end of training alone; no {self.budgets}"
                )
            writers[self.budgets.suffix](table, self.budgets)


@dataclass(frozen=True)
class StudyZoo:
    """Write the trained controllers of a study to one small file, for names such as zoo:ART."""

    dir: Path
    """The study's folder."""
    name: str
    """Name of the study, as in zoo:NAME:ART."""
    out: Path
    """File of the controllers (.npz); their names are then zoo:FILE:MODEL/RUN."""
    core: bool = False
    """Keep only the models that an installed package has of the paper's study."""

    def run(self) -> None:
        """Write it, and say how to use it."""
        from research.reproduction.zoo import core, write_archive, zoo_entries
        from tegotae.systems.zoo import SUFFIX, ZooName, open_zoo

        if self.out.suffix != SUFFIX:
            raise TegotaeError(f"cannot write controllers as {self.out.name!r}; use {SUFFIX}")
        if not self.name.replace("-", "").isalnum():
            raise TegotaeError(f"the name is {self.name!r}; it must be letters, digits and hyphens")
        write_archive(output_file(self.out), self.name, zoo_entries(_records(Folder(self.dir))))
        if self.core:
            write_archive(self.out, self.name, core(open_zoo(self.out)))
        zoo = open_zoo(self.out)
        first = ZooName(str(self.out), next(iter(zoo.models)), "")
        print(
            f"{self.out}: {sum(zoo.models.values())} controllers of {len(zoo.models)} models, "
            f"{self.out.stat().st_size / 1e6:.2g} MB; try: tegotae simulate {first}"
        )


@dataclass(frozen=True)
class StudyFigures(PictureFormat):
    """Draw Figs. 2 and 5 and learning curves from an exported table or a study's folder."""

    source: Annotated[Path, POSITIONAL]
    """A table of `python -m research.reproduction export` (.csv), or a study's folder, which also
    has the controllers (Fig. 5) and the learning curves."""
    out: Path
    """Folder for pictures and tables."""
    budgets: Path | None = None
    """Table of the same runs by training budget (.csv), from `python -m research.reproduction
    export`; a study's folder contains it."""

    def run(self) -> None:
        """Draw the figures."""
        from research.reproduction.claims.budgets import by_budget
        from research.reproduction.claims.counting import Count
        from research.reproduction.claims.findings import findings
        from research.reproduction.endings import endings_by_architecture
        from research.reproduction.export import csv_of
        from research.reproduction.figures.budgets import budgets_figure, drawn_claims
        from research.reproduction.figures.figure5 import (
            policies_figure,
            policies_table,
            policy_panels,
        )
        from research.reproduction.figures.study import (
            architectures_figure,
            correlation_figure,
            pictograms_figure,
        )
        from research.reproduction.report import convergence
        from research.reproduction.report.markdown import endings_table
        from research.reproduction.table import StudyTable
        from tegotae.figures.style import save_figure

        tables = tables_of(self.source, self.budgets)
        table, budgets = tables.runs, tables.budgets
        records = _records(Folder(self.source)) if self.source.is_dir() else []
        texts = {"endings.md": endings_table(endings_by_architecture(table))}
        figures = {
            "architectures": pictograms_figure(table),
            "metrics": architectures_figure(table),
            "correlations": correlation_figure(table),
        }
        if budgets is not None:
            findings_by_budget = {
                name: findings(runs, options=[Count()])
                for name, runs in by_budget(budgets, table).items()
            }
            if drawn_claims(findings_by_budget):
                figures["budgets"] = budgets_figure(findings_by_budget)
        for omega, figure in convergence.convergence_figures(records).items():
            figures[f"convergence-w{omega}"] = figure
        panels = policy_panels(records, table)
        if panels:
            figures["figure5"] = policies_figure(panels)
            texts["figure5.md"] = policies_table(panels)
        if records:
            texts["convergence.csv"] = csv_of(StudyTable(convergence.convergence_means(records)))
        output_folder(self.out)
        figures = {f"{name}.{self.format}": figure for name, figure in figures.items()}
        for name, figure in figures.items():
            save_figure(figure, self.out / name)
        for name, text in texts.items():
            write_atomically(self.out / name, text)
        print(f"wrote {', '.join([*figures, *texts])} to {self.out}")


@dataclass(frozen=True)
class StudyMerge:
    """Copy records of the same study from another folder."""

    source: Annotated[Path, POSITIONAL]
    """Folder to copy from."""
    dir: Path
    """Folder to copy to."""

    def run(self) -> None:
        """Copy the records, and print their number."""
        from research.reproduction.export import merge

        copied = merge(Folder(self.source), Folder(self.dir))
        print(f"{copied} records copied to {self.dir}")


@dataclass(frozen=True)
class StudyTables:
    """A study's tables, from its folder or from files.

    Args:
        runs: a row a run, at the end of training.
        budgets: the same after each budget of training, if there is one.
        sampled: the same of the controllers drawn from the final distributions, if there is one.
        selected: names of the claims that the body was chosen to agree with; a file does not say.
    """

    runs: StudyTable
    budgets: StudyTable | None = None
    sampled: StudyTable | None = None
    selected: frozenset[str] = frozenset()


def tables_of(
    source: Path, budgets: Path | None = None, sampled: Path | None = None
) -> StudyTables:
    """Return the tables of a study.

    Args:
        source: an exported table, or a study's folder.
        budgets: the exported table of budgets; a folder has its own.
        sampled: the exported table of drawn controllers; a folder has its own.

    Raises:
        TegotaeError: if one cannot be read.
    """
    from research.reproduction.export import read_study_csv
    from research.reproduction.readings.designs import selecting_body
    from research.reproduction.table import tabulate, tabulate_budgets, tabulate_sampled

    if source.is_dir():
        records = _records(Folder(source))
        tables = StudyTables(
            tabulate(records),
            tabulate_budgets(records),
            tabulate_sampled(records),
            selecting_body(records[0].experiment.body),
        )
    else:
        tables = StudyTables(read_study_csv(source))
    return StudyTables(
        tables.runs,
        tables.budgets if budgets is None else read_study_csv(budgets),
        tables.sampled if sampled is None else read_study_csv(sampled),
        tables.selected,
    )


def _records(folder: Folder) -> list[Record]:
    records, damaged = folder.all()
    for message in damaged:
        print(message)
    if not records:
        raise TegotaeError(
            f"{folder.path} holds no records yet; first: python -m research.reproduction run"
        )
    if unknown := sorted(set(folder.document.get("metrics", [])).difference(HOPPING.names())):
        print(f"{', '.join(unknown)}: no metric known here; to draw it, give --parts FILE.py")
    for name in {name: None for record in records for name in record.software}:
        versions = sorted({record.software.get(name, "none") for record in records})
        if len(versions) > 1:
            cause = f"with different versions of {name}"
            print(f"the records were made {cause}: {', '.join(versions)}")
    return records
