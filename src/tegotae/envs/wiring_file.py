"""Wirings as files, TOML or JSON: written by people, read back and checked."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Mapping
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np

from tegotae._support import documents
from tegotae._support.documents import DamagedDocumentError, JsonObject
from tegotae._support.errors import TegotaeError, unknown
from tegotae._support.files import write_atomically
from tegotae.envs.wiring import Limb, Wiring
from tegotae.systems.controller_file import SavedController
from tegotae.systems.env_task import WIRING_FORMAT, WiringDocument
from tegotae.systems.resolve import resolve
from tegotae.systems.user_objects import is_reference

_MOST_BYTES = 2**20


_OWN = (
    "height",
    "work",
    "work_positive",
    "work_net",
    "rest_length_m",
    "max_force",
    "max_feedback_rad_per_s",
    "step_s",
    "omega",
)
_LISTS = ("observation_names", "action_names", "contact_bodies", "sector_rad")


def load_wiring(path: Path | str) -> Wiring:
    """The wiring in a TOML or JSON file, or one that comes with the package, by its name.

    Args:
        path: a file that ends in `.toml` or `.json`; or `hopper`, `leg` or `quadruped`.

    Raises:
        TegotaeError: if there is none, or it is no wiring: which entry, what is there and what
            should be.

    Example:
        >>> load_wiring("hopper").limbs[0].drives
        'leg'
    """
    if str(path) in packaged():
        text = (resources.files("tegotae.envs.mujoco") / "wirings" / f"{path}.toml").read_text(
            "utf-8"
        )
        return _parsed(text, ".toml", Path(f"{path}.toml"))
    path = Path(path)
    if path.suffix not in (".toml", ".json"):
        if path.name == str(path) and not path.exists():
            raise unknown("wiring", str(path), packaged())
        raise TegotaeError(f"{path} is no wiring; its name must end in .toml or .json")
    try:
        with path.open("rb") as stream:
            content = stream.read(_MOST_BYTES + 1)
        text = content.decode("utf-8")
    except OSError as error:
        raise TegotaeError(f"cannot read {path}: {error.strerror}") from None
    except UnicodeDecodeError:
        raise TegotaeError(f"{path} is no wiring: it is no text in UTF-8") from None
    if len(content) > _MOST_BYTES:
        raise TegotaeError(f"{path} is no wiring: it is larger than {_MOST_BYTES >> 20} MiB")
    return _parsed(text, path.suffix, path)


def save_wiring(
    wiring: Wiring, path: Path | str, *, reasons: Mapping[str, str] | None = None
) -> None:
    """Write a wiring, TOML or JSON by the name's end; all but its controller and weights.

    Args:
        wiring: the wiring.
        path: its file.
        reasons: comments behind entries of a TOML file, by names such as `omega`,
            `scales.velocity`, `limbs[0].push` and, of a sense, `limbs[0].spring_force`.

    Raises:
        TegotaeError: for a name of another end, or if it cannot be written.
    """
    path = Path(path)
    document = wiring_document(wiring)
    if path.suffix == ".json":
        write_atomically(path, json.dumps(document, indent=1) + "\n")
    elif path.suffix == ".toml":
        write_atomically(path, _toml(document, reasons or {}))
    else:
        raise TegotaeError(f"{path} is no wiring; its name must end in .toml or .json")


def wiring_document(wiring: Wiring) -> JsonObject:
    """A wiring as plain JSON values; all but its controller and weights.

    Example:
        >>> wiring_document(load_wiring("hopper"))["height"]
        'root_height'
    """
    limbs = []
    for limb in wiring.limbs:
        drives = limb.drives if isinstance(limb.drives, str) else list(limb.drives)
        optional = {"rest": limb.rest, "push": limb.push, "phase_rad": float(limb.phase_rad)}
        limbs.append({"senses": dict(limb.senses), "drives": drives, **_given(optional)})
    numbers = {name: getattr(wiring, name) for name in _OWN}
    lists = {name: getattr(wiring, name) for name in _LISTS}
    return {
        "format": WIRING_FORMAT,
        **_given(numbers),
        **{name: list(each) for name, each in lists.items() if each},
        "scales": {name: float(scale) for name, scale in wiring.scales.items()},
        "limbs": limbs,
    }


def wiring_of(document: object, folder: Path | None = None) -> Wiring:
    """The wiring of plain JSON values.

    Args:
        document: what `wiring_document` made, or a file holds.
        folder: where a controller file that it names is looked for.

    Raises:
        DamagedDocumentError: for values that are no wiring's.
        TegotaeError: for a controller file that cannot be read.
    """
    found = (
        document
        if isinstance(document, WiringDocument)
        else documents.fitted(documents.checked(document), WiringDocument)
    )
    if found.format != WIRING_FORMAT:
        raise DamagedDocumentError(f"its format is {found.format!r}; it must be {WIRING_FORMAT!r}")
    limbs = tuple(
        Limb(
            senses=each.senses,
            drives=each.drives if isinstance(each.drives, str) else tuple(each.drives),
            rest=each.rest,
            push=each.push,
            phase_rad=each.phase_rad,
        )
        for each in found.limbs
    )
    lists: dict[str, Any] = {name: getattr(found, name) for name in _LISTS}
    numbers = {name: getattr(found, name) for name in _OWN}
    lists = {name: None if each is None else tuple(each) for name, each in lists.items()}
    wiring = Wiring(
        limbs=limbs,
        scales=found.scales,
        weights=None if found.weights is None else np.asarray(found.weights),
        **numbers,
        **lists,
    )
    if found.controller is None:
        return wiring
    held = wiring.holding(_controller(found.controller, folder or Path()))
    return held if found.omega is None else dataclasses.replace(held, omega=found.omega)


def _controller(name: str, folder: Path) -> SavedController:
    """The controller of a name: a file beside the wiring, or what the name means everywhere."""
    beside = folder / name
    is_file = beside.exists() or (beside.suffix == ".json" and not is_reference(name))
    return resolve(beside if is_file else name).controller()


def packaged() -> list[str]:
    """Names of the wirings that come with the package, for its MuJoCo models."""
    files = (resources.files("tegotae.envs.mujoco") / "wirings").iterdir()
    return sorted(file.name[:-5] for file in files if file.name.endswith(".toml"))


def _parsed(text: str, suffix: str, path: Path) -> Wiring:
    try:
        parse = documents.parse_toml if suffix == ".toml" else documents.parse
        return wiring_of(parse(text), path.parent)
    except DamagedDocumentError as error:
        raise TegotaeError(f"{path} is no wiring: {error}") from None


def _given(values: Mapping[str, str | float | None]) -> JsonObject:
    """The entries that are not None, with JSON's numbers."""
    return {
        name: value if isinstance(value, str) else float(value)
        for name, value in values.items()
        if value is not None
    }


def _toml(document: dict[str, Any], reasons: Mapping[str, str]) -> str:
    """A document of texts, numbers, lists of texts, tables and one list of tables."""

    def line(name: str, value: Any, at: str = "") -> str:
        why = reasons.get(at + name)
        key = name if name.isidentifier() else json.dumps(name)
        return f"{key} = {json.dumps(value)}" + (f"  # {why}" if why else "")

    plain = {n: x for n, x in document.items() if not isinstance(x, dict) and n != "limbs"}
    lines = [line(name, value) for name, value in plain.items()]
    lines += ["", "[scales]", *(line(n, x, "scales.") for n, x in document["scales"].items())]
    for i, limb in enumerate(document["limbs"]):
        at = f"limbs[{i}]."
        own = [line(n, x, at) for n, x in limb.items() if n != "senses"]
        senses = [line(n, x, at) for n, x in limb["senses"].items()]
        lines += ["", "[[limbs]]", *own, "[limbs.senses]", *senses]
    return "\n".join(lines) + "\n"
