"""The one table of operations: what each of a trace is in NumPy, in C, and in LLVM; and which need
no arithmetic, since their value is known."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from lanewise.nodes import DTYPES, FLOATS, Detail, Node, Parameters, literal
from lanewise.writer import FunctionWriter

ATOM, UNARY, PRODUCT, SUM, ORDER, EQUAL, BITS, CHOICE = 9, 8, 7, 6, 5, 4, 3, 1
"""Precedence in C, from names and calls to `?:`."""


Emission = Callable[..., str]
"""Writes an operation, from a writer, its node and the registers of its operands."""
Fold = Callable[..., ArrayLike]
"""An operation in NumPy: of numbers, its value."""


@dataclass(frozen=True)
class Operation:
    """Equivalents of a scalar operation in LLVM, C and NumPy.

    Args:
        text: the C, with {0}, {1} ... for what it acts on; None if it has none.
        binds: how tightly the text binds.
        inside: how tightly each operand must bind to stand without parentheses.
        fold: the same in NumPy, for what is known beforehand; None where that is not worth it.
        needs: a helper of C that the text calls.
        detail: what of the operation's parameters the texts depend on.
        llvm: writes the LLVM; None for what is made of others (`lanewise.functions`).
    """

    text: str | None
    binds: int = ATOM
    inside: tuple[int, ...] = (0, 0, 0)
    fold: Fold | None = None
    needs: str | None = None
    detail: Callable[[Parameters], Detail] = lambda parameters: None
    llvm: Emission | None = None


def _infix(
    sign: str, binds: int, fold: Fold | None, llvm: Emission, *, safe: bool = False
) -> Operation:
    """Return `a sign b`; the right operand binds more tightly, so that sums keep their order.

    Where compilers warn, `safe`, comparisons within stand in parentheses.
    """
    inside = (max(binds + 1, SUM),) * 2 if safe else (binds, binds + 1)
    return Operation(f"{{0}} {sign} {{1}}", binds, inside, fold, llvm=llvm)


def _function(
    name: str,
    operands: int = 1,
    needs: str | None = None,
    fold: Fold | None = None,
    llvm: Emission | None = None,
) -> Operation:
    places = ", ".join(f"{{{i}}}" for i in range(operands))
    return Operation(f"{name}({places})", needs=needs, fold=fold, llvm=llvm)


def _instruction(of_floats: str, of_whole: str, unsigned: str | None = None) -> Emission:
    """Return the emission of an instruction, chosen by the kind of its first operand."""

    def emit(w: FunctionWriter, node: Node, *operands: str) -> str:
        kind = node.inputs[0].kind
        name = of_floats if kind in FLOATS else of_whole
        if unsigned is not None and kind.startswith("u"):
            name = unsigned
        return w.do(f"{name} {w.type(kind)} {', '.join(operands)}")

    return emit


def _comparison(of_floats: str, of_whole: str) -> Emission:
    signless = of_whole in ("eq", "ne")
    unsigned = of_whole if signless else of_whole.replace("s", "u", 1)
    return _instruction(f"fcmp {of_floats}", f"icmp {of_whole}", f"icmp {unsigned}")


def _intrinsic(name: str) -> Emission:
    def emit(w: FunctionWriter, node: Node, *operands: str) -> str:
        return w.call(name, (node.kind,), *operands)

    return emit


def _divided(w: FunctionWriter, node: Node, a: str, b: str) -> str:
    """Return a ratio; a whole number divided by zero has all bits set, so that no processor
    stops.
    """
    kind = w.type(node.kind)
    if node.kind in FLOATS:
        return w.do(f"fdiv {kind} {a}, {b}")
    unit, all_set = w.number(1, node.kind), w.number(-1, node.kind)
    zero = w.do(f"icmp eq {kind} {b}, zeroinitializer")
    over = w.select(zero, node.kind, unit, b)
    if node.kind[0] == "u":
        ratio = w.do(f"udiv {kind} {a}, {over}")
    else:  # the lowest number by minus one is beyond the range
        back = w.do(f"icmp eq {kind} {b}, {all_set}")
        ratio = w.do(f"sdiv {kind} {a}, {w.select(back, node.kind, unit, over)}")
        ratio = w.select(back, node.kind, _negated(w, node, a), ratio)
    return w.select(zero, node.kind, all_set, ratio)


def _negated(w: FunctionWriter, node: Node, x: str) -> str:
    kind = w.type(node.kind)
    return w.do(f"fneg {kind} {x}" if node.kind in FLOATS else f"sub {kind} zeroinitializer, {x}")


def _magnitude(w: FunctionWriter, node: Node, x: str) -> str:
    if node.kind in FLOATS:
        return w.call("fabs", (node.kind,), x)
    return w.call("smax", (node.kind,), x, _negated(w, node, x))


def _extreme(test: str, intrinsic: str) -> Emission:
    """Return the emission of the larger or smaller of two, which is not a number if either is none.

    `x > y ? x : y` is one instruction of many processors, and gives y where x is no number.
    """

    def emit(w: FunctionWriter, node: Node, a: str, b: str) -> str:
        kind, (first, second) = w.type(node.kind), node.inputs
        if node.kind not in FLOATS:
            return w.call(f"{'u' if node.kind[0] == 'u' else 's'}{intrinsic}", (node.kind,), a, b)

        def either(x: str, y: str) -> str:
            return w.select(w.do(f"fcmp {test} {kind} {x}, {y}"), node.kind, x, y)

        if _is_number(first):
            return either(a, b)
        if _is_number(second):
            return either(b, a)
        none = w.do(f"fcmp uno {kind} {a}, {a}")
        return w.select(none, node.kind, a, either(a, b))

    return emit


def _is_number(node: Node) -> bool:
    return node.operation == "literal" and not np.isnan(node.detail)


def _inverted(w: FunctionWriter, node: Node, x: str) -> str:
    ones = w.number(True if node.kind == "bool" else -1, node.kind)
    return w.do(f"xor {w.type(node.kind)} {x}, {ones}")


def _selected(w: FunctionWriter, node: Node, index: str, *cases: str) -> str:
    index_kind = node.inputs[0].kind
    if index_kind == "bool":
        no, yes = cases
        return w.select(index, node.kind, yes, no)
    taken = cases[0]
    for number, case in enumerate(cases[1:], 1):
        mask = w.do(f"icmp sge {w.type(index_kind)} {index}, {w.number(number, index_kind)}")
        taken = w.select(mask, node.kind, case, taken)
    return taken


def _cut_off(w: FunctionWriter, source: str, to: str, x: str) -> str:
    """Return a float's whole part: the nearest number in range beyond it, zero for not a number.

    LLVM's own saturating conversion takes a vector apart into its numbers.
    """
    source_type, target_type = w.type(source), w.type(to)
    bits = _bits(to) - (to[0] != "u")
    lowest, zero = w.number(0.0 if to[0] == "u" else -(2.0**bits), source), "zeroinitializer"
    above = w.do(f"fcmp oge {source_type} {x}, {w.number(2.0**bits, source)}")
    within = w.do(f"fcmp oge {source_type} {x}, {lowest}")
    safe = w.select(above, source, zero, w.select(within, source, x, lowest))
    converted = w.do(
        f"{'fptoui' if to[0] == 'u' else 'fptosi'} {source_type} {safe} to {target_type}"
    )
    converted = w.select(above, to, w.number(2**bits - 1, to), converted)
    return w.select(w.do(f"fcmp uno {source_type} {x}, {x}"), to, zero, converted)


def _bits(kind: str) -> int:
    return 1 if kind == "bool" else 8 * np.dtype(DTYPES[kind]).itemsize


def _converted(w: FunctionWriter, node: Node, x: str) -> str:
    """Convert to another type; floats that become whole are truncated towards zero, within the
    range.
    """
    source, to = node.inputs[0].kind, node.kind
    source_type, target_type = w.type(source), w.type(to)
    if source == to:
        return x
    if to == "bool":
        test = "fcmp une" if source in FLOATS else "icmp ne"
        return w.do(f"{test} {source_type} {x}, zeroinitializer")
    if source in FLOATS and to in FLOATS:
        return w.do(
            f"{'fpext' if to == 'double' else 'fptrunc'} {source_type} {x} to {target_type}"
        )
    if source in FLOATS:
        return _cut_off(w, source, to, x)
    unsigned = source == "bool" or source[0] == "u"
    if to in FLOATS:
        return w.do(f"{'uitofp' if unsigned else 'sitofp'} {source_type} {x} to {target_type}")
    if _bits(source) == _bits(to):
        return x
    longer = "zext" if unsigned else "sext"
    return w.do(
        f"{longer if _bits(to) > _bits(source) else 'trunc'} {source_type} {x} to {target_type}"
    )


def _as_bits(w: FunctionWriter, node: Node, x: str) -> str:
    source, to = w.type(node.inputs[0].kind), w.type(node.kind)
    return x if source == to else w.do(f"bitcast {source} {x} to {to}")


def _shift(instruction: str) -> Emission:
    """Return the emission of a shift; one by all bits or more leaves zero, or the sign in every
    bit.
    """

    def emit(w: FunctionWriter, node: Node, x: str, by: str) -> str:
        kind, last = w.type(node.kind), _bits(node.kind) - 1
        amount = node.inputs[1]
        if amount.operation == "literal" and 0 <= int(amount.detail) <= last:
            return w.do(f"{instruction} {kind} {x}, {by}")
        limit = w.number(last, node.kind)
        within = w.do(f"icmp ule {kind} {by}, {limit}")
        shifted = w.do(f"{instruction} {kind} {x}, {w.select(within, node.kind, by, limit)}")
        if instruction == "ashr":
            return shifted
        return w.select(within, node.kind, shifted, "zeroinitializer")

    return emit


OPERATIONS: dict[str, Operation] = {
    "add": _infix("+", SUM, np.add, _instruction("fadd", "add")),
    "sub": _infix("-", SUM, np.subtract, _instruction("fsub", "sub")),
    "mul": _infix("*", PRODUCT, np.multiply, _instruction("fmul", "mul")),
    "div": _infix("/", PRODUCT, np.divide, _divided),
    "neg": Operation("-{0}", UNARY, (ATOM,), np.negative, llvm=_negated),
    "max": _function("larger", 2, "larger", np.maximum, _extreme("ogt", "max")),
    "min": _function("smaller", 2, "smaller", np.minimum, _extreme("olt", "min")),
    "clamp": Operation("smaller(larger({1}, {0}), {2})", needs="smaller larger"),
    "abs": _function("fabsf", fold=np.abs, llvm=_magnitude),
    "sign": _function("sign_of", needs="sign_of"),
    "floor": _function("floorf", fold=np.floor, llvm=_intrinsic("floor")),
    "ceil": _function("ceilf", fold=np.ceil, llvm=_intrinsic("ceil")),
    "round": _function("rintf", fold=np.rint, llvm=_intrinsic("rint")),
    "sqrt": _function("sqrtf", llvm=_intrinsic("sqrt")),
    "rsqrt": Operation("1.0f / sqrtf({0})", PRODUCT),
    "logistic": Operation("1.0f / (1.0f + expf(-{0}))", PRODUCT, (ATOM,)),
    **{
        name: _function(f"{name}f")
        for name in (
            *("cbrt", "exp", "exp2", "expm1", "log", "log1p", "erf", "sin", "cos", "tan"),
            *("asin", "acos", "atan", "sinh", "cosh", "tanh", "asinh", "acosh", "atanh"),
        )
    },
    "atan2": _function("atan2f", 2),
    "rem": _function("fmodf", 2),
    "pow": _function("powf", 2),
    "square": Operation("{0} * {0}", PRODUCT, (ATOM,)),
    "integer_pow": Operation("integer power", PRODUCT, (ATOM,), detail=lambda p: int(p["y"])),
    "is_finite": _function("is_finite", needs="is_finite"),
    "eq": _infix("==", EQUAL, np.equal, _comparison("oeq", "eq"), safe=True),
    "ne": _infix("!=", EQUAL, np.not_equal, _comparison("une", "ne"), safe=True),
    "lt": _infix("<", ORDER, np.less, _comparison("olt", "slt"), safe=True),
    "le": _infix("<=", ORDER, np.less_equal, _comparison("ole", "sle"), safe=True),
    "gt": _infix(">", ORDER, np.greater, _comparison("ogt", "sgt"), safe=True),
    "ge": _infix(">=", ORDER, np.greater_equal, _comparison("oge", "sge"), safe=True),
    # Of numbers alone: false where one is none. No trace has it (`native_reader`).
    "differ": Operation(None, llvm=_comparison("one", "ne")),
    "and": _infix("&", BITS, np.bitwise_and, _instruction("", "and"), safe=True),
    "or": _infix("|", BITS, np.bitwise_or, _instruction("", "or"), safe=True),
    "xor": _infix("^", BITS, np.bitwise_xor, _instruction("", "xor"), safe=True),
    "not": Operation("!{0}", UNARY, (ATOM,), np.invert, llvm=_inverted),
    # The first of the cases is that of false.
    "select_n": Operation(
        "{0} ? {2} : {1}",
        CHOICE,
        (ORDER, CHOICE + 1, CHOICE + 1),
        lambda which, *cases: cases[int(np.clip(which, 0, len(cases) - 1))],
        llvm=_selected,
    ),
    "convert_element_type": Operation("conversion", fold=lambda x: x, llvm=_converted),
    "bitcast_convert_type": _function("bits_of", needs="bits_of", llvm=_as_bits),
    "shift_left": _function("shifted_left", 2, "shifted_left", llvm=_shift("shl")),
    "shift_right_logical": Operation(None, llvm=_shift("lshr")),
    "shift_right_arithmetic": Operation(None, llvm=_shift("ashr")),
    "copy": Operation("{0}", UNARY, (UNARY,)),
}
"""Operations by their names in a trace; in C, those on integers are of `WHOLE`."""

WHOLE: dict[str, Operation] = {
    "add": _function("sum_of", 2, "sum_of"),
    "sub": _function("difference_of", 2, "difference_of"),
    "mul": _function("product_of", 2, "product_of"),
    "bitcast_convert_type": _function("float_of", needs="float_of"),
    "neg": Operation("difference_of(0, {0})", needs="difference_of"),
    "max": Operation("{0} > {1} ? {0} : {1}", CHOICE, (ATOM, ATOM)),
    "min": Operation("{0} < {1} ? {0} : {1}", CHOICE, (ATOM, ATOM)),
    "not": Operation("~{0}", UNARY, (ATOM,)),
    **{name: OPERATIONS[name] for name in ("and", "or", "xor", "shift_left", "select_n", "copy")},
    **{name: OPERATIONS[name] for name in ("eq", "ne", "lt", "le", "gt", "ge")},
}
"""Operations on int32_t in C, which wrap around as the traced ones do."""


def exact(node: Node) -> Node | None:
    """Return a simpler node that equals an operation for all numbers, to the bit, or None."""
    kind = node.kind
    match node.operation, node.inputs:
        case "select_n", (_, first, *others) if all(x is first for x in others):
            return first
        case "mul", (a, b) if _is(a, 1) or _is(b, 1):
            return b if _is(a, 1) else a
        case "div", (a, b) if _is_power_of_two(b):
            inverse = _literal(1.0 / b.detail, kind)
            return folded(Node("mul", kind, (a, inverse), None, node.origin))
        case "convert_element_type", (a,) if a.kind == kind:
            return a
        case "neg" | "not", (a,) if a.operation == node.operation:
            return a.inputs[0]
        case ("and" | "or") as operation, (a, b) if kind == "bool":
            for literal, operand in ((a, b), (b, a)):
                if literal.operation == "literal":
                    return operand if bool(literal.detail) == (operation == "and") else literal
        case "add", (a, b) if kind not in FLOATS and (_is(a, 0) or _is(b, 0)):
            return b if _is(a, 0) else a
    return None


def of_finite(node: Node) -> Node | None:
    """Return a simpler node for an operation with zero, where no sign of zero matters, or None."""
    match node.operation, node.inputs:
        case "sub", (a, b) if a is b:
            return _literal(0, node.kind)
        case "mul", (a, b) if _is(a, 0) or _is(b, 0):
            return _literal(0, node.kind)
        case "add", (a, b) if _is(a, 0) or _is(b, 0):
            return b if _is(a, 0) else a
    return None


def folded(node: Node, simpler: Callable[[Node], Node | None] = exact) -> Node:
    """Return the node folded: its value if all its inputs are known, or an equal node of less work.

    Args:
        node: an operation.
        simpler: which numbers matter, `exact` or `of_finite`.
    """
    match node.operation, node.inputs:
        case "max" | "min", (a, b) if a is b:
            return a
        case "select_n", (which, no, yes) if which.operation == "literal":
            return yes if which.detail else no
    plain = simpler(node)
    if plain is not None:
        return plain
    fold = OPERATIONS[node.operation].fold
    if fold is None or not all(x.operation == "literal" for x in node.inputs):
        return node
    with np.errstate(all="ignore"):
        return _literal(fold(*(x.detail for x in node.inputs)), node.kind)


def _is(node: Node, value: float) -> bool:
    return node.operation == "literal" and node.detail == value


def _is_power_of_two(node: Node) -> bool:
    """Return whether a node is a power of two, whose inverse is exact, too."""
    if node.operation != "literal" or node.kind not in FLOATS:
        return False
    size = abs(float(node.detail))
    return 1e-30 < size < 1e30 and np.frexp(size)[0] == 0.5


def _literal(value: ArrayLike, kind: str) -> Node:
    return literal(np.asarray(value).astype(DTYPES[kind])[()], kind)
