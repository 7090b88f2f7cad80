"""The source: a function for each piece of the tick, and the step that calls them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from tegotae.parts.weight_names import inside
from tegotae_robots.c.plan import Export, facts, member, unit_of
from tegotae_robots.c.statements import Library, Statements, c_function, initialiser, struct
from tegotae_robots.c.text import filled_c, floating
from tegotae_robots.c.trace import Piece, scale_name

_NAMES = """
signals rhythm_result checked bounded WEIGHTS COUPLING_WEIGHTS SETS UNITS SET LIMB unit limb state
in out heard sound said next felt smooth feedback phase omega pull pulls pulled action reaction
gain most result leg wanted moved torque rates upward LEGS oscillator unit_weights turned left over
turns turn reached REST PUSH
"""
_OWN = _NAMES.split()
"""Names of the code around the traced functions."""
_SCALARS = (
    "action", "reaction", "gain", "smooth", "smooth_foot_x", "smooth_foot_z", "smooth_foot_y",
    "phase", "omega", "feedback", "pull", "nothing", "reached",
)  # fmt: skip
_AHEAD = ("advanced", "phase_after")
"""Pieces that have the oscillator's own weights."""
_OF_OSCILLATOR = ("advanced", "started")
"""Pieces that give the state of an oscillator."""


def source(export: Export) -> str:
    """Return the text of PREFIX.c.

    Raises:
        TegotaeError: for an operation that has no C, by its name.
    """
    library, functions = _functions_of(export, export.pieces)
    oscillator = export.controller.oscillator
    signals = (*export.senses, *(() if oscillator is None else oscillator.SIGNALS))
    if not any({"s", "heard"} & set(x.arguments) for x in functions.values()):  # such as a clock
        signals = ()
        pieces = {name: piece for name, piece in export.pieces.items() if name != "rhythm"}
        library, functions = _functions_of(export, pieces)
    read = frozenset().union(*(x.reads for x in functions.values()))
    entries = facts(export)
    return filled_c(
        "source.c",
        {
            **entries,
            "own_constants": _constants(export, read),
            "weights": "\n".join(_weights(export)),
            "hears": bool(signals),
            "signals": [
                {"name": n, "comment": f" /* {unit_of(n)} */" if n in export.senses else ""}
                for n in signals
            ],
            "functions": "\n".join([*library.texts(), *(x.text for x in functions.values())]),
            "checks": bool(export.senses or export.state_names),
            **_calls(export, functions, entries["limb"]),
        },
    )


@dataclass(frozen=True)
class _Function:
    """A piece as a function of C."""

    name: str
    text: str
    reads: frozenset[str]
    """Names of the values that it reads beside its parameters."""
    arguments: tuple[str, ...]
    """Its parameters, in order: w, s, o, heard, or the name of a number."""

    def call(self, **texts: str) -> str:
        """Return a call of a piece, with its arguments renamed in C by a mapping."""
        return f"{self.name}({', '.join(texts.get(name, name) for name in self.arguments)})"


def _role(name: str) -> str:
    """Return the role whose weights a piece reads."""
    if name == "command_law":
        return "actuation"
    return "oscillator" if name in _AHEAD else name.removesuffix("_term")


def _function(export: Export, library: Library, piece: Piece) -> _Function:
    name = piece.name
    statements = Statements(library, (*_SCALARS, *_OWN))
    results = statements.all(piece.results)
    roots = {text.split("->")[0].split("[")[0] for text in statements.given}
    kinds = {
        "w": f"const {_role(name)}_weights *w",
        "s": "const signals *s",
        "o": f"const {export.prefix}_oscillator *o",
        "heard": "const signals *heard",
        "leg": "const leg_geometry *leg",
        **{array: f"const float *{array}" for array in ("wanted", "moved", "torque", "rates")},
        **{scalar: f"float {scalar}" for scalar in _SCALARS},
    }
    arguments = tuple(x for x in kinds if x in roots)
    gives_oscillator = name in _OF_OSCILLATOR
    text = c_function(
        name,
        ", ".join(kinds[x] for x in arguments),
        statements.lines,
        results,
        [node.kind for node in piece.results],
        piece.names if len(results) > 1 or gives_oscillator else None,
        piece.comment,
        f"{export.prefix}_oscillator" if gives_oscillator else "",
    )
    return _Function(name, text, frozenset(statements.given), arguments)


def _constants(export: Export, read: frozenset[str]) -> list[dict[str, str]]:
    """Return the source's own names of constants."""
    upper = export.prefix.upper()
    lines = [("TICK_S", f"{upper}_TICK_S", "")] if "TICK_S" in read else []
    if export.controller.actuation.commands_force:
        lines.append(("MAX_FORCE_N", f"{upper}_MAX_FORCE_N", ""))
    lines += [
        (scale_name(n), floating(scale), f" /* {unit_of(n)}: networks see {n} over this */")
        for n, scale in export.scales.items()
        if scale_name(n) in read
    ]
    return [{"name": name, "value": value, "comment": comment} for name, value, comment in lines]


def _weights(export: Export) -> list[str]:
    controller, values = export.controller, export.weights.tolist()
    parts = {role: names for role, names in controller.unit_weight_names.items() if names}
    paths = [path for role, names in parts.items() for path in inside((role,), names)]
    blocks = [struct(f"{role}_weights", names) for role, names in parts.items()]
    n = controller.unit_weights
    if parts:
        fields = "".join(f"    {role}_weights {role};\n" for role in parts)
        blocks.append(f"typedef struct {{\n{fields}}} unit_weights;\n")
        sets = [initialiser(paths, values[k * n : (k + 1) * n], "") for k in range(controller.sets)]
        if controller.sets == 1:
            blocks.append(f"static const unit_weights WEIGHTS = {sets[0]};\n")
        else:
            entries = ",\n    ".join(sets)
            head = f"static const unit_weights WEIGHTS[{controller.sets}]"
            blocks.append(f"{head} = {{\n    {entries}\n}};\n")
            blocks.append(_numbers("Which of these each unit has.", "SET", controller.sharing))
    coupling = controller.coupling
    if coupling is not None and (names := coupling.weight_names(controller.limbs)):
        initial = initialiser(names, values[controller.sets * n :], "")
        blocks.append(struct("coupling_weights", names))
        blocks.append(f"static const coupling_weights COUPLING_WEIGHTS = {initial};\n")
    if controller.wiring is not None:
        blocks.append(
            _numbers("The limb that each unit feels and drives.", "LIMB", controller.wiring)
        )
    return blocks


def _functions_of(
    export: Export, pieces: Mapping[str, Piece]
) -> tuple[Library, dict[str, _Function]]:
    """Return the functions of pieces, and the functions that they call."""
    library = Library()
    library.taken |= set(_OWN) | set(export.pieces)
    library.helpers.add("is_finite")
    return library, {name: _function(export, library, x) for name, x in pieces.items()}


def _numbers(comment: str, name: str, values: Sequence[int] | None) -> str:
    numbers = tuple(values or ())
    listed = ", ".join(map(str, numbers))
    return f"/* {comment} */\nstatic const int {name}[{len(numbers)}] = {{{listed}}};\n"


def _calls(export: Export, functions: dict[str, _Function], limb: str) -> dict[str, object]:
    """Return the calls of the pieces in a step, and the statements on their results."""
    controller, names = export.controller, export.commands
    weights = "&WEIGHTS" if controller.sets == 1 else "&WEIGHTS[SET[unit]]"
    unit = "[unit]" if export.limbs > 1 else ""

    def call_of(name: str) -> str:
        if name not in functions:
            return ""
        arguments = {"w": f"{weights}.{_role(name)}", "s": f"&heard{unit}", "pull": f"pulled{unit}"}
        if len(names) > 1:
            arguments |= {f"smooth_{x}": f"smooth.{x}" for x in names}
        return functions[name].call(o=f"&state->oscillator{unit}", **arguments)

    phase = f"turned(checked(phase_rad{unit}, &sound))"
    felt = []
    if controller.oscillator is not None and "rhythm" in functions:
        signals = controller.oscillator.SIGNALS
        felt = [f"heard{unit}.{name} = felt.{name};" for name in signals]
        felt.insert(0, f"const rhythm_result felt = {call_of('rhythm')};")
        if len(signals) == 1:
            felt = [f"heard{unit}.{signals[0]} = {call_of('rhythm')};"]
    smooth, command = call_of("actuation_term"), call_of("command_law")
    if len(names) == 1:
        reads_smooth = "smooth" in functions["command_law"].arguments
        commanding = [f"const float smooth = {smooth};"] if reads_smooth else []
        commanding.append(f"out->{member(names[0])}{limb} = bounded({command});")
    else:
        commanding = [
            f"const actuation_term_result smooth = {smooth};",
            f"const command_law_result said = {command};",
            *(f"out->{member(name)}{limb} = bounded(said.{name});" for name in names),
        ]
    terms = [role for role in ("action", "reaction", "gain") if f"{role}_term" in functions]
    started, coupling = functions.get("started"), functions.get("coupling")
    return {
        **{x: call_of(x) for x in ("phase_of", "feedback_law", "phase_after", "advanced")},
        "started": started.call(phase=phase) if started else "",
        "felt": [{"statement": x} for x in felt],
        "coupled": coupling is not None,
        "coupling": coupling.call(w="&COUPLING_WEIGHTS") if coupling else "",
        "pulls": ", ".join(f"pulls.unit_{i}" for i in range(export.limbs)),
        "reads_omega": any("omega" in x.arguments for x in functions.values()),
        "terms": [{"role": role, "call": call_of(f"{role}_term")} for role in terms],
        "averages": export.averages,
        "commanding": [{"statement": x} for x in commanding],
        "next_is_finite": " && ".join(f"is_finite(next.{x})" for x in export.state_names),
    }
