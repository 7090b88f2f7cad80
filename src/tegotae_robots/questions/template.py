"""A walker that stands for a legged robot, so that a law is trained on it and not on the robot."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from tegotae._support.errors import TegotaeError
from tegotae._support.files import write_atomically
from tegotae.questions.answer import UNDEFINED
from tegotae.questions.question import question
from tegotae.questions.wiring import Environments, stem_of
from tegotae.systems.env_task import is_mujoco_model
from tegotae.systems.robot_file import is_robot_file
from tegotae_robots.questions.model_file import ModelFile, ModelFileOptions

if TYPE_CHECKING:  # which needs MuJoCo
    from tegotae_robots.models.template import Template

_RESPONSES = {
    "bounce": "under its weight",
    "sway": "under a tenth of it ahead",
}


@dataclass(frozen=True, repr=False, kw_only=True)
class FittedTemplate(ModelFile):
    """A template, .toml, whose name is that of a system from then on. `raw` is a
    `tegotae_robots.models.template.Template`, and the document that of the walker."""

    def _write(self, file: Path) -> None:
        write_atomically(file, self.raw.text)


def _numbers(template: Template) -> pd.DataFrame:
    """A row a number: without dimension, as the robot's, and where it is from."""
    own: list[tuple[Any, ...]] = [
        ("mass", 1.0, template.mass_kg, "kg", "all bodies"),
        ("length l0", 1.0, template.length_m, "m", "hips over the feet at the start"),
        ("gravity", 1.0, template.gravity_m_per_s2, "m/s²", "the model's"),
    ]
    for name, number in template.numbers.items():
        value = np.multiply(number.value, number.scale)
        own.append((name, number.value, value, number.unit, number.reason))
    weight = template.mass_kg * template.gravity_m_per_s2
    if math.isfinite(template.push_n):
        why = "limits of torque, a leg straight down; a walker has none"
        own.append(("largest push", template.push_n / weight, template.push_n, "N", why))
    columns = ["number", "template", "robot", "unit", "from"]
    return pd.DataFrame(own, columns=columns)


def _check(template: Template) -> pd.DataFrame:
    """A row a number of a step response: the walker's, the robot's, and by how much they differ."""
    rows = []
    for name, when in _RESPONSES.items():
        pairs = zip(template.walker[name], template.robot.responses[name], strict=True)
        labels = (f"{name} {when}: travel [l0]", f"{name}: ω [√(g/l0)]", f"{name}: damping ratio")
        for label, (ours, its) in zip(labels, pairs, strict=True):
            rows.append((label, ours, its, ours / its - 1.0))
    ours, its = template.swings
    rows.append(
        ("a foot around its ellipse in the air: work [m g l0]", ours, its, ours / its - 1.0)
    )
    return pd.DataFrame(rows, columns=["step response", "template", "robot", "error"])


def _said(value: float | np.ndarray | tuple[float, ...]) -> str:
    numbers = [UNDEFINED if math.isnan(x) else f"{x:.4g}" for x in np.ravel(value)]
    return ", ".join(numbers)


@question(
    subjects=Environments,
    kinds={"option": lambda: ModelFileOptions.options_of("robot.xml")},
)
def template(env: str, options: ModelFileOptions) -> FittedTemplate:
    """Fit a walker of this package to a legged robot, a MuJoCo model: its template.

    A law is trained on it in minutes: `tegotae train AR@robot.toml`. Every number has its reason
    beside it; a step response compares the walker with the robot.

    Example:
        >>> template("robot.xml").save("robot.toml")  # doctest: +SKIP
    """
    from tegotae_robots.models.template import fit_template

    if not is_mujoco_model(env) and not is_robot_file(env):
        raise TegotaeError(f"{env} is no MuJoCo model, FILE.xml, and no robot's file, FILE.toml")
    FittedTemplate.check_name(options.out)
    settings = options.spec(env, options.feet).model_settings
    found = fit_template(replace(settings, legs=False), stem_of(env))
    numbers, check = _numbers(found), _check(found)
    shown = numbers.assign(template=numbers.template.map(_said), robot=numbers.robot.map(_said))
    checked = check.assign(
        template=check.template.map(_said),
        robot=check.robot.map(_said),
        error=[UNDEFINED if math.isnan(x) else f"{x:+.0%}" for x in check.error],
    )
    return FittedTemplate(
        raw=found,
        outcome=found.about,
        table=numbers,
        shown=[shown.set_index("number"), checked.set_index("step response")],
        remarks=[
            *found.remarks,
            "Next:",
            f"tegotae simulate {options.out}",
            f"tegotae train AR@{options.out}",
        ],
        data={**found.document, "check": check.to_dict("records")},
    )
