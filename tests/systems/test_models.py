"""The 218 models of the study: how many, how they are called, how large they are."""

import itertools
from collections import Counter

import jax
import numpy as np
import pytest

from refusals import refused
from tegotae import Controller, Rollout, Scenario, TegotaeError, Timing
from tegotae.parts.terms import Network, Signals
from tegotae.systems.recipe import find_recipe, recipe, study_recipes
from tegotae.systems.term_sets import hidden_sizes

MODELS = study_recipes()
BUDGETS = (32, 96, 128, 1024, 4096)


def test_there_are_218_models():
    assert len(MODELS) == 218
    assert len(set(MODELS.values())) == 218
    assert all(name == model.name for name, model in MODELS.items())


def test_the_design_is_a_full_factorial():
    oscillating = [model for model in MODELS.values() if model.omega_t is not None]
    assert len(oscillating) == 216
    assert Counter(model.omega_t for model in oscillating) == {4.0: 108, 8.0: 108}
    feedback = Counter(
        (m.learned_terms.action, m.learned_terms.reaction, m.learned_terms.gain)
        for m in oscillating
    )
    actuation = Counter(m.actuation for m in oscillating)
    assert len(feedback) == 18
    assert set(feedback.values()) == {12}
    assert set(actuation) == {"sector", "reflex", "both", "tphi", "tf", "tphif"}
    assert set(actuation.values()) == {36}


def test_six_models_are_purely_vanilla_and_have_one_number_to_tune():
    pure = [model for model in MODELS.values() if model.controller().has_a_gain_alone]
    assert len(pure) == 6
    for model in pure:
        assert model.terms.architecture == "V"
        assert model.controller().n_weights == 1


def test_the_observation_is_all_that_any_term_senses():
    velocity = {"velocity"}
    for model in MODELS.values():
        read = {name for term in model.controller().terms.values() for name in term.reads}
        sensed = read & {"spring_force", "velocity", "height"}
        assert sensed & velocity == set(model.observation) & velocity, model.name


def test_learned_terms_are_the_networks_of_the_controller():
    roles = {"action": "A", "reaction": "R", "gain": "G", "actuation": "T"}
    for model in MODELS.values():
        terms = model.controller().terms
        networks = {roles[r] for r, term in terms.items() if isinstance(term, Network)}
        assert networks == set(model.terms.learned), model.name


# Budgets.


@pytest.mark.parametrize("budget", BUDGETS)
def test_no_model_exceeds_the_budget_nor_wastes_what_one_more_neuron_could_use(budget):
    for model in MODELS.values():
        if model.controller().has_a_gain_alone:
            continue
        controller = model.controller(budget)
        costs = [
            len(term.reads) + 2 for term in controller.terms.values() if isinstance(term, Network)
        ]
        assert budget - min(costs) < controller.n_weights <= budget, model.name


def by_brute_force(costs: list[int], budget: int) -> tuple[int, int]:
    """The largest total of one or more neurons each within the budget, and its most even split."""
    best = (0, 0)
    for sizes in itertools.product(*(range(1, budget // cost + 1) for cost in costs)):
        total = sum(h * cost for h, cost in zip(sizes, costs, strict=True))
        if total <= budget:
            best = max(best, (total, min(sizes) - max(sizes)))
    return best


@pytest.mark.parametrize("budget", [32, 95, 96])
@pytest.mark.parametrize("n_inputs", [[1], [2], [2, 1], [2, 3], [2, 1, 3], [2, 2, 4], [4, 1, 1]])
def test_hidden_sizes_use_the_budget_up_and_share_it_evenly(n_inputs, budget):
    costs = [n + 2 for n in n_inputs]
    sizes = [*hidden_sizes("mine", {f"{i}": cost for i, cost in enumerate(costs)}, budget).values()]
    total = sum(h * cost for h, cost in zip(sizes, costs, strict=True))
    assert (total, min(sizes) - max(sizes)) == by_brute_force(costs, budget)


@pytest.mark.parametrize("budget", [0, -96, 9.5, True])
def test_a_budget_that_is_no_count_is_refused(budget):
    refused(r"budget is .* whole number", lambda: recipe("ART").controller(budget))


@pytest.mark.parametrize("name", ["ARGT-rFv-gFv-tphif-w8", "ART", "T-Fv"])
def test_a_budget_too_small_for_a_neuron_each_is_refused(name):
    refused("too small", lambda: recipe(name).controller(3))


# Finding.


def test_a_bare_architecture_names_its_plainest_member():
    assert recipe("V").name == "V-reflex-w8"
    assert recipe("ART").name == "ART-rF-tphif-w8"
    assert recipe("ARGT").name == "ARGT-rF-gF-tphif-w8"
    assert recipe("T").name == "T-F"


def test_every_model_is_found_by_its_name():
    assert all(recipe(name) is model for name, model in MODELS.items())


def test_a_model_may_be_trained_at_any_frequency():
    assert recipe("ART-rF-tphif-w5").omega_t == 5.0
    assert recipe("V-sector-w2.5+hopf").name == "V-sector-w2.5+hopf"
    assert "ART-rF-tphif-w5" not in study_recipes()
    refused("omega is 0; it must be greater than 0", recipe, "ART-rF-tphif-w0")


@pytest.mark.parametrize("name", ["AR-w5", "v-sector-w4", "", "nonsense"])
def test_an_unknown_name_is_refused_with_the_nearest_ones(name):
    with pytest.raises(TegotaeError, match=f"^no model is called {name!r}; ") as raised:
        recipe(name)
    assert "\n" not in str(raised.value)
    names = str(raised.value).split("; ")[1].rstrip("?").split(": ")[-1].split(", ")
    assert all(find_recipe(suggestion.removeprefix("did you mean ")) for suggestion in names)


# Every model runs.


def evaluate(controller: Controller) -> tuple[np.ndarray, np.ndarray]:
    """Feedback and force of a controller with random weights, at eight instants."""
    random = np.random.default_rng(0).normal(size=(controller.n_weights, 1))
    weights = tuple(np.repeat(random.astype("float32"), 8, axis=1))
    phase = np.linspace(0.0, 6.0, 8, dtype="float32")
    signals = Signals(
        {
            "sin_phase": np.sin(phase),
            "cos_phase": np.cos(phase),
            "spring_force": np.linspace(0.0, 3.0, 8, dtype="float32"),
            "velocity": np.linspace(-2.0, 2.0, 8, dtype="float32"),
        }
    )
    feedback = controller.feedback(weights, signals)
    force = controller.command(weights, signals.adding(feedback=feedback), 4.0)
    return np.asarray(feedback), np.asarray(force)


def test_every_model_has_a_finite_feedback_and_a_force_within_the_actuators_limits():
    distinct = {model.controller() for model in MODELS.values()}
    assert len(distinct) == 110, "the two training frequencies share their controllers"
    for controller in distinct:
        feedback, force = evaluate(controller)
        assert feedback.shape == force.shape == (8,), controller
        assert np.isfinite(feedback).all(), controller
        assert ((force >= 0.0) & (force <= 4.0)).all(), controller
        assert feedback.any() == (controller.oscillator is not None), controller


def test_initial_weights_of_every_model_fit_it():
    for name in MODELS:
        controller = recipe(name).controller()
        initial = jax.eval_shape(controller.initial, jax.random.key(0))
        assert initial.shape == (controller.n_weights,), name


@pytest.mark.parametrize(
    "name",
    [
        "V-sector-w4",
        "VG-gFv-both-w8",
        pytest.param("R-rFv-reflex-w4", marks=pytest.mark.thorough),
        pytest.param("AGT-gF-tf-w4", marks=pytest.mark.thorough),
        pytest.param("AR-rF-sector-w8", marks=pytest.mark.thorough),
        "ARGT-rFv-gFv-tphif-w8",
        "T-Fv",
    ],
)
def test_a_model_of_each_kind_runs(name):
    model = recipe(name)
    controller = model.controller()
    keys = jax.random.split(jax.random.key(1), 4)
    weights = np.stack([controller.initial(key) for key in keys])
    rollout = Rollout(controller=controller, timing=Timing(duration_s=1.0))
    out = rollout.run(weights, Scenario(omega=model.omega_t or 6.0))
    assert out.height_m.shape == (50, 4)
    assert not out.failed.any()
    assert np.isfinite(out.height_m).all()
    assert out.touchdown_time_s.shape == (50, 4)
    assert np.isfinite(out.touchdown_time_s).any(axis=0).all()
