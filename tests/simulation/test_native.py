"""Native code does what XLA does, tick by tick and to rounding, and gives one set of bits."""

import dataclasses
import functools
import gc
import json
import weakref
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from springs import Hertz

import tiny
from lanewise.episode import compile_episode
from tegotae import Hopper, Rollout, Scenario, Timing, register
from tegotae._support.engines import EngineWarning
from tegotae.parts.bodies import Actuators, Bar, Blows, Body, Sensors, Walker
from tegotae.parts.controller import Controller, Tegotae
from tegotae.parts.couplings import LearnedCoupling, Neighbours
from tegotae.parts.oscillators import OSCILLATORS, Clamped, PhaseOscillator
from tegotae.parts.terms import (
    ConstantGain,
    CorrectedFoot,
    LearnedActuation,
    LearnedFoot,
    OffsetAction,
    SectorAndReflex,
    UnitAction,
    VanillaAction,
    VanillaReaction,
    WholeBody,
    WholeBodyCorrectedFoot,
    WholeBodyFoot,
)
from tegotae.parts.terrains import Rough, Slope, Steps, Sum
from tegotae.simulation import native
from tegotae.simulation.integrators import Hold, Integrator, PredictorCorrector
from tegotae.simulation.recorder import needing
from tegotae.simulation.schedules import Staircase, Step
from tegotae.simulation.summaries import KeptChannels, Together
from tegotae.systems.recipe import recipe
from tegotae.systems.vanilla import SYSTEMS
from tegotae.training.run import train

TICK_S = 0.002
TICKS = 40
LANES = 5


@dataclass(frozen=True)
class Case:
    """A closed loop, and what its lanes meet."""

    controller: Controller
    body: Body = dataclasses.field(default_factory=Hopper)
    integrator: Integrator = dataclasses.field(default_factory=PredictorCorrector)
    meets: Callable[[], dict[str, Any]] = dict
    tick_s: float = TICK_S

    def run(self, dtype: str = "float32") -> Any:
        """Every tick of some lanes that come down early, go up, or fall."""
        timing = Timing(duration_s=TICKS * self.tick_s, tick_s=self.tick_s, frame_s=self.tick_s)
        rollout = Rollout(controller=self.controller, integrator=self.integrator, timing=timing)
        draw = np.random.default_rng(0)
        weights = draw.normal(0.0, 0.7, (LANES, self.controller.n_weights))
        shape = (*self.controller.limb_shape, LANES)
        scenario = {
            "omega": np.linspace(4.0, 9.0, LANES),
            "height_m": self.body.touching_height_m + np.array([0.01, 0.03, 0.0, 0.02, 0.3])
            if isinstance(getattr(self.body, "body", self.body), Walker)
            else np.array([1.02, 1.05, 1.0, 1.03, 1.4]),
            "velocity_m_per_s": np.array([-1.0, -1.5, -0.5, -2.0, 0.5]),
            "phase_rad": draw.uniform(0.0, 2.0 * np.pi, shape),
        }
        return rollout.run(weights, Scenario(**scenario | self.meets()), self.body, dtype=dtype)


def hopper(**parts: Any) -> Controller:
    """The vanilla hopper's controller with other parts."""
    return dataclasses.replace(recipe("V-both-w4").controller(), **parts)


def feeling(**terms: Any) -> Controller:
    """The same with other terms of its feedback."""
    terms_of_paper = Tegotae(VanillaAction(), VanillaReaction(), ConstantGain())
    return hopper(tegotae=dataclasses.replace(terms_of_paper, **terms))


def legs(actuation: Any = None, coupling: Any = None, limbs: int = 2) -> Controller:
    """Legs under a bar, or those of a walker."""
    controller = dataclasses.replace(
        recipe("V-sector-w8").controller(), limbs=limbs, coupling=coupling
    )
    return controller if actuation is None else dataclasses.replace(controller, actuation=actuation)


def case_named(name: str) -> Case:
    """A legged system."""
    system = SYSTEMS[name]()
    return Case(system.system.controller, system.body, tick_s=system.timing.tick_s)


def on(terrain: Any) -> Case:
    """A quadruped on a terrain."""
    system = SYSTEMS["quadruped-c"]()
    body = dataclasses.replace(system.body, terrain=terrain)
    return Case(system.system.controller, body, tick_s=system.timing.tick_s)


BAR = Bar(inertia_ratio=0.6)
WALKER = Walker()
ROUGH = Rough(rms_m=0.01, wavelength_m=0.3, start_m=-2.0)
CHANGES = {
    "drop_m": 0.1,
    "drop_time_s": 0.02,
    "changes": {
        "mass_kg": np.linspace(0.08, 0.12, LANES),
        "stiffness_n_per_m": Step(15.0, 0.01, 0.05),
        "omega": Staircase(0.5, 0.02),
        "ground_m": Step(-0.02, 0.03),
    },
}
CASES: dict[str, Callable[[], Case]] = {
    "ART": lambda: Case(recipe("ART").controller()),
    "quadruped-c": lambda: case_named("quadruped-c"),
    "changes": lambda: Case(recipe("V-both-w4").controller(), meets=lambda: CHANGES),
    "another spring": lambda: Case(
        recipe("V-both-w4").controller(), Hertz(), meets=lambda: CHANGES
    ),
    "hold": lambda: Case(recipe("ART").controller(), integrator=Hold()),
    "hold on a bar": lambda: Case(legs(), BAR, integrator=Hold()),
    "blows, actuators, sensors": lambda: Case(
        recipe("V-both-w4").controller(),
        Blows(
            body=Actuators(
                body=Sensors(body=Hopper(), delay_s=0.005, noise=0.05), strength=0.9, lag_s=0.01
            ),
            impulse_ns=0.05,
            at_s=0.03,
        ),
    ),
    "blow on a bar": lambda: Case(
        legs(), Blows(body=Bar(inertia_ratio=0.6), impulse_ns=0.05, at_s=0.03)
    ),
    "blow on a walker": lambda: Case(
        case_named("quadruped-c").controller,
        Blows(body=Walker(), impulse_ns=0.05, at_s=0.05),
        tick_s=0.01,
    ),
    **{
        f"oscillator {name}": lambda oscillator=oscillator: Case(hopper(oscillator=oscillator))
        for name, oscillator in OSCILLATORS.items()
    },
    "clamped": lambda: Case(hopper(oscillator=Clamped(PhaseOscillator()))),
    "no oscillator": lambda: Case(recipe("T-Fv").controller()),
    "AR and G": lambda: Case(recipe("ARGT-rFv-gFv-tphif-w8").controller()),
    "sector": lambda: Case(recipe("V-sector-w8").controller()),
    "reflex": lambda: Case(recipe("V-reflex-w8").controller()),
    "sector and reflex": lambda: Case(hopper(actuation=SectorAndReflex())),
    "wide network": lambda: Case(hopper(actuation=LearnedActuation(("phase", "feedback"), 24))),
    "offset action": lambda: Case(feeling(action=OffsetAction())),
    "unit action": lambda: Case(feeling(action=UnitAction())),
    "limit": lambda: Case(feeling(limit_rad_per_s=2.0)),
    "neighbours": lambda: Case(legs(coupling=Neighbours(((0, 1), (1, 0)), 0.5)), BAR),
    "learned coupling": lambda: Case(legs(coupling=LearnedCoupling()), BAR),
    "learned foot": lambda: Case(legs(LearnedFoot(("phase",), 3), limbs=4), WALKER, tick_s=0.01),
    "corrected foot": lambda: Case(
        legs(CorrectedFoot(("phase",), 3), limbs=4), WALKER, tick_s=0.01
    ),
    "whole body": lambda: Case(
        legs(WholeBody(("spring_force",), ("phase", "pitch"), limbs=2, hidden=3)), BAR
    ),
    "whole body, feet": lambda: Case(
        legs(WholeBodyFoot(("spring_force",), ("phase",), limbs=4, hidden=3), limbs=4),
        WALKER,
        tick_s=0.01,
    ),
    "whole body, ellipses": lambda: Case(
        legs(
            WholeBodyCorrectedFoot(
                ("spring_force",), ("phase",), 4, 3, lead_rad=(0.0, 1.0, 2.0, 3.0)
            ),
            limbs=4,
        ),
        WALKER,
        tick_s=0.01,
    ),
    **{
        name: lambda name=name: case_named(name)
        for name in ("bar-light", "plate-light-twist", "quadruped-a", "hexapod", "biped")
    },
    "slope": lambda: on(Slope(along=0.1, across=0.05)),
    "steps": lambda: on(Steps(rise_m=0.01, tread_m=0.05, start_m=-1.0)),
    "rough": lambda: on(ROUGH),
    "sum": lambda: on(Sum(first=Slope(along=0.05), second=ROUGH)),
}
QUICK = ("ART", "changes", "another spring")
"""Those that are compared in every run of the tests: XLA takes seconds to compile one."""


def native_and_xla(case: Case, dtype: str, monkeypatch: pytest.MonkeyPatch) -> tuple[Any, Any]:
    """Return the results of native code and of XLA."""
    native_result = case.run(dtype)
    with monkeypatch.context() as context:
        context.setenv("TEGOTAE_ENGINE", "xla")
        return native_result, case.run(dtype)


@pytest.mark.parametrize("dtype", [pytest.param("float32", marks=pytest.mark.thorough), "float64"])
@pytest.mark.parametrize(
    "name",
    [case if case in QUICK else pytest.param(case, marks=pytest.mark.thorough) for case in CASES],
)
def test_every_tick_is_xlas_to_rounding(name, dtype, monkeypatch):
    native_result, reference = native_and_xla(CASES[name](), dtype, monkeypatch)
    digits = 2e-4 if dtype == "float32" else 1e-9
    assert native_result.channels.keys() == reference.channels.keys()
    for channel, expected in reference.channels.items():
        actual = native_result.channels[channel]
        assert (actual.shape, actual.dtype) == (expected.shape, expected.dtype), channel
        gap = actual.astype(float) - expected.astype(float)
        if channel.endswith("phase_rad"):  # 0 and 2π are the same
            gap = np.angle(np.exp(1j * gap))
        np.testing.assert_array_equal(np.isnan(actual), np.isnan(expected), err_msg=channel)
        scale = np.nanmax(np.abs(expected.astype(float)), initial=1.0)
        assert np.nanmax(np.abs(gap), initial=0.0) < digits * scale, channel


@needing("height_m")
def highest(trajectory: Any, *_: Any) -> jax.Array:
    return trajectory.height_m.max(axis=0)


def of_limit(limit_rad_per_s: float, summary: Any = highest) -> Rollout:
    """A rollout whose program differs by a number of its controller."""
    timing = Timing(duration_s=0.01, tick_s=TICK_S, frame_s=TICK_S)
    controller = feeling(limit_rad_per_s=limit_rad_per_s)
    return Rollout(controller=controller, timing=timing, summary=summary)


@dataclass(frozen=True)
class SortedAction(VanillaAction):
    """A user's part with an operation that has no native code: -cos φ, but not above a half."""

    def __call__(self, weights: Any, signals: Any) -> jax.Array:
        action = super().__call__(weights, signals)
        return jnp.sort(jnp.stack([action, jnp.full_like(action, 0.5)]), axis=0)[0]


def test_what_has_no_native_code_is_run_by_xla_and_named(monkeypatch):
    case = Case(feeling(action=SortedAction()))
    with pytest.warns(EngineWarning, match="^'sort' .* has no native code; XLA runs"):
        native_result, reference = native_and_xla(case, "float32", monkeypatch)
    jax.tree.map(np.testing.assert_array_equal, native_result, reference)


def test_a_training_of_such_a_part_says_so_and_goes_on_with_xla(tmp_path, monkeypatch):
    register(SortedAction)
    learning = tiny.run_of(1)
    controller = learning.experiment.system.controller
    tegotae = dataclasses.replace(controller.tegotae, action=SortedAction())
    run = tiny.changed(learning, controller=dataclasses.replace(controller, tegotae=tegotae))
    run = dataclasses.replace(run, seeds=(0,))
    with pytest.warns(EngineWarning, match="'sort'"):
        train(run, tmp_path / "native")
    record = json.loads((tmp_path / "native" / "run.json").read_text())
    assert record["software"]["engine"] == "native, xla for sort"
    monkeypatch.setenv("TEGOTAE_ENGINE", "xla")
    train(run, tmp_path / "xla")
    native_result, reference = (
        np.load(tmp_path / engine / "checkpoint.npz") for engine in ("native", "xla")
    )
    for name in native_result.files:
        np.testing.assert_array_equal(native_result[name], reference[name], err_msg=name)


@pytest.fixture
def kernels(monkeypatch):
    """Kernels that are compiled from now on, as weak references; the engine keeps two."""
    compiled = []

    def compile_one(*arguments: Any, **options: Any) -> Any:
        kernel = compile_episode(*arguments, **options)
        compiled.append(weakref.ref(kernel))
        return kernel

    monkeypatch.setattr("lanewise.episode.compile_episode", compile_one)
    for name in ("_kernel", "_summarised"):
        factory = getattr(native, name).__wrapped__
        monkeypatch.setattr(native, name, functools.lru_cache(2)(factory))
    return compiled


def test_equal_programs_are_compiled_once_whatever_the_lanes(kernels):
    for lanes in (1, 3):
        of_limit(3.0).run(np.ones((lanes, 1)), Scenario(omega=8.0))
    assert len(kernels) == 1


def test_controllers_whose_recordings_are_alike_share_one_summary(kernels):
    for limit in (3.0, 4.0):
        of_limit(limit).run(np.ones((1, 1)), Scenario(omega=8.0))
    assert (len(kernels), native._summarised.cache_info().misses) == (2, 1)


def test_what_is_recorded_is_copied_and_of_summaries_together_only_what_is_computed_is_compiled(
    kernels,
):
    weights, scenario = np.ones((70, 1)), Scenario(omega=np.linspace(4.0, 9.0, 70))
    height = of_limit(3.0, KeptChannels(("height_m",))).run(weights, scenario).height_m
    assert native._summarised.cache_info().misses == 0
    summary = Together((highest, KeptChannels(("time_s", "height_m")), highest))
    first, kept, second = of_limit(3.0, summary).run(weights, scenario)
    assert list(kept.channels) == ["time_s", "height_m"]
    np.testing.assert_array_equal(kept.height_m, height)
    for computed in (first, second):
        np.testing.assert_array_equal(computed, height.max(axis=0))


def test_a_long_session_keeps_the_programs_that_were_used_last(kernels):
    for limit in (3.0, 4.0, 5.0):
        of_limit(limit).run(np.ones((1, 1)), Scenario(omega=8.0))
    gc.collect()
    assert [kernel() is None for kernel in kernels] == [True, False, False]
