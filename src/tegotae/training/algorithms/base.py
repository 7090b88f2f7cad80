"""What a black-box optimiser of controller weights is."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import Field, dataclass
from functools import cache
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, TypeAlias, TypeVar

import jax
import jax.numpy as jnp

from tegotae._support.documents import JsonObject
from tegotae.systems.descriptions import describe

T = TypeVar("T")

Strategy: TypeAlias = Any
"""Any object with the methods of an evosax strategy that `Algorithm` names."""
SearchState: TypeAlias = Any
"""What a strategy keeps from generation to generation: a pytree with a `mean` and a `std`."""
Parameters: TypeAlias = Any
"""A strategy's parameters: a pytree of its own."""


class Algorithm(ABC):
    """An optimiser of weights from episode fitness alone: a frozen dataclass of its settings.

    Between generations it moves a search distribution with mean μ and standard deviation σ, both of
    [n_weights], towards higher fitness.

    It makes a strategy: any object with evosax's `init(key, mean, parameters)`,
    `ask(key, state, parameters)`, `tell(key, samples, fitness, state, parameters)` and
    `default_params`, pure functions of arrays whose state has a `mean`, shape [n_weights], and a
    `std`, one number or [n_weights]. Strategies minimise; the trainer hands them the negative
    fitness. evosax takes a second to import, so that is left to `make`.
    """

    NAME: ClassVar[str]
    """What commands and documents call it; the name of the class by default."""

    population: int
    """Episodes per generation and seed."""

    if TYPE_CHECKING:  # Every algorithm is a dataclass.
        __dataclass_fields__: ClassVar[dict[str, Field[object]]]

    @property
    def program(self) -> Algorithm:
        """The compiled settings: all, unless a class declares some as data.

        Those that a strategy has from `parameters`, or from the state that `start` returns, need
        not be: another value of them then compiles nothing anew.
        """
        return self

    @abstractmethod
    def make(self, n_weights: int) -> Strategy:
        """A new evosax strategy for this many weights and this population."""

    def strategy(self, n_weights: int) -> Strategy:
        """The evosax strategy for this many weights (always the same: a new one compiles anew)."""
        return _made(self.program, n_weights)

    def parameters(self, n_weights: int) -> Parameters:
        """The strategy's parameters."""
        return self.strategy(n_weights).default_params

    def of_seeds(self, function: Callable[..., T]) -> Callable[..., T]:
        """A function of one seed's arrays as one of all seeds', [seeds, ...]: all at once."""
        return jax.vmap(function)

    def start(self, key: jax.Array, weights: jax.Array) -> SearchState:
        """State of a search that starts from `weights`, shape [n_weights]."""
        n = weights.shape[0]
        return self.strategy(n).init(key, weights, self.parameters(n))


def algorithm_document(settings: object) -> JsonObject:
    """Name and settings of an algorithm, a strategy's or an agent's, as JSON values.

    Raises:
        TegotaeError: for an algorithm that is not registered.

    Example:
        >>> from tegotae.training.algorithms import CMAES
        >>> algorithm_document(CMAES(population=8))
        {'name': 'cma-es', 'population': 8, 'std': 0.3}
    """
    document = describe(settings)
    return {"name": document.pop("kind"), **document}


class OptimizerState(NamedTuple):
    """What an `Adjustable` optimiser keeps."""

    settings: dict[str, jax.Array]
    inner: Any


@dataclass(frozen=True)
class Adjustable:
    """An optimiser of evosax's interface whose settings are data: others compile nothing anew.

    Args:
        make: optax's kind of optimiser (`init`, `update`) of the settings by name.
        settings: the first ones.
    """

    make: Callable[..., Any]
    settings: Mapping[str, float]

    def init(self, means: jax.Array) -> OptimizerState:
        """The state before the first update."""
        return OptimizerState(_arrays(self.settings), self.make(**self.settings).init(means))

    def update(
        self, gradient: jax.Array, state: OptimizerState, means: jax.Array | None = None
    ) -> tuple[jax.Array, OptimizerState]:
        """The step of the means, and the state after it."""
        step, inner = self.make(**state.settings).update(gradient, state.inner, means)
        return step, state._replace(inner=inner)


def with_settings(state: SearchState, **values: float) -> SearchState:
    """A strategy's state with these settings of its `Adjustable` optimiser."""
    return state.replace(opt_state=state.opt_state._replace(settings=_arrays(values)))


def _arrays(values: Mapping[str, float]) -> dict[str, jax.Array]:
    return {name: jnp.asarray(value, "float32") for name, value in values.items()}


@cache
def _made(algorithm: Algorithm, n_weights: int) -> Strategy:
    # Strategies compute constants when made, which must not be part of a program being traced.
    with jax.ensure_compile_time_eval():
        return algorithm.make(n_weights)
