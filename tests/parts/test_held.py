"""A controller with its feedback held at a constant is a clock."""

import dataclasses

import jax
import numpy as np
import pytest

from tegotae._support.errors import TegotaeError
from tegotae.parts.bodies import Hopper
from tegotae.parts.held import with_held_feedback
from tegotae.simulation.rollout import Rollout, Scenario, Timing
from tegotae.simulation.summaries import KeptChannels
from tegotae.systems.recipe import recipe

SECOND = Timing(duration_s=1.0, tick_s=0.001)


def rolled_out(controller, weights, omega):
    rollout = Rollout(controller=controller, timing=SECOND, summary=KeptChannels(None))
    return rollout.run(weights, Scenario(omega, height_m=1.1), Hopper())


def learned(name="ART-rF-tphi-w4", runs=2):
    controller = recipe(name).controller()
    return controller, np.stack([controller.initial(jax.random.key(k)) for k in range(runs)])


def test_without_its_feedback_the_phase_runs_at_omega():
    clock = rolled_out(*with_held_feedback(*learned()), omega=4.0)
    phase = np.asarray(clock.phase_rad)
    assert np.unwrap(phase, axis=0)[-1] == pytest.approx([4.0, 4.0], abs=1e-3)


def test_a_constant_feedback_is_another_frequency():
    controller, weights = learned()
    slower = rolled_out(*with_held_feedback(controller, weights, [-0.5, 0.25]), omega=4.0)
    reference = rolled_out(*with_held_feedback(controller, weights), omega=np.array([3.5, 4.25]))
    for name in ("height_m", "phase_rad"):
        np.testing.assert_allclose(getattr(slower, name), getattr(reference, name), atol=1e-3)


def test_an_actuation_on_the_feedback_reads_the_constant():
    controller, weights = learned("ART-rF-tphif-w4")
    paths = {
        f: rolled_out(*with_held_feedback(controller, weights, f), omega=4.0 - f)
        for f in (0.0, 1.0)
    }
    np.testing.assert_allclose(paths[0.0].phase_rad, paths[1.0].phase_rad, atol=1e-3)
    assert not np.allclose(paths[0.0].impulse_ns, paths[1.0].impulse_ns)


def test_each_set_of_weights_keeps_its_own_actuation():
    controller, rows = learned()
    four = dataclasses.replace(controller, limbs=4, sharing=(0, 0, 1, 1))
    clock, weights = with_held_feedback(four, rows.reshape(-1), 0.5)
    alone = [with_held_feedback(controller, row, 0.5)[1] for row in rows]
    assert clock.sharing == four.sharing
    np.testing.assert_array_equal(weights, np.concatenate(alone))


def test_one_network_has_no_feedback_to_hold():
    with pytest.raises(TegotaeError, match="no feedback that could be held"):
        with_held_feedback(
            recipe("T-F").controller(), np.zeros(recipe("T-F").controller().n_weights)
        )
