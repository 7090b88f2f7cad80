"""A robot of a MuJoCo model in PyBullet: the same masses, joints and servos, on other contacts.

A model becomes a URDF. Feet are spheres that touch a plane; all else touches nothing. Servos give
the torque k (u - q) - d q̇ within the motor's limits at every time step, explicitly. Damping and dry
friction of joints are torques, too, and a rotor's inertia is part of the link that it turns.
"""

from __future__ import annotations

import math
import tempfile
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from tegotae._support.errors import require
from tegotae.envs._types import MjModel
from tegotae.envs.command import CommandSchedule
from tegotae.envs.mujoco.env import ModelLanes
from tegotae.envs.mujoco.sensing import Sensing
from tegotae.envs.mujoco.settings import ModelSettings
from tegotae.envs.scaling import foot_of

mujoco = require("mujoco", "mujoco")
pybullet: Any = import_module("pybullet")

_SLIP_RAD_PER_S = 0.05
"""Speed at which dry friction of a joint is at three quarters of its size."""


class BulletLanes(ModelLanes):
    """Lanes of a model whose physics is PyBullet's; observations and episodes are as there."""

    def __init__(
        self, settings: ModelSettings, lanes: int, *, schedule: CommandSchedule | None = None
    ) -> None:
        super().__init__(settings, lanes, threads=1, schedule=schedule)
        ticks, step_s = self.batch.ticks, self.batch.step_s
        self.batch.close()
        self.batch = _BulletBatch(self.sensing, lanes, ticks, step_s)  # type: ignore[assignment]


class _BulletBatch:
    """Lanes of a model in PyBullet with the methods of a `ModelBatch`."""

    def __init__(self, sensing: Sensing, lanes: int, ticks: int, step_s: float) -> None:
        self.sensing, self.lanes, self.ticks, self.step_s = sensing, lanes, ticks, step_s
        self.work_j = np.zeros(lanes)
        model = sensing.model
        self._joints = [int(model.actuator_trnid[i, 0]) for i in sensing.driven]
        self._q, self._dof = model.jnt_qposadr[self._joints], model.jnt_dofadr[self._joints]
        self._stiffness = model.actuator_gainprm[sensing.driven, 0]
        self._damping = -model.actuator_biasprm[sensing.driven, 2]
        limited = model.actuator_forcelimited[sensing.driven].astype(bool)
        self._most = np.where(limited, model.actuator_forcerange[sensing.driven, 1], np.inf)
        self._sensed = np.zeros((lanes, model.nsensordata))
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "robot.urdf"
            file.write_text(urdf_of(model, sensing.feet), encoding="utf-8")
            self._robots = [_Client(model, sensing.feet, file, self._joints) for _ in range(lanes)]

    def reset(self, height_m: float, noise: np.ndarray | None, where: np.ndarray) -> np.ndarray:
        """Reset some lanes; return the observations of all, [lanes, entries]."""
        model = self.sensing.model
        for lane in np.flatnonzero(where).tolist():
            data = mujoco.MjData(model)
            if model.nkey:
                mujoco.mj_resetDataKeyframe(model, data, 0)
            if noise is not None:
                mujoco.mj_integratePos(model, data.qpos, noise[lane], 1.0)
            data.qpos[2] += height_m
            self._robots[lane].place(data.qpos[:7], data.qpos[self._q])
            self._sense(lane, np.zeros(len(self._joints)))
            self.work_j[lane] = 0.0
        return self.sensing.observed(self._sensed)

    def step(self, action: np.ndarray, push_n: np.ndarray | None, where: np.ndarray) -> np.ndarray:
        """Advance some lanes by a control period; return the observations of all."""
        model, tick_s = self.sensing.model, self.step_s / self.ticks
        commands = self.sensing.controls(action)
        resist, dry = model.dof_damping[self._dof], model.dof_frictionloss[self._dof]
        for lane in np.flatnonzero(where).tolist():
            robot, torques = self._robots[lane], np.zeros(len(self._joints))
            for _ in range(self.ticks):
                q, rate = robot.joints()
                torques = self._stiffness * (commands[lane] - q) - self._damping * rate
                torques = np.clip(torques, -self._most, self._most)
                passive = resist * rate + dry * np.tanh(rate / _SLIP_RAD_PER_S)
                robot.advance(torques - passive, None if push_n is None else push_n[lane])
                self.work_j[lane] += tick_s * float(np.abs(torques * rate).sum())
            self._sense(lane, torques)
        return self.sensing.observed(self._sensed)

    def _sense(self, lane: int, torques: np.ndarray) -> None:
        """Write what MuJoCo's sensors of the model would measure."""
        robot, model, sensed = self._robots[lane], self.sensing.model, self._sensed[lane]

        def write(sensor: str, value: np.ndarray | float) -> None:
            place = model.sensor(f"tegotae/{sensor}")
            sensed[int(place.adr[0]) : int(place.adr[0]) + int(place.dim[0])] = value

        q, rate = robot.joints()
        names = zip(self.sensing.actuators, self._joints, strict=True)
        for k, (actuator, joint) in enumerate(names):
            write(model.joint(joint).name, q[k])
            write(f"{model.joint(joint).name}_velocity", rate[k])
            write(f"{actuator}_force", torques[k])
            write(f"speed/{actuator}", rate[k])
        place, turn, motion, spin = robot.trunk()
        for name, value in (
            ("root_place", place),
            ("root_motion", motion),
            ("root_axis", turn[:, 2]),
            ("root_ahead", turn[:, 0]),
            ("root_left", turn[:, 1]),
            ("root_turn", turn.T @ spin),
            ("root_run", turn.T @ motion),
        ):
            write(name, value)

    def close(self) -> None:
        """End all simulations."""
        for robot in self._robots:
            robot.close()


class _Client:
    """One robot in a simulation of its own."""

    def __init__(
        self, model: MjModel, feet: tuple[str, ...], file: Path, joints: list[int]
    ) -> None:
        self._id = {"physicsClientId": pybullet.connect(pybullet.DIRECT)}
        pybullet.setGravity(*model.opt.gravity, **self._id)
        pybullet.setTimeStep(model.opt.timestep, **self._id)
        plane = pybullet.createCollisionShape(pybullet.GEOM_PLANE, **self._id)
        floor = pybullet.createMultiBody(0.0, plane, **self._id)
        flags = pybullet.URDF_USE_INERTIA_FROM_FILE
        self._robot = pybullet.loadURDF(str(file), flags=flags, **self._id)
        links, names, owner = {}, {-1: 1}, _owners(model)
        for i in range(pybullet.getNumJoints(self._robot, **self._id)):
            info = pybullet.getJointInfo(self._robot, i, **self._id)
            links[info[1].decode()] = i
            names[i] = int(info[12].decode()[1:])
        self._joints = [links[model.joint(joint).name] for joint in joints]
        still = {"linearDamping": 0.0, "angularDamping": 0.0, "jointDamping": 0.0}
        friction = _friction(model, feet[0])
        for i, body in names.items():
            moments = _inertia(model, body, owner)[2].tolist()
            pybullet.changeDynamics(
                *(self._robot, i),
                lateralFriction=friction,
                localInertiaDiagonal=moments,
                **still,
                **self._id,
            )
        pybullet.changeDynamics(floor, -1, lateralFriction=1.0, **self._id)
        off = [0.0] * len(self._joints)
        pybullet.setJointMotorControlArray(
            *(self._robot, self._joints, pybullet.VELOCITY_CONTROL), forces=off, **self._id
        )
        dynamics = pybullet.getDynamicsInfo(self._robot, -1, **self._id)
        self._inertial = dynamics[3], dynamics[4]

    def place(self, root: np.ndarray, joints: np.ndarray) -> None:
        """Put the trunk and the joints somewhere, at rest."""
        x, y, z, *(w, i, k, m) = map(float, root)
        middle = pybullet.multiplyTransforms((x, y, z), (i, k, m, w), *self._inertial)
        pybullet.resetBasePositionAndOrientation(self._robot, *middle, **self._id)
        pybullet.resetBaseVelocity(self._robot, [0.0] * 3, [0.0] * 3, **self._id)
        for joint, angle in zip(self._joints, joints, strict=True):
            pybullet.resetJointState(self._robot, joint, float(angle), 0.0, **self._id)

    def joints(self) -> tuple[np.ndarray, np.ndarray]:
        """Return angles [rad] and rates [rad/s] of the joints."""
        states = pybullet.getJointStates(self._robot, self._joints, **self._id)
        return np.array([state[0] for state in states]), np.array([state[1] for state in states])

    def trunk(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Return place [m], axes, velocity [m/s] and rotation [rad/s] of the trunk's frame."""
        middle = pybullet.getBasePositionAndOrientation(self._robot, **self._id)
        inverse = pybullet.invertTransform(*self._inertial)
        place, quaternion = map(np.array, pybullet.multiplyTransforms(*middle, *inverse))
        turn = np.reshape(pybullet.getMatrixFromQuaternion(quaternion), (3, 3))
        motion, spin = map(np.array, pybullet.getBaseVelocity(self._robot, **self._id))
        return place, turn, motion + np.cross(spin, place - np.array(middle[0])), spin

    def advance(self, torques: np.ndarray, push_n: np.ndarray | None) -> None:
        """Advance by a time step."""
        pybullet.setJointMotorControlArray(
            *(self._robot, self._joints, pybullet.TORQUE_CONTROL),
            forces=torques.tolist(),
            **self._id,
        )
        if push_n is not None and push_n.any():
            middle = pybullet.getBasePositionAndOrientation(self._robot, **self._id)[0]
            world = pybullet.WORLD_FRAME
            pybullet.applyExternalForce(self._robot, -1, push_n, middle, world, **self._id)
        pybullet.stepSimulation(**self._id)

    def close(self) -> None:
        """End the simulation."""
        pybullet.disconnect(**self._id)


def _friction(model: MjModel, foot: str) -> float:
    """Return the sliding friction of a foot on the floor, as MuJoCo mixes it."""
    geom, floor = foot_of(model, foot).geoms[-1], int(np.flatnonzero(model.geom_bodyid == 0)[0])
    values = {int(i): float(model.geom_friction[i, 0]) for i in (geom, floor)}
    priority = model.geom_priority[[geom, floor]]
    if priority[0] != priority[1]:
        return values[geom] if priority[0] > priority[1] else values[floor]
    return max(values.values())


_Owners = dict[int, tuple[int, np.ndarray, np.ndarray]]
"""Link that every body is a part of, and its place and axes there."""


def urdf_of(model: MjModel, feet: tuple[str, ...]) -> str:
    """Return a robot as URDF: links with their inertia, hinges, and spheres as feet.

    Bodies without a joint are parts of those that they hang on.
    """
    parts = ['<robot name="robot">']
    owner = _owners(model)
    spheres: dict[int, list[tuple[np.ndarray, float]]] = {}
    for foot in feet:
        for geom in foot_of(model, foot).geoms:
            if model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_SPHERE and model.geom_contype[geom]:
                link, place, turn = owner[int(model.geom_bodyid[geom])]
                where = place + turn @ model.geom_pos[geom]
                spheres.setdefault(link, []).append((where, float(model.geom_size[geom, 0])))
    for link in sorted({link for link, _, _ in owner.values()}):
        parts += _link(model, link, owner, spheres.get(link, []))
        if link == 1:
            continue
        joint = int(model.body_jntadr[link])
        assert not model.jnt_pos[joint].any()
        parent, place, turn = owner[int(model.body_parentid[link])]
        origin = place + turn @ model.body_pos[link]
        rotation = turn @ _matrix(model.body_quat[link])
        low, high = model.jnt_range[joint] if model.jnt_limited[joint] else (-math.pi, math.pi)
        parts.append(
            f'<joint name="{model.joint(joint).name}" type="revolute"><parent link="b{parent}"/>'
            f'<child link="b{link}"/>{_origin(origin, rotation)}'
            f'<axis xyz="{_text(model.jnt_axis[joint])}"/>'
            f'<limit lower="{low}" upper="{high}" effort="1e4" velocity="1e3"/></joint>'
        )
    return "\n".join([*parts, "</robot>"])


def _owners(model: MjModel) -> _Owners:
    """Return the link that every body is a part of, and its place and axes there."""
    owner: _Owners = {}
    for body in range(1, model.nbody):
        if body == 1 or model.body_jntnum[body]:
            owner[body] = body, np.zeros(3), np.eye(3)
            continue
        link, place, turn = owner[int(model.body_parentid[body])]
        rotation = turn @ _matrix(model.body_quat[body])
        owner[body] = link, place + turn @ model.body_pos[body], rotation
    return owner


def _link(
    model: MjModel,
    link: int,
    owner: _Owners,
    spheres: list[tuple[np.ndarray, float]],
) -> list[str]:
    """Return a link with the mass of its parts; its inertia is set later."""
    mass, centre, _, axes = _inertia(model, link, owner)
    return [
        f'<link name="b{link}"><inertial>{_origin(centre, axes)}<mass value="{mass}"/>'
        '<inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>',
        *(
            f'<collision>{_origin(where)}<geometry><sphere radius="{radius}"/></geometry>'
            "</collision>"
            for where, radius in spheres
        ),
        "</link>",
    ]


def _inertia(
    model: MjModel, link: int, owner: _Owners
) -> tuple[float, np.ndarray, np.ndarray, np.ndarray]:
    """Return mass [kg], centre [m], principal moments [kg m²] and axes of a link.

    The rotor of its joint is a part of it, so that a moment can be larger than the sum of the
    others, which a file of a rigid body must not say.
    """
    parts = [
        (body, place, turn) for body, (of_link, place, turn) in owner.items() if of_link == link
    ]
    masses = np.array([model.body_mass[body] for body, _, _ in parts])
    centres = np.array([place + turn @ model.body_ipos[body] for body, place, turn in parts])
    centre = np.average(centres, axis=0, weights=masses)
    inertia = np.zeros((3, 3))
    for (body, _, turn), mass, where in zip(parts, masses, centres, strict=True):
        axes, arm = turn @ _matrix(model.body_iquat[body]), where - centre
        inertia += axes @ np.diag(model.body_inertia[body]) @ axes.T
        inertia += mass * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    if link != 1:
        joint = int(model.body_jntadr[link])
        axis = model.jnt_axis[joint]
        inertia += model.dof_armature[model.jnt_dofadr[joint]] * np.outer(axis, axis)
    moments, axes = np.linalg.eigh(inertia)
    axes[:, 2] *= np.linalg.det(axes)
    return float(masses.sum()), centre, moments, axes


def _matrix(quaternion: np.ndarray) -> np.ndarray:
    matrix = np.zeros(9)
    mujoco.mju_quat2Mat(matrix, quaternion)
    return matrix.reshape(3, 3)


def _origin(place: np.ndarray, turn: np.ndarray | None = None) -> str:
    turn = np.eye(3) if turn is None else turn
    roll, yaw = math.atan2(turn[2, 1], turn[2, 2]), math.atan2(turn[1, 0], turn[0, 0])
    pitch = math.asin(float(np.clip(-turn[2, 0], -1.0, 1.0)))
    return f'<origin xyz="{_text(place)}" rpy="{roll} {pitch} {yaw}"/>'


def _text(vector: np.ndarray) -> str:
    return " ".join(map(str, vector.tolist()))
