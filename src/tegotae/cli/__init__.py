"""The command `tegotae`: one file a subcommand."""

from __future__ import annotations

import sys
from collections.abc import Sequence

import tyro

from tegotae.cli.bench import Bench
from tegotae.cli.compare import Compare
from tegotae.cli.evaluate import Evaluate
from tegotae.cli.models import Models
from tegotae.cli.simulate import Simulate
from tegotae.cli.train import Train
from tegotae.errors import TegotaeError

COMMANDS = {
    "models": Models,
    "train": Train,
    "simulate": Simulate,
    "evaluate": Evaluate,
    "compare": Compare,
    "bench": Bench,
}


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a subcommand; the exit status is 0, 2 for unusable input, or 130 after Ctrl-C."""
    command = tyro.extras.subcommand_cli_from_dict(
        COMMANDS,
        prog="tegotae",
        description="Learned Tegotae feedback in central pattern generators.",
        args=arguments,
    )
    try:
        command.run()
    except TegotaeError as error:
        print(f"tegotae: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("tegotae: interrupted; what is done is kept", file=sys.stderr)
        return 130
    except BrokenPipeError:
        sys.stderr.close()
        return 0
    return 0


def entry() -> None:
    """The console script."""
    sys.exit(main())
