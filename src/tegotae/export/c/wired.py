"""What the limbs of a controller sense and drive that was trained on an environment."""

from __future__ import annotations

from collections.abc import Sequence

from tegotae.export.c.lower import comment_of, number
from tegotae.export.c.names import plain
from tegotae.export.c.plan import Export
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
