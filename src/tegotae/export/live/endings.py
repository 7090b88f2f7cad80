"""Signals that end a loop: the first one interrupts it, and none interrupts what ends it safely."""

from __future__ import annotations

import signal
import threading
from types import FrameType, TracebackType
from typing import Any

_SIGNALS = ("SIGINT", "SIGTERM", "SIGHUP")
"""Ctrl-C, a request to end, and a terminal that was closed; the last is not on every system."""


class Endings:
    """Holds these signals back while it is entered, in the main thread.

    At the end the handlers from before are back. They get the signals that came, but for a Ctrl-C
    that only would have raised `KeyboardInterrupt`. A signal that was ignored still is.
    """

    def __init__(self) -> None:
        self.came: list[int] = []
        """Signals that came, in their order."""
        self.interrupts = False
        """Whether the next signal raises `KeyboardInterrupt`, which only one does."""
        self._before: dict[int, Any] = {}

    def __enter__(self) -> Endings:
        if threading.current_thread() is not threading.main_thread():
            return self  # Python handles signals in the main thread alone
        for name in _SIGNALS:
            number = getattr(signal, name, None)
            # None stands for a handler that is not Python's, and could not be put back.
            if number is None or signal.getsignal(number) in (None, signal.SIG_IGN):
                continue
            self._before[number] = signal.signal(number, self._handle)
        return self

    def _handle(self, number: int, _frame: FrameType | None) -> None:
        self.came.append(number)
        if self.interrupts:
            self.interrupts = False
            raise KeyboardInterrupt

    def __exit__(
        self,
        _kind: type[BaseException] | None,
        _error: BaseException | None,
        _traceback: TracebackType | None,
    ) -> None:
        for number, handler in self._before.items():
            signal.signal(number, handler)
        for number in dict.fromkeys(self.came):
            if self._before[number] is not signal.default_int_handler:
                signal.raise_signal(number)
