"""Exported controllers against the package, tick by tick: the same numbers, and never a bad one."""

import dataclasses
from pathlib import Path

import jax
import jax.numpy as jnp
import my_parts
import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from separate_hoppers import SeparateHoppers

import compiled
from compiled import Compiled, needs_gcc
from tegotae import Hopper
from tegotae.parts.bodies import Bar, Walker
from tegotae.parts.controller import Controller, Tegotae
from tegotae.parts.couplings import LearnedCoupling, Neighbours
from tegotae.parts.oscillators import (
    PLANAR,
    Clamped,
    Learned,
    PhaseOscillator,
    PhaseState,
    VanDerPol,
)
from tegotae.parts.terms import (
    ConstantGain,
    EllipticFoot,
    LearnedActuation,
    LearnedFoot,
    Network,
    Reflex,
    Sector,
    SectorAndReflex,
    Signals,
    VanillaAction,
    VanillaReaction,
)
from tegotae.simulation.integrators import (
    decide,
    held,
    phase_of,
    push,
    settled,
    to_limbs,
    to_units,
    with_oscillator,
)
from tegotae.systems.controller_file import SavedController
from tegotae.systems.recipe import recipe
from tegotae.systems.term_sets import LAWS
from tegotae_robots.c import Export

ALPHA = 4.0
LANES = 64
VANILLA = Tegotae(VanillaAction(), VanillaReaction(), ConstantGain())


def saved(controller: Controller, body=None, omega: float | None = 8.0, seed: int = 0):
    """A controller with random weights."""
    weights = np.asarray(controller.initial(jax.random.key(seed)), float)
    omega = None if controller.oscillator is None else omega
    return SavedController.from_weights(controller, 2.0 * weights, omega, body or Hopper())


def said_by_the_package(export: Export, leaves: np.ndarray, inputs: np.ndarray):
    """Outputs [names, limbs, lanes] and next states [leaves, limbs, lanes], without compiling.

    `leaves` are [leaves, limbs, lanes], `inputs` [senses, limbs, lanes].
    """
    controller, body = export.saved.controller, export.saved.body
    limbs, lanes = leaves.shape[1] if leaves.size else export.limbs, inputs.shape[-1]

    def of_limbs(x):
        return jnp.asarray(x[0] if limbs == 1 else x, jnp.float32)

    shape = (*controller.limb_shape, lanes)
    weights = controller.spread([jnp.full((lanes,), w, jnp.float32) for w in export.weights])
    omega = jnp.full(shape, export.saved.omega or 0.0, jnp.float32)
    state = ()
    if controller.oscillator is not None:
        structure = jax.tree.structure(controller.oscillator.start(jnp.zeros(1)))
        state = jax.tree.unflatten(structure, [of_limbs(x) for x in leaves])
    sensed = {
        n: to_units(controller, of_limbs(x)) for n, x in zip(export.senses, inputs, strict=True)
    }
    sensed = sensed or {"nothing": jnp.zeros(shape, jnp.float32)}
    heard = with_oscillator(controller, Signals(sensed, export.scales), state)
    message = decide(
        controller,
        weights,
        omega,
        heard,
        state,
        body.max_force_n,
        rate_scale=body.rate_scale,
    )
    phase = phase_of(controller, state, message.feedback)
    original = controller.actuation, controller.of_part("actuation", weights)
    pushed = push(*original, body.max_force_n, message.command, phase, phase, omega)
    pushed = to_limbs(controller, pushed).mean_n
    commands = [pushed] if len(export.commands) == 1 else list(pushed)
    order = controller.wiring or tuple(range(limbs))

    def by_limb(x):
        return x if limbs == 1 else x[jnp.asarray([order.index(i) for i in range(limbs)])]

    outputs = [*commands, by_limb(message.feedback)]
    if export.has_phase:
        outputs.append(by_limb(phase))
    updated = settled(controller, held(state, message.rate, jnp.float32(export.tick_s)))
    return (
        np.stack([np.reshape(x, (limbs, lanes)) for x in outputs]),
        [np.reshape(x, (limbs, lanes)) for x in jax.tree.leaves(updated)],
    )


def check_parity(export: Export, folder: Path, seed: int = 0) -> None:
    """Random states and inputs through both: the same outputs and next states."""
    program, random = Compiled(export, folder), np.random.default_rng(seed)
    limbs = export.limbs
    leaves = random.uniform(0.0, 6.28, (program.leaves, limbs, LANES)).astype(np.float32)
    size = {"spring_force": 3.0, "velocity": 4.0, "height": 1.5}
    inputs = np.stack(
        [random.uniform(-0.2, 1.0, (limbs, LANES)) * size.get(n, 1.0) for n in export.senses]
    ).astype(np.float32)
    outputs, updated = said_by_the_package(export, leaves, inputs)
    sizes = np.maximum(np.abs(outputs).max(axis=(1, 2)), 1e-3)
    program.init(np.zeros(limbs) if limbs > 1 else 0.0)
    for lane in range(LANES):
        if program.leaves:
            program.oscillators[:] = leaves[:, :, lane].T
        result = program.step(inputs[:, :, lane])
        error = np.abs(result - outputs[:, :, lane]) / np.maximum(
            np.abs(outputs[:, :, lane]), sizes[:, None]
        )
        assert error.max() < 1e-5, (lane, result, outputs[:, :, lane])
        for leaf, of_package in enumerate(updated):
            gap = np.abs(program.oscillators[:, leaf] - of_package[:, lane])
            assert np.minimum(gap, np.abs(2.0 * np.pi - gap)).max() < 1e-4
    assert program.faults == 0


@dataclasses.dataclass(frozen=True)
class LearnedPace(PhaseOscillator):
    """An oscillator with weights: `φ̇ = a ω + b f`."""

    @property
    def n_weights(self) -> int:
        return 2

    def initial(self, key: jax.Array) -> jax.Array:
        return jax.random.normal(key, (2,))

    def rate(self, state, omega, feedback, weights=()) -> PhaseState:
        return PhaseState(weights[0] * omega + weights[1] * feedback)


ARCHITECTURES = (
    "V-sector-w8", "V-reflex-w8", "V-both-w4", "VG-gF-reflex-w8", "VT-tphif-w8", "VGT-gFv-tf-w8",
    "A-sector-w8", "AR-rFv-both-w8", "AG-gF-reflex-w4", "ART-rF-tphif-w8", "RG-rF-gFv-sector-w8",
    "RGT-rFv-gF-tphi-w8", "ARG-rF-gF-reflex-w8", "ARGT-rFv-gFv-tphif-w8", "R-rF-both-w8",
    "AGT-gF-tphi-w8", "RT-rFv-tf-w8", "AT-tphi-w8", "T-F", "T-Fv",
)  # fmt: skip


SAMPLED = ("V-sector-w8", "AR-rFv-both-w8", "ART-rF-tphif-w8", "ARGT-rFv-gFv-tphif-w8", "T-Fv")


@needs_gcc
@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=() if name in SAMPLED else pytest.mark.thorough)
        for name in ARCHITECTURES
    ],
)
def test_every_architecture_says_in_c_what_it_says_in_the_package(name, tmp_path):
    model = recipe(name)
    export = Export(saved(model.controller(40), omega=model.omega_t))
    check_parity(export, tmp_path)


OTHERS = {
    "an oscillator and a term of a user": Controller(
        Reflex(),
        my_parts.DriftingPhase(),
        Tegotae(my_parts.HarmonicAction(), VanillaReaction(), ConstantGain()),
    ),
    "an oscillator with weights": Controller(Sector(), LearnedPace(), VANILLA),
    **{
        f"the oscillator {type(each).__name__}": Controller(Reflex(), each, VANILLA)
        for each in (*PLANAR.values(), Learned(VanDerPol()))
    },
    "a frozen oscillator": Controller(SectorAndReflex(), Clamped(PhaseOscillator()), VANILLA),
    "an oscillator with a floor": Controller(Sector(), PhaseOscillator(2.0), VANILLA),
    "a feedback that saturates": Controller(
        Reflex(), PhaseOscillator(), dataclasses.replace(VANILLA, limit_rad_per_s=5.0)
    ),
    "a network too wide to be written out": Controller(
        LearnedActuation(("phase", "feedback"), 45), PhaseOscillator(), VANILLA
    ),
}


@needs_gcc
@pytest.mark.parametrize("which", OTHERS)
def test_what_the_paper_does_not_have_is_exported_by_the_same_way(which, tmp_path):
    check_parity(Export(saved(OTHERS[which])), tmp_path)


SEVERAL = {
    "two legs with shared weights": (Controller(Sector(), PhaseOscillator(), VANILLA, 2), Bar()),
    "two legs, crossed, coupled and each with weights of its own": (
        Controller(
            SectorAndReflex(),
            PhaseOscillator(),
            Tegotae(VanillaAction(), Network(("spring_force", "pitch"), 2), ConstantGain()),
            2,
            LearnedCoupling(),
            sharing=(0, 1),
            wiring=(1, 0),
        ),
        Bar(inertia_ratio=0.6),
    ),
    "three hoppers, each unit on the next one's leg": (
        Controller(Reflex(), PhaseOscillator(), VANILLA, 3, sharing=(0, 1, 2), wiring=(1, 2, 0)),
        SeparateHoppers(hoppers=3),
    ),
    "four feet along ellipses with neighbours": (
        Controller(
            EllipticFoot(shift_rad=0.4),
            PhaseOscillator(),
            VANILLA,
            4,
            Neighbours(((0, 1), (2, 3)), 1.5, 0.3),
        ),
        Walker(),
    ),
    "four feet where networks say": (
        Controller(LearnedFoot(("phase", "pitch"), 2), PhaseOscillator(), VANILLA, 4),
        Walker(),
    ),
}


@needs_gcc
@pytest.mark.parametrize("law", [law for law in LAWS if law != "clock"])  # which senses nothing
def test_short_laws_say_in_c_what_they_say_in_the_package(law, tmp_path):
    check_parity(Export(saved(recipe(law).controller())), tmp_path)


@pytest.mark.parametrize("which", SEVERAL)
def test_networks_of_several_limbs_say_in_c_what_they_say_in_the_package(which, tmp_path):
    controller, body = SEVERAL[which]
    check_parity(Export(saved(controller, body, 2.0)), tmp_path)


@st.composite
def controllers(draw) -> Controller:
    """Controllers of any of the package's terms, and of users' ones."""
    sense = st.sampled_from((("spring_force",), ("spring_force", "velocity"), ("height",)))
    hidden = st.integers(1, 4)
    action = draw(
        st.sampled_from((VanillaAction(), my_parts.HarmonicAction(), Network(("phase",), 3)))
    )
    reaction = draw(
        st.one_of(st.just(VanillaReaction()), st.builds(Network, inputs=sense, hidden=hidden))
    )
    gain = draw(st.one_of(st.just(ConstantGain()), st.builds(Network, inputs=sense, hidden=hidden)))
    actuation = draw(
        st.one_of(
            st.builds(Sector, start_rad=st.floats(0.0, 6.0), width_rad=st.floats(0.0, 3.0)),
            st.just(Reflex()),
            st.builds(
                LearnedActuation,
                inputs=st.sampled_from((("phase", "feedback"), ("phase", "velocity"))),
                hidden=hidden,
            ),
        )
    )
    oscillator = draw(st.sampled_from((PhaseOscillator(), my_parts.DriftingPhase())))
    return Controller(actuation, oscillator, Tegotae(action, reaction, gain))


@needs_gcc
@settings(max_examples=8)
@given(controllers(), st.integers(0, 10_000), st.sampled_from((0.001, 0.004)))
def test_random_controllers_say_in_c_what_they_say_in_the_package(
    tmp_path_factory, controller, seed, tick_s
):
    export = Export(saved(controller, seed=seed), tick_s)
    check_parity(export, tmp_path_factory.mktemp("c"), seed)


@pytest.fixture(scope="module")
def unbounded(tmp_path_factory):
    """A learned controller with two inputs, compiled."""
    if compiled.shutil.which("gcc") is None:
        pytest.skip("gcc is not installed")
    model = recipe("ARGT-rFv-gFv-tphif-w8")
    export = Export(saved(model.controller(40)))
    return Compiled(export, tmp_path_factory.mktemp("c"))


ANY = st.floats(width=32, allow_nan=True, allow_infinity=True)


@settings(max_examples=200)
@given(st.lists(st.tuples(ANY, ANY), min_size=1, max_size=20), ANY)
def test_whatever_is_measured_the_force_stays_within_zero_and_alpha(unbounded, inputs, phase):
    unbounded.init(phase)
    for entry in inputs:
        force, feedback, reached = unbounded.step(entry)[:, 0]
        assert 0.0 <= force <= ALPHA
        assert np.isfinite(feedback)
        assert 0.0 <= reached < 2.0 * np.pi + 1e-6


def test_an_input_that_is_no_number_counts_as_zero_and_is_told(unbounded):
    unbounded.init(1.0)
    at_zero = unbounded.step([0.0, 0.0])
    assert not unbounded.fault
    unbounded.init(1.0)
    assert (unbounded.step([np.nan, -np.inf]) == at_zero).all()
    assert unbounded.fault
    assert unbounded.faults == 1
    unbounded.step([0.0, 0.0])
    assert not unbounded.fault
    assert unbounded.faults == 1


def test_the_force_of_the_spring_follows_from_contact_force_and_from_length(unbounded):
    body = Hopper()
    length, velocity, actuator = 0.8, -1.5, 2.0
    spring = body.stiffness_n_per_m * (body.rest_length_m - length)
    contact = spring - body.damping_ns_per_m * velocity + actuator
    assert unbounded.number("spring_force", contact, velocity, actuator) == pytest.approx(spring)
    assert unbounded.number("spring_force_of_length", length) == pytest.approx(spring)
    assert unbounded.number("spring_force", 0.0, velocity, 0.0) == 0.0
    assert unbounded.number("spring_force_of_length", 1.1) == 0.0
