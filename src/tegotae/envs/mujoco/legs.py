"""Legs of a MuJoCo model: where a foot is, which angles put it elsewhere, and what it bears."""

from __future__ import annotations

import math
import pickle
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache, partial
from typing import TYPE_CHECKING, Any, Literal

import jax
import jax.numpy as jnp
import numpy as np

from tegotae._support import compiled
from tegotae._support.engines import NATIVE, selected
from tegotae._support.errors import TegotaeError, require
from tegotae.envs._types import MjData, MjModel
from tegotae.envs.mujoco.chains import Chains, borne, foot_velocities, kinematics, solved
from tegotae.envs.mujoco.rigid_legs import require_open_chains, require_stiff
from tegotae.envs.scaling import chain_of, foot_of, foot_place, lowest, started

if TYPE_CHECKING:
    from lanewise.function import FunctionKernel

AXES = ("x", "y", "z")
"""Forward, to the left and up, of the trunk."""
_BLOCK = 32
"""Lanes that native code computes at once."""
_MOVES = 1e-6
"""A foot moves if its Jacobian, over the length of the leg, has an entry above this."""

STANDS, _RISES = 0.06, 0.18
"""A foot stands within this height over the lowest one, over the leg's length l, and while it does
not rise faster than this over √(g l)."""
_G_M_PER_S2 = 9.81
_LEAST_M = 0.01
"""Length of a leg."""
_OUTSIDE = 0.01
"""A start is outside a joint's limits if it is by more than this [rad or m]."""

_OfLegs = Callable[..., jax.Array]
"""A function of chains and of arrays by name, [numbers, legs, lanes]."""
_Program = Callable[[Mapping[str, np.ndarray]], np.ndarray]


@dataclass(frozen=True, eq=False)
class LegKinematics:
    """Legs whose feet can be commanded to places.

    Args:
        feet: their names.
        joint_names: those of the joints, leg by leg, from the trunk on.
        chains: their geometry.
        length_m: length l of the longest leg, from its first joint over all others to the foot [m].
        start: joints in the model's start [rad or m], [legs, joints].
        joints: which ones of the model they are, likewise; -1 where a leg has fewer than another.
        servos: which actuators drive them, likewise.
        gears: of the servos, likewise.
        rolling: radius of the feet over their distance from the first joints; round feet roll, and
            go so much further than their centres turn.
    """

    feet: tuple[str, ...]
    joint_names: tuple[tuple[str, ...], ...]
    chains: Chains
    length_m: float
    start: np.ndarray
    joints: np.ndarray
    servos: np.ndarray
    gears: np.ndarray
    rolling: float = 0.0
    _programs: dict[_OfLegs, _Program] = field(default_factory=dict, repr=False)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the numbers of all places: `FOOT_x`, `FOOT_y` and `FOOT_z`."""
        return tuple(f"{foot}_{axis}" for foot in self.feet for axis in AXES)

    @property
    def height_m(self) -> float:
        """Mean height of the first joints over the feet in the model's start, l0 [m]."""
        return self.length_m * float(np.mean(self.chains.anchor[:, 0, 2] - self.chains.foot[:, 2]))

    def joints_at(self, place_m: np.ndarray) -> np.ndarray:
        """Return the joints that place the feet at given points, or as near to them as they reach.

        In closed form where there is one, `chains.direct`; from there, or from the model's start,
        by damped least squares. With e from the foot to its place and J its Jacobian, both over
        the leg's length, and joints at a limit held where they would leave it:

            q ← q + Jᵀ (J Jᵀ + (e² / 2 + 10⁻⁴) I)⁻¹ e.

        Args:
            place_m: from the place in the model's start, in the axes of the trunk [m],
                [lanes, legs, 3].

        Returns:
            Joints [rad or m], [lanes, legs, joints].

        Reference: T. Sugihara, Solvability-unconcerned inverse kinematics by the
        Levenberg-Marquardt method, IEEE Transactions on Robotics 27 (2011).
        """
        moved = self._computed(_solved, place=np.divide(place_m, self.length_m))
        return self.start + self._unit * moved

    def places_of(self, joints: np.ndarray) -> np.ndarray:
        """Return places of feet [m], [lanes, legs, 3], at joints [rad or m], [lanes, legs,
        joints]."""
        foot = self._computed(_reached, moved=self._moved(joints))
        return self.length_m * (foot - self.chains.foot)

    def forces_n(self, joints: np.ndarray, torques: np.ndarray) -> np.ndarray:
        """Return the ground's forces on feet, from the torques that hold massless legs:

            F = -(J Jᵀ + 10⁻⁴ l² I)⁻¹ J τ,

        -J⁻ᵀ τ but for the damping, where a leg has three joints.

        Args:
            joints: [rad or m], [lanes, legs, joints].
            torques: of the servos [N m or N], likewise.

        Returns:
            In the axes of the trunk [N], [lanes, legs, 3].
        """
        pull = torques / np.where(self.chains.slides, 1.0, self.length_m)
        return self._computed(_borne, moved=self._moved(joints), pull=pull)

    def trunk_velocities_m_per_s(
        self, joints: np.ndarray, rates: np.ndarray, turning: np.ndarray
    ) -> np.ndarray:
        """Return the velocity of the trunk as each foot tells it if it stands on the ground:

            v = -((1 + r / h) J q̇ + ω × p),

        leg odometry; the first term is larger by the rolling of a round foot.

        Args:
            joints: q [rad or m], [lanes, legs, joints].
            rates: q̇ [rad/s or m/s], likewise.
            turning: ω, the gyroscope's [rad/s], [lanes, 3].

        Returns:
            Of the trunk's origin, in its axes [m/s], [lanes, legs, 3].

        Reference: G. P. Roston, E. P. Krotkov, Dead reckoning navigation for walking robots, IROS
        (1992).
        """
        moved = self._moved(joints)
        foot = self._computed(_reached, moved=moved)
        relative = self._computed(_moving, moved=moved, rates=rates / self._unit)
        relative = (1.0 + self.rolling) * relative
        return -self.length_m * (relative + np.cross(turning[:, None], foot))

    @property
    def rising_m_per_s(self) -> float:
        """Speed up at which a foot counts as swinging [m/s]."""
        return _RISES * math.sqrt(_G_M_PER_S2 * self.length_m)

    @property
    def feet_m(self) -> np.ndarray:
        """Places of the feet in the model's start, in the axes of the trunk [m], [legs, 3]."""
        return self.length_m * np.asarray(self.chains.foot, float)

    @property
    def _unit(self) -> np.ndarray:
        """Unit of each joint's coordinate [rad or m]."""
        return np.where(self.chains.slides, self.length_m, 1.0)

    def _moved(self, joints: np.ndarray) -> np.ndarray:
        return (joints - self.start) / self._unit

    def _computed(self, function: _OfLegs, **arrays: np.ndarray) -> np.ndarray:
        """Compute a function of arrays [lanes, legs, numbers], and return its result in this
        layout.
        """
        inputs = {name: np.asarray(x.T, np.float32) for name, x in arrays.items()}
        if function not in self._programs:
            self._programs[function] = _program(function, self.chains, inputs)
        return np.array(self._programs[function](inputs), float).T


def legs_of(model: MjModel, feet: Sequence[str]) -> LegKinematics:
    """Return the legs of a compiled model: for every foot the driven joints between it and the
    trunk.

    Joints that several feet hang on stay as they are in the start, and so do those that nothing
    drives, whose springs must bear a share of the weight.

    Args:
        model: an `MjModel`.
        feet: bodies or geoms.

    Raises:
        TegotaeError: for no feet; for a leg without a driven joint of its own or without length,
            whose joints do not move the foot or start outside their limits, or that is driven by
            anything but position servos; for a joint that nothing drives and that yields, or legs
            that are closed chains.
    """
    if not feet:
        raise TegotaeError("legs=true commands feet to places; name the feet, --feet")
    require_open_chains(model, feet)
    owners = _joints(model, feet)
    servos = [[_servo(model, joint) for joint in row] for row in owners]
    data = started(model)
    trunk, origin = data.xmat[1].reshape(3, 3), data.xpos[1]
    foot = (np.array([foot_place(model, data, name) for name in feet]) - origin) @ trunk
    joints = _padded(owners)
    valid = joints >= 0
    axis = np.where(valid[..., None], data.xaxis[joints] @ trunk, 0.0)
    anchor = np.where(valid[..., None], (data.xanchor[joints] - origin) @ trunk, 0.0)
    slide = int(require("mujoco", "mujoco").mjtJoint.mjJNT_SLIDE)
    slides = valid & (model.jnt_type[joints] == slide)
    start = np.where(valid, data.qpos[model.jnt_qposadr[joints]], 0.0)
    limited = valid & model.jnt_limited[joints].astype(bool)
    drives = _padded(servos)
    gears = np.where(valid, model.actuator_gear[drives, 0], 1.0)
    commanded = np.sort(model.actuator_ctrlrange[drives] / gears[..., None])
    held = valid & model.actuator_ctrllimited[drives].astype(bool)
    ends = ((limited, model.jnt_range[joints]), (held, commanded))
    low = np.max([np.where(are, bounds[..., 0] - start, -np.inf) for are, bounds in ends], axis=0)
    high = np.min([np.where(are, bounds[..., 1] - start, np.inf) for are, bounds in ends], axis=0)
    lengths = list(map(_length, anchor, foot, owners))
    length = max(lengths)
    for name, own_m in zip(feet, lengths, strict=True):
        if own_m < _LEAST_M:
            raise TegotaeError(
                f"the leg of {name} has no length: its first joint is at its foot; leave legs=true "
                "out and command the joints"
            )
    for leg, k in zip(*np.nonzero((low > _OUTSIDE) | (high < -_OUTSIDE)), strict=True):
        ends = start[leg, k] + np.array([low[leg, k], high[leg, k]])
        raise TegotaeError(
            f"joint {model.joint(joints[leg, k]).name} starts at {start[leg, k]:.3g}, outside its "
            f"limits of {ends[0]:.3g} to {ends[1]:.3g}; begin elsewhere: "
            "--settings start=KEYFRAME or 'start={\"JOINT\": POSITION}'"
        )
    require_stiff(model, data, feet, _driven(model), length)
    unit = np.where(slides, length, 1.0)
    numbers = axis, anchor / length, slides, foot / length, low / unit, high / unit
    chains = Chains(*(np.asarray(x, np.float32) for x in numbers))
    _, columns = kinematics(chains, list(np.zeros((joints.shape[1], len(feet), 1), np.float32)))
    for name, largest in zip(feet, np.abs(columns).max((0, 1, 3)), strict=True):
        if largest < _MOVES:
            raise TegotaeError(f"the joints of the leg of {name} do not move it; name another foot")
    names = tuple(tuple(model.joint(joint).name for joint in row) for row in owners)
    heights = [foot_place(model, data, name)[2] - _sole(model, data, name) for name in feet]
    rolling = float(np.mean(heights)) / (
        length * float(np.mean((chains.anchor[:, 0] - chains.foot)[:, 2]))
    )
    return LegKinematics(tuple(feet), names, chains, length, start, joints, drives, gears, rolling)


def _sole(model: MjModel, data: MjData, foot: str) -> float:
    """Return the height of the lowest point of a foot [m]; its place without geoms."""
    geoms = foot_of(model, foot).geoms
    return lowest(model, data, geoms)[0] if geoms else float(foot_place(model, data, foot)[2])


def _joints(model: MjModel, feet: Sequence[str]) -> list[list[int]]:
    """Return, for every foot, the driven joints that it alone hangs on, from the trunk on."""
    chains = [chain_of(model, foot) for foot in feet]
    body = model.jnt_bodyid
    alone = [
        joint for joint in _driven(model) if sum(body[joint] in chain for chain in chains) == 1
    ]
    joints = [[joint for joint in alone if body[joint] in chain] for chain in chains]
    for foot, leg_joints in zip(feet, joints, strict=True):
        if model.body_rootid[foot_of(model, foot).body] != 1:
            raise TegotaeError(
                f"{foot} does not hang on {model.body(1).name}, the first body, which is to be the "
                f"trunk; leave that out, --settings without={model.body(1).name}"
            )
        if not leg_joints:
            raise TegotaeError(
                f"no actuator moves a joint between the trunk and {foot} alone, so that it cannot "
                "be commanded to a place; name other feet, or leave legs=true out"
            )
    return joints


def _driven(model: MjModel) -> list[int]:
    """Return the joints that actuators drive."""
    return sorted({int(model.actuator_trnid[i, 0]) for i in _on_joints(model)})


def _on_joints(model: MjModel) -> list[int]:
    on_joint = model.actuator_trntype == int(require("mujoco", "mujoco").mjtTrn.mjTRN_JOINT)
    return np.flatnonzero(on_joint).tolist()


def drive_of(model: MjModel, actuator: int) -> Literal["motor", "servo"] | None:
    """Return "motor" for an actuator of force k u, "servo" for one of k (u - q) less damping, else
    None."""
    mujoco = require("mujoco", "mujoco")
    gain, bias = float(model.actuator_gainprm[actuator, 0]), model.actuator_biasprm[actuator]
    kinds = model.actuator_gaintype, model.actuator_biastype, model.actuator_dyntype
    of_gain, of_bias, dynamics = (int(kind[actuator]) for kind in kinds)
    integrates = dynamics == int(mujoco.mjtDyn.mjDYN_INTEGRATOR)
    if of_gain != int(mujoco.mjtGain.mjGAIN_FIXED) or integrates:
        return None
    if gain == 0.0 or model.actuator_gear[actuator, 0] == 0.0:
        return None
    if of_bias == int(mujoco.mjtBias.mjBIAS_NONE):
        return "motor"
    at_command = gain > 0.0 and bias[0] == 0.0 and math.isclose(gain, -bias[1])
    return "servo" if of_bias == int(mujoco.mjtBias.mjBIAS_AFFINE) and at_command else None


def resting(model: MjModel) -> np.ndarray:
    """Return commands of all actuators that keep a model in its start, [actuators].

    They are the keyframe's or, where it has none but zeros, the positions of servos.
    """
    data = started(model)
    if not data.ctrl.any():
        servos = [i for i in _on_joints(model) if drive_of(model, i) == "servo"]
        data.ctrl[servos] = data.actuator_length[servos]
    limited = model.actuator_ctrllimited.astype(bool)
    return np.where(limited, np.clip(data.ctrl, *model.actuator_ctrlrange.T), data.ctrl)


def _servo(model: MjModel, joint: int) -> int:
    """Return the position servo of a joint."""
    actuators = [i for i in _on_joints(model) if model.actuator_trnid[i, 0] == joint]
    drives = [drive_of(model, i) for i in actuators]
    if drives == ["servo"]:
        return actuators[0]
    right = "give it one <position> actuator"
    if drives == ["motor"]:
        right = "make servos of the motors: --settings servo_nm_per_rad=K"
    raise TegotaeError(
        f"joint {model.joint(joint).name} is not driven by a position servo alone, k (u - q), and "
        f"angles put a foot somewhere; {right}"
    )


def _padded(rows: Sequence[Sequence[int]]) -> np.ndarray:
    longest = max(map(len, rows))
    return np.array([[*row, *[-1] * (longest - len(row))] for row in rows])


def _length(anchor: np.ndarray, foot: np.ndarray, joints: Sequence[int]) -> float:
    """Return the length of a leg from the first joint over all others to the foot [m]."""
    path = np.vstack([anchor[: len(joints)], foot])
    return float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum())


def _program(function: _OfLegs, chains: Chains, like: Mapping[str, np.ndarray]) -> _Program:
    """Compile a function of chains and arrays by name to native code, or by XLA where there is
    none.
    """
    if selected() != NATIVE:
        return jax.jit(partial(function, chains))
    shapes = tuple((name, x.shape[:-1]) for name, x in like.items())
    native = _compiled(function, pickle.dumps(chains), shapes).step(compiled)

    def run(inputs: Mapping[str, np.ndarray]) -> np.ndarray:
        lanes, results = next(iter(inputs.values())).shape[-1], []
        for first in range(0, max(lanes, 1), _BLOCK):
            block = slice(0, min(_BLOCK, lanes - first))
            for name, x in inputs.items():
                native.inputs[name][..., block] = x[..., first : first + _BLOCK]
            native()
            results.append(native.outputs["result"][..., block].copy())
        return np.concatenate(results, axis=-1)

    return run


@lru_cache(maxsize=32)
def _compiled(
    function: _OfLegs, chains: bytes, shapes: tuple[tuple[str, tuple[int, ...]], ...]
) -> FunctionKernel:
    """Return the compiled function, one for all models with legs of the same geometry."""
    from lanewise.function import compile_function  # llvmlite may be missing

    def step(state: Any, inputs: Any) -> Any:
        return state, {"result": function(pickle.loads(chains), inputs)}

    single = {name: jax.ShapeDtypeStruct((*shape, 1), "float32") for name, shape in shapes}
    return compile_function(step, {"none": np.zeros(1, np.float32)}, single, lanes=_BLOCK)


def _solved(chains: Chains, arrays: Mapping[str, jax.Array]) -> jax.Array:
    return solved(chains, [arrays["place"][i] for i in range(3)])


def _reached(chains: Chains, arrays: Mapping[str, jax.Array]) -> jax.Array:
    """Return the places of feet, [3, legs, lanes], of joints, [joints, legs, lanes]."""
    return jnp.stack(kinematics(chains, _rows(chains, arrays["moved"]))[0])


def _borne(chains: Chains, arrays: Mapping[str, jax.Array]) -> jax.Array:
    """Return the forces on feet, [3, legs, lanes], from joints and their torques, [joints, ...]."""
    return jnp.stack(borne(chains, _rows(chains, arrays["moved"]), _rows(chains, arrays["pull"])))


def _moving(chains: Chains, arrays: Mapping[str, jax.Array]) -> jax.Array:
    """Return the velocities of feet, [3, legs, lanes], from joints and rates, [joints, ...]."""
    rates = _rows(chains, arrays["rates"])
    return jnp.stack(foot_velocities(chains, _rows(chains, arrays["moved"]), rates))


def _rows(chains: Chains, array: jax.Array) -> list[jax.Array]:
    return [array[k] for k in range(chains.slides.shape[1])]
