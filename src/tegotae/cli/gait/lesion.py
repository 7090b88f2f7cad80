"""`tegotae gait lesion`: a leg lost, a load laid on, the ground dropped."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated

import numpy as np

from tegotae._support.errors import TegotaeError
from tegotae.cli.console import print_rows
from tegotae.cli.gait.options import GaitCommand
from tegotae.cli.options import UNSET

if TYPE_CHECKING:
    from tegotae.analysis.gaits.lesion import Aftermath


@dataclass(frozen=True, kw_only=True)
class Lesion(GaitCommand):
    """Remove a leg, change the body or drop the ground, and count the releases that stay up."""

    lose: Annotated[tuple[str, ...], UNSET] = ()
    """Names of legs that are lost, such as LH."""
    then: Annotated[tuple[str, ...], UNSET] = ()
    """Parameters of the body that change at that time, such as mass_kg=1.3 com_x_m=0.1."""
    lasting: Annotated[float | None, UNSET] = None
    """Duration of this change [s], such as for a push, push_y_n=0.3; by default permanent."""
    drop: float = 0.0
    """Height by which the ground drops [m]."""
    at: Annotated[float | None, UNSET] = None
    """Time of the event [s]; by default half of the duration."""
    starts: int = 64
    """Number of releases."""

    def run(self) -> None:
        """Compute, write, and print."""
        from tegotae.analysis.gaits.lesion import GaitLesion as What
        from tegotae.analysis.gaits.lesion import aftermath
        from tegotae.analysis.gaits.simulate import coordination_columns, write
        from tegotae.figures.gaits.maps import lesion_figure
        from tegotae.systems.legged import assignments

        fields = tuple(_number(*each) for each in assignments("--then", self.then).items())
        legged = self.legged()
        at = 0.5 * legged.timing.duration_s if self.at is None else self.at
        lasts = math.inf if self.lasting is None else self.lasting
        what = What(at_s=at, lost=self.lose, fields=fields, drop_m=self.drop, lasts_s=lasts)
        found = aftermath(legged, what, self.starts, seed=self.seed, tolerance=self.tolerance)
        left = [legged.names[i] for i in found.left]
        before = coordination_columns(found.before, legged.names)
        after = coordination_columns(found.after, left)
        rows = {
            "start": np.arange(self.starts),
            "stood_before": found.stood,
            "stays_up": found.stays,
            "gait_before": found.gait_before,
            "gait_after": found.gait_after,
            **{f"lag_change_cycles_{leg}": found.lag_change[i] for i, leg in enumerate(left)},
            **{f"before_{name}": values for name, values in before.items()},
            **{f"after_{name}": values for name, values in after.items()},
        }
        share, low, high = found.share
        document = self.document(
            legged, "gait lesion", lesion=found.lesion, reference=legged.names[found.reference],
            margin_m=_defined(found.margin_m),
            stays_up={"share": share, "low": low, "high": high, "of": int(found.stood.sum())},
        )  # fmt: skip
        written = [
            self.draw(lesion_figure(found, self.title(legged)), "lesion"),
            *write(self.folder, "lesion", document, rows),
        ]
        _print(found)
        self.wrote(written)


def _number(name: str, value: float | tuple[float, ...]) -> tuple[str, float]:
    if isinstance(value, tuple):
        raise TegotaeError(f"--then {name} has {len(value)} numbers; name one")
    return name, value


def _defined(value: float) -> float | None:
    return None if math.isnan(value) else value


def _print(found: Aftermath) -> None:
    names, time = found.legged.names, found.legged.units[1]
    share, low, high = found.share
    stood = int(found.stood.sum())
    print(
        f"{found.lesion.label} at {found.lesion.at_s:g} {time}: "
        f"{int(found.stays.sum())} of {stood} that stood stay up, "
        f"{share:.3f} ({low:.3f} … {high:.3f})"
    )
    if not math.isnan(found.margin_m):
        length = found.legged.units[0]
        print(f"the mass is {found.margin_m:.3f} {length} inside the feet that are left")
    pairs = [
        f"{a} → {b}"
        for a, b in zip(found.gait_before[found.stood], found.gait_after[found.stood], strict=True)
    ]
    listed, counts = np.unique(pairs, return_counts=True)
    order = np.argsort(-counts, kind="stable")
    print_rows(("before → after", "starts"), ((str(listed[i]), str(counts[i])) for i in order))
    stays = found.stays
    for i, leg in enumerate(found.left):
        change = found.lag_change[i][stays]
        if leg != found.reference and np.isfinite(change).any():
            print(f"lag of {names[leg]} moves by {np.nanmedian(change):+.3f} cycles (median)")
    for what, values in (
        ("falls after", found.after.fall_time_s[found.stood]),
        ("locks again after", found.after.lock_time_s[stays]),
    ):
        if np.isfinite(values).any():
            count = int(np.isfinite(values).sum())
            print(f"{what} {np.nanmedian(values):.3g} {time} (median of {count})")
