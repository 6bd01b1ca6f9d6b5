"""A real HTTP server on loopback that speaks the chat completions protocol, well or badly, as each test scripts it."""

from __future__ import annotations

import asyncio
import json
from collections.abc import Awaitable, Callable, Mapping
from typing import Any

import pytest

from wakeful.deliberation.settings import ReasonerSettings, Secret
from wakeful.facts.asking import Question
from wakeful.facts.domain import DomainSpec, Guideline

Write = asyncio.StreamWriter
Behaviour = Callable[[Write], Awaitable[None]]


class Server:
    """Answers the n-th request with the n-th behaviour, the last one again and again. Use it as an async context manager."""

    def __init__(self, *behaviours: Behaviour) -> None:
        self._behaviours = behaviours
        self.requests: list[dict[str, Any]] = []
        self.headers: list[Mapping[str, str]] = []
        self.heads: list[str] = []
        self.concurrent = 0
        self.most_concurrent = 0
        self._tasks: set[asyncio.Task[None]] = set()

    async def __aenter__(self) -> Server:
        self._server = await asyncio.start_server(self._connected, "127.0.0.1", 0)
        return self

    async def __aexit__(self, *_: object) -> None:
        self._server.close()
        for task in list(self._tasks):
            task.cancel()
        await asyncio.gather(*self._tasks, return_exceptions=True)

    @property
    def url(self) -> str:
        host, port = self._server.sockets[0].getsockname()[:2]
        return f"http://{host}:{port}/v1"

    async def _connected(self, reader: asyncio.StreamReader, writer: Write) -> None:
        task = asyncio.current_task()
        assert task is not None
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)
        try:
            while True:
                head = (await reader.readuntil(b"\r\n\r\n")).decode()
                first, *rest = head.split("\r\n")
                headers = {name.lower(): value.strip() for name, _, value in (line.partition(":") for line in rest if line)}
                body = await reader.readexactly(int(headers.get("content-length", 0)))
                behaviour = self._behaviours[min(len(self.requests), len(self._behaviours) - 1)]
                self.heads.append(first)
                self.headers.append(headers)
                self.requests.append(json.loads(body))
                self.concurrent += 1
                self.most_concurrent = max(self.most_concurrent, self.concurrent)
                try:
                    await behaviour(writer)
                    await writer.drain()
                finally:
                    self.concurrent -= 1
                if writer.is_closing():
                    return
        except (asyncio.IncompleteReadError, ConnectionError, asyncio.CancelledError):
            return  # the client went away, or the test is over
        finally:
            writer.close()


def respond(body: bytes, status: str = "200 OK", headers: Mapping[str, str] | None = None) -> Behaviour:
    """A whole HTTP response."""

    async def behaviour(writer: Write) -> None:
        lines = [f"HTTP/1.1 {status}", f"content-length: {len(body)}", "content-type: application/json"]
        lines += [f"{name}: {value}" for name, value in (headers or {}).items()]
        writer.write("\r\n".join(lines).encode() + b"\r\n\r\n" + body)

    return behaviour


def says(content: object, *, usage: tuple[int, int] | None = (100, 20), finish: str = "stop", **message: object) -> Behaviour:
    """A chat completion whose message says ``content``: text as it is, anything else as JSON."""
    text = content if isinstance(content, str) or content is None else json.dumps(content)
    body: dict[str, object] = {
        "id": "1",
        "object": "chat.completion",
        "created": 0,
        "model": "scripted",
        "choices": [{"index": 0, "finish_reason": finish, "message": {"role": "assistant", "content": text, **message}}],
    }
    if usage is not None:
        body["usage"] = {"prompt_tokens": usage[0], "completion_tokens": usage[1], "total_tokens": sum(usage)}
    return respond(json.dumps(body).encode())


async def silence(writer: Write) -> None:
    """Never answers."""
    await asyncio.Event().wait()


async def hang_up(writer: Write) -> None:
    """Drops the connection without a byte."""
    writer.transport.abort()


async def break_off(writer: Write) -> None:
    """Drops the connection in the middle of an answer."""
    writer.write(b'HTTP/1.1 200 OK\r\ncontent-length: 5000\r\ncontent-type: application/json\r\n\r\n{"choices": [{"mess')
    await writer.drain()
    writer.close()


def pour(total_bytes: int, status: str = "200 OK") -> Behaviour:
    """Sends a chunked body without end in sight, and no length."""

    async def behaviour(writer: Write) -> None:
        writer.write(f"HTTP/1.1 {status}\r\ntransfer-encoding: chunked\r\ncontent-type: application/json\r\n\r\n".encode())
        block = b"x" * 65_536
        for _ in range(total_bytes // len(block)):
            writer.write(b"10000\r\n" + block + b"\r\n")
            await writer.drain()
        writer.write(b"0\r\n\r\n")

    return behaviour


class Http:
    """What a test scripts a server with."""

    server = Server
    respond = staticmethod(respond)
    says = staticmethod(says)
    silence = staticmethod(silence)
    hang_up = staticmethod(hang_up)
    break_off = staticmethod(break_off)
    pour = staticmethod(pour)


@pytest.fixture
def http() -> type[Http]:
    """The scripted server and its behaviours."""
    return Http


@pytest.fixture
def good() -> dict[str, object]:
    """A reply that `question` admits."""
    return {
        "choice": "planning",
        "confidence": 0.8,
        "forecast": "none",
        "forecast_probability": 0.7,
        "because": ["The route is blocked."],
    }


@pytest.fixture
def question() -> Question:
    """A question with options, labels and facts."""
    return Question(
        about="how to treat an event",
        event="a pallet stands on the route",
        asks="Which treatment fits this event?",
        options=("description", "planning", "risk_prediction"),
        labels=("none", "intervention"),
        facts={"kind": "obstacle", "relation": "new", "load": "0.7", "safety": "True"},
    )


@pytest.fixture
def spec() -> DomainSpec:
    """A domain with two guidelines."""
    return DomainSpec(
        name="warehouse",
        version=1,
        says="a mobile robot in a warehouse",
        guideline=(
            Guideline(treat="planning", because="A blocked route needs another one.", when={"kind": "obstacle"}, expect="none"),
            Guideline(treat="description", because="What is only seen is described."),
        ),
    )


@pytest.fixture
def settings() -> ReasonerSettings:
    """Quick settings without a cache."""
    return ReasonerSettings(api_key=Secret("sk-not-a-real-key-0123456789"), deadline_s=20.0, backoff_s=0.0, backoff_limit_s=0.0)
