"""Which task a name is: on a body with one leg, with several, or in another simulator."""

from __future__ import annotations

import dataclasses
from collections import Counter
from collections.abc import Sequence

from tegotae._support.errors import TegotaeError, require_all
from tegotae.parts.bodies import Body, Interface
from tegotae.questions.task import Subject, Task
from tegotae.systems.body_file import body_called
from tegotae.systems.controller_file import ControllerSet
from tegotae.systems.env_task import extras_of
from tegotae.systems.legged import Legged, settling
from tegotae.systems.resolve import resolve
from tegotae.training.collection import distinct, sets_of


def tasks_of(*subjects: Subject | Task, body: str | Body | None = None) -> list[Task]:
    """The tasks of what is named, each called by a name of its own.

    Args:
        subjects: names, files, folders, or objects.
        body: in place of each one's own; named by `FILE.toml`, `FILE.py:OBJECT` or
            `MODULE:OBJECT`.

    Raises:
        TegotaeError: for a name that means nothing or has no weights, or runs that two names hold.

    Example:
        >>> [task.name for task in tasks_of("paper", "quadruped-c")]
        ['paper', 'quadruped-c']
    """
    if subjects and all(isinstance(subject, Task) for subject in subjects):
        return list(subjects)  # type: ignore[arg-type]
    known = [resolve(subject) for subject in subjects]  # type: ignore[arg-type]
    for subject in known:
        environments = [saved.task.env for _, saved in subject.controllers if saved.task]
        require_all({k: v for env in environments for k, v in extras_of(env).items()})
    sets = distinct([(subject.name, runs) for subject in known for runs in sets_of(subject)])
    legs = {subject.name: subject.legged for subject in known}
    tasks = [task_of(runs, legs[place]) for place, runs in _apart(sets)]
    if body is None:
        return tasks
    new = body_called(body) if isinstance(body, str) else body
    return [task.on(new) for task in tasks]


def _apart(sets: Sequence[tuple[str, ControllerSet]]) -> list[tuple[str, ControllerSet]]:
    """The sets under names of their own: of those called alike, each with its place or a number."""
    names = [runs.name for _, runs in sets]
    for by_place in (True, False):
        counts, seen = Counter(names), Counter[str]()
        for i, name in enumerate(names):
            seen[name] += 1
            if counts[name] > 1:
                names[i] = f"{name} ({sets[i][0] if by_place else f'no. {seen[name]}'})"
    return [
        (place, dataclasses.replace(runs, name=name))
        for name, (place, runs) in zip(names, sets, strict=True)
    ]


def task_of(runs: ControllerSet, legged: Legged | None = None) -> Task:
    """Where controllers are tried: what they were trained on, and how many legs that has.

    Args:
        runs: the controllers.
        legged: of a legged system by name, whose legs it names.

    Raises:
        TegotaeError: for limbs of another simulator of which no environment is known.
    """
    if runs.task is not None:
        from tegotae.questions.environment import EnvironmentTask

        return EnvironmentTask(runs)
    if isinstance(runs.system.body, Interface):
        raise TegotaeError(
            f"{runs.name} drives the limbs of another simulator, whose mechanics are not here; "
            "tegotae train --env says where"
        )
    if runs.body.limbs > 1:
        from tegotae.questions.walking import WalkingTask

        return WalkingTask(runs, legged or settling(runs.system, runs.weights[0], runs.name))
    from tegotae.questions.hopping import HoppingTask

    return HoppingTask(runs)
