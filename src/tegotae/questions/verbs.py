"""The questions as functions: `tg.simulate("quadruped-c")`. The command line asks here, too."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from os import PathLike
from pathlib import Path
from typing import Any

from tegotae._support.errors import TegotaeError
from tegotae._support.progress import reporting
from tegotae.questions.answer import Answer, RecordedRun
from tegotae.questions.generalising import (
    DisturbanceList,
    Generalisation,
    GeneralisationOptions,
    generalise_tasks,
)
from tegotae.questions.measuring import (
    MeasuredRecording,
    RecordingOptions,
    measure_recording,
)
from tegotae.questions.options import changed
from tegotae.questions.task import Subject, Task, tasks_of


def simulate(*subjects: Subject | Task, **options: Any) -> RecordedRun:
    """One run of a controller, closely.

    Args:
        subjects: one name such as `V-sector-w4`, `zoo:ART` or `quadruped-c`, file, or object; a
            vanilla controller on the paper's hopper by default.
        options: those of the subject (`tegotae simulate NAME --help`), with or without their
            units; `body` replaces its body.

    Raises:
        TegotaeError: for a name that means nothing, several controllers, or an option that the
            subject does not have or that cannot be.

    Example:
        >>> simulate("paper", duration=4.0, drop=0.1, drop_time=2.0).frame().columns[1]
        'height_m'
    """
    task, *others = tasks = tasks_of(*(subjects or ["paper"]), body=options.pop("body", None))
    if others:
        names = ", ".join(task.name for task in tasks)
        raise TegotaeError(f"one run of one controller; {names} are {len(tasks)}")
    return task.simulate(changed(task.options("simulate"), options, task.name))


def evaluate(*subjects: Subject | Task, **options: Any) -> Answer:
    """How good controllers are, with intervals over their runs.

    Args:
        subjects: names, files, folders or objects.
        options: those of the subjects (`tegotae evaluate NAME --help`), with or without their
            units; `body` replaces their bodies.

    Raises:
        TegotaeError: for a name that means nothing or has no weights, an option that a subject
            does not have or that cannot be, or subjects without a common measure.
    """
    tasks = tasks_of(*subjects, body=options.pop("body", None))
    return _evaluated(tasks, _checked(tasks, options))


def compare(*subjects: Subject | Task, **options: Any) -> Answer:
    """How good controllers are, and how they differ from the first.

    Args:
        subjects: at least two names, files, folders or objects.
        options: as for `evaluate`.

    Raises:
        TegotaeError: also for sets that are evaluated in different ways.
    """
    tasks = tasks_of(*subjects, body=options.pop("body", None))
    if len(tasks) < 2:
        raise TegotaeError(
            f"a comparison needs at least two sets of controllers; {len(tasks)} found"
        )
    asked = _checked(tasks, options)
    alike = [task.alike(own) for task, own in zip(tasks, asked, strict=True)]
    for task, own in zip(tasks, alike, strict=True):
        for what in [what for what in own if own[what] != alike[0][what]]:
            raise TegotaeError(
                f"{tasks[0].name} and {task.name} are evaluated with another {what}, "
                f"{alike[0][what]} and {own[what]}; an option sets one for all"
            )
    return dataclasses.replace(_evaluated(tasks, asked), base=tasks[0].name)


def measure(file: str | PathLike[str], **options: Any) -> MeasuredRecording:
    """The metrics of a recording of a robot or another simulator, or why they are undefined.

    Args:
        file: .csv, .npz or .parquet.
        options: what is known of it (`RecordingOptions`), with or without units.

    Raises:
        TegotaeError: for a file that cannot be read or lacks a column, or numbers that cannot be.

    Example:
        >>> measure("walk.csv", rest_length=1.0, omega=5.0).plot()  # doctest: +SKIP
    """
    return measure_recording(Path(file), changed(RecordingOptions(), options, "a recording"))


def generalise(*subjects: Subject | Task, **options: Any) -> Generalisation | DisturbanceList:
    """How much controllers bear, unchanged, of conditions outside of their training.

    Args:
        subjects: names, files, folders or objects.
        options: the conditions and the folder of the records (`GeneralisationOptions`).

    Raises:
        TegotaeError: for a condition or a name that means nothing, or a folder of other work.
    """
    own = changed(GeneralisationOptions(), options, "generalise")
    chosen = own.chosen
    if own.list:
        return DisturbanceList(chosen)
    if not subjects:
        raise TegotaeError("name a controller file, a folder, or a study's folder")
    return generalise_tasks(tasks_of(*subjects), own)


def _checked(tasks: Sequence[Task], options: Mapping[str, Any]) -> list[Any]:
    """The options of each task, all of which are of a kind."""
    asked = [changed(task.options("evaluate"), options, task.name) for task in tasks]
    for task, own in zip(tasks, asked, strict=True):
        if type(task) is not type(tasks[0]):
            raise TegotaeError(
                f"{tasks[0].name} {tasks[0].what}, and {task.name} {task.what}: they have no "
                "measure in common"
            )
        task.check(own)
    return asked


def _evaluated(tasks: Sequence[Task], asked: Sequence[Any]) -> Answer:
    answers: list[Answer] = []
    with reporting("evaluate", len(tasks)) as reporter:
        for task, own in zip(tasks, asked, strict=True):
            answers.append(task.evaluate(own))
            reporter.update(len(answers), task.name)
    return Answer.joined(answers)
