"""A recorded result in words: the treatment's own fields, what it rests on, what it proposes and forecasts."""

from __future__ import annotations

from wakeful.facts.time import to_s
from wakeful.facts.values import Value
from wakeful.journal.history import History
from wakeful.journal.results import in_words
from wakeful.journal.story import ProcessStory, Story
from wakeful.journal.wording.words import duration, instant, percent

#: Fields of every result that are told apart from the treatment's own.
COMMON = {"type", "says", "confidence", "rests_on", "would_change", "forecast", "proposes"}


def own_lines(fields: dict[str, Value]) -> list[tuple[str, list[str]]]:
    """The treatment's own fields that say something, each with its name and its lines."""
    return [
        (name.replace("_", " "), [line for entry in records(value) for line in record_lines(entry)])
        for name, value in fields.items()
        if name not in COMMON and value not in (None, "", [], {})
    ]


def records(value: Value) -> list[Value]:
    """A list of records as its records, anything else as one."""
    return value if isinstance(value, list) and value and all(isinstance(entry, dict) for entry in value) else [value]


def record_lines(value: Value) -> list[str]:
    """A record in words, and each record that it holds on a line of its own.

    >>> record_lines({"name": "J3", "signs": [{"sign": "heat", "now": 71.0}, {"sign": "noise", "now": 2.0}]})
    ['J3', '· heat: now = 71', '· noise: now = 2']
    """
    if not isinstance(value, dict):
        return [record_words(value)]
    inner = {name: each for name, each in value.items() if records(each) is each and isinstance(each, list)}
    outer = {name: each for name, each in value.items() if name not in inner}
    return [record_words(outer)] * bool(outer) + [
        f"· {record_words(entry)}" for each in inner.values() for entry in records(each)
    ]


def record_words(value: Value) -> str:
    """A record of a result in words, its empty fields left out; one that begins with a name begins with that name.

    >>> record_words({"fault": "worn pads", "posterior": 0.9293, "shown": ["grip_lost", "stall"], "check": ""})
    'worn pads: posterior = 0.929; shown = grip_lost, stall'
    """
    if not isinstance(value, dict):
        return in_words(value)
    filled = {name.replace("_", " "): each for name, each in value.items() if each not in (None, "", [], {})}
    head = ""
    first = next(iter(filled), "")
    if first and isinstance(filled[first], str):
        head = str(filled.pop(first)) + (": " if filled else "")
    return head + "; ".join(f"{name} = {in_words(each)}" for name, each in filled.items())


def ground_words(read: History, told: Story, ground: str) -> str:
    """What a result rests on; an event's id with what that event was."""
    identity = ground.removeprefix("event ")
    if identity == told.event.id:
        return "this event"
    past = read.events.get(identity)
    if past is None:
        return ground
    return f"event {identity[:10]}: {past.event.kind} of {past.event.entity}, {instant(past.event.stamp.source_ns)}"


def proposal_words(proposal: dict[str, Value]) -> str:
    """An effect that is proposed, by whose authority and only if what."""
    conditions = proposal.get("preconditions")
    only_if = f", only if {'; '.join(str(each) for each in conditions)}" if isinstance(conditions, list) and conditions else ""
    return f"{proposal.get('effect', '')} (authority: {proposal.get('authority', 'operator')}){only_if}"


def forecast_words(told: Story, process: ProcessStory) -> str:
    """What the result says the world will show, and within what time; empty where it says nothing."""
    if process.forecast is None:
        return ""
    forecast = process.forecast
    shares = forecast.probabilities or {forecast.label: forecast.probability}
    spread = ", ".join(f"{label} {percent(share)}" for label, share in sorted(shares.items(), key=lambda item: -item[1])[:4])
    if process.closes_ns is None:
        return spread
    return f"{spread}; the world may show it within {duration(to_s(process.closes_ns - told.admitted_ns))} of the event"
