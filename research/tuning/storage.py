"""A tuning's storage file: an Optuna journal of one study, used by one tuner at a time."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType
from typing import IO, TYPE_CHECKING

import msgspec

from tegotae._support import documents
from tegotae._support.documents import DamagedDocumentError, Json, JsonObject, differing
from tegotae._support.errors import TegotaeError, require
from tegotae._support.files import hold, output_file, output_folder
from tegotae._support.workplace import earlier, move

if TYPE_CHECKING:
    from optuna.study import Study
    from optuna.trial import FrozenTrial

STUDY = "python -m research.tuning"
"""The study's name in its file."""

_CONFIGURATION = "configuration"


@contextmanager
def opened(
    path: Path, configuration: Mapping[str, Json], *, restart: bool = False
) -> Iterator[Study]:
    """Open the study in a storage file, new or continued; no other process may open it meanwhile.

    What a killed tuner left is put in order: half a line at the file's end is cut off, and trials
    that it was at are failed and put into the queue again.

    Args:
        path: the file.
        configuration: what the study is about, as JSON values.
        restart: whether a study that is there before is set aside, in a file beside it.

    Raises:
        TegotaeError: if the file cannot be written, is used by another tuner, or holds something
            else.
        MissingExtraError: without Optuna.
    """
    optuna = require("optuna", "tune")
    output_folder(output_file(path).parent)
    if restart and path.exists():
        _set_aside(path)
    try:
        stream = path.open("a+b")
    except OSError as error:
        raise TegotaeError(f"cannot write {path}: {error.strerror}") from None
    with stream:
        _lock(stream, path)
        _mend(stream, path)
        begun = os.path.getsize(path) > 0
        study = None
        try:
            study = _study(optuna, path, json.loads(json.dumps(configuration)))
            _requeue_abandoned(optuna, study)
            yield study
        except BaseException:
            # A file that nothing was found for yet is free for another tuning.
            if not begun and not (study and _has_values(study)):
                path.unlink(missing_ok=True)
            raise


def _set_aside(path: Path) -> None:
    """Give a study's file another name.

    Raises:
        TegotaeError: if it is in use, no study's, or cannot be moved.
    """
    with path.open("a+b") as stream:
        _lock(stream, path)
        _mend(stream, path)
        place = earlier(path)
        move(path, place)
    print(f"the earlier content of {path} is now in {place}")


def _has_values(study: Study) -> bool:
    """Return True if a trial of the study has a value."""
    trials = study.get_trials(deepcopy=False)
    return any(trial.intermediate_values or trial.values for trial in trials)


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
    length = 0
    for line in stream:
        if not line.endswith(b"\n"):
            break
        try:
            documents.fitted(documents.parse_json(line), _Entry)
        except DamagedDocumentError as error:
            raise _foreign(path, f"no tuning: in a line, {error}") from None
        length += len(line)
    if length == 0 and os.path.getsize(path) > 0:
        raise _foreign(path, "no tuning")
    stream.truncate(length)


def _study(optuna: ModuleType, path: Path, configuration: JsonObject) -> Study:
    journal = optuna.storages.journal
    lock = journal.JournalFileOpenLock(str(path))
    try:
        storage = journal.JournalStorage(journal.JournalFileBackend(str(path), lock_obj=lock))
        names = [summary.study_name for summary in storage.get_all_studies()]
        if any(name != STUDY for name in names):
            raise _foreign(path, f"the study {names[0]!r}")
        if names:
            study = optuna.load_study(storage=storage, study_name=STUDY)
        else:
            study = optuna.create_study(storage=storage, study_name=STUDY, direction="maximize")
        _require_values(study)
    except (TegotaeError, OSError):
        raise
    except Exception as error:  # Optuna believes what is in a journal, so anything may come of it
        raise _foreign(path, f"a damaged study ({type(error).__name__}: {error})") from None
    stored = study.user_attrs.get(_CONFIGURATION)
    if stored is None and not study.trials:
        study.set_user_attr(_CONFIGURATION, configuration)
    elif stored != configuration:
        try:
            theirs = documents.fitted(stored, _TunedConfiguration)
        except DamagedDocumentError as error:
            raise _foreign(path, f"a damaged study: {error}") from None
        names = ", ".join(experiment.name or "no name" for experiment in theirs.experiments)
        raise _foreign(
            path,
            f"a tuning of {theirs.algorithm} for {names} that differs in "
            f"{', '.join(differing(stored, configuration))}",
            ", or start again with --restart",
        )
    return study


class _Entry(msgspec.Struct):
    """Fields of every line of a journal that this reader needs; the rest is Optuna's."""

    op_code: int
    worker_id: str


class _TunedExperiment(msgspec.Struct):
    name: str | None = None


class _TunedConfiguration(msgspec.Struct):
    algorithm: str
    experiments: list[_TunedExperiment]


def _require_values(study: Study) -> None:
    """Check that evaluated settings have numbers as values."""
    for trial in study.get_trials(deepcopy=False):
        for value in (*(trial.values or ()), *trial.intermediate_values.values()):
            if not isinstance(value, float) or not math.isfinite(value):
                raise ValueError(f"trial {trial.number} has the value {value!r}")


def _requeue_abandoned(optuna: ModuleType, study: Study) -> None:
    """Requeue trials left running by a tuner that was killed."""
    states = optuna.trial.TrialState
    for trial in study.get_trials(deepcopy=False, states=(states.RUNNING,)):
        requeue(study, trial)
        study.tell(trial.number, state=states.FAIL)


def requeue(study: Study, trial: FrozenTrial) -> None:
    """Put a trial's parameters into the queue once more."""
    study.enqueue_trial(trial.params, user_attrs={"retry_of": trial.number})


def _foreign(path: Path, reason: str, advice: str = "") -> TegotaeError:
    return TegotaeError(f"{path} holds {reason}; choose another file with --storage{advice}")
