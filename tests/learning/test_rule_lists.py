"""Decision lists: that they find the rules that are there, share limits, and read one event as they read many."""

from __future__ import annotations

import numpy as np
import pytest

from wakeful.learning.material import Floats, Ints, Material
from wakeful.learning.rule_lists import RuleReader, fit_rules
from wakeful.learning.rule_search import SearchSettings

QUICK = SearchSettings(chains=2, steps=250, steps_again=80)


def rows_of(x: Floats, y: Ints, weight: Floats | None = None) -> Material:
    none, ones = np.full(len(x), -1), np.ones(len(x))
    return Material(x=x, treatment=y, result=none, refuted=none, weight=ones if weight is None else weight, result_weight=ones)


def world(n: int = 260, seed: int = 0) -> tuple[Floats, Ints]:
    """Ten yes-or-no columns and three numbers: first by a conjunction, then by a limit in either of two places, else 0."""
    random = np.random.default_rng(seed)
    x = np.column_stack([random.integers(0, 2, (n, 10)), random.random((n, 3))]).astype(np.float64)
    y = np.where((x[:, 0] > 0) & (x[:, 1] > 0), 1, np.where((x[:, 10] > 0.6) & (x[:, 2] > 0), 2, 0))
    y = np.where((y == 0) & (x[:, 10] > 0.6) & (x[:, 3] > 0), 3, y)
    return x, y


def accuracy(reader: RuleReader, x: Floats, y: Ints) -> float:
    return float((reader.shares_many(x).argmax(axis=1) == y).mean())


def test_rules_of_two_conditions_are_found_from_a_few_hundred_events() -> None:
    x, y = world()
    _, lists = fit_rules(rows_of(x, y), np.zeros(len(x), dtype=np.bool_), 4, 1, QUICK)
    new, truth = world(1000, seed=1)
    assert accuracy(RuleReader(lists), new, truth) > 0.97


def test_one_event_is_read_as_many_are() -> None:
    x, y = world()
    _, lists = fit_rules(rows_of(x, y), np.zeros(len(x), dtype=np.bool_), 4, 1, QUICK)
    reader, again = RuleReader(lists), RuleReader(lists)
    assert np.array_equal(reader.shares_many(x[:50]), np.array([again.shares(row) for row in x[:50]]))
    assert reader.shares_many(x).sum(axis=1) == pytest.approx(np.ones(len(x)), abs=1e-6)


def test_a_rule_that_speaks_asks_for_clauses_that_hold() -> None:
    x, y = world()
    _, lists = fit_rules(rows_of(x, y), np.zeros(len(x), dtype=np.bool_), 4, 1, QUICK)
    spoken = RuleReader(lists).speaking(x[0])
    assert len(spoken) == len(lists.lists)
    flat = [rule for rules in lists.lists for rule in (*rules, ())]
    for place in spoken:
        for clause in (lists.clauses[number] for number in flat[place]):
            value = x[0, clause.column] + clause.slope * x[0, max(0, clause.other)]
            assert (value > clause.limit) == clause.above


def test_the_same_seed_gives_the_same_lists() -> None:
    x, y = world(120)
    held_back = np.arange(120) % 4 == 0
    one, two, other = (fit_rules(rows_of(x, y), held_back, 4, seed, QUICK) for seed in (1, 1, 2))
    for first, second in zip(one, two, strict=True):
        assert (first.clauses, first.lists, first.say) == (second.clauses, second.lists, second.say)
        assert np.array_equal(first.spoken, second.spoken)
    assert other[0].lists != one[0].lists


def test_the_tested_lists_have_not_seen_what_was_held_back() -> None:
    x, y = world(200)
    held_back = np.arange(200) >= 150
    lied = y.copy()
    lied[held_back] = 3 - y[held_back]
    honest, _ = fit_rules(rows_of(x, y), held_back, 4, 1, QUICK)
    fooled, _ = fit_rules(rows_of(x, lied), held_back, 4, 1, QUICK)
    assert (honest.lists, honest.clauses) == (fooled.lists, fooled.clauses)


def test_the_published_lists_have_learned_from_all() -> None:
    x, y = world(240)
    held_back = np.arange(240) >= 40
    tested, whole = fit_rules(rows_of(x, y), held_back, 4, 1, QUICK)
    new, truth = world(1000, seed=1)
    assert accuracy(RuleReader(whole), new, truth) > accuracy(RuleReader(tested), new, truth)


def test_without_a_labelled_event_all_treatments_are_equally_likely() -> None:
    x, _ = world(20)
    tested, whole = fit_rules(rows_of(x, np.full(20, -1)), np.zeros(20, dtype=np.bool_), 4, 1, QUICK)
    for lists in (tested, whole):
        assert RuleReader(lists).shares(x[0]).tolist() == [0.25] * 4


def test_a_heavier_event_counts_more() -> None:
    x = np.array([[0.0], [0.0], [0.0], [1.0], [1.0], [1.0]])
    y = np.array([0, 0, 1, 1, 1, 0])
    heavy = np.array([1.0, 1.0, 3.0, 1.0, 1.0, 1.0])
    _, plain = fit_rules(rows_of(x, y), np.zeros(6, dtype=np.bool_), 2, 1, QUICK)
    _, weighed = fit_rules(rows_of(x, y, heavy), np.zeros(6, dtype=np.bool_), 2, 1, QUICK)
    assert RuleReader(weighed).shares(x[0])[1] > RuleReader(plain).shares(x[0])[1]


def test_events_that_nothing_tells_apart_are_spoken_for_by_the_last_resort() -> None:
    _, lists = fit_rules(rows_of(np.ones((10, 2)), np.arange(10) % 2), np.zeros(10, dtype=np.bool_), 2, 1, QUICK)
    assert RuleReader(lists).shares(np.ones(2)) == pytest.approx([0.5, 0.5], abs=1e-6)
