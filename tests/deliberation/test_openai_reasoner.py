"""The openai reasoner against a real HTTP server on loopback: what it sends, what it lets through, what it survives."""

from __future__ import annotations

import asyncio
import json
from collections.abc import Awaitable, Callable, Mapping, Sequence
from typing import Any

import msgspec
import pytest

from wakeful.contracts.reasoner import ReasonerError
from wakeful.deliberation.breaker import Breaker, Circuit, CircuitOpen
from wakeful.deliberation.budget import Budget, OverBudget, Spent
from wakeful.deliberation.cache import ReplyCache
from wakeful.deliberation.endpoint import Completion, Rejected, Turn, Unavailable
from wakeful.deliberation.openai_reasoner import OpenAIReasoner
from wakeful.deliberation.permit import Permit
from wakeful.deliberation.rate import RateLimit, TooOften
from wakeful.deliberation.replies import Inadmissible
from wakeful.deliberation.sdk import SdkEndpoint
from wakeful.deliberation.settings import ReasonerSettings
from wakeful.facts.asking import Question, Reply
from wakeful.facts.domain import DomainSpec
from wakeful.facts.values import Value


class Clock:
    """Virtual seconds; ``sleep`` moves them on at once and remembers what was slept."""

    def __init__(self) -> None:
        self.now_s = 0.0
        self.slept: list[float] = []

    def __call__(self) -> float:
        return self.now_s

    async def sleep(self, seconds: float) -> None:
        self.slept.append(seconds)
        self.now_s += seconds


class Bench:
    """A reasoner wired to a server, with everything around it in view."""

    def __init__(self, url: str, spec: DomainSpec, settings: ReasonerSettings, cache: ReplyCache | None = None) -> None:
        self.settings = msgspec.structs.replace(settings, base_url=url)
        self.clock = Clock()
        self.budget = Budget(settings.max_usd, settings.max_calls)
        self.breaker = Breaker(settings.breaker_failures, settings.breaker_pause_s, self.clock)
        self.endpoint = SdkEndpoint(
            base_url=url,
            api_key=settings.api_key.reveal(),
            model=settings.model,
            max_answer_bytes=settings.max_answer_bytes,
            max_answer_tokens=settings.max_answer_tokens,
        )
        rate = RateLimit(settings.calls_per_minute, self.clock)
        self.reasoner = OpenAIReasoner(
            spec,
            self.settings,
            self.endpoint,
            Permit(self.budget, rate, self.breaker, self.clock.sleep),
            cache,
            sleep=self.clock.sleep,
        )


@pytest.fixture
def ask(http: Any, spec: DomainSpec, settings: ReasonerSettings) -> Callable[..., Any]:
    """Run ``use(bench, server)`` against a server of these behaviours; by default ask one question and return the reply."""

    def run(
        *behaviours: Any, use: Callable[[Bench, Any], Awaitable[Any]], cache: ReplyCache | None = None, **changes: Any
    ) -> Any:
        async def main() -> Any:
            async with http.server(*behaviours) as server:
                bench = Bench(server.url, spec, msgspec.structs.replace(settings, **changes), cache)
                try:
                    return await use(bench, server)
                finally:
                    await bench.endpoint.close()

        return asyncio.run(main())

    return run


def test_a_good_answer_becomes_a_reply_with_its_cost(ask: Any, http: Any, good: Any, question: Question) -> None:
    async def use(bench: Bench, server: Any) -> tuple[Reply, Spent]:
        return await bench.reasoner.answer(question), bench.budget.spent

    reply, spent = ask(http.says(good, usage=(1000, 100)), use=use, price_in_usd_per_m=1.0, price_out_usd_per_m=10.0)
    assert (reply.choice, reply.forecast, reply.confidence, reply.reasoner) == ("planning", "none", 0.8, "openai")
    assert reply.because == ("The route is blocked.",)
    assert reply.calls == 1
    assert reply.cost_usd == pytest.approx(0.002)
    assert spent == Spent(1, 0.002)


def test_the_request_asks_for_json_at_temperature_0_and_bounds_the_answer(
    ask: Any, http: Any, good: Any, question: Question
) -> None:
    async def use(bench: Bench, server: Any) -> Any:
        await bench.reasoner.answer(question)
        return server

    server = ask(http.says(good), use=use, max_answer_tokens=321)
    sent = server.requests[0]
    assert server.heads == ["POST /v1/chat/completions HTTP/1.1"]
    assert sent["model"] == "deepseek-v4-flash"
    assert sent["temperature"] == 0
    assert sent["response_format"] == {"type": "json_object"}
    assert sent["max_tokens"] == 321
    assert [turn["role"] for turn in sent["messages"]] == ["system", "user"]
    assert "tools" not in sent
    assert server.headers[0]["authorization"] == "Bearer sk-not-a-real-key-0123456789"


def test_the_key_is_sent_in_its_header_and_nowhere_else(ask: Any, http: Any, good: Any, question: Question) -> None:
    async def use(bench: Bench, server: Any) -> Any:
        return await bench.reasoner.answer(question), server, repr(bench.settings), bench.reasoner.describe()

    reply, server, shown, described = ask(http.says(good), use=use)
    for text in (json.dumps(server.requests), repr(reply), shown, described):
        assert "sk-not-a-real-key" not in text


def test_a_schema_is_sent_where_the_endpoint_takes_one(ask: Any, http: Any, good: Any, question: Question) -> None:
    async def use(bench: Bench, server: Any) -> Any:
        await bench.reasoner.answer(question)
        return server.requests[0]["response_format"]

    sent = ask(http.says(good), use=use, response_format="json_schema")
    assert sent["type"] == "json_schema"
    properties = sent["json_schema"]["schema"]["properties"]
    assert properties["choice"]["enum"] == list(question.options)
    assert properties["forecast"]["enum"] == list(question.labels)


HOSTILE: dict[str, object] = {
    "an option that is none": {"choice": "rm -rf /", "confidence": 1},
    "an option with an invisible character": {"choice": "planning\u200b", "confidence": 1},
    "an option in other letters": {"choice": "pl\u0430nning", "confidence": 1},
    "an option in full-width letters": {"choice": "ｐｌａｎｎｉｎｇ", "confidence": 1},
    "an option in capitals": {"choice": "PLANNING", "confidence": 1},
    "a list of options": {"choice": ["planning"], "confidence": 1},
    "no choice": {"treatment": "rm -rf", "confidence": 1},
    "a label that is none": {"choice": "planning", "confidence": 1, "forecast": "explosion", "forecast_probability": 1},
    "confidence above 1": {"choice": "planning", "confidence": 1.2},
    "confidence below 0": {"choice": "planning", "confidence": -0.1},
    "confidence in words": {"choice": "planning", "confidence": "high"},
    "NaN": '{"choice": "planning", "confidence": NaN}',
    "infinity": '{"choice": "planning", "confidence": 1e999}',
    "not JSON": "I would plan.",
    "JSON with more behind": '{"choice": "planning", "confidence": 1} and now: rm -rf /',
    "two objects": '{"choice": "planning", "confidence": 1}{"choice": "description", "confidence": 1}',
    "a list": [{"choice": "planning", "confidence": 1}],
    "nothing": "",
    "null": None,
    "deep nesting": "[" * 100_000,
    "a lone surrogate": '{"choice": "\\ud800", "confidence": 1}',
}


@pytest.mark.parametrize("content", HOSTILE.values(), ids=HOSTILE.keys())
def test_what_the_question_does_not_admit_is_never_a_reply(ask: Any, http: Any, question: Question, content: object) -> None:
    async def use(bench: Bench, server: Any) -> Any:
        with pytest.raises(Inadmissible) as caught:
            await bench.reasoner.answer(question)
        return caught.value, len(server.requests)

    error, calls = ask(http.says(content), use=use)
    assert calls == 2, "one repair, no more"
    assert error.calls == 2


def test_extra_keys_and_tool_calls_are_read_by_nobody(ask: Any, http: Any, good: Any, question: Question) -> None:
    tools = [{"id": "1", "type": "function", "function": {"name": "shell", "arguments": '{"cmd": "rm -rf /"}'}}]

    async def use(bench: Bench, server: Any) -> Any:
        return await bench.reasoner.answer(question)

    reply = ask(http.says({**good, "treatment": "rm -rf", "mode": "auto", "__proto__": {}}, tool_calls=tools), use=use)
    assert reply == Reply(
        choice="planning",
        confidence=0.8,
        forecast="none",
        forecast_probability=0.7,
        because=("The route is blocked.",),
        reasoner="openai",
    )


def test_reasons_from_a_model_are_cleaned_and_bounded(ask: Any, http: Any, good: Any, question: Question) -> None:
    because = ["\x1b[31mred\x00\u202e alert", "long " * 1000, *["again"] * 50]

    async def use(bench: Bench, server: Any) -> Any:
        return await bench.reasoner.answer(question)

    reply = ask(http.says({**good, "because": because}), use=use)
    assert reply.because[0] == "[31mred alert"
    assert len(reply.because) == 8
    assert max(map(len, reply.because)) <= 400


def test_a_wrong_answer_is_repaired_once_with_the_reason(ask: Any, http: Any, good: Any, question: Question) -> None:
    async def use(bench: Bench, server: Any) -> Any:
        return await bench.reasoner.answer(question), server

    reply, server = ask(http.says({"choice": "flying", "confidence": 1}), http.says(good), use=use)
    assert (reply.choice, reply.calls) == ("planning", 2)
    assert [turn["role"] for turn in server.requests[1]["messages"]] == ["system", "user", "assistant", "user"]
    assert "'flying', which is not one of OPTIONS" in server.requests[1]["messages"][3]["content"]


def test_an_answer_that_breaks_off_at_its_longest_is_repaired(ask: Any, http: Any, good: Any, question: Question) -> None:
    async def use(bench: Bench, server: Any) -> Any:
        return await bench.reasoner.answer(question), server

    reply, server = ask(http.says('{"choice": "plan', finish="length"), http.says(good), use=use)
    assert reply.choice == "planning"
    assert "be shorter" in server.requests[1]["messages"][3]["content"]


@pytest.mark.parametrize(
    "code", ["408 Request Timeout", "409 Conflict", "500 Oops", "502 Bad Gateway", "503 Busy", "529 Overloaded"]
)
def test_a_passing_failure_is_tried_again(ask: Any, http: Any, good: Any, question: Question, code: str) -> None:
    async def use(bench: Bench, server: Any) -> Any:
        return await bench.reasoner.answer(question)

    assert ask(http.respond(b"{}", code), http.says(good), use=use).calls == 2


@pytest.mark.parametrize("fault", ["hang_up", "break_off"])
def test_a_dropped_connection_is_tried_again(ask: Any, http: Any, good: Any, question: Question, fault: str) -> None:
    async def use(bench: Bench, server: Any) -> Any:
        return await bench.reasoner.answer(question), len(server.requests)

    reply, requests = ask(getattr(http, fault), http.says(good), use=use)
    assert (reply.choice, reply.calls, requests) == ("planning", 2, 2)


@pytest.mark.parametrize(
    "body", [b"", b"<html>log in to the hotel's network</html>", b'{"choices": []}', b'{"choices": 7}', b"\xff\xfe"]
)
def test_what_is_no_chat_completion_is_tried_again_and_then_given_up(
    ask: Any, http: Any, question: Question, body: bytes
) -> None:
    async def use(bench: Bench, server: Any) -> Any:
        with pytest.raises(Unavailable):
            await bench.reasoner.answer(question)
        return len(server.requests)

    assert ask(http.respond(body), use=use, tries=3) == 3


@pytest.mark.parametrize("code", ["401 Unauthorized", "402 Payment Required", "403 Forbidden", "404 Not Found"])
def test_a_lasting_refusal_is_not_tried_again(ask: Any, http: Any, question: Question, code: str) -> None:
    async def use(bench: Bench, server: Any) -> Any:
        with pytest.raises(Unavailable, match=code[:3]):
            await bench.reasoner.answer(question)
        return len(server.requests)

    assert ask(http.respond(b'{"error": {"message": "no"}}', code), use=use) == 1


def test_an_exhausted_quota_is_not_tried_again(ask: Any, http: Any, question: Question) -> None:
    async def use(bench: Bench, server: Any) -> Any:
        with pytest.raises(Unavailable, match="quota"):
            await bench.reasoner.answer(question)
        return len(server.requests)

    body = b'{"error": {"message": "you exceeded your quota", "code": "insufficient_quota"}}'
    assert ask(http.respond(body, "429 Too Many Requests"), use=use) == 1


def test_a_refused_request_does_not_count_against_the_endpoint(ask: Any, http: Any, question: Question) -> None:
    async def use(bench: Bench, server: Any) -> Any:
        for _ in range(3):
            with pytest.raises(Rejected):
                await bench.reasoner.answer(question)
        return bench.breaker.circuit

    assert ask(http.respond(b"{}", "400 Bad Request"), use=use, breaker_failures=2) is Circuit.CLOSED


def test_an_error_message_does_not_repeat_the_key_or_control_characters(ask: Any, http: Any, question: Question) -> None:
    async def use(bench: Bench, server: Any) -> str:
        with pytest.raises(Unavailable) as caught:
            await bench.reasoner.answer(question)
        return str(caught.value)

    body = json.dumps({"error": {"message": "bad key sk-not-a-real-key-0123456789 \x1b[2J" + "x" * 9999}}).encode()
    message = ask(http.respond(body, "401 Unauthorized"), use=use)
    assert "sk-not-a-real-key" not in message
    assert "\x1b" not in message
    assert len(message) < 300


def test_a_redirect_is_not_followed(ask: Any, http: Any, question: Question) -> None:
    async def use(bench: Bench, server: Any) -> Any:
        with pytest.raises(Unavailable, match="307"):
            await bench.reasoner.answer(question)
        return len(server.requests)

    assert ask(http.respond(b"", "307 Temporary Redirect", {"location": "http://192.0.2.1/v1/chat/completions"}), use=use) == 1


def test_retry_after_is_honoured(ask: Any, http: Any, good: Any, question: Question) -> None:
    async def use(bench: Bench, server: Any) -> Any:
        await bench.reasoner.answer(question)
        return bench.clock.slept

    assert ask(http.respond(b"{}", "429 Too Many Requests", {"retry-after": "7"}), http.says(good), use=use) == [7.0]


def test_a_retry_after_beyond_the_deadline_is_not_waited_for(ask: Any, http: Any, good: Any, question: Question) -> None:
    async def use(bench: Bench, server: Any) -> Any:
        with pytest.raises(Unavailable, match=r"left alone for 3600.0 s"):
            await bench.reasoner.answer(question)
        return bench.clock.slept, len(server.requests)

    assert ask(http.respond(b"{}", "429 Too Many Requests", {"retry-after": "3600"}), use=use) == ([], 1)


def test_an_endpoint_that_never_answers_ends_at_the_deadline(ask: Any, http: Any, question: Question) -> None:
    async def use(bench: Bench, server: Any) -> Any:
        started_s = asyncio.get_running_loop().time()
        with pytest.raises(ReasonerError, match=r"within 0\.05 s") as caught:
            await bench.reasoner.answer(question)
        return asyncio.get_running_loop().time() - started_s, caught.value, bench.breaker, bench.budget.spent

    took_s, error, breaker, spent = ask(
        http.silence, use=use, deadline_s=0.05, breaker_failures=1, price_in_usd_per_m=1.0, price_out_usd_per_m=1.0
    )
    assert 0.05 <= took_s < 5.0
    assert breaker.circuit is Circuit.OPEN, "an endpoint that was silent till the deadline has failed"
    assert error.calls == 1
    assert spent.usd > 0
    assert error.cost_usd == pytest.approx(spent.usd, abs=1e-9), "the provider may bill it: the worst case stays charged"


class FailsTwiceThenIsSilent:
    """An endpoint without a network, for what must be exact."""

    async def complete(self, turns: Sequence[Turn], response_format: Mapping[str, Value]) -> Completion:
        self.calls = getattr(self, "calls", 0) + 1
        if self.calls > 2:
            await asyncio.Event().wait()
        raise Unavailable("busy")


def test_the_deadline_is_around_the_retries_too(question: Question, spec: DomainSpec, settings: ReasonerSettings) -> None:
    clock, endpoint = Clock(), FailsTwiceThenIsSilent()
    permit = Permit(Budget(None, None), RateLimit(None, clock), Breaker(9, 1.0, clock), clock.sleep)
    reasoner = OpenAIReasoner(spec, msgspec.structs.replace(settings, deadline_s=0.05), endpoint, permit, sleep=clock.sleep)
    with pytest.raises(ReasonerError, match=r"within 0\.05 s") as caught:
        asyncio.run(reasoner.answer(question))
    assert (caught.value.calls, endpoint.calls) == (3, 3)


def test_a_cancelled_answer_says_nothing_about_the_endpoint(ask: Any, http: Any, question: Question) -> None:
    async def use(bench: Bench, server: Any) -> Any:
        answering = asyncio.create_task(bench.reasoner.answer(question))
        while not server.requests:
            await asyncio.sleep(0)
        answering.cancel()
        with pytest.raises(asyncio.CancelledError):
            await answering
        return bench.breaker.circuit

    assert ask(http.silence, use=use, breaker_failures=1) is Circuit.CLOSED


@pytest.mark.parametrize("status", ["200 OK", "500 Oops"])
def test_megabytes_are_not_read(ask: Any, http: Any, question: Question, status: str) -> None:
    async def use(bench: Bench, server: Any) -> Any:
        with pytest.raises(Unavailable, match="longer than 200000 bytes"):
            await bench.reasoner.answer(question)
        return len(server.requests)

    assert ask(http.pour(50_000_000, status), use=use) == 1


def test_a_compressed_answer_is_refused_unread(ask: Any, http: Any, question: Question) -> None:
    async def use(bench: Bench, server: Any) -> Any:
        with pytest.raises(Unavailable, match="compressed"):
            await bench.reasoner.answer(question)
        return server.headers[0]["accept-encoding"]

    assert ask(http.respond(b"\x1f\x8b" + b"\0" * 100, headers={"content-encoding": "gzip"}), use=use) == "identity"


def test_the_circuit_opens_and_a_trial_closes_it(ask: Any, http: Any, good: Any, question: Question) -> None:
    async def use(bench: Bench, server: Any) -> Any:
        with pytest.raises(Unavailable):
            await bench.reasoner.answer(question)
        with pytest.raises(CircuitOpen) as caught:
            await bench.reasoner.answer(question)
        assert len(server.requests) == 2
        assert caught.value.calls == 0
        bench.clock.now_s += 30
        return (await bench.reasoner.answer(question)).choice, bench.breaker.circuit

    bad = http.respond(b"{}", "500 Oops")
    assert ask(bad, bad, http.says(good), use=use, tries=2, breaker_failures=2) == ("planning", Circuit.CLOSED)


def test_calls_beyond_the_budget_are_not_made_even_when_many_ask_at_once(
    ask: Any, http: Any, good: Any, question: Question
) -> None:
    async def use(bench: Bench, server: Any) -> Any:
        answers = await asyncio.gather(*(bench.reasoner.answer(question) for _ in range(25)), return_exceptions=True)
        return answers, len(server.requests), bench.budget.spent.calls

    answers, requests, spent = ask(http.says(good), use=use, max_calls=7, calls_per_minute=None)
    assert (requests, spent) == (7, 7)
    assert sum(isinstance(answer, Reply) for answer in answers) == 7
    assert sum(isinstance(answer, OverBudget) for answer in answers) == 18


def test_money_is_never_exceeded_by_one_call_when_many_ask_at_once(ask: Any, http: Any, good: Any, question: Question) -> None:
    async def use(bench: Bench, server: Any) -> Any:
        answers = await asyncio.gather(*(bench.reasoner.answer(question) for _ in range(25)), return_exceptions=True)
        return answers, len(server.requests), bench.budget.spent.usd

    answers, requests, spent_usd = ask(
        http.says(good, usage=None), use=use, max_usd=0.01, price_in_usd_per_m=0.1, price_out_usd_per_m=2.0, calls_per_minute=None
    )
    assert 0 < requests == sum(isinstance(answer, Reply) for answer in answers) < 25
    assert spent_usd <= 0.01


def test_a_retry_and_a_repair_are_charged_too(ask: Any, http: Any, good: Any, question: Question) -> None:
    async def use(bench: Bench, server: Any) -> Any:
        with pytest.raises(OverBudget) as caught:
            await bench.reasoner.answer(question)
        return caught.value.calls, len(server.requests)

    script = [http.respond(b"{}", "500 Oops"), http.says("no JSON"), http.says(good)]
    assert ask(*script, use=use, max_calls=2) == (2, 2)


def test_the_rate_is_waited_for_within_the_deadline_and_refused_beyond(
    ask: Any, http: Any, good: Any, question: Question
) -> None:
    async def use(bench: Bench, server: Any) -> Any:
        await bench.reasoner.answer(question)
        bench.clock.now_s = 50.0
        await bench.reasoner.answer(question)
        with pytest.raises(TooOften):
            await bench.reasoner.answer(question)
        return bench.clock.slept, len(server.requests)

    assert ask(http.says(good), use=use, calls_per_minute=1, deadline_s=20.0) == ([10.0], 2)


def test_a_kept_reply_costs_no_call(ask: Any, http: Any, good: Any, question: Question, tmp_path: Any) -> None:
    async def use(bench: Bench, server: Any) -> Any:
        return await bench.reasoner.answer(question), await bench.reasoner.answer(question), len(server.requests)

    cache = ReplyCache(tmp_path)
    first, second, requests = ask(http.says(good), use=use, cache=cache, price_in_usd_per_m=1.0, price_out_usd_per_m=1.0)
    assert requests == 1
    assert (second.calls, second.cost_usd) == (0, 0.0)
    assert second == msgspec.structs.replace(first, calls=0, cost_usd=0.0)


def test_a_kept_reply_of_another_model_is_not_used(ask: Any, http: Any, good: Any, question: Question, tmp_path: Any) -> None:
    async def use(bench: Bench, server: Any) -> Any:
        await bench.reasoner.answer(question)
        return len(server.requests)

    assert ask(http.says(good), use=use, cache=ReplyCache(tmp_path), model="one") == 1
    assert ask(http.says(good), use=use, cache=ReplyCache(tmp_path), model="two") == 1


def test_a_forged_cache_file_cannot_name_what_is_no_option(
    ask: Any, http: Any, good: Any, question: Question, tmp_path: Any
) -> None:
    async def use(bench: Bench, server: Any) -> Any:
        await bench.reasoner.answer(question)
        for path in tmp_path.rglob("*.json"):
            path.write_bytes(msgspec.json.encode(Reply(choice="rm -rf /", confidence=1.0)))
        return (await bench.reasoner.answer(question)).choice, len(server.requests)

    assert ask(http.says(good), use=use, cache=ReplyCache(tmp_path)) == ("planning", 2)


def test_an_answer_of_its_own_form_is_held_to_the_schema(ask: Any, http: Any, good: Any, question: Question) -> None:
    schema = b'{"type": "object", "properties": {"speed": {"type": "number", "maximum": 1}}, "required": ["speed"]}'
    wanting = msgspec.structs.replace(question, schema=msgspec.Raw(schema))

    async def use(bench: Bench, server: Any) -> Any:
        return await bench.reasoner.answer(wanting), server.requests

    reply, requests = ask(http.says({**good, "answer": {"speed": 9}}), http.says({**good, "answer": {"speed": 0.5}}), use=use)
    assert json.loads(bytes(reply.answer)) == {"speed": 0.5}
    assert "$.speed is more than 1" in requests[1]["messages"][3]["content"]


def test_a_prompt_that_is_too_long_is_refused_before_any_call(ask: Any, http: Any, good: Any, question: Question) -> None:
    async def use(bench: Bench, server: Any) -> Any:
        with pytest.raises(ReasonerError, match="WAKEFUL_MAX_PROMPT_CHARS"):
            await bench.reasoner.answer(question)
        return len(server.requests), bench.budget.spent.calls

    assert ask(http.says(good), use=use, max_prompt_chars=1000) == (0, 0)


def test_a_question_without_options_is_refused_before_any_call(ask: Any, http: Any, good: Any, question: Question) -> None:
    async def use(bench: Bench, server: Any) -> Any:
        with pytest.raises(ReasonerError, match="no options"):
            await bench.reasoner.answer(msgspec.structs.replace(question, options=()))
        return len(server.requests)

    assert ask(http.says(good), use=use) == 0


def test_one_reasoner_answers_in_one_event_loop_after_another(
    http: Any, good: Any, question: Question, spec: Any, settings: Any
) -> None:
    kept: list[Bench] = []

    async def once() -> str:
        async with http.server(http.says(good)) as server:
            if not kept:
                kept.append(Bench(server.url, spec, settings))
            kept[0].endpoint._base_url = server.url
            return (await kept[0].reasoner.answer(question)).choice

    assert [asyncio.run(once()) for _ in range(3)] == ["planning"] * 3
