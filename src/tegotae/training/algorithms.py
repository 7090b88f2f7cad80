"""Optimisers of controller weights: the contract of a black-box optimiser, PGPE, and evosax's
three."""

from __future__ import annotations

import ctypes
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import Field, dataclass
from functools import cache
from typing import TYPE_CHECKING, Any, ClassVar, Self, TypeAlias, TypeVar

import jax
import jax.numpy as jnp

from tegotae._support.documents import JsonObject
from tegotae._support.errors import TegotaeError, require
from tegotae.parts.parameters import Part, not_negative, positive, whole
from tegotae.systems.descriptions import describe
from tegotae.training.pgpe import PGPESearch, PGPESettings

T = TypeVar("T")

Strategy: TypeAlias = Any
"""Any object with the methods of an evosax strategy that `Algorithm` names."""
SearchState: TypeAlias = Any
"""State of a strategy between generations: a pytree with a `mean` and a `std`."""
Parameters: TypeAlias = Any
"""A strategy's parameters: a pytree of its own."""


class Algorithm(Part, ABC):
    """An optimiser of weights from episode fitness alone: a frozen dataclass of its settings.

    Between generations it moves a search distribution with mean μ and standard deviation σ, both of
    [n_weights], towards higher fitness.

    It makes a strategy: any object with evosax's `init(key, mean, parameters)`,
    `ask(key, state, parameters)`, `tell(key, samples, fitness, state, parameters)` and
    `default_params`, pure functions of arrays whose state has a `mean`, shape [n_weights], and a
    `std`, one number or [n_weights]. Strategies minimise; the trainer hands them the negative
    fitness.
    """

    NAME: ClassVar[str]
    """Name in commands and documents; the name of the class by default."""
    TITLE: ClassVar[str]
    """Name in figures; `NAME` by default."""
    LIBRARIES: ClassVar[tuple[str, ...]] = ()
    """Installed packages whose versions decide the numbers, beside JAX."""

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

    def check(self) -> None:
        """Raise `MissingExtraError` where a package that it needs is not installed."""

    @abstractmethod
    def make(self, n_weights: int) -> Strategy:
        """Make a new strategy for this many weights and this population."""

    def strategy(self, n_weights: int) -> Strategy:
        """Return the strategy for this many weights; it is always the same, since a new one
        compiles anew.
        """
        return _strategy(self.program, n_weights)

    def parameters(self, n_weights: int) -> Parameters:
        """Return the strategy's parameters."""
        return self.strategy(n_weights).default_params

    def of_seeds(self, function: Callable[..., T]) -> Callable[..., T]:
        """Map a function of one seed's arrays over all seeds at once, [seeds, ...]."""
        return jax.vmap(function)

    def start(self, key: jax.Array, weights: jax.Array) -> SearchState:
        """Return the state of a search that starts from `weights`, shape [n_weights]."""
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


@cache
def _strategy(algorithm: Algorithm, n_weights: int) -> Strategy:
    # Strategies compute constants when made, which must not be part of a program being traced.
    with jax.ensure_compile_time_eval():
        return algorithm.make(n_weights)


def _with_settings(state: SearchState, settings: dict[str, float]) -> SearchState:
    """Return a strategy's state with new settings of its optimiser, which optax keeps as data
    there.
    """
    values = {name: jnp.asarray(value, "float32") for name, value in settings.items()}
    optimiser = state.opt_state
    hyperparams = {**optimiser.hyperparams, **values}
    return state.replace(opt_state=optimiser._replace(hyperparams=hyperparams))


class _OfPopulation(Algorithm):
    """An algorithm that is compiled once for all settings of a population."""

    PAIRS: ClassVar[bool] = False
    """True if samples come in pairs, so that the population is even."""

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.PAIRS and self.population % 2:
            raise TegotaeError(
                f"population is {self.population}; {self.TITLE} samples pairs, so it must be even"
            )

    @property
    def program(self) -> Self:
        """The population alone."""
        return type(self)(population=self.population)  # type: ignore[call-arg]


@dataclass(frozen=True, kw_only=True)
class PGPE(_OfPopulation):
    """PGPE with antithetic pairs, centred ranks and ClipUp, as in the paper.

    With samples `θ± = μ ± ε`, ε ~ N(0, σ²), and centred ranks r of their fitness:

        ∇μ = Σ (r₊ - r₋) ε / n,    ∇σ = Σ (r₊ + r₋ - 2 r̄)(ε² - σ²)/σ / n,

    μ moves by ClipUp, σ by at most a share `std_max_change` of itself. The defaults are those of
    every training that asks for no other settings (documentation, "Tuning").

    Raises:
        TegotaeError: for an odd population or a setting out of its range.

    References:
        F. Sehnke et al., Parameter-exploring policy gradients, Neural Networks 23, 2010.
        N. E. Toklu et al., ClipUp, PPSN 2020.
    """

    NAME = "pgpe"
    TITLE = "PGPE"
    PAIRS = True

    population: int = whole(32, least=2)
    """Episodes per generation: an even number."""
    std: float = positive(0.1)
    """Initial standard deviation of every weight."""
    std_lr: float = not_negative(0.24)
    """Learning rate of the standard deviations."""
    std_max_change: float = not_negative(0.2)
    """Largest share by which a standard deviation changes in a generation."""
    learning_rate: float = positive(0.379)
    """ClipUp's step size."""
    max_speed: float = positive(0.676)
    """ClipUp's largest step."""
    momentum: float = not_negative(0.9)
    """ClipUp's momentum."""

    def make(self, n_weights: int) -> PGPESearch:
        """Make the search of this population."""
        return PGPESearch(self.population)

    def parameters(self, n_weights: int) -> PGPESettings:
        """Return all other settings."""
        return PGPESettings(**{name: getattr(self, name) for name in PGPESettings._fields})


class _EvosaxAlgorithm(_OfPopulation):
    """An algorithm of evosax, an extra that takes a second to import."""

    LIBRARIES = ("evosax",)

    def check(self) -> None:
        """Raise `MissingExtraError` without evosax."""
        require("evosax", "evosax")


@dataclass(frozen=True, kw_only=True)
class CMAES(_EvosaxAlgorithm):
    """CMA-ES with its standard settings (through evosax).

    Candidates are θ ~ N(μ, s² C); weighted by the ranks of their fitness, they move the mean μ, the
    step size s and the covariance C.

    It sets SciPy's BLAS, with which JAX decomposes, to one thread in this process.

    Raises:
        TegotaeError: for a setting out of its range.

    Reference: N. Hansen, The CMA evolution strategy: a tutorial, 2016.
    """

    NAME = "cma-es"
    TITLE = "CMA-ES"

    population: int = whole(64, least=4)
    """Episodes per generation."""
    std: float = positive(0.3)
    """Initial step size, the standard deviation of every weight."""

    def make(self, n_weights: int) -> Strategy:
        """Make evosax's CMA-ES."""
        from evosax.algorithms import CMA_ES

        _use_one_blas_thread()
        return CMA_ES(self.population, jnp.zeros(n_weights))

    def of_seeds(self, function: Callable[..., T]) -> Callable[..., T]:
        """Apply a function to one seed after the other.

        The covariances of all seeds at once are decomposed by the threads of a pool that the
        devices share, and of two devices that wait for it neither goes on (jaxlib 0.10.2).
        """
        return lambda *arrays: jax.lax.map(lambda of_seed: function(*of_seed), arrays)

    def parameters(self, n_weights: int) -> Parameters:
        """Return evosax's parameters."""
        return self.strategy(n_weights).default_params.replace(std_init=jnp.asarray(self.std))


@dataclass(frozen=True, kw_only=True)
class OpenES(_EvosaxAlgorithm):
    """OpenAI-ES: antithetic pairs, centred ranks, Adam, a fixed deviation (through evosax).

    With samples `θ± = μ ± σ ε`, ε ~ N(0, 1), and centred ranks r of their fitness, Adam moves μ
    along `∇μ = Σ (r₊ - r₋) ε / (n σ)`.

    Raises:
        TegotaeError: for an odd population or a setting out of its range.

    Reference: T. Salimans et al., Evolution strategies as a scalable alternative to reinforcement
    learning, 2017.
    """

    NAME = "openai-es"
    TITLE = "OpenAI-ES"
    PAIRS = True

    population: int = whole(64, least=2)
    """Episodes per generation: an even number."""
    std: float = positive(0.2)
    """Standard deviation of every weight."""
    learning_rate: float = positive(0.05)
    """Adam's step size."""

    def make(self, n_weights: int) -> Strategy:
        """Make evosax's OpenAI-ES, with the deviation kept in its state."""
        import optax
        from evosax.algorithms import Open_ES

        class FixedDeviation(Open_ES):
            """OpenAI-ES with its deviation in the state; evosax compiles it into the program."""

            def _tell(self, key, population, fitness, state, params):
                updated = super()._tell(key, population, fitness, state, params)
                return updated.replace(std=state.std)

        optimizer: Any = optax.inject_hyperparams(optax.adam)(self.learning_rate)
        return FixedDeviation(self.population, jnp.zeros(n_weights), optimizer=optimizer)

    def start(self, key: jax.Array, weights: jax.Array):
        """Return the state of a search that starts from `weights`, with its deviation and
        Adam's step size.
        """
        state = super().start(key, weights)
        state = _with_settings(state, {"learning_rate": self.learning_rate})
        return state.replace(std=jnp.asarray(self.std, "float32"))


@dataclass(frozen=True, kw_only=True)
class SNES(_EvosaxAlgorithm):
    """Separable natural evolution strategy, with its standard settings (through evosax).

    With samples `θ = μ + σ z`, z ~ N(0, 1), and utilities u of the ranks of their fitness, which
    sum to 0:

        μ ← μ + σ Σ u z,    σ ← σ exp(η/2 Σ u (z² - 1)),    η = (3 + ln n) / (5 √n).

    Every weight has a deviation of its own, and no learning rate is to be tuned.

    Raises:
        TegotaeError: for a setting out of its range.

    Reference: T. Schaul, T. Glasmachers, J. Schmidhuber, High dimensions and heavy tails for
    natural evolution strategies, GECCO 2011.
    """

    NAME = "snes"
    TITLE = "SNES"

    population: int = whole(32, least=2)
    """Episodes per generation."""
    std: float = positive(0.3)
    """Initial standard deviation of every weight."""

    def make(self, n_weights: int) -> Strategy:
        """Make evosax's SNES."""
        from evosax.algorithms import SNES as EvosaxSNES  # noqa: N811

        return EvosaxSNES(self.population, jnp.zeros(n_weights))

    def parameters(self, n_weights: int) -> Parameters:
        """Return evosax's parameters."""
        return self.strategy(n_weights).default_params.replace(std_init=jnp.asarray(self.std))


def _use_one_blas_thread() -> None:
    """Limit the BLAS to one thread; devices that wait for its threads would wait for ever,
    where there are two.
    """
    from scipy.linalg import cython_lapack  # type: ignore[attr-defined]

    library = ctypes.CDLL(cython_lapack.__file__)  # Its symbols include those that it is linked to.
    for name in ("scipy_openblas_set_num_threads", "openblas_set_num_threads"):
        if hasattr(library, name):
            getattr(library, name)(1)
