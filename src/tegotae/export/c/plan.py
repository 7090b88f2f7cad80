"""The export: a controller, the tick of its robot, and the data of the C code."""

from __future__ import annotations

import functools
from dataclasses import dataclass

import numpy as np

from tegotae._support.errors import TegotaeError, require_finite
from tegotae.export.c.text import is_c_name
from tegotae.export.c.trace import Piece, TracedTick
from tegotae.export.robot import RobotController
from tegotae.parts.bodies import Body, Hopper, Interface
from tegotae.parts.terms import WholeBody
from tegotae.systems.controller_file import SavedController
from tegotae.systems.env_task import EnvTask

_MOST_LIMBS = 32
_LEAST_TICK_S, _MOST_TICK_S = 1e-5, 1.0


@dataclass(frozen=True)
class Export(RobotController):
    """A saved controller as a program for a robot whose loop has this period.

    The robot evaluates the controller at the start of each tick and holds what it says for that
    tick: the package's `Hold` integrator at the same period. What was trained on an environment
    does as it did there: a force that is switched on in a sector of the phase is its mean over the
    tick.

    Args:
        saved: the controller, its weights, its frequency, and the body that it is for.
        tick_s: period of the robot's control loop [s].
        prefix: what all names in C begin with.
        max_force_n: the force α at full push [N], where the controller's file does not have it.

    Raises:
        TegotaeError: for a period that no control loop or that body can have, a prefix that
            is no name in C, or a controller that is not made of a unit a limb.

    Example:
        >>> from tegotae.systems.models import build
        >>> saved = SavedController.of(build("V-reflex-w8"), np.array([2.0]), 8.0)
        >>> Export(saved, prefix="leg").senses
        ('spring_force',)
    """

    tick_s: float = 0.001
    prefix: str = "tegotae"

    def __post_init__(self) -> None:
        super().__post_init__()
        require_finite("tick", self.tick_s, above=0.0)
        if not is_c_name(self.prefix):
            raise TegotaeError(
                f"prefix is {self.prefix!r}, which is no name in C; begin with a letter, and go on "
                "with letters, digits and underscores, such as left_leg (31 at most)"
            )
        if isinstance(self.body, Body):
            self.body.check_tick(self.tick_s)
        if not _LEAST_TICK_S <= self.tick_s <= _MOST_TICK_S:
            raise TegotaeError(
                f"tick is {self.tick_s:g}; the period of a robot's control loop is from "
                f"{_LEAST_TICK_S:g} to {_MOST_TICK_S:g} s (a phase in float32 does not advance "
                "evenly in shorter ones)"
            )
        if self.limbs > _MOST_LIMBS:
            raise TegotaeError(
                f"the controller has {self.limbs} limbs; at most {_MOST_LIMBS} can be exported"
            )
        if isinstance(actuation := self.controller.actuation, WholeBody):
            raise TegotaeError(
                f"a {type(actuation).__name__} cannot be exported: it is one network over all "
                "limbs, and what is exported is a unit a limb"
            )

    @property
    def averages(self) -> bool:
        """Whether the force is its mean over a tick, as limbs on an environment have it.

        On a body of the package the force is that of the tick's start, as with `Hold`.
        """
        return isinstance(self.body, Interface) and self.controller.actuation.needs_phase

    @functools.cached_property
    def scales(self) -> dict[str, float]:
        """What signals are divided by before a network sees them, in their own units."""
        for name, scale in self.signal_scales.items():
            if np.size(scale) != 1:
                raise TegotaeError(
                    f"the scale of {name} differs from limb to limb, which cannot be exported"
                )
        return {name: np.asarray(scale).item() for name, scale in self.signal_scales.items()}

    @property
    def trained_tick_s(self) -> float | None:
        """The control period of the training [s], if the file has it."""
        if self.saved.task is not None:
            return _control_period_s(self.saved.task)
        trained = self.saved.experiment
        return None if trained is None else trained.timing.tick_s

    def warnings(self) -> list[str]:
        """What an author should know before the robot runs, a line each."""
        trained = self.trained_tick_s
        if trained is None or abs(trained - self.tick_s) <= 1e-9:
            return []
        warning = (
            f"the controller was trained at a tick of {trained:g} s and is exported for "
            f"{self.tick_s:g} s"
        )
        if isinstance(self.body, Hopper):
            warning += (
                f"; see how it does there: tegotae simulate FILE --hold --tick {self.tick_s:g}"
            )
        return [warning]

    @functools.cached_property
    def tick(self) -> TracedTick:
        """What traces its parts."""
        return TracedTick(self, averages=self.averages)

    @functools.cached_property
    def pieces(self) -> dict[str, Piece]:
        """The functions that a tick is made of.

        Raises:
            CannotLower: for an operation that has no C, by its name.
        """
        return self.tick.pieces()

    @property
    def state_names(self) -> tuple[str, ...]:
        """Names of the numbers that the state of an oscillator has."""
        return self.tick.state_names

    @property
    def outputs(self) -> list[str]:
        """The numbers among the outputs, as members of a struct."""
        phase = ["phase_rad"] if self.has_phase else []
        return [*map(member, self.commands), "feedback_rad_per_s", *phase]


def _control_period_s(task: EnvTask) -> float | None:
    """The control period of a training on an environment [s], if its file says it."""
    own = task.settings.get("control_s", task.wiring.step_s)
    return float(own) if isinstance(own, int | float) else None


def usual_tick_s(saved: SavedController) -> float:
    """The control period that an export has by default [s].

    That of the training on an environment, where the file says it, and otherwise a millisecond.
    """
    own = None if saved.task is None else _control_period_s(saved.task)
    return 0.001 if own is None else own


_UNITS = {
    "spring_force": ("n", "N"),
    "spring_force_rate": ("n_per_s", "N/s"),
    **dict.fromkeys(("velocity", "speed"), ("m_per_s", "m/s")),
    **dict.fromkeys(("height", "foot_x", "foot_z"), ("m", "m")),
    **dict.fromkeys(("pitch", "roll", "yaw", "twist", "phase"), ("rad", "rad")),
    **dict.fromkeys(
        ("pitch_rate", "roll_rate", "yaw_rate", "twist_rate", "feedback"), ("rad_per_s", "rad/s")
    ),
    "force": ("n", "N"),
}
"""Units of what is sensed and commanded: as part of a name, and as people write them."""


def unit_of(name: str) -> str:
    """The unit of a signal."""
    return _UNITS.get(name, ("", "the unit of the body's sense"))[1]


def member(name: str) -> str:
    """A signal's name with its unit, as a member of a struct.

    Example:
        >>> member("spring_force"), member("whiskers")
        ('spring_force_n', 'whiskers')
    """
    return f"{name}_{_UNITS[name][0]}" if name in _UNITS else name
