"""What a model said, checked against the question: only registered options and labels come through."""

from __future__ import annotations

from typing import Annotated

import msgspec

from wakeful.contracts.reasoner import ReasonerError
from wakeful.deliberation.prompt import clean
from wakeful.deliberation.schema import SchemaError, mismatch
from wakeful.facts.asking import Question, Reply
from wakeful.facts.values import NOTHING, Raw, Value

REASONS = 8
REASON_CHARS = 400

Probability = Annotated[float, msgspec.Meta(ge=0.0, le=1.0)]


class Inadmissible(ReasonerError):
    """The answer cannot be used; the message says why, in words that the model may be shown."""


class _Said(msgspec.Struct):
    """The keys that are read. Whatever else the object holds (tools to call, treatments to register) nobody looks at."""

    choice: str
    confidence: Probability
    forecast: str | None = None
    forecast_probability: Probability | None = None
    because: str | list[str] = []
    answer: Raw = NOTHING


def read(text: str, question: Question) -> Reply:
    """The reply in a model's text: one JSON object, bare or in one code fence.

    Args:
        text: what the model said; nothing in it is trusted.
        question: whose options, labels and schema decide.

    Raises:
        Inadmissible: no such object, a key missing or of the wrong type, a probability outside [0, 1], a choice that is not an
            option, a forecast that is not a label, an answer that its schema refuses.
        SchemaError: the question's schema cannot be checked.
    """
    try:
        said = msgspec.json.decode(_unfenced(text), type=_Said)
    except (msgspec.MsgspecError, RecursionError, UnicodeError) as error:
        raise Inadmissible(f"the answer is not the JSON object asked for: {clean(str(error), 200)}") from None
    because = (said.because,) if isinstance(said.because, str) else tuple(said.because)
    reply = Reply(
        choice=said.choice.strip(),
        confidence=said.confidence,
        forecast=(said.forecast or "").strip(),
        forecast_probability=said.forecast_probability or 0.0,
        because=tuple(kept for one in because[:REASONS] if (kept := clean(one, REASON_CHARS))),
        answer=said.answer if question.schema != NOTHING else NOTHING,
    )
    return check(reply, question)


def check(reply: Reply, question: Question) -> Reply:
    """The reply itself, where the question admits it; without its forecast where no label was asked for.

    Raises:
        Inadmissible: it does not; the message says why.
        SchemaError: the question's schema cannot be checked.
    """
    if reply.choice not in question.options:
        raise Inadmissible(f"choice is {_quoted(reply.choice)}, which is not one of OPTIONS: {', '.join(question.options)}")
    for name, value in (("confidence", reply.confidence), ("forecast_probability", reply.forecast_probability)):
        if not 0.0 <= value <= 1.0:
            raise Inadmissible(f"{name} is {value}, which is not between 0 and 1")
    if not question.labels:
        reply = msgspec.structs.replace(reply, forecast="", forecast_probability=0.0)
    elif reply.forecast and reply.forecast not in question.labels:
        raise Inadmissible(f"forecast is {_quoted(reply.forecast)}, which is not one of LABELS: {', '.join(question.labels)}")
    if question.schema != NOTHING:
        wrong = answer_mismatch(reply.answer, question.schema)
        if wrong is not None:
            raise Inadmissible(f"answer does not fit its schema: {clean(wrong, 200)}")
    return reply


def answer_mismatch(answer: Raw, schema: Raw) -> str | None:
    """What is wrong with an answer by the question's schema, or None. Raises SchemaError where the schema cannot be checked."""
    try:
        wanted: Value = msgspec.json.decode(schema)
    except msgspec.MsgspecError as error:
        raise SchemaError(f"the question's schema is not JSON: {error}") from None
    try:
        value: Value = msgspec.json.decode(answer)
    except (msgspec.MsgspecError, RecursionError) as error:
        return f"it is not JSON: {error}"
    return mismatch(value, wanted)


def reply_schema(question: Question) -> dict[str, Value]:
    """The JSON schema of the whole reply, for endpoints that can be held to one: options and labels as enumerations."""
    probability: Value = {"type": "number", "minimum": 0, "maximum": 1}
    keys: dict[str, Value] = {
        "choice": {"type": "string", "enum": list(question.options)},
        "confidence": probability,
        "forecast": {"type": "string", "enum": list(question.labels) or [""]},
        "forecast_probability": probability,
        "because": {"type": "array", "items": {"type": "string", "maxLength": REASON_CHARS}, "minItems": 1, "maxItems": 4},
    }
    if question.schema != NOTHING:
        keys["answer"] = msgspec.json.decode(question.schema)
    return {"type": "object", "properties": keys, "required": list(keys), "additionalProperties": False}


def _unfenced(text: str) -> str:
    stripped = text.strip()
    if stripped.startswith("```") and stripped.endswith("```") and "\n" in stripped:
        return stripped[stripped.index("\n") : -3].strip()
    return stripped


def _quoted(text: str) -> str:
    return repr(clean(text, 80))
