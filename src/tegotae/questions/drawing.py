"""Figures that explain a controller: `figure_surface`, `figure_basin`, and others."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, Self

import numpy as np
import pandas as pd

from tegotae._support import limits
from tegotae._support.errors import TegotaeError, require_all, require_count, require_finite
from tegotae.analysis.orbit import (
    NoLimitCycleError,
    Orbit,
    find_orbit,
    paths_of,
    require_hopper,
)
from tegotae.parts.bodies import Body
from tegotae.questions.answer import Picture
from tegotae.questions.gaits import WalkingBasin
from tegotae.questions.hopping import HoppingOptions, HoppingTask
from tegotae.questions.question import Names, Tasks, question
from tegotae.questions.task import Task
from tegotae.questions.walking import WalkingTask
from tegotae.simulation.rollout import Timing, Trajectory
from tegotae.systems.controller_file import SavedController
from tegotae.systems.models import PRESETS
from tegotae.systems.system import RELEASE_M

if TYPE_CHECKING:
    from tegotae.envs.policies import Policy


@dataclass(frozen=True, kw_only=True)
class OneLeg(Tasks):
    """Controllers on a body with one leg, by name."""

    KIND = HoppingTask
    WHY = (
        "this figure is of one leg; for others there are simulate, evaluate, gait and figure basin"
    )


_HOPPING: dict[str, Any] = {
    "subjects": OneLeg,
    "usual": ("paper",),
    "kinds": {"option": "paper"},
    "written": "file",
}


@dataclass(frozen=True, kw_only=True)
class Driven(OneLeg):
    """A controller by name, or a policy."""

    policy: str | None = None
    """A policy in place of a controller: a .zip of Stable-Baselines3, an .onnx file, or
    FILE.py:FUNCTION, a function of some of phase_rad, spring_force_n, velocity_m_per_s and
    height_m. FILE.py runs as code, and other files are read by large libraries: take them from
    people that you trust."""

    def named(self, *names: Any) -> Sequence[Any]:
        if self.policy is None:
            return super().named(*(names or ("paper",)))
        if names:
            raise TegotaeError(f"{names[0]} is a controller, and --policy names a policy; name one")
        ending = Path(str(self.policy)).suffix.lower()
        more = {".zip": {"stable_baselines3": "sb3"}, ".onnx": {"onnxruntime": "onnx"}}
        require_all({"gymnasium": "gym", **more.get(ending, {})})
        return [PolicyFile(self.policy)]


@dataclass(frozen=True, kw_only=True)
class PolicyOptions:
    """What a policy's numbers mean, and where its hopper is released."""

    height_m: float = RELEASE_M
    """Release height [m]."""
    phase_rad: float = 0.0
    """Phase at release [rad]."""
    meaning: Any
    """A `tegotae.envs.policies.Meaning`."""


@dataclass(frozen=True)
class PolicyFile:
    """A policy that is not loaded yet: its options say what its numbers mean."""

    name: Any
    """Its place, or the policy itself."""

    def controller(self, options: PolicyOptions) -> Policy:
        """The policy, as `HoppingTask.controller`."""
        from tegotae.envs.policies import load_policy

        return load_policy(self.name, options.meaning)


@dataclass(frozen=True, kw_only=True)
class DriverOptions:
    """Of a figure of a controller or of a policy."""

    driver: Any
    """Of the controller or the policy."""

    @classmethod
    def options_of(cls, subject: HoppingTask | PolicyFile) -> Self:
        """The controller's own, or the usual meaning of a policy."""
        if isinstance(subject, HoppingTask):
            return cls(driver=HoppingOptions.options_of(subject))
        from tegotae.envs.policies import Meaning

        meaning = Meaning(omega=PRESETS["paper"].omega_rad_per_s)
        return cls(driver=PolicyOptions(meaning=meaning))


def _titled(driver: SavedController | Policy) -> str:
    """A controller or a policy in a few words, for a figure."""
    from tegotae.figures.style import literal

    words, omega = [literal(driver.name or "controller")], driver.omega
    if isinstance(driver, SavedController) and driver.controller.has_a_gain_alone:
        words.append(f"σ = {driver.weights[0]:.4g}")
    return ", ".join([*words, *([] if omega is None else [f"ω = {omega:g} rad/s"])])


def _driven(options: type[DriverOptions]) -> dict[str, Any]:
    """The settings of a question about a controller or a policy."""
    kinds = {
        "One leg, such as paper": "paper",
        "A policy": lambda: options.options_of(PolicyFile("policy")),
    }
    return {"subjects": Driven, "nameless": True, "written": "file", "kinds": kinds}


@dataclass(frozen=True, kw_only=True)
class SurfaceOptions(DriverOptions):
    """The part of the surface that is drawn."""

    velocity_m_per_s: float = 0.0
    """Velocity of the slice [m/s], for controllers that sense the velocity."""
    spring_force_n: float | None = None
    """Largest spring force [N]; a tenth above the limit cycle's by default."""
    resolution: int = 200
    """Points along either axis."""
    settle_s: float = 60.0
    """Simulated time before the limit cycle is measured [s]."""


@question(**_driven(SurfaceOptions))
def figure_surface(subject: HoppingTask | PolicyFile, options: SurfaceOptions) -> Picture:
    """Actuator force over phase and spring force, with the limit cycle on it (Fig. 5).

    Example:
        >>> figure_surface("V-reflex-w8", resolution=5).frame().columns[0]
        'spring_force_n'
    """
    from tegotae.analysis.surface import actuation_surface, sees_velocity
    from tegotae.figures.cycles import surface_figure, surface_tables

    require_count("resolution", options.resolution, least=2, most=limits.MOST_POINTS)
    limits.require_within("velocity", options.velocity_m_per_s, limits.MOST_M)
    driver = subject.controller(options.driver)
    body, note = require_hopper(driver.body, "an actuation surface"), _titled(driver)
    shortest_n = body.most_spring_n
    if options.spring_force_n is not None:
        require_finite("spring_force", options.spring_force_n, above=0.0, most=shortest_n)
    remarks: tuple[str, ...] = ()
    try:
        orbit = _orbit(driver, options)
    except NoLimitCycleError as none:
        orbit, remarks = None, (f"{none}; the surface is drawn without it",)
    most_n = options.spring_force_n
    if most_n is None:
        typical_n = 3.0 * body.weight_n if orbit is None else 1.1 * orbit.spring_force_n.max()
        most_n = min(typical_n, shortest_n)
    fastest = 4.0 if orbit is None else 1.1 * float(np.abs(orbit.velocity_m_per_s).max())
    surface = actuation_surface(
        driver,
        np.linspace(0.0, most_n, options.resolution),
        columns=options.resolution,
        velocity_m_per_s=options.velocity_m_per_s,
        velocity_range_m_per_s=(-fastest, fastest),
    )
    if surface.phase_rad is not None and sees_velocity(driver):
        note += f", slice at ẏ = {options.velocity_m_per_s:g} m/s"
    most_force_n = float(body.max_force_n)
    return Picture(
        raw=surface,
        drawn=lambda: surface_figure(surface, orbit, max_force_n=most_force_n, note=note),
        tables=surface_tables(surface, orbit),
        settings=options,
        remarks=remarks,
    )


def _orbit(driver: SavedController | Policy, options: SurfaceOptions) -> Orbit:
    if isinstance(driver, SavedController):
        return find_orbit(driver, settle_s=options.settle_s)
    from tegotae.analysis.policy import measured_policy, policy_orbit

    height = np.array([options.driver.height_m])
    paths = _paths(driver, options.driver, height, options.settle_s)
    return policy_orbit(paths, measured_policy(driver, paths))


def _paths(
    driver: SavedController | Policy, options: Any, heights: np.ndarray, duration_s: float
) -> Trajectory:
    if isinstance(driver, SavedController):
        return paths_of(driver, heights, duration_s=duration_s)
    from tegotae.analysis.policy import policy_paths

    return policy_paths(driver, heights, phase_rad=options.phase_rad, duration_s=duration_s)


@dataclass(frozen=True, kw_only=True)
class PortraitOptions(DriverOptions):
    """The releases of a portrait."""

    heights: tuple[float, ...] = (1.05, 1.2, 1.6)
    """Release heights, at rest [m]."""
    duration_s: float = 30.0
    """Simulated time [s]."""


@question(**_driven(PortraitOptions))
def figure_portrait(subject: HoppingTask | PolicyFile, options: PortraitOptions) -> Picture:
    """Phase portraits of a controller or a policy: (y, ẏ), and spring force over phase."""
    from tegotae.figures.cycles import portrait_figure, portrait_table

    driver = subject.controller(options.driver)
    rest_length_m = float(require_hopper(driver.body, "a phase portrait").rest_length_m)
    paths = _paths(driver, options.driver, np.array(options.heights), options.duration_s)
    return Picture(
        raw=paths,
        drawn=lambda: portrait_figure(paths, rest_length_m=rest_length_m, note=_titled(driver)),
        tables={"": portrait_table(paths)},
        settings=options,
    )


@dataclass(frozen=True, kw_only=True)
class SettledOptions(HoppingOptions):
    """The limit cycle that a controller settles on."""

    settle_s: float = 60.0
    """Simulated time before the limit cycle is measured [s]."""


@dataclass(frozen=True, kw_only=True)
class PoincareOptions(SettledOptions):
    """The disturbances of a limit cycle."""

    step: float = 1e-4
    """Step of the finite differences [m, rad]."""
    nudge: float = 0.01
    """Initial deviation from the limit cycle for the observed decay [m]."""
    turns: int = 40
    """Number of cycles over which the decay is observed."""


@question(**_HOPPING)
def figure_poincare(task: HoppingTask, options: PoincareOptions) -> Picture:
    """Apexes from the release on, Floquet multipliers, and the decay of a small deviation.

    Example:
        >>> figure_poincare("V-reflex-w8", turns=5).raw.hops
        1
    """
    from tegotae.analysis.poincare import check_disturbances, poincare_section, transient
    from tegotae.figures.cycles import poincare_figure, poincare_tables

    step, nudge, turns = options.step, options.nudge, options.turns
    check_disturbances(step, nudge, turns)
    saved = task.controller(options)
    orbit = find_orbit(saved, settle_s=options.settle_s)
    section = poincare_section(saved, orbit, step=step, nudge=nudge, turns=turns)
    apexes = transient(saved, duration_s=options.settle_s)
    modulus = np.abs(section.multipliers)
    multipliers = [f"{x.real:.4f}" if x.imag == 0.0 else f"{x:.4f}" for x in section.multipliers]
    remarks = []
    if not section.refined:
        remarks.append(
            "the fixed point was not refined; the apex at which the gait settled replaces it"
        )
    if np.isfinite(section.observed):
        remarks.append(f"observed decay: {section.observed:.4f} per turn")
    if np.isfinite(section.decay_s):
        remarks.append(f"a disturbance shrinks to 1/e in {section.decay_s:.3f} s")
    hops = "1 hop" if section.hops == 1 else f"{section.hops} hops"
    shown = pd.DataFrame({"Floquet multiplier": multipliers, "|λ|": modulus.round(4)})
    return Picture(
        raw=section,
        drawn=lambda: poincare_figure(section, apexes, _titled(saved)),
        tables=poincare_tables(section, apexes),
        settings=options,
        outcome=f"limit cycle of {hops}, {section.period_s:.4f} s",
        remarks=remarks,
        shown=[shown.set_index("Floquet multiplier")],
        data={"multiplier_modulus": modulus, "observed_factor": section.observed},
    )


@dataclass(frozen=True, kw_only=True)
class PhaseResponseOptions(SettledOptions):
    """The pushes, and where on the limit cycle they come."""

    push: tuple[float, ...] = (0.005, -0.005)
    """Impulses [N s]; positive ones act upward."""
    points: int = 60
    """Number of points of the limit cycle."""
    cycles: int = 40
    """Number of cycles to wait."""


@question(**_HOPPING)
def figure_phase_response(task: HoppingTask, options: PhaseResponseOptions) -> Picture:
    """Shift of the rhythm by a short push, over the phase of the push in the limit cycle."""
    from tegotae.analysis.phase_response import check_pushes, measure_phase_response
    from tegotae.figures import cycles

    saved, push, points = task.controller(options), np.array(options.push), options.points
    check_pushes(push, require_hopper(saved.body, "a push"), points, options.cycles)
    orbit = find_orbit(saved, settle_s=options.settle_s)
    response = measure_phase_response(saved, orbit, push, points=points, cycles=options.cycles)
    remarks = []
    for impulse, own in response.groupby("push_ns", sort=False):
        shift = own["shift_rad"].to_numpy()
        pushed, lost = f"push of {impulse:g} N s: ", float(np.mean(np.isnan(shift)))
        if lost == 1.0:
            remarks.append(f"{pushed}no return to the limit cycle")
            continue
        most = int(np.nanargmax(np.abs(shift)))
        where = own["cycle_phase_rad"].iloc[most] / (2.0 * np.pi)
        tiny = ", which is negligible" if abs(shift[most]) < cycles.NEGLIGIBLE_RAD else ""
        gone = f"; no return from {lost:.0%} of the points" if lost else ""
        remarks.append(
            f"{pushed}largest shift {shift[most]:+.3g} rad at t/T = {where:.2f}{tiny}{gone}"
        )
    return Picture(
        raw=response,
        drawn=lambda: cycles.phase_response_figure(response, _titled(saved)),
        tables={"": response},
        settings=options,
        remarks=remarks,
    )


@dataclass(frozen=True, kw_only=True)
class PhaseLockingOptions:
    """The gains and frequencies that are tried."""

    sigma: tuple[float, float] = (0.0, 12.0)
    """Range of the gain σ [rad/(s N)]."""
    omega: tuple[float, float] = (2.0, 10.0)
    """Range of the frequency ω [rad/s]."""
    cut: float = 4.0
    """Gain of the cut [rad/(s N)]."""
    resolution: int = 100
    """Points along either axis."""
    duration_s: float = 40.0
    """Simulated time [s]; an unsettled gait counts as one without limit cycle."""
    body: Body

    @classmethod
    def options_of(cls, task: Task) -> PhaseLockingOptions:
        """The body of the controller."""
        return cls(body=task.runs.body)


@question(**_HOPPING)
def figure_phase_locking(task: HoppingTask, options: PhaseLockingOptions) -> Picture:
    """Turns of the oscillator per hop over gain σ and frequency ω, and both rates along a cut."""
    from tegotae.analysis.maps import axis, sweep_gain
    from tegotae.figures.maps import phase_locking_figure, phase_locking_table
    from tegotae.figures.style import literal

    limits.require_within("cut", options.cut, limits.MOST_GAIN)
    sweep = sweep_gain(
        task.runs.controller,
        axis("sigma", *options.sigma, options.resolution),
        axis("omega", *options.omega, options.resolution, upper=limits.MOST_RAD_PER_S),
        options.body,
        timing=Timing(duration_s=options.duration_s),
        height_m=task.runs.system.release.height_m,
    )
    note = f"{literal(task.name)} ({type(task.runs.controller.actuation).__name__})"
    return Picture(
        raw=sweep,
        drawn=lambda: phase_locking_figure(sweep, options.cut, note),
        tables={"": phase_locking_table(sweep)},
        settings=options,
    )


@dataclass(frozen=True, kw_only=True)
class HoppingBasin(HoppingOptions):
    """The limit cycle for each release height and phase of one leg."""

    height: tuple[float, float] = (0.4, 2.5)
    """Range of the release height [m]."""
    velocity: tuple[float, float] = (-4.0, 4.0)
    """Range of the release velocity [m/s]; replaces the phase without an oscillator."""
    resolution: int = 60
    """Points along either axis."""
    duration_s: float = 40.0
    """Simulated time [s]; an unsettled gait counts as one without limit cycle."""

    def picture(self, task: HoppingTask) -> Picture:
        """The basins of the releases."""
        from tegotae.analysis.maps import axis, map_basin
        from tegotae.figures.maps import basin_figure, describe

        saved, points = task.controller(self), self.resolution
        heights = axis("height", *self.height, points, above=0.0, upper=limits.MOST_M)
        across = (
            axis("velocity", *self.velocity, points, upper=limits.MOST_M)
            if saved.controller.oscillator is None
            else axis("phase", 0.0, 2.0 * math.pi, points)
        )
        timing = saved.system.timing_over(self.duration_s)
        basin = map_basin(saved, heights, across, timing=timing)
        rows: list[Any] = list(basin.cycles.itertuples())
        without = 1.0 - sum(x.share for x in rows)
        cycles = [f"{describe(x)}, CoT⁻¹ {x.cot_inverse_a_m_per_j:.3f} m/J" for x in rows]
        return Picture(
            raw=basin,
            drawn=lambda: basin_figure(basin, _titled(saved)),
            tables={
                "": basin.frame,
                "cycles": basin.cycles.rename_axis("limit_cycle").reset_index(),
            },
            settings=self,
            remarks=(*cycles, f"no limit cycle: {without:.1%} of the releases"),
            data={"limit_cycles": basin.cycles.to_dict("records")},
        )


def _basin_options(task: Task) -> HoppingBasin | WalkingBasin:
    if isinstance(task, HoppingTask):
        return HoppingBasin.options_of(task)
    if isinstance(task, WalkingTask):
        return WalkingBasin.options_of(task)
    raise TegotaeError(
        f"{task.name} {task.what}; tegotae simulate and tegotae evaluate run it there"
    )


@question(
    own=_basin_options,
    usual=("paper",),
    kinds={"One leg, such as paper": "paper", "Several legs, such as quadruped-c": "quadruped-c"},
    written="file",
)
def figure_basin(task: Any, options: HoppingBasin | WalkingBasin) -> Picture:
    """Basins of attraction: the limit cycle or the gait that releases end in.

    Example:
        >>> len(figure_basin("bar-light", starts=8).frame())
        8
    """
    return options.picture(task)


@dataclass(frozen=True, kw_only=True)
class LearningCurveOptions:
    """What the curves are of."""

    of: Literal["cot_inverse", "fitness"] | None = None
    """Quantity of the curves; by default CoT⁻¹ if all measured it, else the fitness."""


@question(subjects=Names, several=True, written="file")
def figure_learning_curves(
    places: Sequence[Any], options: Sequence[LearningCurveOptions]
) -> Picture:
    """CoT⁻¹ or fitness during training, over episodes and over simulated time (Fig. 3).

    Names are folders of trainings, searched with their subfolders, or tables that this command
    wrote.
    """
    from tegotae.figures import learning_curves
    from tegotae.training.curves import read_curves

    curves = read_curves(list(map(Path, places)), options[0].of)
    return Picture(
        raw=curves,
        drawn=lambda: learning_curves.algorithms_figure(curves),
        tables=learning_curves.algorithms_tables(curves),
        settings=options[0],
        remarks=(
            "Mean over runs of the mean over the last tenth of training [95 % interval]; equal "
            "time: that of the shortest run of the model.",
        ),
        shown=[learning_curves.algorithms_compared(curves)],
    )
