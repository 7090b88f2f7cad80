"""A first wiring of a MuJoCo model, every entry with its reason."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import pandas as pd

from tegotae._support.errors import TegotaeError, require_all
from tegotae.api.parameters import check_types
from tegotae.api.results import MatplotlibFigure, TomlFile, short
from tegotae.systems.env_documents import extras_of, is_mujoco_model

if TYPE_CHECKING:  # which needs Gymnasium
    from tegotae_robots.models.suggesting import Suggestion
    from tegotae_robots.models.suggesting_settings import SuggestedSettings


_PACE = 0.4
"""Speed of the first walk that is proposed [√(g l0)]."""


def _short(value: object) -> str:
    return f"{len(value)} joints" if isinstance(value, Mapping) else short(value)


def _entries(suggestion: Suggestion, settings: SuggestedSettings) -> pd.DataFrame:
    """Return one row per entry that has a reason."""
    wiring = suggestion.wiring
    rows = [(name, _short(x), settings.reasons[name]) for name, x in settings.values.items()]
    for name, reason in suggestion.reasons.items():
        owner, _, entry = name.rpartition(".")
        if owner.startswith("limbs["):
            limb = wiring.limbs[int(owner[6:-1])]
            value = limb.senses[entry] if entry in limb.senses else getattr(limb, entry)
            name = f"{', '.join(limb.entries)}: {entry}"
        elif owner == "scales":
            value = wiring.scales[entry]
        else:
            value = getattr(getattr(wiring, owner) if owner else wiring, entry)
        rows.append((name, short(value), reason))
    return pd.DataFrame(rows, columns=["entry", "value", "reason"])


@check_types
def suggest_wiring(
    env: str,
    *,
    feet: Sequence[str] = (),
    settings: Sequence[str] = (),
) -> TomlFile:
    """Suggest a wiring for a MuJoCo model of your own: feet, limbs, pushes, scales, rest length.

    A robot that is free, with three or more driven joints a leg, gets the settings by which it
    can stand and take commands, too: a floor, servos, a start. Settings that are given stay, and
    with `legs=true` or `legs=false` all of them are yours.

    The file is a robot's: it has the model with its settings, too, and `LAW@FILE.toml` is a law on
    it for every command. Every entry has its reason beside it, in the terminal and as a comment in
    the file. The wiring is a first guess: correct every entry that you know better.

    Args:
        env: MuJoCo model, FILE.xml.
        feet: bodies or geoms that touch the ground; by default the lowest ones at the end of a
            chain.
        settings: further settings of the environment: NAME=VALUE, values as in JSON, such as
            ground=true.

    Raises:
        MissingExtraError: without MuJoCo.
        TegotaeError: for another environment than a MuJoCo model, or one without feet.

    Example:
        >>> suggest_wiring("my_leg.xml").save("my_leg.toml")  # doctest: +SKIP
    """
    require_all(extras_of(env))
    from tegotae.envs.robot_file import environment_named, save_robot
    from tegotae.envs.wiring import wiring_document
    from tegotae_robots.models.suggesting import rounded, suggest_wiring as suggested
    from tegotae_robots.models.suggesting_legs import suggest_legs
    from tegotae_robots.models.suggesting_settings import suggest_settings

    if not is_mujoco_model(env):
        raise TegotaeError(
            f"{env} is no MuJoCo model (FILE.xml); for another environment write the wiring by "
            "hand, and check it with tegotae.envs.check_wiring"
        )
    spec = environment_named(env, settings, feet=feet)
    found = suggest_settings(spec.model_settings, [name for name, _ in spec.settings])
    spec = replace(spec, settings=(*spec.settings, *found.values.items()))
    model = spec.model_settings
    suggestion = suggest_legs(model) if model.legs else suggested(model)
    if model.legs:
        commands = ["simulate zoo:AR-rF+range@FILE.toml", "train AR@FILE.toml"]
        if model.command:
            assert suggestion.wiring.units is not None
            units = suggestion.wiring.units
            speed = rounded(_PACE * units.length_m / units.time_s, 1)
            commands = [
                f"simulate zoo:raibert@FILE.toml --command {speed:g} 0 0",
                "train raibert@FILE.toml",
            ]
    else:
        # What hops ahead, or walks, is paid for distance; CoT⁻¹ of hops alone often stays 0.
        walks = len(suggestion.wiring.limbs) > 1
        fitness = "hopping" if suggestion.on_rail else "return" if walks else ""
        paid = f" --fitness {fitness}" if fitness else ""
        commands = [f"wiring baseline FILE.toml{paid}", f"train ART@FILE.toml{paid}"]
    of_settings = {f"model.settings.{name}": reason for name, reason in found.reasons.items()}
    reasons = {**suggestion.reasons, **of_settings}
    table = _entries(suggestion, found)

    def draw() -> dict[str, MatplotlibFigure]:
        from tegotae_robots.models.workspace import workspace_figure

        return {} if suggestion.legs is None else {"workspace": workspace_figure(suggestion)}

    return TomlFile(
        raw=suggestion,
        write=lambda path: save_robot(spec, suggestion.wiring, path, reasons=reasons),
        draw=draw,
        rows=table,
        views=[table.set_index("entry")],
        notes=[
            *suggestion.remarks,
            "Next:",
            *(f"tegotae {command}" for command in commands),
        ],
        data=wiring_document(suggestion.wiring),
    )
