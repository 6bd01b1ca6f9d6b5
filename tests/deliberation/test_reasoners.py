"""Reasoners by name, and the one contract that all of them keep."""

from __future__ import annotations

import asyncio
import subprocess
import sys
from pathlib import Path
from typing import Any

import msgspec
import pytest

from wakeful.contracts.reasoner import Reasoner, ReasonerError
from wakeful.deliberation import REASONERS, ReasonerSettings, SettingsError, make
from wakeful.deliberation.budget import OverBudget, Spent
from wakeful.facts.asking import Question
from wakeful.facts.domain import DomainSpec


@pytest.mark.parametrize("name", sorted(REASONERS))
def test_every_reasoner_keeps_the_contract(
    name: str, http: Any, good: Any, question: Question, spec: DomainSpec, settings: ReasonerSettings
) -> None:
    async def main() -> None:
        async with http.server(http.says(good)) as server:
            reasoner: Reasoner = make(name, spec, msgspec.structs.replace(settings, base_url=server.url))
            reply = await reasoner.answer(question)
            assert reasoner.name == reply.reasoner == name
            assert reasoner.latency_s >= 0.0
            assert reply.choice in question.options
            assert reply.forecast in question.labels
            assert 0.0 <= reply.confidence <= 1.0
            assert reply.because
            with pytest.raises(ReasonerError):
                await reasoner.answer(msgspec.structs.replace(question, options=()))

    asyncio.run(main())


def test_an_unknown_name_is_answered_with_the_known_ones(spec: DomainSpec) -> None:
    with pytest.raises(SettingsError, match="there are guidelines, openai, scripted"):
        make("oracle", spec, ReasonerSettings())


def test_nothing_is_sent_to_an_endpoint_that_nobody_named(spec: DomainSpec) -> None:
    with pytest.raises(SettingsError, match="WAKEFUL_OPENAI_BASE_URL"):
        make("openai", spec, ReasonerSettings())


def test_a_call_beyond_this_machine_fails_in_tests_without_leaving_it(
    spec: DomainSpec, settings: ReasonerSettings, question: Question
) -> None:
    chosen = msgspec.structs.replace(settings, base_url="https://api.deepseek.com", tries=1)
    with pytest.raises(Exception, match="tests may not look up") as caught:
        asyncio.run(make("openai", spec, chosen).answer(question))
    assert type(caught.value).__name__ in ("OutsideWorld", "Unavailable")


def test_what_an_earlier_run_spent_counts_against_the_budget(
    spec: DomainSpec, settings: ReasonerSettings, question: Question
) -> None:
    chosen = msgspec.structs.replace(settings, base_url="http://127.0.0.1:9", max_calls=5)
    with pytest.raises(OverBudget):
        asyncio.run(make("openai", spec, chosen, spent=Spent(5, 0.0)).answer(question))


def test_a_missing_extra_is_named_and_the_rest_works_without_it() -> None:
    program = """
import sys
sys.modules["openai"] = None
from wakeful.deliberation import ReasonerSettings, make
from wakeful.facts.domain import DomainSpec
spec = DomainSpec(name="d", version=1, says="")
print(make("guidelines", spec, ReasonerSettings()).name)
make("openai", spec, ReasonerSettings(base_url="http://127.0.0.1:9"))
"""
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False, timeout=60)
    assert done.stdout == "guidelines\n"
    assert "pip install 'wakeful[openai]'" in done.stderr


def test_the_sdk_is_not_loaded_before_it_is_wanted() -> None:
    program = "import sys, wakeful.deliberation; print('openai' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True, timeout=60)
    assert done.stdout == "False\n"


def test_the_sdk_is_imported_in_one_place() -> None:
    room = Path(sys.modules["wakeful.deliberation"].__file__ or "").parent
    importing = [
        path.name for path in room.glob("*.py") if "import openai" in path.read_text().replace("import openai_reasoner", "")
    ]
    assert importing == ["sdk.py"]
