"""What the files of an export say of it: facts for their templates."""

from __future__ import annotations

import functools
import textwrap
from typing import Any, cast

from tegotae.export.c.plan import Export, member, unit_of
from tegotae.export.c.text import floating, plain
from tegotae.parts._shapes import Number
from tegotae.parts.bodies import Hopper
from tegotae.parts.bodies.upright import Upright
from tegotae.systems.env_task import LimbDocument

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
}
"""What the senses of the package's bodies are."""


def meaning(sense: str) -> str:
    """What a sense is."""
    return _WHAT.get(sense, plain(sense))


def wired_limbs(export: Export) -> list[LimbDocument]:
    """The limbs of the wiring; none of a controller for a body of the package."""
    return [] if export.saved.task is None else export.saved.task.wiring.limbs


def constants(export: Export) -> dict[str, tuple[Number, str]]:
    """Numbers that the header names, and what they are."""
    numbers: dict[str, tuple[Number, str]] = {
        "TICK_S": (export.tick_s, "period of the control loop [s]"),
    }
    if export.saved.omega is not None:
        numbers["OMEGA_RAD_PER_S"] = (export.saved.omega, "frequency omega at start [rad/s]")
    if export.controller.actuation.commands_force:
        most = cast(Number, export.alpha_n)  # an export without one is refused
        numbers["MAX_FORCE_N"] = (most, "largest force of an actuator alpha [N]")
    if _has_spring(export):
        body = cast(Hopper | Upright, export.body)
        numbers["STIFFNESS_N_PER_M"] = (body.stiffness_n_per_m, "stiffness of a leg k [N/m]")
        numbers["DAMPING_NS_PER_M"] = (body.damping_ns_per_m, "damping of a leg c [N s/m]")
        numbers["REST_LENGTH_M"] = (body.rest_length_m, "length of a leg at rest l0 [m]")
    return numbers


def facts(export: Export) -> dict[str, Any]:
    """What all templates may say."""
    prefix, several = export.prefix, export.limbs > 1
    limbs = wired_limbs(export)
    pushes = export.controller.actuation.commands_force
    has_action = pushes and bool(limbs) and all(x.rest is not None is not x.push for x in limbs)

    def of_several(text: str) -> str:
        return text if several else ""

    def each_limb(numbers: list[Any]) -> str:
        values = ", ".join(map(floating, numbers))
        return f"{{{values}}}" if several else values

    named = [(name, floating(value), what) for name, (value, what) in constants(export).items()]
    if limbs:
        phases = each_limb([limb.phase_rad for limb in limbs])
        named.append(("PHASE_RAD", phases, "phases at start in training [rad]"))
    of_limbs = of_several(f"[{prefix.upper()}_LIMBS]")
    at_phase = f", const float phase_rad{of_limbs}" if several else ", float phase_rad"
    wired = export.controller.wiring is not None
    return {
        "prefix": prefix,
        "PREFIX": prefix.upper(),
        "title": plain(export.saved.name or "a Tegotae controller"),
        "Title": export.saved.name or "A Tegotae controller",
        "tick": f"{export.tick_s:g}",
        "limbs": export.limbs,
        "constants": [{"name": n, "value": value, "what": what} for n, value, what in named],
        "senses": [
            {"name": n, "member": member(n), "unit": unit_of(n), "what": meaning(n)}
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
        "wiring": plain("; ".join(f"limb {k}: {_spelled(limb)}" for k, limb in enumerate(limbs))),
        "wires": [
            {
                "number": k,
                "felt": ", ".join(f"{name}: `{sense}`" for name, sense in limb.senses.items()),
                "drives": limb.drives,
            }
            for k, limb in enumerate(limbs)
        ],
        "of_limbs": of_limbs,
        "of_limb": of_several("int limb, "),
        "number_of_limbs": of_several(f"[{export.limbs}]"),
        "of_unit": of_several("[unit]"),
        "limb": of_several("[limb]" if wired else "[unit]"),
        "index": of_several("[limb]"),
        "i": of_several("[i]"),
        "leg": of_several("[leg]"),
        "units": functools.partial(_over_units, export),
        "starts_at_phases": several and bool(export.state_names),
    }


def _has_spring(export: Export) -> bool:
    """Whether the spring's force can be had from leg length or contact force by the body's law."""
    return "spring_force" in export.senses and isinstance(export.body, Hopper | Upright)


def _commanded(export: Export) -> str:
    """What a command is, as a comment."""
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
    """Statements for one unit, once for each of them."""
    if export.limbs == 1 or not statements:
        return statements
    if "[limb]" in statements:
        statements = f"    const int limb = LIMB[unit];\n{statements}"
    head = f"    for (int unit = 0; unit < {export.prefix.upper()}_LIMBS; ++unit) {{\n"
    return f"{head}{textwrap.indent(statements, '    ')}    }}\n"
