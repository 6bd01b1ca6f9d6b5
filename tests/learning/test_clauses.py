"""Clauses: what they hold of, what naming them costs, and that their rows as bits agree with the arrays."""

from __future__ import annotations

import numpy as np
import pytest

from wakeful.learning.clauses import LIMITS, Clause, Clauses, as_bits, holding

RANDOM = np.random.default_rng(0)
X = np.column_stack(
    [RANDOM.integers(0, 2, 80), np.ones(80), RANDOM.random(80), RANDOM.normal(size=80), RANDOM.integers(0, 2, 80)]
).astype(np.float64)


def test_columns_with_two_values_make_a_clause_and_its_negation_and_constant_ones_none() -> None:
    clauses = Clauses(X)
    assert [(each.column, each.above) for each in clauses.clauses] == [(0, True), (0, False), (4, True), (4, False)]
    assert clauses.bits[0] ^ clauses.bits[1] == (1 << 80) - 1


def test_two_columns_that_say_the_same_are_one() -> None:
    assert len(Clauses(np.column_stack([X[:, 0], X[:, 0]])).plain) == 2


def test_bits_are_the_rows_of_which_a_clause_holds() -> None:
    clauses = Clauses(X)
    for fraction in (0.0, 0.3, 0.99):
        for projection in range(sum(clauses.projections)):
            number = clauses.limited_clause(projection, fraction, True)
            assert number is not None
            assert clauses.bits[number] == as_bits(holding((clauses.clauses[number],), X)[:, 0])


def test_a_clause_through_a_row_holds_of_it() -> None:
    clauses = Clauses(X)
    for row in range(80):
        number = clauses.through(0, row / 80, row)
        assert number is not None
        assert clauses.bits[number] >> row & 1


def test_limits_shift_by_steps_until_there_are_none() -> None:
    clauses = Clauses(X)
    first = clauses.limited_clause(0, 0.0, True)
    assert first is not None
    assert clauses.shifted(first, -1) is None
    assert clauses.shifted(first, LIMITS) is None
    further = clauses.shifted(first, 1)
    assert further is not None
    assert clauses.clauses[further].limit > clauses.clauses[first].limit


def test_a_negation_shares_its_limit() -> None:
    clauses = Clauses(X)
    number = clauses.limited_clause(1, 0.5, True)
    assert number is not None
    other = clauses.negated(number)
    assert clauses.same_limit(number) == clauses.same_limit(other)
    assert clauses.bits[number] & clauses.bits[other] == 0


def test_an_oblique_clause_costs_more_than_one_on_a_column_alone() -> None:
    clauses = Clauses(X)
    axes, oblique = clauses.projections
    assert (axes, oblique) == (2, 8)
    plain, shifted = clauses.limited_clause(0, 0.5, True), clauses.limited_clause(axes, 0.5, True)
    assert plain is not None
    assert shifted is not None
    assert clauses.costs[shifted] > clauses.costs[plain]
    assert clauses.clauses[shifted].other >= 0


def test_an_oblique_clause_adds_the_second_column() -> None:
    clause = Clause(column=0, limit=0.5, above=True, other=1, slope=-0.5)
    assert holding((clause,), np.array([[1.0, 0.5], [1.0, 1.5]])).tolist() == [[True], [False]]


def test_rows_without_any_difference_have_no_clauses() -> None:
    assert Clauses(np.ones((4, 3))).clauses == []
    assert Clauses(np.ones((4, 3))).projections == (0, 0)


def test_bits_stand_at_their_places() -> None:
    assert as_bits(np.array([True, False, True, *[False] * 8, True])) == pytest.approx(0b100000000101)
