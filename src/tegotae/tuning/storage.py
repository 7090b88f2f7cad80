"""A tuning's storage file: an Optuna journal of one study, used by one tuner at a time."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any

from tegotae.errors import TegotaeError
from tegotae.experiment import differing
from tegotae.extras import require
from tegotae.files import output_file
from tegotae.locks import hold

if TYPE_CHECKING:
    from optuna.study import Study
    from optuna.trial import FrozenTrial

STUDY = "tegotae tune"
"""The study's name in its file."""

_CONFIGURATION = "configuration"


@contextmanager
def opened(path: Path, configuration: Mapping[str, Any]) -> Iterator[Study]:
    """The study in a storage file, begun or gone on with; nobody else may open it meanwhile.

    What a killed tuner left is put in order: half a line at the file's end is cut off, and trials
    that it was at are failed and put into the queue again.

    Args:
        path: the file.
        configuration: what the study is about, as JSON values.

    Raises:
        TegotaeError: if the file cannot be written, is used by another tuner, or holds something
            else.
        MissingExtraError: without Optuna.
    """
    optuna = require("optuna", "tune")
    path = output_file(path)
    try:
        stream = path.open("a+b")
    except OSError as error:
        raise TegotaeError(f"cannot write {path}: {error.strerror}") from None
    with stream:
        _lock(stream, path)
        _mend(stream, path)
        study = _study(optuna, path, json.loads(json.dumps(configuration)))
        _requeue_abandoned(optuna, study)
        yield study


def _lock(stream: IO[bytes], path: Path) -> None:
    try:
        alone = hold(stream.fileno())
    except BlockingIOError:
        raise TegotaeError(
            f"{path} is in use by another tuner; for more processes give that one more --workers"
        ) from None
    if alone:  # so a lock of Optuna's is one that a killed tuner left
        Path(f"{path}.lock").unlink(missing_ok=True)


def _mend(stream: IO[bytes], path: Path) -> None:
    """Cut off half a line at the end; refuse a file that is no journal before touching it."""
    stream.seek(0)
    whole = 0
    for line in stream:
        if not line.endswith(b"\n"):
            break
        try:
            entry = json.loads(line)
        except ValueError:
            entry = None
        if not isinstance(entry, dict) or "op_code" not in entry:
            raise _foreign(path, "no tuning")
        whole += len(line)
    if whole == 0 and os.path.getsize(path) > 0:
        raise _foreign(path, "no tuning")
    stream.truncate(whole)


def _study(optuna: Any, path: Path, configuration: dict[str, Any]) -> Study:
    journal = optuna.storages.journal
    lock = journal.JournalFileOpenLock(str(path))
    try:
        storage = journal.JournalStorage(journal.JournalFileBackend(str(path), lock_obj=lock))
        names = [known.study_name for known in storage.get_all_studies()]
    except (ValueError, KeyError, AssertionError):
        raise _foreign(path, "a damaged study") from None
    if any(name != STUDY for name in names):
        raise _foreign(path, f"the study {names[0]!r}")
    if names:
        study = optuna.load_study(storage=storage, study_name=STUDY)
    else:
        study = optuna.create_study(storage=storage, study_name=STUDY, direction="maximize")
    found = study.user_attrs.get(_CONFIGURATION)
    if found is None and not study.trials:
        study.set_user_attr(_CONFIGURATION, configuration)
    elif found != configuration:
        if not isinstance(found, dict) or "experiments" not in found:
            raise _foreign(path, "a tuning of an earlier version of tegotae")
        names = differing(found, configuration)
        raise _foreign(
            path,
            f"a tuning of {found.get('algorithm')} for {_names(found)} that "
            f"differs in {', '.join(names)}",
        )
    return study


def _names(configuration: Mapping[str, Any]) -> str:
    return ", ".join(str(each.get("name")) for each in configuration["experiments"])


def _requeue_abandoned(optuna: Any, study: Study) -> None:
    """Trials left running by a tuner that was killed: nobody else can be at them."""
    states = optuna.trial.TrialState
    for trial in study.get_trials(deepcopy=False, states=(states.RUNNING,)):
        requeue(study, trial)
        study.tell(trial.number, state=states.FAIL)


def requeue(study: Study, trial: FrozenTrial) -> None:
    """Put a trial's parameters into the queue once more."""
    study.enqueue_trial(trial.params, user_attrs={"retry_of": trial.number})


def _foreign(path: Path, what: str) -> TegotaeError:
    return TegotaeError(f"{path} holds {what}; choose another file with --storage")
