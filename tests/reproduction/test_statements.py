"""The further statements: their words, their numbers, and their kept effects."""

from collections import Counter
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from places import ROOT
from research.reproduction.claims.atomic import ALIKE
from research.reproduction.claims.counting import Count
from research.reproduction.claims.effect_table import effect_columns
from research.reproduction.claims.quotations import stands_in
from research.reproduction.claims.resampling import Resampled
from research.reproduction.statements.further import FURTHER, Balance, JointReach
from research.reproduction.statements.judged import balance, joint_reach, judge
from research.reproduction.statements.measure import spread
from research.reproduction.table import StudyTable

KEPT = ROOT / "research" / "reproduction" / "kept"
KNOWN = set((Path(__file__).parents[1] / "kept" / "paper-words.txt").read_text().split())


@pytest.mark.parametrize("statement", FURTHER, ids=lambda statement: statement.name)
def test_a_statement_quotes_words_that_stand_in_the_paper(statement):
    assert stands_in(statement.words, KNOWN)
    assert not stands_in(statement.words + " contrary to all", KNOWN)


def test_each_statement_has_a_name_of_its_own_and_a_sign_or_a_word_of_size():
    assert set(Counter(statement.name for statement in FURTHER).values()) == {1}
    assert all(statement.sign != ALIKE or statement.size for statement in FURTHER)


def test_pushes_at_one_phase_have_no_spread_and_opposite_ones_all():
    phases = np.array([[1.0, 1.0], [0.0, np.pi], [2.0, np.nan]])
    assert spread(np.cos(phases), np.sin(phases)) == pytest.approx([0.0, 1.0, np.nan], nan_ok=True)


def _runs(**metrics: list[float]) -> Resampled:
    """Return a study with one run of each model: four architectures on F, then on Fv."""
    n = len(next(iter(metrics.values())))
    words = {
        "model": [f"m{i}" for i in range(n)],
        "architecture": ["AR", "ART", "ARG", "ARGT"] * (n // 4),
        "observation": ["F"] * (n // 2) + ["Fv"] * (n // 2),
        "actuation": ["sector"] * n,
    }
    numbers = {name: [1.0] * n for name in ("best_fitness", "limit_cycle_share", "at_rest_share")}
    numbers |= {"run": [0.0] * n, "omega_t": [4.0] * n, **metrics}
    columns = {name: np.array(x) for name, x in words.items()}
    return Resampled(StudyTable(columns | {k: np.array(v) for k, v in numbers.items()}), 3)


def test_a_loss_is_weighed_against_a_gain_over_the_ranges_of_both():
    runs = _runs(t1_s=[1.0] * 4 + [3.0] * 4, cot_inverse=[0.0, 0.0, 0.0, 1.0] * 2)
    estimate = balance(Balance("t1_s", "cot_inverse"), runs, Count())
    assert (estimate.effect, estimate.size) == pytest.approx((1.0, 0.0))


def test_a_model_that_is_best_by_all_criteria_reaches_further_than_shuffled_ones():
    rising = list(np.linspace(0.0, 1.0, 8))
    together = _runs(cot_inverse=rising, t0_s=rising[::-1])
    against = _runs(cot_inverse=rising, t0_s=rising)
    number = JointReach(("cot_inverse", "t0_s"))
    ours, theirs = (joint_reach(number, runs, Count()) for runs in (together, against))
    assert ours.effect + ours.size == pytest.approx(1.0)
    assert theirs.effect + theirs.size == pytest.approx(3.0 / 7.0)


def test_kept_effects_are_those_of_the_kept_tables():
    names = ("omega-term", "horizon-sector", "no-senses-phase", "vg-erratic", "t-held")
    few = [statement for statement in FURTHER if statement.name in names]
    found = judge(
        pd.read_csv(KEPT / "study" / "paper.csv"),
        KEPT / "statements",
        ROOT / "research" / "experiments",
        few,
        resamples=2,
    )
    kept = pd.read_csv(KEPT / "statements" / "effects.csv")
    again = pd.DataFrame(effect_columns(found))
    kept = kept[kept.claim.isin(names)]
    assert kept.claim.tolist() == again.claim.tolist()
    assert kept.effect.to_numpy() == pytest.approx(again.effect.to_numpy(), rel=1e-4, nan_ok=True)
