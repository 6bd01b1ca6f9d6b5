"""A process's result in words, and what the world showed of it since."""

from __future__ import annotations

from wakeful.cli.terminal import heading, paragraph, row
from wakeful.cli.words import duration, instant, percent, plain
from wakeful.facts.time import to_s
from wakeful.facts.values import Value
from wakeful.journal.results import in_words, result_fields
from wakeful.journal.story import ProcessStory, VerdictTold
from wakeful.journal.views import History, Story

#: Fields of every result that are told apart from the treatment's own.
_COMMON = {"type", "says", "confidence", "rests_on", "would_change", "forecast", "proposes"}
_SHOWN = 8


def print_result(read: History, told: Story, process: ProcessStory) -> None:
    """Print the typed result: its sentence, the treatment's own fields, what it rests on, proposals and forecast."""
    fields = result_fields(process.result)
    if not fields:
        return
    confidence = fields.get("confidence")
    sure = f", confidence {confidence:.2f}" if isinstance(confidence, int | float) else ""
    heading(f"Result of {plain(str(fields.get('type', process.treatment)))}{sure}")
    paragraph(str(fields.get("says", "")))
    for name, value in fields.items():
        if name not in _COMMON and value not in (None, "", [], {}):
            _listed(name.replace("_", " "), [line for entry in _records(value) for line in record_lines(entry)])
    rests_on, would_change, proposes = (fields.get(name) for name in ("rests_on", "would_change", "proposes"))
    _listed("rests on", [_ground(read, told, str(each)) for each in rests_on] if isinstance(rests_on, list) else [])
    _listed("would change it", [str(each) for each in would_change] if isinstance(would_change, list) else [])
    _listed("proposes", [_proposal(each) for each in proposes if isinstance(each, dict)] if isinstance(proposes, list) else [])
    if process.forecast:
        row("forecast", _forecast(told, process))


def _forecast(told: Story, process: ProcessStory) -> str:
    if process.forecast is None:
        return ""
    forecast = process.forecast
    shares = forecast.probabilities or {forecast.label: forecast.probability}
    spread = ", ".join(f"{label} {percent(share)}" for label, share in sorted(shares.items(), key=lambda item: -item[1])[:4])
    if process.closes_ns is None:
        return spread
    return f"{spread}; the world may show it within {duration(to_s(process.closes_ns - told.admitted_ns))} of the event"


def _records(value: Value) -> list[Value]:
    """A list of records as its records, anything else as one."""
    return value if isinstance(value, list) and value and all(isinstance(entry, dict) for entry in value) else [value]


def record_lines(value: Value) -> list[str]:
    """A record in words, and each record that it holds on a line of its own.

    >>> record_lines({"name": "J3", "signs": [{"sign": "heat", "now": 71.0}, {"sign": "noise", "now": 2.0}]})
    ['J3', '· heat: now = 71', '· noise: now = 2']
    """
    if not isinstance(value, dict):
        return [record_words(value)]
    inner = {name: each for name, each in value.items() if _records(each) is each and isinstance(each, list)}
    outer = {name: each for name, each in value.items() if name not in inner}
    return [record_words(outer)] * bool(outer) + [
        f"· {record_words(entry)}" for each in inner.values() for entry in _records(each)
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


def _listed(label: str, entries: list[str]) -> None:
    for index, entry in enumerate(entries[:_SHOWN]):
        row(label if index == 0 else "", entry)
    if len(entries) > _SHOWN:
        row("", f"and {len(entries) - _SHOWN} more")


def _ground(read: History, told: Story, ground: str) -> str:
    """What a result rests on; an event's id with what that event was."""
    identity = ground.removeprefix("event ")
    if identity == told.event.id:
        return "this event"
    past = read.events.get(identity)
    if past is None:
        return ground
    return f"event {identity[:10]}: {past.event.kind} of {past.event.entity}, {instant(past.event.stamp.source_ns)}"


def _proposal(proposal: dict[str, Value]) -> str:
    conditions = proposal.get("preconditions")
    only_if = f", only if {'; '.join(str(each) for each in conditions)}" if isinstance(conditions, list) and conditions else ""
    return f"{proposal.get('effect', '')} (authority: {proposal.get('authority', 'operator')}){only_if}"


def print_since(told: Story, process: ProcessStory) -> None:
    """Print the outcomes and verdicts on a result, and what was learned from them."""
    if process.role == "child" or not process.forecast:
        return
    heading("What happened since")
    if not process.verdicts:
        left_s = to_s((process.closes_ns or told.now_ns) - told.now_ns)
        paragraph(f"nothing yet: the window closes in {duration(left_s)}" if left_s > 0 else "nothing that decides it")
    for verdict in process.verdicts:
        paragraph(_verdict(told, process, verdict), 2, 2)
    for experience in told.experiences:
        if experience.process == process.id:
            paragraph(
                f"learned from as experience {experience.id}: {_lesson(experience.treatment_label, experience.treatment)}", 2, 2
            )


def _lesson(right: str, applied: str) -> str:
    if not right:
        return f"it counts against {applied} for such an event; which treatment would have been right is not known"
    return f"{right} was right for such an event" if right == applied else f"{right} would have been right, not {applied}"


def _verdict(told: Story, process: ProcessStory, verdict: VerdictTold) -> str:
    judged, outcome = verdict.judged, verdict.outcome
    forecast = f"the forecast was {judged.predicted}: {judged.verdict}"
    if outcome is None:
        if judged.verdict == "undecided":
            return f"{forecast}{f' ({judged.why})' if judged.why else ''}"
        window_s = to_s((process.closes_ns or verdict.at_ns) - told.admitted_ns)
        return f"no outcome came within {duration(window_s)}, which counts as {judged.label}; {forecast}"
    after = duration(to_s(outcome.at_ns - told.event.stamp.source_ns))
    who = {"world": "the world showed", "person": "a person said", "reasoner": "a reasoner said"}[outcome.origin]
    whom = "" if outcome.entity == "*" else f" of {outcome.entity}"
    acted = ", after the result had been acted on" if outcome.acted_on else ""
    lead = ""
    if judged.lead_ns is not None:
        way = "after it was concluded" if judged.lead_ns >= 0 else "before it was concluded"
        lead = f" ({duration(abs(to_s(judged.lead_ns)))} {way})"
    why = f" ({judged.why})" if judged.why else ""
    return f"{after} after the event{lead} {who} {outcome.label}{whom}{acted}; {forecast}{why}"
