"""The gate before each call: in order, and with nothing taken by a call that was refused."""

from __future__ import annotations

import asyncio

import pytest

from wakeful.deliberation.breaker import Breaker, Circuit, CircuitOpen
from wakeful.deliberation.budget import Budget, OverBudget, Spent
from wakeful.deliberation.deadline import Deadline
from wakeful.deliberation.permit import Fault, Permit
from wakeful.deliberation.rate import RateLimit


class Gate:
    def __init__(self, max_calls: int | None = None, per_minute: int | None = None) -> None:
        self.now_s = 0.0
        self.budget = Budget(1.0, max_calls)
        self.breaker = Breaker(1, 10.0, lambda: self.now_s)
        self.permit = Permit(self.budget, RateLimit(per_minute, lambda: self.now_s), self.breaker, self.sleep)

    async def sleep(self, seconds: float) -> None:
        self.now_s += seconds

    def call(self, error: BaseException | None = None, deadline_s: float = 100.0) -> None:
        async def main() -> None:
            async with Deadline(deadline_s) as deadline, self.permit.call(0.1, deadline) as intent:
                if error is not None:
                    raise error
                intent.settle(0.01)

        asyncio.run(main())


def test_a_call_is_charged_on_entry_and_settled_inside() -> None:
    gate = Gate()
    gate.call()
    assert gate.budget.spent == Spent(1, 0.01)


def test_a_fault_keeps_the_worst_charge_and_opens_the_circuit() -> None:
    gate = Gate()
    with pytest.raises(Fault):
        gate.call(Fault())
    assert gate.budget.spent == Spent(1, 0.1)
    assert gate.breaker.circuit is Circuit.OPEN


def test_another_error_leaves_the_circuit_as_it_was() -> None:
    gate = Gate()
    with pytest.raises(KeyError):
        gate.call(KeyError())
    assert gate.breaker.circuit is Circuit.CLOSED


def test_an_open_circuit_takes_neither_money_nor_a_place_in_the_minute() -> None:
    gate = Gate(per_minute=2)
    with pytest.raises(Fault):
        gate.call(Fault())
    for _ in range(5):
        with pytest.raises(CircuitOpen):
            gate.call()
    gate.now_s = 10.0
    gate.call()
    assert gate.now_s == 10.0, "the second place of the minute was still free"
    assert gate.budget.spent.calls == 2


def test_a_trial_that_the_budget_refuses_does_not_block_the_next_trial() -> None:
    gate = Gate(max_calls=1)
    with pytest.raises(Fault):
        gate.call(Fault())
    gate.now_s = 10.0
    for _ in range(3):
        with pytest.raises(OverBudget):
            gate.call()


def test_waiting_for_the_rate_comes_before_the_charge() -> None:
    gate = Gate(per_minute=1)
    gate.call()
    gate.call()
    assert gate.now_s == 60.0
