"""The source: a function for each piece of the tick, and the step that calls them."""

from __future__ import annotations

from dataclasses import dataclass

from tegotae.export.c.header import action_source, has_spring, prototypes
from tegotae.export.c.lower import (
    Library,
    Statements,
    comment_of,
    function,
    initialiser,
    number,
    struct,
)
from tegotae.export.c.names import first_line, plain
from tegotae.export.c.plan import Export, member, unit_of
from tegotae.export.c.trace import Piece, scale_name

_NAMES = """
signals rhythm_result checked bounded WEIGHTS COUPLING_WEIGHTS SETS UNITS SET LIMB unit limb state
in out heard sound said next felt smooth feedback phase omega pull pulls pulled action reaction
gain most result oscillator unit_weights turned left over turns turn reached REST PUSH
"""
_OWN = _NAMES.split()
"""Names of the code around the traced functions."""


@dataclass(frozen=True)
class Function:
    """A piece as a function of C."""

    text: str
    given: frozenset[str]
    """What it reads of what is given."""
    arguments: tuple[str, ...]
    """Its parameters, in order: w, s, o, heard, or the name of a number."""

    def call(self, **texts: str) -> str:
        """The arguments of a call, those that C calls otherwise by what is given here."""
        return ", ".join(texts.get(name, name) for name in self.arguments)


_AHEAD = ("advanced", "phase_after")
"""Pieces that have the oscillator's own weights."""
_SCALARS = (
    "action", "reaction", "gain", "smooth", "smooth_foot_x", "smooth_foot_z", "phase", "omega",
    "feedback", "pull", "nothing", "reached",
)  # fmt: skip


def source(export: Export) -> str:
    """The text of PREFIX.c.

    Raises:
        TegotaeError: for an operation that has no C, by its name.
    """
    library = Library()
    library.taken |= set(_OWN) | set(export.pieces)
    library.helpers.add("is_finite")
    functions = {name: _function(export, library, piece) for name, piece in export.pieces.items()}
    read = frozenset().union(*(each.given for each in functions.values()))
    head = comment_of(
        plain(
            f"{export.prefix}.c: {export.saved.name or 'a Tegotae controller'}. Written by "
            "tegotae from the code that its simulator runs. All numbers are float; nothing is "
            "allocated; there is no state but the caller's."
        )
    )
    blocks = [
        f'{head}#include "{export.prefix}.h"\n\n#include <float.h>\n#include <math.h>\n',
        _constants(export, read),
        _weights(export),
        _signals(export, functions),
        *library.helper_texts(),
        *library.procedures,
        *(each.text for each in functions.values()),
        _CHECKED if export.senses or export.tracer.state_names else "",
        _TURNED if export.tracer.state_names else "",
        _BOUNDED if export.commands == ("force",) else _BOUNDED_PLACE,
        _init(export, functions),
        _step(export, functions),
        _springs(export),
        action_source(export),
    ]
    return "\n".join(block for block in blocks if block)


_CHECKED = """\
/* The number itself; 0 for what is no finite number, which is told. */
static float checked(float x, bool *sound)
{
    const bool known = is_finite(x);
    *sound = *sound && known;
    return known ? x : 0.0f;
}
"""
_TURNED = """\
/* The small angle of a finite one, which whole turns are taken from. A turn is a little less than
   its float. fmodf would do, but takes two kilobytes of a small controller's flash. */
static float turned(float phase)
{
    const float turn = 6.28318548f;
    float left = fabsf(phase);
    float over = 0.0f;
    float turns = turn;
    while (turns <= 0.5f * left) {
        turns *= 2.0f;
    }
    while (turns >= turn) {
        if (left >= turns) {
            left -= turns;
            over += 2.78275e-8f * turns;
        }
        turns *= 0.5f;
    }
    left += over;
    return (phase < 0.0f) ? -left : left;
}
"""
_BOUNDED = """\
/* A force in [0, alpha], whatever comes; 0 for what is no number. */
static float bounded(float force)
{
    return (force > 0.0f) ? ((force < MAX_FORCE_N) ? force : MAX_FORCE_N) : 0.0f;
}
"""
_BOUNDED_PLACE = """\
/* A place of the foot; that at rest for what is no finite number. */
static float bounded(float place)
{
    return is_finite(place) ? place : 0.0f;
}
"""


def _constants(export: Export, read: frozenset[str]) -> str:
    upper = export.prefix.upper()
    lines = []
    if "TICK_S" in read:
        lines.append(f"static const float TICK_S = {upper}_TICK_S;")
    if export.commands == ("force",):
        lines.append(f"static const float MAX_FORCE_N = {upper}_MAX_FORCE_N;")
    for name, scale in export.scales.items():
        if scale_name(name) in read:
            lines.append(
                f"static const float {scale_name(name)} = {number(scale, 'float')[0]}; "
                f"/* {unit_of(name)[1]}: networks see {name} over this */"
            )
    return "\n".join(lines) + "\n" if lines else ""


def _weights(export: Export) -> str:
    controller, values = export.saved.controller, export.weights
    parts = {role: names for role, names in controller.unit_weight_names.items() if names}
    blocks = [struct(f"{role}_weights", names) for role, names in parts.items()]
    n = controller.unit_weights
    if parts:
        fields = "".join(f"    {role}_weights {role};\n" for role in parts)
        blocks.append(f"typedef struct {{\n{fields}}} unit_weights;\n")
        sets = [_set(export, values[k * n : (k + 1) * n]) for k in range(controller.sets)]
        if controller.sets == 1:
            blocks.append(f"static const unit_weights WEIGHTS = {sets[0]};\n")
        else:
            blocks.append(
                f"static const unit_weights WEIGHTS[{controller.sets}] = {{\n    "
                + ",\n    ".join(sets)
                + "\n};\n"
            )
            which = ", ".join(map(str, controller.sharing or ()))
            blocks.append(
                "/* Which of these each unit has. */\n"
                f"static const int SET[{export.limbs}] = {{{which}}};\n"
            )
    if controller.coupling is not None and (
        names := controller.coupling.weight_names(controller.limbs)
    ):
        own = initialiser(names, list(values[controller.sets * n :]), "")
        blocks.append(struct("coupling_weights", names))
        blocks.append(f"static const coupling_weights COUPLING_WEIGHTS = {own};\n")
    if controller.wiring is not None:
        limbs = ", ".join(map(str, controller.wiring))
        blocks.append(
            "/* The limb that each unit feels and drives. */\n"
            f"static const int LIMB[{export.limbs}] = {{{limbs}}};\n"
        )
    return "\n".join(blocks)


def _set(export: Export, values) -> str:
    names = export.saved.controller.unit_weight_names
    paths = [(role, *path) for role, own in names.items() for path in own]
    return initialiser(paths, list(values), "")


def _signals(export: Export, functions: dict[str, Function]) -> str:
    if not _signal_names(export):
        return ""
    fields = "".join(
        f"    float {name}; /* {unit_of(name)[1]} */\n"
        if name in export.senses
        else f"    float {name};\n"
        for name in _signal_names(export)
    )
    return f"/* All that the terms of a unit may read. */\ntypedef struct {{\n{fields}}} signals;\n"


def _signal_names(export: Export) -> tuple[str, ...]:
    oscillator = export.saved.controller.oscillator
    return (*export.senses, *(() if oscillator is None else oscillator.SIGNALS))


def _function(export: Export, library: Library, piece: Piece) -> Function:
    name = next(key for key, each in export.pieces.items() if each is piece)
    statements = Statements(library, (*_SCALARS, *_OWN))
    results = statements.all(piece.results)
    given = statements.given
    roots = {text.split("->")[0].split("[")[0] for text in given}
    role = name.removesuffix("_term")
    kinds = {
        "w": f"const {'oscillator' if name in _AHEAD else role}_weights *w",
        "s": "const signals *s",
        "o": f"const {export.prefix}_oscillator *o",
        "heard": "const signals *heard",
        **{scalar: f"float {scalar}" for scalar in _SCALARS},
    }
    arguments = tuple(each for each in kinds if each in roots)
    parameters = ", ".join(kinds[each] for each in arguments)
    several = len(results) > 1 or name in ("advanced", "started")
    names = piece.names if several else None
    text = function(
        name,
        parameters,
        statements.lines,
        results,
        [node.kind for node in piece.results],
        names,
        _comment(export, name),
    )
    if name in ("advanced", "started"):
        text = _of_oscillator(text, name, export.prefix)
    return Function(text, frozenset(given), arguments)


def _of_oscillator(text: str, name: str, prefix: str) -> str:
    """The function, giving the public struct of an oscillator instead of one of its own."""
    _, text = text.split(f"}} {name}_result;\n\n", 1)
    return text.replace(f"{name}_result", f"{prefix}_oscillator")


def _comment(export: Export, name: str) -> str:
    controller = export.saved.controller
    terms = {f"{role}_term": term for role, term in controller.terms.items()}
    if name in terms:
        letter = {"action": "A'", "reaction": "R", "gain": "G", "actuation": "T"}
        role = name.removesuffix("_term")
        return f"{letter[role]}, the {role}: {first_line(terms[name])}"
    force = export.commands == ("force",)
    return {
        "started": "The oscillator at a phase [rad].",
        "rhythm": "What the terms read of the oscillator.",
        "phase_of": "The phase [rad].",
        "coupling": "What each oscillator gets from the others [rad/s]: "
        + first_line(controller.coupling),
        "phase_after": "The phase at the end of the tick [rad], whole turns not taken off.",
        "feedback_law": "The Tegotae feedback f = G A' R [rad/s]."
        if controller.tegotae
        else "There is no Tegotae feedback.",
        "command_law": "The actuator's force [N]: the term's, clipped to [0, alpha]; full force in "
        "the sector, if there is one" + ("; its mean over the tick." if export.averages else ".")
        if force
        else "Where the foot shall be [m].",
        "advanced": "The oscillator a tick later, its rate held: "
        + first_line(controller.oscillator),
    }[name]


def _init(export: Export, functions: dict[str, Function]) -> str:
    lines = [prototypes(export)["init"][0], "{"]
    upper, faults = export.prefix.upper(), "0u"
    if export.tracer.state_names:
        call = functions["started"].call(phase="turned(checked({}, &sound))")
        lines.append("    bool sound = true;")
        if export.limbs == 1:
            lines.append(f"    state->oscillator = {_started(call, 'phase_rad')};")
        else:
            lines += [
                f"    for (int unit = 0; unit < {upper}_LIMBS; ++unit) {{",
                f"        state->oscillator[unit] = {_started(call, 'phase_rad[unit]')};",
                "    }",
            ]
        lines.append(f"    state->omega_rad_per_s = {upper}_OMEGA_RAD_PER_S;")
        faults = "sound ? 0u : 1u"
    lines += [f"    state->faults = {faults};", "}", ""]
    return "\n".join(lines)


def _started(call: str, phase: str) -> str:
    return f"started({call.format(phase)})"


def _step(export: Export, functions: dict[str, Function]) -> str:
    """The step; of several limbs in three passes, since a coupling must have heard all of them."""
    controller = export.saved.controller
    hears = bool(_signal_names(export))
    at = "" if export.limbs == 1 else "[unit]"
    limb = "" if not at else "[limb]" if controller.wiring else "[unit]"
    length = f"[{export.prefix.upper()}_LIMBS]" if at else ""
    body = ["bool sound = true;"]
    if hears:
        body.append(f"signals heard{length};")
    hearing = _hearing(export, functions, at, limb)
    acting = _acting(export, functions, at, limb)
    if not export.senses:
        body.append("(void)in;")
    body += _each_unit(export, hearing, bool(export.senses))
    if "coupling" in functions:
        call = functions["coupling"].call(w="&COUPLING_WEIGHTS")
        names = ", ".join(f"pulls.unit_{i}" for i in range(export.limbs))
        body.append(f"const coupling_result pulls = coupling({call});")
        body.append(f"const float pulled{length} = {{{names}}};")
    body += _each_unit(export, acting, True)
    body += [
        "if (!sound) {",
        "    ++state->faults;",
        "}",
        "out->fault = !sound;",
    ]
    lines = [_declared(prototypes(export)["step"][0]), "{", *(f"    {line}" for line in body)]
    return "\n".join([*lines, "}", ""])


def _declared(text: str) -> str:
    return text.replace(", const ", ",\n    const ", 1) if len(text) > 96 else text


def _each_unit(export: Export, lines: list[str], uses_limb: bool) -> list[str]:
    if export.limbs == 1 or not lines:
        return lines
    wired = export.saved.controller.wiring is not None and uses_limb
    inner = (["const int limb = LIMB[unit];"] if wired else []) + lines
    upper = export.prefix.upper()
    return [
        f"for (int unit = 0; unit < {upper}_LIMBS; ++unit) {{",
        *(f"    {line}" for line in inner),
        "}",
    ]


def _hearing(export: Export, functions: dict[str, Function], at: str, limb: str) -> list[str]:
    lines = [
        f"heard{at}.{name} = checked(in->{member(name)}{limb}, &sound);" for name in export.senses
    ]
    if "rhythm" not in functions:
        return lines
    rhythm = functions["rhythm"]
    call = rhythm.call(o=f"&state->oscillator{at}")
    names = export.pieces["rhythm"].names
    if len(names) == 1:
        return [*lines, f"heard{at}.{names[0]} = rhythm({call});"]
    lines.append(f"const rhythm_result felt = rhythm({call});")
    return [*lines, *(f"heard{at}.{name} = felt.{name};" for name in names)]


def _acting(export: Export, functions: dict[str, Function], at: str, limb: str) -> list[str]:
    controller = export.saved.controller
    weights = "&WEIGHTS" if controller.sets == 1 else "&WEIGHTS[SET[unit]]"
    own = {"s": f"&heard{at}", "o": f"&state->oscillator{at}"}

    def call(name: str, **more: str) -> str:
        role = "oscillator" if name in _AHEAD else name.removesuffix("_term")
        return (
            f"{name}({functions[name].call(**own, w=f'{weights[0]}{weights[1:]}.{role}', **more)})"
        )

    lines = []
    if "omega" in {x for f in functions.values() for x in f.arguments}:
        lines.append("const float omega = state->omega_rad_per_s;")
    if export.has_phase:
        lines.append(f"const float phase = {call('phase_of')};")
    for role in ("action", "reaction", "gain"):
        if f"{role}_term" in functions:
            lines.append(f"const float {role} = {call(f'{role}_term')};")
    lines.append(f"const float feedback = {call('feedback_law')};")
    pull = {"pull": f"pulled{at}"}
    if "phase_after" in functions:
        lines.append(f"const float reached = {call('phase_after', **pull)};")
    names = export.commands
    smooth = call("actuation_term")
    if len(names) == 1:
        used = "smooth" in functions["command_law"].arguments
        lines += [f"const float smooth = {smooth};"] if used else []
        lines.append(f"out->{member(names[0])}{limb} = bounded({call('command_law')});")
    else:
        lines.append(f"const actuation_term_result smooth = {smooth};")
        more = {f"smooth_{name}": f"smooth.{name}" for name in names}
        lines.append(f"const command_law_result said = {call('command_law', **more)};")
        lines += [f"out->{member(name)}{limb} = bounded(said.{name});" for name in names]
    lines.append(f"out->feedback_rad_per_s{limb} = is_finite(feedback) ? feedback : 0.0f;")
    if export.has_phase:
        lines.append(f"out->phase_rad{limb} = phase;")
    if export.tracer.state_names:
        lines.append(f"const {export.prefix}_oscillator next = {call('advanced', **pull)};")
        finite = " && ".join(f"is_finite(next.{name})" for name in export.tracer.state_names)
        lines += [
            f"if ({finite}) {{",
            f"    state->oscillator{at} = next;",
            "} else {",
            "    sound = false;",
            "}",
        ]
    return lines


def _springs(export: Export) -> str:
    if not has_spring(export):
        return ""
    upper, found = export.prefix.upper(), prototypes(export)
    return f"""\
{found["spring_force"][0]}
{{
    const float spring = contact_n + ({upper}_DAMPING_NS_PER_M * velocity_m_per_s) - actuator_n;
    return ((contact_n > 0.0f) && (spring > 0.0f)) ? spring : 0.0f;
}}

{found["spring_force_of_length"][0]}
{{
    const float spring = {upper}_STIFFNESS_N_PER_M * ({upper}_REST_LENGTH_M - length_m);
    return (spring > 0.0f) ? spring : 0.0f;
}}
"""
