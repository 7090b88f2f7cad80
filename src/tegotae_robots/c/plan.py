"""The export: a controller, the tick of its robot, and what its files say of it."""

from __future__ import annotations

import functools
import textwrap
from dataclasses import dataclass
from typing import Any, cast

import numpy as np

from lanewise.nodes import CannotLower
from tegotae._support.errors import TegotaeError, require_count, require_finite
from tegotae.analysis.certificate import weights_hash
from tegotae.parts._shapes import Number
from tegotae.parts.bodies import Body, Hopper, Interface
from tegotae.parts.bodies.upright import Upright
from tegotae.parts.terms import WholeBody
from tegotae.systems.controller_file import SavedController
from tegotae.systems.env_documents import EnvTask, LimbDocument
from tegotae_robots.c.legs import has_odometry, leg_facts, leg_pieces
from tegotae_robots.c.text import ascii_text, floating, is_c_name
from tegotae_robots.c.trace import Piece, TracedTick
from tegotae_robots.robot import RobotController

MOST_LIMBS = 32
_LEAST_TICK_S, _MOST_TICK_S = 1e-5, 1.0
"""Periods of a robot's control loop: in shorter ones a phase in float32 does not advance evenly."""


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
        >>> from tegotae.systems.recipe import recipe
        >>> reflex = recipe("V-reflex-w8").controller()
        >>> saved = SavedController.from_weights(reflex, np.array([2.0]), 8.0)
        >>> Export(saved, prefix="leg").senses
        ('spring_force',)
    """

    tick_s: float = 0.001
    prefix: str = "tegotae"

    def __post_init__(self) -> None:
        super().__post_init__()
        require_finite("tick", self.tick_s, least=_LEAST_TICK_S, most=_MOST_TICK_S)
        if not is_c_name(self.prefix):
            raise TegotaeError(
                f"prefix is {self.prefix!r}, which is no name in C, or one of its library; begin "
                "with a letter, and go on with letters, digits and underscores, such as left_leg "
                "(31 at most)"
            )
        if isinstance(self.body, Body):
            self.body.check_tick(self.tick_s)
        require_count("the number of limbs", self.limbs, most=MOST_LIMBS)
        if isinstance(actuation := self.controller.actuation, WholeBody):
            raise TegotaeError(
                f"a {type(actuation).__name__} cannot be exported: it is one network over all "
                "limbs, and what is exported is a unit a limb"
            )

    @property
    def averages(self) -> bool:
        """True if the force is its mean over a tick, as limbs on an environment have it.

        On a body of the package the force is that of the tick's start, as with `Hold`.
        """
        return isinstance(self.body, Interface) and self.controller.actuation.needs_phase

    @functools.cached_property
    def scales(self) -> dict[str, float]:
        """Divisors of signals for a network, in the signals' own units."""
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
        """List warnings for an author before the robot runs, a line each."""
        trained = self.trained_tick_s
        if trained is None or abs(trained - self.tick_s) <= 1e-9:
            return []
        warning = (
            f"the controller was trained at a tick of {trained:g} s and is exported for "
            f"{self.tick_s:g} s"
        )
        if isinstance(self.body, Hopper):
            warning += (
                f"; see how it does there: tegotae simulate FILE --hold --tick-s {self.tick_s:g}"
            )
        return [warning]

    @functools.cached_property
    def tick(self) -> TracedTick:
        """Traces of the parts of a tick."""
        return TracedTick(self, averages=self.averages)

    @functools.cached_property
    def pieces(self) -> dict[str, Piece]:
        """The functions that a tick is made of.

        Raises:
            TegotaeError: for an operation that has no C, by its name.
        """
        legs = [] if self.legs is None else leg_pieces(self.legs, odometry=has_odometry(self))
        try:
            return {**self.tick.pieces(), **{piece.name: piece for piece in legs}}
        except CannotLower as error:
            raise TegotaeError(str(error)) from None

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
    """Return the control period of a training on an environment [s], if its file has it."""
    period_s = task.settings.get("control_s", task.wiring.step_s)
    return float(period_s) if isinstance(period_s, int | float) else None


def usual_tick_s(saved: SavedController) -> float:
    """Return the control period that an export has by default [s].

    That of the training on an environment, where the file says it, and otherwise a millisecond.
    """
    period_s = None if saved.task is None else _control_period_s(saved.task)
    return 0.001 if period_s is None else period_s


_UNITS = {
    **dict.fromkeys(("spring_force", "force"), "N"),
    "spring_force_rate": "N/s",
    **dict.fromkeys(("velocity", "speed", "commanded_speed"), "m/s"),
    **{f"{name}_{axis}": "m/s" for name in ("odometry", "commanded") for axis in "xy"},
    **dict.fromkeys(("height", "foot_x", "foot_z", "foot_y"), "m"),
    **dict.fromkeys(("pitch", "roll", "yaw", "twist", "phase"), "rad"),
    **dict.fromkeys(("side_roll", "end_pitch", "side_yaw"), "rad"),
    **dict.fromkeys(("pitch_rate", "roll_rate", "yaw_rate", "twist_rate", "feedback"), "rad/s"),
    **dict.fromkeys(("side_roll_rate", "end_pitch_rate"), "rad/s"),
}
"""Units of what is sensed and commanded."""


def unit_of(name: str) -> str:
    """Return the unit of a signal."""
    return _UNITS.get(name, "the unit of the body's sense")


def member(name: str) -> str:
    """Return a signal's name with its unit, as a member of a struct.

    Example:
        >>> member("spring_force"), member("speed"), member("whiskers")
        ('spring_force_n', 'speed_m_per_s', 'whiskers')
    """
    unit = _UNITS.get(name)
    return name if unit is None else f"{name}_{unit.lower().replace('/', '_per_')}"


_WHAT = {
    "spring_force": "force of the leg's spring F_k, 0 in flight; not the force of contact",
    "spring_force_rate": "its rate of change",
    "velocity": "velocity of the hip, upwards",
    "speed": "forward speed of the body",
    "height": "height of the hip over the ground",
    "pitch": "pitch of the body",
    "roll": "roll of the body",
    "pitch_rate": "rate of pitch",
    "roll_rate": "rate of roll",
    "side_roll": "roll of the body, up on the leg's side",
    "side_roll_rate": "its rate",
    "end_pitch": "pitch of the body, up at the leg's end",
    "end_pitch_rate": "its rate",
    "odometry_x": "velocity of the body over the foot, forward, by leg odometry",
    "odometry_y": "to the left",
    "commanded_x": "commanded velocity of the body over the foot, forward",
    "commanded_y": "to the left",
    "commanded_speed": "largest commanded speed over a foot",
    "side_yaw": "yaw of the body, to the leg's side",
}
"""Descriptions of the senses of the package's bodies."""


_TILTS = frozenset({"root_roll", "root_pitch", "root_yaw"})
"""Entries of a model's observation that are sines."""


def _sensed(export: Export, signal: str) -> str:
    """Describe a sense; an angle of a model's trunk by the sine that was trained with."""
    sources = {limb.senses.get(signal, "").removeprefix("-") for limb in wired_limbs(export)}
    return ("sine of the " if sources & _TILTS else "") + _WHAT.get(signal, ascii_text(signal))


def wired_limbs(export: Export) -> list[LimbDocument]:
    """Return the limbs of the wiring, or None for a controller of a body of the package."""
    return [] if export.saved.task is None else export.saved.task.wiring.limbs


def constants(export: Export) -> dict[str, tuple[Number, str]]:
    """Return the numbers that the header names, with their descriptions."""
    numbers: dict[str, tuple[Number, str]] = {
        "TICK_S": (export.tick_s, "period of the control loop [s]"),
    }
    if export.saved.omega is not None:
        numbers["OMEGA_RAD_PER_S"] = (export.saved.omega, "frequency omega at start [rad/s]")
    if export.controller.actuation.commands_force:
        limit = cast(Number, export.alpha_n)  # an export without one is refused
        numbers["MAX_FORCE_N"] = (limit, "largest force of an actuator alpha [N]")
    if _has_spring(export):
        body = cast(Hopper | Upright, export.body)
        numbers["STIFFNESS_N_PER_M"] = (body.stiffness_n_per_m, "stiffness of a leg k [N/m]")
        numbers["DAMPING_NS_PER_M"] = (body.damping_ns_per_m, "damping of a leg c [N s/m]")
        numbers["REST_LENGTH_M"] = (body.rest_length_m, "length of a leg at rest l0 [m]")
    return numbers


def facts(export: Export) -> dict[str, Any]:
    """Return the values that all templates may take."""
    prefix, several = export.prefix, export.limbs > 1
    limbs = wired_limbs(export)
    pushes = export.controller.actuation.commands_force
    has_action = pushes and bool(limbs) and all(x.rest is not None is not x.push for x in limbs)

    def each_limb(numbers: list[Any]) -> str:
        values = ", ".join(map(floating, numbers))
        return f"{{{values}}}" if several else values

    entries = [
        (name, floating(value), description)
        for name, (value, description) in constants(export).items()
    ]
    weights = f'"{weights_hash(export.saved.weights)}"'
    entries.append(("WEIGHTS_SHA256", weights, "as a certificate names them"))
    if limbs:
        phases = each_limb([limb.phase_rad for limb in limbs])
        entries.append(("PHASE_RAD", phases, "phases at start in training [rad]"))
    of_limbs = f"[{prefix.upper()}_LIMBS]" if several else ""
    at_phase = f", const float phase_rad{of_limbs}" if several else ", float phase_rad"
    wired = export.controller.wiring is not None
    return {
        "prefix": prefix,
        "PREFIX": prefix.upper(),
        "title": ascii_text(export.saved.name or "a Tegotae controller"),
        "Title": export.saved.name or "A Tegotae controller",
        "tick": f"{export.tick_s:g}",
        "limbs": export.limbs,
        "constants": [
            {"name": n, "value": value, "what": description} for n, value, description in entries
        ],
        "senses": [
            {"name": n, "member": member(n), "unit": unit_of(n), "what": _sensed(export, n)}
            for n in export.senses
        ],
        "commands": [
            {
                "member": member(name),
                "unit": unit_of(name),
                "what": _commanded(export),
                "meaning": "force, in [0, α]" if pushes else "place of the foot from that at rest",
            }
            for name in export.commands
        ],
        "state": [
            {"name": n, "comment": " /* rad, in [0, 2 pi) */" if n == "phase" else ""}
            for n in export.state_names
        ],
        "oscillates": bool(export.state_names),
        "has_phase": export.has_phase,
        "at_phase": at_phase if export.state_names else "",
        "pushes": pushes,
        "flies": pushes and not limbs,
        "has_spring": _has_spring(export),
        "has_action": has_action,
        "rests": each_limb([limb.rest for limb in limbs]) if has_action else "",
        "full_pushes": each_limb([limb.push for limb in limbs]) if has_action else "",
        "wired": bool(limbs),
        "wiring": ascii_text(
            "; ".join(f"limb {k}: {_spelled(limb)}" for k, limb in enumerate(limbs))
        ),
        "wires": [
            {
                "number": k,
                "felt": ", ".join(f"{name}: `{sense}`" for name, sense in limb.senses.items()),
                "drives": limb.drives if isinstance(limb.drives, str) else "`, `".join(limb.drives),
            }
            for k, limb in enumerate(limbs)
        ],
        "of_limbs": of_limbs,
        "several": several,
        "number_of_limbs": f"[{export.limbs}]" if several else "",
        "limb": ("[limb]" if wired else "[unit]") if several else "",
        "units": functools.partial(_over_units, export),
        "starts_at_phases": several and bool(export.state_names),
        **leg_facts(export),
    }


def _has_spring(export: Export) -> bool:
    """Return True if the body's law gives the spring's force from leg length or contact force."""
    linear = isinstance(export.body, Upright) or getattr(export.body, "is_linear", False)
    return "spring_force" in export.senses and linear


def _commanded(export: Export) -> str:
    """Describe a command, as a comment."""
    if not export.controller.actuation.commands_force:
        return "where the foot shall be, from its place at rest"
    if wired_limbs(export):
        return f"force in [0, alpha], which is an action: {export.prefix}_action"
    return "force of the actuator, in [0, alpha]; send 0 while the foot is in the air"


def _spelled(limb: LimbDocument) -> str:
    felt = ", ".join(f"{name} is {sense}" for name, sense in limb.senses.items())
    driven = limb.drives if isinstance(limb.drives, str) else " and ".join(limb.drives)
    return f"{felt}, drives {driven}" if felt else f"drives {driven}"


def _over_units(export: Export, statements: str) -> str:
    """Return statements for one unit, repeated for each."""
    if export.limbs == 1 or not statements:
        return statements
    if "[limb]" in statements:
        statements = f"    const int limb = LIMB[unit];\n{statements}"
    head = f"    for (int unit = 0; unit < {export.prefix.upper()}_LIMBS; ++unit) {{\n"
    return f"{head}{textwrap.indent(statements, '    ')}    }}\n"
