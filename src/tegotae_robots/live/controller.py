"""A controller as native code, in a file and stepped from Python: measurements in, commands out,
microseconds between."""

from __future__ import annotations

import math
import reprlib
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
from numpy.typing import ArrayLike

from lanewise.machine import NativeStep, load_step, sealed, unsealed
from lanewise.nodes import LanewiseError
from tegotae._support.errors import TegotaeError, is_of, require_finite
from tegotae._support.files import write_atomically
from tegotae._support.limits import MOST_RAD_PER_S, MOST_STEP_S

_FORMAT, _VERSION = b"tegotae native controller ", b"3\n"
_MOST = float(np.finfo(np.float32).max)
"""Largest value of a measurement, in its units."""


@dataclass(frozen=True, kw_only=True)
class NativeController:
    """A compiled controller: its code, and the data that its caller needs.

    Args:
        name: of the controller; None if it has none.
        senses: the signals that a step takes.
        commands: what it commands, limb by limb.
        limbs: how many limbs there are.
        omega_rad_per_s: ω [rad/s]; None without an oscillator.
        phase_entry: the entry of the state that is the phase; None if no single one is.
        start: the state at the release, by entry, as nested lists of numbers.
        code: of a step, from `FunctionKernel.to_bytes`.
        feet_m: places of the feet of a robot that takes commands, forward and to the left of the
            trunk's origin [m], [limbs, 2]; empty without commands.
    """

    name: str | None
    senses: tuple[str, ...]
    commands: tuple[str, ...]
    limbs: int
    omega_rad_per_s: float | None
    phase_entry: str | None
    start: dict[str, Any]
    code: bytes
    feet_m: tuple[tuple[float, float], ...] = ()

    def step(self) -> NativeStep:
        """Load the code into this process.

        Raises:
            TegotaeError: for code that was altered, or is of another kind of processor.
        """
        try:
            return load_step(self.code)
        except LanewiseError as error:
            raise TegotaeError(str(error)) from None


def write_native(native: NativeController, path: Path) -> None:
    """Write a compiled controller: its description, and the whole of it with a checksum.

    Raises:
        TegotaeError: if it cannot be written.
    """
    write_atomically(path, _FORMAT + _VERSION + sealed(msgspec.msgpack.encode(native)))


def read_native(path: Path | str) -> NativeController:
    """Read a compiled controller.

    Its code runs as it is: load files from whom you trust.

    Raises:
        TegotaeError: for a file that is damaged, of another version, or none of these.
    """
    try:
        content = Path(path).read_bytes()
    except OSError as error:
        raise TegotaeError(f"cannot read {path}: {error.strerror}") from None
    if not content.startswith(_FORMAT + _VERSION):
        raise TegotaeError(
            f"{path} is damaged, of another version, or no native controller; write one: "
            f"tegotae export native NAME --out {path}"
        )
    try:
        document = unsealed(content.removeprefix(_FORMAT + _VERSION))
    except LanewiseError as error:
        raise TegotaeError(f"{path}: {error}") from None
    return msgspec.msgpack.decode(document, type=NativeController)


class LiveController:
    """A saved controller as native code, with the state of its oscillators.

    A step first moves the oscillators on by φ̇ = ω + f, with the feedback f of the step before and
    for the time since; then evaluates terms and actuation on the measurements. Hold the command
    until the next step. At equal steps these are the numbers of the `Hold` integrator.

    A step takes a few microseconds, and no JAX. Make one from a file (`load`), or from any name of
    a controller by `tegotae.robots.export_native(NAME).live()`. A copy (`copy.copy`,
    `copy.deepcopy`, pickle) goes on by itself from where this one is.

    Args:
        native: the compiled controller.
        clock: the time [s] if `step` gets no duration; any origin.

    Example:
        >>> import tegotae
        >>> live = tegotae.robots.export_native("V-reflex-w8").live()
        >>> live.step({"spring_force": 0.0}, dt_s=0.001).tolist()
        [0.0]
    """

    def __init__(
        self, native: NativeController, *, clock: Callable[[], float] = time.monotonic
    ) -> None:
        self._native = native
        self._clock = clock
        self._commanded: dict[str, np.ndarray | float] = {}
        self.senses = native.senses
        """The signals that a step takes."""
        self.commands = native.commands
        """Names of the commands of a step, limb by limb, such as a force [N]."""
        self.limbs = native.limbs
        """Number of limbs."""
        self._step = native.step()
        inputs, outputs = self._step.inputs, self._step.outputs
        self._signals = tuple(
            (name, np.zeros(native.limbs), inputs[f"signals.{name}"].reshape(-1))
            for name in native.senses
        )
        self._elapsed_s, self._omega = inputs["elapsed_s"], inputs["omega"]
        self._finite, self._command = outputs["finite"], outputs["command"][..., 0]
        if len(native.commands) == 1:
            self._command = self._command[0]
        self._phase, self._feedback = (
            outputs[name][:, 0] for name in ("phase_rad", "feedback_rad_per_s")
        )
        self.omega_rad_per_s = native.omega_rad_per_s
        if native.feet_m:
            self.command()
        self.reset()

    @classmethod
    def load(
        cls, path: Path | str, *, clock: Callable[[], float] = time.monotonic
    ) -> LiveController:
        """Load the controller of a file of `tegotae export native`, at once and without JAX.

        Args:
            path: the file.
            clock: the time [s].

        Raises:
            TegotaeError: for a file that cannot be read, or is no whole one of these.
        """
        return cls(read_native(path), clock=clock)

    def __getstate__(self) -> dict[str, Any]:
        attributes = {name: vars(self)[name] for name in _KEPT}
        return attributes | {"memory": self._step.buffers()}

    def __setstate__(self, state: dict[str, Any]) -> None:
        LiveController.__init__(self, state["_native"], clock=state["_clock"])
        self._step.restore(state.pop("memory"))
        vars(self).update(state)

    def reset(self, phase_rad: ArrayLike | None = None) -> None:
        """Put the oscillators where they start; the next step begins there.

        Args:
            phase_rad: their phases [rad], one for all or one a limb, of a phase oscillator; those
                of the controller's release by default.

        Raises:
            TegotaeError: for phases that are not finite, of another number, or of an oscillator
                whose state is not its phase.
        """
        start = dict(self._native.start)
        if phase_rad is not None:
            phase = self._phases(phase_rad)
            if self._native.phase_entry is None:
                raise TegotaeError(
                    "the controller has no phase oscillator, whose phase alone says where it is; "
                    "reset it without phase_rad"
                )
            entry = self._step.state[self._native.phase_entry]
            start[self._native.phase_entry] = phase.reshape((-1, 1)[: entry.ndim])
        self._step.reset(**start)
        self._last_s: float | None = None
        self._began = False
        self.steps = 0
        """Steps since the last reset."""

    def command(
        self,
        forward_m_per_s: float = 0.0,
        left_m_per_s: float = 0.0,
        yaw_rate_rad_per_s: float = 0.0,
        heading_error_rad: float = 0.0,
    ) -> None:
        """Command a robot on legs from the next step on; it stops before the first command.

        The senses `commanded_x`, `commanded_y` and `commanded_speed` then need no measurement.

        Args:
            forward_m_per_s: forward; backward below zero.
            left_m_per_s: to the left.
            yaw_rate_rad_per_s: turning to the left.
            heading_error_rad: how far a heading is to the left of the robot's own, to which it
                turns, too.

        Raises:
            TegotaeError: for a controller without commands, or what is no finite number.
        """
        if not self._native.feet_m:
            raise TegotaeError(
                "the controller takes no command; export one that does, such as raibert"
            )
        numbers = {name: x for name, x in locals().items() if name != "self"}
        for name, number in numbers.items():
            require_finite(name, number)
        ahead, beside = np.array(self._native.feet_m).T
        towards = math.remainder(heading_error_rad, 2.0 * math.pi)
        turning = yaw_rate_rad_per_s + min(max(2.0 * towards, -1.0), 1.0)
        x = forward_m_per_s - turning * beside
        y = left_m_per_s + turning * ahead
        speed = float(np.hypot(x, y).max())
        self._commanded = {"commanded_x": x, "commanded_y": y, "commanded_speed": speed}

    def step(self, measurements: Mapping[str, ArrayLike], dt_s: float | None = None) -> np.ndarray:
        """Return the command until the next step.

        Args:
            measurements: of each signal in `senses` a number or an array [limbs], in the units of
                the body's senses; others are ignored.
            dt_s: time since the last step [s], an hour at most; by the clock if None. Of the first
                step after a reset it does not matter.

        Returns:
            The command of each limb, [limbs], or [commands, limbs] if there are several
            (`commands`). It is a view: the next step overwrites it.

        Raises:
            TegotaeError: for a signal that is missing or no finite number, a time out of range, or
                numbers so large that the command or the oscillators would not be finite. All then
                stands as before.
        """
        if dt_s is None:
            time_s = self._clock()
            dt_s = 0.0 if self._last_s is None else time_s - self._last_s
        else:
            time_s = self._last_s
        if type(dt_s) is not float or not 0.0 <= dt_s <= MOST_STEP_S:
            require_finite("dt_s", dt_s, least=0.0, most=MOST_STEP_S)
        for name, key, array in self._signals:
            try:
                key[:] = self._commanded[name] if name in self._commanded else measurements[name]
            except KeyError:
                raise TegotaeError(
                    f"the measurements lack {name!r}; the controller reads "
                    f"{', '.join(self.senses)}, and was given "
                    f"{', '.join(map(str, measurements)) or 'nothing'}"
                ) from None
            except (TypeError, ValueError, OverflowError):
                raise self._no_measurement(name, measurements) from None
            if not all(abs(x) <= _MOST for x in key.tolist()):  # NaN is not, either
                raise self._no_measurement(name, measurements)
            array[:] = key
        self._elapsed_s[...] = dt_s if self._began else 0.0
        self._step()
        if not self._finite:
            raise TegotaeError(
                f"step {self.steps} gives numbers that are not finite, {dt_s:g} s after the last "
                f"one, of {reprlib.repr(measurements)}; the measurements are too large"
            )
        self._began, self._last_s = True, time_s
        self.steps += 1
        return self._command

    def _no_measurement(self, name: str, measurements: Mapping[str, ArrayLike]) -> TegotaeError:
        """Return the error for a value that is no measurement of a signal."""
        if not is_of(measurements, Mapping):
            return TegotaeError(
                f"the measurements are {reprlib.repr(measurements)}; they must be numbers by name, "
                f"such as {dict.fromkeys(self.senses, 0.0)}"
            )
        return TegotaeError(
            f"{name} is {reprlib.repr(measurements[name])} at step {self.steps}; it must be a "
            f"finite number or one for each of {self.limbs} limbs"
        )

    def _phases(self, phase_rad: ArrayLike) -> np.ndarray:
        """Return the phases given to `reset`, checked."""
        try:
            phase = np.asarray(phase_rad, float)
        except (TypeError, ValueError, OverflowError):
            phase = np.full(1, np.nan)
        if not (abs(phase) <= _MOST).all() or phase.size not in (1, self.limbs):
            raise TegotaeError(
                f"phase_rad is {reprlib.repr(phase_rad)}; it must be one finite number or one for "
                f"each of {self.limbs} limbs"
            )
        return phase

    @property
    def phase_rad(self) -> np.ndarray:
        """Phases at the last step [rad], [limbs]; zero without an oscillator that has one."""
        return self._phase.copy()

    @property
    def feedback_rad_per_s(self) -> np.ndarray:
        """Feedback of the last step [rad/s], [limbs]."""
        return self._feedback.copy()

    @property
    def omega_rad_per_s(self) -> float | None:
        """The frequency ω [rad/s], which may be set between steps; None without an oscillator."""
        return self._omega_rad_per_s

    @omega_rad_per_s.setter
    def omega_rad_per_s(self, value: float | None) -> None:
        if (value is None) != (self._native.omega_rad_per_s is None):
            has = "no" if self._native.omega_rad_per_s is None else "an"
            raise TegotaeError(
                f"omega_rad_per_s is {value}, and the controller has {has} oscillator"
            )
        if value is not None:
            require_finite("omega_rad_per_s", value, above=0.0, most=MOST_RAD_PER_S)
            value = float(value)
        self._omega_rad_per_s = value
        self._omega[...] = 0.0 if value is None else value


_KEPT = ("_native", "_clock", "_commanded", "_omega_rad_per_s", "_last_s", "_began", "steps")
"""Attributes that a copy takes over beside the memory of the code."""
