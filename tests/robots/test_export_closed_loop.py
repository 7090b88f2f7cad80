"""Exported controllers drive the package's bodies: the same hops as the package's own run."""

import dataclasses

import jax
import my_parts
import numpy as np
import pytest

from compiled import Compiled, needs_gcc
from robots import (
    TICK_S,
    apexes_of_the_package,
    apexes_of_the_robots,
    as_simulated,
    driven,
    own_run,
)
from tegotae import Hopper
from tegotae.parts.bodies import Bar
from tegotae.parts.controller import Controller, Tegotae
from tegotae.parts.oscillators import OSCILLATORS, PhaseOscillator
from tegotae.parts.terms import (
    ConstantGain,
    Reflex,
    Sector,
    VanillaAction,
    VanillaReaction,
)
from tegotae.simulation.rollout import Timing
from tegotae.systems.controller_file import SavedController
from tegotae.systems.recipe import recipe
from tegotae_robots.c import Export

ALLOWED_M = 1e-3


def with_weights(controller: Controller, names: dict[tuple, float]) -> np.ndarray:
    """Weights that are zero but for those that are named."""
    weights = np.zeros(controller.n_weights)
    for path, value in names.items():
        weights[controller.weight_names.index(path)] = value
    return weights


def nearly_linear(role: str, signal: str, slope: float) -> dict[tuple, float]:
    """A network whose first neuron makes it nearly slope x signal, the signal as it sees it."""
    return {(role, "neuron", 0, signal): 0.1, (role, "neuron", 0, "output"): 10.0 * slope}


def gaits() -> dict[str, SavedController]:
    """Controllers that hop regularly; those with networks are made like the vanilla one."""
    learned = recipe("ARGT-rF-gF-tphif-w8").controller(40)
    like_vanilla = {
        **nearly_linear("action", "cos_phase", -1.0),
        **nearly_linear("reaction", "spring_force", 0.981),
        ("gain", "neuron", 0, "bias"): 1.0,
        ("gain", "neuron", 0, "output"): 2.6,
        **nearly_linear("actuation", "feedback", -3.13),
    }
    single = recipe("T-Fv").controller(20)
    pushes = {
        ("actuation", "neuron", 0, "velocity"): 2.0,
        ("actuation", "neuron", 0, "output"): 1.2,
    }
    harmonic = Controller(
        Reflex(),
        my_parts.DriftingPhase(),
        Tegotae(my_parts.HarmonicAction(), VanillaReaction(), ConstantGain()),
    )
    return {
        "a sector": SavedController.from_weights(
            recipe("V-sector-w8").controller(), np.array([1.0]), 8.0
        ),
        "a reflex": SavedController.from_weights(
            recipe("V-reflex-w8").controller(), np.array([2.0]), 8.0
        ),
        "networks for all terms": SavedController.from_weights(
            learned, with_weights(learned, like_vanilla), 8.0
        ),
        "the single network": SavedController.from_weights(
            single, with_weights(single, pushes), None
        ),
        "a user's oscillator": SavedController.from_weights(
            harmonic, np.array([-1.0, 0.0, 0.0, 0.0, 2.0]), 8.0
        ),
    }


def contact_force(program: Compiled, sensed: dict, pushed: float) -> list:
    """Return the reading of a load cell under the foot: F_k - c v + F_a, and nothing in the air."""
    damping = program.export.saved.body.damping_ns_per_m
    force = sensed["spring_force"] - damping * sensed["velocity"] + pushed
    return [max(force, 0.0) if sensed["height"] < 1.0 else 0.0]


def converted(program: Compiled, sensed: dict, pushed: float) -> list:
    """The same as the header's function makes the spring's force of it."""
    (contact,) = contact_force(program, sensed, pushed)
    return [program.number("spring_force", contact, sensed["velocity"], pushed)]


@pytest.fixture(scope="module")
def hops(tmp_path_factory):
    """The compiled gaits' apexes."""
    programs = [
        Compiled(Export(saved, TICK_S), tmp_path_factory.mktemp("c")) for saved in gaits().values()
    ]
    reflex = Export(gaits()["a reflex"], TICK_S)
    programs += [Compiled(reflex, tmp_path_factory.mktemp("c")) for _ in range(2)]
    measured = [as_simulated] * len(gaits()) + [contact_force, converted]
    heights = apexes_of_the_robots(programs, Hopper(), 1.2, 0.0, measured)
    return dict(zip((*gaits(), "fed with contact", "converted"), heights, strict=True))


@needs_gcc
@pytest.mark.parametrize("gait", gaits())
def test_the_compiled_controller_hops_as_the_simulated_one_does_for_twenty_seconds(gait, hops):
    times, heights = apexes_of_the_package(gaits()[gait])
    late = heights[times > 12.0]
    assert late.max() - late.min() < 0.01, "the gait that is compared is no regular one"
    assert len(late) > 5
    assert len(hops[gait]) == len(heights)
    assert np.abs(hops[gait] - heights).max() < ALLOWED_M


@needs_gcc
def test_the_force_of_contact_in_place_of_the_springs_is_another_gait_and_the_conversion_mends_it(
    hops,
):
    right, wrong, mended = (hops[x][-1] for x in ("a reflex", "fed with contact", "converted"))
    print(f"last apex {right:.3f} m, fed with contact {wrong:.3f} m, converted {mended:.3f} m")
    assert abs(wrong - right) > 0.3
    assert abs(mended - right) < 0.02


@pytest.mark.thorough
@needs_gcc
def test_two_compiled_legs_under_a_bar_hop_as_the_simulated_ones_do(tmp_path):
    terms = Tegotae(VanillaAction(), VanillaReaction(), ConstantGain())
    controller = Controller(Sector(), PhaseOscillator(), terms, limbs=2)
    saved = SavedController.from_weights(controller, np.array([1.0]), 8.0, Bar(inertia_ratio=1.6))
    phases = np.array([0.0, 1.0])
    times, heights = apexes_of_the_package(saved, phase_rad=phases[:, None])
    (result,) = apexes_of_the_robots([Compiled(Export(saved), tmp_path)], saved.body, 1.2, phases)
    assert len(result) == len(heights) > 5
    assert np.abs(result - heights).max() < ALLOWED_M
    assert times[-1] > 15.0  # in phase, so that both legs leave the ground


def on_another(oscillator: str) -> SavedController:
    """A regular gait of a vanilla leg with another oscillator; its own numbers as they start."""
    adapts = "adaptive" in oscillator  # its frequency is worn down by every load that lasts
    plain, sigma = ("V-sector-w8", 8.0) if adapts else ("V-reflex-w8", 1.0)
    controller = dataclasses.replace(recipe(plain).controller(), oscillator=OSCILLATORS[oscillator])
    weights = np.array(controller.initial(jax.random.key(0)))
    weights[controller.weight_names.index(("gain", "sigma"))] = sigma
    return SavedController.from_weights(controller, weights, 8.0)


@needs_gcc
@pytest.mark.thorough
@pytest.mark.parametrize("oscillator", [name for name in OSCILLATORS if name != "phase"])
def test_every_oscillator_hops_compiled_as_it_does_simulated(oscillator, tmp_path):
    saved = on_another(oscillator)
    times, heights = apexes_of_the_package(saved)
    late = heights[times > 12.0]
    if oscillator != "learned-adaptive-hopf":  # of which no regular gait is known
        assert late.max() - late.min() < 0.01, "the gait that is compared is no regular one"
    (result,) = apexes_of_the_robots(
        [Compiled(Export(saved, TICK_S), tmp_path)], Hopper(), 1.2, 0.0
    )
    assert len(result) == len(heights) > 5
    assert np.abs(result - heights).max() < ALLOWED_M


@needs_gcc
@pytest.mark.thorough
def test_learned_legs_of_a_walker_move_compiled_as_they_do_simulated(tmp_path):
    task = recipe("ARGT-t+phif@quadruped-c").experiment()
    weights = np.array(task.controller.initial(jax.random.key(1)))
    saved = SavedController.from_weights(task.controller, weights, task.omega, task.body)
    timing = Timing(duration_s=4.0, tick_s=0.004, frame_s=0.04)
    phases = np.linspace(0.0, 5.0, task.body.limbs)
    path = own_run(saved, timing, height_m=1.1, phase_rad=phases[:, None])
    result = driven(
        [Compiled(Export(saved, timing.tick_s), tmp_path)],
        task.body,
        1.1,
        phases,
        timing=timing,
        recorded=lambda state, contact: state.position,
    )
    every = round(timing.frame_s / timing.tick_s)
    of_robot = result[every - 1 :: every, 2, 0]
    of_package = np.asarray(path.height_m)[:, 0]
    assert np.ptp(of_package) > 0.01, "it does not move"
    assert np.abs(of_robot - of_package).max() < ALLOWED_M
