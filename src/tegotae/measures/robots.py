"""Metrics of a robot's episode in another simulator: what they are computed from, their kind, and
the package's own.

The package's own stand at the end of the file, in the order in which tables show them.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import ClassVar

import numpy as np

from tegotae._support.errors import TegotaeError, require_known
from tegotae.measures.hopping.gait import Measured, measure
from tegotae.measures.hopping.metrics import HOPPING
from tegotae.measures.metric import Catalogue, Metric
from tegotae.measures.statistics import POSITIVE, SHARE
from tegotae.parts.channels import COMMANDED

ROBOTS = Catalogue("robots", "run", "omega", "start")
"""The metrics of robots."""
_LONGEST_STEP_S = 0.02
"""Between samples of a height whose hops can be measured."""
_AT_LIMIT = 1.0 - 1e-6
"""Share of an actuator's largest force from which on it is saturated."""


@dataclass(frozen=True)
class EnvEpisode:
    """One episode of one candidate, for a fitness of your own."""

    time_s: np.ndarray
    """Time at the end of each step [s], [steps]."""
    observation: np.ndarray
    """The observations at these times, [steps, entries]."""
    names: tuple[str, ...]
    """Names of its entries."""
    action: np.ndarray
    """The action of each step, [steps, entries]."""
    reward: np.ndarray
    """The environment's reward, [steps]."""
    phase_rad: np.ndarray
    """Phases at the end of each step [rad], [steps, limbs]."""
    lasted: float
    """Share of the longest episode that it lasted, 0 ... 1; less than 1 if it ended early."""

    def __getitem__(self, name: str) -> np.ndarray:
        """Return the observation's entry of that name, [steps].

        Raises:
            TegotaeError: if nothing that is observed has this name.
        """
        require_known("entry of the observation", name, self.names)
        return self.observation[:, self.names.index(name)]


@dataclass(frozen=True, eq=False, kw_only=True)
class RobotEpisode(EnvEpisode):
    """An episode with the robot's data from its wiring; missing data are None or empty."""

    fitness: float
    """Fitness by the objective of the experiment."""
    step_s: float
    """Time of a step [s]."""
    loads: Mapping[str, np.ndarray] = field(default_factory=dict[str, np.ndarray])
    """Loads of the limbs by the observation's entry, [steps] each, never negative."""
    force_limits: Mapping[str, tuple[float, float]] = field(
        default_factory=dict[str, tuple[float, float]]
    )
    """Least and largest force of actuators by the observation's entry [N or N m]."""
    work_j: np.ndarray | None = None
    """Absolute work of the actuators since the start [J], [steps]."""
    weight_n: float | None = None
    """Weight of a robot on legs [N]."""
    height_m: np.ndarray | None = None
    """Height of a body that hops [m], [steps]; None of a robot on legs, which walks."""
    rest_length_m: float | None = None
    """Height at which its foot leaves the ground [m]."""
    omega: float | None = None
    """Prescribed frequency ω [rad/s]."""

    @property
    def late(self) -> slice:
        """The steps of the second half."""
        return slice(len(self.time_s) // 2, None)

    @property
    def distance_m(self) -> float | None:
        """Distance [m], along the heading where that is observed."""
        if "root_speed" in self.names:
            return float(np.trapezoid(self["root_speed"], self.time_s))
        if "root_forward" in self.names:
            went = self["root_forward"]
            return float(went[-1] - went[0])
        return None

    @cached_property
    def hopping(self) -> Measured | None:
        """The gait as that of a recording; None where height, rest length or hops are not known."""
        if self.height_m is None or self.rest_length_m is None or self.step_s > _LONGEST_STEP_S:
            return None
        try:
            return measure(
                self.time_s - self.time_s[0],
                self.height_m.astype(float),
                rest_length_m=self.rest_length_m,
                phase_rad=self.phase_rad[:, 0].astype(float),
                omega=self.omega,
                work_j=None if self.work_j is None else self.work_j.astype(float),
            )
        except TegotaeError:  # an episode that ended at once is no recording
            return None


@dataclass(frozen=True, kw_only=True)
class RobotMetric(Metric):
    """A metric of a robot's episode.

    Args:
        compute: function of a `RobotEpisode` to a number, NaN where undefined; None where the
            simulator does not show what it takes.

    Example:
        >>> @RobotMetric.described(label="largest action", more_is_better=False)
        ... def largest_action(episode):
        ...     '''largest magnitude of an action'''
        ...     return abs(episode.action).max()
        >>> largest_action.heading
        'largest action'
    """

    compute: Callable[[RobotEpisode], float | None]

    CATALOGUE: ClassVar[Catalogue] = ROBOTS


def episode_numbers(
    episode: RobotEpisode, metrics: tuple[Metric, ...] | None = None
) -> dict[str, float]:
    """Return metrics of an episode by name, without those that the simulator does not show.

    Args:
        episode: the episode.
        metrics: metrics of robots; all by default.
    """
    selected = ROBOTS.metrics() if metrics is None else metrics
    values = {m.name: m.compute(episode) for m in selected if isinstance(m, RobotMetric)}
    return {name: float(value) for name, value in values.items() if value is not None}


# Source: of this library.
@RobotMetric.described(label="fitness", more_is_better=True)
def fitness(episode: RobotEpisode) -> float:
    """fitness by the objective of the experiment"""
    return episode.fitness


# Source: Gymnasium.
@RobotMetric.described(name="return", label="return, sum of the rewards", more_is_better=True)
def episode_return(episode: RobotEpisode) -> float:
    """sum of the environment's rewards"""
    return float(episode.reward.sum())


# Source: of this library.
@RobotMetric.described(
    label="share of the episode that it lasted", more_is_better=True, range=SHARE
)
def lasted(episode: RobotEpisode) -> float:
    """share of the longest episode that this one lasted"""
    return episode.lasted


# Source: of this library.
@RobotMetric.described(label="distance", unit="m", more_is_better=None)
def distance_m(episode: RobotEpisode) -> float | None:
    """distance, along the heading where that is observed"""
    return episode.distance_m


# Source: of this library.
@RobotMetric.described(label="speed", unit="m/s", more_is_better=None)
def speed_m_per_s(episode: RobotEpisode) -> float | None:
    """distance over the time of the episode"""
    distance = episode.distance_m
    return None if distance is None else distance / float(episode.time_s[-1])


# Source: of this library.
@RobotMetric.described(label="work of the actuators", unit="J", more_is_better=None, range=POSITIVE)
def work_j(episode: RobotEpisode) -> float | None:
    """absolute work of the actuators"""
    return None if episode.work_j is None else float(episode.work_j[-1])


# Source: of this library.
@RobotMetric.described(label="cost of transport", more_is_better=False, range=POSITIVE)
def cost_of_transport(episode: RobotEpisode) -> float | None:
    """work over weight and distance"""
    distance, work = episode.distance_m, episode.work_j
    if work is None or not episode.weight_n or distance is None or distance <= 0.0:
        return None
    return float(work[-1]) / (episode.weight_n * distance)


# Source: of this library.
@RobotMetric.described(label="rate of the first oscillator", unit="Hz", more_is_better=None)
def stride_hz(episode: RobotEpisode) -> float:
    """turns of the first limb's oscillator per second, in the second half"""
    turned = np.unwrap(episode.phase_rad[episode.late, 0].astype(float))
    span = episode.step_s * max(1, len(turned) - 1)
    return float(turned[-1] - turned[0]) / (2.0 * math.pi * span)


# Source: of this library.
@RobotMetric.described(label="share of time on the ground", more_is_better=None, range=SHARE)
def duty(episode: RobotEpisode) -> float | None:
    """share of the second half in which a foot bears load, mean of the feet"""
    if not episode.loads:
        return None
    return float(np.mean([(load[episode.late] > 0.0).mean() for load in episode.loads.values()]))


# Source: of this library.
@RobotMetric.described(label="servos at their limit", more_is_better=False, range=SHARE)
def saturated_share(episode: RobotEpisode) -> float | None:
    """share of the time at the limit of force, mean of the actuators that have one"""
    shares = [
        np.mean(
            ((low < 0.0) & (episode[name] <= _AT_LIMIT * low))
            | ((high > 0.0) & (episode[name] >= _AT_LIMIT * high))
        )
        for name, (low, high) in episode.force_limits.items()
    ]
    return float(np.mean(shares)) if shares else None


# Source: of this library.
@RobotMetric.described(label="displacement over command", more_is_better=None)
def followed(episode: RobotEpisode) -> float | None:
    """displacement along the commanded path over what was commanded"""
    asked = _commanded(episode)
    if asked is None:
        return None
    forward, left, _, heading = asked
    direction = np.exp(1j * heading) * (forward + 1j * left)
    distance = float(np.abs(direction).sum()) * episode.step_s
    place = episode["root_forward"] + 1j * episode["root_left"]
    unit = direction[1:] / np.maximum(np.abs(direction[1:]), 1e-9)
    along = float((np.diff(place) * np.conj(unit)).real.sum())
    return along / distance if distance > 0.0 else math.nan


# Source: of this library.
@RobotMetric.described(label="heading error at the end", unit="rad", more_is_better=None)
def heading_error_rad(episode: RobotEpisode) -> float | None:
    """heading less the commanded one at the end, as the gyroscope counts it"""
    asked = _commanded(episode)
    if asked is None:
        return None
    return float(episode["root_heading"][-1] - asked[3, -1])


def _commanded(episode: RobotEpisode) -> np.ndarray | None:
    """Return forward, left [m/s], yaw rate [rad/s] and heading [rad], [4, steps]; None without
    commands.
    """
    if not {*COMMANDED} <= {*episode.names}:
        return None
    return np.array([episode[name] for name in COMMANDED])


# Source: of this library.
@RobotMetric.described(label="hops", more_is_better=None, range=POSITIVE)
def hops(episode: RobotEpisode) -> float | None:
    """number of hops of a body whose height is observed"""
    return None if episode.hopping is None else float(len(episode.hopping.hops.height_m))


# Source: of this library.
@RobotMetric.described(
    label="height of the late apexes", unit="m", more_is_better=None, range=POSITIVE
)
def apex_m(episode: RobotEpisode) -> float | None:
    """mean height of the apexes of the later half of the hops"""
    if episode.hopping is None:
        return None
    heights = np.asarray(episode.hopping.hops.height_m)
    return float(heights[len(heights) // 2 :].mean()) if len(heights) else math.nan


def _hopping_metric(name: str) -> RobotMetric:
    """Return a metric of hopping as one of a robot's recorded height."""
    metric = HOPPING.find(name)

    def compute(episode: RobotEpisode) -> float | None:
        return None if episode.hopping is None else float(getattr(episode.hopping, name))

    fields = ("label", "about", "more_is_better", "unit", "range", "math", "shown")
    description = {field: getattr(metric, field) for field in fields}
    return RobotMetric(name=name, compute=compute, **description)


# Source: paper equation 12.
cot_inverse = _hopping_metric("cot_inverse")
# Source: of this library.
limit_cycle_period = _hopping_metric("limit_cycle_period")
# Source: paper equation 13.
w_peak = _hopping_metric("w_peak")
# Source: paper IV-A.
t0_s = _hopping_metric("t0_s")

ROBOTS.built_in = tuple(x for x in tuple(globals().values()) if isinstance(x, RobotMetric))
