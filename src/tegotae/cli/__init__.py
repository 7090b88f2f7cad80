"""Train, simulate and compare learned Tegotae feedback in central pattern generators."""

from __future__ import annotations

from collections.abc import Sequence

import tyro

from tegotae.cli.bench import Bench
from tegotae.cli.compare import Compare
from tegotae.cli.evaluate import Evaluate
from tegotae.cli.figure import Figure
from tegotae.cli.models import Models
from tegotae.cli.simulate import Simulate
from tegotae.cli.status import exit_status, leave
from tegotae.cli.study import Study
from tegotae.cli.train import Train
from tegotae.cli.tune import Tune

COMMANDS = {
    "models": Models,
    "train": Train,
    "tune": Tune,
    "simulate": Simulate,
    "evaluate": Evaluate,
    "compare": Compare,
    "figure": Figure,
    "study": Study,
    "bench": Bench,
}


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a subcommand; the exit status is 0, 2 for unusable input, or 130 after Ctrl-C.

    Raises:
        SystemExit: of status 2 for arguments that do not make a command; of 0 after `--help`.
    """
    command = tyro.extras.subcommand_cli_from_dict(
        COMMANDS,
        prog="tegotae",
        description=__doc__,
        args=arguments,
        config=(
            tyro.conf.FlagCreatePairsOff,
            tyro.conf.DisallowNone,
            tyro.conf.PositionalMetavarFromFieldName,
        ),
    )
    return exit_status(command.run)


def entry() -> None:
    """The console script."""
    leave(main())
