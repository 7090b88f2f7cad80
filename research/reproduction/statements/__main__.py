"""Judge the statements of the paper that the study's table has no column for.

    python -m research.reproduction.statements measure    # the pushes of zoo:paper, an hour of CPU
    python -m research.reproduction.statements report     # effects and table of the page, a minute

The trainings of `cot-only.csv` and `held.csv` are those of `python -m research.reproduction run`
with --cot-only and --hold.
"""

from __future__ import annotations

from pathlib import Path

import pandas as pd

from research.frame import main, write_text
from research.reproduction.claims.effect_table import effects_csv
from research.reproduction.report.atomic import outcomes_table
from research.reproduction.statements.judged import judge
from research.reproduction.statements.measure import measure_models

_KEPT = Path(__file__).parents[1] / "kept"


def measure(study: Path = _KEPT / "study" / "paper.csv", out: Path = _KEPT / "statements") -> None:
    """Measure pushes and cut feedback of the models that the table lacks.

    Args:
        study: the study's runs.
        out: folder of pushes.csv.
    """
    measure_models(pd.read_csv(study), out / "pushes.csv")


def report(
    study: Path = _KEPT / "study" / "paper.csv",
    out: Path = _KEPT / "statements",
    experiments: Path = _KEPT.parents[1] / "experiments",
) -> None:
    """Judge every statement, and write effects.csv and statements.md.

    Args:
        study: the study's runs.
        out: folder of the tables.
        experiments: folder of figure3.csv and second_look.csv.
    """
    findings = judge(pd.read_csv(study), out, experiments)
    for finding in findings:
        print(f"{finding.claim.name:20} {finding.outcome}")
    write_text(out / "effects.csv", effects_csv(findings))
    write_text(out / "statements.md", outcomes_table(findings))


if __name__ == "__main__":
    main(measure, report)
