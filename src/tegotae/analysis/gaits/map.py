"""Maps of gaits over parameters of system and body."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from tegotae._support.documents import Document
from tegotae._support.errors import TegotaeError, require_count, require_finite, require_known
from tegotae._support.limits import MOST_GAIN, MOST_POINTS, MOST_RAD_PER_S, MOST_SEEDS
from tegotae.analysis.gaits.releases import coordination_frame, gait_counts
from tegotae.analysis.maps import axis
from tegotae.measures.gaits.names import TOLERANCE
from tegotae.measures.gaits.summary import Coordination
from tegotae.measures.statistics import UNDEFINED
from tegotae.parts._shapes import LaneNumbers
from tegotae.parts.bodies import Body
from tegotae.parts.fields import FieldNumber, numbers_of, replace
from tegotae.simulation.world import Scenario, with_changes
from tegotae.study import Cell, CellResult, measured_in_turn
from tegotae.systems.descriptions import describe
from tegotae.systems.legged import Legged, lanes_of, random_phases

OMEGA, SIGMA = "omega", "sigma"
"""Axes of a map beside the fields of the body."""


@dataclass(frozen=True)
class Axis:
    """Values of one quantity, evenly spaced or not, rising.

    Args:
        name: "omega", "sigma", or a field of the body. Of a field that has a number a leg, such as
            `hips_x_m`, the values are factors on all of them: the spacing of the legs.
        values: two at least.

    Raises:
        TegotaeError: for fewer than two values, or values that do not rise.

    Example:
        >>> Axis("omega", (1.0, 2.0)).values
        (1.0, 2.0)
    """

    name: str
    values: tuple[float, ...]

    def __post_init__(self) -> None:
        for value in np.ravel(self.values):
            require_finite(f"a value of {self.name}", value)
        object.__setattr__(self, "values", tuple(float(x) for x in np.ravel(self.values)))
        require_count(f"points along {self.name}", len(self.values), least=2, most=MOST_POINTS)
        if not (np.diff(self.values) > 0.0).all():
            raise TegotaeError(f"the values of {self.name} do not rise: {self.values}")

    @classmethod
    def between(cls, name: str, low: float, high: float, count: int) -> Axis:
        """Return an axis of evenly spaced values.

        Raises:
            TegotaeError: for fewer than two, or ends that are not in order.
        """
        return cls(name, tuple(axis(name, low, high, count, upper=math.inf).tolist()))


def check_axis(legged: Legged, axis: Axis) -> None:
    """Raise `TegotaeError` if a system has no parameter of this name, or refuses these values."""
    if axis.name == OMEGA:
        if legged.omega is None:
            raise TegotaeError("the controller has no oscillator, and so no omega")
        for value in axis.values:
            require_finite("a value of omega", value, above=0.0, most=MOST_RAD_PER_S)
    elif axis.name == SIGMA:
        legged.with_numbers(sigma=axis.values[0])
        require_finite("a value of sigma", axis.values[-1], most=MOST_GAIN)
    else:
        names = [OMEGA, SIGMA, *numbers_of(legged.body)]
        require_known("parameter of this system", axis.name, names)


def fields_at(body: Body, values: Mapping[str, float]) -> dict[str, FieldNumber]:
    """Return the changed fields of a body at a place on some axes; those of the legs are
    multiplied.

    Example:
        >>> from tegotae.parts.bodies import Bar
        >>> fields_at(Bar(), {"hips_m": 2.0, "inertia_ratio": 0.5, "omega": 8.0})
        {'hips_m': (-1.0, 1.0), 'inertia_ratio': 0.5}
    """
    nominal = numbers_of(body)
    return {
        name: tuple(value * x for x in entries)
        if isinstance(entries := nominal[name], tuple)
        else value
        for name, value in values.items()
        if name not in (OMEGA, SIGMA)
    }


@dataclass(frozen=True)
class Setting:
    """One place on the axes: the body there, or the reason why there is none."""

    at: Mapping[str, float]
    body: Any
    """A `Body`; None if there is none."""
    refused: str
    """Reason why a body is impossible; empty if it is possible."""


def settings(legged: Legged, places: Sequence[Mapping[str, float]]) -> list[Setting]:
    """Return the body at every place, or None where the body refuses its values.

    Args:
        legged: the system.
        places: values by the names of axes.
    """
    cells: list[Setting] = []
    for place in places:
        try:
            body = replace(legged.body, fields_at(legged.body, place))
            body.check_tick(legged.timing.tick_s)
        except TegotaeError as error:
            cells.append(Setting(place, None, str(error)))
        else:
            cells.append(Setting(place, body, ""))
    return cells


def lanes_at(
    legged: Legged,
    where: Sequence[Setting],
    phase_rad: LaneNumbers,
    changes: Mapping[str, LaneNumbers] | None = None,
) -> tuple[np.ndarray, Scenario]:
    """Return weights and scenario of lanes at possible settings, one setting per lane.

    Each body is released as high over where its legs touch the ground as the system's own.

    Args:
        legged: the system.
        where: of every lane, [lanes].
        phase_rad: at release [rad], [limbs, lanes].
        changes: further ones, by name (`with_changes`).

    Returns:
        Weights, [lanes, n_weights], and the scenario.
    """
    weights = np.tile(legged.weights, (len(where), 1))
    if SIGMA in where[0].at:
        weights = np.array([[setting.at[SIGMA]] for setting in where])
    fields = [fields_at(legged.body, setting.at) for setting in where]
    varied = {name: np.array([setting[name] for setting in fields]).T for name in fields[0]}
    if OMEGA in where[0].at:
        varied[OMEGA] = np.array([setting.at[OMEGA] for setting in where])
    scenario = legged.scenario(
        phase_rad, height_m=np.array([legged.system.height_on(setting.body) for setting in where])
    )
    nominal = with_changes(scenario, legged.body, varied)
    return weights, with_changes(nominal, legged.body, changes or {})


NO_BODY = "no such body"
"""A cell whose body refuses to be: an inertia that no body has, a leg too soft to stand on."""
LANES = 1024
"""Approximate number of lanes advanced at once; progress is reported, and saved, in such parts."""


@dataclass(frozen=True)
class GaitMap:
    """The gaits of every cell, from the same random releases."""

    legged: Legged
    """The released system."""
    x: Axis
    """The columns."""
    y: Axis
    """The rows."""
    frame: pd.DataFrame
    """A row a cell and start, row by row of the map: why there is no such body (`refused`), the
    gait and the coordination (`coordination_frame`)."""

    def grid(self, column: str) -> np.ndarray:
        """Return a column of the frame, [rows, columns, starts]."""
        return self.frame[column].to_numpy().reshape(len(self.y.values), len(self.x.values), -1)

    @property
    def cells(self) -> pd.DataFrame:
        """Return the most frequent gait of every cell, one row per cell.

        `gait` is the most common name, of several the first by letters; `share` of the starts have
        it, and `fallen_share` of all starts fell. Over those that have it, lags are circular means,
        and other numbers medians.
        """
        frame: Any = self.frame
        lags = [f"lag_cycles_{leg}" for leg in self.legged.names]
        cell = np.arange(len(frame)) // self.grid("gait").shape[-1]
        modes = frame.groupby(cell)["gait"].agg(lambda names: names.mode()[0])
        has = frame["gait"] == modes.loc[cell].to_numpy()
        common: Any = frame[has].groupby(cell[has])
        turned = np.exp(2j * np.pi * frame.loc[has, lags].astype(float)).groupby(cell[has]).mean()
        lag = np.angle(turned) / (2.0 * np.pi) % 1.0
        known = common[lags].count() == common[lags].size().to_numpy()[:, None]
        return pd.concat(
            [
                frame[[self.x.name, self.y.name, "refused"]].groupby(cell).first(),
                modes,
                has.groupby(cell).mean().rename("share"),
                frame["fall_time_s"].notna().groupby(cell).mean().rename("fallen_share"),
                pd.DataFrame(lag, columns=lags).where(known),
                common[list(_MEDIANS)].median(),
            ],
            axis=1,
        )

    @property
    def summary(self) -> pd.DataFrame:
        """Numbers of cells and costs as texts, one row per gait, the most frequent first."""
        cells: Any = self.cells
        number, of_gaits = gait_counts(cells["gait"]), cells.groupby("gait")
        cost = of_gaits["cost_of_transport"].agg(["min", "max"]).loc[number.index]
        return pd.DataFrame(
            {
                "cells": number,
                "share": (number / len(cells)).map("{:.3f}".format),
                "all starts agree": of_gaits["share"].agg(lambda x: f"{(x == 1.0).mean():.3f}"),
                "cost of transport": [
                    UNDEFINED if math.isnan(low) else f"{low:.3g} … {high:.3g}"
                    for low, high in cost.to_numpy()
                ],
            },
            index=number.index.rename("gait of most starts"),
        )


_MEDIANS = ("lock_time_s", "speed_m_per_s", "cost_of_transport")


@dataclass(frozen=True)
class MapPart(Cell):
    """Some cells of a map, advanced together: the unit that a map keeps.

    Args:
        legged: the system.
        where: the body of each cell.
        phase_rad: at release [rad], [limbs, starts].
        at_once: how many cells are advanced. The last part is filled up, so that it needs no
            program of another size.
    """

    legged: Legged
    where: Sequence[Setting]
    phase_rad: np.ndarray
    at_once: int
    name = "map"  # type: ignore[assignment]

    @property
    def document(self) -> Document:
        """The system, the places of its cells, and the phases."""
        places = [dict(setting.at) for setting in self.where]
        return {**describe(self.legged), "at": places, "phase_rad": self.phase_rad.tolist()}

    def measure(self) -> CellResult:
        """Measure the coordination of all lanes; the starts of a cell are adjacent."""
        starts = self.phase_rad.shape[1]
        cells = [*self.where, *[self.where[-1]] * (self.at_once - len(self.where))]
        lanes = [setting for setting in cells for _ in range(starts)]
        phase = np.tile(self.phase_rad, self.at_once)
        weights, scenario = lanes_at(self.legged, lanes, phase)
        rollout = self.legged.rollout(self.legged.summary())
        coordination = lanes_of(rollout.run(weights, scenario, self.legged.body))
        arrays = {
            name: x[..., : len(self.where) * starts] for name, x in coordination._asdict().items()
        }
        return CellResult(self.document, {}, arrays)


def map_gaits(
    legged: Legged,
    x: Axis,
    y: Axis,
    *,
    starts: int = 4,
    seed: int = 0,
    tolerance: float = TOLERANCE,
    folder: Path | None = None,
) -> GaitMap:
    """Release a body at random phases at every cell of two parameters.

    All cells are lanes of one compiled program, each with the fields of its own body.

    Args:
        legged: the body and what drives it.
        x: the parameter of the columns.
        y: that of the rows, another one.
        starts: how many releases a cell; all cells have the same phases.
        seed: of the phases.
        tolerance: how far lags may be from a named pattern's [cycles].
        folder: keeps what is done, so that interrupted work continues from there.

    Raises:
        TegotaeError: for parameters that the system does not have, the same one twice, or if the
            body refuses all cells.

    Example:
        >>> from tegotae.systems.resolve import legged_system as system
        >>> axes = Axis("inertia_ratio", (0.6, 1.6)), Axis("sigma", (1.0, 1.5))
        >>> map_gaits(system("bar-light"), *axes, starts=2).cells.gait.tolist()
        ['antiphase', 'in phase', 'antiphase', 'in phase']
    """
    if x.name == y.name:
        raise TegotaeError(f"both parameters are {x.name}; a map is over two different ones")
    for varied in (x, y):
        check_axis(legged, varied)
    require_count("starts", starts, most=MOST_SEEDS)
    all_settings = settings(legged, [{x.name: a, y.name: b} for b in y.values for a in x.values])
    able = [setting for setting in all_settings if setting.body is not None]
    if not able:
        raise TegotaeError(f"no cell of this map has a body: {all_settings[0].refused}")
    phase = random_phases(legged.body.limbs, starts, seed)
    at_once = min(len(able), max(1, LANES // starts))
    parts = [
        MapPart(legged, able[i : i + at_once], phase, at_once) for i in range(0, len(able), at_once)
    ]
    results = measured_in_turn(parts, folder, "gait map", ".map.npz")
    coordination = Coordination(
        *(np.concatenate([setting.arrays[n] for setting in results], axis=-1) for n in _CHANNELS)
    )
    labels = pd.DataFrame([{**setting.at, "refused": setting.refused} for setting in all_settings])
    possible = np.repeat([setting.body is not None for setting in all_settings], starts)
    lanes = coordination_frame(coordination, legged.names, tolerance).set_index(
        np.flatnonzero(possible)
    )
    every = labels.loc[labels.index.repeat(starts)].reset_index(drop=True).join(lanes)
    return GaitMap(legged, x, y, every.fillna({"gait": NO_BODY}))


_CHANNELS = Coordination._fields
