"""A robot as a file, TOML: its model, the settings of the model, and the wiring of its limbs.

`LAW@FILE.toml` is a law on the robot of a file. On a robot whose feet are commanded to places a law
without a body of its own is that of `quadruped-c`, so that `AR@go1.toml` is `AR@quadruped-c` there.
"""

from __future__ import annotations

import contextlib
import os
from pathlib import Path

import msgspec

from tegotae._support import documents
from tegotae._support.documents import DamagedDocumentError, JsonObject
from tegotae._support.errors import TegotaeError
from tegotae.systems.env_task import WiringDocument
from tegotae.systems.legged import SYSTEMS
from tegotae.systems.tuned import is_front_name
from tegotae.systems.user_objects import is_reference
from tegotae.systems.zoo import is_zoo_name

ROBOT_FORMAT = "tegotae robot"
_WALKER = "quadruped-c"
"""Walker whose laws fit on legs without more words."""
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
    path = Path(path)
    try:
        document = documents.fitted(documents.read(path), RobotDocument)
        if document.format != ROBOT_FORMAT:
            raise DamagedDocumentError(
                f"its format is {document.format!r}; it must be {ROBOT_FORMAT!r}"
            )
    except FileNotFoundError:
        raise TegotaeError(f"there is no file {path}") from None
    except DamagedDocumentError as error:
        raise TegotaeError(f"{path} is no robot: {error}") from None
    return document


def law_on_robot(name: str) -> tuple[str, str] | None:
    """Return the law and the robot's file of a name `LAW@FILE.toml`; None for another name.

    Raises:
        TegotaeError: for a robot's file without a law, or a damaged one.

    Example:
        >>> law_on_robot("AR@quadruped-c") is None
        True
    """
    law, _, file = name.rpartition("@")
    if not is_robot_file(file):
        return None
    on_legs = robot_document(file).on_legs
    if not law:
        such_as = "AR" if on_legs else "ART"
        raise TegotaeError(
            f"{file} is a robot, without a law; name one on it, such as {such_as}@{file}"
        )
    has_body = "@" in law or law in SYSTEMS or is_front_name(law) or os.path.exists(law)
    if on_legs and not has_body and (is_zoo_name(law) or not is_reference(law)):
        law = f"{law}@{_WALKER}"
    return law, file
