"""Measuring a recording of a robot or of another simulator."""

from __future__ import annotations

import math
import reprlib
from collections.abc import Mapping, Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import pandas as pd

from tegotae._support.errors import TegotaeError, require_finite
from tegotae.api.controller import Changes, Work
from tegotae.api.parameters import check_types, filled
from tegotae.api.results import UNDEFINED, MatplotlibFigure, Table
from tegotae.measures.hopping.gait import Measured, measure as measured_of
from tegotae.measures.hopping.hopping import LimitCycle
from tegotae.measures.hopping.metrics import HOPPING, REGIMES
from tegotae.measures.plausibility import check_forces, check_over_ground
from tegotae.measures.recordings import read_recording
from tegotae.parts.bodies import Body, Hopper
from tegotae.systems.parts_by_name import body_called
from tegotae.systems.vanilla import preset as preset_named


def check_recording(file: object) -> None:
    """Raise `TegotaeError` for an object that is no name of a file."""
    if not isinstance(file, str | Path):
        raise TegotaeError(
            f"a recording is called {reprlib.repr(file)}; it must be the name of a file, such as "
            "'log.csv'"
        )


def _known_body(options: Any) -> Body | None:
    """Return the recorded body, if it is named.

    Raises:
        TegotaeError: for an unknown name, or two.
    """
    if options.preset is not None and options.body is not None:
        raise TegotaeError("preset and body both say what the recording is of; name one")
    if options.preset is not None:
        return preset_named(options.preset).hopper
    body = options.body
    return body_called(body) if isinstance(body, str) else body


def _leg_numbers(options: Any, body: Body | None) -> dict[str, float | None]:
    """Return the numbers of the leg: those of the options, or else those of the body.

    Raises:
        TegotaeError: for two that contradict each other.
    """
    numbers: dict[str, float | None] = {}
    for name in ("rest_length_m", "max_force_n", "mass_kg", "gravity_m_per_s2"):
        option: float | None = getattr(options, name)
        value_of_body: Any = getattr(body, name, None)
        if option is not None and value_of_body is not None and option != float(value_of_body):
            source = "body" if options.preset is None else f"preset {options.preset}"
            raise TegotaeError(
                f"{name} is {option:g}, and the {source} has {value_of_body:g}; leave one of them "
                "out"
            )
        numbers[name] = option if value_of_body is None else float(value_of_body)
    if options.gravity_m_per_s2 is not None and numbers["mass_kg"] is None:
        raise TegotaeError("gravity_m_per_s2 belongs to a mass; set mass_kg, too")
    return numbers


def _weight_n(leg: Mapping[str, float | None]) -> float | None:
    """Return the weight of the body [N], if its mass is known."""
    mass, gravity = leg["mass_kg"], leg["gravity_m_per_s2"]
    if mass is None:
        return None
    gravity = Hopper.gravity_m_per_s2 if gravity is None else gravity
    require_finite("mass", mass, above=0.0, most=1e9)
    require_finite("gravity", gravity, above=0.0, most=1e9)
    return mass * gravity


def _result(measured: Measured, rest_length_m: float, weight_n: float | None) -> Table:
    """Return the metrics as a table, with the figure of the recording.

    Args:
        measured: the metrics.
        rest_length_m: rest length of the leg [m].
        weight_n: weight of the body [N], if it is known.
    """
    regime, hops = REGIMES[measured.regime], measured.hops
    # Why there is no limit cycle is said once, not by each metric that needs one.
    reason_of_cycle = measured.reasons.get("limit_cycle_period", "")
    rows = []
    for metric in HOPPING.metrics():
        if metric.name.endswith("_share") and metric.name != "optimum_share":
            continue  # shares of several runs are none of one recording
        reason = measured.reasons.get(metric.name, metric.about)
        value = float(getattr(measured, metric.name, math.nan))
        remark = regime if reason_of_cycle and reason == reason_of_cycle else reason
        rows.append((metric.name, metric.label, value, metric.unit, remark))
    table = pd.DataFrame(rows, columns=["name", "metric", "value", "unit", "about"])
    formatted = [(label, _text(value, unit), remark) for _, label, value, unit, remark in rows]
    heads = ["metric", "value", "what it is, or why it is undefined"]
    metric_table = pd.DataFrame(formatted, columns=heads).set_index("metric")
    notes, efficiency = list(measured.notes), None
    if (cycle := measured.efficiency) is not None:
        scaled = math.nan if weight_n is None else weight_n * cycle.cot_inverse
        efficiency = {**asdict(cycle), "cot_inverse_times_weight": scaled}
        doubt = ", not settled: the value may depend on which hops were recorded"
        weighted = "" if weight_n is None else f" (m g CoT⁻¹ {scaled:.3g})"
        if math.isfinite(cycle.cot_inverse):
            notes.insert(
                0,
                f"from {cycle.start_s:.2f} to {cycle.end_s:.2f} s: climbed "
                f"{cycle.climb_flight_m:.4g} m in flight and {cycle.climb_m:.4g} m in all for "
                f"{cycle.work_j:.4g} J, CoT⁻¹ {cycle.cot_inverse:.4g} m/J{weighted}"
                f"{'' if cycle.settled else doubt}",
            )

    def tables() -> Mapping[str, Any]:
        from tegotae.figures.recording import recording_tables

        return recording_tables(measured)

    def draw() -> dict[str, MatplotlibFigure]:
        from tegotae.figures.recording import recording_figure

        picture = recording_figure(measured, rest_length_m=rest_length_m, note=regime)
        return {"recording": picture}

    values = {name: value for name, _, value, _, _ in rows}
    seconds = float(measured.frames.time_s[-1, 0])
    title = f"{regime}; {len(hops.time_s)} hops in {seconds:.2f} s"
    return Table(
        raw=measured,
        title=f"{title}; {reason_of_cycle}" if reason_of_cycle else title,
        notes=notes,
        rows=table,
        views=[metric_table],
        data={
            "regime": regime,
            **values,
            "reasons": {name: x for name, x in measured.reasons.items() if name in values},
            "notes": measured.notes,
            "efficiency": efficiency,
            "apex_time_s": hops.time_s,
            "apex_height_m": hops.height_m,
            "apex_phase_rad": hops.phase_rad,
        },
        draw=draw,
        figure_tables=tables,
    )


def _text(value: float, unit: str) -> str:
    return UNDEFINED if math.isnan(value) else f"{value:.4g} {unit}".strip()


_LIMIT_CYCLE = LimitCycle()


@check_types
def measure(
    file: str | Path,
    *,
    columns: Sequence[str] = (),
    rate: float | None = None,
    resample: float | None = None,
    lowpass: float | None = None,
    preset: str | None = None,
    body: str | Body | None = None,
    rest_length_m: float | None = None,
    max_force_n: float | None = None,
    mass_kg: float | None = None,
    gravity_m_per_s2: float | None = None,
    omega: float | None = None,
    disturbed_at: float | None = None,
    work: Work = "absolute",
    limit_cycle: LimitCycle | Changes = _LIMIT_CYCLE,
) -> Table:
    """Measure a recorded gait of a robot or simulator: every metric, or why it is undefined.

    Its first sample is the release. Column names end in their units: time_s (or ms, us, ns) and
    height_m (cm, mm) are required; ground_m, phase_rad (deg) and actuator_force_n or force_n (kN,
    mN, MN, kgf, gf, or kg and g for these) are optional. So are running totals, with values before
    each sample: work_j (kJ, mJ, MJ) of the actuators, climb_flight_m of heights climbed in flight,
    climb_m of all heights climbed. Files of `tegotae simulate --csv` fit.

    Args:
        file: the recording, FILE.csv, FILE.npz or FILE.parquet.
        columns: columns with other names: QUANTITY=COLUMN[UNIT], such as height=com_z[mm], or
            height=-z[m] of a column that points down. The quantities are time, height, ground,
            phase, force, work, climb_flight and climb.
        rate: sampling rate [Hz], if there is no column of times.
        resample: rate for resampling by linear interpolation [Hz], if times are not uniform.
        lowpass: cutoff of the zero-phase low-pass filter of the height [Hz]; inf for no filter. By
            default a noisy height is filtered at the cutoff with the least expected error, which is
            printed.
        preset: preset of the recorded hopper, such as paper: gives rest length, largest force and
            mass, and adds the share of the optimum.
        body: recorded body in place of a preset, FILE.toml, FILE.py:OBJECT or MODULE:OBJECT.
        rest_length_m: rest length l0 [m]: the height over ground at liftoff.
        max_force_n: largest actuator force α [N], for the smoothness.
        mass_kg: mass [kg], for the efficiency without a unit, m g CoT⁻¹.
        gravity_m_per_s2: gravity [m/s²], for the same; by default the body's, or Earth's.
        omega: prescribed frequency ω [rad/s], for ΔΩ and Δw.
        disturbed_at: time of a disturbance in the recording [s]; T1 is measured from there.
        work: definition of the actuator's work.
        limit_cycle: definition of a settled gait.

    Raises:
        TegotaeError: for a file that is no recording, or numbers that contradict each other.

    Example:
        >>> measure("walk.csv", rest_length_m=1.0, omega=5.0).plot()  # doctest: +SKIP
    """
    options = filled(locals(), {"limit_cycle": _LIMIT_CYCLE})
    check_recording(file)
    mechanics = _known_body(options)
    leg = _leg_numbers(options, mechanics)
    weight_n, length_m = _weight_n(leg), leg["rest_length_m"]
    if length_m is None:
        raise TegotaeError(
            "the rest length is not given, the height over ground at which the foot leaves it; "
            "set rest_length_m"
        )
    require_finite("rest_length_m", length_m, above=0.0, most=1e9)
    read = read_recording(file, options.columns, rate_hz=options.rate, resample_hz=options.resample)
    doubts = check_over_ground(read, length_m)
    if "force_n" in read:
        limits = {"weight_n": weight_n, "max_force_n": leg["max_force_n"]}
        doubts += check_forces(read["force_n"].to_numpy(), **limits)
    measured = measured_of(
        **read,
        rest_length_m=length_m,
        omega=options.omega,
        max_force_n=leg["max_force_n"],
        disturbed_at_s=options.disturbed_at,
        limit_cycle=options.limit_cycle,
        lowpass_hz=options.lowpass,
        work=options.work,
        body=mechanics,
    )
    result = _result(measured, length_m, weight_n)
    return replace(result, notes=[*doubts, *result.notes])
