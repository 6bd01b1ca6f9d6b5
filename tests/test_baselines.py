"""What the learning benchmark compares with must itself be right."""

from __future__ import annotations

import numpy as np

from benchmarks.baselines import BaseRate, LogisticRegression, softmax


def test_logistic_regression_recovers_the_rule_that_made_the_data() -> None:
    random = np.random.default_rng(0)
    x = random.normal(size=(3000, 4))
    rule = np.array([[2.0, 0.0, -2.0], [0.0, 1.0, -1.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
    y = np.array([random.choice(3, p=row) for row in softmax(x @ rule)])
    fitted = LogisticRegression(3)
    fitted.fit(x, y)
    test = random.normal(size=(500, 4))
    agreed = np.mean([fitted.predict(row) == best for row, best in zip(test, (test @ rule).argmax(axis=1), strict=True)])
    assert agreed > 0.95


def test_logistic_regression_is_at_the_minimum_of_its_penalised_loss() -> None:
    random = np.random.default_rng(1)
    x, y = random.normal(size=(120, 5)), random.integers(0, 3, 120)
    fitted = LogisticRegression(3, c=0.5, steps=3000)
    fitted.fit(x, y)
    assert fitted._weights is not None
    rows = np.hstack([(x - x.mean(axis=0)) / x.std(axis=0), np.ones((120, 1))])
    slope = rows.T @ (softmax(rows @ fitted._weights) - np.eye(3)[y])
    slope[:-1] += fitted._weights[:-1] / 0.5
    assert np.abs(slope).max() < 1e-6


def test_the_base_rate_is_the_most_frequent_outcome_of_all_or_of_the_last() -> None:
    outcome = np.array([0, 0, 0, 1, 1])
    everything, latest = BaseRate(2), BaseRate(2, last=2)
    for each in (everything, latest):
        each.fit(np.zeros((5, 1)), outcome)
    assert (everything.predict(np.zeros(1)), latest.predict(np.zeros(1))) == (0, 1)
