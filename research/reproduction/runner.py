"""The missing work of a study or of the readings, done in its folder."""

from __future__ import annotations

from pathlib import Path

from research.reproduction.folder import Folder, Work
from tegotae.study import Pool


def run_study(
    plan: Work,
    place: Path | Folder,
    pool: Pool | None = None,
    bundle: int | None = None,
    *,
    restart: bool = False,
) -> int:
    """Run the missing units of a plan in a folder, and return the number of records afterwards.

    Args:
        plan: the study.
        place: its folder.
        pool: where to work; worker processes on all cores of this machine by default.
        bundle: largest number of units that a worker does together.
        restart: whether a study that is there before is set aside, in a folder beside it.

    Raises:
        TegotaeError: if the folder holds another study or is in use, or as `Study.run` does.
        KeyboardInterrupt: after Ctrl-C. This and the former say what is kept.
    """
    folder = place if isinstance(place, Folder) else Folder(place)
    with folder.claimed(plan, restart=restart):
        units = plan.units
        folder.study(units).run(pool, bundle)
        return len(units)
