"""What controllers do where they are tried: `simulate`, `evaluate` and `compare`."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Any

from tegotae._support.errors import TegotaeError
from tegotae._support.progress import reporting
from tegotae.questions.answer import Answer, RecordedRun
from tegotae.questions.question import question
from tegotae.questions.task import Task

_ONE, _SEVERAL = "One leg, such as paper", "Several legs, such as quadruped-c"
_THERE = "Trained in another simulator"


def _there(question: str) -> Any:
    """The options of a controller that was trained in another simulator, which is an extra."""
    from tegotae.questions.environment import EnvironmentEvaluation, EnvironmentSimulation

    if question == "simulate":
        return EnvironmentSimulation(duration_s=24.0)
    return EnvironmentEvaluation(omega=())


@question(
    own=lambda task: task.simulate_options(),
    usual=("paper",),
    kinds={
        _ONE: "paper",
        _SEVERAL: "quadruped-c",
        _THERE: lambda: _there("simulate"),
    },
)
def simulate(task: Task, options: Any) -> RecordedRun:
    """Simulate a controller: one run, closely.

    Example:
        >>> simulate("paper", duration=4.0, drop=0.1, drop_time=2.0).frame().columns[1]
        'height_m'
    """
    return task.simulate(options)


_EVALUATED: dict[str, Any] = {
    "own": lambda task: task.evaluate_options(),
    "several": True,
    "kinds": {_ONE: "paper", _SEVERAL: "quadruped-c", _THERE: lambda: _there("evaluate")},
}


@question(**_EVALUATED)
def evaluate(tasks: Sequence[Task], options: Sequence[Any]) -> Answer:
    """Evaluate controllers: means over the runs of a training with their 95 % intervals."""
    _check(tasks, options)
    answers: list[Answer] = []
    with reporting("evaluate", len(tasks)) as reporter:
        for task, own in zip(tasks, options, strict=True):
            answers.append(task.evaluate(own))
            reporter.update(len(answers), task.name)
    return Answer.joined(answers)


@question(**_EVALUATED)
def compare(tasks: Sequence[Task], options: Sequence[Any]) -> Answer:
    """Compare controllers: how good each is, and how it differs from the first."""
    if len(tasks) < 2:
        raise TegotaeError(
            f"a comparison needs at least two sets of controllers; {len(tasks)} found"
        )
    _check(tasks, options)
    alike = [task.alike(own) for task, own in zip(tasks, options, strict=True)]
    for task, own in zip(tasks, alike, strict=True):
        for what in [what for what in own if own[what] != alike[0][what]]:
            raise TegotaeError(
                f"{tasks[0].name} and {task.name} are evaluated with another {what}, "
                f"{alike[0][what]} and {own[what]}; an option sets one for all"
            )
    return dataclasses.replace(evaluate.ask(tasks, options), base=tasks[0].name)


def _check(tasks: Sequence[Task], options: Sequence[Any]) -> None:
    """Raise `TegotaeError` for what has no measure in common, or cannot be evaluated."""
    for task, own in zip(tasks, options, strict=True):
        if type(task) is not type(tasks[0]):
            raise TegotaeError(
                f"{tasks[0].name} {tasks[0].what}, and {task.name} {task.what}: they have no "
                "measure in common"
            )
        task.check(own)
