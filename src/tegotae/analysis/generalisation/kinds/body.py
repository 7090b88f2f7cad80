"""Another body, or another frequency, from the release on."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tegotae._support.errors import require_finite
from tegotae.analysis.generalisation.controllers_under_test import ControllersUnderTest
from tegotae.analysis.generalisation.disturbance import Disturbance


@dataclass(frozen=True, kw_only=True)
class Frequency(Disturbance):
    """Another frequency ω: that of the training times the level.

    Raises:
        TegotaeError: for a level that is not positive.
    """

    neutral: float = 1.0

    def __post_init__(self) -> None:
        super().__post_init__()
        for level in self.levels:
            require_finite(f"a level of {self.name}", level, above=0.0)

    def lacks(self, tested):
        """See `Disturbance.lacks`."""
        return "" if tested.omega is not None else "it has no oscillator"

    def changes(self, tested, level, at_s):
        """See `Disturbance.changes`."""
        return {"omega": tested.omega * level}


@dataclass(frozen=True, kw_only=True)
class Scaled(Disturbance):
    """Numbers of the body times the level, from the release on.

    A leg of another length is released as high over where it touches the ground.
    """

    fields: tuple[str, ...]
    """Names of which the body has at least one; all that it has are scaled."""
    neutral: float = 1.0

    def lacks(self, tested):
        """See `Disturbance.lacks`."""
        own = self._own(tested)
        if not own:
            return f"a {type(tested.unwrapped).__name__} has no {' or '.join(self.fields)}"
        if not any(np.any(np.asarray(tested.usual(name))) for name in own):
            return f"its {self.fields[0]} is 0, and so is any share of it"
        return ""

    def _own(self, tested: ControllersUnderTest) -> list[str]:
        return list(filter(tested.has_field, self.fields))

    def changes(self, tested, level, at_s):
        """See `Disturbance.changes`."""
        changes = {name: _times(tested.usual(name), level) for name in self._own(tested)}
        if "rest_length_m" in self.fields:
            longer = (level - 1.0) * float(tested.body.rest_length_m)
            changes["height_m"] = tested.height_m + longer
        return changes


def _times(usual, level):
    """A number of the body, or the legs' numbers [limbs, 1], times levels [lanes]."""
    usual = np.asarray(usual, float)
    return usual[:, None] * level if usual.ndim else usual * level
