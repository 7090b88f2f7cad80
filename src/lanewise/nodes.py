"""The nodes of a graph of scalars, where they come from in the traced code, and its errors."""

from __future__ import annotations

import ast
import functools
import itertools
from collections.abc import Callable, Generator, Iterable, Mapping, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, ParamSpec, TypeAlias, TypeVar

import numpy as np
from numpy.typing import ArrayLike

Traced: TypeAlias = Any
"""A jaxpr or a piece of one: JAX declares neither shapes nor types of what stands in it."""
Parameters: TypeAlias = Mapping[str, Any]
"""Parameters of an operation of a trace: each operation has entries of its own."""
Tree: TypeAlias = Any
"""Any pytree of arrays, or of their shapes, such as a lane's state."""
Detail: TypeAlias = Any
"""Detail of a node beside its inputs: a number, a name, or its branch or loop."""


P = ParamSpec("P")
T = TypeVar("T")

_keeps_calls: ContextVar[bool] = ContextVar("kept", default=False)


def stays_a_call(function: Callable[P, T]) -> Callable[P, T]:
    """Let the function stay one call in traces made within `keeping_calls`.

    Everywhere else it is the plain function: nothing of it shows in a compiled program.
    """
    import jax  # nodes need no JAX, nor does compiled code

    compiled = jax.jit(function)

    @functools.wraps(function)
    def call(*args: P.args, **kwargs: P.kwargs) -> T:
        return (compiled if _keeps_calls.get() else function)(*args, **kwargs)

    return call


@contextmanager
def keeping_calls() -> Generator[None]:
    """Keep, within the block, the calls of functions as calls in traces.

    Example:
        >>> import jax
        >>> import jax.numpy as jnp
        >>> @stays_a_call
        ... def doubled(x):
        ...     return x + x
        >>> with keeping_calls():
        ...     trace = jax.make_jaxpr(lambda x: doubled(x))(jnp.ones(()))
        >>> trace.eqns[0].params["name"]
        'doubled'
    """
    token = _keeps_calls.set(True)
    try:
        yield
    finally:
        _keeps_calls.reset(token)


@dataclass(frozen=True)
class Place:
    """Source location of a computation."""

    file: Path
    line: int
    function: str

    @property
    def names(self) -> tuple[str, ...]:
        """Names that the line assigns; else the function's name."""
        name = self.function.split(".")[-1].strip("_")
        return _assigned(self.file).get(self.line) or (name if name.isidentifier() else "value",)


def is_of_jax(path: str) -> bool:
    """Return whether a path, or its beginning, is that of a file of JAX itself."""
    return _jax_folder() in path


@functools.cache
def _jax_folder() -> str:
    import jax

    return str(Path(jax.__file__).parent)


def place_of(equation: Traced) -> Place | None:
    """Return the line of the program that made an operation of a trace, if that is known."""
    try:
        frames = equation.source_info.traceback.frames
    except AttributeError:
        return None
    for frame in frames:
        path = frame.file_name
        if path != __file__ and not is_of_jax(path) and not path.startswith("<"):
            return Place(Path(path), frame.line_num, frame.function_name)
    return None


@functools.cache
def _assigned(file: Path) -> dict[int, tuple[str, ...]]:
    """Return the names that each line of a file assigns to."""
    try:
        tree = ast.parse(file.read_text(encoding="utf-8"))
    except (OSError, ValueError, SyntaxError):
        return {}
    assigned: dict[int, tuple[str, ...]] = {}
    for node in ast.walk(tree):
        if isinstance(node, ast.Assign):
            target = node.targets[0]
        elif isinstance(node, ast.AugAssign | ast.AnnAssign):
            target = node.target
        else:
            continue
        targets = target.elts if isinstance(target, ast.Tuple) else [target]
        names = tuple(name.id for name in targets if isinstance(name, ast.Name))
        if len(names) == len(targets):
            for line in range(node.lineno, (node.end_lineno or node.lineno) + 1):
                assigned[line] = names
    return assigned


class LanewiseError(ValueError):
    """The program cannot be compiled or loaded: a line for people."""


class CannotLower(LanewiseError):  # noqa: N818 - it says what cannot be done
    """An operation that has no native code, or no C: which, and where it was written.

    Args:
        operation: its name in a trace, or other words that name it.
        place: the line of the program, if that is known.
        why: what about it, if not all of it.
        target: the code that there is none of.

    Example:
        >>> print(CannotLower("sort"))
        'sort' has no native code
    """

    def __init__(
        self,
        operation: str,
        place: Place | None = None,
        reason: str = "",
        target: str = "native code",
    ) -> None:
        label = repr(operation) if operation.isidentifier() else operation
        where = "" if place is None else f" ({place.file.name}, line {place.line})"
        super().__init__(f"{label}{where} has no {target}{reason and ': '}{reason}")
        self.operation, self.place, self.why = operation, place, reason


KINDS = {
    "float32": "float",
    "float64": "double",
    "int32": "int32_t",
    "int64": "int64_t",
    "uint32": "uint32_t",
    "uint64": "uint64_t",
    "bool": "bool",
}
"""Types in C by those of a trace."""
DTYPES = {kind: dtype for dtype, kind in KINDS.items()}
"""Types of a trace by those in C."""
FLOATS = ("float", "double")
UNIFORM, LANE, TICK = range(3)
"""Stages of an episode, at which a scalar is known: the same for all lanes; of a lane, and the same
all the time; of every tick."""
_number = itertools.count()


@dataclass(eq=False)
class Node:
    """A scalar: a constant, an input, or the result of an operation on other scalars."""

    operation: str
    """A name of `OPERATIONS`; or literal, given, result; branch or loop, of which parts are."""
    kind: str
    """Its type in C."""
    inputs: tuple[Node, ...] = ()
    detail: Detail = None
    """The value of a literal, the name of what is given, which result of which call."""
    origin: Traced = None
    """The operation of the trace that it comes from, where the program's own names are wanted."""
    stage: int = TICK
    """Stage at which the value is known; of an operation, once all of its inputs are."""
    number: int = field(default_factory=lambda: next(_number))
    """Later ones depend on earlier ones alone."""

    def __post_init__(self) -> None:
        if self.inputs:
            self.stage = max([node.stage for node in self.inputs])


@dataclass(eq=False)
class Fork:
    """Alternatives of a node `branch`: the results of either side.

    The node's inputs are the condition, then `no`, then `yes`.
    """

    no: tuple[Node, ...]
    yes: tuple[Node, ...]


@dataclass(eq=False)
class Loop:
    """Body of a node `loop`, repeated while a condition holds.

    The node's inputs are the values that `carried` begins with, then all from outside that a round
    reads.
    """

    carried: tuple[Node, ...]
    """Values that change from round to round, as input nodes."""
    goes_on: Node
    """The condition, of what is carried."""
    onwards: tuple[Node, ...]
    """Values carried to the next round."""

    @functools.cached_property
    def changing(self) -> frozenset[Node]:
        """All values that change from round to round."""
        changing = set(self.carried)
        for node in reachable((self.goes_on, *self.onwards)):
            if not changing.isdisjoint(node.inputs):
                changing.add(node)
        return frozenset(changing)

    def outside(self) -> tuple[Node, ...]:
        """Return the values that the loop reads and does not change, in order."""
        order = reachable((self.goes_on, *self.onwards))
        read = {x: None for node in order if node in self.changing for x in node.inputs}
        read.update(dict.fromkeys((self.goes_on, *self.onwards)))
        return tuple(x for x in read if x not in self.changing and x.operation != "literal")


def input_node(name: Detail, kind: str = "float", stage: int = TICK) -> Node:
    """Return the node of a scalar input; for C, with its text there."""
    return Node("given", kind, detail=name, stage=stage)


def literal(value: Detail, kind: str) -> Node:
    """Return the node of a constant."""
    return Node("literal", kind, detail=value, stage=UNIFORM)


def reachable(nodes: Iterable[Node]) -> list[Node]:
    """Return all nodes that these depend on, in an order in which they can be computed."""
    met: set[Node] = set()
    pending = list(nodes)
    while pending:
        node = pending.pop()
        if node not in met:
            met.add(node)
            pending += node.inputs
    return sorted(met, key=lambda node: node.number)


@functools.cache
def dtype_name(dtype: np.dtype) -> str:
    """Return the name of a type in a trace, kept since NumPy composes it anew each time."""
    return str(dtype)


def array_of(nodes: Sequence[Node], shape: tuple[int, ...]) -> np.ndarray:
    """Return the nodes as an array."""
    array = np.empty(len(nodes), object)
    array[:] = nodes
    return array.reshape(shape)


def constant(value: ArrayLike, kinds: Mapping[str, str] = KINDS) -> np.ndarray:
    """Return an array of known numbers as an array of literals.

    Raises:
        CannotLower: for numbers of a type that no scalar has.
    """
    numbers = np.asarray(value)
    kind = kinds.get(dtype_name(numbers.dtype))
    if kind is None:
        raise CannotLower(f"numbers of {numbers.dtype}")
    return array_of([literal(x, kind) for x in numbers.reshape(-1)], numbers.shape)


def scalars(arrays: Sequence[np.ndarray]) -> list[Node]:
    """Return all entries of the arrays as one list."""
    return [node for array in arrays for node in array.reshape(-1)]
