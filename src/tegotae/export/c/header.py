"""The header of an export, and the limbs of a wired one."""

from __future__ import annotations

from collections.abc import Sequence
from typing import cast

from tegotae.export.c.lower import comment_of, number
from tegotae.export.c.names import WHAT, plain
from tegotae.export.c.plan import Export, member, unit_of
from tegotae.parts._shapes import Number
from tegotae.parts.bodies import Hopper
from tegotae.parts.bodies.upright import Upright
from tegotae.systems.controller_set import LimbDocument


def limbs(export: Export) -> list[LimbDocument]:
    """The limbs of the wiring; none of a controller for a body of the package."""
    return [] if export.saved.task is None else export.saved.task.wiring.limbs


def has_action(export: Export) -> bool:
    """Whether the wiring says what action each force is."""
    ends = [end for limb in limbs(export) for end in (limb.rest, limb.push)]
    return export.commands == ("force",) and bool(ends) and None not in ends


def wired_comment(export: Export) -> str:
    """Which limb senses and drives what, as a comment."""
    if not limbs(export):
        return ""
    lines = [f"limb {k}: {_spelled(limb)}" for k, limb in enumerate(limbs(export))]
    return comment_of(plain("As it was trained, " + "; ".join(lines) + "."))


def _spelled(limb: LimbDocument) -> str:
    felt = ", ".join(f"{name} is {at}" for name, at in limb.senses.items())
    driven = limb.drives if isinstance(limb.drives, str) else " and ".join(limb.drives)
    return f"{felt}, drives {driven}" if felt else f"drives {driven}"


def phases(export: Export) -> str:
    """The phases with which the limbs began in training [rad], as an initialiser."""
    values = ", ".join(number(limb.phase_rad, "float")[0] for limb in limbs(export))
    return values if export.limbs == 1 else f"{{{values}}}"


def action_prototype(export: Export) -> tuple[str, str]:
    """The function that makes actions of forces: its declaration, and what it does."""
    limb = "" if export.limbs == 1 else "int limb, "
    return (
        f"float {export.prefix}_action({limb}float force_n)",
        "The action of a limb at a force, as the wiring of the training has it: "
        "rest + (push - rest) force / alpha.",
    )


def action_source(export: Export) -> str:
    """That function; nothing where there is none."""
    if not has_action(export):
        return ""
    own = limbs(export)
    one = export.limbs == 1
    at = "" if one else "[limb]"

    def constant(name: str, values: Sequence[float]) -> str:
        texts = [number(value, "float")[0] for value in values]
        if one:
            return f"static const float {name} = {texts[0]};\n"
        return f"static const float {name}[{len(texts)}] = {{{', '.join(texts)}}};\n"

    rests = constant("REST", [float(limb.rest or 0.0) for limb in own])
    pushes = constant("PUSH", [float(limb.push or 0.0) for limb in own])
    return f"""\
/* The action at no force, and at full force. */
{rests}{pushes}
{action_prototype(export)[0]}
{{
    return REST{at} + ((PUSH{at} - REST{at}) * (force_n / MAX_FORCE_N));
}}
"""


def header(export: Export) -> str:
    """The text of PREFIX.h."""
    prefix, saved = export.prefix, export.saved
    guard = f"{prefix.upper()}_H"
    title = saved.name or "a Tegotae controller"
    blocks = [
        comment_of(
            plain(
                f"{prefix}.h: {title}, for a control loop of {export.tick_s:g} s. Written by "
                f"tegotae from a controller file; {prefix}.json describes it, README.md how "
                "to use it."
            )
        )
        + f"#ifndef {guard}\n#define {guard}\n\n#include <stdbool.h>\n#include <stdint.h>\n",
        wired_comment(export),
        _constants(export),
        _state(export),
        _inputs(export),
        _outputs(export),
        _LINKAGE,
        _functions(export),
        _LINKAGE_ENDS,
        f"#endif /* {guard} */\n",
    ]
    return "\n".join(block for block in blocks if block)


_LINKAGE = """\
#ifdef __cplusplus
extern "C" {
#endif
"""
"""C++, that of an Arduino too, calls the functions by their names in C."""
_LINKAGE_ENDS = """\
#ifdef __cplusplus
}
#endif
"""


def index(export: Export) -> str:
    """What a member of a struct has behind it: nothing of one limb, else their number."""
    return "" if export.limbs == 1 else f"[{export.prefix.upper()}_LIMBS]"


def has_spring(export: Export) -> bool:
    """Whether the spring's force can be had from leg length or contact force by the body's law."""
    return "spring_force" in export.senses and isinstance(export.body, Hopper | Upright)


def constants(export: Export) -> dict[str, tuple[Number, str]]:
    """Numbers that the header names, and what they are."""
    found: dict[str, tuple[Number, str]] = {
        "TICK_S": (export.tick_s, "period of the control loop [s]"),
    }
    if export.saved.omega is not None:
        found["OMEGA_RAD_PER_S"] = (export.saved.omega, "frequency omega at start [rad/s]")
    if export.commands == ("force",):
        most = cast(Number, export.max_force_n)  # an export without one is refused
        found["MAX_FORCE_N"] = (most, "largest force of an actuator alpha [N]")
    if has_spring(export):
        body = cast(Hopper | Upright, export.body)
        found["STIFFNESS_N_PER_M"] = (body.stiffness_n_per_m, "stiffness of a leg k [N/m]")
        found["DAMPING_NS_PER_M"] = (body.damping_ns_per_m, "damping of a leg c [N s/m]")
        found["REST_LENGTH_M"] = (body.rest_length_m, "length of a leg at rest l0 [m]")
    return found


def _constants(export: Export) -> str:
    upper = export.prefix.upper()
    lines = [f"#define {upper}_LIMBS {export.limbs}"]
    lines += [
        f"#define {upper}_{name} {number(value, 'float')[0]} /* {what} */"
        for name, (value, what) in constants(export).items()
    ]
    if limbs(export):
        lines.append(
            f"#define {upper}_PHASE_RAD {phases(export)} /* phases at start in training [rad] */"
        )
    return "\n".join(lines) + "\n"


def _state(export: Export) -> str:
    prefix, names = export.prefix, export.tracer.state_names
    text = ""
    if names:
        fields = "".join(
            f"    float {name};{' /* rad, in [0, 2 pi) */' if name == 'phase' else ''}\n"
            for name in names
        )
        text += f"/* The state of one oscillator. */\ntypedef struct {{\n{fields}}} "
        text += f"{prefix}_oscillator;\n\n"
    fields = ""
    if names:
        fields += f"    {prefix}_oscillator oscillator{index(export)};\n"
        fields += "    float omega_rad_per_s; /* frequency; may be changed between steps */\n"
    fields += (
        "    uint32_t faults; /* steps that met what is no finite number; 1 from such a start */\n"
    )
    text += "/* All that one step hands to the next. */\n"
    return text + f"typedef struct {{\n{fields}}} {prefix}_state;\n"


def _inputs(export: Export) -> str:
    fields = "".join(
        f"    float {member(name)}{index(export)}; "
        f"/* {WHAT.get(name, plain(name))} [{unit_of(name)[1]}] */\n"
        for name in export.senses
    )
    fields = fields or "    float unused; /* this controller senses nothing */\n"
    return (
        "/* What is measured at the start of a tick. */\n"
        f"typedef struct {{\n{fields}}} {export.prefix}_inputs;\n"
    )


def _outputs(export: Export) -> str:
    at = index(export)
    fields = ""
    for name in export.commands:
        what = (
            _force(export) if name == "force" else "where the foot shall be, from its place at rest"
        )
        fields += f"    float {member(name)}{at}; /* {what} [{unit_of(name)[1]}] */\n"
    fields += f"    float feedback_rad_per_s{at}; /* Tegotae feedback f [rad/s] */\n"
    if export.has_phase:
        fields += f"    float phase_rad{at}; /* phase at the start of the tick [rad] */\n"
    fields += "    bool fault; /* something was no finite number, see README.md */\n"
    return (
        "/* What is to be done during the tick. */\n"
        f"typedef struct {{\n{fields}}} {export.prefix}_outputs;\n"
    )


def _force(export: Export) -> str:
    """What a force is, as a comment."""
    if limbs(export):
        return f"force in [0, alpha], which is an action: {export.prefix}_action"
    return "force of the actuator, in [0, alpha]; send 0 while the foot is in the air"


def prototypes(export: Export) -> dict[str, tuple[str, str]]:
    """The functions: declarations, and what they do."""
    prefix, at = export.prefix, index(export)
    phases = f"const float phase_rad{at}" if at else "float phase_rad"
    parameter = f", {phases}" if export.tracer.state_names else ""
    found = {
        "init": (
            f"void {prefix}_init({prefix}_state *state{parameter})",
            "Make the state that a run begins with"
            + (
                ", at these phases [rad], which count modulo 2 pi; one that is no finite number "
                "counts as 0, and as a fault."
                if parameter
                else "."
            ),
        ),
        "step": (
            f"void {prefix}_step({prefix}_state *state, const {prefix}_inputs *in, "
            f"{prefix}_outputs *out)",
            "One tick: from what is measured at its start to what is done until its end.",
        ),
    }
    if has_action(export):
        found["action"] = action_prototype(export)
    if has_spring(export):
        found["spring_force"] = (
            f"float {prefix}_spring_force(float contact_n, float velocity_m_per_s, "
            "float actuator_n)",
            "The spring's force F_k [N] from the force of contact, such as that of a load cell "
            "under the foot: F_k = F_contact + c v - F_a, v being the velocity of the hip upwards. "
            "0 without contact. The law wants this one; fed with the force of contact it hops "
            "differently.",
        )
        found["spring_force_of_length"] = (
            f"float {prefix}_spring_force_of_length(float length_m)",
            "The spring's force F_k [N] from the length of the leg: k (l0 - l), and 0 beyond l0.",
        )
    return found


def _functions(export: Export) -> str:
    return "\n".join(
        comment_of(what) + f"{declaration};\n" for declaration, what in prototypes(export).values()
    )
