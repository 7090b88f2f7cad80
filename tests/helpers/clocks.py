"""A clock on which waiting takes no time."""

import threading


class Clock:
    """Stands in for `time`: seconds pass by sleeping, and a few microseconds with each look.

    A loop that keeps its time by this clock does the same on any machine, however busy.
    """

    LOOK_S = 2e-5

    def __init__(self) -> None:
        self.now_s = 0.0
        self._one = threading.Lock()  # a loop's watchdog looks from a thread of its own

    def perf_counter(self) -> float:
        self.sleep(self.LOOK_S)
        return self.now_s

    def sleep(self, seconds: float) -> None:
        with self._one:
            self.now_s += seconds
