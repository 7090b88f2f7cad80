"""Refusals: bad input ends in an error of one line."""

import re
from collections.abc import Callable
from typing import Any

import pytest

from tegotae import TegotaeError


def refused(match: str | re.Pattern[str], call: Callable[..., Any], /, *args: Any, **named: Any):
    """Check that a call is refused in one line that a pattern matches; return that line."""
    __tracebackhide__ = True
    with pytest.raises(TegotaeError, match=match) as raised:
        call(*args, **named)
    line = str(raised.value)
    assert "\n" not in line
    return line
