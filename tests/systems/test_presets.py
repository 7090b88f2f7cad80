"""Presets: the paper's hopper, and another program's exact rules, checked against those rules."""

from math import cos, pi

import numpy as np
import pytest
from scipy.integrate import odeint

from refusals import refused
from tegotae import Hopper, System, TegotaeError, Timing
from tegotae.analysis.simulation import simulate
from tegotae.systems.system import Release
from tegotae.systems.vanilla import preset

DURATION_S = 15.0


class Program:
    """The rules of pyTegotaeCPG (D. Owaki, 2025) and its way to solve them.

    The leg is in contact iff y <= l, and the body is damped everywhere. In contact the phase is fed
    back, and the actuator is on from a phase of 1.6π for 0.02·ω·π.
    """

    m, k, c, l, g, amplitude = 0.1, 5.0, 0.2, 1.0, 9.81, 4.0  # noqa: E741

    def __init__(self, omega: float = 5.0, sigma: float = 2.753) -> None:
        self.omega, self.sigma = omega, sigma

    def rates(self, state: np.ndarray, _: float) -> list[float]:
        y, v, phase = state
        contact = y <= self.l
        spring = self.k * (self.l - y) if contact else 0.0
        on = contact and 1.6 * pi <= phase % (2.0 * pi) < 1.6 * pi + 0.02 * self.omega * pi
        force = -self.c * v + spring - self.m * self.g + self.amplitude * on
        return [v, force / self.m, self.omega + self.sigma * spring * -cos(phase)]

    def apexes(self) -> tuple[np.ndarray, np.ndarray]:
        """Times [s] and heights [m] of the highest points above l."""
        time = np.arange(0.0, DURATION_S, 1e-4)
        height = odeint(self.rates, [1.0, 0.0, 0.0], time)[:, 0]
        middle = height[1:-1]
        is_apex = (middle > height[:-2]) & (middle >= height[2:]) & (middle > self.l)
        return time[1:-1][is_apex], middle[is_apex]


def apexes(name: str, omega: float = 5.0, sigma: float = 2.753) -> tuple[np.ndarray, np.ndarray]:
    """The same by this package."""
    model = preset(name)
    system = System(
        controller=model.controller("sector"),
        omega=omega,
        body=model.hopper,
        release=Release(height_m=model.height_m),
    )
    timing = Timing(duration_s=DURATION_S, frame_s=0.01)
    times, heights, _ = simulate(system, [sigma], timing).apexes
    return times, heights


@pytest.mark.parametrize(("omega", "sigma"), [(5.0, 2.753), (4.0, 2.0), (6.0, 2.753)])
def test_the_preset_follows_the_other_programs_rules_to_a_millimetre(omega, sigma):
    time_s, height_m = Program(omega, sigma).apexes()
    our_time_s, our_height_m = apexes("pyTegotaeCPG", omega, sigma)
    assert len(height_m) >= 10
    np.testing.assert_allclose(our_height_m, height_m, rtol=0.0, atol=1e-3)
    np.testing.assert_allclose(our_time_s, time_s, rtol=0.0, atol=2e-3)


def test_the_presets_numbers_are_those_of_their_sources():
    ours = preset("pyTegotaeCPG")
    hopper, sector = ours.hopper, ours.sector
    assert (ours.omega_rad_per_s, ours.sigma, ours.height_m) == (5.0, 2.753, 1.0)
    assert hopper.flight_damping_ns_per_m == hopper.damping_ns_per_m == Program.c
    assert (hopper.mass_kg, hopper.stiffness_n_per_m) == (Program.m, Program.k)
    assert (sector.start_rad, sector.width_rad) == (1.6 * pi, 0.0)
    assert sector.duration_s * 5.0 == pytest.approx(0.02 * 5.0 * pi)
    paper = preset("paper")
    assert paper.hopper == Hopper()
    assert paper.height_m == 1.2
    assert (paper.sector.start_rad, paper.sector.width_rad) == (1.75 * pi, 0.1 * pi)


def test_an_unknown_preset_is_refused_with_the_nearest_one():
    refused(r"^no preset is called 'pytegotaecpg'; did you mean pyT", preset, "pytegotaecpg")


def test_an_unknown_actuation_is_refused_with_the_nearest_one():
    with pytest.raises(TegotaeError, match=r"^no actuation is called 'refelx'; did you mean refle"):
        preset("paper").controller("refelx")
