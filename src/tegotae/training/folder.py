"""What every training leaves in its folder: what it is for, and its controllers."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Mapping
from importlib.metadata import version
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from tegotae._support import documents
from tegotae._support.documents import DamagedDocumentError, Json, differing
from tegotae._support.engines import require_engine
from tegotae._support.errors import TegotaeError
from tegotae._support.files import write_atomically
from tegotae.parts.controller import Controller
from tegotae.systems import controller_file
from tegotae.systems.controller_file import SavedController
from tegotae.systems.experiment import Experiment
from tegotae.training.learner import Trainable


class RunDocument(msgspec.Struct):
    """What `run.json` holds."""

    configuration: dict[str, Any]
    software: dict[str, str] = {}


class ExperimentEntry(msgspec.Struct):
    """What `run.json` says at least of the experiment."""

    name: str


class _BegunConfiguration(msgspec.Struct):
    experiment: ExperimentEntry


class _BegunSoftware(msgspec.Struct):
    engine: str


class _Begun(msgspec.Struct):
    """What of `run.json` decides whether a training goes on."""

    configuration: _BegunConfiguration
    software: _BegunSoftware


def versions_of(*packages: str) -> dict[str, str]:
    """Versions of the programs that decide the numbers: these packages and what all need."""
    return {name: version(name) for name in ("tegotae", "jax", "jaxlib", *packages, "numpy")}


def claim(out: Path, configuration: Mapping[str, Json], versions: Mapping[str, str]) -> None:
    """Write into `run.json` what the folder is for, or see that what is in it is of this training.

    Raises:
        TegotaeError: if the folder holds another training, one that another engine or other
            versions of the programs have begun, or cannot be written.
    """
    path = out / "run.json"
    wanted = json.loads(json.dumps(configuration))
    if any(out.glob("checkpoint*")) or any(out.glob("*-seed*.json")):
        document = _document(path)
        found = document.configuration
        if names := differing(found, wanted):
            raise TegotaeError(
                f"{out} holds a training of {found['experiment']['name']} that differs "
                f"in {', '.join(names)}; choose another folder with --out, or start again with "
                "--anew"
            )
        remedy = "choose another folder with --out, or start again with --anew"
        require_engine(
            document.software["engine"], f"{out} holds a training", remedy, versions["engine"]
        )
        _require_versions(out, document.software, versions, remedy)
    document = {"configuration": wanted, "software": dict(versions)}
    write_atomically(path, json.dumps(document, indent=1) + "\n")


def _require_versions(
    out: Path, found: Mapping[str, str], ours: Mapping[str, str], remedy: str
) -> None:
    """Raise `TegotaeError` if other versions made what is there: the rest would have other bits."""
    others = [name for name in ours if found.get(name, ours[name]) != ours[name]]
    if others:
        theirs = ", ".join(f"{name} {found[name]}" for name in others)
        here = ", ".join(f"{name} {ours[name]}" for name in others)
        raise TegotaeError(
            f"{out} holds a training made with {theirs}, and here is {here}, whose numbers may "
            f"differ; install those versions, {remedy}"
        )


def _document(path: Path) -> RunDocument:
    try:
        document = documents.read(path)
        documents.fitted(document, _Begun)
        return documents.fitted(document, RunDocument)
    except FileNotFoundError:
        raise TegotaeError(
            f"{path.parent} holds a training but no {path.name}; choose another folder with --out"
        ) from None
    except DamagedDocumentError as error:
        raise TegotaeError(
            f"{path} is damaged: {error}; choose another folder with --out"
        ) from None


def save_controller(
    out: Path,
    *,
    experiment: Trainable,
    controller: Controller,
    weights: np.ndarray,
    configuration: Mapping[str, Json],
    outcome: Mapping[str, Json],
    versions: Mapping[str, str],
) -> Path:
    """Write `NAME-seedN.json`, the controller that the training of one seed ended in.

    Args:
        experiment: what was trained.
        controller: its controller, as it is with these weights.
        weights: shape [n_weights].
        configuration: how it was trained.
        outcome: the result of that; its `seed` is part of the file's name.
    """
    path = out / f"{experiment.name}-seed{outcome['seed']}.json"
    training = {name: each for name, each in configuration.items() if name != "experiment"}
    saved = SavedController(
        dataclasses.replace(experiment.system, controller=controller),
        weights,
        name=experiment.name,
        experiment=experiment if isinstance(experiment, Experiment) else None,
        task=experiment.task,
        training={**training, **outcome},
        software=dict(versions),
    )
    controller_file.save(saved, path)
    return path
