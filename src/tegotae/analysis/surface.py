"""The actuation surface: what the whole controller answers to every phase and spring force."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import jax
import jax.numpy as jnp
import numpy as np

from tegotae._support.errors import TegotaeError, require_finite
from tegotae.analysis.maps import lanes
from tegotae.analysis.orbit import require_hopper
from tegotae.parts.maths import TWO_PI
from tegotae.simulation.integrators import TickSetting, signals
from tegotae.simulation.rollout import Scenario
from tegotae.systems.controller_file import SavedController

if TYPE_CHECKING:  # of an extra
    from tegotae.envs.policies import Policy


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

    @property
    def columns(self) -> tuple[str, np.ndarray]:
        """Name and values of the columns' axis."""
        if self.phase_rad is None:
            return "velocity_m_per_s", self.velocity_m_per_s
        return "phase_rad", self.phase_rad


def sees_velocity(driven: SavedController | Policy) -> bool:
    """Return whether any term of the controller reads the velocity, or the policy observes it."""
    if isinstance(driven, SavedController):
        return any("velocity" in term.reads for term in driven.controller.terms.values())
    return "velocity" in driven.meaning.settings.observed


def actuation_surface(
    driven: SavedController | Policy,
    spring_force_n: np.ndarray,
    *,
    columns: int = 200,
    velocity_m_per_s: float = 0.0,
    velocity_range_m_per_s: tuple[float, float] = (-4.0, 4.0),
) -> Surface:
    """Evaluate feedback, then actuation, over all pairs of phase and spring force:

        f = G(φ, s) A′(φ) R(s),    F_a = T(φ, f)  clipped to [0, α],    s = F_k or (F_k, ẏ).

    What has no phase, such as the single network, has a surface over (ẏ, F_k). What a policy
    observes beside these is that of a leg which this spring force compresses.

    Args:
        driven: a controller with its weights, frequency and body; or a policy.
        spring_force_n: spring forces F_k [N], not negative, shape [rows].
        columns: how many phases, from 0 to 2π (or velocities).
        velocity_m_per_s: the velocity of the slice, where there is a phase [m/s].
        velocity_range_m_per_s: range of velocities where they make the columns [m/s].

    Raises:
        TegotaeError: for a body without a single spring, a velocity that is not finite, spring
            forces that are negative or beyond those of a leg of no length, or a policy that fails.

    Example:
        >>> from tegotae.systems.recipe import recipe
        >>> reflex = recipe("V-reflex-w8").controller()
        >>> saved = SavedController.from_weights(reflex, np.array([2.0]), 8.0)
        >>> found = actuation_surface(saved, np.array([0.0, 1.0]), columns=3)  # φ = 0, π, 2π
        >>> found.actuator_force_n[1].round(6)  # -min(0, -σ cos φ F_k)
        array([2., 0., 2.])
    """
    controller, body = driven.controller, require_hopper(driven.body, "an actuation surface")
    require_finite("velocity", velocity_m_per_s)
    forces = np.asarray(spring_force_n, float)
    limit = body.most_spring_n
    if not (np.all(forces >= 0.0) and np.all(forces <= limit)):
        raise TegotaeError(
            f"spring forces go from {np.min(forces):g} to {np.max(forces):g} N; those of this leg "
            f"lie between 0 and {limit:g} N"
        )
    with_oscillator = controller.oscillator is not None
    phase = np.linspace(0.0, TWO_PI, columns)
    velocity = np.linspace(*velocity_range_m_per_s, columns)
    force, column = lanes(forces, phase if with_oscillator else velocity)
    speed = np.full_like(column, velocity_m_per_s) if with_oscillator else column
    with jax.enable_x64(True):
        height = jnp.asarray(body.rest_length_m - body.depth(force))
        state = body.release(height, jnp.asarray(speed))
        angle = jnp.asarray(column if with_oscillator else np.zeros_like(column))
        oscillator = () if controller.oscillator is None else controller.oscillator.start(angle)
        ground = jnp.zeros(column.shape)
        signals_there = signals(controller, body, state, oscillator, ground)
        lane_weights = (
            driven.weights if isinstance(driven, SavedController) else driven.weights(signals_there)
        )
        weights = [jnp.broadcast_to(jnp.asarray(x), column.shape) for x in lane_weights]
        turning = jnp.full(column.shape, float(Scenario.at_frequency(driven.omega).omega))
        setting = TickSetting(controller, body, weights, turning, ground, jnp.zeros(()))
        control = setting.drive(state, oscillator)
        answer = setting.push(control.command, angle, angle)

    def as_map(x) -> np.ndarray:
        return np.asarray(x).reshape(len(forces), columns)

    return Surface(
        phase_rad=phase if with_oscillator else None,
        velocity_m_per_s=np.array([velocity_m_per_s]) if with_oscillator else velocity,
        spring_force_n=forces,
        actuator_force_n=as_map(answer.mean_n),
        feedback_rad_per_s=as_map(control.feedback),
    )
