"""A user's file outside the package: parts of their own, and an experiment made of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp

from tegotae import Experiment, Hopper, System, Timing
from tegotae.measures.evaluation import Protocol
from tegotae.measures.objectives.objective import Objective
from tegotae.parts.controller import Controller, Tegotae
from tegotae.parts.fields import replace
from tegotae.parts.maths import wrap_phase
from tegotae.parts.oscillators import Oscillator
from tegotae.parts.parameters import traceable
from tegotae.parts.terms import (
    ConstantGain,
    Reflex,
    Signals,
    Term,
    VanillaReaction,
)
from tegotae.training.algorithms import Algorithm


@dataclass(frozen=True)
class HarmonicAction(Term):
    """`A′(φ) = Σ_n a_n cos nφ + b_n sin nφ` of first and second order."""

    @property
    def reads(self) -> tuple[str, ...]:
        return ("sin_phase", "cos_phase")

    @property
    def n_weights(self) -> int:
        return 4

    def initial(self, key: jax.Array) -> jax.Array:
        return 0.1 * jax.random.normal(key, (4,)) + jnp.array([-1.0, 0.0, 0.0, 0.0])

    def __call__(self, weights: Sequence[jax.Array], signals: Signals) -> jax.Array:
        sine, cosine = signals["sin_phase"], signals["cos_phase"]
        second = weights[2] * (cosine * cosine - sine * sine) + weights[3] * 2.0 * sine * cosine
        return weights[0] * cosine + weights[1] * sine + second


class DriftingState(NamedTuple):
    phase: jax.Array
    shift: jax.Array


@dataclass(frozen=True)
class DriftingPhase(Oscillator):
    """`φ̇ = ω + a + f`, `τ ȧ = η f - a`."""

    strength: float = 0.1
    time_s: float = 2.0

    def start(self, phase_rad: jax.Array) -> DriftingState:
        return DriftingState(wrap_phase(phase_rad), jnp.zeros_like(phase_rad))

    def rate(self, state: Any, omega: jax.Array, feedback: jax.Array, weights: Any = ()) -> Any:
        fades = (self.strength * feedback - state.shift) / self.time_s
        return DriftingState(omega + state.shift + feedback, fades)

    def phase(self, state: Any) -> jax.Array:
        return state.phase

    def settle(self, state: Any) -> DriftingState:
        return state._replace(phase=wrap_phase(state.phase))


@traceable
@dataclass(frozen=True, kw_only=True)
class LoadedHopper(Hopper):
    """A hopper that feels its spring through a sensor of some gain."""

    sensor_gain: float = 1.1

    def sense(self, state: Any, ground_m: jax.Array) -> Any:
        felt = super().sense(state, ground_m)
        values = dict(felt.values)
        values["spring_force"] = self.sensor_gain * values["spring_force"]
        return felt._replace(values=values)


@dataclass(frozen=True, kw_only=True)
class Height(Objective):
    """Greatest height of the body in the last part of an episode [m]."""

    last_s: float = 1.0

    def outcome(self, trajectory: Any, scenario: Any, body: Any, timing: Timing) -> jax.Array:
        frames = round(self.last_s / timing.frame_s)
        return trajectory.height_m[-frames:].max(axis=0)


class Searching(NamedTuple):
    mean: jax.Array
    std: jax.Array
    fitness: jax.Array


@dataclass(frozen=True, kw_only=True)
class Climb(Algorithm):
    """Keep the best of some random neighbours."""

    NAME = "climb"

    population: int = 4
    step: float = 0.2

    def make(self, n_weights: int) -> Climber:
        return Climber(self.population, self.step)


@dataclass(frozen=True)
class Climber:
    """The strategy: pure functions of arrays."""

    population: int
    step: float
    default_params: tuple = ()

    def init(self, key: jax.Array, mean: jax.Array, parameters: Any) -> Searching:
        return Searching(mean, jnp.asarray(self.step, mean.dtype), jnp.asarray(jnp.inf))

    def ask(self, key: jax.Array, state: Searching, parameters: Any) -> tuple[jax.Array, Any]:
        noise = jax.random.normal(key, (self.population, state.mean.shape[0]))
        return state.mean[None] + state.std * noise, state

    def tell(
        self, key: jax.Array, samples: jax.Array, fitness: jax.Array, state: Any, parameters: Any
    ) -> tuple[Searching, dict]:
        best = jnp.argmin(fitness)
        better = fitness[best] < state.fitness
        mean = jnp.where(better, samples[best], state.mean)
        return Searching(mean, state.std, jnp.minimum(fitness[best], state.fitness)), {}


def make_experiment(name: str = "mine", **changes: Any) -> Experiment:
    """An experiment of a few seconds, of parts that the package does not have."""
    terms = Tegotae(HarmonicAction(), VanillaReaction(), ConstantGain())
    system = System(
        controller=Controller(Reflex(), DriftingPhase(), terms),
        omega=8.0,
        body=LoadedHopper(),
        timing=Timing(duration_s=2.0, tick_s=0.004),
    )
    protocol = Protocol(
        undisturbed_s=2.0, disturbed_s=2.0, offsets=(0.0,), tick_s=0.004, clamped_phases=2
    )
    default = Experiment(name=name, system=system, objective=Height(), protocol=protocol)
    return replace(default, changes)


experiment = make_experiment()
several = [experiment, make_experiment("mine-slow", omega=4.0)]
