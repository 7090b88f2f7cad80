"""What all gait commands have in common: the system, and the folder for what they write."""

from __future__ import annotations

import contextlib
import dataclasses
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import tyro

from tegotae.cli.options import UNSET, AsItIs
from tegotae.errors import TegotaeError, require_finite, unknown
from tegotae.files import output_folder

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from tegotae.gaits import Legged


@dataclass(frozen=True, kw_only=True)
class Subject:
    """A legged system, and a folder."""

    system: Annotated[str, tyro.conf.Positional]
    """A system's name, such as bar-light or quadruped-c; FILE.py:OBJECT, a Legged of your own; or a
    controller file of `tegotae train`."""
    out: Path
    """The folder for pictures (.png), tables (.csv) and documents (.json)."""
    omega: AsItIs = None
    """Frequency ω [rad/s]."""
    sigma: AsItIs = None
    """Gain σ of a vanilla controller."""
    set: tuple[str, ...] = ()
    """Fields of the body that are to be otherwise, such as inertia_ratio=0.35."""
    duration: Annotated[float | None, UNSET] = None
    """Simulated time [s]; the system's by default."""
    seed: int = 0
    """Of the random phases at release."""
    tolerance: float = 0.1
    """How far lags may be from those of a named gait [cycles]."""

    def legged(self) -> Legged:
        """The system with what was given; the folder is made.

        Raises:
            TegotaeError: for what cannot be, before anything is computed.
        """
        from tegotae.gaits import system

        require_finite("tolerance", self.tolerance, above=0.0, most=0.5)
        found = system(self.system).with_numbers(self.omega, self.sigma)
        if self.set:
            fields = dict(assignment("--set", each) for each in self.set)
            own = [field.name for field in dataclasses.fields(found.body)]  # type: ignore[arg-type]
            for name in fields:
                if name not in own:
                    raise unknown(f"field of a {type(found.body).__name__}", name, own)
            found = found.with_body(dataclasses.replace(found.body, **fields))  # type: ignore[type-var]
        if self.duration is not None:
            timing = dataclasses.replace(found.timing, duration_s=self.duration)
            found = dataclasses.replace(found, timing=timing)
        output_folder(self.out)
        return found

    def title(self, legged: Legged, *, omega: bool = True) -> str:
        """The system in a few words, for a figure."""
        from tegotae.figures.style import literal

        name = self.system.rpartition(":")[2] or self.system
        at = f", ω = {legged.omega:g}" if omega and legged.omega is not None else ""
        return literal(", ".join([name, *self.set])) + at

    def document(self, legged: Legged, command: str, **more: Any) -> dict[str, Any]:
        """What stands in a document before what was found."""
        from tegotae import __version__
        from tegotae.gaits.document import system_document

        settings = {
            field.name: getattr(self, field.name)
            for field in dataclasses.fields(self)
            if field.name not in ("out",)
        }
        return {
            "command": f"gait {command}",
            "version": __version__,
            "settings": settings,
            "system": system_document(legged),
            **more,
        }

    def draw(self, figure: Figure, name: str) -> Path:
        """Write a picture."""
        from tegotae.figures.style import save_figure

        return save_figure(figure, self.out / f"{name}.png")

    def wrote(self, paths: Iterable[Path]) -> None:
        """Say what was written."""
        print("wrote " + ", ".join(map(str, paths)))


def assignment(option: str, text: str) -> tuple[str, Any]:
    name, equals, value = text.partition("=")
    numbers: tuple[float, ...] = ()
    with contextlib.suppress(ValueError):
        numbers = tuple(float(each) for each in value.split(","))
    if not equals or not numbers:
        raise TegotaeError(
            f"{option} {text} sets nothing; write NAME=NUMBER, or NAME=NUMBER,NUMBER for the legs"
        )
    return name, numbers[0] if len(numbers) == 1 else numbers
