"""Recorded answers in words: a reasoner's choice, pieces of evidence, episodes from memory, a child's result."""

from __future__ import annotations

import msgspec

from wakeful.facts.asking import Kind
from wakeful.facts.lines import Answered
from wakeful.facts.values import Value
from wakeful.journal.results import in_words
from wakeful.journal.wording.words import count, percent, plain

_LONGEST = 160


def answer_words(answered: Answered) -> str:
    """One answer in words; empty for an empty one. A choice of treatment is told without its reasons: the decision has them."""
    value = _plain(answered)
    if value is None or value == []:
        return "nothing like it" if answered.kind is Kind.RECALL else ""
    if answered.kind is Kind.RECALL and isinstance(value, list):
        return _episodes(value)
    if isinstance(value, dict) and "choice" in value:
        return _reply(value, reasons=answered.key != "treatment")
    if isinstance(value, dict) and isinstance(value.get("says"), str):
        return plain(f"“{value['says']}”", _LONGEST)
    if answered.kind is Kind.EVIDENCE and isinstance(value, list):
        return plain(in_words([_piece(entry) for entry in value]), _LONGEST)
    return plain(in_words(value), _LONGEST)


def _plain(answered: Answered) -> Value:
    try:
        value: Value = msgspec.json.decode(bytes(answered.value))
    except msgspec.DecodeError:
        return None
    return value


def _piece(evidence: Value) -> Value:
    return evidence.get("value", evidence.get("topic")) if isinstance(evidence, dict) else evidence


def _episodes(episodes: list[Value]) -> str:
    best = episodes[0]
    if not isinstance(best, dict):
        return count(len(episodes), "episode")
    likeness = best.get("likeness")
    like = f", likeness {likeness:.2f}" if isinstance(likeness, int | float) else ""
    outcome = best.get("outcome")
    ended = f", which ended in {outcome}" if outcome else ", not judged yet"
    return plain(
        f"{count(len(episodes), 'episode')}, the closest {best.get('kind', '')} of {best.get('entity', '')}{like}{ended}"
    )


def _reply(reply: dict[str, Value], reasons: bool) -> str:
    confidence = reply.get("confidence")
    sure = f", confidence {confidence:.2f}" if isinstance(confidence, int | float) else ""
    label, probability = reply.get("forecast"), reply.get("forecast_probability")
    foretold = ""
    if label:
        foretold = f", expecting {label}" + (f" {percent(probability)}" if isinstance(probability, int | float) else "")
    because = reply.get("because")
    why = f", because {'; '.join(str(each) for each in because)}" if reasons and isinstance(because, list) and because else ""
    return plain(f"{reply['choice']}{sure}{foretold}{why}")
