"""What all gait commands have in common: the system, and the folder for what they write."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import tyro

from tegotae._support.errors import TegotaeError, require_finite
from tegotae._support.files import check_folder
from tegotae.cli.asking import file_stem
from tegotae.cli.options import UNSET, SystemsOwn

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from tegotae.analysis.gaits import Legged


@dataclass(frozen=True, kw_only=True)
class LeggedSystemOptions:
    """A legged system by name, and what of it is to be otherwise."""

    system: Annotated[str, tyro.conf.Positional]
    """The name of a system, such as bar-light or quadruped-c; a controller file; or FILE.py:OBJECT,
    a Legged or SavedController of your own. It sets release, control period and integrator."""
    omega: SystemsOwn = None
    """Frequency ω [rad/s]."""
    sigma: SystemsOwn = None
    """Gain σ of a vanilla controller."""
    duration: Annotated[float | None, UNSET] = None
    """Simulated time [s]; by default the system's, or one in which legs settle."""
    set: Annotated[tuple[str, ...], UNSET] = ()
    """Change fields of the body, such as inertia_ratio=0.35."""
    terrain: Annotated[tuple[str, ...], UNSET] = ()
    """Ground of a walking torso: flat, slope, steps, rough or FILE.py:OBJECT, followed by its
    parameters, such as rough rms_m=0.05."""
    delay: float = 0.0
    """Delay of the senses of the legs [s]."""
    noise: float = 0.0
    """Noise of the senses of the legs, relative to their scales."""
    seed: int = 0
    """Seed of the random phases of the legs at release."""
    tolerance: float = 0.1
    """Tolerance around the lags of a named gait [cycles]."""

    def legged(self) -> Legged:
        """The system with what was given.

        Raises:
            TegotaeError: for what cannot be, before anything is computed.
        """
        from tegotae.cli.options import require_ours
        from tegotae.parts.fields import with_fields
        from tegotae.systems.legged import assignments, felt, terrain_of
        from tegotae.systems.resolve import resolve

        require_finite("tolerance", self.tolerance, above=0.0, most=0.5)
        named = resolve(self.system)
        require_ours(named)
        found = named.legs().with_numbers(self.omega, self.sigma)
        if self.set:
            fields = assignments("--set", self.set)
            if "present" in fields:
                raise TegotaeError(
                    "--set present would remove legs that are then measured; tegotae gait lesion "
                    "--lose removes legs"
                )
            found = found.with_body(with_fields(found.body, fields))
        if self.terrain:
            found = found.with_body(with_fields(found.body, {"terrain": terrain_of(self.terrain)}))
        if self.duration is not None:
            timing = dataclasses.replace(found.timing, duration_s=self.duration)
            found = found.with_system(timing=timing)
        if self.delay or self.noise:
            found = found.with_body(felt(found, self.delay, self.noise))
        return found

    def title(self, legged: Legged, *, omega: bool = True) -> str:
        """The system in a few words, for a figure."""
        from tegotae.figures.gaits.style import setting
        from tegotae.figures.style import literal

        name = self.system.rpartition(":")[2] or self.system
        at = f", ω = {legged.omega:g}" if omega and legged.omega is not None else ""
        words = [name, *map(setting, self.set), " ".join(self.terrain)]
        words += [f"{what} {x:g}" for what in ("delay", "noise") if (x := getattr(self, what))]
        return literal(", ".join(filter(None, words))) + at

    def document(self, legged: Legged, command: str, **more: object) -> dict[str, object]:
        """What stands in a document before what was found."""
        from tegotae import __version__
        from tegotae.analysis.gaits.simulate import system_document

        settings = {
            field.name: getattr(self, field.name)
            for field in dataclasses.fields(self)
            if field.name not in ("out", "format")
        }
        return {
            "command": command,
            "version": __version__,
            "settings": settings,
            "system": system_document(legged),
            **more,
        }


@dataclass(frozen=True, kw_only=True)
class GaitCommand(LeggedSystemOptions):
    """A legged system, and a folder."""

    out: Annotated[Path | None, UNSET] = None
    """Folder for pictures, tables (.csv) and documents (.json); by default named after the command
    and the system."""
    format: Literal["png", "svg", "pdf"] = "png"
    """Format of the pictures."""

    @property
    def folder(self) -> Path:
        """The folder that is written, such as `gait-map-quadruped-c`."""
        kind = f"gait-{type(self).__module__.rpartition('.')[2]}"
        return Path(f"{kind}-{file_stem(self.system)}") if self.out is None else self.out

    def legged(self) -> Legged:
        """The system with what was given; the folder is tried for writing.

        Raises:
            TegotaeError: for what cannot be, before anything is computed.
        """
        found = super().legged()
        check_folder(self.folder)
        return found

    def draw(self, figure: Figure, name: str) -> Path:
        """Write a picture."""
        from tegotae.figures.style import save_figure

        return save_figure(figure, self.folder / f"{name}.{self.format}")

    def wrote(self, paths: Iterable[Path]) -> None:
        """Say what was written."""
        print("wrote " + ", ".join(map(str, paths)))
