"""The list of the paper's claims: its words, names and effects."""

from collections import Counter
from pathlib import Path

import pytest

from research.reproduction.claims.atomic import ALIKE, ATOMIC_CLAIMS, LESS, MORE
from research.reproduction.claims.effects import (
    Correlation,
    Difference,
    DoubleDifference,
    Unmeasured,
)
from research.reproduction.claims.quotations import hashes_of, stands_in
from research.reproduction.table import ARCHITECTURES
from tegotae.measures.hopping.metrics import HOPPING

KNOWN = set((Path(__file__).parents[1] / "kept" / "paper-words.txt").read_text().split())


@pytest.mark.parametrize("claim", ATOMIC_CLAIMS, ids=lambda claim: claim.name)
def test_a_claim_quotes_words_that_stand_in_the_paper(claim):
    assert stands_in(claim.words, KNOWN)


def test_words_that_the_paper_does_not_have_are_found_out():
    assert not stands_in("Adding active gain modulation vastly impairs the CoT", KNOWN)
    assert not stands_in("too short", KNOWN), "no run of five words is no evidence"


def test_a_quotation_may_leave_words_out_where_it_says_so():
    text = hashes_of("one two three four five six seven eight nine ten eleven twelve")
    assert stands_in("one two three four five […] eight nine ten eleven twelve", text)
    assert not stands_in("one two three four five eight nine ten eleven twelve", text)


def test_each_claim_has_a_name_of_its_own():
    assert set(Counter(claim.name for claim in ATOMIC_CLAIMS).values()) == {1}


def test_each_claim_has_a_sign_or_a_word_for_how_alike_things_are():
    for claim in ATOMIC_CLAIMS:
        assert claim.sign in (MORE, LESS, ALIKE)
        assert claim.sign != ALIKE or claim.size


def test_what_no_table_has_says_so():
    for claim in ATOMIC_CLAIMS:
        assert claim.note or not isinstance(claim.effect, Unmeasured)


def test_effects_name_metrics_and_architectures_that_there_are():
    for effect in (claim.effect for claim in ATOMIC_CLAIMS):
        if isinstance(effect, Correlation):
            assert {effect.a, effect.b} <= set(HOPPING.names())
        if isinstance(effect, Difference | DoubleDifference):
            assert effect.metric in HOPPING.names()
        if isinstance(effect, Difference):
            groups = [group for group in (effect.ours, effect.theirs) if group]
            assert {name for entry in groups for name in entry.architectures} <= set(ARCHITECTURES)
