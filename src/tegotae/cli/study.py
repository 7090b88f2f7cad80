"""`tegotae study`: the whole study, from one command that survives anything."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from tegotae.study.folder import Folder
from tegotae.study.plan import plan


@dataclass(frozen=True)
class StudyRun:
    """Train and evaluate what is missing of a study; run it again to go on."""

    dir: Path
    """The study's folder."""
    scale: str = "quick"
    """smoke (seconds), quick (all architectures, few runs) or paper (218 models, 15 runs)."""
    models: str = "*"
    """Only these models, with * and ? as in a shell."""
    workers: int | None = None
    """Worker processes of one core each; one per core by default."""
    cluster: str | None = None
    """Address of a Dask scheduler to work on, or local."""

    def run(self) -> None:
        """Do what is missing."""
        from functools import partial

        from tegotae.study import runner

        chosen = plan(self.scale, self.models)
        results = partial(runner.on_cores, workers=self.workers)
        if self.cluster is not None:
            from tegotae.study.cluster import on_cluster

            results = on_cluster(self.cluster)
        total = runner.run(chosen, self.dir, results)
        print(f"{total} records in {self.dir}; next: tegotae study report --dir {self.dir}")


@dataclass(frozen=True)
class StudyStatus:
    """Say what a study's folder holds."""

    dir: Path
    """The study's folder."""

    def run(self) -> None:
        """Print it."""
        folder = Folder(self.dir)
        document = folder.document
        units = plan(document["scale"]).units
        records, damaged = folder.all()
        found = {record.model for record in records}
        missing = [u.run.model.name for u in units if u.run.model.name not in found]
        print(f"scale {document['scale']}: {len(records)} of {len(units)} models done")
        if missing:
            print(f"missing: {', '.join(missing[:8])}{' ...' if len(missing) > 8 else ''}")
        for message in damaged:
            print(message)


@dataclass(frozen=True)
class Study:
    """Run the whole study of the paper, and report on it."""

    which: Annotated[
        Annotated[StudyRun, tyro.conf.subcommand("run")]
        | Annotated[StudyStatus, tyro.conf.subcommand("status")],
        tyro.conf.arg(name=""),
    ]

    def run(self) -> None:
        """Do it."""
        self.which.run()
