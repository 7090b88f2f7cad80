"""Coordination of the legs of a body: gaits and their basins, maps, costs, stability, lesions."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, Unpack

import pandas as pd

from tegotae._support.errors import TegotaeError
from tegotae._support.workplace import GAIT_FRONT, GAIT_MAP, require_free_for
from tegotae.analysis.gaits.front import Search, search_front
from tegotae.analysis.gaits.lesion import GaitLesion, aftermath
from tegotae.analysis.gaits.map import OMEGA, SIGMA, Axis, map_gaits
from tegotae.analysis.gaits.releases import release_all, system_document
from tegotae.analysis.gaits.stability import stability as measured_stability
from tegotae.analysis.gaits.sweep import sweep as swept
from tegotae.api.controller import Subject
from tegotae.api.controllers import load
from tegotae.api.parameters import check_types, filled, with_own_values
from tegotae.api.results import Figure, MatplotlibFigure, short
from tegotae.api.walking import WalkerController, WalkerOptions
from tegotae.parts.fields import numbers_of
from tegotae.systems.legged import Legged
from tegotae.systems.parts_by_name import assignments
from tegotae.systems.tuned import front_family

__all__ = ["basin", "front", "map", "perturb", "stability", "sweep"]
Walking = Subject | WalkerController
"""Controller of a body with several legs, by name or loaded."""


def __dir__() -> list[str]:
    return __all__


class _Study:
    """System with several legs under study.

    Args:
        arguments: arguments of the study's function, the shared ones in `options`.
    """

    def __init__(self, arguments: Mapping[str, Any]) -> None:
        self.controller = _walker(arguments["controller"])
        self.defaults = {**self.controller.defaults(), **_ranges(self.controller)}
        self.values = filled(arguments, self.defaults)
        self.releases = {"seed": self.values.seed, "tolerance": self.values.tolerance}
        self.legged: Legged = self.controller.driven(self.values)
        self.varied: list[str] = []

    def axis(self, limits: tuple[str, float, float], count: int) -> Axis:
        """Return evenly spaced values of a parameter that is varied.

        Args:
            limits: the parameter, its lowest and its highest value.
            count: number of values.

        Raises:
            TegotaeError: for a parameter that an option sets to one value.
        """
        name, low, high = limits
        if name in (OMEGA, SIGMA) and getattr(self.values, name) != self.defaults[name]:
            raise TegotaeError(f"{name} is one value, and it is varied")
        self.varied.append(name)
        return Axis.between(name, low, high, count)

    def figure(
        self,
        raw: Any,
        frame: pd.DataFrame,
        draw: Callable[[Any, str], MatplotlibFigure],
        **fields: Any,
    ) -> Figure:
        """Return the result.

        Args:
            raw: result of the computation.
            frame: its table.
            draw: function of it and of a title that draws the figure.
            fields: fields of the result; `data` stands in the document before the rows.
        """
        numbers = {"system": system_document(self.legged), **fields.pop("data", {})}
        settings, hidden = vars(self.values), ("controller", "out")
        return Figure(
            raw=raw,
            draw=lambda: {"figure": draw(raw, self._title())},
            figure_tables={"": frame},
            settings={name: x for name, x in settings.items() if name not in hidden},
            data={**numbers, "rows": frame.to_dict("records")},
            **fields,
        )

    def _title(self) -> str:
        """Return the system and its changes in a few words."""
        from tegotae.figures.gaits.style import in_words
        from tegotae.figures.style import literal_text

        values, omega = self.values, self.legged.omega
        numbers = numbers_of(self.controller.legged.body)
        changed = {name: x for name, x in numbers_of(values.body).items() if x != numbers[name]}
        words = [self.controller.name, *(f"{in_words(n)} {short(x)}" for n, x in changed.items())]
        words += [" ".join(values.terrain)]
        words += [
            f"{name} {x:g}" for name, x in (("delay", values.delay_s), ("noise", values.noise)) if x
        ]
        suffix = "" if omega is None or OMEGA in self.varied else f", ω = {omega:g}"
        return literal_text(", ".join(filter(None, words))) + suffix


def _ranges(controller: Walking, **_: Any) -> dict[str, Any]:
    """Return the default ranges of the axes of a study."""
    walker = _walker(controller)
    omega = (OMEGA, *_range_around(walker.legged.omega))
    return {
        "levels": omega[1:],
        "x": omega,
        "y": (SIGMA, *_range_around(walker.sigma)),
        "over": omega,
    }


def _walker(controller: Walking) -> WalkerController:
    """Return the controller, which must be one of a body with several legs."""
    return load(controller).require(WalkerController, "a gait is how several legs go together")


@check_types
def basin(
    controller: Walking,
    *,
    starts: int = 256,
    **options: Unpack[WalkerOptions],
) -> Figure:
    """Draw the gaits of several legs that emerge from random phases, how often, and how soon.

    Args:
        controller: body with several legs and its controller.
        starts: number of releases.

    Raises:
        TegotaeError: for values that cannot be, before anything is computed.

    Example:
        >>> len(basin("bar-light", starts=8).table)
        8
    """
    study = _Study(locals())
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


def _range_around(value: float | None) -> tuple[float, float]:
    """Return half of a value, and one and a half of it."""
    value = value or 1.0
    return 0.5 * value, 1.5 * value


@with_own_values(_ranges)
def sweep(
    controller: Walking,
    *,
    levels: tuple[float, float] | None = None,
    count: int = 16,
    dwell_s: float | None = None,
    starts: int = 16,
    **options: Unpack[WalkerOptions],
) -> Figure:
    """Raise the frequency step by step and lower it again, to find gait changes and hysteresis.

    Args:
        controller: body with several legs and its controller.
        levels: lowest and highest frequency ω [rad/s]; by default half and one and a half of the
            system's.
        count: number of levels.
        dwell_s: duration of each level [s]; by default half of the system's duration.
        starts: number of releases in each direction.

    Raises:
        TegotaeError: for values that cannot be, before anything is computed.

    Example:
        >>> sweep("bar-light", levels=(7.5, 8.0), count=2, dwell_s=40.0, starts=2).notes[0]
        'no named gait changes on the way up and returns on the way down'
    """
    study = _Study(locals())
    from tegotae.figures.gaits.lags import sweep_figure

    axis, duration_s = study.axis((OMEGA, *study.values.levels), count), study.values.duration_s
    if dwell_s is not None and duration_s != study.defaults["duration_s"]:
        raise TegotaeError("duration_s does nothing beside dwell_s; leave one of them out")
    dwell_s = float(0.5 * duration_s if dwell_s is None else dwell_s)
    result = swept(study.legged, axis.values, dwell_s=dwell_s, starts=starts, **study.releases)
    return study.figure(
        result,
        result.frame,
        sweep_figure,
        views=[result.summary],
        notes=result.notes,
        data={
            "dwell_s": dwell_s,
            "hysteresis": result.hysteresis.to_dict("records"),
            "bistable": result.bistable,
        },
    )


@with_own_values(_ranges)
def map(
    controller: Walking,
    *,
    x: tuple[str, float, float] | None = None,
    y: tuple[str, float, float] | None = None,
    cells: tuple[int, int] = (60, 60),
    starts: int = 4,
    out: Path | str | None = None,
    **options: Unpack[WalkerOptions],
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

    Raises:
        TegotaeError: for values that cannot be, before anything is computed.

    Example:
        >>> axes = {"x": ("inertia_ratio", 0.6, 1.6), "y": ("sigma", 1.0, 1.5)}
        >>> map("bar-light", **axes, cells=(2, 2), starts=2).table.gait.tolist()
        ['antiphase', 'in phase', 'antiphase', 'in phase']
    """
    study, folder = _Study(locals()), None if out is None else Path(out)
    from tegotae.figures.gaits.maps import map_figure

    across, along = study.axis(study.values.x, cells[0]), study.axis(study.values.y, cells[1])
    if folder is not None:
        require_free_for(folder, GAIT_MAP)
    result = map_gaits(study.legged, across, along, folder=folder, starts=starts, **study.releases)
    axes = {"x": across, "y": along}
    return study.figure(result, result.cells, map_figure, views=[result.summary], data=axes)


@check_types
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
    **options: Unpack[WalkerOptions],
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

    Raises:
        TegotaeError: for values that cannot be, before anything is computed.
    """
    study, folder = _Study(locals()), None if out is None else Path(out)
    from tegotae.figures.gaits.maps import front_figure

    search = Search(
        coarse=walkers,
        rounds=rounds,
        varied=varied,
        starts=starts,
        unseen=unseen,
        seed=study.values.seed,
    )
    families = [front_family(study.legged, name) for name in dict.fromkeys(family)]
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
    study.varied = [OMEGA]
    return study.figure(table, table, front_figure, views=[summary], data={"search": search})


@with_own_values(_ranges)
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
    **options: Unpack[WalkerOptions],
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

    Raises:
        TegotaeError: for values that cannot be, before anything is computed.

    Example:
        >>> near = ("inertia_ratio", 0.98, 1.02)
        >>> stability("bar-light", over=near, count=2, gaits=("in phase",)).notes[0]
        'in phase gains its stability at inertia_ratio 1'
    """
    study = _Study(locals())
    from tegotae.figures.gaits.maps import stability_figure

    axis = study.axis(study.values.over, count)
    settings = {"kick": kick, "pairs": pairs, "skip": skip, "cycles": cycles, **study.releases}
    result = measured_stability(study.legged, axis, tuple(gaits) or None, **settings)
    return study.figure(
        result,
        result.frame,
        stability_figure,
        views=[result.summary],
        notes=result.notes,
        data={
            "crossings": result.crossings.to_dict("records"),
            "jacobians": result.jacobians,
        },
    )


@check_types
def perturb(
    controller: Walking,
    *,
    lose: Sequence[str] = (),
    then: Sequence[str] = (),
    lasting_s: float | None = None,
    drop_m: float = 0.0,
    at_s: float | None = None,
    starts: int = 64,
    **options: Unpack[WalkerOptions],
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

    Raises:
        TegotaeError: for values that cannot be, before anything is computed.

    Example:
        >>> perturb("bar-light", drop_m=0.05, starts=4, duration_s=60.0).title
        'ground 0.05 lower at 30 s: 4 of 4 that stood stay up, 1.000 (0.510 … 1.000)'
    """
    study = _Study(locals())
    from tegotae.figures.gaits.lags import lesion_figure

    lesion = GaitLesion(
        at_s=0.5 * study.values.duration_s if at_s is None else at_s,
        lost=tuple(lose),
        fields=tuple(assignments("then", then).items()),
        drop_m=drop_m,
        lasts_s=math.inf if lasting_s is None else lasting_s,
    )
    result = aftermath(study.legged, lesion, starts=starts, **study.releases)
    share = result.share
    return study.figure(
        result,
        result.frame,
        lesion_figure,
        title=result.title,
        views=[result.summary],
        notes=result.notes,
        data={
            "lesion": result.lesion,
            "reference": study.legged.names[result.reference],
            "margin_m": result.margin_m,
            "stays_up": {
                "share": share.mean,
                "low": share.low,
                "high": share.high,
                "of": result.stood,
            },
        },
    )
