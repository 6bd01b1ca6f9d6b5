"""The contract suite that third parties use, over every reasoner that comes with wakeful."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Iterator
from typing import Any

import msgspec
import pytest

from wakeful.deliberation import REASONERS, ReasonerSettings, make
from wakeful.facts.asking import Question
from wakeful.facts.domain import DomainSpec
from wakeful.testing.reasoner_checks import check_reasoner


@pytest.fixture
def address(http: Any, good: Any) -> Iterator[str]:
    """A server in a thread of its own: the suite runs one event loop after another."""
    loop = asyncio.new_event_loop()
    server = http.server(http.says(good))
    thread = threading.Thread(target=loop.run_forever)
    thread.start()
    try:
        asyncio.run_coroutine_threadsafe(server.__aenter__(), loop).result(10)
        yield server.url
        asyncio.run_coroutine_threadsafe(server.__aexit__(), loop).result(10)
    finally:
        loop.call_soon_threadsafe(loop.stop)
        thread.join(10)
        loop.close()


@pytest.mark.parametrize("name", sorted(REASONERS))
def test_a_reasoner_keeps_its_contract(
    name: str, address: str, spec: DomainSpec, settings: ReasonerSettings, question: Question
) -> None:
    reasoner = make(name, spec, msgspec.structs.replace(settings, base_url=address))
    plain = msgspec.structs.replace(question, labels=(), facts={}, history=("treated by planning, ended in none (supported)",))
    assert check_reasoner(reasoner, [question, plain])
