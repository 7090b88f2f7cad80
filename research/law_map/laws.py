"""The laws of the map: how they are drawn, what their numbers mean, and what becomes of them."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from functools import cache
from typing import NamedTuple

import numpy as np
from scipy.stats import qmc

from research.reproduction.readings.named import reading_named
from tegotae.analysis.maps import OutcomeSummary
from tegotae.measures.hopping.metrics import FAILED, LIMIT_CYCLE
from tegotae.parts.controller import Controller, Tegotae
from tegotae.parts.fields import replace
from tegotae.parts.oscillators import PhaseOscillator
from tegotae.parts.terms import ConstantGain, FreeSector, Sector, ShiftedAction
from tegotae.simulation.rollout import Timing
from tegotae.study import Arrays
from tegotae.systems.recipe import recipe
from tegotae.systems.system import System
from tegotae.systems.term_sets import LAWS, nominal_speed_m_per_s
from tegotae.systems.vanilla import legged_named as legged_system

SEED = 20251
FORMS = {"load": 0.25, "latch": 0.5, "decay": 0.25}
"""Share of each in the laws."""
TURN = 2.0 * math.pi
ENDS = ("low", "high")
"""Names of the two commands of a body."""
OFFSETS, WIDTHS, DECAYS = (-1.5, 1.5), (0.1 * math.pi, math.pi), (0.1, 10.0)
"""Ranges of o, of a sector's width [rad], and of N₀."""
VANILLA = Sector()
PUSH = VANILLA.start_rad + 0.5 * VANILLA.width_rad
"""Middle of vanilla's sector [rad]: here every sector has it, so that p is no choice of origin."""


TITLES = ("place_rad", "shape", "rate_rad_per_s", "offset", "width_rad")
"""Columns of `Laws`."""


@dataclass(frozen=True)
class Subject:
    """A body, the commands that laws meet on it, and how they are drawn and measured.

    Args:
        omegas: commands ω [rad/s].
        rates: range of a [rad/s].
        timing: of the map.
        legs: how many it has.
        share: of the laws that it meets.
    """

    omegas: tuple[float, ...]
    rates: tuple[float, float]
    timing: Timing
    legs: int = 1
    share: float = 1.0


HOPS = {"rates": (0.5, 32.0), "timing": Timing(duration_s=20.0)}
SUBJECTS = {
    "study": Subject((4.0, 8.0), **HOPS),
    "quadruped": Subject(
        (2.0, 3.0),
        (0.1, 10.0),
        Timing(duration_s=60.0, tick_s=0.0125, frame_s=0.1),
        legs=4,
        share=0.25,
    ),
    "calibrated": Subject((4.0, 8.0), **HOPS, share=0.25),
}


class Laws(NamedTuple):
    """Laws of one form, arrays [laws] each."""

    place: np.ndarray
    """p [rad]."""
    shape: np.ndarray
    """The offset o of `load`, N* of `latch`, N₀ of `decay`."""
    rate: np.ndarray
    """a [rad/s]."""
    offset: np.ndarray
    """o."""
    width: np.ndarray
    """Width of the sector of a hopper [rad]."""


def between(ends: tuple[float, float], share: np.ndarray, *, log: bool = False) -> np.ndarray:
    """Return the values of a range at shares of the way through it, or through its logarithm."""
    low, high = np.log(ends) if log else ends
    values = low + (high - low) * share
    return np.exp(values) if log else values


def drawn(subject: str, form: str, first: int, count: int) -> tuple[Laws, np.ndarray]:
    """Return some laws of the sequence, and the phases of their releases [legs, laws] [rad]."""
    system = SUBJECTS[subject]
    rng = np.random.default_rng((SEED, list(FORMS).index(form)))
    sobol = qmc.Sobol(5 + system.legs, scramble=True, rng=rng)
    if first:
        sobol.fast_forward(first)
    place, shape, rate, offset, width, *phases = sobol.random(count).T
    o = between(OFFSETS, shape if form == "load" else offset)
    shapes = {
        "load": o,
        "latch": np.tan(np.pi * (shape - 0.5)),
        "decay": between(DECAYS, shape, log=True),
    }
    laws = Laws(
        between((-np.pi, np.pi), place),
        shapes[form],
        between(system.rates, rate, log=True),
        o,
        between(WIDTHS, width, log=True),
    )
    return laws, TURN * np.array(phases)


def height_of(form: str, shape: np.ndarray) -> np.ndarray:
    """Return the position of a shape in the map, 0 to 1 in its range: the reverse of the draw."""
    if form == "latch":
        return 0.5 + np.arctan(shape) / np.pi
    ends = OFFSETS if form == "load" else np.log(DECAYS)
    return ((shape if form == "load" else np.log(shape)) - ends[0]) / (ends[1] - ends[0])


@cache
def system_of(subject: str, form: str) -> System:
    """Return the closed loop of a form of law on a body."""
    terms = Tegotae(ShiftedAction(), LAWS[form].reaction, ConstantGain())
    if subject == "quadruped":
        legged = legged_system("quadruped-c")
        controller = dataclasses.replace(legged.controller, tegotae=terms)
        return replace(legged.system, {"controller": controller})
    plain = recipe("clock-w8").experiment()
    if subject == "calibrated":
        plain = reading_named("calibrated").applied(plain)
    controller = Controller(FreeSector(), PhaseOscillator(), terms)
    return replace(plain.system, {"controller": controller})


def weights_of(subject: str, form: str, laws: Laws) -> np.ndarray:
    """Return the weights of laws, [laws, n_weights]."""
    legs, body = SUBJECTS[subject].legs, system_of(subject, form).body
    if form == "load":
        weight_n = float(body.mass_kg * body.gravity_m_per_s2)
        weights = [laws.rate * legs / weight_n]
    elif form == "latch":
        weights = [legs / laws.shape, -laws.rate * laws.shape / np.hypot(1.0, laws.shape)]
    else:
        weights = [legs / laws.shape, laws.rate]
    sector = [] if legs > 1 else [(PUSH - 0.5 * laws.width) % TURN, laws.width]
    return np.stack([laws.place, laws.offset, *weights, *sector], axis=1)


def measured(
    subject: str, form: str, laws: Laws, phases: np.ndarray, omega: float, timing: Timing
) -> Arrays:
    """Measure merit, rate of hops or strides [rad/s], speed, and failures of laws, [laws] each.

    Rate and speed are those of laws that hop or walk, NaN of others; of legs also the lags of
    three behind the left hind one [cycles].
    """
    system = replace(system_of(subject, form), {"omega": omega, "timing": timing})
    weights = weights_of(subject, form, laws)
    if subject != "quadruped":
        scenario = system.scenario(phase_rad=phases[0])
        outcome = system.rollout(OutcomeSummary()).run(weights, scenario, system.body)
        moves, failed = outcome.regime == LIMIT_CYCLE, outcome.regime == FAILED
        values = {"merit": outcome.cot_inverse, "rate": outcome.hop_rate}
    else:
        legged = dataclasses.replace(
            legged_system("quadruped-c"), system=system, weights=tuple(weights[0])
        )
        scenario = system.scenario(phase_rad=phases)
        outcome = system.rollout(legged.summary()).run(weights, scenario, system.body)
        failed = np.isfinite(outcome.fall_time_s)
        fast = outcome.speed_m_per_s >= 0.5 * nominal_speed_m_per_s(legged.system, omega)
        moves = np.isfinite(outcome.lock_time_s) & (outcome.cycle_frequency_hz > 0.0) & fast
        values = {
            "merit": 1.0 / np.maximum(outcome.cost_of_transport, 1e-3),
            "rate": TURN * outcome.cycle_frequency_hz,
            "speed": outcome.speed_m_per_s,
        }
        values |= {f"lag_{legged.names[k]}": outcome.lag[k] for k in (0, 1, 3)}
    results = {name: np.where(moves, x, np.nan).astype("float32") for name, x in values.items()}
    return results | {"merit": np.nan_to_num(results["merit"]), "failed": np.asarray(failed)}
