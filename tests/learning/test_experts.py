"""Pooling: the better expert gets the weight, few rows move little."""

from __future__ import annotations

import numpy as np
import pytest

from wakeful.learning.experts import LEAST, logs_of, pooled, weigh
from wakeful.learning.material import Floats, Ints

PRIOR = np.array([0.5, 0.5])


def experts(n: int) -> tuple[Floats, Ints]:
    """The first knows, with 0.9; the second guesses at random, as sure of it."""
    random = np.random.default_rng(0)
    label = random.integers(0, 3, n)
    guess = random.integers(0, 3, n)
    shares = np.full((2, n, 3), 0.05)
    shares[0, np.arange(n), label] = 0.9
    shares[1, np.arange(n), guess] = 0.9
    return logs_of(shares), label


def test_who_foretold_better_weighs_more() -> None:
    logs, label = experts(200)
    weights = weigh(logs, label, np.ones(200), PRIOR, 1.0)
    assert weights[0] > 0.8
    assert weights[1] < 0.25


def test_a_few_rows_leave_the_prior_almost_as_it_is() -> None:
    logs, label = experts(3)
    assert weigh(logs, label, np.ones(3), PRIOR, 100.0) == pytest.approx(PRIOR, abs=0.05)


def test_without_a_labelled_row_the_prior_stands() -> None:
    logs, label = experts(5)
    assert weigh(logs, np.full(5, -1), np.ones(5), PRIOR, 1.0) is PRIOR
    assert weigh(logs, label, np.zeros(5), PRIOR, 1.0) is PRIOR


def test_the_pool_of_equal_experts_with_weights_that_add_up_to_one_is_that_expert() -> None:
    shares = np.array([[0.7, 0.2, 0.1]])
    assert pooled(logs_of(np.stack([shares, shares])), np.array([0.3, 0.7])) == pytest.approx(shares)


def test_no_expert_alone_can_rule_anything_out() -> None:
    sure = logs_of(np.array([[1.0, 0.0], [0.5, 0.5]])[:, None, :])
    assert pooled(sure, np.array([1.0, 1.0]))[0, 1] == pytest.approx(LEAST, rel=0.01)


def test_weights_never_fall_below_zero() -> None:
    logs, label = experts(300)
    worse = np.stack([logs[0], np.roll(logs[0], 1, axis=1)])
    assert (weigh(worse, label, np.ones(300), PRIOR, 0.1) >= 0.0).all()
