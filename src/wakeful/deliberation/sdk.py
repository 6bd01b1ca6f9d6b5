"""One call through the `openai` SDK. The SDK is imported here and nowhere else; `reasoners.py` loads this file only on demand."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Mapping, Sequence
from typing import cast

import httpx2
import msgspec
import openai
from openai.types.chat import ChatCompletionMessageParam
from openai.types.chat.completion_create_params import ResponseFormat

from wakeful.contracts.reasoner import ReasonerError
from wakeful.deliberation.backoff import retry_after_s
from wakeful.deliberation.endpoint import Completion, Rejected, Turn, Unavailable
from wakeful.deliberation.prompt import clean
from wakeful.facts.values import Value


class _Message(msgspec.Struct):
    content: str | None = None


class _Choice(msgspec.Struct):
    message: _Message
    finish_reason: str | None = None


class _Usage(msgspec.Struct):
    prompt_tokens: int | None = None
    completion_tokens: int | None = None


class _Body(msgspec.Struct):
    choices: list[_Choice]
    usage: _Usage | None = None


class SdkEndpoint:
    """An endpoint behind the `openai` SDK, with the SDK's own retries, redirects and time-outs off: ours are around it.

    An answer is read up to ``max_answer_bytes`` and dropped beyond; compressed answers are not accepted, so that a small
    answer cannot unfold into a large one.

    Args:
        base_url: such as ``https://api.deepseek.com``; None for the SDK's default.
        api_key: sent to the endpoint and shown to nobody.
        model: the model's name at the endpoint.
        max_answer_bytes: the most that is read of an answer.
        max_answer_tokens: the most that the model may write.
    """

    def __init__(self, *, base_url: str | None, api_key: str, model: str, max_answer_bytes: int, max_answer_tokens: int) -> None:
        self._base_url = base_url
        self._api_key = api_key
        self._model = model
        self._max_answer_bytes = max_answer_bytes
        self._max_answer_tokens = max_answer_tokens
        self._client: openai.AsyncOpenAI | None = None
        self._loop: asyncio.AbstractEventLoop | None = None

    async def complete(self, turns: Sequence[Turn], response_format: Mapping[str, Value]) -> Completion:
        """One call, without retries."""
        try:
            response = await self._connected().chat.completions.with_raw_response.create(
                model=self._model,
                messages=[cast("ChatCompletionMessageParam", {"role": turn.role, "content": turn.content}) for turn in turns],
                response_format=cast("ResponseFormat", dict(response_format)),
                temperature=0,
                max_tokens=self._max_answer_tokens,
                stream=False,
            )
            body = msgspec.json.decode(response.content, type=_Body)
        except openai.APIStatusError as error:
            raise self._refusal(error) from None
        except _Oversized:
            raise Unavailable(f"the endpoint's answer is longer than {self._max_answer_bytes} bytes", again=False) from None
        except openai.APIConnectionError as error:
            cause = error.__cause__
            if isinstance(cause, _Oversized):
                raise Unavailable(f"the endpoint's answer is longer than {self._max_answer_bytes} bytes", again=False) from None
            raise Unavailable(f"no answer from the endpoint: {self._shown(str(cause or error))}") from None
        except (msgspec.MsgspecError, RecursionError, UnicodeError) as error:
            raise Unavailable(f"the endpoint's answer is not a chat completion: {self._shown(str(error))}") from None
        if not body.choices:
            raise Unavailable("the endpoint's answer holds no choice")
        choice, usage = body.choices[0], body.usage or _Usage()
        text = self._without_key(choice.message.content or "")
        return Completion(text, choice.finish_reason or "", usage.prompt_tokens, usage.completion_tokens)

    async def close(self) -> None:
        """Close the connections of the running loop; the next call opens new ones."""
        client, self._client = self._client, None
        if client is not None and self._loop is asyncio.get_running_loop():
            await client.close()

    def _connected(self) -> openai.AsyncOpenAI:
        """The client of the running loop: connections cannot outlive theirs."""
        loop = asyncio.get_running_loop()
        if self._client is None or self._loop is not loop:
            self._loop = loop
            self._client = openai.AsyncOpenAI(
                base_url=self._base_url,
                api_key=self._api_key,
                max_retries=0,
                timeout=None,
                default_headers={"Accept-Encoding": "identity"},
                http_client=openai.DefaultAsyncHttpxClient(
                    timeout=None, follow_redirects=False, event_hooks={"response": [self._bound]}
                ),
            )
        return self._client

    async def _bound(self, response: httpx2.Response) -> None:
        if response.headers.get("content-encoding", "identity").lower() not in ("", "identity"):
            raise Unavailable("the endpoint sent a compressed answer, which was not asked for", again=False)
        if not isinstance(response.stream, httpx2.AsyncByteStream):
            raise Unavailable("this version of the openai SDK is not built on httpx2: pip install 'wakeful[openai]'", again=False)
        response.stream = _Bounded(response.stream, self._max_answer_bytes)

    def _refusal(self, error: openai.APIStatusError) -> ReasonerError:
        status, code = error.status_code, str(error.code or "")
        says = f"the endpoint answered {status}: {self._shown(error.message)}"
        if status in (400, 413, 422):
            return Rejected(says)
        again = status in (408, 409, 429) or status >= 500
        return Unavailable(
            says, again=again and code != "insufficient_quota", retry_after_s=retry_after_s(error.response.headers)
        )

    def _shown(self, text: str) -> str:
        return clean(text.replace(self._api_key, "[key]") if self._api_key else text, 200)

    def _without_key(self, text: str) -> str:
        """An answer is journaled: an endpoint that gives the key back in it is not believed to mean it."""
        return text.replace(self._api_key, "[key]") if len(self._api_key) >= _LEAST_KEY_CHARS else text


#: What is shorter is no key but a placeholder, as local servers take it, and may stand in any answer.
_LEAST_KEY_CHARS = 8


class _Oversized(Exception):
    """More bytes came than are read."""


class _Bounded(httpx2.AsyncByteStream):
    """A response's bytes, up to a limit: the one place where a body is bounded, error bodies included."""

    def __init__(self, stream: httpx2.AsyncByteStream, limit: int) -> None:
        self._stream = stream
        self._left = limit

    async def __aiter__(self) -> AsyncIterator[bytes]:
        async for chunk in self._stream:
            self._left -= len(chunk)
            if self._left < 0:
                raise _Oversized
            yield chunk

    async def aclose(self) -> None:
        await self._stream.aclose()
