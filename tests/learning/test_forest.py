"""Boosted trees: what they learn, that weights count, and that one event is read as many are."""

from __future__ import annotations

import numpy as np
import pytest

from tests.learning.test_rule_lists import rows_of, world
from wakeful.learning.forest import Forest, ForestReader, ForestSettings, fit_forest

QUICK = ForestSettings(rounds=30)


def grown(seed: int = 1, n: int = 260) -> Forest:
    return fit_forest(rows_of(*world(n)), 4, seed, QUICK)


def test_trees_learn_conjunctions_and_limits() -> None:
    new, truth = world(1000, seed=1)
    assert float((ForestReader(grown()).logits_many(new).argmax(axis=1) == truth).mean()) > 0.93


def test_one_event_is_read_as_many_are() -> None:
    reader, (x, _) = ForestReader(grown()), world(50)
    assert np.allclose(reader.logits_many(x), np.array([reader.logits(row) for row in x]), atol=1e-9)


def test_the_same_seed_gives_the_same_trees() -> None:
    one, two = grown(1), grown(1)
    assert all(np.array_equal(getattr(one, name), getattr(two, name)) for name in ("column", "cut", "leaf", "base"))
    assert not np.array_equal(one.cut, grown(2).cut)


def test_a_rows_path_is_that_of_its_cuts() -> None:
    forest, (x, _) = grown(), world(20)
    reader = ForestReader(forest)
    for row in x[:5]:
        total = forest.base.copy()
        for tree in range(len(forest.leaf)):
            node = 0
            while node < forest.column.shape[1]:
                node = 2 * node + 1 + int(row[forest.column[tree, node]] > forest.cut[tree, node])
            total[tree % 4] += forest.leaf[tree, node - forest.column.shape[1]]
        assert reader.logits(row) == pytest.approx(total)


def test_events_that_nothing_tells_apart_get_the_shares_of_the_treatments() -> None:
    forest = fit_forest(rows_of(np.ones((30, 2)), np.arange(30) % 3 // 2), 3, 1, QUICK)
    logits = ForestReader(forest).logits(np.ones(2))
    assert logits[0] > logits[1] > logits[2]
    assert ForestReader(forest).logits_many(np.ones((2, 2))).shape == (2, 3)


def test_without_a_labelled_event_there_are_no_trees() -> None:
    x, _ = world(20)
    forest = fit_forest(rows_of(x, np.full(20, -1)), 4, 1, QUICK)
    assert ForestReader(forest).logits(x[0]) == pytest.approx(np.full(4, np.log(0.5)))


def test_a_heavier_event_counts_more() -> None:
    x = np.repeat([[0.0], [1.0]], 20, axis=0)
    y = np.arange(40) % 2
    weight = np.where(y == 1, 3.0, 1.0)
    plain, heavy = (ForestReader(fit_forest(rows_of(x, y, each), 2, 1, QUICK)) for each in (None, weight))
    assert heavy.logits(x[0])[1] - heavy.logits(x[0])[0] > plain.logits(x[0])[1] - plain.logits(x[0])[0] + 0.5
