"""Units in which a controller counts on a body of another size: Froude's similarity."""

from __future__ import annotations

from dataclasses import dataclass

from tegotae.parts.parameters import Part, positive

_DIMENSIONS = {
    "spring_force": (0, 0, 1),
    "spring_force_rate": (0, -1, 1),
    "force": (0, 0, 1),
    "velocity": (1, -1, 0),
    "speed": (1, -1, 0),
    **dict.fromkeys(("odometry_x", "odometry_y"), (1, -1, 0)),
    **dict.fromkeys(("commanded_x", "commanded_y", "commanded_speed"), (1, -1, 0)),
    "height": (1, 0, 0),
    "feedback": (0, -1, 0),
    "alarm": (0, -1, 0),
}
"""Powers of length, time and force; of others, such as angles, none, and of their rates 1/time."""


@dataclass(frozen=True, kw_only=True)
class Units(Part):
    """Values of a controller's 1 m, 1 s and 1 N on a body.

    A controller of a walker with l0 = m = g = 1 has l0, √(l0 / g) and m g of a robot as its units
    there: all that it feels and does is then in the same proportion to the robot as it was to the
    walker.

    Args:
        length_m: of 1 m [m].
        time_s: of 1 s [s].
        force_n: of 1 N [N].

    Raises:
        TegotaeError: for one that is not above zero.

    Example:
        >>> Units(length_m=0.25, time_s=0.16, force_n=120.0).value_of("speed")
        1.5625
    """

    length_m: float = positive(1.0)
    time_s: float = positive(1.0)
    force_n: float = positive(1.0)

    def value_of(self, signal: str) -> float:
        """Return the value of one unit of a signal on the body."""
        length, time, force = _DIMENSIONS.get(signal, (0, -1 * signal.endswith("_rate"), 0))
        return self.length_m**length * self.time_s**time * self.force_n**force

    def over(self, divisor: Units) -> Units:
        """Return these units over others: the factors for a controller trained on another body."""
        return Units(
            length_m=self.length_m / divisor.length_m,
            time_s=self.time_s / divisor.time_s,
            force_n=self.force_n / divisor.force_n,
        )
