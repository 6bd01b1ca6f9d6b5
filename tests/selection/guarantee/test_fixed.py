"""The guarantee from one calibration set: as loose as the set is small, and kept."""

from __future__ import annotations

import numpy as np

from wakeful.selection.guarantee.bets import LEVELS
from wakeful.selection.guarantee.fixed import level_for
from wakeful.selection.guarantee.standing import NOTHING


def test_42_events_promise_nothing_at_five_percent_and_much_at_ten() -> None:
    scores, right = np.linspace(0.5, 1.0, 42), np.zeros(42, dtype=bool)
    assert level_for(scores, right, 0.05, 0.05) == NOTHING
    assert level_for(scores, right, 0.10, 0.05) == 0.0


def test_a_looser_level_is_not_looked_at_behind_one_that_failed() -> None:
    scores = np.concatenate([np.full(30, 0.995), np.full(170, 0.95)])
    wrong = np.zeros(200, dtype=bool)
    wrong[:10] = True
    assert level_for(scores, wrong, 0.05, 0.05) == NOTHING
    wrong[:10], wrong[30:40] = False, True
    assert level_for(scores, wrong, 0.05, 0.05) == 0.96


def test_over_many_calibration_sets_the_true_risk_is_above_alpha_no_more_often_than_delta() -> None:
    random = np.random.default_rng(3)
    grid = np.sort(random.random(20_000))
    above = 0
    for _ in range(1500):
        scores = random.random(300)
        wrong = random.random(300) < 0.5 * (1 - scores)
        level = level_for(scores, wrong, 0.05, 0.1)
        above += float((0.5 * (1 - grid) * (grid >= level)).mean()) > 0.05
    assert 0 < above / 1500 <= 0.1
    assert level_for(np.array([]), np.array([], dtype=bool), 0.05, 0.1) == NOTHING
    assert LEVELS[0] < NOTHING
