"""The walker's MuJoCo twin: it stands where the walker stands, and walks as the walker walks."""

import numpy as np
import pytest

import walkers
from research.benchmarks import mujoco_walker, walker_model
from tegotae import Timing
from tegotae.envs.mujoco.settings import model_files
from tegotae.measures.gaits.lags import circular_mean, lag_difference
from walker_oracle import SET_A, SET_C

pytest.importorskip("mujoco")


def twin(parts, omega, phases, duration_s):
    return mujoco_walker.walk(
        walkers.body_of(parts),
        walkers.controller_of(parts).actuation,
        omega=omega,
        sigma=parts.sigma,
        phase_rad=phases,
        duration_s=duration_s,
    )


def last(time, phase, x, y):
    """Lags [legs] and speed over the last 15 units of time."""
    late = time > time[-1] - 15.0
    lag = (phase[late, :1] - phase[late]) / (2 * np.pi)
    distance = np.hypot(x[late][-1] - x[late][0], y[late][-1] - y[late][0])
    return np.asarray(circular_mean(lag)), distance / 15.0


def test_the_packages_quadruped_is_the_walker_at_the_size_of_a_small_robot():
    import mujoco

    def saved(text):
        model = mujoco.MjSpec.from_string(text).compile()
        content = np.zeros(mujoco.mj_sizeModel(model), np.uint8)
        mujoco.mj_saveModel(model, None, content)
        return content

    np.testing.assert_array_equal(saved(model_files()["quadruped"]), saved(walker_model.mjcf()))


def test_the_twin_stands_at_the_walkers_height():
    observation = twin(SET_A, 0.0, (-np.pi / 2,) * 4, 10.0)
    np.testing.assert_allclose(
        observation.place_m[-1], (0.0, 0.0, SET_A.standing_height), atol=3e-3
    )


@pytest.mark.thorough
def test_the_twin_trots_and_walks_where_the_walker_does():
    omegas = np.array([0.9, 2.1, 3.2])
    phases = np.random.default_rng(1).uniform(0.0, 2 * np.pi, 4)
    timing = Timing(duration_s=60.0, tick_s=0.01, frame_s=0.1)
    path = walkers.run(SET_C, omegas, np.tile(phases[:, None], 3), timing)
    hind_lags = []
    for lane, omega in enumerate(omegas):
        series = [path[name][..., lane] for name in ("time_s", "phase_rad", "x_m", "y_m")]
        lag, speed = last(*series)
        observation = twin(SET_C, omega, phases, 60.0)
        lag_of_twin, speed_of_twin = last(
            observation.time_s, observation.phase_rad, *observation.place_m[:, :2].T
        )
        assert np.abs(lag_difference(lag_of_twin, lag)).max() < 0.06
        assert speed_of_twin == pytest.approx(speed, rel=0.12)
        hind_lags.append(lag[2])
    # A trot, a walk in diagonal sequence, a trot.
    np.testing.assert_allclose(hind_lags, (0.5, 0.33, 0.47), atol=0.05)


def test_the_bare_model_is_timed():
    body, foot = walkers.body_of(SET_C), walkers.controller_of(SET_C).actuation
    rates = mujoco_walker.mujoco_ticks_per_second(body, foot, omega=2.1, lanes=4, ticks=10)
    assert all(np.isfinite(rates))
    assert min(rates) > 0.0
