"""The walking torso as a MuJoCo model: a twin to compare gaits with, and a baseline for speed.

Needs the extra `mujoco`.

The model is that of `research.benchmarks.walker_model`.
"""

from __future__ import annotations

import os
import time
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from research.benchmarks.walker_model import Settings, description
from tegotae._support.errors import require
from tegotae.envs._types import MjData

if TYPE_CHECKING:
    from tegotae.parts.bodies import Walker
    from tegotae.parts.terms import EllipticFoot


class TwinWalk(NamedTuple):
    """The observation of a twin."""

    time_s: np.ndarray
    """Time, [frames]."""
    place_m: np.ndarray
    """Place of the torso's centre of mass, [frames, 3]."""
    phase_rad: np.ndarray
    """Phases, [frames, legs]."""


def commanded(
    foot: EllipticFoot, phase: np.ndarray, rate: np.ndarray | float
) -> tuple[np.ndarray, np.ndarray]:
    """Return the commanded positions (x, z) of the feet from below their hips, and their rates;
    [..., legs, 2]."""
    height = np.where(np.sin(phase) > 0, foot.lift_m, foot.press_m)
    place = -foot.stride_m * np.cos(phase + foot.shift_rad), height * np.sin(phase)
    speed = foot.stride_m * np.sin(phase + foot.shift_rad) * rate, height * np.cos(phase) * rate
    return np.stack(place, axis=-1), np.stack(speed, axis=-1)


def drive(body: Walker, place: np.ndarray, speed: np.ndarray) -> np.ndarray:
    """Return the motors' forces for a command, [..., legs, 2]."""
    stiffness = np.array([body.stiffness_x_n_per_m, body.stiffness_z_n_per_m], float)
    damping = np.array([body.damping_xy_ns_per_m, body.damping_z_ns_per_m], float)
    return stiffness * place + damping * speed


def _put_feet(body: Walker, foot: EllipticFoot, phase: np.ndarray, data: MjData) -> None:
    """Place the feet where they are commanded, or on the ground."""
    slides = data.qpos[7:].reshape(len(phase), 3)
    place, _ = commanded(foot, phase, 0.0)
    slides[:, 0], slides[:, 2] = place[:, 0], np.maximum(place[:, 1], 0.0)


def walk(
    body: Walker,
    foot: EllipticFoot,
    *,
    omega: float,
    sigma: float,
    phase_rad: ArrayLike,
    duration_s: float,
    settings: Settings | None = None,
) -> TwinWalk:
    """Walk with the twin under vanilla Tegotae, from given phases, released at the height of its
    legs.

        φ̇_i = ω - σ max(0, K_z d_z) / (m g) · cos φ_i

    with d_z how far foot i is above its command.

    Args:
        body: the walker, on flat ground.
        foot: what its legs are commanded.
        omega: intrinsic angular frequency [rad/s].
        sigma: feedback gain [rad/s].
        phase_rad: phases at the start [rad], [legs].
        duration_s: how long [s].
        settings: MuJoCo's.

    Raises:
        MissingExtraError: without MuJoCo.
    """
    mujoco = require("mujoco", "mujoco")
    model = mujoco.MjModel.from_xml_string(description(body, settings))
    data = mujoco.MjData(model)
    phase = np.array(phase_rad, float)
    _put_feet(body, foot, phase, data)
    feet = data.qpos[7:].reshape(len(phase), 3)
    tick, weight = model.opt.timestep, body.mass_kg * body.gravity_m_per_s2
    times, places, phases = [], [], []
    for index in range(round(duration_s / tick)):
        place, _ = commanded(foot, phase, 0.0)
        load = np.maximum(0.0, body.stiffness_z_n_per_m * (feet[:, 2] - place[:, 1])) / weight
        rate = omega - sigma * load * np.cos(phase)
        data.ctrl[:] = drive(body, *commanded(foot, phase, rate)).ravel()
        mujoco.mj_step(model, data)
        phase = phase + tick * rate
        times.append((index + 1) * tick)
        places.append(data.qpos[:3].copy())
        phases.append(phase)
    return TwinWalk(np.array(times), np.array(places), np.array(phases))


def cores() -> int:
    """Return the number of cores that this process may use."""
    affinity = getattr(os, "sched_getaffinity", None)
    return len(affinity(0)) if affinity else os.cpu_count() or 1


def mujoco_ticks_per_second(
    body: Walker,
    foot: EllipticFoot,
    *,
    omega: float,
    lanes: int = 256,
    ticks: int = 500,
    settings: Settings | None = None,
) -> tuple[float, float]:
    """Time steps per second, and per core-second, of the bare model in MuJoCo's batched rollout.

    All cores work. A trot is commanded from beforehand: no oscillator, no feedback, no Python in
    the loop, nothing recorded. The best of three runs.

    Raises:
        MissingExtraError: without MuJoCo.
    """
    mujoco, batched = require("mujoco", "mujoco"), require("mujoco.rollout", "mujoco")
    model = mujoco.MjModel.from_xml_string(description(body, settings))
    data = mujoco.MjData(model)
    lags = np.pi * np.arange(len(body.hips_x_m))
    lags[2:] = lags[2:][::-1]
    phase = lags + omega * model.opt.timestep * np.arange(ticks)[:, None]
    _put_feet(body, foot, phase[0], data)
    kind = mujoco.mjtState.mjSTATE_FULLPHYSICS
    state = np.empty((1, mujoco.mj_stateSize(model, kind)))
    mujoco.mj_getState(model, data, state[0], kind)
    pushes = drive(body, *commanded(foot, phase, omega)).reshape(1, ticks, model.nu)
    inputs = np.repeat(state, lanes, axis=0), np.repeat(pushes, lanes, axis=0)
    threads = cores()
    workers = [mujoco.MjData(model) for _ in range(threads)]
    times, work = [], []
    with batched.Rollout(nthread=threads) as rollout:
        for _ in range(4):
            begun, begun_work = time.perf_counter(), time.process_time()
            rollout.rollout([model] * lanes, workers, *inputs, nstep=ticks, skip_checks=True)
            times.append(time.perf_counter() - begun)
            work.append(time.process_time() - begun_work)
    return lanes * ticks / min(times[1:]), lanes * ticks / min(work[1:])
