"""The physical optimum: closed forms, two methods, a bound that holds, and what it refuses."""

import dataclasses
import math
import sys
from fractions import Fraction

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from springs import Hertz

from places import ROOT
from programs import main
from refusals import refused
from research.reproduction.export import write_study_csv
from research.reproduction.optimum import (
    Certificate,
    Stance,
    certify,
    highest_frequency,
    largest_cot_inverse,
    optimal_stances,
    optimise,
    proofs,
    small_hop_limit,
    upper_bound,
    verify,
)
from research.reproduction.optimum.exact import PI_ABOVE, covers
from research.reproduction.optimum.grid import least_work
from research.reproduction.optimum.problem import (
    climb,
    flight_mismatch,
    flow,
    least_lift_off,
    most_landing,
    most_lift_off,
)
from study_tables import table
from tegotae import Hopper, Rollout, Scenario, TegotaeError, Timing
from tegotae.measures.evaluation import Protocol, evaluate
from tegotae.measures.hopping.gait import GaitSummary
from tegotae.measures.hopping.metrics import LIMIT_CYCLE
from tegotae.measures.optimum import curve, has_table, share
from tegotae.systems import controller_file
from tegotae.systems.recipe import recipe

HOPPER = Hopper()
UNDAMPED = {"flight_damping_ns_per_m": 0.0}
DAMPED = Hopper(
    mass_kg=0.07, stiffness_n_per_m=4.4, damping_ns_per_m=0.34, flight_damping_ns_per_m=0.34,
    max_force_n=1.24, rest_length_m=0.63,
)  # fmt: skip
"""Near the calibrated body of the study."""
ONE_SWING = [(Stance(),)]


@pytest.fixture(scope="module")
def at_four():
    pytest.importorskip("casadi")
    return optimise(HOPPER, 4.0, shapes=ONE_SWING, starts=3)


# Closed forms


def test_without_damping_a_hop_at_the_bodys_own_time_costs_nothing():
    """The spring alone returns the mass: v is free, and T follows from it in closed form."""
    pytest.importorskip("casadi")
    body = Hopper(damping_ns_per_m=0.0)
    rate, speed = body.natural_frequency_rad_per_s, 2.0
    stance_s = 2.0 * (math.pi - math.atan2(speed * rate, body.gravity_m_per_s2)) / rate
    omega = 2.0 * math.pi / (stance_s + 2.0 * speed / body.gravity_m_per_s2)
    assert optimise(body, omega, shapes=ONE_SWING, starts=4).cot_inverse > 1e3


@pytest.mark.parametrize(("work", "factor"), [("absolute", 1.0), ("positive", 2.0)])
def test_hops_too_low_to_load_the_spring_reach_the_closed_form(work, factor):
    """The fastest hops fall and rise 1 cm: stop the fall and throw, both under full force.

    A soft leg, so that what is left of its spring and damper does not show.
    """
    pytest.importorskip("casadi")
    limit = factor * (1.0 - HOPPER.weight_n / 4.0) / (2.0 * HOPPER.weight_n)
    assert small_hop_limit(HOPPER, work) == pytest.approx(limit)
    soft = Hopper(stiffness_n_per_m=0.5, damping_ns_per_m=0.02)
    gait = optimise(soft, 50.0, work=work, shapes=ONE_SWING, starts=3)
    assert gait.cot_inverse == pytest.approx(limit, rel=0.003)


def test_net_work_has_no_limit_for_small_hops():
    assert small_hop_limit(HOPPER, "net") == math.inf


def test_no_lift_off_is_faster_than_the_energy_allows():
    v, dt = 0.0, 1e-3
    x = -HOPPER.rest_length_m
    while x < 0.0:
        x, v = flow(HOPPER, x, v, HOPPER.max_force_n, dt)
    assert 0.5 * most_lift_off(HOPPER) < v < most_lift_off(HOPPER)


def flown(body, lift_off):
    """Climb [m], time [s] and landing speed [m/s] of a flight, by an independent solver."""
    damping = body.flight_damping_ns_per_m / body.mass_kg

    def ends(time_s, state):
        return state[0]

    ends.terminal, ends.direction = True, -1.0
    path = solve_ivp(
        lambda _, state: [state[1], -body.gravity_m_per_s2 - damping * state[1]],
        (0.0, 10.0), [1e-12, lift_off], events=ends, rtol=1e-11, atol=1e-12, dense_output=True,
    )  # fmt: skip
    land_s = path.t_events[0][0]
    return path.sol(np.linspace(0.0, land_s, 20_001))[0].max(), land_s, -path.y_events[0][0][1]


@pytest.mark.parametrize("lift_off", [0.4, 3.0])
def test_a_damped_flight_climbs_and_lands_as_a_solver_says(lift_off):
    climbed, time_s, landing = flown(DAMPED, lift_off)
    assert climb(DAMPED, lift_off) == pytest.approx(climbed, rel=1e-6)
    assert flight_mismatch(DAMPED, lift_off, landing) == pytest.approx(0.0, abs=1e-8)
    assert (lift_off + landing) / DAMPED.gravity_m_per_s2 == pytest.approx(time_s, rel=1e-8)
    assert landing < min(lift_off, most_landing(DAMPED))


def test_the_lowest_hop_clears_a_hundredth_of_the_leg_damped_or_not():
    for body in (HOPPER, DAMPED):
        assert climb(body, least_lift_off(body)) == pytest.approx(0.01 * body.rest_length_m)
    assert least_lift_off(DAMPED) > least_lift_off(dataclasses.replace(DAMPED, **UNDAMPED))


def test_hardly_damped_flight_has_nearly_the_optimum_of_ballistic_flight(at_four):
    hardly = dataclasses.replace(HOPPER, flight_damping_ns_per_m=1e-6)
    gait = optimise(hardly, 4.0, shapes=ONE_SWING, starts=3)
    assert gait.cot_inverse == pytest.approx(at_four.cot_inverse, rel=2e-4)


def test_a_gait_with_damped_flight_lands_as_it_began():
    pytest.importorskip("casadi")
    gait = optimise(DAMPED, 7.0, shapes=ONE_SWING, starts=2, intervals=20)
    climbed, time_s, landing = flown(DAMPED, gait.lift_off_m_per_s[0])
    assert gait.velocity_m_per_s[0][0] == pytest.approx(-landing, rel=1e-5)
    assert gait.stance_s[0] + time_s == pytest.approx(2.0 * math.pi / 7.0, rel=1e-5)
    assert gait.cot_inverse * gait.work_j == pytest.approx(climbed, rel=1e-5)


# The best gait that is found


def test_the_best_gait_is_one_that_the_engines_physics_makes(at_four):
    """Its force, stepped finely through the stance's closed-form motion, ends where it says."""
    time_s, force = at_four.time_s[0], at_four.force_n[0]
    x, v, work = 0.0, -at_four.lift_off_m_per_s[0], 0.0
    for length, push in zip(np.diff(time_s), force[:-1], strict=True):
        for _ in range(20):
            previous = x
            x, v = flow(HOPPER, x, v, push, length / 20)
            work += abs(push * (x - previous))
    assert x == pytest.approx(0.0, abs=1e-6)
    assert v == pytest.approx(at_four.lift_off_m_per_s[0], abs=1e-5)
    assert work == pytest.approx(at_four.work_j, rel=1e-3)
    assert force.min() >= -1e-6
    assert force.max() <= HOPPER.max_force_n + 1e-6
    period_s = time_s[-1] + 2.0 * at_four.lift_off_m_per_s[0] / HOPPER.gravity_m_per_s2
    assert period_s == pytest.approx(2.0 * math.pi / 4.0, rel=1e-6)


def test_dynamic_programming_finds_the_same(at_four):
    speed = float(at_four.lift_off_m_per_s[0])
    work = least_work(HOPPER, speed, float(at_four.stance_s[0]), points=80)
    assert work == pytest.approx(at_four.work_j, rel=0.04)


def test_no_other_lift_off_velocity_does_better_on_the_grid(at_four):
    def reached(speed: float) -> float:
        stance_s = 0.5 * math.pi - 2.0 * speed / HOPPER.gravity_m_per_s2
        work = least_work(HOPPER, speed, stance_s, points=60)
        return speed**2 / (2.0 * HOPPER.gravity_m_per_s2) / work

    assert all(reached(speed) < 1.01 * at_four.cot_inverse for speed in (3.0, 4.0, 4.5, 5.5))


def test_an_inner_swing_lets_the_mass_wait_at_its_top():
    """So slow hops exist at any frequency, and waiting is free."""
    pytest.importorskip("casadi")
    two = {"shapes": [(Stance(2),)], "starts": 2, "intervals": 16}
    slow = [optimise(HOPPER, omega, **two).cot_inverse for omega in (1.5, 2.0)]
    assert slow[0] == pytest.approx(slow[1], rel=1e-3)


# The upper bound


@pytest.mark.thorough
def test_the_bound_holds_and_is_near(at_four):
    bound = upper_bound(HOPPER, 4.0, best=at_four.cot_inverse)
    assert at_four.cot_inverse <= bound < 1.02 * at_four.cot_inverse


def test_what_certifies_the_bound_falls_along_random_gaits():
    """V's condition along motions under random forces: climb, work and time of any of them."""
    pytest.importorskip("casadi")
    proof = certify(HOPPER, 4.0, cells=6)
    random = np.random.default_rng(0)
    dt, hop_s, gravity = 1e-3, math.pi / 2.0, HOPPER.gravity_m_per_s2
    n, lowest = 300, least_lift_off(HOPPER)
    x, v = np.full(n, -1e-9), -random.uniform(0.5, 6.0, n)
    force = np.zeros(n)
    total = np.zeros(n)
    start = value = _evaluate(proof, x, v)
    for step in range(4000):
        if step % 20 == 0:
            force = HOPPER.max_force_n * random.integers(0, 2, n) * random.uniform(0.0, 1.0, n)
        x_next, v_next = flow(HOPPER, x, v, force, dt)
        total += proof.time_price * dt - proof.bound * force * np.abs(x_next - x)
        up = x_next >= 0.0
        fly_s = 2.0 * v_next / gravity
        hop = np.where(v_next >= lowest, hop_s, 0.0)
        total += np.where(up, v_next**2 / (2 * gravity) + proof.time_price * (fly_s - hop), 0.0)
        x = np.where(up, -1e-9, np.maximum(x_next, -0.999))
        v = np.where(up, -v_next, v_next)
        collapsed = x_next < -0.999  # the leg has no length left: it starts anew
        value = _evaluate(proof, x, v)
        total = np.where(collapsed, 0.0, total)
        start = np.where(collapsed, value, start)
        assert np.all(total + value - start < 0.02)


def _evaluate(proof, x, v):
    """V at states."""
    i = np.clip(np.searchsorted(proof.heights_m, x, "right") - 1, 0, len(proof.heights_m) - 2)
    j = np.clip(np.searchsorted(proof.speeds_m_per_s, v, "right") - 1, 0, None)
    j = np.minimum(j, len(proof.speeds_m_per_s) - 2)
    s = (x - proof.heights_m[i]) / np.diff(proof.heights_m)[i]
    t = (v - proof.speeds_m_per_s[j]) / np.diff(proof.speeds_m_per_s)[j]

    def weights(u):
        return np.array([(1 - u) ** 2, 2 * u * (1 - u), u**2])

    local = np.arange(3)
    patch = proof.coefficients[(2 * i + local[:, None])[:, None], (2 * j + local[:, None])[None]]
    return np.einsum("an,bn,abn->n", weights(s), weights(t), patch)


@pytest.mark.thorough
def test_no_controller_is_above_the_bound():
    """Random learned controllers and V over gains and frequencies: all that settle."""
    random = np.random.default_rng(1)
    optimum = curve()
    count = 0
    for name, weights in (
        ("V-reflex-w4", random.uniform(0.0, 8.0, (150, 1))),
        ("V-sector-w4", random.uniform(0.0, 8.0, (150, 1))),
        ("ART-rF-tphif-w4", 0.8 * random.normal(size=(300, 96))),
    ):
        rollout = Rollout(
            controller=recipe(name).controller(),
            timing=Timing(duration_s=30.0),
            summary=GaitSummary(),
        )
        omega = random.uniform(2.0, 10.0, len(weights))
        outcome = rollout.run(
            weights[:, : recipe(name).controller().n_weights], Scenario(omega=omega)
        )
        settled = np.asarray(outcome.regime) == LIMIT_CYCLE
        rate, value = (np.asarray(x)[settled] for x in (outcome.hop_rate, outcome.cot_inverse))
        period = np.asarray(outcome.limit_cycle_period)[settled]
        assert np.all(value <= 1.005 * optimum.bound("upper_bound_any", rate))
        single = period == 1
        assert np.all(value[single] <= 1.005 * optimum.bound("upper_bound", rate[single]))
        count += settled.sum()
    assert count > 50


# What proves the bounds, in rational arithmetic


@pytest.fixture(scope="module")
def kept_proofs() -> list[Certificate]:
    return proofs.read_certificates()


@pytest.mark.parametrize("omega", [4.0, pytest.param(8.0, marks=pytest.mark.thorough)])
def test_a_row_of_the_kept_table_is_proved_without_a_solver(omega, kept_proofs, monkeypatch):
    monkeypatch.setitem(sys.modules, "casadi", None)
    (row,) = (row for row in proofs.claimed_bounds() if row.omega == omega)
    proofs.check_row(row, kept_proofs)


@pytest.mark.thorough
def test_every_row_of_the_kept_table_is_proved(kept_proofs):
    assert len(proofs.claimed_bounds()) == 49
    for row in proofs.claimed_bounds():
        proofs.check_row(row, kept_proofs)


def test_the_bound_at_any_frequency_is_what_the_pages_say(kept_proofs):
    anywhere = kept_proofs[0]
    assert anywhere.omega is None
    assert covers([anywhere], HOPPER, None)
    assert verify(anywhere, HOPPER) <= Fraction("1.296")


@pytest.mark.parametrize("name", ["upper_bound", "upper_bound_any"])
def test_a_row_that_claims_a_little_less_is_not_proved(name, kept_proofs):
    row = next(row for row in proofs.claimed_bounds() if row.omega == 4.0)
    less = dataclasses.replace(row, **{name: getattr(row, name) - 2e-6})
    refused(r"no certificates prove .* at 4 rad/s", proofs.check_row, less, kept_proofs)


def test_hops_that_no_certificate_speaks_of_leave_a_row_unproved(kept_proofs):
    row = next(row for row in proofs.claimed_bounds() if row.omega == 4.0)
    matching = [certificate for certificate in kept_proofs if certificate.omega == 4.0]
    assert len(matching) > 2
    with pytest.raises(TegotaeError, match="no certificates prove"):
        proofs.check_row(
            row, [certificate for certificate in matching if certificate is not matching[1]]
        )


def with_entry(array: np.ndarray, place: tuple[int, ...], change: float) -> np.ndarray:
    changed = array.copy()
    changed[place] += change
    return changed


@pytest.mark.parametrize(
    ("name", "tampered", "reason"),
    [
        ("bound", lambda x: 0.9999 * x, "the condition is missed"),
        ("omega", lambda x: 0.99 * x, "over flights .* missed"),
        ("time_price", lambda x: 1e-9, "0 <= λ and μ <= 0 is needed"),
        ("coefficients", lambda x: with_entry(x, (8, 20), 0.01), "the condition is missed"),
        ("coefficients", lambda x: with_entry(x, (0, 0), math.nan), "is not finite"),
        ("coefficients", lambda x: x[:, 1:], "coefficients, not"),
        ("speeds_m_per_s", lambda x: 0.99 * x, "faster ones are possible"),
        ("heights_m", lambda x: 0.99 * x, "do not reach from -l0 to 0"),
        ("speeds_m_per_s", lambda x: with_entry(x, (0,), -1.0), "same in both directions"),
        ("heights_m", lambda x: x[::-1], "knots do not rise"),
    ],
)
def test_a_certificate_that_was_tampered_with_is_rejected(name, tampered, reason, kept_proofs):
    proof = next(
        certificate
        for certificate in kept_proofs
        if certificate.omega == 4.0 and covers([certificate], HOPPER, None)
    )
    with pytest.raises(TegotaeError, match=f"does not hold: .*{reason}") as raised:
        verify(dataclasses.replace(proof, **{name: tampered(getattr(proof, name))}), HOPPER)
    assert "\n" not in str(raised.value)


def test_a_certificate_of_one_body_does_not_hold_for_a_stronger_one(kept_proofs):
    refused("does not hold", lambda: verify(kept_proofs[1], Hopper(max_force_n=4.1)))


def test_a_certificate_of_positive_work_is_exact_too():
    pytest.importorskip("casadi")
    proof = certify(HOPPER, 6.0, work="positive", cells=3)
    assert float(verify(proof, HOPPER)) == proof.bound


def test_the_fraction_for_pi_is_larger_than_pi_by_less_than_a_float_tells():
    # Machin's formula, whose alternating series are cut on the side that makes it too large.
    def arctan(one_over: int, terms: int) -> Fraction:
        signs = ((-1) ** n for n in range(terms))
        return sum(
            (Fraction(s, (2 * n + 1) * one_over ** (2 * n + 1)) for n, s in enumerate(signs)),
            Fraction(0),
        )

    above = 16 * arctan(5, 31) - 4 * arctan(239, 10)
    below = 16 * arctan(5, 30) - 4 * arctan(239, 11)
    assert below < above < PI_ABOVE
    assert float(PI_ABOVE) == math.pi


def test_a_file_without_certificates_is_refused_in_one_line(tmp_path):
    file = tmp_path / "proofs.npz"
    file.write_bytes(b"no archive")
    refused("holds no certificates", proofs.read_certificates, file)


# The kept table


def test_the_kept_table_is_whole_and_in_order():
    optimum = curve()
    assert np.all(np.diff(optimum["omega"]) > 0.0)
    assert np.all(optimum["cot_inverse"] <= optimum["upper_bound"])
    assert np.all(optimum["upper_bound"] <= optimum["upper_bound_any"] + 1e-9)
    assert np.all(optimum["cot_inverse_two"] <= optimum["upper_bound_any"])
    assert optimum["omega"][-1] == pytest.approx(0.995 * 52.4, rel=0.01)


def test_the_kept_table_says_what_the_optimiser_finds(at_four):
    assert largest_cot_inverse(HOPPER, 4.0) == pytest.approx(at_four.cot_inverse, rel=1e-3)
    stance = optimal_stances()[4.0]
    assert stance["velocity_m_per_s"][-1] == pytest.approx(at_four.lift_off_m_per_s[0], rel=1e-3)


def test_a_share_is_of_the_optimum_at_the_gaits_own_frequency():
    assert share(0.5 * largest_cot_inverse(HOPPER, 5.0), 5.0) == pytest.approx(0.5)
    assert share(0.3, 5.0, 2) < share(0.3, 8.0, 1)
    assert np.isnan(
        share(np.array([0.3, np.nan, 0.3]), np.array([0.5, 5.0, 5.0]), [1, 1, np.nan])
    ).all()


def test_an_evaluation_reports_the_share_where_the_table_holds():
    short = Protocol(undisturbed_s=15.0, disturbed_s=5.0, offsets=(0.0,), clamped_phases=1)
    episodes = evaluate(recipe("V-reflex-w8").controller(), [[2.0]], 8.0, protocol=short).episodes
    assert 0.2 < episodes["optimum_share"][0, 0] < 1.0
    heavy = Hopper(mass_kg=0.11)
    heavier = evaluate(recipe("V-reflex-w8").controller(), [[2.0]], 8.0, heavy, short).episodes
    assert np.isnan(heavier["optimum_share"]).all()
    assert not has_table(HOPPER, "net")


@pytest.mark.thorough
def test_a_trained_controller_comes_near_the_optimum_and_not_above():
    path = ROOT / "docs" / "_static" / "figures" / "optimum-ART-w8.json"
    saved = controller_file.load(path)
    short = Protocol(undisturbed_s=60.0, disturbed_s=5.0, offsets=(0.0,), clamped_phases=1)
    episodes = evaluate(saved.controller, saved.weights, saved.omega, saved.body, short).episodes
    assert 0.97 < episodes["optimum_share"][0, 0] < 1.001


# What is refused


class Wheel:
    """A body that is no hopper."""


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: largest_cot_inverse(Hopper(max_force_n=0.9), 4.0), "above the weight of 0.981 N"),
        (
            lambda: largest_cot_inverse(Hertz(), 4.0),
            "Hopper on its linear spring; the body is a Hertz",
        ),
        (lambda: largest_cot_inverse(Hopper(leg_friction_n=0.1), 4.0), "leg_friction_n is 0.1"),
        (lambda: largest_cot_inverse(HOPPER, 0.0), "omega is 0; it must be greater than 0"),
        (lambda: largest_cot_inverse(HOPPER, math.nan), "omega is nan"),
        (lambda: largest_cot_inverse(HOPPER, 60.0), "this hopper hops at 5.* rad/s at most"),
        (lambda: largest_cot_inverse(HOPPER, 4.0, period=3), "period is 3"),
        (lambda: largest_cot_inverse(HOPPER, 4.0, work="heat"), "work is 'heat'"),
        (lambda: certify(Hopper(flight_damping_ns_per_m=0.1), 4.0), "ballistic flight"),
        (lambda: small_hop_limit(Wheel()), "the body is a Wheel"),
        (lambda: least_work(HOPPER, -1.0, 0.5), "lift_off_m_per_s is -1"),
        (lambda: least_work(HOPPER, 3.0, 0.02, points=20), "no stance of 0.02 s"),
    ],
)
def test_what_has_no_optimum_is_refused_in_one_line(call, words):
    refused(words, call)


def test_a_frequency_without_hops_gives_no_number():
    pytest.importorskip("casadi")
    fastest = highest_frequency(HOPPER)
    with pytest.raises(TegotaeError, match=r"no gait of period 1 was found at .* none of 3 starts"):
        optimise(HOPPER, 1.1 * fastest, shapes=ONE_SWING, starts=3)


def test_a_program_that_does_not_converge_gives_no_bound(monkeypatch):
    pytest.importorskip("casadi")
    from research.reproduction.optimum import certificate

    monkeypatch.setattr(certificate, "_minimise", lambda matrix, limit, largest: None)
    refused("no upper bound was found at 4 rad/s", certify, HOPPER, 4.0)


def test_without_casadi_the_extra_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "casadi", None)
    refused(r"pip install 'tegotae\[optimum\]'", optimise, HOPPER, 4.0)
    assert largest_cot_inverse(HOPPER, 4.0) > 1.0  # the kept table needs no extra


# The figure


def test_the_figure_comes_with_its_numbers(tmp_path):
    out = tmp_path / "optimum.png"
    assert main(["reproduction", "optimum", "--out", str(out)]) == 0
    assert out.exists()
    header = out.with_suffix(".csv").read_text().splitlines()[0]
    assert header.startswith("omega,cot_inverse,upper_bound")
    assert out.with_suffix(".stances.csv").exists()


def test_a_table_of_another_body_is_not_held_against_this_ones_optimum(tmp_path, one_line_error):
    path = tmp_path / "calibrated.csv"
    write_study_csv(table(optimum_share=np.full(5, np.nan)), path)
    message = one_line_error("reproduction", "optimum", str(path), "--out", str(tmp_path / "a.png"))
    assert f"{path} has no shares of the optimum" in message
