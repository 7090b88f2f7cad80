"""Figures that explain a controller: its cycle, its surface, its basin, its response to pushes.

All take a controller by name or loaded; None stands for the controller's own value.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, Unpack

import numpy as np

from tegotae._support import limits
from tegotae._support.errors import TegotaeError, require_all, require_count, require_finite
from tegotae.analysis.maps import axis, map_basin, sweep_gain
from tegotae.analysis.orbit import (
    NoLimitCycleError,
    Orbit,
    find_orbit,
    release_paths,
    require_hopper,
)
from tegotae.analysis.phase_response import check_pushes, measure_phase_response
from tegotae.analysis.poincare import check_disturbances, poincare_section, transient
from tegotae.analysis.surface import actuation_surface, sees_velocity
from tegotae.api.controller import Changes, Subject
from tegotae.api.controllers import load
from tegotae.api.hopping import HopperController, HopperOptions
from tegotae.api.parameters import HIDDEN, Values, check_types, filled, with_own_values
from tegotae.api.results import Figure, MatplotlibFigure
from tegotae.parts.bodies import Body
from tegotae.simulation.recorder import Trajectory
from tegotae.simulation.rollout import Timing
from tegotae.systems.controller_file import SavedController
from tegotae.systems.system import Release
from tegotae.systems.vanilla import PRESETS

if TYPE_CHECKING:
    from tegotae.envs.policies import Meaning, Policy

__all__ = [
    "basin",
    "learning_curves",
    "phase_locking",
    "phase_response",
    "poincare",
    "portrait",
    "surface",
]
Hopping = Subject | HopperController
"""Controller of a body with one leg, by name or loaded."""


def __dir__() -> list[str]:
    return __all__


def _figure(
    raw: Any,
    draw: Callable[[], MatplotlibFigure],
    tables: Mapping[str, Any],
    options: Any,
    **fields: Any,
) -> Figure:
    """Return a figure with its tables and options."""
    settings = {name: x for name, x in vars(options).items() if name != "controller"}
    if callable(settings.get("policy")):
        settings["policy"] = settings["policy"].__name__
    return Figure(
        raw=raw, draw=lambda: {"figure": draw()}, figure_tables=tables, settings=settings, **fields
    )


def _values(arguments: Mapping[str, Any], others: str = "are simulate, evaluate, gait") -> Any:
    """Return the arguments, with the controller's own values in place of None.

    Args:
        arguments: arguments of the figure's function, the shared ones in `options`.
        others: end of the sentence that names the commands for other bodies.

    Raises:
        TegotaeError: for a controller of another body than one with one leg.
    """
    controller, policy = arguments["controller"], arguments.get("policy")
    defaults = _driver_defaults(controller, policy)
    if policy is None:
        reason = f"this figure is of one leg; for others there {others}"
        controller = load(controller).require(HopperController, reason)
        defaults = {"": controller.name, **controller.defaults(), **defaults}
    return filled({**arguments, "controller": controller}, defaults)


def _titled(driver: SavedController | Policy) -> str:
    """Return a controller or a policy in a few words, for a figure."""
    from tegotae.figures.style import literal_text

    words, omega = [literal_text(driver.name or "controller")], driver.omega
    if isinstance(driver, SavedController) and driver.controller.has_a_gain_alone:
        words.append(f"σ = {driver.weights[0]:.4g}")
    return ", ".join([*words, *([] if omega is None else [f"ω = {omega:g} rad/s"])])


def _driver_defaults(controller: Any = None, policy: Any = None, **_: Any) -> Values:
    """Return values of a policy, and which options a controller or a policy does not have.

    Raises:
        TegotaeError: for a controller beside the policy, or a missing extra.
    """
    if policy is None:
        return {"meaning": HIDDEN}
    if isinstance(controller, HopperController) or controller not in (None, "paper"):
        name = getattr(controller, "name", controller)
        raise TegotaeError(f"{name} is a controller, and policy names a policy; name one")
    ending = Path(str(policy)).suffix.lower()
    extras = {".zip": {"stable_baselines3": "sb3"}, ".onnx": {"onnxruntime": "onnx"}}
    require_all({"gymnasium": "gym", **extras.get(ending, {})})
    from tegotae.envs.policies import Meaning

    meaning = Meaning(omega=PRESETS["paper"].omega_rad_per_s)
    hidden = dict.fromkeys(("omega", "sigma", "body"), HIDDEN)
    return {
        "": getattr(policy, "__name__", policy),
        "meaning": meaning,
        "release": Release(),
    } | hidden


def _driver(values: Any) -> SavedController | Policy:
    """Return the controller with the options, or the policy."""
    if values.policy is None:
        return values.controller.changed(values)
    from tegotae.envs.policies import load_policy

    return load_policy(values.policy, values.meaning)


@with_own_values(_driver_defaults)
def surface(
    controller: Hopping = "paper",
    *,
    velocity_m_per_s: float = 0.0,
    spring_force_n: float | None = None,
    resolution: int = 200,
    settle_s: float = 60.0,
    policy: str | Callable[..., Any] | None = None,
    meaning: Meaning | Changes | None = None,
    **options: Unpack[HopperOptions],
) -> Figure:
    """Draw the actuator force over phase and spring force, with the limit cycle on it (Fig. 5).

    Args:
        controller: controller of a body with one leg.
        velocity_m_per_s: velocity of the slice [m/s], for controllers that sense the velocity.
        spring_force_n: largest spring force [N]; a tenth above the limit cycle's by default.
        resolution: points along either axis.
        settle_s: simulated time before the limit cycle is measured [s].
        policy: a policy in place of a controller: a .zip of Stable-Baselines3, an .onnx file, or
            FILE.py:FUNCTION, a function of some of phase_rad, spring_force_n, velocity_m_per_s and
            height_m. FILE.py runs as code, and other files are read by large libraries: take them
            from people that you trust.
        meaning: what the numbers of the policy mean.

    Raises:
        TegotaeError: for values that cannot be, before anything is computed.

    Example:
        >>> surface("V-reflex-w8", resolution=5).table.columns[0]
        'spring_force_n'
    """
    values = _values(locals())
    from tegotae.figures.cycles import surface_figure, surface_tables

    require_count("resolution", values.resolution, least=2, most=limits.MOST_POINTS)
    limits.require_within("velocity_m_per_s", values.velocity_m_per_s, limits.MOST_M)
    driver = _driver(values)
    body, note = require_hopper(driver.body, "an actuation surface"), _titled(driver)
    shortest_n = body.most_spring_n
    if values.spring_force_n is not None:
        require_finite("spring_force_n", values.spring_force_n, above=0.0, most=shortest_n)
    notes: tuple[str, ...] = ()
    try:
        orbit = _orbit(driver, values)
    except NoLimitCycleError as none:
        orbit, notes = None, (f"{none}; the surface is drawn without it",)
    most_n = values.spring_force_n
    if most_n is None:
        typical_n = 3.0 * body.weight_n if orbit is None else 1.1 * orbit.spring_force_n.max()
        most_n = min(typical_n, shortest_n)
    fastest = 4.0 if orbit is None else 1.1 * float(np.abs(orbit.velocity_m_per_s).max())
    surface = actuation_surface(
        driver,
        np.linspace(0.0, most_n, values.resolution),
        columns=values.resolution,
        velocity_m_per_s=values.velocity_m_per_s,
        velocity_range_m_per_s=(-fastest, fastest),
    )
    if surface.phase_rad is not None and sees_velocity(driver):
        note += f", slice at ẏ = {values.velocity_m_per_s:g} m/s"
    most_force_n = float(body.max_force_n)
    return _figure(
        surface,
        lambda: surface_figure(surface, orbit, max_force_n=most_force_n, note=note),
        surface_tables(surface, orbit),
        values,
        notes=notes,
    )


def _orbit(driver: SavedController | Policy, values: Any) -> Orbit:
    if isinstance(driver, SavedController):
        return find_orbit(driver, settle_s=values.settle_s)
    from tegotae.analysis.policy import measured_policy, policy_orbit

    height = np.array([values.release.height_m])
    paths = _paths(driver, values, height, values.settle_s)
    return policy_orbit(paths, measured_policy(driver, paths))


def _paths(
    driver: SavedController | Policy, values: Any, heights: np.ndarray, duration_s: float
) -> Trajectory:
    if isinstance(driver, SavedController):
        return release_paths(driver, heights, duration_s=duration_s)
    from tegotae.analysis.policy import policy_paths

    phase_rad = values.release.phase_rad
    return policy_paths(driver, heights, phase_rad=phase_rad, duration_s=duration_s)


@with_own_values(_driver_defaults)
def portrait(
    controller: Hopping = "paper",
    *,
    heights: Sequence[float] = (1.05, 1.2, 1.6),
    duration_s: float = 30.0,
    policy: str | Callable[..., Any] | None = None,
    meaning: Meaning | Changes | None = None,
    **options: Unpack[HopperOptions],
) -> Figure:
    """Draw phase portraits of a controller or a policy: (y, ẏ), and spring force over phase.

    Args:
        controller: controller of a body with one leg.
        heights: release heights, at rest [m].
        duration_s: simulated time [s].
        policy: a policy in place of a controller: a .zip of Stable-Baselines3, an .onnx file, or
            FILE.py:FUNCTION, a function of some of phase_rad, spring_force_n, velocity_m_per_s and
            height_m. FILE.py runs as code, and other files are read by large libraries: take them
            from people that you trust.
        meaning: what the numbers of the policy mean.

    Raises:
        TegotaeError: for values that cannot be, before anything is computed.
    """
    values = _values(locals())
    from tegotae.figures.cycles import portrait_figure, portrait_table

    driver = _driver(values)
    rest_length_m = float(require_hopper(driver.body, "a phase portrait").rest_length_m)
    paths = _paths(driver, values, np.array(values.heights), values.duration_s)
    return _figure(
        paths,
        lambda: portrait_figure(paths, rest_length_m=rest_length_m, note=_titled(driver)),
        {"": portrait_table(paths)},
        values,
    )


@check_types
def poincare(
    controller: Hopping = "paper",
    *,
    settle_s: float = 60.0,
    step: float = 1e-4,
    nudge: float = 0.01,
    turns: int = 40,
    **options: Unpack[HopperOptions],
) -> Figure:
    """Draw apexes from the release on, Floquet multipliers, and the decay of a small deviation.

    Args:
        controller: controller of a body with one leg.
        settle_s: simulated time before the limit cycle is measured [s].
        step: step of the finite differences [m, rad].
        nudge: initial deviation from the limit cycle for the observed decay [m].
        turns: number of cycles over which the decay is observed.

    Raises:
        TegotaeError: for values that cannot be, before anything is computed.

    Example:
        >>> poincare("V-reflex-w8", turns=5).raw.hops
        1
    """
    values = _values(locals())
    from tegotae.figures.cycles import poincare_figure, poincare_tables

    check_disturbances(step, nudge, turns)
    saved = values.controller.changed(values)
    orbit = find_orbit(saved, settle_s=settle_s)
    section = poincare_section(saved, orbit, step=step, nudge=nudge, turns=turns)
    apexes = transient(saved, duration_s=settle_s)
    hops = "1 hop" if section.hops == 1 else f"{section.hops} hops"
    return _figure(
        section,
        lambda: poincare_figure(section, apexes, _titled(saved)),
        poincare_tables(section, apexes),
        values,
        title=f"limit cycle of {hops}, {section.period_s:.4f} s",
        notes=section.notes,
        views=[section.summary],
        data={
            "multiplier_modulus": np.abs(section.multipliers),
            "observed_factor": section.observed,
        },
    )


@check_types
def phase_response(
    controller: Hopping = "paper",
    *,
    push: Sequence[float] = (0.005, -0.005),
    points: int = 60,
    cycles: int = 40,
    settle_s: float = 60.0,
    **options: Unpack[HopperOptions],
) -> Figure:
    """Draw the shift of the rhythm by a short push, over the phase of the push in the limit cycle.

    Args:
        controller: controller of a body with one leg.
        push: impulses [N s]; positive ones act upward.
        points: number of points of the limit cycle.
        cycles: number of cycles to wait.
        settle_s: simulated time before the limit cycle is measured [s].

    Raises:
        TegotaeError: for values that cannot be, before anything is computed.
    """
    values = _values(locals())
    from tegotae.figures.cycles import phase_response_figure, phase_response_notes

    saved, pushes = values.controller.changed(values), np.array(push)
    check_pushes(pushes, require_hopper(saved.body, "a push"), points, cycles)
    orbit = find_orbit(saved, settle_s=settle_s)
    response = measure_phase_response(saved, orbit, pushes, points=points, cycles=cycles)
    return _figure(
        response,
        lambda: phase_response_figure(response, _titled(saved)),
        {"": response},
        values,
        notes=phase_response_notes(response),
    )


@check_types
def phase_locking(
    controller: Hopping = "paper",
    *,
    sigma: tuple[float, float] = (0.0, 12.0),
    omega: tuple[float, float] = (2.0, 10.0),
    cut: float = 4.0,
    resolution: int = 100,
    duration_s: float = 40.0,
    body: Body | Changes | None = None,
) -> Figure:
    """Draw the oscillator's turns per hop over gain σ and frequency ω, and both rates along a cut.

    Args:
        controller: controller of a body with one leg.
        sigma: range of the gain σ [rad/(s N)].
        omega: range of the frequency ω [rad/s].
        cut: gain of the cut [rad/(s N)].
        resolution: points along either axis.
        duration_s: simulated time [s]; an unsettled gait counts as one without limit cycle.
        body: another body, or changes of the controller's own.

    Raises:
        TegotaeError: for values that cannot be, before anything is computed.
    """
    values = _values(locals())
    from tegotae.figures.maps import phase_locking_figure, phase_locking_table
    from tegotae.figures.style import literal_text

    limits.require_within("cut", cut, limits.MOST_GAIN)
    hopping = values.controller
    sweep = sweep_gain(
        hopping.runs.controller,
        axis("sigma", *sigma, resolution),
        axis("omega", *omega, resolution, upper=limits.MOST_RAD_PER_S),
        values.body,
        timing=Timing(duration_s=duration_s),
        height_m=hopping.runs.system.release.height_m,
    )
    note = f"{literal_text(hopping.name)} ({type(hopping.runs.controller.actuation).__name__})"
    return _figure(
        sweep,
        lambda: phase_locking_figure(sweep, cut, note),
        {"": phase_locking_table(sweep)},
        values,
    )


@check_types
def basin(
    controller: Hopping = "paper",
    *,
    height_m: tuple[float, float] = (0.4, 2.5),
    velocity_m_per_s: tuple[float, float] = (-4.0, 4.0),
    resolution: int = 60,
    duration_s: float = 40.0,
    **options: Unpack[HopperOptions],
) -> Figure:
    """Draw the limit cycle that each release of one leg ends in, over height and phase.

    `tegotae.gaits.basin` draws the gaits of several legs.

    Args:
        controller: controller of a body with one leg.
        height_m: range of the release height [m].
        velocity_m_per_s: range of the release velocity [m/s]; replaces the phase without an
            oscillator.
        resolution: points along either axis.
        duration_s: simulated time [s]; an unsettled gait counts as one without limit cycle.

    Raises:
        TegotaeError: for values that cannot be, before anything is computed.
    """
    values = _values(locals(), "is tegotae gait basin")
    from tegotae.figures.maps import basin_figure, describe_map

    saved = values.controller.changed(values)
    heights = axis("height_m", *height_m, resolution, above=0.0, upper=limits.MOST_M)
    across = (
        axis("velocity_m_per_s", *velocity_m_per_s, resolution, upper=limits.MOST_M)
        if saved.controller.oscillator is None
        else axis("phase", 0.0, 2.0 * math.pi, resolution)
    )
    timing = saved.system.timing_over(duration_s)
    basin = map_basin(saved, heights, across, timing=timing)
    rows: list[Any] = list(basin.cycles.itertuples())
    without = 1.0 - sum(x.share for x in rows)
    cycles = [f"{describe_map(x)}, CoT⁻¹ {x.cot_inverse_a_m_per_j:.3f} m/J" for x in rows]
    return _figure(
        basin,
        lambda: basin_figure(basin, _titled(saved)),
        {
            "": basin.frame,
            "cycles": basin.cycles.rename_axis("limit_cycle").reset_index(),
        },
        values,
        notes=(*cycles, f"no limit cycle: {without:.1%} of the releases"),
        data={"limit_cycles": basin.cycles.to_dict("records")},
    )


@check_types
def learning_curves(
    first: str | Path, *others: str | Path, of: Literal["cot_inverse", "fitness"] | None = None
) -> Figure:
    """Draw CoT⁻¹ or fitness during training, over episodes and over simulated time (Fig. 3).

    Names are folders of trainings, searched with their subfolders, or tables that this command
    wrote.

    Args:
        first: folder or table.
        others: further ones.
        of: quantity of the curves; by default CoT⁻¹ if all measured it, else the fitness.

    Raises:
        TegotaeError: for folders without a training.
    """
    values = filled({"of": of}, {})
    from tegotae.figures import learning_curves as drawings
    from tegotae.training.curves import read_curves

    curves = read_curves([Path(first), *map(Path, others)], of)
    return _figure(
        curves,
        lambda: drawings.algorithms_figure(curves),
        drawings.algorithms_tables(curves),
        values,
        notes=(
            "Mean over runs of the mean over the last tenth of training [95 % interval]; equal "
            "time: that of the shortest run of the model.",
        ),
        views=[drawings.algorithms_compared(curves)],
    )
