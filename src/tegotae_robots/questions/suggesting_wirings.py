"""A first wiring of a MuJoCo model, every entry with its reason."""

from __future__ import annotations

import shlex
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pandas as pd

from tegotae._support.errors import TegotaeError
from tegotae.questions.question import question
from tegotae.questions.wiring import Environments
from tegotae.systems.env_task import is_mujoco_model
from tegotae_robots.questions.model_file import ModelFile, ModelFileOptions

if TYPE_CHECKING:  # which needs Gymnasium
    from matplotlib.figure import Figure

    from tegotae.envs.env_spec import EnvSpec
    from tegotae_robots.models.suggesting import Suggestion


@dataclass(frozen=True, repr=False, kw_only=True)
class SuggestedWiring(ModelFile):
    """A robot's file, .toml, with a first wiring. `raw` is a
    `tegotae_robots.models.suggesting.Suggestion`, and the document that of the wiring."""

    spec: EnvSpec

    def figures(self) -> dict[str, Figure]:
        """The workspace of feet that are commanded to places; none of joints."""
        from tegotae_robots.models.workspace import workspace_figure

        return {} if self.raw.legs is None else {"workspace": workspace_figure(self.raw)}

    def _write(self, file: Path) -> None:
        from tegotae.envs.robot_file import save_robot

        save_robot(self.spec, self.raw.wiring, file, reasons=self.raw.reasons)


def _entries(suggestion: Suggestion) -> pd.DataFrame:
    """A row an entry that has a reason."""
    wiring, rows = suggestion.wiring, []
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
        rows.append((name, _said(value), reason))
    return pd.DataFrame(rows, columns=["entry", "value", "reason"])


def _said(value: Any) -> str:
    if isinstance(value, str):
        return value
    return f"{value:.4g}" if isinstance(value, float) else ", ".join(map(_said, value))


@question(
    subjects=Environments,
    kinds={"option": lambda: ModelFileOptions.options_of("my_leg.xml")},
)
def wiring_suggest(env: str, options: ModelFileOptions) -> SuggestedWiring:
    """Suggest a wiring for a MuJoCo model of your own: feet, limbs, pushes, scales, rest length.

    The file is a robot's: it has the model with its settings, too, and `LAW@FILE.toml` is a law on
    it for every command. Every entry has its reason beside it, in the terminal and as a comment in
    the file. The wiring is a first guess: correct every entry that you know better.

    Example:
        >>> wiring_suggest("my_leg.xml").save("my_leg.toml")  # doctest: +SKIP
    """
    from tegotae.envs.wiring import wiring_document
    from tegotae_robots.models.suggesting import suggest_wiring
    from tegotae_robots.models.suggesting_legs import suggest_legs

    if not is_mujoco_model(env):
        raise TegotaeError(
            f"{env} is no MuJoCo model (FILE.xml); for another environment write the wiring by "
            "hand, and check it with tegotae.envs.check_wiring"
        )
    SuggestedWiring.check_name(options.out)
    spec = options.spec(env, options.feet)
    settings = spec.model_settings
    suggestion = suggest_legs(settings) if settings.legs else suggest_wiring(settings)
    robot = shlex.quote(str(options.out))
    if settings.legs:
        ways = [f"simulate zoo:AR-rF+range@{robot}", f"train AR@{robot}"]
    else:
        # What hops ahead, or walks, is paid for distance; CoT⁻¹ of hops alone often stays 0.
        walks = len(suggestion.wiring.limbs) > 1
        fitness = "hopping" if suggestion.on_rail else "return" if walks else ""
        paid = f" --fitness {fitness}" if fitness else ""
        ways = [f"wiring baseline {robot}{paid}", f"train ART@{robot}{paid}"]
    table = _entries(suggestion)
    return SuggestedWiring(
        raw=suggestion,
        spec=spec,
        table=table,
        shown=[table.set_index("entry")],
        remarks=[
            *suggestion.remarks,
            "Next:",
            *(f"tegotae {way}" for way in ways),
        ],
        data=wiring_document(suggestion.wiring),
    )
