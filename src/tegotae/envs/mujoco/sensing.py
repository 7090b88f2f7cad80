"""Signals that a leg can sense on a MuJoCo model: its sensors, by the names of the observation."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tegotae._support.errors import TegotaeError, require, require_finite, unknown
from tegotae.envs._types import MjModel, MjSpec
from tegotae.envs.command import over_feet
from tegotae.envs.mujoco.legs import AXES, STANDS, LegKinematics, legs_of, resting
from tegotae.envs.mujoco.settings import ModelSettings, compiled_model
from tegotae.envs.scaling import started

_OWN = "tegotae/"
"""Prefix of the names of sensors that are added here."""
_SHORTEST_S, _LONGEST_S = 1e-5, 0.1
"""Time steps: below, a second of the model takes minutes; above, a leg cannot be controlled."""
MOST = 1e10
"""Numbers beyond are of a model that explodes, as MuJoCo has it, too (`mjMAXVAL`)."""


@dataclass(frozen=True)
class ObservedEntry:
    """One number that is observed: `gain * (sensor - offset)`, at least `lower`."""

    name: str
    column: int
    gain: float = 1.0
    offset: float = 0.0
    lower: float = -np.inf


@dataclass(frozen=True)
class Sensing:
    """A model with the places of its quantities in the sensor data.

    Raises:
        TegotaeError: for a file that is no model, or a foot that is no part of it.
    """

    model: MjModel
    """The `MjModel`."""
    entries: tuple[ObservedEntry, ...]
    """The observations, in order; but for what follows from several sensors."""
    actuators: tuple[str, ...]
    """The driven entries. Adhesion is none of them: it is on all the time (`held`)."""
    driven: np.ndarray
    """Indices of these actuators among the model's controls."""
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
    legs: LegKinematics | None
    """Those of the feet that are commanded to places."""
    angles: np.ndarray
    """Columns of the legs' joints, [legs, joints]."""
    rates: np.ndarray
    """Columns of their velocities, likewise."""
    turning: slice
    """Columns of the gyroscope."""
    has_odometry: bool = False
    """True if the velocity of the trunk over each foot is observed, of a robot with commands."""

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Names of the observed quantities."""
        borne = [] if self.legs is None else [f"{foot}_estimated_force" for foot in self.feet]
        over = [f"{foot}_odometry_{axis}" for foot in self.feet for axis in AXES[:2]]
        over = over if self.has_odometry else []
        return (*(entry.name for entry in self.entries), *borne, *over)

    @property
    def lower(self) -> np.ndarray:
        """Least values of the observed quantities, [entries]."""
        lower = [entry.lower for entry in self.entries]
        lower += [0.0] * (0 if self.legs is None else len(self.feet))
        return np.array([*lower, *[-np.inf] * (len(self.names) - len(lower))])

    @property
    def actions(self) -> tuple[str, ...]:
        """Names of the actions: places of feet, and actuators that move none of them."""
        if self.legs is None:
            return self.actuators
        return (*self.legs.names, *(self.actuators[i] for i in np.flatnonzero(self._alone)))

    @property
    def bounds(self) -> np.ndarray:
        """Least and largest action, [2, actions]: the actuators' ranges, unbounded where a
        model gives none; places reach as far as the longest leg.
        """
        model = self.model
        limited = model.actuator_ctrllimited[self.driven].astype(bool)
        free = np.array([[-np.inf], [np.inf]])
        ranges = np.where(limited, model.actuator_ctrlrange[self.driven].T, free)
        if self.legs is None:
            return ranges
        far = np.full(len(self.legs.names), self.legs.length_m)
        return np.hstack([[-far, far], ranges[:, self._alone]])

    @property
    def still(self) -> np.ndarray:
        """Action that keeps the model in its start, [actions]: feet at their places, actuators at
        the commands of the keyframe or, where it has none, servos at their joints' positions."""
        commands = resting(self.model)[self.driven]
        if self.legs is None:
            return commands
        return np.append(np.zeros(len(self.legs.names)), commands[self._alone])

    def controls(self, action: np.ndarray) -> np.ndarray:
        """Return the commands of the actuators, [lanes, actuators], for actions [lanes,
        actions]."""
        if self.legs is None:
            return action
        legs, n = self.legs, len(self.legs.names)
        places = np.reshape(action[:, :n], (-1, len(self.feet), len(AXES)))
        commands = np.zeros((len(action), len(self.actuators)))
        commands[:, self._alone] = action[:, n:]
        commands[:, self._servos] = (legs.gears * legs.joints_at(places))[:, legs.servos >= 0]
        return commands

    @cached_property
    def _servos(self) -> np.ndarray:
        """Indices of actuators that are servos of the legs, in the order of legs and joints."""
        assert self.legs is not None
        return np.searchsorted(self.driven, self.legs.servos[self.legs.servos >= 0])

    @cached_property
    def _alone(self) -> np.ndarray:
        """Indices of actuators that move no foot."""
        return ~np.isin(np.arange(len(self.actuators)), self._servos)

    @property
    def force_limits(self) -> dict[str, tuple[float, float]]:
        """Least and largest force of actuators by the entry that observes it [N or N m].

        They are a model's own limits of force, or those of a motor whose command is limited;
        actuators without any are left out.
        """
        model, limits = self.model, {}
        for name, i in zip(self.actuators, self.driven, strict=True):
            if model.actuator_forcelimited[i]:
                ends = model.actuator_forcerange[i]
            elif model.actuator_ctrllimited[i] and not model.actuator_biastype[i]:
                ends = np.sort(model.actuator_gainprm[i, 0] * model.actuator_ctrlrange[i])
            else:
                continue
            limits[f"{name}_force"] = (float(ends[0]), float(ends[1]))
        return limits

    @property
    def contacts(self) -> tuple[str, ...]:
        """Names of the feet's contact forces; an actuator's force may have the plain one."""
        names = [(f"{foot}_contact_force", f"{foot}_force") for foot in self.feet]
        return tuple(longer if longer in self.names else plain for longer, plain in names)

    def observed(self, data: np.ndarray) -> np.ndarray:
        """Return the observations from sensor data [..., columns], shape [..., entries]."""
        columns, gain, offset, lower = self._conversion
        values = np.maximum(gain * (data[..., columns] - offset), lower)
        if self.legs is None:
            return values
        torques = np.zeros((*data.shape[:-1], *self.angles.shape))
        torques[..., self.legs.servos >= 0] = data[..., self.forces[self._servos]]
        force = self.legs.forces_n(data[..., self.angles], self.legs.gears * torques)
        load = np.maximum(force[..., 2], 0.0)
        if not self.has_odometry:
            return np.concatenate([values, load], axis=-1)
        over = self._odometry(data).reshape(*load.shape[:-1], -1)
        return np.concatenate([values, load, over], axis=-1)

    def _odometry(self, data: np.ndarray) -> np.ndarray:
        assert self.legs is not None
        rates = np.where(self.legs.joints >= 0, data[..., self.rates], 0.0)
        angles, turning = data[..., self.angles], data[..., self.turning]
        return leg_odometry(self.legs, angles, rates, turning)

    @cached_property
    def _conversion(self) -> tuple[np.ndarray, ...]:
        """Columns, gains, offsets and least values of the entries, [entries] each."""
        names = ("column", "gain", "offset", "lower")
        return tuple(np.array([getattr(entry, name) for entry in self.entries]) for name in names)

    def power(self, data: np.ndarray) -> np.ndarray:
        """Return the actuators' powers of sensor data [..., columns], [W], shape [...,
        actuators].
        """
        return data[..., self.forces] * data[..., self.speeds]


def leg_odometry(
    legs: LegKinematics, joints: np.ndarray, rates: np.ndarray, turning: np.ndarray
) -> np.ndarray:
    """Return the velocity of a trunk over each of its feet, by the legs that stand.

    That of the trunk is a mean of what the feet tell (`LegKinematics.trunk_velocities_m_per_s`).
    A foot counts the less, the higher it is over the lowest one and the faster the trunk would rise
    over it, with the weight

        exp(-(h / 0.06 l)² - (v_z / 0.18 √(g l))²).

    Torques do not tell: at a run those of a swinging leg are as large as of a standing one.

    Args:
        legs: their geometry.
        joints: [rad or m], [lanes, legs, joints].
        rates: of the joints, likewise.
        turning: the gyroscope's [rad/s], [lanes, 3].

    Returns:
        Forward and to the left in the axes of the trunk [m/s], [lanes, legs, 2].
    """
    estimates = legs.trunk_velocities_m_per_s(joints, rates, turning)
    height = legs.places_of(joints)[..., 2] + legs.feet_m[:, 2]
    above = (height - height.min(axis=-1, keepdims=True)) / (STANDS * legs.length_m)
    share = np.exp(-(above**2) - (estimates[..., 2] / legs.rising_m_per_s) ** 2)
    share /= np.maximum(share.sum(axis=-1, keepdims=True), 1e-9)
    trunk = (share[..., None] * estimates[..., :2]).sum(axis=-2)
    return over_feet(np.concatenate([trunk, turning[..., 2:]], axis=-1), legs.feet_m[:, :2])


def sensing(settings: ModelSettings) -> Sensing:
    """Add sensors for all that a leg can feel to a model.

    Observed are, by these names:

    - `JOINT` and `JOINT_velocity` of every hinge and slide joint [rad or m, and per s];
    - `JOINT_spring`, of those with a spring, the spring's force or torque [N or N m];
    - `ACTUATOR_force` of every actuator but adhesion [N or N m];
    - `FOOT_force`, the upward contact force on every foot [N], never negative;
    - of the model's first body `root_height`, `root_forward` [m], `root_velocity`, `root_climb`
      [m/s] and `root_upright` (the cosine of its tilt); and as an IMU has them, in its own axes,
      `root_roll` and `root_pitch` (the sines of how far its left side is up and its nose down),
      `root_roll_rate`, `root_pitch_rate`, `root_yaw_rate` [rad/s], and `root_speed`, ahead [m/s];
      and `root_yaw`, the sine of its heading to the left;
    - `FOOT_estimated_force` [N], with `legs`: the upward force on every foot as the servos' torques
      tell it, -J⁻ᵀ τ without the mass of the leg, in the axes of the trunk, never negative;
    - the model's own sensors by their names, `NAME` or `NAME[i]`.

    Sensors are those of the last time step's beginning, as MuJoCo has it.

    Args:
        settings: the model, its feet, and what is changed of it.

    Raises:
        TegotaeError: for a model that cannot be read, or that lacks what is named of it.
        MissingExtraError: without MuJoCo.

    Example:
        >>> sensing(ModelSettings(model="hopper", feet=["foot"])).names[:3]  # doctest: +SKIP
        ('height', 'height_velocity', 'leg')
    """
    mujoco = require("mujoco", "mujoco")
    spec, feet = settings.spec(), tuple(settings.feet)
    bodies = [body.name for body in spec.bodies if body.name != "world"]
    if not bodies:
        raise TegotaeError("the model has no body; give one that can move")
    touching = {foot: _touching(spec, foot) for foot in feet}
    root = bodies[0]
    if not root:
        raise TegotaeError("the first body of the MuJoCo model has no name; give it one")
    for kind, parts in (("joint", spec.joints), ("actuator", spec.actuators)):
        for i, part in enumerate(parts):
            if not part.name:
                part.name = f"{kind}{i}"
    sensors = [sensor.name for sensor in spec.sensors]
    scalar = (mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE)
    joints = [joint.name for joint in spec.joints if joint.type in scalar]
    kinds, objects = mujoco.mjtSensor, mujoco.mjtObj
    for name in joints:
        _add(spec, name, kinds.mjSENS_JOINTPOS, objects.mjOBJ_JOINT, name)
        _add(spec, f"{name}_velocity", kinds.mjSENS_JOINTVEL, objects.mjOBJ_JOINT, name)
    for name in [actuator.name for actuator in spec.actuators]:
        _add(spec, f"{name}_force", kinds.mjSENS_ACTUATORFRC, objects.mjOBJ_ACTUATOR, name)
        _add(spec, f"speed/{name}", kinds.mjSENS_ACTUATORVEL, objects.mjOBJ_ACTUATOR, name)
    # The net force on a foot, in the world's axes.
    net = [1 << int(mujoco.mjtConDataField.mjCONDATA_FORCE), 3, 1]
    for foot in feet:
        _add(spec, f"contact/{foot}", kinds.mjSENS_CONTACT, touching[foot], foot, intprm=net)
    for name, kind in (
        ("root_place", kinds.mjSENS_FRAMEPOS),
        ("root_motion", kinds.mjSENS_FRAMELINVEL),
        ("root_axis", kinds.mjSENS_FRAMEZAXIS),
        ("root_ahead", kinds.mjSENS_FRAMEXAXIS),
        ("root_left", kinds.mjSENS_FRAMEYAXIS),
    ):
        _add(spec, name, kind, objects.mjOBJ_XBODY, root)
    spec.body(root).add_site(name=_OWN + "imu")
    for name, kind in (("root_turn", kinds.mjSENS_GYRO), ("root_run", kinds.mjSENS_VELOCIMETER)):
        _add(spec, name, kind, objects.mjOBJ_SITE, _OWN + "imu")
    model = _compiled(spec, settings)
    sticks = model.actuator_trntype == int(mujoco.mjtTrn.mjTRN_BODY)
    actuators = [model.actuator(int(i)).name for i in np.flatnonzero(~sticks)]
    legs = legs_of(model, feet) if settings.legs else None
    entries = _entries(*(model, joints, actuators, feet, sensors), commanded=bool(settings.command))
    names = [entry.name for entry in entries]
    if twice := sorted({name for name in names if names.count(name) > 1}):
        raise TegotaeError(f"several of the model's entries are called {twice[0]!r}; rename one")
    return Sensing(
        model=model,
        entries=tuple(entries),
        actuators=tuple(actuators),
        driven=np.array([model.actuator(name).id for name in actuators], int),
        held=np.where(sticks, model.actuator_ctrlrange[:, 1], 0.0),
        forces=np.array([_column(model, f"{name}_force") for name in actuators], int),
        speeds=np.array([_column(model, f"speed/{name}") for name in actuators], int),
        root=root,
        feet=feet,
        legs=legs,
        angles=_angles(model, legs),
        rates=_angles(model, legs, "_velocity"),
        turning=slice(turn := _column(model, "root_turn"), turn + 3),
        has_odometry=bool(settings.command),
    )


def _add(
    spec: MjSpec, name: str, kind: object, target: object, owner: str, **options: list[int]
) -> None:
    """Add a sensor to a part of a model."""
    spec.add_sensor(name=_OWN + name, type=kind, objtype=target, objname=owner, **options)


def _angles(model: MjModel, legs: LegKinematics | None, quantity: str = "") -> np.ndarray:
    """Return the columns of the legs' joints; the first joint's stands in for missing ones."""
    joints = np.zeros((0, 0), int) if legs is None else legs.joints
    names = [model.joint(max(int(joint), 0)).name + quantity for joint in joints.ravel()]
    rows = [
        _column(model, name) if joint >= 0 else 0
        for name, joint in zip(names, joints.ravel(), strict=True)
    ]
    return np.reshape(np.array(rows, int), joints.shape)


def _column(model: MjModel, sensor: str) -> int:
    """Return the first column of the data of a sensor that was added here."""
    return int(model.sensor(_OWN + sensor).adr[0])


def _compiled(spec: MjSpec, settings: ModelSettings) -> MjModel:
    """Compile, check and scale the model."""
    mujoco = require("mujoco", "mujoco")
    model = compiled_model(spec)
    scale_model(model, settings.mass_factor, settings.friction_factor)
    elliptic = model.opt.cone == int(mujoco.mjtCone.mjCONE_ELLIPTIC)
    if elliptic and model.opt.jacobian == int(mujoco.mjtJacobian.mjJAC_AUTO):
        # The same steps but for rounding; a walking robot's take a quarter less time.
        model.opt.jacobian = int(mujoco.mjtJacobian.mjJAC_SPARSE)
    step_s = "the time step of the MuJoCo model [s]"
    require_finite(step_s, model.opt.timestep, least=_SHORTEST_S, most=_LONGEST_S)
    data = started(model)
    for name in ("qpos", "qvel", "xpos", "qacc"):
        values = getattr(data, name)
        if not is_sound(values).all():
            worst = values[~is_sound(values)].flat[0]
            where = "its first keyframe" if model.nkey else "its positions, masses and gravity"
            raise TegotaeError(
                f"the MuJoCo model starts with {name} at {worst:g}; it must be finite and below "
                f"{MOST:g}: check {where}"
            )
    # A state that explodes stays so, and is seen: MuJoCo would put the model back to its start.
    model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_AUTORESET)
    return model


def is_sound(values: np.ndarray) -> np.ndarray:
    """Return True where values of a model are finite and of a size that only an exploding model
    exceeds.

    Example:
        >>> is_sound(np.array([1.0, np.nan, 1e30])).tolist()
        [True, False, False]
    """
    return np.abs(values) < MOST


def scale_model(model: MjModel, mass: float, friction: float) -> None:
    """Multiply masses, inertias and sliding friction of a compiled model."""
    model.geom_friction[:, 0] *= friction
    if mass != 1.0:
        mujoco = require("mujoco", "mujoco")
        model.body_mass *= mass
        model.body_inertia *= mass
        mujoco.mj_setConst(model, mujoco.MjData(model))  # what follows from masses


def _touching(spec: MjSpec, foot: str) -> object:
    """Return MuJoCo's object type of a foot: a body or a geom.

    Raises:
        TegotaeError: for a name that is neither's.
    """
    objects = require("mujoco", "mujoco").mjtObj
    bodies = [body.name for body in spec.bodies if body.name != "world"]
    geoms = [geom.name for geom in spec.geoms if geom.name and geom.parent.name != "world"]
    if foot in bodies:
        return objects.mjOBJ_XBODY  # with what hangs on it, such as the sole on a shank
    if foot in geoms:
        return objects.mjOBJ_GEOM
    if site := spec.site(foot):
        raise TegotaeError(
            f"{foot} is a site, which touches nothing; name its body, {site.parent.name}"
        )
    raise unknown("body or geom of this model", foot, [*bodies, *geoms])


def _entries(
    model: MjModel,
    joints: list[str],
    actuators: list[str],
    feet: tuple[str, ...],
    sensors: list[str],
    *,
    commanded: bool,
) -> list[ObservedEntry]:
    """Return the observed entries; `sensors` are the model's own."""
    entries = []
    for name in joints:
        entries += [ObservedEntry(x, _column(model, x)) for x in (name, f"{name}_velocity")]
    for name in joints:
        joint = model.joint(name)
        if stiffness := float(np.ravel(joint.stiffness)[0]):
            rest = float(model.qpos_spring[int(joint.qposadr[0])])
            place = _column(model, name)
            entries.append(ObservedEntry(f"{name}_spring", place, -stiffness, rest))
    forces = [f"{name}_force" for name in actuators]
    entries += [ObservedEntry(name, _column(model, name)) for name in forces]
    taken = {entry.name for entry in entries}
    for foot in feet:
        name = f"{foot}_force" if f"{foot}_force" not in taken else f"{foot}_contact_force"
        # The sensor measures the force of the foot on the ground.
        upward = _column(model, f"contact/{foot}") + 2
        entries.append(ObservedEntry(name, upward, gain=-1.0, lower=0.0))
    entries += [
        ObservedEntry(f"root_{name}", _column(model, f"root_{sensor}") + axis, gain)
        for name, sensor, axis, gain in (
            ("height", "place", 2, 1.0),
            ("forward", "place", 0, 1.0),
            ("velocity", "motion", 0, 1.0),
            ("climb", "motion", 2, 1.0),
            ("upright", "axis", 2, 1.0),
            ("roll", "left", 2, 1.0),
            ("pitch", "ahead", 2, -1.0),
            ("yaw", "ahead", 1, 1.0),
            ("roll_rate", "turn", 0, 1.0),
            ("pitch_rate", "turn", 1, 1.0),
            ("yaw_rate", "turn", 2, 1.0),
            ("speed", "run", 0, 1.0),
            *([("left", "place", 1, 1.0)] if commanded else []),
        )
    ]
    for name in sensors:
        sensor = model.sensor(name)
        first, size = int(sensor.adr[0]), int(sensor.dim[0])
        numbered = [name] if size == 1 else [f"{name}[{i}]" for i in range(size)]
        entries += [ObservedEntry(x, first + i) for i, x in enumerate(numbered)]
    return entries
