"""The verb `explain`: one controller on a page."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

import tegotae
from tegotae._support.documents import JsonObject, as_json
from tegotae._support.errors import TegotaeError, require_count, require_finite
from tegotae._support.files import write_atomically
from tegotae._support.limits import MOST_POINTS
from tegotae.analysis.controller_page import ControllerPage
from tegotae.analysis.explanation import (
    SPREAD_M,
    ReleasedController,
    ReleasedHopper,
    ReleasedWalker,
)
from tegotae.analysis.surface import actuation_surface
from tegotae.api.controller import LoadedController
from tegotae.api.hopping import HopperController
from tegotae.api.results import MatplotlibFigure, Table
from tegotae.api.walking import WalkerController
from tegotae.parts.bodies import Hopper, Walker
from tegotae.parts.fields import unwrapped
from tegotae.parts.maths import TWO_PI
from tegotae.simulation.world import OMEGA
from tegotae.systems.controller_file import SavedController, save
from tegotae.systems.legged import random_phases
from tegotae.systems.resolve import resolve

if TYPE_CHECKING:
    from tegotae.analysis.surface import Surface


def explain(controller: LoadedController, options: Any) -> Explanation:
    """Explain a controller on one page (`LoadedController.explain`).

    Args:
        controller: the controller.
        options: parameters of the method, without None.

    Raises:
        TegotaeError: for a controller elsewhere than on a body of this package, or values that
            cannot be.
    """
    task = _explainable(controller)
    require_finite("duration_s", options.duration_s, least=1.0)
    require_count("releases", options.releases, most=MOST_POINTS)
    require_count("seed", options.seed, least=0)
    require_count("retune", options.retune, least=0)
    require_count("retune_seeds", options.retune_seeds, most=MOST_POINTS)
    require_count("first_seed", options.first_seed, least=0)
    if options.retune and options.releases < 2:
        raise TegotaeError(
            "releases is 1; it must be at least 2, of which one half chooses among the short forms "
            "and the other judges; or retune none, with retune 0"
        )
    seeds = range(options.first_seed, options.first_seed + options.retune_seeds)
    page = ControllerPage.from_releases(
        _released(task, options), name=task.name, retune=options.retune, seeds=seeds
    )
    return Explanation(title=task.name, raw=page, notes=page.sentences(), settings=vars(options))


def _explainable(controller: LoadedController) -> HopperController | WalkerController:
    """Return the controller; refuse one on a body that is not of this package."""
    if len(controller.runs.weights) > 1 and controller.source:
        resolve(controller.source).controller()  # refused, with the file of one
    if isinstance(controller, WalkerController):
        if not isinstance(unwrapped(controller.runs.body), Walker):
            raise TegotaeError(
                f"explain judges legs by their cost of transport, and {controller.name} hops in "
                "place; tegotae gait sweep and tegotae gait stability study it"
            )
        return controller
    return controller.require(
        HopperController,
        "explain reads what moves on a body of this package; tegotae simulate --csv records its "
        "senses, phases and commands there, and tegotae evaluate measures it",
    )


def _released(task: HopperController | WalkerController, options: Any) -> ReleasedController:
    """Return the releases from which a controller is evaluated."""
    runs, n = task.runs, options.releases
    saved = SavedController(runs.system, task.weights, task.name, runs.experiment)
    if isinstance(task, WalkerController):
        legged = task.legged
        timing = replace(legged.timing, duration_s=options.duration_s)
        release = legged.scenario(random_phases(legged.body.limbs, n, options.seed))
        return ReleasedWalker(saved, _frequencies(saved), release, timing, legged=legged)
    protocol = replace(runs.protocol, undisturbed_s=options.duration_s)
    draw, usual_m = np.random.default_rng(options.seed), runs.system.release.height_m
    release = runs.system.scenario(
        height_m=usual_m + draw.uniform(-SPREAD_M, SPREAD_M, n),
        phase_rad=draw.uniform(0.0, TWO_PI, n),
    )
    timing = runs.system.timing_over(options.duration_s, tick_s=protocol.tick_s)
    return ReleasedHopper(saved, _frequencies(saved, protocol.offsets), release, timing, protocol)


def _frequencies(saved: SavedController, offsets: Sequence[float] = ()) -> np.ndarray:
    """Return the commands [rad/s]: those of the evaluation, those of the training, or others around
    its own ω.
    """
    omega = saved.omega
    if omega is None:
        return np.array([math.nan])
    conditions = () if saved.experiment is None else saved.experiment.conditions
    for condition in conditions:
        if condition.name == OMEGA:
            return np.linspace(min(condition.extremes), max(condition.extremes), 5)
    around = omega + np.array(offsets)
    return around if len(around) and min(around) > 0.0 else omega * np.linspace(0.5, 1.5, 5)


@dataclass(frozen=True, repr=False, kw_only=True)
class Explanation(Table):
    """Explanation of a controller; its page is `page.md` of the folder that `save` writes."""

    raw: ControllerPage  # pyright: ignore[reportGeneralTypeIssues] - keyword-only, so in any order
    settings: Mapping[str, Any]
    """Options of the explanation."""

    @property
    def table(self) -> pd.DataFrame:
        """Scores, one row per variant, release and frequency."""
        return self.raw.table

    def texts(self) -> list[pd.DataFrame]:
        tables = (self.raw.scores, self.raw.curves, self.raw.tried)
        return [table for table in tables if len(table)]

    def page(self) -> str:
        """Return the page, in Markdown; its figures are beside it."""
        return self.raw.markdown()

    def to_dict(self) -> JsonObject:
        page = self.raw
        scores = {
            name: {"mean": x.mean, "following": x.following_of_releases, **asdict(x)}
            for name, x in page.evaluated.items()
        }
        forms = [
            {
                "name": form.name,
                "chosen_by": form.chosen_by,
                "kept": form.kept,
                "weights": form.saved.weights,
            }
            for form in page.forms
        ]
        return as_json(
            {
                "name": page.name,
                "settings": self.settings,
                "feedback_rad_per_s": page.feedback_rad_per_s,
                "scores": scores,
                "curves": page.curves.reset_index().to_dict("records"),
                "forms": forms,
                "said": self.notes,
            }
        )

    def figures(self) -> Mapping[str, MatplotlibFigure]:
        from tegotae.figures.explanation import explanation_figure, forms_figure

        page = self.raw
        curves = explanation_figure(page.name, page.visited, self._surface(), page.evaluated)
        rows = [(form.name, form.numbers, form.evaluated.mean) for form in page.forms]
        unit = "m/J" if page.hops else "1"
        further = {"forms": forms_figure(rows, page.evaluated, unit)} if rows else {}
        return {"curves": curves, **further}

    def _surface(self) -> Surface | None:
        saved, v = self.raw.released.saved, self.raw.visited[0]
        if not isinstance(saved.body, Hopper):
            return None
        most_n = 1.1 * max(float(v.spring_force_n.max()), float(saved.body.weight_n))
        most_n = min(most_n, saved.body.most_spring_n)
        return actuation_surface(saved, np.linspace(0.0, most_n, 80), columns=120)

    def _fill(self, folder: Path) -> list[Path]:
        """Write the page, its figures, numbers and document into a folder, and the shortest forms,
        each as a controller file and as a folder of C."""
        paths = super()._fill(folder)
        for form in self.raw.chosen_forms:
            paths.append(folder / f"{form.name}.json")
            save(form.saved, paths[-1])
            if self.raw.hops:
                paths += tegotae.robots.export_c(form.saved).save(folder / f"{form.name}-c")
        path = folder / "page.md"
        write_atomically(path, self.page())
        return [path, *paths]
