"""The terms of a controller: Action, Reaction, Gain and Actuation, vanilla and learned."""

import math

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given, strategies as st

from refusals import refused
from tegotae.parts.terms import (
    ConstantGain,
    EllipticFoot,
    FreeSector,
    LearnedActuation,
    Network,
    PacedFoot,
    Reflex,
    Sector,
    SectorAndReflex,
    Signals,
    SteppingFoot,
    TiltReaction,
    VanillaAction,
    VanillaReaction,
    WaryFoot,
)

PHASE = np.array([0.3, 2.0, 5.0])
SPRING = np.array([0.0, 1.5, 3.0])
FEEDBACK = np.array([-2.0, 0.0, 1.5])


def signals() -> Signals:
    values = {
        "sin_phase": jnp.sin(jnp.asarray(PHASE)),
        "cos_phase": jnp.cos(jnp.asarray(PHASE)),
        "spring_force": jnp.asarray(SPRING),
        "velocity": jnp.asarray([-1.0, 0.5, 2.0]),
        "feedback": jnp.asarray(FEEDBACK),
    }
    return Signals(values, {"spring_force": 0.981, "velocity": 3.0, "feedback": 2.5})


@pytest.mark.parametrize(
    ("term", "n_weights"),
    [
        (VanillaAction(), 0),
        (VanillaReaction(), 0),
        (ConstantGain(), 1),
        (Sector(), 0),
        (Reflex(), 0),
        (SectorAndReflex(), 0),
        (Network(("phase",), 8), 32),
        (Network(("spring_force",), 8), 24),
        (Network(("phase", "spring_force"), 8), 40),
        (LearnedActuation(("spring_force",), 32), 96),
        (LearnedActuation(("spring_force", "velocity"), 24), 96),
    ],
)
def test_a_term_has_as_many_initial_weights_as_it_says(term, n_weights):
    assert term.n_weights == n_weights
    initial = term.initial(jax.random.key(0))
    assert initial.shape == (n_weights,)
    assert np.isfinite(initial).all()


def test_a_term_reads_only_what_it_says():
    for term in (VanillaAction(), VanillaReaction(), Reflex(), Network(("phase", "velocity"), 3)):
        values = {name: signals()[name] for name in term.reads}
        weights = list(jnp.ones((term.n_weights, 3)))
        assert term(weights, Signals(values, {})).shape == (3,)


@pytest.mark.parametrize("width", [1, 5, 40, 41, 300])
def test_a_network_is_one_tanh_layer_on_sine_cosine_and_dimensionless_signals(width):
    term = Network(("phase", "spring_force", "velocity"), hidden=width)
    weights = np.random.default_rng(0).normal(size=(width, 6, 3))  # neurons, (w..., b, v), lanes
    inputs = np.stack([np.sin(PHASE), np.cos(PHASE), SPRING / 0.981, [-1 / 3, 0.5 / 3, 2 / 3]])
    hidden = np.tanh(np.einsum("jil,il->jl", weights[:, :4], inputs) + weights[:, 4])
    expected = np.sum(weights[:, 5] * hidden, axis=0)
    flat = [jnp.asarray(w, "float32") for w in weights.reshape(-1, 3)]
    np.testing.assert_allclose(term(flat, signals()), expected, rtol=1e-5, atol=1e-5)
    np.testing.assert_allclose(term(jnp.stack(flat), signals()), expected, rtol=1e-5, atol=1e-5)


def test_the_reflex_reacts_to_falling_tegotae_only():
    np.testing.assert_array_equal(Reflex()([], signals()), [2.0, 0.0, 0.0])
    np.testing.assert_array_equal(SectorAndReflex()([], signals()), [2.0, 0.0, 0.0])
    np.testing.assert_array_equal(Sector()([], signals()), 0.0)


def test_only_sectors_switch_full_force():
    path = (jnp.zeros(3), jnp.ones(3), jnp.ones(3))
    assert Reflex().full_force((), *path) is None
    assert LearnedActuation(("phase",), 3).full_force((), *path) is None
    assert Sector().full_force((), *path) is not None
    assert SectorAndReflex().full_force((), *path) is not None


# The share of a phase path inside a sector, against sampling the path.


def sampled(sector: Sector, start: float, end: float, omega: float) -> tuple[float, float]:
    """Share and centre by sampling the path at the middles of 200 000 equal pieces."""
    positions = (np.arange(200_000) + 0.5) / 200_000
    width = sector.width_rad + sector.duration_s * omega
    inside = np.mod(start + positions * (end - start) - sector.start_rad, 2 * np.pi) < width
    return inside.mean(), positions[inside].mean() if inside.any() else 0.5


def full_force(sector: Sector, start: float, end: float, omega: float) -> tuple[float, float]:
    with jax.enable_x64(True):
        arrays = (jnp.asarray([x], "float64") for x in (start, end, omega))
        share, centre = sector.full_force((), *arrays)
    return float(share[0]), float(centre[0])


EDGE = 1.75 * math.pi


@given(
    sector_start=st.floats(-7.0, 7.0),
    width=st.floats(0.0, 6.0),
    start=st.floats(-10.0, 20.0),
    travel=st.floats(-6.0, 6.0).filter(lambda x: abs(x) > 1e-3),
)
def test_share_and_centre_are_those_of_the_sampled_path(sector_start, width, start, travel):
    sector = Sector(start_rad=sector_start, width_rad=width)
    share, centre = full_force(sector, start, start + travel, 5.0)
    expected_share, expected_centre = sampled(sector, start, start + travel, 5.0)
    assert share == pytest.approx(expected_share, abs=3e-5)
    # The centre of next to nothing is not well sampled; its moment is what pushes the body.
    assert share * centre == pytest.approx(expected_share * expected_centre, abs=3e-5)


def test_a_phase_that_stands_still_is_inside_the_half_open_sector_or_outside():
    for phase, share in ((EDGE - 1e-6, 0.0), (EDGE, 1.0), (EDGE + 0.3, 1.0), (EDGE + 0.32, 0.0)):
        assert full_force(Sector(), phase, phase, 5.0) == (share, 0.5)


def test_a_sector_may_last_a_fixed_time_at_the_prescribed_frequency():
    sector = Sector(start_rad=1.0, width_rad=0.0, duration_s=0.1)
    for omega in (4.0, 8.0):
        share, _ = full_force(sector, 0.5, 2.5, omega)
        assert share == pytest.approx(0.1 * omega / 2.0)


@given(start=st.floats(-7.0, 7.0), width=st.floats(0.0, 6.0), phase=st.floats(-10.0, 20.0))
def test_a_trained_sector_has_the_edges_of_a_given_one_inside_a_tick(start, width, phase):
    given_one = full_force(Sector(start_rad=start, width_rad=width), phase, phase + 0.3, 5.0)
    with jax.enable_x64(True):
        path = (jnp.asarray([x], "float64") for x in (phase, phase + 0.3, 5.0))
        weights = tuple(jnp.asarray([x], "float64") for x in (start, width))
        share, centre = FreeSector().full_force(weights, *path)
    assert (float(share[0]), float(centre[0])) == pytest.approx(given_one, abs=1e-12)


def test_a_width_beyond_a_turn_is_one_and_a_negative_one_none():
    path = tuple(jnp.asarray([x]) for x in (1.0, 1.2, 5.0))
    for width, share in ((-1.0, 0.0), (7.0, 1.0)):
        weights = jnp.array([2.0]), jnp.array([width])
        assert FreeSector().full_force(weights, *path)[0].item() == pytest.approx(share, abs=1e-5)


@pytest.mark.parametrize("kind", [Network, LearnedActuation])
def test_a_network_without_inputs_is_refused(kind):
    refused(r"^a network has no inputs", kind, (), 8)


def test_a_reflexs_force_per_feedback_is_a_choice():
    falling = Signals({"feedback": jnp.array([-2.0, 3.0])})
    np.testing.assert_allclose(Reflex(0.5)((), falling), [1.0, 0.0])
    np.testing.assert_allclose(SectorAndReflex(newtons_per_feedback=0.5)((), falling), [1.0, 0.0])


def test_a_foot_steps_aside_to_where_the_torso_falls_and_is_shorter_where_it_is_high():
    gains = {"roll_m": -0.1, "aside_m": 0.2, "aside_rate_ms": 0.05, "yaw": 0.5}
    ellipse = {"stride_m": 0.3, "lift_m": 0.1}
    foot = SteppingFoot()
    weights = [jnp.full(2, {**gains, **ellipse}.get(path[0], 0.0)) for path in foot.weight_names]
    side = jnp.array([1.0, -1.0])  # a leg on the left, and one on the right
    ones, roll, rate, yaw = jnp.ones(2), 0.3, 2.0, 0.1
    values = {"sin_phase": ones, "cos_phase": ones, "end_pitch": ones, "roll": roll * ones}
    values |= {"roll_rate": rate * ones, "side_yaw": yaw * side}
    values |= {"side_roll": roll * side, "side_roll_rate": rate * side}
    ahead, up, aside = foot(weights, Signals(values, {}))
    np.testing.assert_allclose(ahead, -0.3 * (1.0 + 0.5 * yaw * side), rtol=1e-6)
    np.testing.assert_allclose(up, 0.1 - 0.1 * roll * side, rtol=1e-6)
    np.testing.assert_allclose(aside, -(0.2 * roll + 0.05 * rate) * ones, rtol=1e-6)


def test_a_paced_foot_goes_round_the_ellipse_of_its_frequency():
    foot = PacedFoot()
    weights = [jnp.full(3, x) for x in (0.4, 0.1, 0.05, 0.2, 0.0, 0.0, 0.0, 0.0, 1.5)]
    values = {name: jnp.zeros(3) for name in foot.reads}
    angle = jnp.array([0.3, 2.0, 4.0])
    values |= {"sin_phase": jnp.sin(angle), "cos_phase": jnp.cos(angle)}
    signals, omega = Signals(values, {}), jnp.array([0.0, 3.0, 6.0])
    paced = foot.paced(weights, foot(weights, signals), omega)
    for lane, stride in enumerate((0.0, 0.2, 0.3)):
        ellipse = EllipticFoot(stride_m=stride, lift_m=0.1, press_m=0.05, shift_rad=0.2)
        np.testing.assert_allclose(paced[:, lane], ellipse((), signals)[:, lane], atol=1e-6)


def test_a_tilt_is_felt_the_same_to_all_sides_and_as_a_square():
    values = dict.fromkeys(TiltReaction.READS, jnp.zeros(8))
    values |= {name: values[name].at[k].set(0.1) for k, name in enumerate(TiltReaction.READS)}
    values |= {name: values[name].at[4 + k].set(-0.2) for k, name in enumerate(TiltReaction.READS)}
    felt = TiltReaction(tilt_rad=0.1)((), Signals(values))
    np.testing.assert_allclose(felt, [1.0] * 4 + [4.0] * 4, rtol=1e-5)


def test_a_wary_foot_steps_shorter_and_higher_the_more_it_is_alarmed():
    numbers = [jnp.full(4, x) for x in (0.4, 0.1, 0.05, 0.2, 0.0, 0.0, 0.0, 0.0, 1.5)]
    values = {name: jnp.full(4, 0.5) for name in PacedFoot().reads}
    calm, alarm = PacedFoot()(numbers, Signals(values)), jnp.array([-1.0, 0.0, 0.125, 3.0])
    for higher in (0.0, 0.4):
        weights = [*numbers, jnp.full(4, higher)]
        ahead, up = WaryFoot()(weights, Signals(values | {"alarm": alarm}))
        np.testing.assert_allclose(ahead, calm[0] / jnp.array([1.0, 1.0, 1.125, 4.0]), rtol=1e-6)
        raised = 1.0 + higher * jnp.array([0.0, 0.0, 0.5, 1.0])
        np.testing.assert_allclose(up, calm[1] * raised, rtol=1e-6)
