"""The interface of a body: all that a controller sees of it, on any simulator."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar

from tegotae._support.errors import TegotaeError, require_count, require_finite
from tegotae.parts.commands import FORCE
from tegotae.parts.parameters import STATIC, traceable


@traceable
@dataclass(frozen=True, kw_only=True)
class Interface:
    """Signals, commands and scales of limbs; None for what is not known.

    It stands for a body whose mechanics are in another simulator or in a robot.
    A network sees a signal x as x / scale, and one without a known scale as x.

    Args:
        senses: names of the signals.
        scales: of each signal, in its units; None for all or for one that is not known.
        limbs: how many limbs there are.
        commands: what is commanded (`tegotae.parts.commands`).
        max_force_n: the force α at which the actuators are at full push.
        rest_length_m: height at which the feet touch the ground [m].
        feedback_scale: √(g / l), the scale of the feedback [rad/s].

    Raises:
        TegotaeError: for a number out of its range, or scales of another number than senses.

    Example:
        >>> Interface(senses=("spring_force", "velocity"), scales=(9.81, None)).known_scales
        {'spring_force': 9.81}
    """

    NAME: ClassVar[str] = "Interface"
    """What documents call it, where a body could stand."""

    senses: tuple[str, ...] = field(default=("spring_force",), metadata=STATIC)
    scales: tuple[float | None, ...] | None = None
    limbs: int = field(default=1, metadata=STATIC)
    commands: tuple[str, ...] = field(default=FORCE, metadata=STATIC)
    max_force_n: float | None = None
    rest_length_m: float | None = None
    feedback_scale: float | None = None

    def __post_init__(self) -> None:
        require_count("limbs", self.limbs)
        if self.scales is not None and len(self.scales) != len(self.senses):
            raise TegotaeError(
                f"there are {len(self.scales)} scales for {len(self.senses)} senses; give one "
                "each, None where it is not known"
            )
        numbers = {
            "max_force_n": self.max_force_n,
            "rest_length_m": self.rest_length_m,
            "feedback_scale": self.feedback_scale,
            **{
                f"the scale of {name}": scale
                for name, scale in zip(self.senses, self.scales or (), strict=False)
            },
        }
        for name, value in numbers.items():
            if value is not None:
                require_finite(name, value, above=0.0)

    @property
    def known_scales(self) -> dict[str, float]:
        """The scales that are known, by the names of the signals; that of `feedback` among them."""
        pairs = zip(self.senses, self.scales or (), strict=False)
        found = {**dict(pairs), "feedback": self.feedback_scale}
        return {name: scale for name, scale in found.items() if scale is not None}
