"""Coordination of the legs of a body: gaits and their basins, maps, costs, stability, lesions."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from tegotae._support.errors import TegotaeError
from tegotae._support.workplace import GAIT_FRONT, GAIT_MAP, require_free_for
from tegotae.analysis.gaits.front import Search, search_front
from tegotae.analysis.gaits.lesion import GaitLesion, aftermath
from tegotae.analysis.gaits.map import OMEGA, SIGMA, Axis, map_gaits
from tegotae.analysis.gaits.releases import release_all, system_document
from tegotae.analysis.gaits.stability import stability as measured_stability
from tegotae.analysis.gaits.sweep import DOWN, UP, sweep as swept
from tegotae.api.controller import Changes, Subject
from tegotae.api.controllers import one
from tegotae.api.parameters import filled, in_shell
from tegotae.api.results import UNDEFINED, Figure, short
from tegotae.api.walking import WalkerController
from tegotae.measures.gaits.names import TOLERANCE
from tegotae.parts.bodies import Body
from tegotae.parts.fields import numbers_of
from tegotae.systems.legged import Legged, assignments
from tegotae.systems.tuned import family as family_of

if TYPE_CHECKING:
    from matplotlib import figure as matplotlib_figure

__all__ = ["basin", "front", "map", "perturb", "stability", "sweep"]
Walking = Subject | WalkerController
"""Controller of a body with several legs, by name or loaded."""
_EXAMPLES = {
    "A walker, such as quadruped-c": "quadruped-c",
    "A bar, such as bar-light": "bar-light",
}
_FOLDER: dict[str, Any] = {"writes": "folder", "examples": _EXAMPLES}


def __dir__() -> list[str]:
    return __all__


class _Study:
    """A system with several legs under study, with its options.

    Args:
        controller: the system, by name or loaded.
        options: parameters of the study.
        over: quantities that are varied.
    """

    def __init__(self, controller: Walking, options: Mapping[str, Any], *over: Axis) -> None:
        controller = _walker(controller)
        defaults = {**controller.defaults(), **_default_ranges(_walker(controller))}
        for axis in over:
            value = options[axis.name] if axis.name in (OMEGA, SIGMA) else None
            if value not in (None, defaults.get(axis.name)):
                raise TegotaeError(f"{axis.name} is one value, and it is varied")
        self.controller, self.over = controller, [axis.name for axis in over]
        self.options = filled(options, defaults)
        self.releases = {name: options[name] for name in ("seed", "tolerance")}
        self.legged: Legged = controller.driven(self.options)

    def figure(
        self,
        raw: Any,
        frame: pd.DataFrame,
        draw: Callable[[Any, str], matplotlib_figure.Figure],
        **fields: Any,
    ) -> Figure:
        """Return the result.

        Args:
            raw: result of the computation.
            frame: its table.
            draw: function of it and of a title that draws the figure.
            more: fields of the result; `data` stands in the document before the rows.
        """
        numbers = {"system": system_document(self.legged), **fields.pop("data", {})}
        settings = vars(self.options)
        hidden = ("controller", "out")
        return Figure(
            raw=raw,
            draw=lambda: {"figure": draw(raw, self._title())},
            figure_tables={"": frame},
            settings={name: x for name, x in settings.items() if name not in hidden},
            data={**numbers, "rows": frame.to_dict("records")},
            **fields,
        )

    def _title(self) -> str:
        """The system, and its changes, in a few words."""
        from tegotae.figures.gaits.style import in_words
        from tegotae.figures.style import literal_text

        options, omega = self.options, self.legged.omega
        numbers = numbers_of(self.controller.legged.body)
        changed = {name: x for name, x in numbers_of(options.body).items() if x != numbers[name]}
        words = [self.controller.name, *(f"{in_words(n)} {short(x)}" for n, x in changed.items())]
        words += [" ".join(options.terrain)]
        words += [
            f"{name} {x:g}"
            for name, x in (("delay", options.delay_s), ("noise", options.noise))
            if x
        ]
        suffix = "" if omega is None or OMEGA in self.over else f", ω = {omega:g}"
        return literal_text(", ".join(filter(None, words))) + suffix


def _default_ranges(controller: WalkerController) -> dict[str, Any]:
    """Usual ranges of the axes of a study."""
    omega = (OMEGA, *_around(controller.legged.omega))
    return {
        "levels": omega[1:],
        "x": omega,
        "y": (SIGMA, *_around(controller.sigma)),
        "over": omega,
    }


_RANGES: dict[str, Any] = {"defaults": lambda controller, **_: _default_ranges(_walker(controller))}


def _axis(limits: tuple[str, float, float], count: int) -> Axis:
    """Evenly spaced values of a parameter between its limits."""
    name, low, high = limits
    return Axis.between(name, low, high, count)


def _walker(controller: Walking) -> WalkerController:
    """The controller, which must be one of a body with several legs."""
    return one(controller, WalkerController, "a gait is how several legs go together")


@in_shell(writes="file", examples=_EXAMPLES)
def basin(
    controller: Walking,
    *,
    starts: int = 256,
    duration_s: float | None = None,
    omega: float | None = None,
    sigma: float | None = None,
    seed: int = 0,
    terrain: Sequence[str] = (),
    delay_s: float | None = None,
    noise: float | None = None,
    tolerance: float = TOLERANCE,
    body: Body | Changes | None = None,
) -> Figure:
    """Draw the gaits of several legs that emerge from random phases, how often, and how soon.

    Args:
        controller: body with several legs and its controller.
        starts: number of releases.
        duration_s: simulated time [s].
        omega: frequency ω [rad/s].
        sigma: gain σ of the vanilla feedback [rad/(s N)].
        seed: seed of the random phases at release.
        terrain: ground of a walking torso: flat, slope, steps, rough or FILE.py:OBJECT, followed by
            its parameters, such as rough rms_m=0.05.
        delay_s: delay of the senses of the legs [s].
        noise: noise of the senses of the legs, relative to their scales.
        tolerance: tolerance around the lags of a named gait [cycles].
        body: another body, or changes of the system's own.

    Raises:
        TegotaeError: for values that cannot be, before anything is computed.

    Example:
        >>> len(basin("bar-light", starts=8).table)
        8
    """
    study = _Study(controller, locals())
    from tegotae.figures.gaits.maps import gait_basin_figure

    legged = study.legged
    if legged.omega is None:
        raise TegotaeError(
            "starts differ in the phases of the oscillators, and this controller has none: all "
            "would be the same one, which a simulation shows"
        )
    basin = release_all(legged, starts=starts, **study.releases)
    names, unit = legged.names, legged.units[1]
    outcomes: Any = basin.outcomes
    rows = [
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
    return study.figure(
        basin,
        basin.frame.drop(columns=["run", "omega"]),
        gait_basin_figure,
        notes=(
            f"Lags behind {names[legged.reference]} in cycles, circular mean ± deviation over "
            "the starts; median time to lock.",
        ),
        views=[pd.DataFrame(rows).set_index("gait")],
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


@in_shell(**_FOLDER, **_RANGES)
def sweep(
    controller: Walking,
    *,
    levels: tuple[float, float] | None = None,
    count: int = 16,
    dwell_s: float | None = None,
    starts: int = 16,
    duration_s: float | None = None,
    omega: float | None = None,
    sigma: float | None = None,
    seed: int = 0,
    terrain: Sequence[str] = (),
    delay_s: float | None = None,
    noise: float | None = None,
    tolerance: float = TOLERANCE,
    body: Body | Changes | None = None,
) -> Figure:
    """Raise the frequency step by step and lower it again, to find gait changes and hysteresis.

    Args:
        controller: body with several legs and its controller.
        levels: lowest and highest frequency ω [rad/s]; by default half and one and a half of the
            system's.
        count: number of levels.
        dwell_s: duration of each level [s]; by default half of the system's duration.
        starts: number of releases in each direction.
        duration_s: simulated time [s].
        omega: frequency ω [rad/s].
        sigma: gain σ of the vanilla feedback [rad/(s N)].
        seed: seed of the random phases at release.
        terrain: ground of a walking torso: flat, slope, steps, rough or FILE.py:OBJECT, followed by
            its parameters, such as rough rms_m=0.05.
        delay_s: delay of the senses of the legs [s].
        noise: noise of the senses of the legs, relative to their scales.
        tolerance: tolerance around the lags of a named gait [cycles].
        body: another body, or changes of the system's own.

    Raises:
        TegotaeError: for values that cannot be, before anything is computed.

    Example:
        >>> sweep("bar-light", levels=(7.5, 8.0), count=2, dwell_s=40.0, starts=2).notes[0]
        'no named gait changes on the way up and returns on the way down'
    """
    options, controller = locals(), _walker(controller)
    from tegotae.figures.gaits.lags import sweep_figure

    axis = Axis.between(OMEGA, *(levels or _around(controller.legged.omega)), count)
    study = _Study(controller, options, axis)
    if dwell_s is not None and study.options.duration_s != controller.defaults()["duration_s"]:
        raise TegotaeError("duration_s does nothing beside dwell_s; leave one of them out")
    dwell_s = float(0.5 * study.options.duration_s if dwell_s is None else dwell_s)
    result = swept(study.legged, axis.values, dwell_s=dwell_s, starts=starts, **study.releases)
    gaits = result.frame.groupby(["omega_rad_per_s", "direction"])["gait"]
    listed: Any = gaits.agg(lambda x: ", ".join(f"{name} {n}" for name, n in _counts(x).items()))
    summary = listed.unstack()[[UP, DOWN]].add_prefix("gaits on the way ").rename_axis(index="ω")
    where = ", ".join(f"{w:.4g}" for w in result.bistable)
    changes = result.hysteresis
    return study.figure(
        result,
        result.frame,
        sweep_figure,
        views=[summary.set_index(summary.index.map("{:.4g}".format))],
        notes=(
            *(_in_a_line(change) for change in changes.round(9).to_dict("records")),
            *([] if len(changes) else [_NO_CHANGE]),
            f"lags differ between the two ways at {where or 'no level'}",
        ),
        data={
            "dwell_s": dwell_s,
            "hysteresis": changes.to_dict("records"),
            "bistable": result.bistable,
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


@in_shell(**_FOLDER, **_RANGES)
def map(
    controller: Walking,
    *,
    x: tuple[str, float, float] | None = None,
    y: tuple[str, float, float] | None = None,
    cells: tuple[int, int] = (60, 60),
    starts: int = 4,
    out: Path | str | None = None,
    duration_s: float | None = None,
    omega: float | None = None,
    sigma: float | None = None,
    seed: int = 0,
    terrain: Sequence[str] = (),
    delay_s: float | None = None,
    noise: float | None = None,
    tolerance: float = TOLERANCE,
    body: Body | Changes | None = None,
) -> Figure:
    """Map the gaits over two parameters; run it again on the same folder to continue.

    Parameters are omega, sigma, and numbers of the body. For a parameter with one value per leg,
    such as hips_x_m, the values of an axis are factors on all of them.

    Args:
        controller: body with several legs and its controller.
        x: columns: a parameter, its lowest and its highest value, such as com_x_m -0.3 0.3.
        y: rows: another parameter, its lowest and its highest value.
        cells: numbers of columns and rows.
        starts: number of releases per cell.
        out: folder for picture, table, document and finished cells; the same one again continues.
        duration_s: simulated time [s].
        omega: frequency ω [rad/s].
        sigma: gain σ of the vanilla feedback [rad/(s N)].
        seed: seed of the random phases at release.
        terrain: ground of a walking torso: flat, slope, steps, rough or FILE.py:OBJECT, followed by
            its parameters, such as rough rms_m=0.05.
        delay_s: delay of the senses of the legs [s].
        noise: noise of the senses of the legs, relative to their scales.
        tolerance: tolerance around the lags of a named gait [cycles].
        body: another body, or changes of the system's own.

    Raises:
        TegotaeError: for values that cannot be, before anything is computed.

    Example:
        >>> axes = {"x": ("inertia_ratio", 0.6, 1.6), "y": ("sigma", 1.0, 1.5)}
        >>> map("bar-light", **axes, cells=(2, 2), starts=2).table.gait.tolist()
        ['antiphase', 'in phase', 'antiphase', 'in phase']
    """
    options, controller = locals(), _walker(controller)
    from tegotae.figures.gaits.maps import map_figure

    ranges, folder = _default_ranges(controller), None if out is None else Path(out)
    across = _axis(x or ranges["x"], cells[0])
    along = _axis(y or ranges["y"], cells[1])
    study = _Study(controller, options, across, along)
    if folder is not None:
        require_free_for(folder, GAIT_MAP)
    result = map_gaits(study.legged, across, along, folder=folder, starts=starts, **study.releases)
    table: Any = result.cells
    counts = _counts(table["gait"])
    of_gaits = table.groupby("gait")
    cost = of_gaits["cost_of_transport"].agg(["min", "max"]).loc[counts.index]
    summary = pd.DataFrame(
        {
            "cells": counts,
            "share": (counts / len(table)).map("{:.3f}".format),
            "all starts agree": of_gaits["share"].agg(lambda x: f"{(x == 1.0).mean():.3f}"),
            "cost of transport": [
                UNDEFINED if math.isnan(low) else f"{low:.3g} … {high:.3g}"
                for low, high in cost.to_numpy()
            ],
        },
        index=counts.index.rename("gait of most starts"),
    )
    axes = {"x": across, "y": along}
    return study.figure(result, table, map_figure, views=[summary], data=axes)


@in_shell(**_FOLDER)
def front(
    controller: Walking,
    *,
    family: Sequence[str] = ("vanilla",),
    walkers: int = 8192,
    rounds: int = 8,
    varied: int = 1024,
    starts: int = 4,
    unseen: int = 32,
    out: Path | str | None = None,
    duration_s: float | None = None,
    omega: float | None = None,
    sigma: float | None = None,
    seed: int = 0,
    terrain: Sequence[str] = (),
    delay_s: float | None = None,
    noise: float | None = None,
    tolerance: float = TOLERANCE,
    body: Body | Changes | None = None,
) -> Figure:
    """Search for the least cost of transport at every speed, over frequency, gain, stride and lift.

    Run it again on the same folder to continue.

    Args:
        controller: body with several legs and its controller.
        family: controllers of the legs: vanilla, cosine, "vanilla ellipse", or a gait prescribed
            without feedback, such as "forced trot".
        walkers: number of random walkers at the start.
        rounds: number of rounds in which the cheapest walkers of every speed are varied.
        varied: number of variations per round.
        starts: number of releases per walker. All must stay up and settle.
        unseen: number of further releases, from other phases, to check the cheapest walkers.
        out: folder for picture, table, document and finished walkers; the same one again continues.
        duration_s: simulated time [s].
        omega: frequency ω [rad/s].
        sigma: gain σ of the vanilla feedback [rad/(s N)].
        seed: seed of the random phases at release.
        terrain: ground of a walking torso: flat, slope, steps, rough or FILE.py:OBJECT, followed by
            its parameters, such as rough rms_m=0.05.
        delay_s: delay of the senses of the legs [s].
        noise: noise of the senses of the legs, relative to their scales.
        tolerance: tolerance around the lags of a named gait [cycles].
        body: another body, or changes of the system's own.

    Raises:
        TegotaeError: for values that cannot be, before anything is computed.
    """
    study, folder = _Study(controller, locals()), None if out is None else Path(out)
    from tegotae.figures.gaits.maps import front_figure

    search = Search(
        coarse=walkers, rounds=rounds, varied=varied, starts=starts, unseen=unseen, seed=seed
    )
    families = [family_of(study.legged, name) for name in dict.fromkeys(family)]
    if folder is not None:
        require_free_for(folder, GAIT_FRONT)
    fronts = [search_front(study.legged, member, search, folder) for member in families]
    if not any(len(front) for front in fronts):
        raise TegotaeError(
            f"no walker of {study.controller.name} among {sum(search.sizes)} stays up at a steady "
            "speed from every release, so it has no front; try fewer starts, or more walkers in a "
            "folder of their own"
        )
    table = pd.concat(fronts, ignore_index=True)
    formats = {"speed": ".3f", "cost_of_transport": ".3f", "omega": ".2f", "gait": ""}
    summary = pd.DataFrame(
        {name: table[name].map(f"{{:{style}}}".format) for name, style in formats.items()}
    ).set_index(pd.Index(table["family"]))
    study.over = [OMEGA]
    return study.figure(table, table, front_figure, views=[summary], data={"search": search})


@in_shell(**_FOLDER, **_RANGES)
def stability(
    controller: Walking,
    *,
    over: tuple[str, float, float] | None = None,
    count: int = 14,
    gaits: Sequence[str] = (),
    kick: float = 0.005,
    pairs: int = 8,
    skip: int = 4,
    cycles: int = 8,
    duration_s: float | None = None,
    omega: float | None = None,
    sigma: float | None = None,
    seed: int = 0,
    terrain: Sequence[str] = (),
    delay_s: float | None = None,
    noise: float | None = None,
    tolerance: float = TOLERANCE,
    body: Body | Changes | None = None,
) -> Figure:
    """Measure how small deviations of the lags grow or decay, cycle by cycle, over a parameter.

    Args:
        controller: body with several legs and its controller.
        over: parameter (omega, sigma, or one of the body), its lowest and its highest value.
        count: number of values.
        gaits: names of gaits, such as trot; by default all for this number of legs.
        kick: size of the perturbation of the legs' phases, at half of the time [cycles].
        pairs: number of directions of the perturbation, each in both signs.
        skip: number of cycles after the perturbation that are left out.
        cycles: number of cycles fitted after these.
        duration_s: simulated time [s].
        omega: frequency ω [rad/s].
        sigma: gain σ of the vanilla feedback [rad/(s N)].
        seed: seed of the random phases at release.
        terrain: ground of a walking torso: flat, slope, steps, rough or FILE.py:OBJECT, followed by
            its parameters, such as rough rms_m=0.05.
        delay_s: delay of the senses of the legs [s].
        noise: noise of the senses of the legs, relative to their scales.
        tolerance: tolerance around the lags of a named gait [cycles].
        body: another body, or changes of the system's own.

    Raises:
        TegotaeError: for values that cannot be, before anything is computed.

    Example:
        >>> near = ("inertia_ratio", 0.98, 1.02)
        >>> stability("bar-light", over=near, count=2, gaits=("in phase",)).notes[0]
        'in phase gains its stability at inertia_ratio 1'
    """
    options, controller = locals(), _walker(controller)
    from tegotae.figures.gaits.maps import stability_figure

    axis = _axis(over or _default_ranges(controller)["over"], count)
    study = _Study(controller, options, axis)
    settings = {"kick": kick, "pairs": pairs, "skip": skip, "cycles": cycles, **study.releases}
    result = measured_stability(study.legged, axis, tuple(gaits) or None, **settings)
    frame: Any = result.frame
    rows = [
        UNDEFINED if math.isnan(a) else f"{a:.3f}, {b:.3f}"
        for a, b in zip(frame["largest"], frame["unexplained"], strict=True)
    ]
    summary = frame.assign(shown=rows).pivot(index=axis.name, columns="gait", values="shown")
    summary = summary[list(result.jacobians)].add_suffix(": largest, unexplained")
    crossings = [
        f"{gait} {'loses' if loses else 'gains'} its stability at {axis.name} {crossing:.3g}"
        for gait, crossing, loses in result.crossings.itertuples(index=False)
    ]
    ends = []
    for gait, rows_of_gait in frame[frame["refused"] == ""].groupby("gait", sort=False):
        values, stays = rows_of_gait[axis.name].to_numpy(), rows_of_gait["stays"].to_numpy()
        for i in np.flatnonzero(np.diff(stays.astype(int))):
            side = "below" if stays[i] else "above"
            between = f"{values[i]:.3g} … {values[i + 1]:.3g}"
            ends.append(f"{gait}, simulated to the end: stays {side} {between}")
    none = "no multiplier crosses one between neighbouring values"
    return study.figure(
        result,
        frame,
        stability_figure,
        views=[summary.set_index(summary.index.map("{:.4g}".format))],
        notes=(*crossings, *ends, *([] if crossings else [none])),
        data={
            "crossings": result.crossings.to_dict("records"),
            "jacobians": result.jacobians,
        },
    )


@in_shell(**_FOLDER)
def perturb(
    controller: Walking,
    *,
    lose: Sequence[str] = (),
    then: Sequence[str] = (),
    lasting_s: float | None = None,
    drop_m: float = 0.0,
    at_s: float | None = None,
    starts: int = 64,
    duration_s: float | None = None,
    omega: float | None = None,
    sigma: float | None = None,
    seed: int = 0,
    terrain: Sequence[str] = (),
    delay_s: float | None = None,
    noise: float | None = None,
    tolerance: float = TOLERANCE,
    body: Body | Changes | None = None,
) -> Figure:
    """Remove a leg, change the body or drop the ground, and count the releases that stay up.

    Args:
        controller: body with several legs and its controller.
        lose: names of legs that are lost, such as LH.
        then: parameters of the body that change at that time, such as mass_kg=1.3 com_x_m=0.1.
        lasting_s: duration of this change [s], such as for a push, push_y_n=0.3; by default
            permanent.
        drop_m: height by which the ground drops [m].
        at_s: time of the event [s]; by default half of the duration.
        starts: number of releases.
        duration_s: simulated time [s].
        omega: frequency ω [rad/s].
        sigma: gain σ of the vanilla feedback [rad/(s N)].
        seed: seed of the random phases at release.
        terrain: ground of a walking torso: flat, slope, steps, rough or FILE.py:OBJECT, followed by
            its parameters, such as rough rms_m=0.05.
        delay_s: delay of the senses of the legs [s].
        noise: noise of the senses of the legs, relative to their scales.
        tolerance: tolerance around the lags of a named gait [cycles].
        body: another body, or changes of the system's own.

    Raises:
        TegotaeError: for values that cannot be, before anything is computed.

    Example:
        >>> perturb("bar-light", drop_m=0.05, starts=4, duration_s=60.0).title
        'ground 0.05 lower at 30 s: 4 of 4 that stood stay up, 1.000 (0.510 … 1.000)'
    """
    study = _Study(controller, locals())
    from tegotae.figures.gaits.maps import lesion_figure

    legged = study.legged
    lesion = GaitLesion(
        at_s=0.5 * study.options.duration_s if at_s is None else at_s,
        lost=tuple(lose),
        fields=tuple(assignments("then", then).items()),
        drop_m=drop_m,
        lasts_s=math.inf if lasting_s is None else lasting_s,
    )
    result = aftermath(legged, lesion, starts=starts, **study.releases)
    frame: Any = result.frame
    share = result.share
    stood, stays = frame[frame["stood_before"]], frame[frame["stays_up"]]
    (length, time), margin = legged.units, result.margin_m
    notes = [f"the mass is {margin:.3f} {length} inside the feet that are left"]
    notes = [] if math.isnan(margin) else notes
    for leg in result.left:
        change = stays[f"lag_change_cycles_{legged.names[leg]}"].median()
        if leg != result.reference and not math.isnan(change):
            notes.append(f"lag of {legged.names[leg]} moves by {change:+.3f} cycles (median)")
    for quantity, values in (
        ("falls after", stood["after_fall_time_s"]),
        ("locks again after", stays["after_lock_time_s"]),
    ):
        if values.count():
            notes.append(f"{quantity} {values.median():.3g} {time} (median of {values.count()})")
    pairs = _counts(stood["gait_before"] + " → " + stood["gait_after"])
    return study.figure(
        result,
        frame,
        lesion_figure,
        title=f"{result.lesion.label} at {result.lesion.at_s:g} {time}: {len(stays)} of "
        f"{len(stood)} that stood stay up, {share.mean:.3f} ({share.low:.3f} … {share.high:.3f})",
        views=[pairs.rename_axis("before → after").to_frame("starts")],
        notes=notes,
        data={
            "lesion": result.lesion,
            "reference": legged.names[result.reference],
            "margin_m": margin,
            "stays_up": {
                "share": share.mean,
                "low": share.low,
                "high": share.high,
                "of": len(stood),
            },
        },
    )
