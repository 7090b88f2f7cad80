"""Cells of the map: a body, and what differs from its reference cell."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from tegotae.parts.bodies import Actuators, Body, Hopper, Sensors, Walker
from tegotae.parts.fields import unwrapped
from tegotae.parts.parameters import traceable
from tegotae.parts.terrains import Rough, Slope, SplitGrip, Steps
from tegotae.simulation.rollout import Scenario, Timing
from tegotae.simulation.schedules import Step
from tegotae.simulation.world import with_changes
from tegotae.systems.vanilla import SYSTEMS

LOAD_SENSES = ("spring_force", "spring_force_rate")
WALK, HOP = Timing(duration_s=40.0, tick_s=0.0125, frame_s=0.25), Timing(tick_s=0.004, frame_s=0.1)
"""Timing of an episode of walkers [√(l0/g)] and of legs that hop [s]."""
SLIP_S = 1.5
"""Time in which a leg gains half a cycle, or a number `slip` of cycles."""


@traceable
@dataclass(frozen=True, kw_only=True)
class TiltSensors(Sensors):
    """Sensors that measure the tilt late or with noise, and the load as it is."""

    def sense(self, state: Any, ground_m: Any) -> Any:
        """Return the reports, those of the load undisturbed."""
        reports, exact = super().sense(state, ground_m), self.body.sense(state.body, ground_m)
        loads = {name: exact.values[name] for name in LOAD_SENSES}
        return reports._replace(values=reports.values | loads)


@dataclass(frozen=True)
class Cell:
    """A body, its start and what happens to it.

    Args:
        body: name in `BODIES`.
        factor: what differs from the body's reference cell.
        change: fields of the body that have other numbers, perhaps multiplied ("*name").
        wrapper: class and numbers of a wrapper of the body.
        event: what happens in the middle of an episode.
        any_phases: True if each leg starts at any phase, False if all start in their gait.
    """

    body: str
    factor: str = "reference"
    change: Mapping[str, Any] = field(default_factory=dict)
    wrapper: tuple[type, Mapping[str, float]] | None = None
    event: str = ""
    any_phases: bool = False

    @property
    def name(self) -> str:
        """Name of the cell in tables."""
        return f"{self.body}, {self.factor}" + (", any phases" if self.any_phases else "")

    @property
    def held_out(self) -> bool:
        """True if the rule is judged on this cell, and not made of it."""
        return self.body in HELD_OUT

    @property
    def loses_phase(self) -> bool:
        """True if the legs' phases start or come apart."""
        return self.any_phases or self.event == "phase slips"

    @cached_property
    def mechanics(self) -> Body:
        """The body without its wrapper."""
        body, fields = BODIES[self.body], {}
        for name, value in self.change.items():
            nominal = getattr(body, name.lstrip("*"))
            scaled = tuple(value * x for x in nominal) if isinstance(nominal, tuple) else None
            fields[name.lstrip("*")] = (
                value if name[0] != "*" else value * nominal if scaled is None else scaled
            )
        return dataclasses.replace(body, **fields)

    @property
    def walks(self) -> bool:
        """True of a walker."""
        return isinstance(self.mechanics, Walker)

    @property
    def timing(self) -> Timing:
        """Timing of an episode."""
        timing = WALK if self.walks else HOP
        finer = math.ceil(timing.tick_s / self.mechanics.longest_tick_s)
        return dataclasses.replace(timing, tick_s=timing.tick_s / finer)

    @cached_property
    def complete_body(self) -> Body:
        """The body with its wrapper."""
        if self.wrapper is None:
            return self.mechanics
        kind, numbers = self.wrapper
        ticks = {}
        if issubclass(kind, Sensors):
            late = numbers.get("delay_s", 0.0) / self.timing.tick_s
            ticks = {"most_ticks": max(math.ceil(late - 1e-6), 1)}
        return kind(body=self.mechanics, **numbers, **ticks)

    def places(self) -> np.ndarray:
        """Return the place of each leg, its row from the front and its side (0, 1), [2, limbs]."""
        body = self.mechanics
        x = np.array(getattr(body, "hips_x_m", getattr(body, "hips_m", (0.0,))))
        y = np.array(getattr(body, "hips_y_m", getattr(body, "hips_z_m", np.zeros(len(x)))))
        return np.array([np.unique(-x, return_inverse=True)[1], y < 0.0], float)

    def scenario(self, numbers: Mapping[str, np.ndarray], seeds: np.ndarray) -> Scenario:
        """Return the episodes of controllers.

        Args:
            numbers: of the controllers, [lanes].
            seeds: of the starts, [lanes].
        """
        limbs, body, walks = self.mechanics.limbs, self.mechanics, self.walks
        unique, lane = np.unique(seeds, return_inverse=True)
        drawn = [np.random.default_rng(int(seed)) for seed in unique]
        phase = 2.0 * np.pi * np.array([rng.random(limbs) for rng in drawn])[lane].T
        tilt = np.array([rng.normal(size=2) for rng in drawn])[lane].T
        leg = np.array([rng.integers(limbs) for rng in drawn])[lane]
        if not self.any_phases:
            row, side = self.places()[..., None]
            lags = row * numbers["lag"] + side * numbers["side_lag"]
            common = phase[:1] if walks else 0.1 * phase[:1] + 2.0 * np.pi * numbers["lead"]
            phase = common - 2.0 * np.pi * lags
        omega = numbers["omega"]
        changes: dict[str, Any] = {}
        half = 0.5 * self.timing.duration_s
        alone = np.arange(limbs)[:, None] == leg
        if self.event == "leg lost":
            changes["present"] = Step(1.0 - alone, from_s=half)
        elif self.event == "ω steps":
            changes["omega"] = Step(1.6 * omega, from_s=half)
        elif self.event == "push":
            changes["push_y_n"] = Step(np.where(leg % 2, 0.45, -0.45), half, half + 1.0)
        elif self.event == "phase slips":
            gained = omega + alone * 2.0 * np.pi * numbers.get("slip", 0.5) / SLIP_S
            changes["omega"] = Step(gained, half, half + SLIP_S)
        if isinstance(getattr(body, "terrain", None), Rough):
            changes["terrain.place"] = (seeds % 97).astype(float)
        pose = {"pitch_rad": 0.05 * tilt[0], "roll_rad": 0.05 * tilt[1]}
        pose = {name: x for name, x in pose.items() if name in self.complete_body.pose_names}
        sag = body.weight_n / (limbs * body.stiffness_z_n_per_m) if walks else 0.0
        height = body.touching_height_m + numbers["press"] - sag if walks else 1.2
        scenario = Scenario(
            omega=omega, height_m=height, phase_rad=phase if limbs > 1 else phase[0],
            initial_pose=pose,
        )  # fmt: skip
        return with_changes(scenario, body, changes) if changes else scenario


def _in_pairs(*x: float) -> Walker:
    """Return a walker with quadruped C's legs in pairs at these places fore and aft."""
    hips = tuple(float(place) for place in x for _ in range(2))
    return Walker(hips_x_m=hips, hips_y_m=(0.44, -0.44) * len(x))


BODIES: dict[str, Body] = {
    "quadruped": Walker(),
    "biped": _in_pairs(0.0),
    "hexapod": _in_pairs(0.85, 0.0, -0.85),
    "hopper": Hopper(),
    **{name: unwrapped(SYSTEMS[key]().body) for name, key in {
        "light bar": "bar-light", "heavy bar": "bar-heavy",
        "light plate": "plate-light-both", "heavy plate": "plate-heavy",
        "quadruped A": "quadruped-a", "quadruped G": "quadruped-g",
        "mixed plate": "plate-light-pitch",
    }.items()},
    "octopod": _in_pairs(0.85, 0.28, -0.28, -0.85),
}  # fmt: skip
HELD_OUT = ("quadruped A", "quadruped G", "mixed plate", "octopod")
"""Bodies on which the rule is judged; chosen before any run."""
STIFF = {f"*stiffness_{axis}_n_per_m": 0.5 for axis in "xyz"}
ROUGH = {"terrain": Rough(rms_m=0.04)}
NOISY, LATE = (TiltSensors, {"noise": 0.1}), (TiltSensors, {"delay_s": 0.3})
_Q = "quadruped"
_FACTORS: dict[str, dict[str, Any]] = {
    "hips narrow": {"change": {"*hips_y_m": 0.6}},
    "hips short": {"change": {"*hips_x_m": 0.7}},
    "mass high": {"change": {"com_z_m": 0.0}},
    "mass low": {"change": {"com_z_m": -0.5}},
    "mass ahead": {"change": {"com_x_m": 0.25}},
    "soft legs or ground": {"change": STIFF},
    "stiff legs": {"change": dict.fromkeys(STIFF, 2.0)},
    "slippery": {"change": {"friction": 0.15}},
    "slippery right": {"change": {"terrain": SplitGrip(right=0.25)}},
    "uphill": {"change": {"terrain": Slope(along=0.2)}},
    "downhill": {"change": {"terrain": Slope(along=-0.2)}},
    "across a slope": {"change": {"terrain": Slope(across=0.2)}},
    "rough": {"change": ROUGH},
    "stairs": {"change": {"terrain": Steps(rise_m=0.05, tread_m=0.7)}},
    "tilt late": {"wrapper": LATE},
    "tilt noisy": {"wrapper": NOISY},
    "all late": {"wrapper": (Sensors, {"delay_s": 0.3})},
    "slow servos": {"wrapper": (Actuators, {"lag_s": 0.3})},
    "leg lost": {"event": "leg lost"},
    "ω steps": {"event": "ω steps"},
    "push": {"event": "push"},
    "phase slips": {"event": "phase slips"},
}
_PAIRS = ("mass high", "soft legs or ground", "rough", "tilt noisy", "leg lost", "ω steps")
_HOPS = ("hopper", "light bar", "heavy bar", "light plate", "heavy plate")
_FIRST = ("push", "leg lost", "rough", "phase slips", "tilt noisy")
_LAST = ("tilt noisy", "leg lost", "rough", "all late", "tilt late")
_SLIPS = {"event": "phase slips"}


def _starts(*bodies: str) -> list[Cell]:
    """Return the reference cells of bodies, in their gait and from any phases."""
    return [Cell(body, any_phases=free) for body in bodies for free in (False, True)]


CELLS = tuple(
    [*_starts(_Q, "hexapod"), *(Cell(_Q, f, **_FACTORS[f]) for f in _FIRST)]
    + _starts("hopper", "quadruped A")
    + [Cell(_Q, f, **_FACTORS[f], any_phases=True) for f in _PAIRS if f not in _LAST]
    + [Cell(body, "phase slips", **_SLIPS) for body in ("quadruped A", "hexapod")]
    + _starts("light plate", "heavy plate", "mixed plate", "light bar", "heavy bar", "octopod")
    + [Cell(_Q, f, **_FACTORS[f]) for f in _FACTORS if f not in (*_FIRST, *_LAST)]
    + _starts("quadruped G", "biped")
    + [Cell("quadruped A", f, **_FACTORS[f]) for f in ("mass high", "rough")]
    + [Cell("hexapod", "leg lost", **_FACTORS["leg lost"])]
    + [Cell(_Q, f, **_FACTORS[f], any_phases=True) for f in _PAIRS if f in _LAST]
    + [Cell(_Q, f, **_FACTORS[f]) for f in _LAST if f not in _FIRST]
)
"""All cells, in the order in which they are measured."""
