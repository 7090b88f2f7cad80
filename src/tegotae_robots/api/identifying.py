"""From a log to a body: the numbers of a one-legged hopper, fitted to its recording."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

import pandas as pd

from tegotae._support.errors import require_finite
from tegotae._support.files import write_atomically
from tegotae.api.measuring import check_recording
from tegotae.api.parameters import check_types
from tegotae.api.results import TomlFile
from tegotae.measures.recordings import read_recording
from tegotae.parts.bodies import Hopper, Sensors
from tegotae.systems.parts_by_name import body_text
from tegotae_robots.identification import FITTED, Identified, identify as fitted_to, log_of

_MEANINGS = dict(
    zip(
        FITTED,
        ("mass", "stiffness", "damping", "rest length", "largest force", "sensor delay"),
        strict=True,
    )
)
_SIMULATED_TICK_S = 0.001
_NEEDED = ("height", "spring_force", "command")


def _body_of(fit: Identified, gravity_m_per_s2: float) -> Sensors:
    """Return the hopper of a fit; values that noise pushes below zero are set to zero."""
    numbers = {name: float(f"{max(x, 0.0):.6g}") for name, x in fit.values.items()}
    delay_s = numbers.pop("delay_s")
    ticks = max(Sensors().most_ticks, math.ceil(delay_s / _SIMULATED_TICK_S) + 1)
    hopper = Hopper(gravity_m_per_s2=gravity_m_per_s2, **numbers)
    return Sensors(body=hopper, delay_s=delay_s, most_ticks=ticks)


@check_types
def identify(
    file: str | Path,
    *,
    columns: Sequence[str] = (),
    rate: float | None = None,
    resample: float | None = None,
    gravity_m_per_s2: float = Hopper.gravity_m_per_s2,
) -> TomlFile:
    """Fit mass, stiffness, damping, rest length, delay and force limit of a hopper to its log.

    The last fifth of the hops is not fitted and checks the prediction. The body is a name for
    --body from then on. Column names end in their units: time_s (or ms, us, ns), height_m (cm, mm)
    over level ground, spring_force_n (kN, mN, MN, kgf, gf, or kg and g for these), and
    command_share (or percent), the command of the actuator as a share of its largest force.

    Args:
        file: the log, FILE.csv, FILE.npz or FILE.parquet.
        columns: columns with other names: QUANTITY=COLUMN[UNIT], such as command=pwm[percent]. The
            quantities are time, height, spring_force and command.
        rate: sampling rate [Hz], if there is no column of times.
        resample: rate for resampling by linear interpolation [Hz], if times are not uniform.
        gravity_m_per_s2: gravity g [m/s²], which is not fitted.

    Raises:
        TegotaeError: for a file that is no log, or too few hops.

    Example:
        >>> identify("log.csv").save("log.toml")  # doctest: +SKIP
    """
    check_recording(file)
    require_finite("gravity_m_per_s2", gravity_m_per_s2, above=0.0, most=1e9)
    samples = read_recording(
        file,
        columns,
        rate_hz=rate,
        resample_hz=resample,
        quantities=("time", *_NEEDED),
        needed=_NEEDED,
    )
    fit = fitted_to(log_of(samples), gravity_m_per_s2)
    body = _body_of(fit, gravity_m_per_s2)
    numbers = pd.DataFrame(
        [(_MEANINGS[n], fit.values[n], fit.low[n], fit.high[n], FITTED[n]) for n in FITTED],
        columns=["number", "value", "low", "high", "unit"],
    )
    rows = pd.DataFrame(
        {
            "number": numbers.number,
            "value": [
                f"{x:.4g} {unit}" for x, unit in zip(numbers.value, numbers.unit, strict=True)
            ],
            "95 % interval": [
                f"{a:.4g} to {b:.4g}"
                for a, b in zip(fit.low.values(), fit.high.values(), strict=True)
            ],
        }
    )
    checked = fit.prediction.set_index("hops ahead").map(lambda x: f"{x:.2f}")
    omega = float(f"{fit.values['stiffness_n_per_m'] / fit.values['mass_kg']:.6g}") ** 0.5
    height = 1.2 * fit.values["rest_length_m"]
    reasons = {
        name: f"{unit}, 95 %: {fit.low[name]:.4g} to {fit.high[name]:.4g}"
        for name, unit in FITTED.items()
    }

    return TomlFile(
        raw=fit,
        write=lambda path: write_atomically(path, body_text(body, reasons)),
        title=f"fitted to {fit.hops[0]} hops; {fit.hops[1]} others check the prediction",
        rows=numbers,
        views=[rows.set_index("number"), checked],
        notes=[
            f"Noise of the height {fit.noise[0]:.3g} m, of the load {fit.noise[1]:.3g} N. A "
            "prediction is as good as the noise allows where its error is 1.",
            "Next, at a frequency ω near that of stance:",
            f"tegotae train ART-rF-tphif-w{omega:.0f} --body FILE.toml --height-m {height:.3g}",
        ],
        data={
            "values": fit.values,
            "low": fit.low,
            "high": fit.high,
            "noise_height_m": fit.noise[0],
            "noise_load_n": fit.noise[1],
            "prediction": fit.prediction.to_dict("records"),
        },
    )
