"""The paper's claims, each a function from results to a verdict.

A claim is made of parts, each an effect with its 95 % interval. It holds if every part does, fails
if the interval of any part lies on the wrong side, and is undecided otherwise; without any data it
is not measured. Parts without bounds are for information.

A gait without a limit cycle has no CoT⁻¹ and no transients, and is left out of those and counted
beside them; a body at rest has a CoT⁻¹ of zero. T0 and T1 are thus of those that settle and
recover, whose shares stand beside. Architectures are compared design by design, that is, at equal
ω_t and input of the actuation, and the differences averaged.

Claims 2 to 9 are decided by the study's table (`verdicts`), of all runs, at each ω_t alone
(`verdicts_by_omega`) and after each budget of training (`verdicts_by_budget`); claims 1
(algorithms), 10 (number of parameters) and 11 (gain and frequency) by experiments of their own
(`experiment_verdicts`).
"""

from pathlib import Path

from tegotae.study.claims.architectures import (
    CLAIMS,
    FAR,
    MODELS,
    NEAR,
    correlation,
    designs,
    verdicts,
)
from tegotae.study.claims.experiments import (
    EXPERIMENTS,
    KeptExperiment,
    claim_1,
    claim_10,
    claim_11,
    experiment_verdicts,
)
from tegotae.study.claims.slices import ALL, verdicts_by_budget, verdicts_by_omega
from tegotae.study.claims.verdict import (
    FAILS,
    HOLDS,
    INFORMATION,
    NOT_MEASURED,
    UNDECIDED,
    Part,
    Verdict,
)
from tegotae.study.table import Table


def all_verdicts(table: Table, experiments: Path | None = None) -> list[Verdict]:
    """What a study's table and the experiments' tables in a folder say, in the order of claims.

    Raises:
        TegotaeError: if there is no such folder, or a table cannot be read.
    """
    found = [*verdicts(table), *experiment_verdicts(experiments)]
    return sorted(found, key=lambda verdict: verdict.number)


__all__ = [
    "ALL",
    "CLAIMS",
    "EXPERIMENTS",
    "FAILS",
    "FAR",
    "HOLDS",
    "INFORMATION",
    "MODELS",
    "NEAR",
    "NOT_MEASURED",
    "UNDECIDED",
    "KeptExperiment",
    "Part",
    "Verdict",
    "all_verdicts",
    "claim_1",
    "claim_10",
    "claim_11",
    "correlation",
    "designs",
    "experiment_verdicts",
    "verdicts",
    "verdicts_by_budget",
    "verdicts_by_omega",
]
