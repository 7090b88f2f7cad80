"""Senses and joints of a MuJoCo model, and the frame that fits its legs."""

from __future__ import annotations

import contextlib
import re
import warnings
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from importlib import resources
from importlib.util import find_spec
from pathlib import Path
from types import ModuleType
from typing import Protocol

import numpy as np

from tegotae._support.errors import TegotaeError, require, require_finite, unknown
from tegotae.envs._types import MjData, MjModel, MjsActuator, MjSpec


def fit(
    spec: MjSpec,
    *,
    ground: bool = False,
    without: Sequence[str] = (),
    servo_nm_per_rad: float = 0.0,
) -> None:
    """Change an `MjSpec` that is not compiled yet.

    A servo gives its joint the torque `k (u - q)` at position q for the command u, within the
    motor's own limits of force; u is limited to the joint's range. What damps it is the joint's own
    damping.

    Args:
        spec: the model's.
        ground: whether to add a level floor at height 0.
        without: names of bodies and geoms to leave out.
        servo_nm_per_rad: the stiffness k of every motor of a joint [N m/rad, or N/m]; 0 for none.

    Raises:
        TegotaeError: for something to leave out that the model does not have, or servos where no
            joint has a motor.

    Example:
        >>> import mujoco  # doctest: +SKIP
        >>> fit(mujoco.MjSpec.from_file("go1.xml"), ground=True)  # doctest: +SKIP
    """
    for name in without:
        found = spec.body(name) or spec.geom(name)
        if found is None or name == "world":
            known = [part.name for part in (*spec.bodies, *spec.geoms) if part.name]
            raise unknown("body or geom of this model", name, [n for n in known if n != "world"])
        spec.delete(found)
    if ground:
        plane = require("mujoco", "mujoco").mjtGeom.mjGEOM_PLANE
        spec.worldbody.add_geom(name="tegotae/ground", type=plane, size=[0.0, 0.0, 1.0])
    if servo_nm_per_rad:
        _make_servos(spec, servo_nm_per_rad)


def _make_servos(spec: MjSpec, stiffness: float) -> None:
    """Position servos in place of the motors of joints."""
    mujoco = require("mujoco", "mujoco")
    motors = [
        each
        for each in spec.actuators
        if each.trntype == mujoco.mjtTrn.mjTRN_JOINT
        and each.gaintype == mujoco.mjtGain.mjGAIN_FIXED
        and each.biastype == mujoco.mjtBias.mjBIAS_NONE
        and each.dyntype == mujoco.mjtDyn.mjDYN_NONE
    ]
    if not motors:
        raise TegotaeError(
            "no joint of the model has a motor to make a servo of; leave servo_nm_per_rad out"
        )
    for motor in motors:
        # What the motor could do stays what the servo can do.
        most = abs(float(motor.gear[0])) * _most_force(motor)
        low, high = spec.joint(motor.target).range
        motor.ctrlrange = [0.0, 0.0]  # else it is not the joint's range that becomes it
        motor.set_to_position(stiffness, inheritrange=low < high)
        motor.gear = [1.0, 0.0, 0.0, 0.0, 0.0, 0.0]
        motor.ctrllimited = low < high
        motor.forcelimited = np.isfinite(most)
        motor.forcerange = [-most, most] if np.isfinite(most) else [0.0, 0.0]


def _most_force(motor: MjsActuator) -> float:
    """The largest force of a motor, before its gear; infinite if nothing limits it."""
    gain = abs(float(motor.gainprm[0]))
    most = [scale * np.abs(each).max() for scale, each in
            ((gain, motor.ctrlrange), (1.0, motor.forcerange)) if np.any(each)]  # fmt: skip
    return float(min(most, default=np.inf))


_OWN = "tegotae/"
"""What the names of sensors begin with that are added here."""
_SHORTEST_S, _LONGEST_S = 1e-5, 0.1
"""Time steps: below, a second of the model takes minutes; above, a leg cannot be controlled."""
MOST = 1e10
"""Numbers beyond are of a model that explodes, as MuJoCo has it, too (`mjMAXVAL`)."""
_OCCASION = re.compile(r" at DOF \d+| Time = [-\d.einf]*\d\.")
"""What differs between two warnings of MuJoCo of one kind."""


@dataclass(frozen=True)
class ObservedEntry:
    """One number that is observed: `gain * (sensor - offset)`, at least `least`."""

    name: str
    column: int
    gain: float = 1.0
    offset: float = 0.0
    least: float = -np.inf


@dataclass(frozen=True)
class Sensing:
    """A model, and where in its sensor data is what.

    Raises:
        TegotaeError: for a file that is no model, or a foot that is no part of it.
    """

    model: MjModel
    """The `MjModel`."""
    entries: tuple[ObservedEntry, ...]
    """The observations, in order."""
    actuators: tuple[str, ...]
    """The driven entries. Adhesion is none of them: it is on all the time (`held`)."""
    driven: np.ndarray
    """Where in the model's controls these are."""
    held: np.ndarray
    """The model's controls where nothing is driven: adhesion at its most, all else 0."""
    forces: np.ndarray
    """Columns of the actuators' forces."""
    speeds: np.ndarray
    """Columns of the actuators' velocities."""
    root: str
    """Name of the first body, whose height is observed."""
    feet: tuple[str, ...]
    """Bodies and geoms whose contact forces are observed."""

    @property
    def names(self) -> tuple[str, ...]:
        """Names of what is observed."""
        return tuple(entry.name for entry in self.entries)

    @property
    def contacts(self) -> tuple[str, ...]:
        """Names of the feet's contact forces; an actuator's force may have the plain one."""
        named = [(f"{foot}_contact_force", f"{foot}_force") for foot in self.feet]
        return tuple(longer if longer in self.names else plain for longer, plain in named)

    def observed(self, data: np.ndarray) -> np.ndarray:
        """The observations from sensor data [..., columns], shape [..., entries]."""
        columns = [entry.column for entry in self.entries]
        gain = np.array([entry.gain for entry in self.entries])
        offset = np.array([entry.offset for entry in self.entries])
        least = np.array([entry.least for entry in self.entries])
        return np.maximum(gain * (data[..., columns] - offset), least)

    def power(self, data: np.ndarray) -> np.ndarray:
        """The actuators' powers of sensor data [..., columns], [W], shape [..., actuators]."""
        return data[..., self.forces] * data[..., self.speeds]


def read(source: str | Path) -> MjSpec:
    """The `MjSpec` of an MJCF file, of its text, or of a model of this package by its name.

    A file of another package that is installed is `PACKAGE:FILE` (`located`).

    Raises:
        TegotaeError: if there is no such file or model, or MuJoCo cannot read it.
    """
    mujoco = require("mujoco", "mujoco")
    if mujoco.get_mju_user_warning() is None:
        mujoco.set_mju_user_warning(_warn)
    text = str(source)
    try:
        if text.lstrip().startswith("<"):
            return mujoco.MjSpec.from_string(text)
        if text in models():
            return mujoco.MjSpec.from_string(models()[text])
        if not text.endswith((".xml", ".mjcf")):
            raise unknown("MuJoCo model of this package", text, models())
        return mujoco.MjSpec.from_file(str(located(text)))
    except TegotaeError:
        raise
    except ValueError as error:
        first = " ".join(str(error).split())
        raise TegotaeError(f"MuJoCo cannot read {text[:80]!r}: {first}") from None


def _warn(message: str) -> None:
    """A warning of MuJoCo as one of Python, not on the terminal and in MUJOCO_LOG.TXT."""
    with contextlib.suppress(Warning):  # that is an error here, perhaps in a thread of MuJoCo's
        warnings.warn(f"MuJoCo: {_OCCASION.sub('', message).strip()}", stacklevel=2)


def located(text: str) -> Path:
    """The file of a model: a path, or `PACKAGE:FILE`, a file in the folder of an installed package.

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
        found = find_spec(package)
        if found is None or not found.submodule_search_locations:
            raise TegotaeError(
                f"{inside} is to be read from {package}, and no such package is installed"
            )
        path = Path(found.submodule_search_locations[0]) / inside
    if not path.is_file():
        raise TegotaeError(f"there is no file {path}")
    return path


def models() -> dict[str, str]:
    """The MJCF of the models that come with the package, by name."""
    from tegotae.envs.mujoco.quadruped import mjcf

    folder = resources.files("tegotae.envs.mujoco") / "models"
    files = sorted(file.name for file in folder.iterdir() if file.name.endswith(".xml"))
    written = {name[:-4]: (folder / name).read_text(encoding="utf-8") for name in files}
    return {**written, "quadruped": mjcf()}


def sensing(
    source: str | Path,
    feet: Sequence[str],
    *,
    ground: bool = False,
    without: Sequence[str] = (),
    servo_nm_per_rad: float = 0.0,
    mass_factor: float = 1.0,
    friction_factor: float = 1.0,
) -> Sensing:
    """A model with sensors for all that a leg can feel.

    Observed are, by these names:

    - `JOINT` and `JOINT_velocity` of every hinge and slide joint [rad or m, and per s];
    - `JOINT_spring`, of those with a spring, the spring's force or torque [N or N m];
    - `ACTUATOR_force` of every actuator but adhesion [N or N m];
    - `FOOT_force`, the upward contact force on every foot [N], never negative;
    - `root_height`, `root_forward` [m], `root_velocity`, `root_climb` [m/s] and `root_upright`
      (the cosine of its tilt) of the model's first body;
    - the model's own sensors by their names, `NAME` or `NAME[i]`.

    Sensors are those of the last time step's beginning, as MuJoCo has it.

    Args:
        source: an MJCF file, `FILE` or `PACKAGE:FILE`, its text, or the name of a model of this
            package.
        feet: names of bodies or geoms.
        ground: whether to add a level floor at height 0, for a model that has none.
        without: names of bodies and geoms to leave out.
        servo_nm_per_rad: makes of every motor of a joint a position servo of this stiffness
            [N m/rad, or N/m]; 0 leaves them as they are.
        mass_factor: what all masses and inertias are multiplied by.
        friction_factor: what all sliding friction is multiplied by.

    Raises:
        TegotaeError: for a file that is no model, or a foot that is no part of it; for something to
            leave out that it does not have, or servos where no joint has a motor.

    Example:
        >>> sensing("hopper", ["foot"]).names[:3]  # doctest: +SKIP
        ('height', 'height_velocity', 'leg')
    """
    mujoco = require("mujoco", "mujoco")
    spec = read(source)
    kinds, objects = mujoco.mjtSensor, mujoco.mjtObj
    fit(spec, ground=ground, without=without, servo_nm_per_rad=servo_nm_per_rad)
    bodies = [body.name for body in spec.bodies if body.name != "world"]
    if not bodies:
        raise TegotaeError("the model has no body; give one that can move")
    touching = {foot: _touching(spec, foot) for foot in feet}
    root = bodies[0]
    if not root:
        raise TegotaeError("the first body of the MuJoCo model has no name; give it one")
    _name(spec.joints, "joint")
    _name(spec.actuators, "actuator")
    scalar = (mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE)
    joints = [joint for joint in spec.joints if joint.type in scalar]
    plans: list[tuple[str, object, object, str, dict[str, list[int]]]] = []
    for joint in joints:
        plans.append((joint.name, kinds.mjSENS_JOINTPOS, objects.mjOBJ_JOINT, joint.name, {}))
        velocity = f"{joint.name}_velocity"
        plans.append((velocity, kinds.mjSENS_JOINTVEL, objects.mjOBJ_JOINT, joint.name, {}))
    for actuator in spec.actuators:
        name, kind = actuator.name, objects.mjOBJ_ACTUATOR
        plans.append((f"{name}_force", kinds.mjSENS_ACTUATORFRC, kind, name, {}))
        plans.append((f"speed/{name}", kinds.mjSENS_ACTUATORVEL, kind, name, {}))
    for foot in feet:
        # Net force on the foot, in the world's axes.
        options = {"intprm": [1 << int(mujoco.mjtConDataField.mjCONDATA_FORCE), 3, 1]}
        plans.append((f"contact/{foot}", kinds.mjSENS_CONTACT, touching[foot], foot, options))
    frame = objects.mjOBJ_XBODY
    plans.append(("root_place", kinds.mjSENS_FRAMEPOS, frame, root, {}))
    plans.append(("root_motion", kinds.mjSENS_FRAMELINVEL, frame, root, {}))
    plans.append(("root_axis", kinds.mjSENS_FRAMEZAXIS, frame, root, {}))
    own = [sensor.name for sensor in spec.sensors]
    for name, kind, what, where, options in plans:
        spec.add_sensor(name=_OWN + name, type=kind, objtype=what, objname=where, **options)
    try:
        model = spec.compile()
    except ValueError as error:
        message = " ".join(str(error).split())
        raise TegotaeError(f"MuJoCo cannot compile the model: {message}") from None
    scale_model(model, mass_factor, friction_factor)
    elliptic = model.opt.cone == int(mujoco.mjtCone.mjCONE_ELLIPTIC)
    if elliptic and model.opt.jacobian == int(mujoco.mjtJacobian.mjJAC_AUTO):
        # The same steps but for rounding; a walking robot's take a quarter less time.
        model.opt.jacobian = int(mujoco.mjtJacobian.mjJAC_SPARSE)
    step_s = "the time step of the MuJoCo model [s]"
    require_finite(step_s, model.opt.timestep, least=_SHORTEST_S, most=_LONGEST_S)
    _check_start(mujoco, model)
    # A state that explodes stays so, and is seen: MuJoCo would put the model back to its start.
    model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_AUTORESET)
    at = {model.sensor(i).name: int(model.sensor_adr[i]) for i in range(model.nsensor)}
    sticks = model.actuator_trntype == int(mujoco.mjtTrn.mjTRN_BODY)
    actuators = [model.actuator(int(i)).name for i in np.flatnonzero(~sticks)]
    entries = _entries(model, joints, actuators, feet, at)
    entries += _own_entries(model, own)
    names = [entry.name for entry in entries]
    if twice := sorted({name for name in names if names.count(name) > 1}):
        raise TegotaeError(f"several of the model's entries are called {twice[0]!r}; rename one")
    return Sensing(
        model=model,
        entries=tuple(entries),
        actuators=tuple(actuators),
        driven=np.array([model.actuator(name).id for name in actuators], int),
        held=np.where(sticks, model.actuator_ctrlrange[:, 1], 0.0),
        forces=np.array([at[f"{_OWN}{name}_force"] for name in actuators], int),
        speeds=np.array([at[f"{_OWN}speed/{name}"] for name in actuators], int),
        root=root,
        feet=tuple(feet),
    )


def started(mujoco: ModuleType, model: MjModel) -> MjData:
    """MuJoCo's data at the model's start: its first keyframe, or else its zero."""
    data = mujoco.MjData(model)
    if model.nkey:
        mujoco.mj_resetDataKeyframe(model, data, 0)
    mujoco.mj_forward(model, data)
    return data


def is_sound(values: np.ndarray) -> np.ndarray:
    """Where numbers of a model are finite, and none that only a model that explodes has.

    Example:
        >>> is_sound(np.array([1.0, np.nan, 1e30])).tolist()
        [True, False, False]
    """
    return np.abs(values) < MOST


def _check_start(mujoco: ModuleType, model: MjModel) -> None:
    data = started(mujoco, model)
    for name in ("qpos", "qvel", "xpos", "qacc"):
        values = getattr(data, name)
        if not is_sound(values).all():
            worst = values[~is_sound(values)].flat[0]
            where = "its first keyframe" if model.nkey else "its positions, masses and gravity"
            raise TegotaeError(
                f"the MuJoCo model starts with {name} at {worst:g}; it must be finite and below "
                f"{MOST:g}: check {where}"
            )


def scale_model(model: MjModel, mass: float, friction: float) -> None:
    """Masses, inertias and sliding friction of a compiled model, multiplied."""
    model.geom_friction[:, 0] *= friction
    if mass != 1.0:
        mujoco = require("mujoco", "mujoco")
        model.body_mass *= mass
        model.body_inertia *= mass
        mujoco.mj_setConst(model, mujoco.MjData(model))  # what follows from masses


def _touching(spec: MjSpec, foot: str) -> object:
    """Whether a foot is a body or a geom, as MuJoCo's kind of object.

    Raises:
        TegotaeError: for a name that is neither's.
    """
    objects = require("mujoco", "mujoco").mjtObj
    bodies = [body.name for body in spec.bodies if body.name != "world"]
    geoms = [geom.name for geom in spec.geoms if geom.name and geom.parent.name != "world"]
    if foot in bodies:
        return objects.mjOBJ_BODY
    if foot in geoms:
        return objects.mjOBJ_GEOM
    for site in spec.sites:
        if site.name == foot:
            raise TegotaeError(
                f"{foot} is a site, which touches nothing; name its body, {site.parent.name}"
            )
    raise unknown("body or geom of this model", foot, [*bodies, *geoms])


class _Named(Protocol):
    name: str


def _name(elements: Iterable[_Named], kind: str) -> None:
    """Give every element that has none a name."""
    for i, element in enumerate(elements):
        if not element.name:
            element.name = f"{kind}{i}"


def _entries(
    model: MjModel,
    joints: Sequence[_Named],
    actuators: Sequence[str],
    feet: Sequence[str],
    at: Mapping[str, int],
) -> list[ObservedEntry]:
    entries = []
    for joint in joints:
        entries.append(ObservedEntry(joint.name, at[_OWN + joint.name]))
        entries.append(ObservedEntry(f"{joint.name}_velocity", at[f"{_OWN}{joint.name}_velocity"]))
    for joint in joints:
        own = model.joint(joint.name)
        if stiffness := float(np.ravel(own.stiffness)[0]):
            rest = float(model.qpos_spring[int(own.qposadr[0])])
            entries.append(
                ObservedEntry(f"{joint.name}_spring", at[_OWN + joint.name], -stiffness, rest)
            )
    entries += [ObservedEntry(f"{name}_force", at[f"{_OWN}{name}_force"]) for name in actuators]
    taken = {entry.name for entry in entries}
    for foot in feet:
        name = f"{foot}_force" if f"{foot}_force" not in taken else f"{foot}_contact_force"
        # The sensor measures the force of the foot on the ground.
        entries.append(ObservedEntry(name, at[f"{_OWN}contact/{foot}"] + 2, gain=-1.0, least=0.0))
    place, motion = at[f"{_OWN}root_place"], at[f"{_OWN}root_motion"]
    entries += [ObservedEntry("root_height", place + 2), ObservedEntry("root_forward", place)]
    entries += [ObservedEntry("root_velocity", motion), ObservedEntry("root_climb", motion + 2)]
    return [*entries, ObservedEntry("root_upright", at[f"{_OWN}root_axis"] + 2)]


def _own_entries(model: MjModel, names: Sequence[str]) -> list[ObservedEntry]:
    entries = []
    for name in names:
        own = model.sensor(name)
        first, size = int(own.adr[0]), int(own.dim[0])
        numbered = [name] if size == 1 else [f"{name}[{i}]" for i in range(size)]
        entries += [ObservedEntry(each, first + i) for i, each in enumerate(numbered)]
    return entries
