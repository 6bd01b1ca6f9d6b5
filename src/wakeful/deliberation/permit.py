"""The one gate before every call outside: circuit, rate, budget, in this order, each before the call is made."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager

from wakeful.deliberation.breaker import Breaker
from wakeful.deliberation.budget import Budget
from wakeful.deliberation.deadline import Deadline
from wakeful.deliberation.rate import RateLimit

Sleep = Callable[[float], Awaitable[None]]


class Fault(Exception):
    """Mixed into the errors of an endpoint that speak against the endpoint itself; the breaker counts these."""


class Intent:
    """One call that was allowed and charged. ``settle`` replaces its worst-case charge by its true price."""

    def __init__(self, budget: Budget, worst_usd: float) -> None:
        self._budget = budget
        self._charge = budget.charge(worst_usd)
        self.cost_usd = worst_usd

    def settle(self, actual_usd: float) -> None:
        """The call was answered and cost this much."""
        self._budget.settle(self._charge, actual_usd)
        self.cost_usd = actual_usd


class Permit:
    """Says whether the next call may be made, and learns how it ended.

    Args:
        budget: calls and money; charged when a call is intended.
        rate: calls a minute; waited for, within the deadline.
        breaker: told of every call's end.
        sleep: how to wait, in seconds.
    """

    def __init__(self, budget: Budget, rate: RateLimit, breaker: Breaker, sleep: Sleep = asyncio.sleep) -> None:
        self.budget = budget
        self.breaker = breaker
        self._rate = rate
        self._sleep = sleep

    @asynccontextmanager
    async def call(
        self, worst_usd: float, deadline: Deadline, faults: tuple[type[BaseException], ...] = (Fault,)
    ) -> AsyncIterator[Intent]:
        """Around one call: allowed and charged on entry, reported to the breaker on exit.

        Args:
            worst_usd: the most that the call can cost.
            deadline: the answer's; also how a call that it cut short is told from one that somebody cancelled.
            faults: the errors that speak against the endpoint.

        Raises:
            CircuitOpen, TooOften, OverBudget: the call may not be made. Nothing was charged.
        """
        self.breaker.check()
        wait_s = self._rate.reserve(deadline.remaining_s)
        if wait_s > 0:
            await self._sleep(wait_s)
        ticket = self.breaker.admit()
        report = self.breaker.withdrawn
        try:
            intent = Intent(self.budget, worst_usd)
            try:
                yield intent
                report = self.breaker.succeeded
            except faults:
                report = self.breaker.failed
                raise
            except asyncio.CancelledError:
                if deadline.passed:
                    report = self.breaker.failed
                raise
        finally:
            report(ticket)
