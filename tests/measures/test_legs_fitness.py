"""Fitness of legs: a walk at a speed, hopping leg by leg; and terms for legs."""

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from refusals import refused
from tegotae import Hopper, Rollout, Scenario, TegotaeError, Timing, check
from tegotae.measures.objectives.fitness import Fitness, HoppingLegs, climb_in_flight
from tegotae.measures.objectives.objective import FAILED_FITNESS
from tegotae.measures.objectives.walking import TRACKING, Walking
from tegotae.parts.bodies import Bar, Walker
from tegotae.parts.controller import Controller
from tegotae.parts.terms import (
    CorrectedFoot,
    EllipticFoot,
    LearnedFoot,
    OffsetAction,
    Sector,
    Signals,
    VanillaAction,
    WholeBody,
    WholeBodyCorrectedFoot,
    WholeBodyFoot,
)
from tegotae.simulation.recorder import Trajectory
from tegotae.systems.recipe import recipe

TIMING = Timing(duration_s=20.0, tick_s=0.01, frame_s=0.1)
TIME = 0.1 * np.arange(1, 201)[:, None]
WALK = Walking(speed_m_per_s=0.25, settle_s=10.0)


CASES = {
    "wanted": {},
    "cheap": {"power": 0.05},
    "slow": {"speed": 0.225},
    "fast": {"speed": 0.275},
    "creeping": {"speed": 0.01},
    "standing": {"speed": 0.0},
    "backwards": {"speed": -0.1},
    "turned": {"yaw": 2.0, "looks": 2.0},
    "aside": {"looks": 1.0},
    "at rest": {"speed": 0.0, "power": 0.0},
    "fallen": {"failed": 1.0},
}
"""Walks in the direction `yaw`, looking in the direction `looks`."""


@pytest.fixture(scope="module")
def walks():
    """A function that returns an entry of the fitness's parts of walks by name."""
    standard = {"speed": 0.25, "power": 0.1, "yaw": 0.0, "looks": 0.0, "failed": 0.0}
    lanes = {k: np.array([{**standard, **case}[k] for case in CASES.values()]) for k in standard}
    frames = {
        "time_s": TIME + 0.0 * lanes["speed"],
        "x_m": TIME * lanes["speed"] * np.cos(lanes["yaw"]),
        "y_m": TIME * lanes["speed"] * np.sin(lanes["yaw"]),
        "yaw_rad": 0.0 * TIME + lanes["looks"],
        "work_absolute_j": TIME * lanes["power"],
        "failed": (TIME > 15.0) & (lanes["failed"] > 0.0),
    }
    recorded = Trajectory(**jax.tree.map(jnp.asarray, frames))
    result = jax.jit(lambda t: WALK(t, Scenario(omega=2.0), Walker(), TIMING))(recorded)
    result = jax.tree.map(np.asarray, result)
    return lambda entry, *names: [float(result[entry][list(CASES).index(n)]) for n in names]


# Walking


def test_at_the_wanted_speed_a_walk_is_worth_its_inverse_cost_of_transport(walks):
    assert walks("fitness", "wanted", "cheap") == pytest.approx([2.5, 5.0], rel=1e-4)
    assert walks("cot_inverse", "wanted", "cheap") == pytest.approx([2.5, 5.0], rel=1e-4)


def test_a_speed_that_is_off_costs_its_share_either_way(walks):
    names = ("slow", "fast")
    for fitness, cheap in zip(walks("fitness", *names), walks("cot_inverse", *names), strict=True):
        assert fitness == pytest.approx(cheap - 0.1 * TRACKING, rel=1e-3)


def test_who_stands_or_goes_backwards_is_worse_than_who_creeps(walks):
    creeps, stands, back = walks("fitness", "creeping", "standing", "backwards")
    assert creeps > stands > back
    assert stands == pytest.approx(-TRACKING)


def test_only_the_way_in_the_direction_of_the_gaze_counts(walks):
    straight, turned, aside = walks("cot_inverse", "wanted", "turned", "aside")
    assert turned == pytest.approx(straight, rel=1e-4)
    assert aside == pytest.approx(straight * np.cos(1.0), rel=1e-4)


def test_a_body_at_rest_that_does_no_work_has_no_efficiency_and_no_nan(walks):
    assert walks("cot_inverse", "at rest") == [0.0]
    assert walks("fitness", "at rest") == pytest.approx([-TRACKING])


def test_whoever_falls_is_below_all_others(walks):
    assert walks("fitness", "fallen") == pytest.approx([FAILED_FITNESS + 0.75])
    assert walks("cot_inverse", "fallen") == [0.0]


def test_another_speed_is_data_of_the_same_program():
    faster = dataclasses.replace(WALK, speed_m_per_s=0.4, tracking=3.0)
    assert faster.program == WALK.program
    assert faster.data != WALK.data


@pytest.mark.parametrize(
    "settings", [{"speed_m_per_s": 0.0}, {"settle_s": -1.0}, {"tracking": float("nan")}]
)
def test_a_walk_with_impossible_numbers_is_refused(settings):
    refused(next(iter(settings)), dataclasses.replace, WALK, **settings)


def test_an_episode_that_ends_before_it_has_settled_is_refused():
    for fitness in (WALK, HoppingLegs(settle_s=10.0)):
        with pytest.raises(TegotaeError, match="leaves"):
            fitness.check(Timing(duration_s=10.0))


# Hopping


def test_climbs_count_in_flight_alone():
    hips = np.array([[0.8, 1.3, 1.0, 0.9, 1.2], [1.0, 0.6, 0.9, 0.7, 1.0]]).T[:, :, None]
    assert float(climb_in_flight(jnp.asarray(hips), 1.0)[0]) == pytest.approx(0.5)


@pytest.mark.precise
def test_where_legs_do_not_feel_each_other_the_fitness_is_the_hoppers():
    timing = Timing(duration_s=14.0, tick_s=0.004)
    hopper = recipe("V-sector-w8").controller()
    alone = Rollout(controller=hopper, timing=timing, summary=Fitness(settle_s=6.0)).run(
        [1.0], Scenario(omega=8.0, phase_rad=0.3), Hopper()
    )
    legs = dataclasses.replace(hopper, limbs=2)
    rollout = Rollout(controller=legs, timing=timing, summary=HoppingLegs(settle_s=6.0))
    start = np.array([[0.3], [1.7]])  # each its own way
    together = rollout.run([1.0], Scenario(omega=8.0, phase_rad=start), Bar(inertia_ratio=1.0))
    assert together["cot_inverse"][0] == pytest.approx(float(alone["cot_inverse"][0]), rel=0.05)
    assert together["delta_omega"][0] == pytest.approx(float(alone["delta_omega"][0]), abs=0.02)
    assert not together["failed"][0]


# Terms


def of_legs(limbs=3, lanes=2, seed=0) -> Signals:
    draw = np.random.default_rng(seed)
    names = ("spring_force", "pitch", "sin_phase", "cos_phase")
    values = {name: jnp.asarray(draw.normal(size=(limbs, lanes)), "float32") for name in names}
    values["pitch"] = jnp.broadcast_to(values["pitch"][0], (limbs, lanes))
    return Signals(values, {"spring_force": 2.0})


def test_one_network_for_all_legs_is_its_formula():
    network = WholeBody(("spring_force",), ("pitch",), limbs=3, hidden=2)
    weights = np.random.default_rng(1).normal(size=(network.n_weights, 3, 2)).astype("float32")
    weights = np.broadcast_to(weights[:, :1], weights.shape)  # shared by all legs
    heard = of_legs()
    result = np.asarray(jax.jit(lambda w: network(list(w), heard))(weights))
    x = np.concatenate([np.asarray(heard["spring_force"]) / 2.0, np.asarray(heard["pitch"])[:1]])
    neurons = weights[:, 0].reshape(2, -1, 2)
    hidden = np.tanh((neurons[:, :4] * x[None]).sum(axis=1) + neurons[:, 4])
    np.testing.assert_allclose(result, (neurons[:, 5:] * hidden[:, None]).sum(axis=0), rtol=1e-5)


def test_one_network_for_all_legs_feels_every_leg_and_a_network_a_leg_its_own_alone():
    complete = WholeBodyFoot(("spring_force",), (), limbs=3, hidden=3)
    separate = LearnedFoot(("spring_force",), hidden=3)
    heard = of_legs()
    loads = heard["spring_force"]
    moved = Signals({**heard.values, "spring_force": loads.at[2].add(1.0)}, heard.scales)
    for term, others_move in ((complete, True), (separate, False)):
        weights = term.initial(jax.random.key(0))[:, None, None] * jnp.ones((1, 3, 2))
        say = jax.jit(lambda w, x, values, term=term: term(list(w), Signals(values, x)))
        outputs = [say(weights, dict(signals.scales), signals.values) for signals in (moved, heard)]
        change = np.abs(np.asarray(outputs[0] - outputs[1]))
        assert (change[:, 2] > 0.0).all()
        assert (change[:, :2] > 0.0).all() == others_move


def test_one_network_for_all_legs_has_one_set_of_weights_and_its_own_number_of_legs():
    network = WholeBodyFoot(("spring_force",), (), limbs=4, hidden=2)
    assert Controller(network, limbs=4).n_weights == network.n_weights == 2 * (4 + 1 + 8)
    refused("commands 4 limbs; the controller has 6", Controller, network, limbs=6)
    with pytest.raises(TegotaeError, match="one network for all limbs; leave sharing out"):
        Controller(network, limbs=4, sharing=(0, 0, 1, 1))
    refused("no inputs", WholeBody, (), (), limbs=4, hidden=2)
    assert len(set(network.weight_names)) == network.n_weights


def test_the_cosine_law_without_an_offset_is_the_vanilla_action():
    heard = of_legs()
    zero = [jnp.zeros((3, 2))]
    np.testing.assert_array_equal(OffsetAction()(zero, heard), VanillaAction()((), heard))
    np.testing.assert_allclose(
        OffsetAction()([zero[0] + 0.5], heard), -heard["cos_phase"] - 0.5, rtol=1e-6
    )
    check(OffsetAction())


def test_a_corrected_foot_begins_on_its_ellipse_whatever_the_random_weights():
    ellipse = EllipticFoot(stride_m=0.3, shift_rad=0.2)
    term = CorrectedFoot(("phase",), hidden=3, around=ellipse)
    heard = of_legs()
    weights = term.initial(jax.random.key(3))
    assert float(jnp.abs(weights).max()) > 0.0
    say = jax.jit(lambda w: term(list(w), heard))
    at_first = say(weights[:, None, None] * jnp.ones((1, 3, 2)))
    np.testing.assert_allclose(at_first, ellipse((), heard), atol=1e-6)
    later = say(jnp.ones((term.n_weights, 3, 2)))
    assert (np.abs(np.asarray(later - at_first)) > 0.0).all()
    with pytest.raises(TegotaeError, match="it must be an EllipticFoot"):
        CorrectedFoot(("phase",), hidden=3, around=Sector())


def test_ellipses_under_one_clock_follow_the_first_leg_at_their_leads():
    ellipse = EllipticFoot(stride_m=0.3, shift_rad=0.2)
    leads = (0.0, np.pi, 1.0)
    settings = {"limbs": 3, "hidden": 2, "around": ellipse, "lead_rad": leads}
    term = WholeBodyCorrectedFoot(("spring_force",), ("phase",), **settings)
    heard = of_legs()
    weights = term.initial(jax.random.key(3))[:, None, None] * jnp.ones((1, 3, 2))
    sine, cosine = heard["sin_phase"][0], heard["cos_phase"][0]
    clock, size = jnp.arctan2(sine, cosine), jnp.hypot(sine, cosine)  # drawn, and so not of size 1
    turned = [(size * jnp.sin(clock + lead), size * jnp.cos(clock + lead)) for lead in leads]
    expected = [ellipse.place(*signals) for signals in turned]
    result = jax.jit(lambda w: term(list(w), heard))(weights)
    np.testing.assert_allclose(result, jnp.stack(expected, axis=1), atol=1e-6)
    refused("give it 3, one a leg", dataclasses.replace, term, lead_rad=(0.0,))
