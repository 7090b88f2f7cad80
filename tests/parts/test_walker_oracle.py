"""The walker's equations solved adaptively: that solver held to physics, and the engine to it."""

import dataclasses
import functools

import numpy as np
import pytest

import walkers
from tegotae import Timing
from walker_oracle import SET_A, SET_C, Parts, Start, Walk, six, walk

SIX = dataclasses.replace(SET_A, hips=six(0.7, 0.45))
PHASES = (0.3, 3.0, 3.6, 0.9, 5.0, 2.0)


def let_go(parts: Parts, **options) -> Start:
    return Start((0.0, 0.0, 1.0 + parts.com_z), **options)


@functools.cache
def reference(parts: Parts) -> Walk:
    """Two strides from uneven phases."""
    phases = PHASES[: len(parts.hips)]
    return walk(parts, 2.1, let_go(parts), phases, np.linspace(0.0, 5.0, 101))


# The solver of the tests


@pytest.mark.parametrize(
    "parts", [pytest.param(SET_A, marks=pytest.mark.thorough), SET_C], ids="AC"
)
def test_energy_is_work_less_what_damping_friction_and_release_took(parts):
    record = reference(parts)
    assert np.ptp(record.contact.sum(1)) >= 2
    losses = record.damping_loss + record.friction_loss + record.release_loss
    balance = (record.work_done + record.work_taken - losses).sum(1)
    energy = record.energy(parts)
    np.testing.assert_allclose(energy - energy[0], balance, atol=1e-6)
    for total in (record.work_done, -record.work_taken, record.friction_loss, record.slip):
        assert np.all(np.diff(total, axis=0) >= 0.0)
        assert np.all(total[-1] > 0.0)


def test_a_slow_rhythm_is_held_by_its_own_load():
    omega = 0.1
    record = walk(SET_A, omega, let_go(SET_A), (-1.5,) * 4, [0.0, 50.0, 60.0])
    held = SET_A.sigma * record.load[-1] * np.cos(record.phase[-1])
    np.testing.assert_allclose(held, omega, atol=1e-4)
    np.testing.assert_allclose(record.phase[-1], record.phase[-2], atol=1e-4)
    np.testing.assert_allclose(record.velocity[-1], 0.0, atol=1e-4)


# The engine beside it


@functools.cache
def engine_walk(parts: Parts, tick_s: float) -> dict[str, np.ndarray]:
    """The engine's run of the reference, [frames, ...]."""
    phases = np.array(PHASES[: len(parts.hips)])[:, None]
    path = walkers.run(parts, 2.1, phases, Timing(duration_s=5.0, tick_s=tick_s, frame_s=0.05))
    return {name: x[..., 0] for name, x in path.items()}


def errors(parts: Parts, tick_s: float) -> dict[str, float]:
    """The engine's largest differences to the reference, by what differs."""
    path, record = engine_walk(parts, tick_s), reference(parts)
    place = np.stack([path["x_m"], path["y_m"], path["height_m"]], axis=-1)
    angle = np.stack([path["roll_rad"], path["pitch_rad"], path["yaw_rad"]], axis=-1)
    work, taken = record.work_done[1:].sum(1), record.work_taken[1:].sum(1)
    differences = {
        "place": place - record.place[1:],
        "angle": angle - record.roll_pitch_yaw[1:],
        "phase": np.angle(np.exp(1j * (path["phase_rad"] - record.phase[1:]))),
        "load": path["spring_force_n"] - record.load[1:],
        "slip": path["slid_m"] - record.slip[1:],
        "work done": path["work_positive_j"] - work,
        "all work": path["work_absolute_j"] - (work - taken),
        "energy": path["energy_j"] - record.energy(parts)[1:],
    }
    return {name: float(np.abs(x).max()) for name, x in differences.items()}


@pytest.mark.parametrize(
    "parts",
    [
        pytest.param(SET_C, id="four legs"),
        pytest.param(SIX, id="six legs", marks=pytest.mark.thorough),
    ],
)
def test_the_engine_walks_as_the_adaptive_solver_does(parts):
    limits = {
        "place": 2e-3,
        "angle": 1e-3,
        "phase": 2e-3,
        "load": 1e-2,
        "slip": 5e-3,
        "work done": 2e-3,
        "all work": 2e-3,
        "energy": 1e-3,
    }
    assert {name: e for name, e in errors(parts, 0.005).items() if not e < limits[name]} == {}


@pytest.mark.thorough
def test_the_error_falls_faster_than_the_tick():
    coarse, fine = errors(SET_C, 0.01), errors(SET_C, 0.005)
    assert coarse["phase"] > 2.0 * fine["phase"]
    assert coarse["angle"] > 2.0 * fine["angle"]
