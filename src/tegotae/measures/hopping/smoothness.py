"""How smoothly a controller actuates."""

from __future__ import annotations

import jax
import jax.numpy as jnp

from tegotae._support.errors import TegotaeError
from tegotae.parts._shapes import AnyArray, Numeric

FORCE_PERIOD_S = 0.02
"""The actuator force is averaged over this time [s] before its rate of change is taken."""


def require_measurable(tick_s: float) -> None:
    """Raise `TegotaeError` for a control period by which hops cannot be measured.

    Records are of whole control periods, and the mean force of each 20 ms is one of its metrics.
    """
    ratio = FORCE_PERIOD_S / tick_s
    if round(ratio) < 1 or abs(ratio - round(ratio)) > 1e-6:
        raise TegotaeError(
            f"the control period is {tick_s:g} s; hops are measured with those of which "
            f"{FORCE_PERIOD_S:g} s is a whole multiple, such as 0.001, 0.002, 0.0025, 0.004, "
            "0.005, 0.01 and 0.02"
        )


def smoothness(
    impulse_ns: AnyArray, max_force_n: Numeric, frame_s: float, start_s: Numeric
) -> jax.Array:
    """Root-mean-square rate of change of the actuator force over its largest value [1/s].

        smoothness = rms( (F̄_{j+1} - F̄_j) / Δt ) / α,    Δt = 20 ms,

    where F̄_j is the mean force over the j-th 20 ms. The mean makes a force that jumps measurable,
    and the result independent of how finely the force was recorded. The smaller, the smoother.

    Args:
        impulse_ns: running total of ∫ F_a dt [N s] at the end of each frame, [frames, lanes].
        max_force_n: largest force α [N].
        frame_s: recording period [s], of which 20 ms is a whole multiple.
        start_s: only later changes count [s]; a number or [lanes].

    Raises:
        TegotaeError: for a recording period of which 20 ms is no multiple.

    Example:
        >>> import numpy as np
        >>> force = 4.0 * np.arange(50)[:, None] / 50  # 0 to 4 N within a second
        >>> f"{float(smoothness(np.cumsum(0.02 * force, axis=0), 4.0, 0.02, 0.0)[0]):.3f}"
        '1.000'
    """
    ratio = FORCE_PERIOD_S / frame_s
    if round(ratio) < 1 or abs(ratio - round(ratio)) > 1e-6:
        raise TegotaeError(
            f"frame_s is {frame_s:g}; the smoothness of actuation needs a recording period "
            f"of which {FORCE_PERIOD_S:g} s is a whole multiple"
        )
    total = jnp.asarray(impulse_ns)[round(ratio) - 1 :: round(ratio)]
    rate = jnp.diff(total, 2, axis=0) / FORCE_PERIOD_S**2
    # The j-th change is that from the (j+1)-th mean force to the next.
    begins = FORCE_PERIOD_S * jnp.arange(1, len(rate) + 1, dtype=rate.dtype)
    counts = begins[:, None] >= jnp.asarray(start_s, rate.dtype).reshape(1, -1)
    number = jnp.sum(counts, axis=0).astype(rate.dtype)
    mean_square = jnp.sum(jnp.where(counts, rate**2, 0.0), axis=0) / number
    return jnp.sqrt(mean_square) / max_force_n
