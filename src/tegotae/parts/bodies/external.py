"""Limbs that are moved elsewhere: in somebody else's simulator, or on a robot."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, NoReturn

import jax.numpy as jnp

from tegotae._support.errors import TegotaeError, require_count, require_finite
from tegotae.parts.bodies.base import Body, Sensation
from tegotae.parts.commands import FORCE
from tegotae.parts.parameters import STATIC, traceable


@traceable
@dataclass(frozen=True, kw_only=True)
class ExternalLimbs(Body):
    """Limbs that feel and push, and whose mechanics are not here.

    A controller that was trained on an environment belongs to such a body: it says what signals
    there are, what they are measured against, and how hard the actuators push. What would move it
    is refused in one line.

    Args:
        senses: names of the signals.
        scales: what a network divides each of them by.
        count: how many limbs.
        commands: what is commanded (`tegotae.parts.commands`).
        max_force_n: the force α at which the action is at full push.
        rest_length_m: height at which the feet touch the ground [m].
        feedback_scale: √(g / l), by which a network sees the feedback [rad/s].

    Raises:
        TegotaeError: for a number out of its range, or scales of another number than senses.

    Example:
        >>> limbs = ExternalLimbs(senses=("spring_force",), scales=(9.81,), count=2)
        >>> limbs.SENSES, limbs.limbs
        (('spring_force',), 2)
    """

    senses: tuple[str, ...] = field(default=("spring_force",), metadata=STATIC)
    scales: tuple[float, ...] = (1.0,)
    count: int = field(default=1, metadata=STATIC)
    commands: tuple[str, ...] = field(default=FORCE, metadata=STATIC)
    max_force_n: float = 4.0
    rest_length_m: float = 1.0
    feedback_scale: float = 1.0

    def __post_init__(self) -> None:
        require_count("count", self.count)
        for name in ("max_force_n", "rest_length_m", "feedback_scale"):
            require_finite(name, getattr(self, name), above=0.0)
        if len(self.scales) != len(self.senses):
            raise TegotaeError(
                f"there are {len(self.scales)} scales for {len(self.senses)} senses; give one each"
            )
        for name, scale in zip(self.senses, self.scales, strict=True):
            require_finite(f"the scale of {name}", scale, above=0.0)

    @property
    def SENSES(self) -> tuple[str, ...]:  # type: ignore[override]  # noqa: N802 - of every body
        """Names of the signals."""
        return self.senses

    @property
    def COMMANDS(self) -> tuple[str, ...]:  # type: ignore[override]  # noqa: N802 - of every body
        """What the actuators are told."""
        return self.commands

    @property
    def limbs(self) -> int:
        """How many limbs there are."""
        return self.count

    @property
    def rate_scale(self) -> Any:
        """√(g / l) [rad/s]."""
        return jnp.asarray(self.feedback_scale)

    def sense(self, state: Any, ground_m: Any) -> Sensation:
        """What is felt is what was handed in: a value by the name of each signal."""
        return Sensation(dict(state), dict(zip(self.senses, self.scales, strict=True)))

    def check_release(self, height_m: float) -> None:
        """Raise `TegotaeError`: it cannot be released here."""
        self._elsewhere()

    def release(self, height_m: Any, velocity_m_per_s: Any) -> Any:
        """Refused."""
        self._elsewhere()

    def predict(self, state: Any, force_n: Any, ground_m: Any, tick_s: Any) -> Any:
        """Refused."""
        self._elsewhere()

    def advance(self, state: Any, push: Any, ground_m: Any, tick_s: Any) -> Any:
        """Refused."""
        self._elsewhere()

    def failed(self, state: Any, ground_m: Any) -> Any:
        """Refused."""
        self._elsewhere()

    def height(self, state: Any) -> Any:
        """Refused."""
        self._elsewhere()

    def velocity(self, state: Any) -> Any:
        """Refused."""
        self._elsewhere()

    def energy(self, state: Any, ground_m: Any) -> Any:
        """Refused."""
        self._elsewhere()

    def _elsewhere(self) -> NoReturn:
        raise TegotaeError(
            "this controller was trained on an environment, and its body is not here; use "
            "Wiring.from_controller there, or give a body of this package, such as a Hopper"
        )
