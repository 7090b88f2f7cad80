"""`python -m research.reproduction readings`: the claims under many readings of the paper."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from research.reproduction.commands.output import PictureFormat
from tegotae._support.engines import require_workers
from tegotae._support.errors import TegotaeError
from tegotae._support.files import output_folder, write_atomically
from tegotae.api.parameters import POSITIONAL

if TYPE_CHECKING:
    from research.reproduction.readings.readings import Reading
    from research.reproduction.readings.verdicts import FindingsByReading


@dataclass(frozen=True)
class MultiverseRun:
    """Train and evaluate the missing models of a multiverse; run it again to continue."""

    dir: Path
    """The multiverse's folder."""
    scale: str = "calibrated"
    """Extent of the multiverse: calibrated (24 readings under which V agrees with the paper, 24
    models, 8 runs each) or smoke (seconds)."""
    readings: int | None = None
    """Number of readings; a larger number includes those of a smaller one. By default the
    scale's."""
    workers: int | None = None
    """Number of worker processes with one core each; by default one per core."""
    cluster: str | None = None
    """Address of a Dask scheduler, or local."""
    restart: bool = False
    """Start again, and move an existing multiverse to a folder beside this one."""

    def run(self) -> None:
        """Run the missing units."""
        from functools import partial

        from research.reproduction import runner
        from research.reproduction.readings.folder import MultiverseFolder
        from research.reproduction.readings.plan import UNITS_PER_BUNDLE, multiverse
        from tegotae.study import on_cores

        plan = multiverse(self.scale, self.readings)
        if self.workers is not None:
            require_workers(self.workers)
        results = partial(on_cores, workers=self.workers)
        if self.cluster is not None:
            from research.reproduction.cluster import on_cluster

            results = on_cluster(self.cluster)
        folder = MultiverseFolder(self.dir)
        total = runner.run_study(plan, folder, results, UNITS_PER_BUNDLE, restart=self.restart)
        print(
            f"{total} records in {self.dir}; next: "
            f"python -m research.reproduction readings figures {self.dir} --out FOLDER"
        )


@dataclass(frozen=True)
class MultiverseStatus:
    """Show the state of a multiverse's folder."""

    dir: Path
    """The multiverse's folder."""
    readings: int | None = None
    """Number of readings; by default the scale's."""

    def run(self) -> None:
        """Print it."""
        from research.reproduction.readings.folder import MultiverseFolder, is_whole, reading_tables
        from research.reproduction.unit import record_key

        folder = MultiverseFolder(self.dir)
        plan = folder.plan(self.readings)
        records, damaged = folder.all()
        complete = sum(is_whole(plan, table) for table in reading_tables(plan, records).values())
        keys = {unit.key for unit in plan.units}
        count = sum(record_key(record.configuration) in keys for record in records)
        print(
            f"scale {plan.scale}: {count} of {len(keys)} models done, "
            f"{complete} of {plan.readings} readings complete"
        )
        for message in damaged:
            print(message)


@dataclass(frozen=True)
class MultiverseExport:
    """Write two tables: the readings, and the effects of every claim under each reading."""

    dir: Path
    """The multiverse's folder."""
    out: Path
    """Folder for readings.csv and effects.csv."""
    readings: int | None = None
    """Number of readings; by default the scale's."""

    def run(self) -> None:
        """Write them."""
        from research.reproduction.readings.tables import EFFECTS, READINGS, write_multiverse_tables

        readings, by_reading = _findings(self.dir, self.readings)
        write_multiverse_tables(readings, by_reading, self.out)
        print(f"wrote {READINGS}, {EFFECTS} to {self.out}")


@dataclass(frozen=True)
class MultiverseFigures(PictureFormat):
    """Draw the share of readings that reproduce each claim, and the decisive choices."""

    source: Annotated[Path, POSITIONAL]
    """A multiverse's folder, or a folder of `python -m research.reproduction readings export`."""
    out: Path
    """Folder for pictures and for multiverse.md."""
    omega: str = "both"
    """Frequency ω_t of the verdicts: both, 4 or 8 rad/s."""

    def run(self) -> None:
        """Draw the figure."""
        from research.reproduction.figures.multiverse import curve_figure, overview_figure
        from research.reproduction.readings.influence import decisive, influences
        from research.reproduction.readings.tables import READINGS, read_tables
        from research.reproduction.readings.verdicts import CLAIMS, of_claim
        from research.reproduction.report.multiverse import shares_table
        from tegotae.figures.style import save_figure

        exported = (self.source / READINGS).exists()
        readings, by_reading = read_tables(self.source) if exported else _findings(self.source)
        frequencies = sorted({omega for by_omega in by_reading.values() for omega in by_omega})
        if self.omega not in frequencies:
            raise TegotaeError(
                f"omega is {self.omega!r}; it must be one of {', '.join(frequencies)}"
            )
        figures = {f"multiverse.{self.format}": overview_figure(readings, by_reading, self.omega)}
        for claim in CLAIMS:
            results = of_claim(by_reading, claim.name, self.omega)
            if results and (claim.headline or decisive(influences(readings, results))):
                figures[f"{claim.name}.{self.format}"] = curve_figure(readings, results)
        output_folder(self.out)
        for name, figure in figures.items():
            save_figure(figure, self.out / name)
        text = shares_table(readings, by_reading, self.omega)
        write_atomically(self.out / "multiverse.md", text)
        print(f"wrote {', '.join(figures)}, multiverse.md to {self.out}")


def _findings(path: Path, count: int | None = None) -> tuple[list[Reading], FindingsByReading]:
    from research.reproduction.readings.folder import MultiverseFolder, is_whole, reading_tables
    from research.reproduction.readings.verdicts import findings_by_reading

    folder = MultiverseFolder(path)
    plan = folder.plan(count)
    records, damaged = folder.all()
    for message in damaged:
        print(message)
    by_number = reading_tables(plan, records)
    if not by_number:
        raise TegotaeError(
            f"{path} holds no result yet; first: python -m research.reproduction readings run"
        )
    complete = sum(is_whole(plan, table) for table in by_number.values())
    if complete < plan.readings:
        print(
            f"{complete} of {plan.readings} readings are complete; of the others, only claims "
            "count that have all of their models"
        )
    by_reading = findings_by_reading(by_number, models=plan.models)
    return [reading for reading, _ in plan.by_reading], by_reading
