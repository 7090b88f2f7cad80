"""A MuJoCo model as a user names it: its file, what is changed of it, and how its episodes go."""

from __future__ import annotations

import contextlib
import re
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib import resources
from importlib.util import find_spec
from pathlib import Path

import numpy as np

from tegotae._support.errors import TegotaeError, require, require_kind, require_known, unknown
from tegotae.envs._types import MjModel, MjsActuator, MjSpec
from tegotae.envs.command import CommandSchedule
from tegotae.envs.scaling import lowest
from tegotae.parts.parameters import Part, finite, not_negative, positive

_OCCASION = re.compile(r" at DOF \d+| Time = [-\d.einf]*\d\.")
"""Parts that differ between two warnings of MuJoCo of one kind."""


def _is_place(entry: tuple[str, float]) -> bool:
    """Return whether an entry is a joint's name and a finite position."""
    name, place = entry
    number = isinstance(place, (int, float)) and not isinstance(place, bool)
    return isinstance(name, str) and number and bool(np.isfinite(place))


@dataclass(frozen=True, kw_only=True)
class ModelSettings(Part):
    """A MuJoCo model as an environment, `tegotae.envs.mujoco.env.ModelEnv`.

    Args:
        model: an MJCF file, its text, or the name of a model of this package: `hopper`, `leg` or
            `quadruped`. A file of another installed package is `PACKAGE:FILE`.
        feet: names of the bodies or geoms whose contact forces are observed.
        control_s: time for which an action is held [s].
        duration_s: length of an episode [s].
        release_m: how much higher than in the model the first body is released [m].
        noise: standard deviation of what is added to all positions at a reset [m or rad].
        fallen_share: the episode ends when the first body is lower than this share of its height in
            the model, or its axis has tipped below the horizontal.
        ground: whether to add a level floor at height 0, for a model of a robot alone.
        without: names of bodies and geoms of the model to leave out, such as a wall.
        start: the model's start: the name of a keyframe, by default the first one; or positions of
            joints by name [rad or m], others as without a keyframe, over a floor at height 0.
        servo_nm_per_rad: makes of every motor of a joint a position servo of this stiffness k
            [N m/rad, or N/m]; 0 leaves motors as they are. A servo gives its joint the torque
            `k (u - q)` at position q for the command u, within the motor's own limits of force; u
            is limited to the joint's range. The joint's own damping damps it, and
            `servo_damping_nms_per_rad`.
        servo_damping_nms_per_rad: what the servos' torques are less by, times the joint's speed
            [N m s/rad, or N s/m].
        legs: whether feet are commanded to places, and not joints: with the actions `FOOT_x`,
            `FOOT_y`, `FOOT_z` from each foot's place in the model's start, forward, to the left and
            up in the axes of the trunk [m]. Inverse kinematics of the leg sets its servos.
        command: forward, left [m/s] and yaw rate [rad/s] that a robot with `legs` is to have, a
            heading [rad] as a fourth, or a CSV of them over time (`CommandSchedule`). With one, its
            odometry and the commanded velocity over each foot are observed: `FOOT_odometry_x`,
            `FOOT_commanded_x` and `_y` [m/s], forward and to the left in the axes of the trunk, and
            `commanded_speed`. It turns to its heading, that of the yaw rate without another
            (`heading_rate`); `root_heading` is that of the gyroscope.
        mass_factor: what all masses and inertias are multiplied by, to test robustness.
        friction_factor: what all sliding friction is multiplied by, likewise.
        effort: what a unit of work, over weight and length, costs in the reward.

    Raises:
        TegotaeError: for a number out of its range, or names that are none.
    """

    model: str | Path
    feet: Sequence[str] = ()
    control_s: float = positive(0.01)
    duration_s: float = positive(24.0)
    release_m: float = not_negative(0.0)
    noise: float = not_negative(0.0)
    fallen_share: float = finite(0.3, least=0.0, most=1.0)
    ground: bool = False
    without: Sequence[str] = ()
    start: str | Mapping[str, float] = ""
    servo_nm_per_rad: float = not_negative(0.0)
    servo_damping_nms_per_rad: float = not_negative(0.0)
    legs: bool = False
    command: Sequence[float] | str = ()
    mass_factor: float = positive(1.0)
    friction_factor: float = positive(1.0)
    effort: float = not_negative(0.1)

    def __post_init__(self) -> None:
        super().__post_init__()
        for name in ("ground", "legs"):
            require_kind(name, getattr(self, name), bool, "true or false")
        for name, kinds in (("feet", "bodies or geoms"), ("without", "bodies and geoms")):
            names = getattr(self, name)
            if not isinstance(names, (list, tuple)) or not all(isinstance(n, str) for n in names):
                raise TegotaeError(f"{name} is {names!r}; it must be a list of names of {kinds}")
            if twice := [x for i, x in enumerate(names) if x in names[:i]]:
                raise TegotaeError(f"{twice[0]} is named twice in {name}; name it once")
        places = self.start.items() if isinstance(self.start, Mapping) else ()
        if not isinstance(self.start, (str, Mapping)) or not all(map(_is_place, places)):
            raise TegotaeError(
                f"start is {self.start!r}; it must be the name of a keyframe, or finite positions "
                'by joint such as {"knee": -1.2}'
            )
        if self.command:
            if not self.legs:
                raise TegotaeError("command is of a robot whose feet are commanded; add legs=true")
            CommandSchedule.from_command(self.command)
        if self.servo_damping_nms_per_rad and not self.servo_nm_per_rad:
            raise TegotaeError(
                f"servo_damping_nms_per_rad is {self.servo_damping_nms_per_rad:g}, of servos that "
                "are not made; give servo_nm_per_rad, their stiffness, too"
            )

    def spec(self) -> MjSpec:
        """Return the `MjSpec`, adapted and not yet compiled.

        Raises:
            TegotaeError: for a file that is no model; for something to leave out that the model
                does not have, or servos where no joint has a motor.
            MissingExtraError: without MuJoCo.
        """
        spec = _read(str(self.model))
        for name in self.without:
            part = spec.body(name) or spec.geom(name)
            if part is None or name == "world":
                names = {part.name for part in (*spec.bodies, *spec.geoms)} - {"", "world"}
                raise unknown("body or geom of this model", name, sorted(names))
            spec.delete(part)
        if self.ground:
            plane = require("mujoco", "mujoco").mjtGeom.mjGEOM_PLANE
            spec.worldbody.add_geom(name="tegotae/ground", type=plane, size=[0.0, 0.0, 1.0])
        if self.servo_nm_per_rad:
            _make_servos(spec, self.servo_nm_per_rad, self.servo_damping_nms_per_rad)
        if self.start:
            _begin(spec, self.start)
        return spec


PACKAGED = {
    "hopper": ModelSettings(model="hopper", feet=("foot",), control_s=0.002, release_m=0.2),
    "leg": ModelSettings(model="leg", feet=("foot",), control_s=0.005, release_m=0.05),
    "quadruped": ModelSettings(
        model="quadruped",
        feet=("foot0", "foot1", "foot2", "foot3"),
        # Ten of its time steps, which follow from the walker's own time unit.
        control_s=10 * 0.005 * (0.2 / 9.81) ** 0.5,
        noise=0.01,
    ),
}
"""The models of this package as environments, by name."""


def _read(text: str) -> MjSpec:
    """Return the `MjSpec` of an MJCF file, of its text, or of a model of this package by its
    name.
    """
    mujoco = require("mujoco", "mujoco")
    if mujoco.get_mju_user_warning() is None:
        mujoco.set_mju_user_warning(_warn)
    try:
        if text.lstrip().startswith("<"):
            return mujoco.MjSpec.from_string(text)
        if text in model_files():
            return mujoco.MjSpec.from_string(model_files()[text])
        if not text.endswith((".xml", ".mjcf")):
            raise unknown("MuJoCo model of this package", text, model_files())
        return mujoco.MjSpec.from_file(str(located(text)))
    except TegotaeError:
        raise
    except ValueError as error:
        first = " ".join(str(error).split())
        raise TegotaeError(f"MuJoCo cannot read {text[:80]!r}: {first}") from None


def _warn(message: str) -> None:
    """Report a warning of MuJoCo as one of Python, not on the terminal and in MUJOCO_LOG.TXT."""
    with contextlib.suppress(Warning):  # that is an error here, perhaps in a thread of MuJoCo's
        warnings.warn(f"MuJoCo: {_OCCASION.sub('', message).strip()}", stacklevel=2)


def located(text: str) -> Path:
    """Return the file of a model: a path, or `PACKAGE:FILE`, a file in the folder of an installed
    package.

    The package is not imported.

    Raises:
        TegotaeError: if there is no such file, or no such package.

    Example:
        >>> located("tegotae:envs/mujoco/models/leg.xml").name
        'leg.xml'
    """
    path = Path(text)
    package, colon, inside = text.partition(":")
    # A single letter is a drive.
    if colon and len(package) > 1 and package.isidentifier() and not path.exists():
        spec = find_spec(package)
        if spec is None or not spec.submodule_search_locations:
            raise TegotaeError(
                f"{inside} is to be read from {package}, and no such package is installed"
            )
        path = Path(spec.submodule_search_locations[0]) / inside
    if not path.is_file():
        raise TegotaeError(f"there is no file {path}")
    return path


def model_files() -> dict[str, str]:
    """Return the MJCF of the models that come with the package, by name."""
    folder = resources.files("tegotae.envs.mujoco") / "models"
    files = sorted(file.name for file in folder.iterdir() if file.name.endswith(".xml"))
    return {name[:-4]: (folder / name).read_text(encoding="utf-8") for name in files}


def _begin(spec: MjSpec, start: str | Mapping[str, float]) -> None:
    """Leave the one keyframe that the model is to start in.

    Raises:
        TegotaeError: for a keyframe or a joint that the model does not have.
    """
    keys = {key.name or str(i): key for i, key in enumerate(spec.keys)}
    if isinstance(start, str) and start not in keys:
        raise unknown("keyframe of this model", start, keys)
    for name, key in keys.items():
        if name != start:
            spec.delete(key)
    spec.nkey = 0  # of <size nkey="5"/>, which makes keyframes of zeros
    if not isinstance(start, str):
        spec.add_key(name="start", qpos=_posed(spec, start))


def _posed(spec: MjSpec, places: Mapping[str, float]) -> np.ndarray:
    """Return a model's positions with joints at places, its lowest geom on a floor at height 0."""
    mujoco = require("mujoco", "mujoco")
    model = compiled_model(spec)
    data = mujoco.MjData(model)
    scalar = model.jnt_type >= int(mujoco.mjtJoint.mjJNT_SLIDE)
    names = [model.joint(int(joint)).name for joint in np.flatnonzero(scalar)]
    for name, place in places.items():
        require_known("hinge or slide of this model", name, names)
        data.qpos[model.joint(name).qposadr[0]] = place
    mujoco.mj_kinematics(model, data)
    if model.jnt_type[0] == int(mujoco.mjtJoint.mjJNT_FREE):
        data.qpos[2] -= lowest(model, data, np.flatnonzero(model.geom_bodyid > 0).tolist())[0]
    return data.qpos


def compiled_model(spec: MjSpec) -> MjModel:
    """Compile a model.

    Raises:
        TegotaeError: for one that MuJoCo cannot compile.
    """
    try:
        return spec.compile()
    except ValueError as error:
        message = " ".join(str(error).split())
        raise TegotaeError(f"MuJoCo cannot compile the model: {message}") from None


def _make_servos(spec: MjSpec, stiffness: float, damping: float) -> None:
    """Replace the motors of joints by position servos."""
    mujoco = require("mujoco", "mujoco")
    motors = [
        motor
        for motor in spec.actuators
        if motor.trntype == mujoco.mjtTrn.mjTRN_JOINT
        and motor.gaintype == mujoco.mjtGain.mjGAIN_FIXED
        and motor.biastype == mujoco.mjtBias.mjBIAS_NONE
        and motor.dyntype == mujoco.mjtDyn.mjDYN_NONE
    ]
    if not motors:
        raise TegotaeError(
            "no joint of the model has a motor to make a servo of; leave servo_nm_per_rad out"
        )
    for motor in motors:
        # What the motor could do stays what the servo can do.
        limit = abs(float(motor.gear[0])) * _most_force(motor)
        low, high = spec.joint(motor.target).range
        motor.ctrlrange = [0.0, 0.0]  # else it is not the joint's range that becomes it
        motor.set_to_position(stiffness, damping, inheritrange=low < high)
        motor.gear = [1.0, 0.0, 0.0, 0.0, 0.0, 0.0]
        motor.ctrllimited = low < high
        motor.forcelimited = np.isfinite(limit)
        motor.forcerange = [-limit, limit] if np.isfinite(limit) else [0.0, 0.0]


def _most_force(motor: MjsActuator) -> float:
    """Return the largest force of a motor, before its gear; infinite if nothing limits it."""
    gain = abs(float(motor.gainprm[0]))
    limits = [scale * np.abs(ends).max() for scale, ends in
            ((gain, motor.ctrlrange), (1.0, motor.forcerange)) if np.any(ends)]  # fmt: skip
    return float(min(limits, default=np.inf))
