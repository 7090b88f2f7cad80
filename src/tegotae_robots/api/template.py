"""A walker that stands for a legged robot, so that a law is trained on it and not on the robot."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from tegotae._support.errors import TegotaeError, require_all
from tegotae._support.files import write_atomically
from tegotae.api.parameters import check_types
from tegotae.api.results import UNDEFINED, TomlFile, short
from tegotae.systems.env_documents import extras_of, is_mujoco_model, is_robot_file, stem_of

if TYPE_CHECKING:  # which needs MuJoCo
    from tegotae_robots.models.template import Template

_RESPONSES = {
    "bounce": "under its weight",
    "sway": "under a tenth of it ahead",
}


def _numbers(template: Template) -> pd.DataFrame:
    """Return one row per number: dimensionless, in the robot's units, and its source."""
    rows: list[tuple[Any, ...]] = [
        ("mass", 1.0, template.mass_kg, "kg", "all bodies"),
        ("length l0", 1.0, template.length_m, "m", "hips over the feet at the start"),
        ("gravity", 1.0, template.gravity_m_per_s2, "m/s²", "the model's"),
    ]
    for name, number in template.numbers.items():
        value = np.multiply(number.value, number.scale)
        rows.append((name, number.value, value, number.unit, number.reason))
    weight = template.mass_kg * template.gravity_m_per_s2
    if math.isfinite(template.push_n):
        reason = "limits of torque, a leg straight down; a walker has none"
        rows.append(("largest push", template.push_n / weight, template.push_n, "N", reason))
    columns = ["number", "template", "robot", "unit", "from"]
    return pd.DataFrame(rows, columns=columns)


def _check(template: Template) -> pd.DataFrame:
    """Return one row per number of a step response: the walker's, the robot's, and their
    difference.
    """
    rows = []
    for name, when in _RESPONSES.items():
        pairs = zip(template.walker[name], template.robot.responses[name], strict=True)
        labels = (f"{name} {when}: travel [l0]", f"{name}: ω [√(g/l0)]", f"{name}: damping ratio")
        for label, (ours, robot) in zip(labels, pairs, strict=True):
            rows.append((label, ours, robot, ours / robot - 1.0))
    ours, robot = template.swings
    rows.append(
        ("a foot around its ellipse in the air: work [m g l0]", ours, robot, ours / robot - 1.0)
    )
    return pd.DataFrame(rows, columns=["step response", "template", "robot", "error"])


@check_types
def fit_template(
    env: str,
    *,
    feet: Sequence[str] = (),
    settings: Sequence[str] = (),
) -> TomlFile:
    """Fit a walker of this package, the template, to a MuJoCo model of a legged robot.

    A law is trained on it in minutes: `tegotae train AR@robot.toml`. Every number has its reason
    beside it; a step response compares the walker with the robot.

    Args:
        env: MuJoCo model, FILE.xml, or a robot's file, FILE.toml.
        feet: bodies or geoms that touch the ground; by default the lowest ones at the end of a
            chain.
        settings: further settings of the environment: NAME=VALUE, values as in JSON, such as
            ground=true.

    Raises:
        MissingExtraError: without MuJoCo.
        TegotaeError: for another environment than a MuJoCo model with legs.

    Example:
        >>> fit_template("robot.xml").save("robot.toml")  # doctest: +SKIP
    """
    require_all(extras_of(env))
    from tegotae.envs.robot_file import environment_named
    from tegotae_robots.models.template import fit_template as fitted

    if not is_mujoco_model(env) and not is_robot_file(env):
        raise TegotaeError(f"{env} is no MuJoCo model, FILE.xml, and no robot's file, FILE.toml")
    model = environment_named(env, settings, feet=feet).model_settings
    template = fitted(replace(model, legs=False), stem_of(env))
    numbers, check = _numbers(template), _check(template)
    columns = numbers.assign(template=numbers.template.map(short), robot=numbers.robot.map(short))
    checked = check.assign(
        template=check.template.map(short),
        robot=check.robot.map(short),
        error=[UNDEFINED if math.isnan(x) else f"{x:+.0%}" for x in check.error],
    )

    return TomlFile(
        raw=template,
        write=lambda path: write_atomically(path, template.text),
        title=template.about,
        rows=numbers,
        views=[columns.set_index("number"), checked.set_index("step response")],
        notes=[
            *template.remarks,
            "Next:",
            "tegotae simulate FILE.toml",
            "tegotae train AR@FILE.toml",
        ],
        data={**template.document, "check": check.to_dict("records")},
    )
