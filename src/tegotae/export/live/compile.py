"""From a saved controller to its compiled form."""

from __future__ import annotations

import numpy as np

from tegotae.export.live.file import NativeController
from tegotae.export.live.tick import live_tick
from tegotae.parts.oscillators import PhaseOscillator
from tegotae.systems.controller_file import SavedController


def compiled(saved: SavedController, max_force_n: float | None = None) -> NativeController:
    """A saved controller as code for this kind of processor.

    Args:
        saved: the controller.
        max_force_n: the force at full push [N], where the file does not know it.

    Raises:
        TegotaeError: for a largest force that is missing, known already or out of range.
        CannotLower: for an operation that has no native code.
    """
    tick = live_tick(saved.system, np.asarray(saved.weights), max_force_n)
    controller = saved.controller
    by_phase = type(controller.oscillator) is PhaseOscillator
    of_oscillator = [name for name in tick.start if name.startswith("oscillator")]
    return NativeController(
        name=saved.name,
        senses=tick.senses,
        commands=controller.actuation.COMMANDS,
        limbs=controller.limbs,
        omega_rad_per_s=saved.omega,
        phase_entry=of_oscillator[0] if by_phase else None,
        start=tick.start,
        state=tick.kernel.state,
        inputs=tick.kernel.inputs,
        outputs=tick.kernel.outputs,
        code=tick.kernel.object_file(),
    )
