"""`tegotae measure`: the metrics of anyone's recording."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import numpy as np
import tyro

from tegotae._support.documents import JsonObject
from tegotae._support.errors import TegotaeError, require_finite
from tegotae._support.progress import note
from tegotae.cli.console import one_line, print_rows, print_text
from tegotae.cli.options import UNSET, WorkOption
from tegotae.measures.hopping import REGIMES, LimitCycle, measure
from tegotae.measures.hopping.measured import Efficiency, Measured
from tegotae.measures.hopping.registry import metrics
from tegotae.measures.recordings import (
    Recording,
    left_alone,
    read_columns,
    recording,
)
from tegotae.parts.bodies import Body, Hopper
from tegotae.systems.presets import preset
from tegotae.systems.user_objects import named

if TYPE_CHECKING:
    from tegotae.measures.hopping.metric import Metric

Given = Annotated[float | None, UNSET]
_FIELDS = {
    "rest_length": "rest_length_m",
    "max_force": "max_force_n",
    "mass": "mass_kg",
    "gravity": "gravity_m_per_s2",
}
"""Options that say what a body's field is."""
_EARTH = f"(default: the body's, or {Hopper.gravity_m_per_s2:g})"


@dataclass(frozen=True, kw_only=True)
class Measure(WorkOption):
    """Measure a recorded gait of a robot or simulator: every metric, or why it is undefined."""

    file: Annotated[Path, tyro.conf.Positional]
    """The recording: .csv, .npz or .parquet. Its first sample is the release. Column names end in
    their units: time_s (or ms, us, ns) and height_m (cm, mm) are required; ground_m, phase_rad
    (deg) and actuator_force_n or force_n (kN, mN, MN) are optional. So are running totals, with
    values before each sample: work_j (kJ, mJ, MJ) of the actuators, climb_flight_m of heights
    climbed in flight, climb_m of all heights climbed. Files of `tegotae simulate --csv` fit."""
    columns: Annotated[tuple[str, ...], UNSET] = ()
    """Columns with other names: QUANTITY=COLUMN[UNIT], such as height=com_z[mm]. The quantities are
    time, height, ground, phase, force, work, climb_flight and climb."""
    rate: Given = None
    """Sampling rate [Hz], if there is no column of times."""
    resample: Given = None
    """Rate for resampling by linear interpolation [Hz], if times are not uniform."""
    lowpass: Given = None
    """Cutoff of the zero-phase low-pass filter of the height [Hz]; inf for no filter. By default a
    noisy height is filtered at the cutoff with the least expected error, which is printed."""
    rest_length: Given = None
    """Rest length l0 [m]: the height over ground at liftoff."""
    omega: Given = None
    """Prescribed frequency ω [rad/s], for ΔΩ and Δw."""
    max_force: Given = None
    """Largest actuator force α [N], for the smoothness."""
    mass: Given = None
    """Mass [kg], for the efficiency without a unit, m g CoT⁻¹."""
    gravity: Annotated[float | None, tyro.conf.arg(help_behavior_hint=_EARTH)] = None
    """Gravity [m/s²], for the same."""
    disturbed_at: Given = None
    """Time of a disturbance in the recording [s]; T1 is measured from there."""
    preset: Annotated[str | None, UNSET] = None
    """Preset of the recorded hopper, such as paper: gives rest length, largest force and mass, and
    adds the share of the optimum."""
    body: Annotated[str | None, UNSET] = None
    """The recorded body in place of a preset, FILE.py:OBJECT or MODULE:OBJECT."""
    height_tolerance: float = LimitCycle().height_tolerance_m
    """Tolerance for the apex heights of a limit cycle [m]."""
    phase_tolerance: float = LimitCycle().phase_tolerance_rad
    """Tolerance for the phases at the apexes of a limit cycle [rad]."""
    json: bool = False
    """Print one JSON object."""
    plot: Annotated[Path | None, UNSET] = None
    """Draw height, phase, portrait, apexes and spectrum (.png, .pdf, .svg), and write the numbers
    as .csv."""

    def run(self) -> None:
        """Measure, print and draw."""
        if self.plot is not None:
            from tegotae.figures.style import figure_file

            figure_file(self.plot)
        body = self._body()
        weight_n = self._weight_n(body)
        rest_length = self._or_body("rest_length", body)
        if rest_length is None:
            raise TegotaeError(
                "the rest length is not given, the height over ground at which the foot leaves it; "
                "set --rest-length [m]"
            )
        found = measure(
            **self._recording().arguments(),
            rest_length_m=rest_length,
            omega=self.omega,
            max_force_n=self._or_body("max_force", body),
            disturbed_at_s=self.disturbed_at,
            limit_cycle=LimitCycle(
                height_tolerance_m=self.height_tolerance, phase_tolerance_rad=self.phase_tolerance
            ),
            lowpass_hz=self.lowpass,
            work=self.work,
            body=body,
        )
        if self.plot is not None:
            self._draw(found, rest_length)
        if self.json:
            print(json.dumps(_document(found, weight_n)))
        else:
            _print(found, weight_n)

    def _recording(self) -> Recording:
        columns = read_columns(self.file)
        read = recording(columns, self.columns, rate_hz=self.rate)
        for line in left_alone(columns, self.columns):
            note(f"tegotae: {one_line(line)}")
        return read if self.resample is None else read.resampled(self.resample)

    def _body(self) -> Body | None:
        if self.preset is not None and self.body is not None:
            raise TegotaeError("--preset and --body both say what the recording is of; name one")
        if self.preset is not None:
            return preset(self.preset).hopper
        return None if self.body is None else named(self.body, Body, "body")

    def _weight_n(self, body: Body | None) -> float | None:
        mass = self._or_body("mass", body)
        gravity = self._or_body("gravity", body)
        if mass is None:
            if gravity is not None and body is None:
                raise TegotaeError("--gravity belongs to a mass; set --mass [kg], too")
            return None
        require_finite("mass", mass, above=0.0, most=1e9)
        gravity = Hopper.gravity_m_per_s2 if gravity is None else gravity
        require_finite("gravity", gravity, above=0.0, most=1e9)
        return mass * gravity

    def _or_body(self, option: str, body: Body | None) -> float | None:
        """A number as it is given, or else the body's; not two that contradict each other."""
        own = getattr(self, option)
        known = getattr(body, _FIELDS[option], None)
        if own is None:
            return None if known is None else float(known)
        if known is not None and float(known) != own:
            what = "body" if self.preset is None else f"preset {self.preset}"
            raise TegotaeError(
                f"--{option.replace('_', '-')} is {own:g}, and the {what} has {float(known):g}; "
                "leave one of them out"
            )
        return own

    def _draw(self, found: Measured, rest_length_m: float) -> None:
        from tegotae.figures.recording import recording_figure, recording_tables
        from tegotae.figures.style import save_figure, write_tables

        assert self.plot is not None
        note = REGIMES[found.regime]
        save_figure(recording_figure(found, rest_length_m=rest_length_m, note=note), self.plot)
        write_tables(self.plot, recording_tables(found))


def _shown() -> tuple[Metric, ...]:
    """The metrics of one recording: shares of several runs are none."""
    return tuple(metric for metric in metrics() if not metric.name.endswith("_share")
                 or metric.name == "optimum_share")  # fmt: skip


def _print(found: Measured, weight_n: float | None) -> None:
    regime, hops = REGIMES[found.regime], len(found.hops.time_s)
    # Why there is no limit cycle is said once, not by each metric that needs one.
    why = found.reasons.get("limit_cycle_period", "")
    seconds = float(found.frames.time_s[-1, 0])
    print(f"{regime}; {hops} hops in {seconds:.2f} s" + (f"; {why}" if why else ""))
    rows = []
    for metric in _shown():
        value = getattr(found, metric.name, math.nan)
        shown = "–" if math.isnan(value) else f"{value:.4g} {metric.unit}".strip()
        reason = found.reasons.get(metric.name, metric.about)
        rows.append((metric.label, shown, regime if reason == why else reason))
    print_rows(("metric", "value", "what it is, or why it is undefined"), rows)
    if found.efficiency is not None and math.isfinite(found.efficiency.cot_inverse):
        print_text(_efficiency(found.efficiency, weight_n))
    for each in found.notes:
        print_text(each)


def _efficiency(of: Efficiency, weight_n: float | None) -> str:
    scaled = "" if weight_n is None else f" (m g CoT⁻¹ {weight_n * of.cot_inverse:.3g})"
    mark = "" if of.settled else ", not settled: the value may depend on which hops were recorded"
    return (
        f"from {of.start_s:.2f} to {of.end_s:.2f} s: climbed {of.climb_flight_m:.4g} m in flight "
        f"and {of.climb_m:.4g} m in all for {of.work_j:.4g} J, CoT⁻¹ {of.cot_inverse:.4g} "
        f"m/J{scaled}{mark}"
    )


def _document(found: Measured, weight_n: float | None) -> JsonObject:
    """As JSON values: null for what is undefined, with its reason."""
    values = {m.name: _finite(getattr(found, m.name, math.nan)) for m in _shown()}
    of = found.efficiency
    return {
        "regime": REGIMES[found.regime],
        **values,
        "reasons": {name: why for name, why in found.reasons.items() if name in values},
        "notes": list(found.notes),
        "efficiency": None
        if of is None
        else {
            **{name: value if name == "settled" else _finite(value)
               for name, value in vars(of).items()},
            "cot_inverse": _finite(of.cot_inverse),
            "cot_inverse_total": _finite(of.cot_inverse_total),
            "cot_inverse_times_weight": _finite(
                math.nan if weight_n is None else weight_n * of.cot_inverse
            ),
        },
        "apex_time_s": found.hops.time_s.tolist(),
        "apex_height_m": found.hops.height_m.tolist(),
        "apex_phase_rad": found.hops.phase_rad.tolist(),
    }  # fmt: skip


def _finite(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None
