"""What a leg senses, by the short names of designs."""

from __future__ import annotations

from tegotae._support.errors import TegotaeError, unknown
from tegotae.parts.bodies import Body

OBSERVATIONS = {
    "F": "the leg's load",
    "Fv": "its load and how fast it changes",
    "Fa": "its load and the body's pitch and roll",
}
"""The short names, and what they stand for."""
_RATES = ("spring_force_rate", "velocity")
_ANGLES = ("pitch", "roll")


def of_leg(observation: str, body: Body) -> tuple[str, ...]:
    """The names of what each leg senses by itself.

    Args:
        observation: "F", "Fv" or "Fa".
        body: whose senses they are. The rate of the load is that of its spring, or the velocity of
            the hip where the body senses that.

    Raises:
        TegotaeError: for another observation, or one that the body does not sense.

    Example:
        >>> from tegotae.parts.bodies import Plate, Walker
        >>> of_leg("Fv", Walker()), of_leg("Fv", Plate())
        (('spring_force', 'spring_force_rate'), ('spring_force', 'velocity'))
    """
    if observation not in OBSERVATIONS:
        raise unknown("observation", observation, OBSERVATIONS)
    rates = [name for name in _RATES if name in body.SENSES][:1] if observation == "Fv" else []
    return _sensed(("spring_force", *rates), body, observation, rates or observation != "Fv")


def of_body(observation: str, body: Body) -> tuple[str, ...]:
    """The names of what is the same for all legs: the body's angles, if they are observed.

    Args:
        observation: what is observed, such as "F" or "Fa".
        body: the body.

    Example:
        >>> from tegotae.parts.bodies import Bar
        >>> of_body("Fa", Bar()), of_body("F", Bar())
        (('pitch',), ())
    """
    angles = [name for name in _ANGLES if name in body.SENSES] if observation == "Fa" else []
    return _sensed(tuple(angles), body, observation, angles or observation != "Fa")


def all_of(observation: str, body: Body) -> tuple[str, ...]:
    """What a leg's own network is given: what the leg senses, and what the body does.

    Args:
        observation: what is observed, such as "F" or "Fa".
        body: the body.
    """
    return (*of_leg(observation, body), *of_body(observation, body))


def _sensed(names: tuple[str, ...], body: Body, observation: str, found: object) -> tuple[str, ...]:
    if not found or not set(names) <= set(body.SENSES):
        raise TegotaeError(
            f"a {type(body).__name__} does not sense {OBSERVATIONS[observation]} ({observation}); "
            f"it senses {', '.join(body.SENSES)}"
        )
    return names
