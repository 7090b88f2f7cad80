"""Parameters that vary from lane to lane: the frequency, the gain, or a number of the body."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from tegotae._support.errors import (
    TegotaeError,
    require_count,
    require_finite,
    unknown,
)
from tegotae._support.limits import MOST_GAIN, MOST_POINTS, MOST_RAD_PER_S
from tegotae.parts._shapes import LaneNumbers
from tegotae.parts.bodies import Body
from tegotae.parts.fields import FieldNumber, numbers_of, with_fields
from tegotae.simulation.world import Scenario, with_changes
from tegotae.systems.legged import Legged

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
