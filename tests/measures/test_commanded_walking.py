"""Fitness of a law for a range of commands: cheap for its speed, as fast as commanded."""

import dataclasses

import jax.numpy as jnp
import numpy as np
import pytest

from refusals import refused
from tegotae import Scenario, TegotaeError, Timing
from tegotae.measures.objectives.walking import COMMANDED_TRACKING as TRACKING, CommandedWalking
from tegotae.parts.bodies import Walker
from tegotae.simulation.recorder import Trajectory
from tegotae.simulation.world import Uniform
from tegotae.systems.recipe import recipe

FRONT = ((0.1, 0.8), (0.3, 0.4), (0.6, 0.4))
WALK = CommandedWalking(front=FRONT, advance_m_per_rad=0.1, settle_s=10.0)
TIMING = Timing(duration_s=20.0, tick_s=0.01, frame_s=0.1)
TIME = 0.1 * np.arange(1, 201)[:, None]


def fitness(speed, power, omega, mass=1.0):
    """Return the fitness of a walk straight ahead; each argument is a number or one a lane."""
    speed, power, omega, mass = np.broadcast_arrays(
        *map(np.atleast_1d, (speed, power, omega, mass))
    )
    still = jnp.asarray(0.0 * TIME * speed)
    frames = {"x_m": TIME * speed, "work_absolute_j": TIME * power, "time_s": TIME + still}
    walked = Trajectory(
        **{name: jnp.asarray(x) for name, x in frames.items()},
        y_m=still,
        yaw_rad=still,
        failed=still > 1.0,
    )
    scenario = Scenario(omega=jnp.asarray(omega), changes={"mass_kg": jnp.asarray(mass)})
    return np.asarray(WALK(walked, scenario, Walker(), TIMING)["fitness"])


def test_who_costs_what_the_front_costs_at_that_speed_gains_nothing():
    result = fitness(speed=[0.1, 0.2, 0.6], power=[0.08, 0.12, 0.24], omega=[1.0, 2.0, 6.0])
    np.testing.assert_allclose(result, 0.0, atol=2e-3)


def test_half_the_cost_at_one_speed_is_worth_what_double_at_another_costs():
    cheap, dear = fitness(speed=0.3, power=[0.06, 0.24], omega=3.0)
    assert cheap == pytest.approx(np.log(2.0), abs=2e-3)
    assert dear == pytest.approx(-cheap, abs=2e-3)


def test_the_wanted_speed_follows_from_the_command_of_each_episode():
    result = fitness(speed=0.3, power=0.12, omega=[3.0, 2.0, 6.0])
    assert result == pytest.approx([0.0, -0.5 * TRACKING, -0.5 * TRACKING], abs=4e-3)


def test_a_heavier_body_may_need_more():
    assert fitness(0.3, 0.144, 3.0, mass=1.2) == pytest.approx([0.0], abs=2e-3)


def test_who_stands_is_better_than_who_goes_backwards_and_worse_than_who_creeps():
    back, stands, creeps = fitness(speed=[-0.02, 0.0, 0.02], power=0.1, omega=3.0)
    assert back < stands < creeps


def test_another_front_is_data_of_the_same_program():
    second = dataclasses.replace(WALK, front=((0.2, 0.5), (0.3, 0.3), (0.5, 0.6)), tracking=1.0)
    assert second.program == WALK.program


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"front": ((0.1, 0.5),)}, "a front has two speeds at least"),
        ({"front": ((0.3, 0.5), (0.2, 0.5))}, "must rise"),
        ({"front": ((0.1, 0.5), (0.2, 0.0))}, "a cost of the front"),
        ({"advance_m_per_rad": 0.0}, "advance_m_per_rad"),
    ],
)
def test_a_front_that_is_none_is_refused(settings, message):
    refused(message, dataclasses.replace, WALK, **settings)


def test_commands_that_no_walker_of_the_front_follows_are_refused_before_training():
    walk = recipe("AR@quadruped-c")
    wide = (Uniform("omega", low=1.0, high=9.0),)
    with pytest.raises(TegotaeError, match=r"omega 9 commands .* choose omega from 1 to 6"):
        walk.experiment(objective=WALK, conditions=wide)
    refused("no oscillator", lambda: recipe("T-F@quadruped-c").experiment(objective=WALK))
