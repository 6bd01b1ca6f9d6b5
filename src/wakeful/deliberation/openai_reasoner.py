"""Explicit deliberation by a language model behind any OpenAI-compatible endpoint."""

from __future__ import annotations

import asyncio
from collections.abc import Mapping

import msgspec

from wakeful.contracts.reasoner import ReasonerError
from wakeful.deliberation.backoff import Backoff
from wakeful.deliberation.cache import ReplyCache, digest
from wakeful.deliberation.deadline import Deadline
from wakeful.deliberation.endpoint import Completion, Endpoint, Turn, Unavailable
from wakeful.deliberation.permit import Permit, Sleep
from wakeful.deliberation.prompt import Prompt, build, clean
from wakeful.deliberation.replies import Inadmissible, check, read, reply_schema
from wakeful.deliberation.settings import ReasonerSettings
from wakeful.facts.asking import Question, Reply
from wakeful.facts.domain import DomainSpec
from wakeful.facts.values import Value

_PER_MILLION = 1_000_000
_REPAIR_CHARS = 2_000


class _Tally:
    """What one answer has taken so far."""

    def __init__(self) -> None:
        self.calls = 0
        self.cost_usd = 0.0


class OpenAIReasoner:
    """Asks a model, at temperature 0, and lets through only what the question admits.

    Each call is checked against circuit, rate and budget before it is made. One deadline is around all of an answer: calls,
    retries, waits and the one repair, in which the model is shown what was wrong with its answer.

    Args:
        spec: the domain, whose guidelines the model is shown.
        settings: model, prices, limits.
        endpoint: where the calls go.
        permit: the gate before each call; shared by reasoners that share a budget.
        cache: where replies are kept, or None.
        meanings: one sentence for each option that has one, such as a treatment's ``says``.
        sleep: how to wait between tries, in seconds.
    """

    name = "openai"

    def __init__(
        self,
        spec: DomainSpec,
        settings: ReasonerSettings,
        endpoint: Endpoint,
        permit: Permit,
        cache: ReplyCache | None = None,
        meanings: Mapping[str, str] | None = None,
        sleep: Sleep = asyncio.sleep,
    ) -> None:
        self.latency_s = settings.latency_s
        self._spec = spec
        self._settings = settings
        self._endpoint = endpoint
        self._permit = permit
        self._cache = cache
        self._meanings = dict(meanings or {})
        self._sleep = sleep
        self._backoff = Backoff(settings.backoff_s, settings.backoff_limit_s, settings.seed)

    def describe(self) -> str:
        """One line on who answers and within which limits."""
        chosen = self._settings
        return f"{chosen.model} at {chosen.base_url or 'the default endpoint'}, within {chosen.deadline_s:g} s an answer"

    async def answer(self, question: Question) -> Reply:
        """One answer, from the cache where it is there.

        Raises:
            ReasonerError: no admissible answer: refused before a call (circuit, rate, budget), unavailable, out of time, or
                inadmissible twice. It carries the calls and the cost that were spent all the same.
        """
        tally = _Tally()
        try:
            async with Deadline(self._settings.deadline_s) as deadline:
                return await self._answer(question, deadline, tally)
        except TimeoutError:
            error = ReasonerError(f"no answer from {self._settings.model} within {self._settings.deadline_s:g} s")
            error.calls, error.cost_usd = tally.calls, tally.cost_usd
            raise error from None
        except ReasonerError as error:
            error.calls, error.cost_usd = tally.calls, tally.cost_usd
            raise

    async def _answer(self, question: Question, deadline: Deadline, tally: _Tally) -> Reply:
        if not question.options:
            raise ReasonerError("the question has no options to choose from")
        prompt = build(question, self._spec, self._meanings)
        if len(prompt.system) + len(prompt.user) > self._settings.max_prompt_chars:
            raise ReasonerError(
                f"the prompt of {len(prompt.system) + len(prompt.user)} characters is longer than "
                f"{self._settings.max_prompt_chars}; ask less, or raise WAKEFUL_MAX_PROMPT_CHARS"
            )
        name = digest(
            self._settings.base_url or "", self._settings.model, self._settings.response_format, prompt.system, prompt.user
        )
        kept = self._cache.get(name) if self._cache else None
        if kept is not None:
            try:
                return check(kept, question)
            except Inadmissible:
                kept = None
        reply = await self._ask(question, prompt, deadline, tally)
        if self._cache:
            self._cache.put(name, reply)
        return reply

    async def _ask(self, question: Question, prompt: Prompt, deadline: Deadline, tally: _Tally) -> Reply:
        turns = [Turn("system", prompt.system), Turn("user", prompt.user)]
        first = await self._complete(turns, question, deadline, tally)
        try:
            reply = _read(first, question)
        except Inadmissible as wrong:
            turns += [Turn("assistant", clean(first.text, _REPAIR_CHARS) or "(nothing)"), Turn("user", _repair(wrong))]
            reply = _read(await self._complete(turns, question, deadline, tally), question)
        return msgspec.structs.replace(reply, reasoner=self.name, cost_usd=tally.cost_usd, calls=tally.calls)

    async def _complete(self, turns: list[Turn], question: Question, deadline: Deadline, tally: _Tally) -> Completion:
        chosen = self._settings
        most_tokens = sum(len(turn.content.encode()) + 64 for turn in turns)  # a token is at least one byte
        worst_usd = self._price(most_tokens, chosen.max_answer_tokens)
        for failures in range(chosen.tries):
            try:
                async with self._permit.call(worst_usd, deadline) as intent:
                    tally.calls += 1
                    tally.cost_usd += worst_usd
                    completion = await self._endpoint.complete(turns, self._format(question))
                    if completion.prompt_tokens is not None and completion.completion_tokens is not None:
                        intent.settle(self._price(completion.prompt_tokens, completion.completion_tokens))
                        tally.cost_usd += intent.cost_usd - worst_usd
                return completion
            except Unavailable as error:
                wait_s = self._backoff.wait_s(failures, error.retry_after_s)
                if not error.again or failures + 1 == chosen.tries:
                    raise
                if wait_s >= deadline.remaining_s:
                    raise Unavailable(
                        f"{error} (it is to be left alone for {wait_s:.1f} s, longer than the answer may take)"
                    ) from error
                await self._sleep(wait_s)
        raise ReasonerError("WAKEFUL_TRIES must be at least 1")

    def _price(self, prompt_tokens: int, answer_tokens: int) -> float:
        chosen = self._settings
        bought = max(0, prompt_tokens) * chosen.price_in_usd_per_m + max(0, answer_tokens) * chosen.price_out_usd_per_m
        return bought / _PER_MILLION

    def _format(self, question: Question) -> dict[str, Value]:
        if self._settings.response_format == "json_object":
            return {"type": "json_object"}
        return {"type": "json_schema", "json_schema": {"name": "reply", "strict": True, "schema": reply_schema(question)}}


def _read(completion: Completion, question: Question) -> Reply:
    try:
        return read(completion.text, question)
    except Inadmissible as wrong:
        if completion.finish == "length":
            raise Inadmissible("the answer broke off at its longest; be shorter") from wrong
        raise


def _repair(wrong: Inadmissible) -> str:
    return f"That cannot be used: {clean(str(wrong), 400)}. Answer the same question again, with one JSON object as asked for."
