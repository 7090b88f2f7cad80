"""`python -m apps.playground`: a page to play with, in one file."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated

from apps.playground import ControllerChoice, Page, standard
from tegotae._support.errors import TegotaeError
from tegotae._support.files import output_file, write_atomically
from tegotae._support.progress import note
from tegotae.api.parameters import POSITIONAL
from tegotae.systems.resolve import resolve
from tegotae.systems.zoo import stem
from tegotae.training.collection import controller_of


@dataclass(frozen=True, kw_only=True)
class Playground:
    """Write the playground: one HTML file that needs no server and no network.

    On it one can disturb controllers, change their bodies, compare them, and watch one learn.
    """

    controllers: Annotated[list[str], POSITIONAL] = field(default_factory=list)
    """Controller files, or other names with weights, such as V-sector-w4; by default a vanilla and
    three learned controllers."""
    out: Path = Path("playground.html")
    """File of the page."""

    def run(self) -> None:
        """Write the page, and say where it is."""
        if self.out.suffix.lower() not in (".html", ".htm"):
            raise TegotaeError(f"cannot write a page as {str(self.out)!r}; its name ends in .html")
        path = output_file(self.out)
        stems = [stem(specification) for specification in self.controllers]
        choices = [
            ControllerChoice(
                name if stems.count(name) == 1 else specification,
                controller_of(resolve(specification)),
            )
            for name, specification in zip(stems, self.controllers, strict=True)
        ]
        page = Page([*choices, *standard()[:1]] if choices else standard(), note)
        html = page.html()
        write_atomically(path, html)
        print(f"{path}: {len(html.encode()) / 1024:.0f} KB; open it in a browser")
