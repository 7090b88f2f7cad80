"""Limbs that are moved elsewhere: in somebody else's simulator, or on a robot."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NoReturn

import jax
import jax.numpy as jnp

from tegotae._support.errors import TegotaeError
from tegotae.parts._shapes import (
    PerLane,
    PerLimb,
    Scalar,
    StateTree,
)
from tegotae.parts.bodies.base import Body, Push, Sensation
from tegotae.parts.bodies.interface import Interface
from tegotae.parts.parameters import traceable


@traceable
@dataclass(frozen=True, kw_only=True)
class ExternalLimbs(Body):
    """Limbs of which only the interface is known: their mechanics are elsewhere.

    A controller that was trained on an environment belongs to such a body. Whatever needs the
    mechanics is refused in one line.

    Args:
        interface: what the controller sees of them.

    Example:
        >>> limbs = ExternalLimbs(interface=Interface(limbs=2, max_force_n=4.0))
        >>> limbs.SENSES, limbs.limbs
        (('spring_force',), 2)
    """

    interface: Interface = field(default_factory=Interface)

    @property
    def SENSES(self) -> tuple[str, ...]:  # type: ignore[override]  # noqa: N802 - of every body
        """Names of the signals."""
        return self.interface.senses

    @property
    def COMMANDS(self) -> tuple[str, ...]:  # type: ignore[override]  # noqa: N802 - of every body
        """Commands of the actuators."""
        return self.interface.commands

    @property
    def limbs(self) -> int:
        """How many limbs there are."""
        return self.interface.limbs

    @property
    def max_force_n(self) -> float:  # type: ignore[override]
        """The force α at full push [N]."""
        return self._known("max_force_n", "the force at which the actuators are at full push")

    @property
    def rest_length_m(self) -> float:  # type: ignore[override]
        """Height at which the feet touch the ground [m]."""
        return self._known("rest_length_m", "the height at which the feet touch the ground [m]")

    @property
    def rate_scale(self) -> jax.Array:
        """√(g / l) [rad/s]."""
        return jnp.asarray(self._known("feedback_scale", "the scale of the feedback [rad/s]"))

    def sense(self, state: dict[str, PerLimb], ground_m: PerLane) -> Sensation:
        """The signals that were handed in, by their names, with the scales that are known."""
        scales = self.interface.known_scales
        return Sensation(dict(state), {n: scales[n] for n in self.SENSES if n in scales})

    def check_release(self, height_m: float) -> None:
        """Raise `TegotaeError`: it cannot be released here."""
        self._elsewhere()

    def release(self, height_m: PerLane, velocity_m_per_s: PerLane) -> NoReturn:
        """Refused."""
        self._elsewhere()

    def predict(
        self, state: StateTree, force_n: PerLimb, ground_m: PerLane, tick_s: Scalar
    ) -> NoReturn:
        """Refused."""
        self._elsewhere()

    def advance(self, state: StateTree, push: Push, ground_m: PerLane, tick_s: Scalar) -> NoReturn:
        """Refused."""
        self._elsewhere()

    def failed(self, state: StateTree, ground_m: PerLane) -> NoReturn:
        """Refused."""
        self._elsewhere()

    def height(self, state: StateTree) -> NoReturn:
        """Refused."""
        self._elsewhere()

    def velocity(self, state: StateTree) -> NoReturn:
        """Refused."""
        self._elsewhere()

    def energy(self, state: StateTree, ground_m: PerLane) -> NoReturn:
        """Refused."""
        self._elsewhere()

    def _known(self, name: str, what: str) -> float:
        value = getattr(self.interface, name)
        if value is None:
            raise TegotaeError(f"{name} of these limbs is not known; give {what}")
        return value

    def _elsewhere(self) -> NoReturn:
        raise TegotaeError(
            "this controller was trained on an environment, and its body is not here; use "
            "Wiring.from_controller there, or give a body of this package, such as a Hopper"
        )
