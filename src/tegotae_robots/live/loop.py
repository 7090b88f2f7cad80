"""The loop of a robot: in time, safe at every end, recorded."""

from __future__ import annotations

import io
import math
import reprlib
import signal
import threading
import time
import zipfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import FrameType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from tegotae._support.errors import TegotaeError, is_of, require_finite
from tegotae._support.files import output_file, write_atomically
from tegotae._support.limits import require_memory
from tegotae_robots.live.controller import LiveController

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

    def __exit__(self, *_: object) -> None:
        for number, handler in self._before.items():
            signal.signal(number, handler)
        for number in dict.fromkeys(self.came):
            if self._before[number] is not signal.default_int_handler:
                signal.raise_signal(number)


Read = Callable[[], Mapping[str, ArrayLike]]
Write = Callable[[np.ndarray], None]

_SPIN_S = 0.0002
"""The rest of a period that is waited for awake [s]: sleep alone wakes some 50 µs late."""

_LONGEST_NAME = 100
"""Longest name of a measurement [characters]."""


@dataclass(frozen=True)
class LoopReport:
    """The outcome of a loop.

    Args:
        ticks: steps that were taken.
        late_s: how late each began after its time [s], [ticks].
        busy_s: how long read, step and write took together [s], [ticks].
        stopped: why it ended: "duration", "watchdog", or "interrupted" by a signal.
    """

    ticks: int
    late_s: np.ndarray
    busy_s: np.ndarray
    stopped: str

    def __str__(self) -> str:
        def line(name: str, x: np.ndarray) -> str:
            quantiles = np.quantile(1e6 * x, (0.5, 0.99, 0.999, 1.0)) if len(x) else [np.nan] * 4
            return f"{name:6}" + "".join(f"{value:10.1f}" for value in quantiles)

        head = f"{self.ticks} steps; [µs]" + "".join(
            f"{name:>10}" for name in ("median", "99 %", "99.9 %", "most")
        )
        return "\n".join((head, line("late", self.late_s), line("busy", self.busy_s)))


def drive_hardware(
    live: LiveController,
    read: Read,
    write: Write,
    *,
    rate_hz: float = 1000.0,
    duration_s: float,
    safe: np.ndarray | float = 0.0,
    watchdog_s: float = 0.05,
    recording: Path | str | None = None,
) -> LoopReport:
    """Run a controller on hardware: every period read, step, write.

    However it ends, by its duration, by Ctrl-C, by SIGTERM or SIGHUP, by an error of `read` or by
    the watchdog, the last command is the safe one, and the recording is written. In the main thread
    no further signal interrupts this. SIGTERM and SIGHUP then have their usual effect.

    Args:
        live: the controller; the oscillators advance by the time that really passed.
        read: gives measurements: the controller's senses, and whatever else is to be recorded,
            such as `height_m`; numbers or arrays [limbs].
        write: takes a command: [limbs], or [commands, limbs].
        rate_hz: periods a second; a period that is missed is left out, not made up for.
        duration_s: for how long [s].
        safe: the command that does no harm, such as no force; of the command's shape or one number.
        watchdog_s: if no period ends for so long [s], the safe command is written from another
            thread, and the loop ends.
        recording: a .npz file for `tegotae measure`: `time_s`, what was read, `phase_rad`,
            `feedback_rad_per_s` and the commands, `_0`, `_1`, ... of several limbs.

    Raises:
        TegotaeError: before anything is read, for a rate, a duration or a watchdog out of range, a
            safe command that is none, or a recording that exists or cannot be written; before the
            first command, for measurements of the wrong type or shape, or by a name of the loop's
            own.

    Example:
        A page of the documentation drives a simulated leg: `docs/deploy/live.md`.
    """
    require_finite("rate_hz", rate_hz, above=0.0, most=1e5)
    require_finite("duration_s", duration_s, above=0.0, most=86400.0)
    require_finite("watchdog_s", watchdog_s, above=1.0 / rate_hz, most=60.0)
    path = None if recording is None else new_recording(recording)
    loop = _Loop(live, read, write, safe, rate_hz, max(1, round(duration_s * rate_hz)))
    with Endings() as endings:
        try:
            return loop.run(watchdog_s, endings)
        finally:
            if path is not None and loop.done:
                write_atomically(path, _npz(loop.columns()))


def new_recording(path: Path | str) -> Path:
    """Return the path of a new recording, for a program that checks it before anything else.

    Raises:
        TegotaeError: if it exists, cannot be written, or is no .npz.

    Example:
        >>> recording = new_recording("run.npz")
    """
    path = Path(path)
    if path.suffix != ".npz":
        raise TegotaeError(f"recording is {path}; its name must end in .npz")
    if output_file(path).exists():
        raise TegotaeError(f"{path} exists; choose another name, or move that recording")
    return path


def _npz(columns: Mapping[str, np.ndarray]) -> bytes:
    """Return the bytes of an .npz file; `numpy.savez` refuses names that are its own arguments."""
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        for name, column in columns.items():
            with archive.open(f"{name}.npy", "w", force_zip64=True) as entry:
                np.lib.format.write_array(entry, column, allow_pickle=False)
    return stream.getvalue()


class _Loop:
    """A loop under way, with all memory that it will need."""

    def __init__(
        self,
        live: LiveController,
        read: Read,
        write: Write,
        safe: np.ndarray | float,
        rate_hz: float,
        ticks: int,
    ) -> None:
        self._live, self._read, self._write = live, read, write
        several = len(live.commands) > 1
        shape = (len(live.commands), live.limbs) if several else (live.limbs,)
        self._safe = _safe_command(safe, shape)
        self._period_s, self._ticks = 1.0 / rate_hz, ticks
        numbers = 3 + 2 * live.limbs + len(live.commands) * live.limbs + len(live.senses)
        require_memory(8.0 * numbers * ticks, f"a loop of {ticks} periods")
        self.done = 0
        self._time_s, self._late_s, self._busy_s = np.zeros((3, ticks))
        self._read_columns: dict[str, np.ndarray] = {}
        commands = ("force_n",) if live.commands == ("force",) else live.commands
        self._own_names = ("time_s", "phase_rad", "feedback_rad_per_s", *commands)
        self._taken = set(self._own_names)
        for name in self._own_names[1:]:
            self._taken.update(_column_names(name, live.limbs))
        self._own = np.zeros((ticks, 2, live.limbs), np.float32)
        self._commands = np.zeros((ticks, *shape), np.float32)
        self._beat = time.perf_counter()
        self._ended = threading.Event()
        self._bitten = False

    def run(self, watchdog_s: float, endings: Endings) -> LoopReport:
        guard = threading.Thread(target=self._guard, args=(watchdog_s,), daemon=True)
        stopped = "duration"
        self._beat = time.perf_counter()
        guard.start()
        try:
            try:
                endings.interrupts = True
                self._go(endings)
            finally:
                endings.interrupts = False
        except KeyboardInterrupt:
            stopped = "interrupted"
        finally:
            self._ended.set()
            guard.join()
            self._write(self._safe)
        stopped = "watchdog" if self._bitten else "interrupted" if endings.came else stopped
        n = self.done
        return LoopReport(n, self._late_s[:n].copy(), self._busy_s[:n].copy(), stopped)

    def _go(self, endings: Endings) -> None:
        live, clock = self._live, time.perf_counter
        begun = clock()
        due = last = begun
        end = begun + self._ticks * self._period_s
        while due < end - 0.5 * self._period_s and not (self._bitten or endings.came):
            begun_s = _wait_until(due)
            measured = self._read()
            self._keep(measured)
            command = live.step(measured, begun_s - last if self.done else 0.0)
            if self._bitten or endings.came:
                return
            self._write(command)
            index, last = self.done, begun_s
            self._time_s[index], self._late_s[index] = begun_s - begun, begun_s - due
            self._own[index, 0], self._own[index, 1] = live.phase_rad, live.feedback_rad_per_s
            self._commands[index] = command
            self.done += 1
            self._beat = ended_s = clock()
            self._busy_s[index] = ended_s - begun_s
            due += self._period_s
            if ended_s > due:  # periods that are over by now
                due += self._period_s * ((ended_s - due) // self._period_s + 1.0)

    def _keep(self, measured: Mapping[str, ArrayLike]) -> None:
        """Record the readings before they command anything."""
        if not is_of(measured, Mapping):
            raise TegotaeError(
                f"read gave {reprlib.repr(measured)}; it must give measurements by name, such as "
                f"{dict.fromkeys(self._live.senses, 0.0)}"
            )
        for name, value in measured.items():
            if name not in self._read_columns:
                self._read_columns[name] = self._column(name, value)
            column = self._read_columns[name]
            try:
                column[self.done] = value
            except (TypeError, ValueError, OverflowError):
                raise TegotaeError(
                    f"read gave {reprlib.repr(value)} for {name!r} at step {self.done}, and "
                    f"{'an array' if column.ndim > 1 else 'a number'} before"
                ) from None

    def _column(self, name: str, value: ArrayLike) -> np.ndarray:
        """Return memory for the values that are read under a name."""
        try:
            shape = np.asarray(value, float).shape
        except (TypeError, ValueError, OverflowError):
            shape = None
        if shape not in ((), (1,), (self._live.limbs,)):
            raise TegotaeError(
                f"read gave {reprlib.repr(value)} for {name!r}; it must be a number or one for "
                f"each of {self._live.limbs} limbs"
            )
        names = _column_names(name, math.prod(shape))
        if not _is_name(name) or not self._taken.isdisjoint((name, *names)):
            raise TegotaeError(
                f"read gave a measurement named {reprlib.repr(name)}; it must be a printable text "
                f"of at most {_LONGEST_NAME} characters, and none of the names that are recorded "
                f"already: {', '.join(sorted(self._taken))}"
            )
        self._taken |= {name, *names}
        return np.full((self._ticks, *shape), np.nan)

    def _guard(self, watchdog_s: float) -> None:
        while not self._ended.wait(0.25 * watchdog_s):
            if time.perf_counter() - self._beat > watchdog_s:
                self._bitten = True
                self._write(self._safe)
                return

    def columns(self) -> dict[str, np.ndarray]:
        """Return the recording, one column per number."""
        n = self.done
        commands = self._commands[:n].reshape(n, -1, self._live.limbs).swapaxes(0, 1)
        measured = (self._time_s[:n], self._own[:n, 0], self._own[:n, 1], *commands)
        arrays = dict(zip(self._own_names, measured, strict=True))
        arrays |= {name: x[:n] for name, x in self._read_columns.items()}
        columns: dict[str, np.ndarray] = {}
        for name, array in arrays.items():
            column = array.reshape(n, -1).T
            columns |= zip(_column_names(name, len(column)), column, strict=True)
        return columns


def _column_names(name: str, count: int) -> tuple[str, ...]:
    """Return the columns of so many numbers that are recorded under a name."""
    return (name,) if count == 1 else tuple(f"{name}_{i}" for i in range(count))


def _is_name(name: object) -> bool:
    """Return True if an archive can have an entry of this name."""
    return isinstance(name, str) and name.isprintable() and 0 < len(name) <= _LONGEST_NAME


def _safe_command(safe: np.ndarray | float, shape: tuple[int, ...]) -> np.ndarray:
    """Return the safe command of every limb.

    Raises:
        TegotaeError: unless it is finite numbers of the command's shape.
    """
    try:
        with np.errstate(over="ignore"):  # what is infinite in float32 is refused below
            command = np.broadcast_to(np.asarray(safe, float), shape).astype(np.float32)
    except (TypeError, ValueError, OverflowError):
        command = np.full(shape, np.nan)
    if not np.isfinite(command).all():
        raise TegotaeError(
            f"safe is {reprlib.repr(safe)}; it must be a finite number, or an array of such of the "
            f"command's shape {shape}"
        )
    return command


def _wait_until(due: float) -> float:
    """Wait until a time, first asleep and then awake, and return the time after it."""
    while True:
        remaining_s = due - time.perf_counter()
        if remaining_s <= 0.0:
            return time.perf_counter()
        if remaining_s > _SPIN_S:
            time.sleep(remaining_s - _SPIN_S)
