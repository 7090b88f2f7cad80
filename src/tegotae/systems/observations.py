"""Observations of learned terms: what a name's `-rF` or `-gFv` lets a network sense."""

from __future__ import annotations

from dataclasses import dataclass

from tegotae._support.errors import TegotaeError, lookup
from tegotae.parts.bodies import Body


@dataclass(frozen=True, kw_only=True)
class Observation:
    """Senses of a body that a learned term reads, under a short name.

    Args:
        name: its part of a controller's name, such as "Fv".
        senses: signals of each leg.
        of_body: signals that all legs have in common; a body has one of them at least.
        about: its meaning in words.
        symbols: the same in symbols.
    """

    name: str
    senses: tuple[str, ...]
    of_body: tuple[str, ...] = ()
    about: str
    symbols: str

    def on(self, body: Body) -> tuple[tuple[str, ...], tuple[str, ...]]:
        """Return the signals of each leg, and those that all legs of a body have in common.

        Args:
            body: the body.

        Raises:
            TegotaeError: for a body without these senses.

        Example:
            >>> from tegotae.parts.bodies import Bar
            >>> observation("Fa").on(Bar())
            (('spring_force',), ('pitch',))
        """
        common = tuple(name for name in self.of_body if name in body.SENSES)
        if not set(self.senses) <= set(body.SENSES) or bool(common) != bool(self.of_body):
            raise TegotaeError(
                f"a {type(body).__name__} does not sense {self.about} ({self.name}); it senses "
                f"{', '.join(body.SENSES)}"
            )
        return self.senses, common


_ROWS = (
    Observation(name="F", senses=("spring_force",), about="the leg's load", symbols="F_k"),
    Observation(
        name="Fv",
        senses=("spring_force", "velocity"),
        about="its load and the velocity of its hip",
        symbols="F_k, ẏ",
    ),
    Observation(
        name="Fr",
        senses=("spring_force", "spring_force_rate"),
        about="its load and how fast it changes",
        symbols="F_k, dF_k/dt",
    ),
    Observation(
        name="Fa",
        senses=("spring_force",),
        of_body=("pitch", "roll"),
        about="its load and the body's pitch and roll",
        symbols="F_k, angles",
    ),
)
OBSERVATIONS = {row.name: row for row in _ROWS}
"""The observations by name."""


def observation(name: str) -> Observation:
    """Return the observation of a name.

    Raises:
        TegotaeError: for an unknown one, with the nearest ones.

    Example:
        >>> observation("Fv").senses
        ('spring_force', 'velocity')
    """
    return lookup("observation", name, OBSERVATIONS)
