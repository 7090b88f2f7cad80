"""Maps of gaits over parameters of system and body."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tegotae._support.errors import (
    TegotaeError,
    require_count,
    require_finite,
    unknown,
)
from tegotae._support.limits import MOST_GAIN, MOST_POINTS, MOST_RAD_PER_S, MOST_SEEDS
from tegotae.analysis.gaits.checkpoint import Columns, in_parts
from tegotae.measures.gaits.names import TOLERANCE, gait_of
from tegotae.measures.gaits.summary import Coordination
from tegotae.parts._shapes import AnyArray, LaneNumbers
from tegotae.parts.bodies import Body
from tegotae.parts.fields import FieldNumber, numbers_of, with_fields
from tegotae.simulation.rollout import Timing
from tegotae.simulation.world import Scenario, with_changes
from tegotae.systems.descriptions import describe
from tegotae.systems.legged import Legged, lanes_of, random_phases

OMEGA, SIGMA = "omega", "sigma"
"""What can be varied beside the fields of the body."""


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
        require_count(f"the number of values of {self.name}", len(self.values), least=2)
        require_count(f"the number of values of {self.name}", len(self.values), most=MOST_POINTS)
        if not (np.diff(self.values) > 0.0).all():
            raise TegotaeError(f"the values of {self.name} do not rise: {self.values}")

    @classmethod
    def between(cls, name: str, low: float, high: float, count: int) -> Axis:
        """Evenly spaced values.

        Raises:
            TegotaeError: for fewer than two, or ends that are not in order.
        """
        require_finite(f"the first value of {name}", low)
        require_finite(f"the last value of {name}", high)
        require_count(f"the number of values of {name}", count, least=2, most=MOST_POINTS)
        if not low < high:
            raise TegotaeError(f"{name} goes from {low:g} to {high:g}; it must rise")
        return cls(name, tuple(np.linspace(low, high, count).tolist()))


def check_axis(legged: Legged, axis: Axis) -> None:
    """Raise `TegotaeError` if a system has nothing of this name to vary, or not such values."""
    if axis.name == OMEGA:
        if legged.omega is None:
            raise TegotaeError("the controller has no oscillator, and so no omega")
        for value in axis.values:
            require_finite("a value of omega", value, above=0.0, most=MOST_RAD_PER_S)
    elif axis.name == SIGMA:
        legged.with_numbers(sigma=axis.values[0])
        require_finite("a value of sigma", axis.values[-1], most=MOST_GAIN)
    else:
        known = [OMEGA, SIGMA, *numbers_of(legged.body)]
        if axis.name not in known:
            raise unknown("parameter of this system", axis.name, known)


def fields_at(body: Body, at: Mapping[str, float]) -> dict[str, FieldNumber]:
    """The fields of a body at a place on some axes; those of the legs multiplied.

    Example:
        >>> from tegotae.parts.bodies import Bar
        >>> fields_at(Bar(), {"hips_m": 2.0, "inertia_ratio": 0.5, "omega": 8.0})
        {'hips_m': (-1.0, 1.0), 'inertia_ratio': 0.5}
    """
    usual = numbers_of(body)
    return {
        name: tuple(value * x for x in own) if isinstance(own := usual[name], tuple) else value
        for name, value in at.items()
        if name not in (OMEGA, SIGMA)
    }


@dataclass(frozen=True)
class Setting:
    """One place on the axes: the body there, or why there is none."""

    at: Mapping[str, float]
    body: Body | None
    refused: str
    """Why a body cannot be like that; empty if it can."""


def settings(legged: Legged, places: Sequence[Mapping[str, float]]) -> list[Setting]:
    """The body at every place; one that it refuses itself has none.

    Args:
        legged: the system.
        places: values by the names of axes.
    """
    made: list[Setting] = []
    for at in places:
        try:
            body = with_fields(legged.body, fields_at(legged.body, at))
            body.check_tick(legged.timing.tick_s)
        except TegotaeError as error:
            made.append(Setting(at, None, str(error)))
        else:
            made.append(Setting(at, body, ""))
    return made


def lanes_at(
    legged: Legged,
    where: Sequence[Setting],
    phase_rad: LaneNumbers,
    changes: Mapping[str, LaneNumbers] | None = None,
) -> tuple[np.ndarray, Scenario]:
    """Weights and scenario of lanes at settings that can be: a setting a lane.

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
        weights = np.array([[each.at[SIGMA]] for each in where])
    fields = [fields_at(legged.body, each.at) for each in where]
    varied = {name: np.array([each[name] for each in fields]).T for name in fields[0]}
    if OMEGA in where[0].at:
        varied[OMEGA] = np.array([each.at[OMEGA] for each in where])
    scenario = legged.scenario(
        phase_rad, height_m=np.array([legged.system.height_on(_body(each)) for each in where])
    )
    usual = with_changes(scenario, legged.body, varied)
    return weights, with_changes(usual, legged.body, changes or {})


def _body(setting: Setting) -> Body:
    assert setting.body is not None
    return setting.body


NO_BODY = "no such body"
"""A cell whose body refuses to be: an inertia that no body has, a leg too soft to stand on."""
LANES = 1024
"""How many lanes are advanced at once, about; progress is reported, and kept, in such parts."""


@dataclass(frozen=True)
class GaitMap:
    """The gaits of every cell, from the same random releases."""

    legged: Legged
    """The released system."""
    x: Axis
    """The columns."""
    y: Axis
    """The rows."""
    phase_rad: np.ndarray
    """Phases at release [rad], [limbs, starts]."""
    found: Coordination
    """How the legs go together: [rows, columns, (limbs,) starts]; NaN without a body."""
    gait: np.ndarray
    """The gait's name, or why it has none, [rows, columns, starts]."""
    refused: np.ndarray
    """Why there is no such body, empty where there is one, [rows, columns]."""

    @property
    def cells(self) -> Cells:
        """What most starts of every cell do."""
        return majority(self.found, self.gait)


@dataclass(frozen=True)
class Cells:
    """What most starts of every cell do: arrays [rows, columns]."""

    gait: np.ndarray
    """The most common name; of several, the first by letters."""
    share: np.ndarray
    """The share of starts that have it."""
    lag: np.ndarray
    """The circular mean of their lags [cycles], [rows, columns, limbs]."""
    cost_of_transport: np.ndarray
    """The median of theirs."""
    speed_m_per_s: np.ndarray
    """The median of theirs [m/s]."""
    lock_time_s: np.ndarray
    """The median of theirs [s]."""
    fallen: np.ndarray
    """The share of all starts that fell."""


def gait_map(
    legged: Legged,
    x: Axis,
    y: Axis,
    *,
    starts: int = 4,
    seed: int = 0,
    tolerance: float = TOLERANCE,
    timing: Timing | None = None,
    window_s: float | None = None,
    kept: Path | None = None,
    progress: Callable[[int, int], None] = lambda done, of: None,
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
        timing: of each rollout; that of the system by default.
        window_s: length of its end that is measured [s]; its last quarter by default.
        kept: a file that keeps what is done, so that interrupted work continues from there.
        progress: is called with how many cells are done, and of how many.

    Raises:
        TegotaeError: for parameters that the system does not have, the same one twice, or if the
            body refuses all cells.

    Example:
        >>> from tegotae.analysis.gaits import system
        >>> axes = Axis("inertia_ratio", (0.6, 1.6)), Axis("sigma", (1.0, 1.5))
        >>> gait_map(system("bar-light"), *axes, starts=2).cells.gait.tolist()
        [['antiphase', 'in phase'], ['antiphase', 'in phase']]
    """
    if x.name == y.name:
        raise TegotaeError(f"both parameters are {x.name}; a map is over two different ones")
    for axis in (x, y):
        check_axis(legged, axis)
    require_count("starts", starts, most=MOST_SEEDS)
    timing = timing or legged.timing
    places = [{x.name: a, y.name: b} for b in y.values for a in x.values]
    made = settings(legged, places)
    able = [each for each in made if each.body is not None]
    if not able:
        raise TegotaeError(f"no cell of this map has a body: {made[0].refused}")
    phase = random_phases(legged.body.limbs, starts, seed)
    summary = legged.summary(window_s=window_s)
    engine = legged.engine(summary, timing)
    at_once = min(len(able), max(1, LANES // starts))
    count = -(-len(able) // at_once)

    def part(number: int) -> Columns:
        own = able[number * at_once : (number + 1) * at_once]
        # The last part is filled up, so that it needs no program of another size.
        own = own + own[-1:] * (at_once - len(own))
        where = [setting for setting in own for _ in range(starts)]
        weights, scenario = lanes_at(legged, where, np.tile(phase, at_once))
        return lanes_of(engine.run(weights, scenario, legged.body))._asdict()

    parts = in_parts(
        count,
        part,
        kept=kept,
        settings={
            "system": describe(legged), "x": x, "y": y, "phase_rad": phase.tolist(),
            "timing": timing, "summary": summary,
        },
        progress=lambda done: progress(min(done * at_once, len(able)), len(able)),
    )  # fmt: skip
    found = _on_cells(parts, made, (len(y.values), len(x.values), starts))
    gait = _names(found, legged, tolerance, made)
    refused = np.array([each.refused for each in made]).reshape(gait.shape[:2])
    return GaitMap(legged, x, y, phase, found, gait, refused)


def majority(found: Coordination, gait: np.ndarray) -> Cells:
    """What most starts of every cell do.

    Args:
        found: the coordination, [rows, columns, (limbs,) starts].
        gait: names, [rows, columns, starts].

    Example:
        >>> nothing = Coordination(*(np.zeros((1, 1, 3)) for _ in Coordination._fields))
        >>> nothing = nothing._replace(lag=np.zeros((1, 1, 2, 3)))
        >>> cells = majority(nothing, np.array([[["trot", "pace", "trot"]]]))
        >>> cells.gait.item(), round(cells.share.item(), 3)
        ('trot', 0.667)
    """
    shape = gait.shape[:2]
    names = np.empty(shape, object)
    share, fallen = np.zeros(shape), np.zeros(shape)
    lag = np.full((*shape, found.lag.shape[2]), np.nan)
    medians = {
        name: np.full(shape, np.nan)
        for name in ("cost_of_transport", "speed_m_per_s", "lock_time_s")
    }
    for cell in np.ndindex(*shape):
        found_names, counts = np.unique(gait[cell], return_counts=True)
        names[cell] = found_names[counts.argmax()]
        own = gait[cell] == names[cell]
        share[cell] = own.mean()
        fallen[cell] = np.isfinite(found.fall_time_s[cell]).mean()
        of_cell = found.lag[cell][:, own]
        if np.isfinite(of_cell).all():
            lag[cell] = _mean_lag(of_cell)
        for name, median in medians.items():
            values = getattr(found, name)[cell][own]
            if np.isfinite(values).any():
                median[cell] = np.nanmedian(values)
    return Cells(gait=names.astype(str), share=share, lag=lag, fallen=fallen, **medians)


def _mean_lag(lag: AnyArray) -> np.ndarray:
    turned = np.exp(2j * np.pi * lag).mean(axis=1)
    return (np.angle(turned) / (2.0 * np.pi)) % 1.0


def _on_cells(parts: list[Columns], made: list[Setting], shape: tuple[int, ...]) -> Coordination:
    """The parts together on the grid, NaN where there is no body."""
    rows, columns, starts = shape
    able = np.array([each.body is not None for each in made])

    def on_grid(name: str) -> np.ndarray:
        whole = np.concatenate([part[name] for part in parts], axis=-1)[..., : able.sum() * starts]
        of_cells = np.moveaxis(whole.reshape(*whole.shape[:-1], -1, starts), -2, 0)
        grid = np.full((len(made), *of_cells.shape[1:]), np.nan)
        grid[able] = of_cells
        return grid.reshape(rows, columns, *of_cells.shape[1:])

    return Coordination(**{name: on_grid(name) for name in Coordination._fields})


def _names(
    found: Coordination, legged: Legged, tolerance: float, made: list[Setting]
) -> np.ndarray:
    rows, columns, _, starts = found.lag.shape
    together = (np.moveaxis(np.asarray(x), -1, 2) for x in found)
    flat = Coordination(*(x.reshape(-1, *x.shape[3:]).T for x in together))
    names = gait_of(flat, legged.names, tolerance).reshape(rows, columns, starts)
    able = np.array([each.body is not None for each in made]).reshape(rows, columns)
    return np.where(able[..., None], names, NO_BODY)
