"""Limits around any reasoner: a deadline, the gate before each answer, and a cache."""

from __future__ import annotations

import msgspec

from wakeful.contracts.reasoner import Reasoner, ReasonerError
from wakeful.deliberation.cache import ReplyCache, digest
from wakeful.deliberation.deadline import Deadline
from wakeful.deliberation.permit import Intent, Permit
from wakeful.deliberation.replies import Inadmissible, check
from wakeful.facts.asking import Question, Reply


class GuardedReasoner:
    """A reasoner of your own within the limits that the openai reasoner has: one answer counts as one call.

    What it says is checked against the question, so that a reasoner without checks of its own cannot name an option that is none.

    Args:
        inner: who answers.
        permit: circuit, rate and budget, checked before each answer.
        deadline_s: how long one answer may take, waits included.
        worst_usd: the most that one answer can cost.
        cache: where replies are kept, or None. Its key is the inner reasoner's name and the whole question: share a folder
            only among reasoners that answer alike.
    """

    def __init__(
        self, inner: Reasoner, permit: Permit, *, deadline_s: float, worst_usd: float = 0.0, cache: ReplyCache | None = None
    ) -> None:
        self.name = inner.name
        self.latency_s = inner.latency_s
        self._inner = inner
        self._permit = permit
        self._deadline_s = deadline_s
        self._worst_usd = worst_usd
        self._cache = cache

    async def answer(self, question: Question) -> Reply:
        """One admissible answer.

        Raises:
            ReasonerError: refused before the call (circuit, rate, budget), out of time, inadmissible, or its own.
        """
        name = digest("guarded", self._inner.name, msgspec.json.encode(question, order="sorted").decode())
        kept = self._cache.get(name) if self._cache else None
        if kept is not None:
            try:
                return check(kept, question)
            except Inadmissible:
                kept = None
        try:
            async with (
                Deadline(self._deadline_s) as deadline,
                self._permit.call(self._worst_usd, deadline, faults=(ReasonerError,)) as intent,
            ):
                reply = await self._asked(question, intent)
        except TimeoutError:
            raise ReasonerError(f"no answer from {self.name} within {self._deadline_s:g} s") from None
        try:
            reply = check(reply, question)
        except ReasonerError as error:
            error.calls, error.cost_usd = reply.calls, reply.cost_usd  # it is paid for all the same
            raise
        if self._cache:
            self._cache.put(name, reply)
        return reply

    async def _asked(self, question: Question, intent: Intent) -> Reply:
        """The inner reasoner's answer; an error tells of the one call that was charged for it."""
        try:
            reply = await self._inner.answer(question)
        except ReasonerError as error:
            error.calls, error.cost_usd = 1, intent.cost_usd
            raise
        intent.settle(reply.cost_usd)
        return msgspec.structs.replace(reply, calls=1)
