"""The controller: terms put together, their weights in one vector, and what is refused."""

from dataclasses import dataclass

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from refusals import refused
from tegotae import Controller, Hopper, Rollout, Scenario, Timing
from tegotae.parts.controller import Tegotae
from tegotae.parts.oscillators import PhaseOscillator
from tegotae.parts.terms import (
    ConstantGain,
    LearnedActuation,
    Network,
    Reflex,
    Sector,
    Signals,
    Term,
    VanillaAction,
    VanillaReaction,
)

PHASE = np.array([0.3, 2.0, 5.0])
SPRING = np.array([0.0, 1.5, 3.0])


def signals(**overrides) -> Signals:
    values = {
        "sin_phase": np.sin(PHASE),
        "cos_phase": np.cos(PHASE),
        "spring_force": SPRING,
        "velocity": np.array([-1.0, 0.5, 2.0]),
        **overrides,
    }
    return Signals({name: jnp.asarray(x, "float32") for name, x in values.items()})


def art() -> Controller:
    return Controller(
        LearnedActuation(("phase", "feedback"), 2),
        PhaseOscillator(),
        Tegotae(Network(("phase",), 3), Network(("spring_force",), 4), ConstantGain()),
    )


def test_the_weights_lie_in_the_order_action_reaction_gain_actuation():
    assert art().layout == {
        "action": slice(0, 12),
        "reaction": slice(12, 24),
        "gain": slice(24, 25),
        "actuation": slice(25, 35),
    }
    assert art().n_weights == 35


def test_initial_weights_are_one_vector_that_follows_the_key():
    first, again = (art().initial(jax.random.key(3)) for _ in range(2))
    assert first.shape == (35,)
    np.testing.assert_array_equal(first, again)
    assert first[24] == ConstantGain().start
    assert not np.array_equal(first, art().initial(jax.random.key(4)))


def test_the_feedback_is_the_product_of_gain_action_and_reaction():
    controller = art()
    weights = jnp.asarray(np.random.default_rng(0).normal(size=(35, 3)), "float32")
    terms, layout = controller.tegotae, controller.layout
    product = (
        terms.gain(weights[layout["gain"]], signals())
        * terms.action(weights[layout["action"]], signals())
        * terms.reaction(weights[layout["reaction"]], signals())
    )
    np.testing.assert_allclose(controller.feedback(weights, signals()), product, rtol=1e-6)


def test_the_gain_enters_the_feedback_once():
    vanilla = Controller(
        Reflex(), PhaseOscillator(), Tegotae(VanillaAction(), VanillaReaction(), ConstantGain())
    )
    feedback = vanilla.feedback(jnp.full((1, 3), 3.0), signals())
    np.testing.assert_allclose(feedback, -3.0 * np.cos(PHASE) * SPRING, rtol=1e-6)


def test_without_tegotae_terms_there_is_no_feedback():
    single = Controller(LearnedActuation(("spring_force", "velocity"), 24))
    assert list(single.terms) == ["actuation"]
    assert single.n_weights == 96
    feedback = single.feedback(jnp.ones((96, 3)), signals())
    np.testing.assert_array_equal(feedback, 0.0)


@pytest.mark.parametrize(("output", "force"), [(-7.0, 0.0), (1.5, 1.5), (9.0, 4.0)])
def test_the_force_saturates_between_zero_and_the_actuators_most(output, force):
    @dataclass(frozen=True)
    class Fixed(Reflex):
        def __call__(self, weights, signals):
            return jnp.full_like(signals["feedback"], output)

    commanded = Controller(Fixed()).command([], signals(feedback=np.zeros(3)), 4.0)
    np.testing.assert_array_equal(commanded, force)


def test_equal_controllers_are_one_static_argument():
    assert art() == art()
    assert hash(art()) == hash(art())


# Misuse.


def run(controller: Controller, body: Hopper | None = None) -> None:
    rollout = Rollout(controller=controller, timing=Timing(duration_s=0.02))
    rollout.run(np.zeros(controller.n_weights), Scenario(omega=5.0), body)


@pytest.mark.parametrize(
    ("controller", "message"),
    [
        (
            Controller(
                Reflex(),
                PhaseOscillator(),
                Tegotae(VanillaAction(), Network(("spring_forse",), 3), ConstantGain()),
            ),
            "^the reaction term reads 'spring_forse', which nothing provides; .*spring_force",
        ),
        (
            Controller(LearnedActuation(("phase",), 3)),
            "^the actuation term reads 'sin_phase', which nothing provides",
        ),
        (
            Controller(
                Sector(),
                PhaseOscillator(),
                Tegotae(VanillaAction(), VanillaReaction(), Network(("feedback",), 3)),
            ),
            "^the gain term reads 'feedback', which nothing provides",
        ),
    ],
    ids=["misspelt", "phase-without-oscillator", "feedback-of-itself"],
)
def test_a_term_that_reads_what_nothing_provides_is_refused(controller, message):
    refused(message, run, controller)


def test_an_actuation_may_read_the_feedback_and_the_bodys_senses():
    run(
        Controller(
            LearnedActuation(("feedback", "height", "velocity"), 2),
            PhaseOscillator(),
            Tegotae(VanillaAction(), VanillaReaction(), ConstantGain()),
        )
    )


def test_a_new_term_needs_nothing_but_its_own_class():
    @dataclass(frozen=True)
    class SaturatedReaction(Term):
        @property
        def reads(self):
            return ("spring_force",)

        def __call__(self, weights, signals):
            return jnp.minimum(signals["spring_force"], 1.0)

    tegotae = Tegotae(VanillaAction(), SaturatedReaction(), ConstantGain())
    controller = Controller(Reflex(), PhaseOscillator(), tegotae)
    feedback = controller.feedback(jnp.ones((1, 3)), signals())
    np.testing.assert_allclose(feedback, -np.cos(PHASE) * np.minimum(SPRING, 1.0), rtol=1e-6)
    run(controller)
