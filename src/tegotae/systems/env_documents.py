"""Documents of other simulators: a wiring of limbs, a robot's file, a task in a controller file.

A robot's file, TOML, has its model, the settings of the model, and the wiring of its limbs.
"""

from __future__ import annotations

import contextlib
from pathlib import Path

import msgspec

from tegotae._support import documents
from tegotae._support.documents import DamagedDocumentError, Json, JsonObject
from tegotae._support.errors import TegotaeError

WIRING_FORMAT = "tegotae wiring"
MODELS = ("hopper", "leg", "quadruped")
"""MuJoCo models that come with this package."""


def is_mujoco_model(env: str) -> bool:
    """Return whether an environment is a MuJoCo model, whose physics needs no environment around
    it.

    Example:
        >>> is_mujoco_model("my_leg.xml"), is_mujoco_model("leg"), is_mujoco_model("Hopper-v5")
        (True, True, False)
    """
    return env.endswith((".xml", ".mjcf")) or env in MODELS


def extras_of(env: str) -> dict[str, str]:
    """Return the modules that an environment needs, with the extras that install them.

    Raises:
        TegotaeError: for URDF, which is to be converted.

    Example:
        >>> extras_of("Hopper-v5"), extras_of("my_leg.toml")
        ({'gymnasium': 'gym'}, {'gymnasium': 'mujoco', 'mujoco': 'mujoco'})
    """
    if env.lower().endswith(".urdf"):
        raise TegotaeError(
            f"{env} is URDF; convert it to MJCF with a free joint and actuators by MuJoCo "
            "(mujoco.MjSpec.from_file, to_xml; mj_saveLastXML), as in "
            "docs/guides/walking-robot.md#a-robot-in-urdf, and name the FILE.xml"
        )
    if is_mujoco_model(env) or env.endswith(".toml"):  # a robot's file
        return {"gymnasium": "mujoco", "mujoco": "mujoco"}
    return {"gymnasium": "gym"}


def stem_of(env: str) -> str:
    """Return the name of an environment as a part of a file's name.

    Example:
        >>> stem_of("my_leg.xml"), stem_of("robots:leg.xml"), stem_of("my_robot.py:make")
        ('my_leg', 'leg', 'my_robot')
    """
    module, _, last = env.rpartition(":")
    return Path(last if is_mujoco_model(env) else module or env).stem


class LimbDocument(msgspec.Struct, forbid_unknown_fields=True):
    """A limb in a file; see `tegotae.envs.Limb`."""

    senses: dict[str, str]
    drives: str | list[str]
    rest: float | None = None
    push: float | None = None
    phase_rad: float = 0.0


class UnitsDocument(msgspec.Struct, forbid_unknown_fields=True):
    """Units in a file; see `tegotae.parts.units.Units`."""

    length_m: float = 1.0
    time_s: float = 1.0
    force_n: float = 1.0


class WiringDocument(msgspec.Struct, forbid_unknown_fields=True):
    """A wiring in a file; see `tegotae.envs.Wiring`."""

    limbs: list[LimbDocument]
    format: str = WIRING_FORMAT
    scales: dict[str, float] = {}
    units: UnitsDocument | msgspec.UnsetType = msgspec.UNSET
    max_force: float = 4.0
    max_feedback_rad_per_s: float = 10.0
    sector_rad: list[float] | None = None
    step_s: float | None = None
    observation_names: list[str] | None = None
    action_names: list[str] | None = None
    contact_bodies: list[str] = []
    height: str | None = None
    work: str | None = None
    work_positive: str | None = None
    work_net: str | None = None
    rest_length_m: float | None = None
    controller: str | None = None
    """A controller file, relative to this one, or any name of one (`tegotae.systems.resolve`); a
    reference to code only if the user named that code, too."""
    weights: list[float] | None = None
    """Weights of the vanilla controller: σ alone."""
    omega: float | None = None


class EnvTask(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Task on an environment that a system's weights were trained for."""

    env: str
    """The environment's name (`tegotae.envs.env_spec.EnvSpec`)."""
    settings: JsonObject = {}
    """Settings of the environment."""
    wiring: WiringDocument
    """Senses and actuators of the limbs there."""
    objective: JsonObject
    """The measure of an episode: its `kind`, and its settings."""
    duration_s: float
    """Length of an episode [s]."""
    episodes: int = 1
    """Episodes per candidate."""
    omegas: list[float] = []
    """Frequencies that they had in turn [rad/s], if not the wiring's alone."""
    seed: int = 0
    """Seed of the first episode's reset."""
    evaluation_episodes: int = 0
    """Episodes of the evaluation set, where generations draw their own starts."""
    sha256: dict[str, str] = {}
    """Hashes of the files that it names, by role."""


ROBOT_FORMAT = "tegotae robot"
_MARK = f'"{ROBOT_FORMAT}"'.encode()


class ModelDocument(msgspec.Struct, forbid_unknown_fields=True):
    """A robot's model in its file."""

    env: str
    """Environment (`tegotae.envs.env_spec.EnvSpec`), mostly a MuJoCo model, FILE.xml beside this
    file."""
    sha256: str = ""
    """Hash of the model's file, for which the wiring was made; any file fits if it is empty."""
    settings: JsonObject = {}
    """Settings of the environment."""


class RobotDocument(WiringDocument, forbid_unknown_fields=True, kw_only=True):
    """A robot in a file: a wiring with its model."""

    model: ModelDocument

    @property
    def on_legs(self) -> bool:
        """True if limbs are legs, whose feet are commanded to places."""
        return any(not isinstance(limb.drives, str) for limb in self.limbs)


def is_robot_file(name: str | Path) -> bool:
    """Return whether a name is that of a robot's file, by the file's content.

    Example:
        >>> is_robot_file("quadruped-c"), is_robot_file("no_such_file.toml")
        (False, False)
    """
    with contextlib.suppress(OSError, ValueError):  # which a reader of the file puts into words
        return str(name).endswith(".toml") and _MARK in Path(name).read_bytes()
    return False


def robot_document(path: Path | str) -> RobotDocument:
    """Read a robot's file.

    Raises:
        TegotaeError: if it is no robot's, or damaged: which entry, and what should be there.
    """
    return documents.read_as(Path(path), "robot", _robot)


def _robot(document: Json) -> RobotDocument:
    robot = documents.fitted(document, RobotDocument)
    if robot.format != ROBOT_FORMAT:
        raise DamagedDocumentError(f"its format is {robot.format!r}; it must be {ROBOT_FORMAT!r}")
    return robot
