"""`tegotae gait front`: the least cost of transport over speed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tegotae._support.errors import TegotaeError
from tegotae._support.progress import reporting
from tegotae._support.workplace import GAIT_FRONT, require_free_for
from tegotae.cli.console import print_rows
from tegotae.cli.gait.options import GaitCommand


@dataclass(frozen=True, kw_only=True)
class Front(GaitCommand):
    """Search for the least cost of transport at every speed, over frequency, gain, stride and
    lift."""

    family: tuple[str, ...] = ("vanilla",)
    """Controllers of the legs: vanilla, cosine, "vanilla ellipse", or a gait prescribed without
    feedback, such as "forced trot"."""
    walkers: int = 8192
    """Number of random walkers at the start."""
    rounds: int = 8
    """Number of rounds in which the cheapest walkers of every speed are varied."""
    varied: int = 1024
    """Number of variations per round."""
    starts: int = 4
    """Number of releases per walker. All must stay up and settle."""
    unseen: int = 32
    """Number of further releases, from other phases, to check the cheapest walkers."""

    def run(self) -> None:
        """Search, write, and print."""
        from tegotae.analysis.gaits.front import Search, search_front
        from tegotae.analysis.gaits.simulate import write
        from tegotae.figures.gaits.maps import front_figure
        from tegotae.systems.tuned import family

        require_free_for(self.folder, GAIT_FRONT)
        search = Search(
            coarse=self.walkers,
            rounds=self.rounds,
            varied=self.varied,
            starts=self.starts,
            unseen=self.unseen,
            seed=self.seed,
        )
        legged = self.legged()
        found = [family(legged, name) for name in dict.fromkeys(self.family)]
        parts = []
        for each in found:
            with reporting(each.name, search.walkers) as reporter:
                parts.append(
                    search_front(
                        legged,
                        each,
                        search,
                        kept=self.folder / f"front.{each.name.replace(' ', '-')}.partial.npz",
                        progress=lambda done, of, reporter=reporter: reporter.update(done),
                    )
                )
        if not any(len(part["speed"]) for part in parts):
            raise TegotaeError(
                f"no walker of {self.system} among {search.walkers // search.starts} stays up at a "
                "steady speed from every release, so it has no front; try fewer --starts, or more "
                "--walkers in a folder of their own"
            )
        table = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
        document = self.document(legged, "gait front", search=search)
        written = [
            self.draw(front_figure(table, self.title(legged, omega=False)), "front"),
            *write(self.folder, "front", document, table),
        ]
        print_rows(
            ("family", "speed", "cost of transport", "ω", "gait"),
            (
                (str(name), f"{v:.3f}", f"{cost:.3f}", f"{omega:.2f}", str(gait))
                for name, v, cost, omega, gait in zip(
                    *(table[c] for c in ("family", "speed", "cost_of_transport", "omega", "gait")),
                    strict=True,
                )
            ),
        )
        self.wrote(written)
