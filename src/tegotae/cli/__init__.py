"""Train, simulate and compare learned Tegotae feedback in central pattern generators."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence

import tyro

from tegotae._start import ready
from tegotae.cli.bench import Bench
from tegotae.cli.compare import Compare
from tegotae.cli.console import make_safe
from tegotae.cli.evaluate import Evaluate
from tegotae.cli.export import Export
from tegotae.cli.figure import Figure
from tegotae.cli.gait import Gait
from tegotae.cli.generalise import Generalise
from tegotae.cli.measure import Measure
from tegotae.cli.models import Models
from tegotae.cli.playground import Playground
from tegotae.cli.simulate import Simulate
from tegotae.cli.status import DEBUG, exit_status, leave
from tegotae.cli.study import Study
from tegotae.cli.train import Train
from tegotae.cli.train_env import TrainEnv
from tegotae.cli.tune import Tune
from tegotae.devices import check_environment
from tegotae.errors import TegotaeError
from tegotae.references import imported

COMMANDS = {
    "models": Models,
    "train": Train,
    "train-env": TrainEnv,
    "tune": Tune,
    "simulate": Simulate,
    "evaluate": Evaluate,
    "compare": Compare,
    "measure": Measure,
    "figure": Figure,
    "gait": Gait,
    "generalise": Generalise,
    "study": Study,
    "export": Export,
    "playground": Playground,
    "bench": Bench,
}


_SWITCHES = (
    "With --parts FILE.py, or --parts MODULE, any command knows the parts that you wrote there, "
    "which files that name them need; several files may follow, or another --parts. "
    "--version says which version this is. With --debug, or "
    "TEGOTAE_DEBUG=1, an error shows where it arose."
)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a subcommand; the exit status is 0, or another one (`exit_status`).

    Raises:
        SystemExit: of status 2 for arguments that do not make a command; of 0 after `--help`.
    """
    words = list(sys.argv[1:] if arguments is None else arguments)
    if "--debug" in words:
        os.environ[DEBUG] = "1"  # which worker processes inherit
    words = [word for word in words if word != "--debug"]
    return exit_status(lambda: _run(words))


def _run(words: list[str]) -> None:
    if words == ["--version"]:
        from tegotae import __version__

        print(f"tegotae {__version__}")
        return
    words, places = split_parts(words)
    for place in places:
        imported(place)
    command = tyro.extras.subcommand_cli_from_dict(
        COMMANDS,
        prog="tegotae",
        description=f"{__doc__} {_SWITCHES}",
        args=words,
        config=(
            tyro.conf.FlagCreatePairsOff,
            tyro.conf.DisallowNone,
            tyro.conf.PositionalMetavarFromFieldName,
        ),
    )
    check_environment()
    try:
        command.run()
    except SystemExit:  # no command of ours ends so: a part does, perhaps in a worker
        raise TegotaeError(
            "code of a part ended the command (SystemExit); a part returns, or raises an error"
        ) from None


def split_parts(words: list[str]) -> tuple[list[str], list[str]]:
    """The words without --parts, and what it names: a file or module, more files behind it.

    Example:
        >>> split_parts(["--parts", "a.py", "b.py", "study", "--parts", "c", "run"])
        (['study', 'run'], ['a.py', 'b.py', 'c'])
    """
    kept, places = [], []
    rest = [each for word in words for each in _after_parts(word)]
    while rest:
        word = rest.pop(0)
        if word != "--parts":
            kept.append(word)
            continue
        if not rest or rest[0].startswith("-"):
            raise TegotaeError("--parts names no file; write --parts FILE.py, or a module")
        places.append(rest.pop(0))
        while rest and rest[0].endswith(".py"):
            places.append(rest.pop(0))
    return kept, places


def _after_parts(word: str) -> list[str]:
    """The word; what stands for two, such as --parts=FILE.py, as two."""
    option, equals, value = word.partition("=")
    return [option, value] if option == "--parts" and equals else [word]


def entry() -> None:
    """The console script."""
    make_safe()
    ready()
    leave(main())
