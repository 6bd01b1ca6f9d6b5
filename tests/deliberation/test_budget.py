"""The budget: charged when intended, never exceeded by one call, by any number of threads."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import pytest
from hypothesis import given
from hypothesis import strategies as st

from wakeful.deliberation.budget import Budget, OverBudget, Spent


def test_a_call_that_could_pass_the_limit_is_refused_and_not_charged() -> None:
    budget = Budget(max_usd=0.01, max_calls=None)
    budget.charge(0.006)
    with pytest.raises(OverBudget, match="WAKEFUL_MAX_USD"):
        budget.charge(0.005)
    assert budget.spent == Spent(1, 0.006)


def test_a_settled_call_gives_back_what_it_did_not_cost() -> None:
    budget = Budget(max_usd=0.01, max_calls=None)
    budget.settle(budget.charge(0.01), 0.001)
    budget.charge(0.009)
    assert budget.spent == Spent(2, 0.01)


def test_a_call_is_settled_once() -> None:
    budget = Budget(max_usd=1.0, max_calls=None)
    charge = budget.charge(0.5)
    budget.settle(charge, 0.25)
    budget.settle(charge, 0.0)
    assert budget.spent.usd == 0.25


def test_a_negative_price_gives_no_money_back() -> None:
    budget = Budget(max_usd=1.0, max_calls=None)
    budget.settle(budget.charge(-5.0), -5.0)
    assert budget.spent.usd == 0.0


def test_what_an_earlier_run_spent_counts() -> None:
    budget = Budget(max_usd=1.0, max_calls=10, spent=Spent(10, 0.2))
    with pytest.raises(OverBudget, match="10 reasoner calls"):
        budget.charge(0.0)


def test_a_budget_of_no_calls_allows_none() -> None:
    with pytest.raises(OverBudget):
        Budget(max_usd=None, max_calls=0).charge(0.0)


def test_threads_together_stay_within_both_limits() -> None:
    budget = Budget(max_usd=0.5, max_calls=400)

    def spend(_: int) -> int:
        made = 0
        for _ in range(100):
            try:
                budget.settle(budget.charge(0.002), 0.001)
                made += 1
            except OverBudget:
                pass
        return made

    with ThreadPoolExecutor(8) as pool:
        made = sum(pool.map(spend, range(8)))
    assert made == 400
    assert budget.spent == Spent(400, 0.4)


@given(
    st.lists(st.tuples(st.floats(0, 0.02), st.floats(0, 1), st.booleans()), max_size=60),
    st.floats(0, 0.1),
    st.integers(0, 40),
)
def test_no_order_of_charges_and_settlements_passes_a_limit(
    calls: list[tuple[float, float, bool]], max_usd: float, max_calls: int
) -> None:
    budget = Budget(max_usd, max_calls)
    truly_usd, made = 0.0, 0
    for worst_usd, share, settled in calls:
        try:
            charge = budget.charge(worst_usd)
        except OverBudget:
            continue
        made += 1
        truly_usd += worst_usd * share
        if settled:
            budget.settle(charge, worst_usd * share)
        assert budget.spent.usd <= max_usd + 1e-9
    assert truly_usd <= max_usd + 1e-9
    assert made == budget.spent.calls <= max_calls
