"""Controllers and bodies with several limbs: what the limb axis promises."""

import dataclasses
import math

import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given, strategies as st
from separate_hoppers import SeparateHoppers

import upright_oracle
from refusals import refused
from tegotae import Controller, Hopper, Rollout, Scenario, Timing, check
from tegotae.parts.bodies import Bar
from tegotae.parts.couplings import LearnedCoupling, Neighbours
from tegotae.parts.terms import Signals
from tegotae.systems.recipe import recipe

ONE = recipe("V-sector-w8").controller()
ART = recipe("ART").controller(20)
SHORT = Timing(duration_s=4.0)


def network(unit: Controller, limbs: int = 2, **options) -> Controller:
    return dataclasses.replace(unit, limbs=limbs, **options)


def run(controller: Controller, weights, body=None, *, timing=SHORT, **scenario):
    rollout = Rollout(controller=controller, timing=timing)
    return rollout.run(weights, Scenario(omega=8.0, **scenario), body, dtype="float64")


# A network of units


def test_uncoupled_units_on_separate_bodies_are_as_many_runs_of_one():
    weights = np.random.default_rng(0).normal(size=(3, ART.n_weights))
    phase = np.array([[0.0, 1.0, 2.0], [3.0, 4.0, 5.0]])
    path = run(
        network(ART), weights, SeparateHoppers(), phase_rad=phase, initial_pose={"apart_m": 0.2}
    )
    for limb, height in enumerate((1.1, 1.3)):
        alone = run(ART, weights, Hopper(), phase_rad=phase[limb], height_m=height)
        np.testing.assert_allclose(path.hoppers_m[:, limb], alone.height_m, atol=1e-12)
        for channel in ("phase_rad", "feedback_rad_per_s", "actuator_force_n", "spring_force_n"):
            of_limb = getattr(path, channel)[:, limb]
            np.testing.assert_allclose(of_limb, getattr(alone, channel), atol=1e-9, err_msg=channel)


def test_what_belongs_to_a_limb_has_its_axis_before_the_lanes():
    path = run(network(ONE), [[1.0], [2.0], [3.0]], Bar())
    frames = SHORT.n_frames
    assert path.phase_rad.shape == path.touchdown_time_s.shape == (frames, 2, 3)
    assert path.height_m.shape == path.work_net_j.shape == path.failed.shape == (frames, 3)


@pytest.mark.parametrize(
    ("sharing", "sets", "limbs_alike"),
    [(None, 1, [0, 0, 0]), ((0, 0, 1), 2, [0, 0, 1]), ((0, 1, 2), 3, [0, 1, 2])],
    ids=["shared", "by girdle", "free"],
)
def test_weights_are_shared_by_all_by_some_or_by_none(sharing, sets, limbs_alike):
    controller = network(ONE, 3, sharing=sharing)
    assert controller.n_weights == sets
    rows = [jnp.full(2, 10.0 * i) for i in range(sets)]
    (gain,) = controller.spread(rows)
    np.testing.assert_array_equal(gain, 10.0 * np.array(limbs_alike)[:, None] * np.ones(2))


def test_a_mirrored_start_gives_the_mirrored_gait():
    bar, legs = Bar(inertia_ratio=0.6), network(ONE)
    phase = np.array([[0.3], [2.0]])
    ahead = run(legs, [[2.0]], bar, phase_rad=phase, initial_pose={"pitch_rad": 0.1})
    mirrored = run(legs, [[2.0]], bar, phase_rad=phase[::-1], initial_pose={"pitch_rad": -0.1})
    np.testing.assert_allclose(ahead.height_m, mirrored.height_m, atol=1e-12)
    np.testing.assert_allclose(ahead.pitch_rad, -mirrored.pitch_rad, atol=1e-12)
    np.testing.assert_allclose(ahead.phase_rad, mirrored.phase_rad[:, ::-1], atol=1e-10)


def test_wiring_lets_units_feel_and_drive_other_limbs():
    bar = Bar(inertia_ratio=0.6)
    phase, gains = np.array([[0.3], [2.0]]), [[2.0, 3.0]]
    straight = run(network(ONE, sharing=(0, 1)), gains, bar, phase_rad=phase)
    crossed = run(
        network(ONE, sharing=(0, 1), wiring=(1, 0)),
        [[3.0, 2.0]],
        bar,
        phase_rad=phase[::-1],
    )
    np.testing.assert_array_equal(straight.height_m, crossed.height_m)
    np.testing.assert_array_equal(straight.phase_rad, crossed.phase_rad[:, ::-1])


def test_a_unit_feels_and_drives_the_limb_that_its_wiring_names():
    """The wiring is not its own inverse."""
    wiring, gains, phase = (1, 2, 0), (1.0, 2.0, 3.0), [[0.3], [2.0], [4.0]]
    together = run(
        network(ONE, 3, sharing=(0, 1, 2), wiring=wiring),
        [gains],
        SeparateHoppers(hoppers=3),
        phase_rad=phase,
        initial_pose={"apart_m": 0.2},
    )
    for unit, limb in enumerate(wiring):
        height_m = (1.1, 1.2, 1.3)[limb]
        alone = run(ONE, [[gains[unit]]], Hopper(), phase_rad=phase[unit], height_m=height_m)
        np.testing.assert_allclose(together.hoppers_m[:, limb], alone.height_m, atol=1e-12)
        np.testing.assert_allclose(together.phase_rad[:, unit], alone.phase_rad, atol=1e-9)


def test_lists_serve_where_tuples_do():
    lists = network(ONE, sharing=[0, 1], wiring=[1, 0], coupling=Neighbours([[0, 1]], 1.0))
    tuples = network(ONE, sharing=(0, 1), wiring=(1, 0), coupling=Neighbours(((0, 1),), 1.0))
    assert lists == tuples
    assert hash(lists) == hash(tuples)
    assert Bar(hips_m=[-0.5, 0.5]) == Bar()


# Couplings


@pytest.mark.parametrize(
    "coupling", [Neighbours(((0, 1), (1, 0)), 0.0), LearnedCoupling()], ids=["fixed", "learned"]
)
def test_a_coupling_of_zero_is_none(coupling):
    phase, bar = [[0.3], [2.0]], Bar(inertia_ratio=0.6)
    weights = [[2.0] + [0.0] * coupling.n_weights(2)]
    coupled = run(network(ONE, coupling=coupling), weights, bar, phase_rad=phase)
    alone = run(network(ONE), [[2.0]], bar, phase_rad=phase)
    np.testing.assert_array_equal(coupled.height_m, alone.height_m)


@given(phase=st.lists(st.floats(0.0, 6.2), min_size=4, max_size=4), lag=st.floats(-3.0, 3.0))
def test_a_coupling_is_the_sine_of_the_gap_less_the_lag(phase, lag):
    phi = np.array(phase)
    signals = Signals({"sin_phase": jnp.sin(phi), "cos_phase": jnp.cos(phi)})
    pull = Neighbours(((0, 1), (0, 2), (3, 0)), 2.0, lag)((), signals)
    expected = [
        2.0 * (math.sin(phi[1] - phi[0] - lag) + math.sin(phi[2] - phi[0] - lag)),
        0.0,
        0.0,
        2.0 * math.sin(phi[0] - phi[3] - lag),
    ]
    np.testing.assert_allclose(pull, expected, atol=1e-5)


def test_a_learned_coupling_can_be_any_fixed_one():
    phi = jnp.array([0.2, 1.5])
    signals = Signals({"sin_phase": jnp.sin(phi), "cos_phase": jnp.cos(phi)})
    strength, lag = 1.7, 0.9
    weights = [strength * math.cos(lag), -strength * math.sin(lag)] * 2
    fixed = Neighbours(((0, 1), (1, 0)), strength, lag)
    np.testing.assert_allclose(
        LearnedCoupling()(list(map(jnp.asarray, weights)), signals), fixed((), signals), rtol=1e-5
    )


@pytest.mark.thorough
def test_a_strong_coupling_brings_oscillators_to_its_lag():
    lag = 1.0
    coupling = Neighbours(((1, 0), (0, 1)), 20.0)
    one_way = Neighbours(((1, 0),), 20.0, lag)
    for links, gap in ((coupling, 0.0), (one_way, lag)):
        path = run(network(ONE, coupling=links), [[0.0]], Bar(), phase_rad=[[0.0], [2.0]])
        measured = np.diff(path.phase_rad[-1], axis=0)[0, 0]
        assert math.cos(measured + gap) == pytest.approx(1.0, abs=1e-6)


# The bar


def test_the_bar_keeps_the_contract_of_a_body():
    check(Bar(hips_m=(-0.6, -0.1, 0.2, 0.5), inertia_ratio=1.5))


def test_two_legs_do_not_feel_each_other_at_an_inertia_ratio_of_one():
    phase = np.array([[0.0, 1.0], [2.0, 4.0]])
    bar = Bar(inertia_ratio=1.0)
    path = run(network(ONE), [1.0], bar, phase_rad=phase)
    for limb, hip in enumerate(bar.hips_m):
        alone = run(ONE, [1.0], phase_rad=phase[limb])
        np.testing.assert_allclose(path.height_m + hip * path.pitch_rad, alone.height_m, atol=1e-11)
        np.testing.assert_allclose(path.phase_rad[:, limb], alone.phase_rad, atol=1e-9)


@pytest.mark.parametrize("hips", [(-0.5, 0.5), (-0.7, 0.0, 0.7), (-0.6, -0.2, 0.2, 0.6)])
def test_legs_that_are_all_alike_are_one_hopper_at_any_inertia(hips):
    alone = run(ONE, [1.5], phase_rad=0.4)
    path = run(network(ONE, len(hips)), [1.5], Bar(hips_m=hips, inertia_ratio=0.3), phase_rad=0.4)
    np.testing.assert_allclose(path.height_m, alone.height_m, atol=1e-11)
    np.testing.assert_allclose(path.pitch_rad, 0.0, atol=1e-12)
    np.testing.assert_allclose(path.work_absolute_j, len(hips) * alone.work_absolute_j, atol=1e-11)
    np.testing.assert_allclose(path.climb_flight_m, alone.climb_flight_m, atol=1e-11)


@pytest.mark.parametrize(
    ("hips", "inertia_ratio", "reflex", "phases"),
    [
        ((-0.5, 0.5), 0.6, False, (0.0, 1.0)),
        ((-0.5, 0.5), 1.6, True, (0.5, 2.0)),
        ((-0.6, 0.1, 0.5), 0.8, False, (0.0, 1.0, 2.5)),
    ],
    ids=["light", "heavy, reflex", "three legs"],
)
def test_apexes_are_those_of_an_adaptive_solver(hips, inertia_ratio, reflex, phases):
    flown = upright_oracle.fly(
        upright_oracle.bar(hips, inertia_ratio),
        sigma=2.0,
        omega=8.0,
        phases=phases,
        duration=4.0,
        turned=(0.05,),
        reflex=reflex,
    )
    controller = network(recipe("V-reflex-w8").controller() if reflex else ONE, len(hips))
    path = run(
        controller,
        [2.0],
        Bar(hips_m=hips, inertia_ratio=inertia_ratio),
        phase_rad=np.array(phases)[:, None],
        initial_pose={"pitch_rad": 0.05},
    )
    mask = np.isfinite(path.apex_time_s[:, 0])
    assert mask.sum() == len(flown.apex_time) >= 2
    np.testing.assert_allclose(path.apex_height_m[mask, 0], flown.apex_height, atol=1e-3)
    np.testing.assert_allclose(path.apex_time_s[mask, 0], flown.apex_time, atol=2e-3)


def test_without_damping_and_force_the_bar_keeps_its_energy():
    bar = Bar(damping_ns_per_m=0.0, inertia_ratio=0.5)
    silent = network(recipe("V-reflex-w8").controller())
    path = run(silent, [0.0], bar, initial_pose={"pitch_rad": 0.2, "pitch_rate_rad_per_s": 0.5})
    assert np.ptp(path.energy_j) < 1e-9 * path.energy_j[0, 0]


@pytest.mark.parametrize(
    ("inertia_ratio", "lag"), [(0.6, math.pi), (1.6, 0.0)], ids=["light", "heavy"]
)
def test_a_light_bar_falls_into_antiphase_and_a_heavy_one_into_phase(inertia_ratio, lag):
    phase = np.random.default_rng(0).uniform(0.0, 2.0 * np.pi, (2, 4))
    timing = Timing(duration_s=90.0, frame_s=0.1, tick_s=0.002)
    rollout = Rollout(controller=network(ONE), timing=timing)
    path = rollout.run(
        [1.0], Scenario(omega=8.0, phase_rad=phase), Bar(inertia_ratio=inertia_ratio)
    )
    gap = np.diff(path.phase_rad[-1], axis=0)[0]
    np.testing.assert_allclose(np.cos(gap - lag), 1.0, atol=0.05)


# What cannot be


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: network(ONE, 0), "limbs is 0; it must be a whole number of at least 1"),
        (lambda: network(ONE, sharing=(0,)), "sharing names the weights of 1 limbs; .* has 2"),
        (lambda: network(ONE, sharing=(0, 2)), r"number the sets of weights from 0 on"),
        (lambda: network(ONE, wiring=(0, 0)), r"limb 0 is driven by 2 units"),
        (lambda: network(ONE, wiring=(0, 2)), r"limb 1 is driven by no unit"),
        (
            lambda: network(ONE, coupling=Neighbours(((0, 2),), 1.0)),
            r"a link is \(0, 2\); it must name two different limbs of 0 ... 1",
        ),
        (lambda: network(ONE, 1, coupling=LearnedCoupling()), "needs at least two limbs"),
        (
            lambda: network(recipe("T-F").controller(), coupling=LearnedCoupling()),
            "a coupling but no oscillators to couple",
        ),
        (lambda: run(ONE, [1.0], Bar()), "drives 1 limbs, and a Bar has 2"),
        (lambda: run(network(ONE), [1.0]), "drives 2 limbs, and a Hopper has 1"),
        (
            lambda: run(network(ONE), [1.0], Bar(), phase_rad=np.zeros((3, 1))),
            r"phase_rad has shape \(3, 1\); it must be a number, \[lanes\] or \[2, lanes\]",
        ),
        (
            lambda: run(ONE, [1.0], initial_pose={"pitch_rad": 1.0}),
            "Hopper has no initial_pose 'pitch_rad'; it takes none",
        ),
        (
            lambda: run(network(ONE), [1.0], Bar(), initial_pose={"roll_rad": 1.0}),
            "Bar has no initial_pose 'roll_rad'; it takes pitch_rad, pitch_rate_rad_per_s",
        ),
        (
            lambda: run(network(ONE), [1.0], Bar(), initial_pose=[1]),
            r"initial_pose is \[1\]; it must be numbers by name",
        ),
        (
            lambda: run(network(ONE), [1.0], Bar(), initial_pose={"pitch_rad": "x"}),
            "pitch_rad is 'x'; it must be a number",
        ),
        (lambda: run(ONE, [1.0], 3), "body is 3; it must be a Body"),
        (lambda: run(ONE, "x"), "weights is 'x'; it must be a number or an array"),
        (lambda: network(ONE, sharing=("a", "b")), r"sharing is \('a', 'b'\); .*whole numbers"),
        (lambda: network(ONE, wiring=1), "wiring is 1; it must be whole numbers"),
        (lambda: network(ONE, coupling=3), "coupling is 3; it must be a Coupling"),
        (lambda: Neighbours((0, 1), 1.0), r"links is \(0, 1\); it must be pairs of limbs"),
        (lambda: Neighbours(((0, 1.5),), 1.0), r"a link is \(0, 1.5\); .*whole numbers"),
        (lambda: Bar(hips_m=0.5), "hips_m is 0.5; it must be numbers"),
        (lambda: Bar(hips_m=(0.5, -0.5)), "from back to front"),
        (lambda: Bar(hips_m=(-0.5, 0.7)), "whose mean is 0.1; it must be 0"),
        (lambda: Bar(inertia_ratio=-1.0), "inertia_ratio is -1"),
        (
            lambda: run(network(ONE), [1.0], Bar(inertia_ratio=1e-6)),
            "the control tick of 0.001 s is too long for this bar",
        ),
    ],
)
def test_what_does_not_go_together_is_said_in_one_line(make, message):
    refused(message, make)
