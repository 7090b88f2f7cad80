"""The actuation surface: what the whole controller answers to every phase and spring force."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import jax
import jax.numpy as jnp
import numpy as np

from tegotae._support.errors import TegotaeError, require_finite
from tegotae.analysis.sweep import lanes
from tegotae.parts._shapes import LaneNumbers
from tegotae.parts.bodies import Body, Hopper
from tegotae.parts.controller import Controller
from tegotae.parts.maths import TWO_PI
from tegotae.parts.terms import Signals
from tegotae.simulation.integrators.base import drive, push, signals
from tegotae.simulation.rollout import Scenario
from tegotae.systems.controller_file import SavedController


@dataclass(frozen=True)
class Surface:
    """Actuator force and feedback over (phase, spring force)."""

    phase_rad: np.ndarray | None
    """Phases φ [rad] along the columns, shape [columns]; None without an oscillator."""
    velocity_m_per_s: np.ndarray
    """Velocity ẏ [m/s]: that of the slice, shape [1], or without an oscillator the columns'."""
    spring_force_n: np.ndarray
    """Spring forces F_k [N] along the rows, shape [rows]."""
    actuator_force_n: np.ndarray
    """F_a [N] in [0, α], shape [rows, columns]."""
    feedback_rad_per_s: np.ndarray
    """Tegotae feedback f [rad/s], shape [rows, columns]."""


def sees_velocity(saved: SavedController) -> bool:
    """Whether any term of the controller reads the velocity."""
    return any("velocity" in term.reads for term in saved.controller.terms.values())


def actuation_surface(
    saved: SavedController,
    spring_force_n: np.ndarray,
    *,
    columns: int = 200,
    velocity_m_per_s: float = 0.0,
    velocity_range_m_per_s: tuple[float, float] = (-4.0, 4.0),
) -> Surface:
    """Evaluate feedback, then actuation, over all pairs of phase and spring force:

        f = G(φ, s) A′(φ) R(s),    F_a = T(φ, f)  clipped to [0, α],    s = F_k or (F_k, ẏ).

    The single network has no phase; its surface is that over (ẏ, F_k).

    Args:
        saved: the controller, its weights, frequency and body.
        spring_force_n: spring forces F_k [N], not negative, shape [rows].
        columns: how many phases, from 0 to 2π (or velocities).
        velocity_m_per_s: the velocity that terms which read one are shown [m/s].
        velocity_range_m_per_s: range of velocities where they make the columns [m/s].

    Raises:
        TegotaeError: for a body without a single spring, a velocity that is not finite, or spring
            forces that are negative or beyond those of a leg of no length.

    Example:
        >>> from tegotae import build
        >>> saved = SavedController.of(build("V-reflex-w8"), np.array([2.0]), 8.0)
        >>> found = actuation_surface(saved, np.array([0.0, 1.0]), columns=3)  # φ = 0, π, 2π
        >>> found.actuator_force_n[1].round(6)  # -min(0, -σ cos φ F_k)
        array([2., 0., 2.])
    """
    return surface_of(
        saved.controller,
        saved.body,
        saved.omega,
        lambda seen: list(saved.weights),
        spring_force_n,
        columns=columns,
        velocity_m_per_s=velocity_m_per_s,
        velocity_range_m_per_s=velocity_range_m_per_s,
    )


def surface_of(
    controller: Controller,
    body: Body,
    omega: float | None,
    weights_at: Callable[[Signals], Sequence[LaneNumbers]],
    spring_force_n: np.ndarray,
    *,
    columns: int,
    velocity_m_per_s: float,
    velocity_range_m_per_s: tuple[float, float],
) -> Surface:
    """The same where the weights may depend on what is sensed: an agent's action is a weight.

    Args:
        controller: what makes the force.
        body: the hopper.
        omega: frequency ω [rad/s]; None without an oscillator.
        weights_at: from the signals of all points to the weights, each one or [points].
        spring_force_n: as for `actuation_surface`, and so the rest.
        columns: how many phases or velocities.
        velocity_m_per_s: the velocity of the slice [m/s].
        velocity_range_m_per_s: range of velocities where they make the columns [m/s].
    """
    if not isinstance(body, Hopper):
        raise TegotaeError(f"an actuation surface needs a hopper, not a {type(body).__name__}")
    require_finite("velocity", velocity_m_per_s)
    forces = np.asarray(spring_force_n, float)
    most = body.stiffness_n_per_m * body.rest_length_m
    if not (np.all(forces >= 0.0) and np.all(forces <= most)):
        raise TegotaeError(
            f"spring forces go from {np.min(forces):g} to {np.max(forces):g} N; those of this leg "
            f"lie between 0 and {most:g} N"
        )
    with_oscillator = controller.oscillator is not None
    phase = np.linspace(0.0, TWO_PI, columns)
    velocity = np.linspace(*velocity_range_m_per_s, columns)
    force, column = lanes(forces, phase if with_oscillator else velocity)
    speed = np.full_like(column, velocity_m_per_s) if with_oscillator else column
    with jax.enable_x64(True):
        state = body.release(
            jnp.asarray(body.rest_length_m - force / body.stiffness_n_per_m), jnp.asarray(speed)
        )
        angle = jnp.asarray(column if with_oscillator else np.zeros_like(column))
        oscillator = () if controller.oscillator is None else controller.oscillator.start(angle)
        ground = jnp.zeros(column.shape)
        seen = signals(controller, body, state, oscillator, ground)
        weights = [jnp.broadcast_to(jnp.asarray(x), column.shape) for x in weights_at(seen)]
        turning = jnp.full(column.shape, float(Scenario.of(omega).omega))
        control = drive(controller, body, weights, turning, state, oscillator, ground)
        answer = push(controller, body.max_force_n, control.command, angle, angle, turning)

    def as_map(x) -> np.ndarray:
        return np.asarray(x).reshape(len(forces), columns)

    return Surface(
        phase_rad=phase if with_oscillator else None,
        velocity_m_per_s=np.array([velocity_m_per_s]) if with_oscillator else velocity,
        spring_force_n=forces,
        actuator_force_n=as_map(answer.mean_n),
        feedback_rad_per_s=as_map(control.feedback),
    )
