"""Short laws: names, numbers, and that they are what their formulas say."""

import jax.numpy as jnp
import numpy as np
import pytest

from refusals import refused
from tegotae import Hopper, Rollout, Scenario, TegotaeError, Timing
from tegotae.measures.check import check
from tegotae.parts.terms import Signals
from tegotae.systems.recipe import find_recipe, recipe
from tegotae.systems.resolve import resolve
from tegotae.systems.term_sets import LAWS, LAWS_OF_LEGS

NUMBERS = {"clock": 2, "load": 3, "offset": 4, "latch": 5, "decay": 5, "tuned": 4}
PHI, N = 0.7, 1.3
FEEDBACK = {
    "clock": lambda: 0.0,
    "load": lambda sigma: -sigma * N * 0.981 * np.cos(PHI),
    "offset": lambda o, sigma: -sigma * N * 0.981 * (np.cos(PHI) + o),
    "latch": lambda o, k, sigma: -sigma * (1 - k * N) * (np.cos(PHI) + o),
    "decay": lambda o, k, sigma: -sigma * np.exp(-k * N) * (np.cos(PHI) + o),
    "tuned": lambda sigma: -sigma * N * 0.981 * np.cos(PHI),
}


def test_there_are_six_and_each_has_its_numbers():
    assert {name: recipe(name).controller().n_weights for name in LAWS} == NUMBERS


@pytest.mark.parametrize("law", LAWS)
def test_the_feedback_is_that_of_the_formula(law):
    controller = recipe(law).controller()
    numbers = 0.5 + 0.1 * np.arange(controller.n_weights)
    values = {"spring_force": jnp.array([N * 0.981])}
    rhythm = {"sin_phase": jnp.sin(jnp.array([PHI])), "cos_phase": jnp.cos(jnp.array([PHI]))}
    signals = Signals({**values, **rhythm}, {"spring_force": 0.981})
    computed = controller.feedback(tuple(jnp.array([x]) for x in numbers), signals)
    feedback = [
        x
        for x, (part, _) in zip(numbers, controller.weight_names, strict=True)
        if part != "actuation"
    ]
    assert float(computed[0]) == pytest.approx(FEEDBACK[law](*feedback), rel=1e-5)


@pytest.mark.parametrize(
    "law",
    [
        law if law in ("load", "tuned") else pytest.param(law, marks=pytest.mark.thorough)
        for law in LAWS
    ],
)
def test_they_keep_the_contracts_of_terms_and_controllers(law):
    controller = recipe(law).controller()
    for term in controller.terms.values():
        check(term)
    check(controller, Hopper())


def test_a_clock_pushes_in_its_sector_whatever_it_feels():
    rollout = Rollout(controller=recipe("clock").controller(), timing=Timing(duration_s=3.0))
    out = rollout.run(np.array([[4.5, 0.5]]), Scenario(omega=5.0))
    assert np.all(out.feedback_rad_per_s == 0.0)
    pushing = out.actuator_force_n[:, 0] > 0.0
    late = (out.phase_rad[:, 0] > 4.4) & (out.phase_rad[:, 0] < 5.1)
    assert pushing.any()
    assert not (pushing & ~late).any()


@pytest.mark.parametrize("law", LAWS_OF_LEGS)
def test_on_legs_the_feet_stay_the_systems(law):
    controller = recipe(f"{law}@quadruped-c").controller()
    assert controller.actuation == recipe("V@quadruped-c").controller().actuation
    assert controller.n_weights == {"load": 3, "latch": 4, "decay": 4}[law]


def test_on_legs_the_ellipse_can_be_trained_too():
    controller = recipe("decay-t@quadruped-c").controller()
    actuation = recipe("V@quadruped-c").controller().actuation
    assert (controller.n_weights, controller.actuation.start) == (8, actuation)
    refused("no ellipse", lambda: recipe("decay-t@bar-light").controller())


def test_names_are_those_of_models():
    assert resolve("latch-w4").experiment().omega == 4.0
    assert recipe("latch").name == "latch-w8"
    for name in ("latch-x4", "latch-w", "latch-w.", "latch-w1.2.3"):
        assert find_recipe(name) is None


def test_a_frequency_that_is_none_or_a_budget_too_small_is_refused():
    refused("omega is 0", recipe, "latch-w0")
    with pytest.raises(TegotaeError, match="budget is 4, too small: latch has at least 5"):
        recipe("latch-w4").controller(4)
