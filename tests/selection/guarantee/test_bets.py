"""Bets against a risk: that they are fair is computed, that they hold at every time is measured."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from wakeful.selection.guarantee.bets import LEVELS, SHARES, WEIGHTS, Tally, place_of

TRUE, FALSE = np.array(True), np.array(False)


def told(errors: int, quiet: int, probability: float = 1.0, place: int = 0) -> Tally:
    tally = Tally()
    for count, wrong in ((errors, TRUE), (quiet, FALSE)):
        for _ in range(count):
            tally.count(np.array(place), wrong, probability)
    return tally


@given(st.floats(0.01, 0.5), st.sampled_from([1.0, 0.5, 0.2, 0.05]), st.integers(0, 3), st.integers(0, 30))
def test_a_bet_gains_nothing_on_average_where_the_risk_is_what_the_doubter_says(
    risk: float, probability: float, errors: int, quiet: int
) -> None:
    now = float(np.exp(told(errors, quiet).log_capital(risk)[0]))
    after_error, after_none = told(errors, quiet), told(errors, quiet)
    after_error.count(np.array(0), TRUE, probability)
    after_none.count(np.array(0), FALSE, probability)
    shown = risk * probability  # an error shows itself where it is drawn
    mean = shown * math.exp(after_error.log_capital(risk)[0]) + (1 - shown) * math.exp(after_none.log_capital(risk)[0])
    assert mean == pytest.approx(now, rel=1e-9)


def test_the_capital_is_the_weighted_sum_of_its_shares() -> None:
    expected = sum(
        weight * (1 - share) ** 2 * (1 + share * 0.05 / 0.95) ** 30 for share, weight in zip(SHARES, WEIGHTS, strict=True)
    )
    assert math.exp(told(2, 30).log_capital(0.05)[0]) == pytest.approx(expected)
    assert sum(WEIGHTS) == pytest.approx(1.0)


def test_only_at_levels_that_the_score_reaches_can_an_event_be_an_error() -> None:
    place = int(place_of(0.93))
    assert LEVELS[place] <= 0.93 < LEVELS[place - 1]
    tally = told(1, 0, place=place)
    assert tally.errors[:place].sum() == 0
    assert (tally.errors[place:] == 1).all()
    assert (tally.quiet[1.0][:place] == 1).all()
    assert int(place_of(1.0)) == 0
    assert int(place_of(0.99)) == 0
    assert LEVELS[int(place_of(0.0))] == 0.0


def test_many_treatments_side_by_side_count_as_each_would_alone() -> None:
    random = np.random.default_rng(0)
    side_by_side, alone = Tally((5,)), [Tally() for _ in range(5)]
    for _ in range(200):
        place, wrong, where = random.integers(0, 17, 5), random.random(5) < 0.1, random.random(5) < 0.7
        side_by_side.count(place, wrong, 0.2, where)
        for each in np.flatnonzero(where):
            alone[each].count(place[each], wrong[each], 0.2)
    for each, one in enumerate(alone):
        assert side_by_side.log_capital(0.05)[each] == pytest.approx(one.log_capital(0.05))
        assert side_by_side.bound(0.05)[each] == pytest.approx(one.bound(0.05))


def test_the_bound_is_the_least_risk_that_is_refuted_and_tightens_with_experience() -> None:
    bounds = [float(told(0, quiet).bound(0.05)[0]) for quiet in (10, 42, 73, 200, 1000)]
    assert bounds == sorted(bounds, reverse=True)
    assert bounds[1] > 0.05 > bounds[2]
    assert bounds[-1] < 0.006
    assert float(told(3, 500).log_capital(float(told(3, 500).bound(0.05)[0]))[0]) == pytest.approx(math.log(20), abs=1e-6)


@pytest.mark.parametrize("errors", [0, 1, 4])
def test_so_many_more_events_are_needed_and_not_one_less(errors: int) -> None:
    needed = told(errors, 20).more_needed(0, 0.05, 0.05)
    limit = math.log(20)
    assert told(errors, 20 + needed).log_capital(0.05)[0] >= limit > told(errors, 19 + needed).log_capital(0.05)[0]
    assert told(errors, 20 + needed).more_needed(0, 0.05, 0.05) == 0


@pytest.mark.parametrize("probability", [1.0, 0.2])
def test_looked_at_after_every_event_a_risk_of_alpha_is_hardly_ever_refuted(probability: float) -> None:
    random = np.random.default_rng(11)
    runs, alpha, delta = 3000, 0.05, 0.05
    tally, ever, strictest = Tally((runs,)), np.zeros(runs, dtype=bool), np.zeros(runs, dtype=np.int64)
    for _ in range(700):
        wrong = (random.random(runs) < alpha) & (random.random(runs) < probability)
        tally.count(strictest, wrong, probability)
        ever |= tally.log_capital(alpha, strictest) >= -math.log(delta)
    share = float(ever.mean())
    assert 0.0 < share <= delta
