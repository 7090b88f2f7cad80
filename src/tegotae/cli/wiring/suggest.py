"""`tegotae wiring suggest`: a first wiring of a MuJoCo model."""

from __future__ import annotations

import shlex
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

from tegotae._support.errors import TegotaeError, require_all
from tegotae._support.files import output_file
from tegotae.cli.console import print_rows
from tegotae.cli.env_options import made_with
from tegotae.cli.options import UNSET
from tegotae.systems.env_task import extras_of

if TYPE_CHECKING:
    from tegotae.envs.mujoco.suggesting import Suggestion


@dataclass(frozen=True, kw_only=True)
class WiringSuggest:
    """Suggest a wiring for a MuJoCo model of your own: feet, limbs, pushes, scales, rest length.

    Every entry has its reason beside it, in the terminal and as a comment in the file. The wiring
    is a first guess: correct every entry that you know better.
    """

    model: Annotated[str, tyro.conf.Positional]
    """An MJCF file: FILE.xml or, in an installed package, PACKAGE:FILE.xml."""
    feet: Annotated[tuple[str, ...], UNSET] = ()
    """Bodies or geoms that touch the ground; by default the lowest ones at the end of a chain."""
    settings: Annotated[tuple[str, ...], UNSET] = ()
    """Further settings of the model: NAME=VALUE, values as in JSON, such as ground=true."""
    out: Annotated[
        Path | None, tyro.conf.arg(help_behavior_hint="(default: named as the model)")
    ] = None
    """The wiring's file (.toml or .json)."""

    def run(self) -> None:
        """Suggest, print and write."""
        require_all(extras_of("model.xml"))
        from tegotae.envs.env_spec import EnvSpec
        from tegotae.envs.mujoco.suggesting import suggest_wiring
        from tegotae.envs.wiring_file import save_wiring

        if not EnvSpec(env=self.model).is_model:
            raise TegotaeError(
                f"{self.model} is no MuJoCo model (FILE.xml); for another environment write the "
                "wiring by hand, and check it with tegotae.envs.check_wiring"
            )
        file = self._file()
        given = made_with(self.feet, None, self.settings, is_model=True)
        spec = EnvSpec(env=self.model, settings=given)
        found = suggest_wiring(spec.model_settings)
        save_wiring(found.wiring, file, reasons=found.reasons)
        print_rows(("entry", "value", "reason"), _rows(found))
        for remark in found.remarks:
            print(remark)
        print(f"wrote {file}; next:")
        where = ["--env", self.model, "--wiring", str(file)]
        if self.settings:
            where += ["--settings", *self.settings]
        if found.on_rail:
            where += ["--fitness", "hopping"]
        elif len(found.wiring.limbs) > 1:
            # What hops ahead, or walks, is paid for distance; CoT⁻¹ of hops alone often stays 0.
            where += ["--fitness", "return"]
        print(f"  tegotae wiring baseline {shlex.join(where)}")
        print(f"  tegotae train ART {shlex.join(where)}")

    def _file(self) -> Path:
        if self.out is not None:
            return output_file(self.out)
        file = Path(Path(self.model.rpartition(":")[2]).stem + ".toml")
        if file.exists():
            raise TegotaeError(f"{file} exists already; name another file with --out")
        return output_file(file)


def _rows(found: Suggestion) -> list[tuple[str, str, str]]:
    """Entry, value and reason; what has no reason is not worth a line."""
    wiring, why = found.wiring, found.reasons
    plain = {
        "contact_bodies": ", ".join(wiring.contact_bodies),
        **{name: getattr(wiring, name) for name in ("height", "work")},
        "rest_length_m": f"{wiring.rest_length_m:g}",
        "step_s": f"{wiring.step_s:g}",
        "omega": f"{wiring.omega:g}",
        **{f"scales.{name}": f"{value:g}" for name, value in wiring.scales.items()},
    }
    if wiring.sector_rad is not None:
        plain["sector_rad"] = ", ".join(f"{x:.3g}" for x in wiring.sector_rad)
    rows = [(name, value, why.get(name, "")) for name, value in plain.items()]
    for i, limb in enumerate(wiring.limbs):
        own = {
            "rest": f"{limb.rest:g}",
            "push": f"{limb.push:g}",
            "spring_force": limb.senses["spring_force"],
            "phase_rad": f"{limb.phase_rad:.3g}",
        }
        rows += [
            (f"{limb.drives}: {name}", value, why[f"limbs[{i}].{name}"])
            for name, value in own.items()
            if f"limbs[{i}].{name}" in why
        ]
    return rows
