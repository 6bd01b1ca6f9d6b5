"""The search's arithmetic: evidence, cost, and that annealing goes on from where it is told."""

from __future__ import annotations

from math import lgamma

import numpy as np
import pytest

from wakeful.learning.clauses import Clauses, as_bits
from wakeful.learning.rule_search import Search, SearchSettings

RANDOM = np.random.default_rng(3)
X = np.column_stack([RANDOM.integers(0, 2, (60, 3)), RANDOM.random((60, 2))]).astype(np.float64)
Y = np.where(X[:, 0] > 0, 1, 0)
EVERYTHING = (1 << 60) - 1


def search(**settings: float) -> Search:
    return Search(Clauses(X), [as_bits(y == Y) for y in (0, 1)], EVERYTHING, SearchSettings(**settings))  # type: ignore[arg-type]


def test_the_evidence_is_the_dirichlet_multinomials() -> None:
    def dirichlet(counts: tuple[int, ...], a: float = 0.1) -> float:
        total = lgamma(len(counts) * a) - lgamma(sum(counts) + len(counts) * a)
        return total + sum(lgamma(count + a) - lgamma(a) for count in counts)

    found = search()
    counts = found.counts(((0,),))
    masks = (found.mask((0,)),)
    assert found.likelihood(masks, EVERYTHING) == pytest.approx(sum(dirichlet(each) for each in counts))


def test_rules_speak_in_turn_for_what_is_left() -> None:
    counts = search().counts(((0,), (1,), (2,)))
    assert sum(sum(each) for each in counts) == 60
    assert sum(counts[2]) == 0  # rule 1 is rule 0's negation: nothing is left for rule 2


def test_a_limit_that_is_named_twice_costs_little_the_second_time() -> None:
    found = search()
    limit = found._clauses.limited_clause(0, 0.5, True)
    assert limit is not None
    other = found._clauses.limited_clause(1, 0.5, True)
    assert other is not None
    assert found.cost(((limit,), (0, limit))) < found.cost(((limit,), (0, other)))


def test_a_longer_list_costs_more() -> None:
    found = search()
    assert found.cost(()) == 0.0 < found.cost(((0,),)) < found.cost(((0,), (2,)))


def test_annealing_finds_the_column_that_decides() -> None:
    kept = search(steps=150).chain(1)
    score, rules = kept[-1]
    assert len(rules) >= 1
    assert score > search().found((), ()).score + 20
    assert {clause for rule in rules for clause in rule} & {0, 1}


def test_a_chain_can_go_on_from_a_list() -> None:
    own = search(steps_again=40, heat_again=1.0)
    best = own.chain_from(((0,),), 5)[-1]
    assert best[0] >= own.found(((0,),), (own.mask((0,)),)).score - 8.0


def test_only_the_rows_that_are_given_are_learned_from() -> None:
    half = (1 << 30) - 1
    found = Search(Clauses(X), [as_bits(y == Y) for y in (0, 1)], half, SearchSettings())
    assert sum(sum(each) for each in found.counts(((0,),))) == 30
