"""Reading a model's text: whatever it says, only what the question admits comes through."""

from __future__ import annotations

import json
from typing import Any

import jsonschema
import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from wakeful.deliberation.replies import Inadmissible, check, read, reply_schema
from wakeful.deliberation.schema import SchemaError
from wakeful.facts.asking import Question, Reply

ASKED = Question(about="", event="", asks="", options=("planning", "memory"), labels=("none", "intervention"))
JSON = st.recursive(
    st.none() | st.booleans() | st.floats() | st.text() | st.sampled_from(["planning", "memory", "none", "choice"]),
    lambda inner: (
        st.lists(inner, max_size=3)
        | st.dictionaries(
            st.sampled_from(["choice", "confidence", "forecast", "forecast_probability", "because", "answer"]), inner
        )
    ),
)


@given(st.text() | JSON.map(json.dumps))
def test_any_text_gives_an_admissible_reply_or_none(text: str) -> None:
    try:
        reply = read(text, ASKED)
    except Inadmissible:
        return
    assert reply.choice in ASKED.options
    assert reply.forecast in ("", *ASKED.labels)
    assert 0 <= reply.confidence <= 1
    assert 0 <= reply.forecast_probability <= 1


@pytest.mark.parametrize(
    "text",
    [
        '{"choice": "planning", "confidence": 1}',
        ' {"choice": " planning ", "confidence": 1}\n',
        '```json\n{"choice": "planning", "confidence": 1}\n```',
        '```\n{"choice": "planning", "confidence": 1, "because": "one sentence"}\n```',
        '{"choice": "planning", "confidence": 1, "forecast": null, "forecast_probability": null}',
    ],
)
def test_an_object_may_stand_bare_or_in_one_fence(text: str) -> None:
    assert read(text, ASKED).choice == "planning"


def test_a_forecast_that_nobody_asked_for_is_left_out() -> None:
    asked = msgspec.structs.replace(ASKED, labels=())
    reply = read('{"choice": "planning", "confidence": 1, "forecast": "doom", "forecast_probability": 1}', asked)
    assert (reply.forecast, reply.forecast_probability) == ("", 0.0)


def test_an_answer_that_nobody_asked_for_is_left_out() -> None:
    assert bytes(read('{"choice": "planning", "confidence": 1, "answer": {"run": "rm"}}', ASKED).answer) == b"null"


def test_a_missing_answer_is_inadmissible_where_one_is_wanted() -> None:
    asked = msgspec.structs.replace(ASKED, schema=msgspec.Raw(b'{"type": "object"}'))
    with pytest.raises(Inadmissible, match="not of type object"):
        read('{"choice": "planning", "confidence": 1}', asked)


@pytest.mark.parametrize("schema", [b"{", b'{"pattern": "a"}', b"7"])
def test_a_schema_that_cannot_be_checked_makes_the_question_unusable(schema: bytes) -> None:
    with pytest.raises(SchemaError):
        check(Reply(choice="planning", confidence=1.0), msgspec.structs.replace(ASKED, schema=msgspec.Raw(schema)))


def test_the_message_to_the_model_is_short_whatever_it_said() -> None:
    with pytest.raises(Inadmissible) as caught:
        read(json.dumps({"choice": "x" * 100_000, "confidence": 1}), ASKED)
    assert len(str(caught.value)) < 300


def test_the_schema_that_is_sent_admits_what_is_admissible() -> None:
    asked = msgspec.structs.replace(ASKED, schema=msgspec.Raw(b'{"type": "object"}'))
    valid: dict[str, Any] = {
        "choice": "memory",
        "confidence": 1,
        "forecast": "none",
        "forecast_probability": 0.5,
        "because": ["so"],
        "answer": {},
    }
    validator = jsonschema.Draft202012Validator(reply_schema(asked))
    assert validator.is_valid(valid)
    assert not validator.is_valid({**valid, "choice": "rm -rf"})
    assert not validator.is_valid({**valid, "tool": "rm -rf"})
    assert read(json.dumps(valid), asked).choice == "memory"
