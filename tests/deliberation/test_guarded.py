"""Limits around a reasoner of one's own."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable
from pathlib import Path

import pytest

from wakeful.contracts.reasoner import ReasonerError
from wakeful.deliberation.breaker import Breaker, Circuit, CircuitOpen
from wakeful.deliberation.budget import Budget, OverBudget, Spent
from wakeful.deliberation.cache import ReplyCache
from wakeful.deliberation.guarded import GuardedReasoner
from wakeful.deliberation.permit import Permit
from wakeful.deliberation.rate import RateLimit
from wakeful.deliberation.replies import Inadmissible
from wakeful.facts.asking import Question, Reply


class Own:
    """A user's reasoner."""

    name = "own"
    latency_s = 0.1

    def __init__(self, answer: Callable[[], Awaitable[Reply]]) -> None:
        self._answer = answer
        self.asked = 0

    async def answer(self, question: Question) -> Reply:
        self.asked += 1
        return await self._answer()


async def plan() -> Reply:
    return Reply(choice="planning", confidence=0.5, cost_usd=0.25)


async def misbehave() -> Reply:
    return Reply(choice="rm -rf /", confidence=0.5)


async def fail() -> Reply:
    raise ReasonerError("no")


async def hang() -> Reply:
    await asyncio.Event().wait()
    raise AssertionError


def permit(budget: Budget | None = None, failures: int = 2) -> Permit:
    return Permit(budget or Budget(None, None), RateLimit(None, lambda: 0.0), Breaker(failures, 1.0, lambda: 0.0))


def test_an_answer_is_charged_at_its_worst_and_settled_at_its_price(question: Question) -> None:
    budget = Budget(1.0, None)
    guarded = GuardedReasoner(Own(plan), permit(budget), deadline_s=5.0, worst_usd=0.75)
    assert asyncio.run(guarded.answer(question)).choice == "planning"
    assert budget.spent == Spent(1, 0.25)
    assert asyncio.run(guarded.answer(question)).choice == "planning"
    with pytest.raises(OverBudget):
        asyncio.run(guarded.answer(question))


def test_what_is_no_option_does_not_come_through(question: Question) -> None:
    with pytest.raises(Inadmissible):
        asyncio.run(GuardedReasoner(Own(misbehave), permit(), deadline_s=5.0).answer(question))


def test_failures_open_the_circuit(question: Question) -> None:
    gate, own = permit(failures=2), Own(fail)
    guarded = GuardedReasoner(own, gate, deadline_s=5.0)
    for _ in range(2):
        with pytest.raises(ReasonerError, match="no"):
            asyncio.run(guarded.answer(question))
    with pytest.raises(CircuitOpen):
        asyncio.run(guarded.answer(question))
    assert own.asked == 2


def test_silence_ends_at_the_deadline_and_counts_as_a_failure(question: Question) -> None:
    gate = permit(failures=1)
    with pytest.raises(ReasonerError, match=r"no answer from own within 0\.02 s"):
        asyncio.run(GuardedReasoner(Own(hang), gate, deadline_s=0.02).answer(question))
    assert gate.breaker.circuit is Circuit.OPEN


def test_a_kept_reply_is_not_asked_for_again(question: Question, tmp_path: Path) -> None:
    own = Own(plan)
    guarded = GuardedReasoner(own, permit(), deadline_s=5.0, cache=ReplyCache(tmp_path))
    first, second = asyncio.run(guarded.answer(question)), asyncio.run(guarded.answer(question))
    assert (own.asked, first.cost_usd, second.cost_usd, second.calls) == (1, 0.25, 0.0, 0)
