"""How sure a share of independent starts is."""

from __future__ import annotations

import math

from tegotae._support.errors import require_count

_Z = 1.959963984540054
"""The normal quantile of 97.5 %."""


def wilson(count: int, of: int) -> tuple[float, float]:
    """95 % interval of a share, `count / of`, by Wilson's score.

    Args:
        count: how many starts have it.
        of: of how many.

    Raises:
        TegotaeError: unless 0 <= count <= of, and of > 0.

    Source:
        Wilson, J. American Statistical Association 22 (1927).

    Example:
        >>> [round(end, 3) for end in wilson(24, 24)]
        [0.862, 1.0]
    """
    require_count("of", of)
    require_count("count", count, least=0, most=of)
    share, z2 = count / of, _Z**2 / of
    middle = (share + z2 / 2) / (1 + z2)
    half = _Z * math.sqrt(share * (1 - share) / of + z2 / (4 * of)) / (1 + z2)
    # Of none, and of all, the ends are 0 and 1, which rounding would miss.
    return (middle - half if count else 0.0), (middle + half if count < of else 1.0)
