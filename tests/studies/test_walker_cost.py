"""The study of the cost of transport counts the work of a leg's axes by themselves."""

import jax.numpy as jnp
import pytest


def test_the_work_of_each_axis_of_a_leg_is_counted_by_itself(study):
    walker_cost = study("gaits.walker_cost")
    force_n = tuple(jnp.full((4, 1), x, "float32") for x in (1.0, 0.0, 1.0))
    rate = jnp.stack([jnp.full((4, 1), x, "float32") for x in (0.1, -0.1)])
    netted, by_axis = (
        body.leg_work(force_n, rate, rate, jnp.float32(0.01))
        for body in (walker_cost.Watched(), walker_cost.ByAxis())
    )
    assert netted.tolist() == [[0.0]] * 4
    assert by_axis.ravel().tolist() == pytest.approx([0.002] * 4)
