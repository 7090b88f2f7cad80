"""A demonstration: learned controllers move, without a question asked."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from tegotae._support.errors import require
from tegotae.api.controllers import load
from tegotae.api.parameters import check_types
from tegotae.api.results import Files

CONTROLLER = "zoo:ART-rF-tphif-w4/0"
"""The hopper's controller, learned from its leg force alone."""
ON_LEGS = "zoo:AR-rF+range"
"""The robot's controller, learned on a simple model of four legs."""
_NEXT = (
    f"tegotae explain {CONTROLLER} --plot why.png   # what its networks do",
    "tegotae train ART --seeds 4 --out runs/art   # learn your own in a minute",
    "tegotae --help   # all commands",
)


@check_types
def demo(*, robot: Path | None = None) -> Files:
    """Let a learned hopper hop over a drop, with a picture and a film.

    Args:
        robot: file of a robot with legs (.toml), written by `tegotae wiring suggest`, that walks,
            too; needs the extra mujoco.

    Returns:
        Files to save: hop.png and hop.gif; of a robot also walk.gif.

    Raises:
        MissingExtraError: for a robot without MuJoCo.
        TegotaeError: for a file that cannot be read, or is no robot with legs.

    Example:
        >>> print(demo().title)
        5 apexes; the last at 2.3003, 2.3051, 2.3067, 2.3070 m
    """
    walk = None
    if robot is not None:
        require("mujoco", "mujoco")
        walk = load(f"{ON_LEGS}@{robot}").simulate(duration_s=6.0)
    hop = load(CONTROLLER).simulate(drop_m=0.1, drop_time_s=3.0, duration_s=8.0)

    def write(folder: Path) -> Sequence[Path]:
        folder.mkdir(parents=True, exist_ok=True)
        hop.plot(folder / "hop.png")
        hop.animate(folder / "hop.gif")
        paths = [folder / "hop.png", folder / "hop.gif"]
        if walk is not None:
            walk.animate(folder / "walk.gif")
            paths.append(folder / "walk.gif")
        return paths

    return Files(
        title=hop.title,
        views=hop.texts(),
        notes=("Next:", *_NEXT),
        data=hop.to_dict(),
        rows=lambda: hop.table,
        write=write,
    )
