"""A controller from elsewhere on the limbs of an environment, without training."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from tegotae._support.errors import TegotaeError, require_all
from tegotae.parts.units import Units
from tegotae.questions.question import Names, question
from tegotae.questions.wiring import OnEnvironment, stem_of
from tegotae.systems.controller_file import SavedController, save
from tegotae.systems.env_task import extras_of
from tegotae.systems.resolve import resolve
from tegotae.systems.robot_file import law_on_robot
from tegotae_robots.questions.model_file import ModelFile


@dataclass(frozen=True, kw_only=True)
class Transferable(Names):
    """A controller by name."""

    NAMED = (
        "A name is one of a controller with weights: a file, a trained controller such as "
        "zoo:AR-rF+range@quadruped-c, a legged system such as quadruped-c or a template, FILE.toml."
        " NAME@FILE.toml puts it on the robot of a file."
    )


@dataclass(frozen=True, kw_only=True)
class TransferOptions(OnEnvironment):
    """Where the controller goes, and its file there."""

    env: str
    """The environment, unless the name says the robot: a Gymnasium id, with a --wiring."""
    duration_s: float = 8.0
    """Duration of an episode [s]."""
    out: Path
    """The controller's file (.json), which must not be there yet."""

    @classmethod
    def options_of(cls, law: str) -> TransferOptions:
        """A file that is named as the controller."""
        name = law.rpartition(":")[2].replace("@", "-")
        return cls(env="", out=Path(f"{stem_of(name)}-there.json"))


@dataclass(frozen=True, repr=False, kw_only=True)
class TransferredController(ModelFile):
    """A controller on an environment, .json. `raw` is the `SavedController`."""

    ENDING = ".json"

    def _write(self, file: Path) -> None:
        save(self.raw, file)


def _conversions(saved: SavedController, omega: float | None, units: Units) -> pd.DataFrame:
    """Return a row for each number that changes its units."""
    rows = [
        ("length", 1.0, units.length_m, "m"),
        ("time", 1.0, units.time_s, "s"),
        ("force", 1.0, units.force_n, "N"),
        ("omega", saved.omega, round(omega or 0.0, 3), "rad/s"),
    ]
    return pd.DataFrame(rows, columns=["number", "its own", "there", "unit"])


@question(
    subjects=Transferable,
    kinds={"option": lambda: TransferOptions.options_of("my_law.json")},
)
def wiring_transfer(law: str, options: TransferOptions) -> TransferredController:
    """Put a controller from elsewhere on the limbs of an environment, without training.

    With units in the wiring (`tegotae wiring suggest MODEL.xml --settings legs=true`) it is scaled
    by Froude's similarity: lengths over l0, times over √(l0 / g), forces over the weight. Its file
    is then a name for every command, such as simulate, evaluate or train --start.

    Example:
        >>> wiring_transfer("quadruped-c@robot.toml").save("walks.json")  # doctest: +SKIP
    """
    from tegotae.training.environments.transfer import transferred

    env = options.env
    if (on_robot := law_on_robot(law)) is not None:
        law, env = on_robot
    if not env:
        raise TegotaeError("no robot is given; name its file, LAW@FILE.toml, or an --env")
    TransferredController.check_name(options.out)
    require_all(extras_of(env))
    saved = resolve(law).controller()
    spec, wiring = options.wired(env)
    name = f"{saved.name or Path(law).stem}-on-{stem_of(env)}"
    put = transferred(
        saved, spec, wiring, name=name, omega=options.omega, duration_s=options.duration_s
    )
    table = pd.DataFrame() if wiring.units is None else _conversions(saved, put.omega, wiring.units)
    return TransferredController(
        raw=put,
        outcome=f"{saved.name or law}, {put.controller.n_weights} weights, on {spec.env}",
        table=table,
        shown=[] if table.empty else [table.set_index("number")],
        remarks=["Next:", f"tegotae simulate {options.out}", f"tegotae evaluate {options.out}"],
        data={"name": name, "omega_rad_per_s": put.omega},
    )
