"""What files of earlier versions leave unsaid about a closed loop, settled in one place.

Up to version 3 a controller file held controller, frequency and body, and the rest of its training
in an untyped entry. Release and timing that it does not state are the usual ones of its body.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import cast

from tegotae._support.documents import Json, JsonObject
from tegotae.parts.bodies import Body, Interface, Walker
from tegotae.parts.controller import Controller
from tegotae.parts.fields import unwrapped
from tegotae.simulation.rollout import Timing
from tegotae.systems.descriptions import describe, entry, restore
from tegotae.systems.system import Release, System

WALKING = 200.0
"""Time in which a walker settles [√(l0 / g)]."""
WALKING_TICK = 0.008
"""A walker's control tick [√(l0 / g)]."""

_RENAMED = {"fitness": "objective"}
"""Entries of an earlier experiment by other names."""
_OF_SYSTEM = ("timing", "integrator")
_OF_RELEASE = {"release_m": "height_m", "phase_rad": "phase_rad", "posture": "initial_pose"}
_OWN = ("conditions", "episodes", "objective", "protocol")


def usual_system(
    controller: Controller, body: Body | Interface, omega: float | None, tick: float = WALKING_TICK
) -> System:
    """A controller on a body, released and timed as is usual for this body.

    A walker begins on its feet, and its times are in √(l0 / g); others are released as the paper's
    hopper is.

    Args:
        controller: what drives the body.
        body: the body, or what is known of it.
        omega: frequency ω [rad/s]; None without an oscillator.
        tick: control tick of a walker [√(l0 / g)].

    Raises:
        TegotaeError: for what does not go together.
    """
    own = body if isinstance(body, Interface) else unwrapped(body)
    if not isinstance(own, Walker):
        return System(controller=controller, body=body, omega=omega)
    unit_s = math.sqrt(own.rest_length_m / own.gravity_m_per_s2)
    press_m = getattr(controller.actuation, "press_m", 0.0)
    return System(
        controller=controller,
        body=body,
        omega=omega,
        release=Release(height_m=own.standing_height_m + press_m),
        timing=Timing(duration_s=WALKING * unit_s, tick_s=tick * unit_s, frame_s=0.08 * unit_s),
    )


def of_earlier_version(document: JsonObject) -> JsonObject:
    """A controller document of version 1, 2 or 3 as one of version 4.

    Raises:
        KeyError: for an entry that is missing.
        TypeError: for one of another type.
        TegotaeError: for what a part itself refuses.
    """
    if document["version"] == 1:
        document = _of_version_1(document)
    training = dict(entry(document, "training", JsonObject))
    earlier = training.get("experiment")
    on_engine = isinstance(earlier, Mapping) and ("fitness" in earlier or "protocol" in earlier)
    on_env = isinstance(earlier, Mapping) and "wiring" in earlier
    task = _task(cast(JsonObject, training.pop("experiment"))) if on_env else None
    own = entry(document, "body", JsonObject)
    if own["kind"] == "WiredLimbs":
        own = _external_limbs(own, {} if task is None else cast(JsonObject, task["wiring"]))
    controller, body = (
        entry(document, "controller", Controller),
        restore(own, Body | Interface, "body"),
    )
    omega = entry(document, "omega_rad_per_s", float | None)
    usual = usual_system(controller, body, None if omega is None else float(omega))
    system: JsonObject = describe(usual)
    experiment = None
    if on_engine:
        experiment = {"name": document["model"], **_nested(cast(JsonObject, earlier))}
        del training["experiment"]
        ours = cast(JsonObject, experiment.pop("system"))
        system |= {name: ours[name] for name in _OF_SYSTEM if name in ours}
        release = cast(JsonObject, system["release"])
        system["release"] = {**release, **cast(JsonObject, ours["release"])}
    return {
        "format": document["format"],
        "version": document["version"],
        "name": document["model"],
        "system": system,
        "weights": document["weights"],
        "experiment": experiment,
        "task": task,
        "training": training,
        "software": document["software"],
    }


def experiment_document(document: Mapping[str, Json]) -> JsonObject:
    """An experiment's document, of whatever version, as one of today's.

    Earlier ones had controller, body and release beside the rest, and no system.
    """
    if "system" in document:
        return dict(document)
    found = _nested(document)
    parts = {name: document[name] for name in ("controller", "body", "omega")}
    system = {**cast(JsonObject, found["system"]), **parts}
    return {"name": document["name"], **found, "system": system}


def _nested(document: Mapping[str, Json]) -> JsonObject:
    """The entries of an earlier experiment, those of its system apart."""
    named = {_RENAMED.get(name, name): value for name, value in document.items()}
    release = {new: named[old] for old, new in _OF_RELEASE.items() if old in named}
    system: JsonObject = {name: named[name] for name in _OF_SYSTEM if name in named}
    own = {name: named[name] for name in _OWN if name in named}
    return {"system": {**system, "release": release}, **own}


def _task(document: JsonObject) -> JsonObject:
    """The task on an environment, which lay in the untyped entry of the training."""
    place, objective = (
        entry(document, "place", JsonObject),
        dict(entry(document, "measure", JsonObject)),
    )
    if objective["kind"] == "Own":
        objective["kind"] = "UserObjective"
    others = ("wiring", "episodes", "seed", "sha256")
    return {
        "env": place["env"],
        "settings": place.get("settings", {}),
        "objective": objective,
        "duration_s": entry(document, "timing", JsonObject)["duration_s"],
        **{name: document[name] for name in others if name in document},
    }


def _external_limbs(body: JsonObject, wiring: JsonObject) -> JsonObject:
    """Limbs on an environment, whose scales and rest length were 1 if unknown.

    Args:
        body: an earlier `WiredLimbs`.
        wiring: what was known of them; empty if the file does not say.
    """
    known = cast(JsonObject, wiring.get("scales", {}))

    def of(name: str, value: Json) -> Json:
        return value if not wiring or name in known or value != 1.0 else None

    senses = cast(Sequence[str], body.get("senses", ["spring_force"]))
    scales = cast(Sequence[Json], body.get("scales", [1.0]))
    rest_m = body.get("rest_length_m")
    if wiring and wiring.get("rest_length_m") is None:
        rest_m = None
    interface = {
        "senses": senses,
        "scales": [of(*each) for each in zip(senses, scales, strict=True)],
        "limbs": body.get("count", 1),
        "commands": body.get("commands", ["force"]),
        "max_force_n": body.get("max_force_n"),
        "rest_length_m": rest_m,
        "feedback_scale": of("feedback", body.get("feedback_scale")),
    }
    return {"kind": "Interface", **interface}


def with_interface(document: JsonObject) -> JsonObject:
    """A controller document whose limbs elsewhere are an interface.

    The first files of version 4 had a body around it, `ExternalLimbs`.
    """
    system = entry(document, "system", JsonObject)
    body = entry(system, "body", JsonObject)
    if body.get("kind") != "ExternalLimbs":
        return dict(document)
    interface = {"kind": "Interface", **entry(body, "interface", JsonObject)}
    return {**document, "system": {**system, "body": interface}}


def _of_version_1(document: JsonObject) -> JsonObject:
    """A document of version 1 as one of version 2.

    There the terms of the feedback lay beside the actuation, and a controller without an oscillator
    had the frequency 0.
    """
    parts = dict(entry(document, "controller", JsonObject))
    if "action" in parts:
        own = [name for name in ("limit_rad_per_s",) if name in parts]
        names = ["action", "reaction", "gain", *own]
        parts["tegotae"] = {name: parts.pop(name) for name in names}
    omega = float(entry(document, "omega_rad_per_s", float))
    return {
        **document,
        "controller": parts,
        "omega_rad_per_s": omega if "oscillator" in parts else None,
    }
