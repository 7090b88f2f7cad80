"""A body of a user's own is dropped without a push before it is trained or evaluated."""

import warnings
from dataclasses import dataclass

import pytest
from springs import Hertz

from tegotae import Hopper, TegotaeError
from tegotae.measures.evaluation import Protocol, require_evaluable
from tegotae.parts.parameters import traceable
from tegotae.simulation.checks.passive import PassiveBodyWarning, check_passive, energy_of_drop
from tegotae.systems.recipe import recipe

TICK_S = 0.004


@traceable
@dataclass(frozen=True, kw_only=True)
class Gaining(Hopper):
    """A hopper that every tick in stance makes faster."""

    def advance(self, state, push, ground_m, tick_s):
        state, contact = super().advance(state, push, ground_m, tick_s)
        faster = 1.0 + 0.01 * contact.stance_share
        return state._replace(velocity=faster * state.velocity), contact


def test_the_energy_of_an_undamped_drop_stays_and_that_of_a_damped_one_goes():
    assert energy_of_drop(Hopper(damping_ns_per_m=0.0), 1.2, 4.0, TICK_S) == pytest.approx(1.0)
    assert energy_of_drop(Hopper(), 1.2, 4.0, TICK_S)[-1] < 0.0


BEFORE = {
    "training": lambda body: recipe("AR").experiment(budget=40, body=body).check(),
    "evaluation": lambda body: require_evaluable(
        recipe("V-reflex-w8").controller(), body, Protocol()
    ),
}


@pytest.mark.parametrize("long_work", BEFORE)
def test_a_body_that_hops_on_without_a_push_is_named_before_long_work(long_work):
    with pytest.warns(PassiveBodyWarning, match=r"Hertz .* from 1.2 m .* still has 100% of its"):
        BEFORE[long_work](Hertz(damping_ns_per_m=0.0))
    with warnings.catch_warnings():
        warnings.simplefilter("error", PassiveBodyWarning)
        BEFORE[long_work](Hertz())


def test_a_body_that_climbs_without_work_is_refused():
    with pytest.raises(TegotaeError, match=r"Gaining .* climbs without work: its energy rises to"):
        check_passive(Gaining(damping_ns_per_m=0.0), 1.2, 4.0, TICK_S)
