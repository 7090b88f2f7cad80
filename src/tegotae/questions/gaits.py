"""How the legs of a body go together: `gait_sweep`, `gait_map`, `gait_front`, `gait_stability` and
`gait_lesion`."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

import numpy as np
import pandas as pd

from tegotae._support.errors import TegotaeError
from tegotae._support.workplace import GAIT_FRONT, GAIT_MAP, require_free_for
from tegotae.analysis.gaits.front import Search, search_front
from tegotae.analysis.gaits.lesion import GaitLesion, aftermath
from tegotae.analysis.gaits.map import OMEGA, SIGMA, Axis, map_gaits
from tegotae.analysis.gaits.releases import release_all, system_document
from tegotae.analysis.gaits.stability import stability
from tegotae.analysis.gaits.sweep import DOWN, UP, sweep
from tegotae.parts.fields import numbers_of
from tegotae.questions.answer import UNDEFINED, AnswerBase, Picture, short
from tegotae.questions.options import picked
from tegotae.questions.question import Tasks, question
from tegotae.questions.walking import DrivenOptions, WalkingTask
from tegotae.systems.legged import Legged, assignments
from tegotae.systems.tuned import family

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class GaitStudy(Picture):
    """Many releases of a body with several legs: a table of them, and its figure."""

    ENDING = ""
    save = AnswerBase.save


@dataclass(frozen=True, kw_only=True)
class SeveralLegs(Tasks):
    """Controllers on a body with several legs, by name."""

    KIND = WalkingTask
    WHY = "a gait is how several legs go together"


_LEGS: dict[str, Any] = {
    "subjects": SeveralLegs,
    "kinds": {
        "A walker, such as quadruped-c": "quadruped-c",
        "A bar, such as bar-light": "bar-light",
    },
    "written": "folder",
}


RELEASES = ("starts", "seed", "tolerance")
"""Options about random releases, which the analyses have as arguments."""


@dataclass(frozen=True, kw_only=True)
class GaitOptions(DrivenOptions):
    """The system and its random releases."""

    seed: int = 0
    """Seed of the random phases at release."""

    @classmethod
    def options_of(cls, task: WalkingTask) -> Self:
        """The system's own values."""
        return cls(**task.driven_options())

    def legged(self, task: WalkingTask, *over: Axis) -> Legged:
        """The system with what was given.

        Args:
            task: the system as it is named.
            over: what of it is varied.

        Raises:
            TegotaeError: for what cannot be, or one value of what is varied.
        """
        usual = task.driven_options()
        for axis in over:
            if axis.name in (OMEGA, SIGMA) and getattr(self, axis.name) != usual[axis.name]:
                raise TegotaeError(f"{axis.name} is one value, and it is varied")
        return task.driven(self)

    def study(
        self,
        task: WalkingTask,
        found: Any,
        frame: pd.DataFrame,
        draw: Callable[[Any, str], Figure],
        over: Sequence[str] = (),
        made: type[Picture] = GaitStudy,
        **more: Any,
    ) -> Any:
        """The answer.

        Args:
            task: the system as it is named.
            found: what was computed.
            frame: its table.
            draw: the figure of it, with a title.
            over: what was varied.
            made: the answer's class.
            more: fields of the answer; `data` stands in the document before the rows.
        """
        legged = self.legged(task)
        numbers = {"system": system_document(legged), **more.pop("data", {})}
        return made(
            raw=found,
            drawn=lambda: draw(found, self._title(task, legged, over)),
            tables={"": frame},
            settings=replace(self, out=None) if hasattr(self, "out") else self,
            data={**numbers, "rows": frame.to_dict("records")},
            **more,
        )

    def _title(self, task: WalkingTask, legged: Legged, over: Sequence[str]) -> str:
        """The system, and what of it is otherwise, in a few words."""
        from tegotae.figures.gaits.style import in_words
        from tegotae.figures.style import literal

        usual = numbers_of(task.legged.body)
        changed = {name: x for name, x in numbers_of(self.body).items() if x != usual[name]}
        words = [task.name, *(f"{in_words(name)} {short(x)}" for name, x in changed.items())]
        words += [" ".join(self.terrain)]
        words += [
            f"{name} {x:g}" for name, x in (("delay", self.delay_s), ("noise", self.noise)) if x
        ]
        at = "" if legged.omega is None or OMEGA in over else f", ω = {legged.omega:g}"
        return literal(", ".join(filter(None, words))) + at


@dataclass(frozen=True, kw_only=True)
class WalkingBasin(GaitOptions):
    """The gaits of several legs that emerge from random phases, how often, and how soon."""

    starts: int = 256
    """Number of releases."""

    def picture(self, task: WalkingTask) -> Picture:
        """The basins of the random releases."""
        from tegotae.figures.gaits.maps import basin_figure

        legged = self.legged(task)
        if legged.omega is None:
            raise TegotaeError(
                "starts differ in the phases of the oscillators, and this controller has none: all "
                "would be the same one, which a simulation shows"
            )
        basin = release_all(legged, **picked(self, *RELEASES))
        names, unit = legged.names, legged.units[1]
        outcomes: Any = basin.outcomes
        shown = [
            {
                "gait": x.gait,
                "starts": x.count,
                "share": f"{x.share:.3f}",
                "95 %": f"{x.low:.3f} … {x.high:.3f}",
                **{
                    f"lag {leg}": _lag(x.lag[i], x.between[i])
                    for i, leg in enumerate(names)
                    if i != legged.reference
                },
                f"locks in [{unit}]": short(x.lock_time_s),
            }
            for x in outcomes.itertuples()
        ]
        return self.study(
            task,
            basin,
            basin.frame.drop(columns=["run", "omega"]),
            basin_figure,
            made=Picture,
            remarks=(
                f"Lags behind {names[legged.reference]} in cycles, circular mean ± deviation over "
                "the starts; median time to lock.",
            ),
            shown=[pd.DataFrame(shown).set_index("gait")],
            data={"outcomes": outcomes.to_dict("records")},
        )


def _lag(mean: float, between: float) -> str:
    if math.isnan(mean):
        return short(mean)
    return f"{round(mean, 3) % 1.0:.3f} ± " + (f"{between:.3f}" if between < 1.0 else "all round")


def _counts(names: pd.Series) -> pd.Series:
    """How often each name is there, the most common first, those as common by letters."""
    return names.value_counts().sort_index().sort_values(ascending=False, kind="stable")


def _around(value: float | None) -> tuple[float, float]:
    """From half of a value to one and a half of it."""
    value = value or 1.0
    return 0.5 * value, 1.5 * value


@dataclass(frozen=True, kw_only=True)
class SweepOptions(GaitOptions):
    """Levels of the frequency, upwards and downwards."""

    levels: tuple[float, float]
    """Lowest and highest frequency ω [rad/s]."""
    count: int = 16
    """Number of levels."""
    dwell_s: float | None = None
    """Duration of each level [s]; by default half of the system's duration."""
    starts: int = 16
    """Number of releases in each direction."""

    @classmethod
    def options_of(cls, task: WalkingTask) -> SweepOptions:
        return cls(**task.driven_options(), levels=_around(task.legged.omega))


@question(**_LEGS)
def gait_sweep(task: WalkingTask, options: SweepOptions) -> GaitStudy:
    """Raise the frequency step by step and lower it again, to find gait changes and hysteresis.

    Example:
        >>> gait_sweep("bar-light", levels=(7.5, 8.0), count=2, dwell=40.0, starts=2).notes[0]
        'no named gait changes on the way up and returns on the way down'
    """
    from tegotae.figures.gaits.lags import sweep_figure

    levels = Axis.between(OMEGA, *options.levels, options.count)
    legged = options.legged(task, levels)
    if options.dwell_s is not None and options.duration_s != task.legged.timing.duration_s:
        raise TegotaeError("the duration does nothing beside the dwell; leave one of them out")
    dwell_s = 0.5 * options.duration_s if options.dwell_s is None else options.dwell_s
    found = sweep(legged, levels.values, dwell_s=dwell_s, **picked(options, *RELEASES))
    gaits = found.frame.groupby(["omega_rad_per_s", "direction"])["gait"]
    listed: Any = gaits.agg(lambda x: ", ".join(f"{name} {n}" for name, n in _counts(x).items()))
    summary = listed.unstack()[[UP, DOWN]].add_prefix("gaits on the way ").rename_axis(index="ω")
    where = ", ".join(f"{w:.4g}" for w in found.bistable)
    changes = found.hysteresis
    return options.study(
        task,
        found,
        found.frame,
        sweep_figure,
        [OMEGA],
        shown=[summary.set_index(summary.index.map("{:.4g}".format))],
        remarks=(
            *(_in_a_line(change) for change in changes.round(9).to_dict("records")),
            *([] if len(changes) else [_NO_CHANGE]),
            f"lags differ between the two ways at {where or 'no level'}",
        ),
        data={
            "dwell_s": dwell_s,
            "hysteresis": changes.to_dict("records"),
            "bistable": found.bistable,
        },
    )


_NO_CHANGE = "no named gait changes on the way up and returns on the way down"


def _in_a_line(change: dict[Any, Any]) -> str:
    """A change of gait and its hysteresis."""
    return (
        "{slow} to {fast}: up between {up_low:.3g} and {up_high:.3g} ({up_starts} starts), down "
        "between {down_low:.3g} and {down_high:.3g} ({down_starts}); hysteresis between "
        "{width_low:.3g} and {width_high:.3g}"
    ).format(**change)


@dataclass(frozen=True, kw_only=True)
class MapOptions(GaitOptions):
    """Two parameters: omega, sigma, or parameters of the body.

    For a parameter with one value per leg, such as hips_x_m, the values of an axis are factors on
    all of them.
    """

    x: tuple[str, float, float]
    """Columns: a parameter, its lowest and its highest value, such as com_x_m -0.3 0.3."""
    y: tuple[str, float, float]
    """Rows: another parameter, its lowest and its highest value."""
    cells: tuple[int, int] = (60, 60)
    """Numbers of columns and rows."""
    starts: int = 4
    """Number of releases per cell."""
    out: Path | None = None
    """Folder for picture, table, document and what is done; the same one again continues."""

    @classmethod
    def options_of(cls, task: WalkingTask) -> MapOptions:
        x, y = (OMEGA, *_around(task.legged.omega)), (SIGMA, *_around(task.sigma))
        return cls(**task.driven_options(), x=x, y=y)


@question(**_LEGS)
def gait_map(task: WalkingTask, options: MapOptions) -> GaitStudy:
    """Map the gaits over two parameters; run it again on the same folder to continue.

    Example:
        >>> axes = {"x": ("inertia_ratio", 0.6, 1.6), "y": ("sigma", 1.0, 1.5)}
        >>> gait_map("bar-light", **axes, cells=(2, 2), starts=2).frame().gait.tolist()
        ['antiphase', 'in phase', 'antiphase', 'in phase']
    """
    from tegotae.figures.gaits.maps import map_figure

    x = Axis.between(*options.x, options.cells[0])
    y = Axis.between(*options.y, options.cells[1])
    legged = options.legged(task, x, y)
    if options.out is not None:
        require_free_for(options.out, GAIT_MAP)
    found = map_gaits(legged, x, y, folder=options.out, **picked(options, *RELEASES))
    cells: Any = found.cells
    counts = _counts(cells["gait"])
    of_gaits = cells.groupby("gait")
    cost = of_gaits["cost_of_transport"].agg(["min", "max"]).loc[counts.index]
    summary = pd.DataFrame(
        {
            "cells": counts,
            "share": (counts / len(cells)).map("{:.3f}".format),
            "all starts agree": of_gaits["share"].agg(lambda x: f"{(x == 1.0).mean():.3f}"),
            "cost of transport": [
                UNDEFINED if math.isnan(low) else f"{low:.3g} … {high:.3g}"
                for low, high in cost.to_numpy()
            ],
        },
        index=counts.index.rename("gait of most starts"),
    )
    axes = {"x": x, "y": y}
    return options.study(
        task, found, cells, map_figure, [x.name, y.name], shown=[summary], data=axes
    )


@dataclass(frozen=True, kw_only=True)
class FrontOptions(GaitOptions):
    """How much is searched, over frequency, gain, stride and lift."""

    family: tuple[str, ...] = ("vanilla",)
    """Controllers of the legs: vanilla, cosine, "vanilla ellipse", or a gait prescribed without
    feedback, such as "forced trot"."""
    walkers: int = 8192
    """Number of random walkers at the start."""
    rounds: int = 8
    """Number of rounds in which the cheapest walkers of every speed are varied."""
    varied: int = 1024
    """Number of variations per round."""
    starts: int = 4
    """Number of releases per walker. All must stay up and settle."""
    unseen: int = 32
    """Number of further releases, from other phases, to check the cheapest walkers."""
    out: Path | None = None
    """Folder for picture, table, document and what is done; the same one again continues."""


@question(**_LEGS)
def gait_front(task: WalkingTask, options: FrontOptions) -> GaitStudy:
    """Search for the least cost of transport at every speed; run it again on the same folder to
    continue."""
    from tegotae.figures.gaits.maps import front_figure

    amounts = picked(options, "rounds", "varied", "starts", "unseen", "seed")
    search = Search(coarse=options.walkers, **amounts)
    legged = options.legged(task)
    families = [family(legged, name) for name in dict.fromkeys(options.family)]
    if options.out is not None:
        require_free_for(options.out, GAIT_FRONT)
    fronts = [search_front(legged, each, search, options.out) for each in families]
    if not any(map(len, fronts)):
        raise TegotaeError(
            f"no walker of {task.name} among {sum(search.sizes)} stays up at a steady speed from "
            "every release, so it has no front; try fewer --starts, or more --walkers in a folder "
            "of their own"
        )
    table = pd.concat(fronts, ignore_index=True)
    shown = {"speed": ".3f", "cost_of_transport": ".3f", "omega": ".2f", "gait": ""}
    summary = pd.DataFrame(
        {name: table[name].map(f"{{:{style}}}".format) for name, style in shown.items()}
    ).set_index(pd.Index(table["family"]))
    return options.study(
        task, table, table, front_figure, [OMEGA], shown=[summary], data={"search": search}
    )


@dataclass(frozen=True, kw_only=True)
class StabilityOptions(GaitOptions):
    """A parameter, and how the lags are perturbed."""

    over: tuple[str, float, float]
    """Parameter (omega, sigma, or one of the body), its lowest and its highest value."""
    count: int = 14
    """Number of values."""
    gaits: tuple[str, ...] = ()
    """Names of gaits, such as trot; by default all for this number of legs."""
    kick: float = 0.005
    """Size of the perturbation of the legs' phases, at half of the time [cycles]."""
    pairs: int = 8
    """Number of directions of the perturbation, each in both signs."""
    skip: int = 4
    """Number of cycles after the perturbation that are left out."""
    cycles: int = 8
    """Number of cycles fitted after these."""

    @classmethod
    def options_of(cls, task: WalkingTask) -> StabilityOptions:
        return cls(**task.driven_options(), over=(OMEGA, *_around(task.legged.omega)))


@question(**_LEGS)
def gait_stability(task: WalkingTask, options: StabilityOptions) -> GaitStudy:
    """Measure how small deviations of the lags grow or decay, cycle by cycle, over a parameter.

    Example:
        >>> near = ("inertia_ratio", 0.98, 1.02)
        >>> gait_stability("bar-light", over=near, count=2, gaits=("in phase",)).notes[0]
        'in phase gains its stability at inertia_ratio 1'
    """
    from tegotae.figures.gaits.maps import stability_figure

    over = Axis.between(*options.over, options.count)
    how = picked(options, "kick", "pairs", "skip", "cycles", "seed", "tolerance")
    found = stability(options.legged(task, over), over, options.gaits or None, **how)
    frame: Any = found.frame
    shown = [
        UNDEFINED if math.isnan(a) else f"{a:.3f}, {b:.3f}"
        for a, b in zip(frame["largest"], frame["unexplained"], strict=True)
    ]
    summary = frame.assign(shown=shown).pivot(index=over.name, columns="gait", values="shown")
    summary = summary[list(found.jacobians)].add_suffix(": largest, unexplained")
    crossings = [
        f"{gait} {'loses' if loses else 'gains'} its stability at {over.name} {at:.3g}"
        for gait, at, loses in found.crossings.itertuples(index=False)
    ]
    ends = []
    for gait, own in frame[frame["refused"] == ""].groupby("gait", sort=False):
        values, stays = own[over.name].to_numpy(), own["stays"].to_numpy()
        for i in np.flatnonzero(np.diff(stays.astype(int))):
            side = "below" if stays[i] else "above"
            between = f"{values[i]:.3g} … {values[i + 1]:.3g}"
            ends.append(f"{gait}, simulated to the end: stays {side} {between}")
    none = "no multiplier crosses one between neighbouring values"
    return options.study(
        task,
        found,
        frame,
        stability_figure,
        [over.name],
        shown=[summary.set_index(summary.index.map("{:.4g}".format))],
        remarks=(*crossings, *ends, *([] if crossings else [none])),
        data={
            "crossings": found.crossings.to_dict("records"),
            "jacobians": found.jacobians,
        },
    )


@dataclass(frozen=True, kw_only=True)
class LesionOptions(GaitOptions):
    """What happens, and when."""

    lose: tuple[str, ...] = ()
    """Names of legs that are lost, such as LH."""
    then: tuple[str, ...] = ()
    """Parameters of the body that change at that time, such as mass_kg=1.3 com_x_m=0.1."""
    lasting_s: float | None = None
    """Duration of this change [s], such as for a push, push_y_n=0.3; by default permanent."""
    drop_m: float = 0.0
    """Height by which the ground drops [m]."""
    at_s: float | None = None
    """Time of the event [s]; by default half of the duration."""
    starts: int = 64
    """Number of releases."""


@question(**_LEGS)
def gait_lesion(task: WalkingTask, options: LesionOptions) -> GaitStudy:
    """Remove a leg, change the body or drop the ground, and count the releases that stay up.

    Example:
        >>> gait_lesion("bar-light", drop=0.05, starts=4, duration=60.0).title
        'ground 0.05 lower at 30 s: 4 of 4 that stood stay up, 1.000 (0.510 … 1.000)'
    """
    from tegotae.figures.gaits.maps import lesion_figure

    legged = options.legged(task)
    lesion = GaitLesion(
        at_s=0.5 * options.duration_s if options.at_s is None else options.at_s,
        lost=options.lose,
        fields=tuple(assignments("--then", options.then).items()),
        drop_m=options.drop_m,
        lasts_s=math.inf if options.lasting_s is None else options.lasting_s,
    )
    found = aftermath(legged, lesion, **picked(options, *RELEASES))
    frame: Any = found.frame
    share, low, high = found.share
    stood, stays = frame[frame["stood_before"]], frame[frame["stays_up"]]
    (length, time), margin = legged.units, found.margin_m
    remarks = [f"the mass is {margin:.3f} {length} inside the feet that are left"]
    remarks = [] if math.isnan(margin) else remarks
    for leg in found.left:
        change = stays[f"lag_change_cycles_{legged.names[leg]}"].median()
        if leg != found.reference and not math.isnan(change):
            remarks.append(f"lag of {legged.names[leg]} moves by {change:+.3f} cycles (median)")
    for what, values in (
        ("falls after", stood["after_fall_time_s"]),
        ("locks again after", stays["after_lock_time_s"]),
    ):
        if values.count():
            remarks.append(f"{what} {values.median():.3g} {time} (median of {values.count()})")
    pairs = _counts(stood["gait_before"] + " → " + stood["gait_after"])
    return options.study(
        task,
        found,
        frame,
        lesion_figure,
        outcome=f"{found.lesion.label} at {found.lesion.at_s:g} {time}: {len(stays)} of "
        f"{len(stood)} that stood stay up, {share:.3f} ({low:.3f} … {high:.3f})",
        shown=[pairs.rename_axis("before → after").to_frame("starts")],
        remarks=remarks,
        data={
            "lesion": found.lesion,
            "reference": legged.names[found.reference],
            "margin_m": margin,
            "stays_up": {"share": share, "low": low, "high": high, "of": len(stood)},
        },
    )
