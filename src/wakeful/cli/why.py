"""`wakeful why EVENT`: what was thought about one event, why, and what has happened since."""

from __future__ import annotations

from pathlib import Path

import click

from wakeful.cli.mistakes import Mistake
from wakeful.cli.options import journal_option, json_option, print_json, reading
from wakeful.cli.reasons import print_decisions
from wakeful.cli.terminal import heading, paragraph, say
from wakeful.cli.thinking import print_thinking
from wakeful.cli.words import count, duration, instant, percent, plain
from wakeful.facts.time import to_s
from wakeful.facts.values import Field, Value
from wakeful.journal.results import in_words, result_fields
from wakeful.journal.story import ProcessStory, VerdictTold
from wakeful.journal.views import History, NoSuchEvent, Story, find_event, history, story

_CRITICALITY = ("routine", "notable", "urgent", "critical")

#: Fields of every result that are told apart from the treatment's own.
_COMMON = {"type", "says", "confidence", "rests_on", "would_change", "forecast", "proposes"}


@click.command("why")
@click.argument("event")
@journal_option
@json_option
def why_command(event: str, journal: Path | None, as_json: bool) -> None:
    """Tell the story of one event, by its id or the beginning of it.

    Candidates with their probabilities, the numbers that were compared, reasons, what it rests on, what was asked and
    answered, the result in words, and what the world showed since.
    """
    with reading(journal) as opened:
        read = history(opened)
    try:
        told = story(read, find_event(read, event))
    except NoSuchEvent as error:
        near = f"; close are {', '.join(error.close)}" if error.close else ""
        raise Mistake(f"{error}{near}; 'wakeful events' lists them") from None
    if as_json:
        print_json(told)
    else:
        print_story(read, told)


def print_story(read: History, told: Story) -> None:
    """Print all of an event's story."""
    _event(told)
    for process in told.processes:
        if process.role != "root":
            heading(_role(process))
            if process.because:
                paragraph(f"because {process.because}")
        print_decisions(read, told, process)
        print_thinking(read, told, process)
        _result(process, told)
        _since(process, told)
    if told.trust:
        heading("Trust")
        for change in told.trust:
            trusted = change.trusted
            paragraph(f"{trusted.treatment} {trusted.before:.3f} → {trusted.after:.3f}: {trusted.why}", 2, 2)


def _event(told: Story) -> None:
    event = told.event
    say(f"{event.kind} of {event.entity or event.robot or 'the robot'}", bold=True)
    if event.says:
        paragraph(event.says)
    heading("Event")
    robot = f", robot {event.robot}" if event.robot else ""
    _row("id", f"{event.id} (line {told.position}; {event.source}, position {event.position}{robot})")
    since = f"±{duration(to_s(event.stamp.uncertainty_ns))}, " if event.stamp.uncertainty_ns else ""
    _row("when", f"{instant(event.stamp.source_ns)} ({since}{event.stamp.clock} clock)")
    deadline = f", to be treated within {duration(event.deadline_s)}" if event.deadline_s is not None else ""
    stands = f"stands for {count(event.observations, 'observation')}" if event.observations > 1 else ""
    again = f"came {count(told.duplicates, 'time')} again" if told.duplicates else ""
    weight = f"{_CRITICALITY[event.criticality]}{deadline}; {event.relation.value} against what was remembered"
    _row("weight", "; ".join(part for part in (weight, stands, again) if part))
    _row("fields", ", ".join(f"{name} = {in_words(_value(value), 4)}" for name, value in event.fields.items()))
    context = {"task": event.context.task, "zone": event.context.zone, "safety": "yes" if event.context.safety else ""}
    parts = [f"{name} = {value}" for name, value in context.items() if value]
    parts += [f"{name} = {in_words(_value(value), 4)}" for name, value in event.context.fields.items()]
    _row("context", ", ".join(parts))
    if event.condition:
        _row("condition", f"{event.condition.key.strip('|')} ({event.condition.phase.value})")


def _value(value: Field) -> Value:
    return list(value) if isinstance(value, tuple) else value


def _role(process: ProcessStory) -> str:
    if process.role == "child":
        return f"{process.treatment.capitalize()} for process {process.parent} (process {process.id})"
    return f"Reopened: process {process.id} thinks again about what process {process.reopens} concluded"


def _result(process: ProcessStory, told: Story) -> None:
    fields = result_fields(process.result)
    if not fields:
        return
    confidence = fields.get("confidence")
    sure = f", confidence {confidence:.2f}" if isinstance(confidence, int | float) else ""
    heading(f"Result of {plain(str(fields.get('type', process.treatment)))}{sure}")
    paragraph(str(fields.get("says", "")), 2, 2)
    for name, value in fields.items():
        if name not in _COMMON and value not in (None, "", [], {}):
            _field(name.replace("_", " "), value)
    _listed("rests on", fields.get("rests_on"))
    _listed("would change it", fields.get("would_change"))
    proposes = fields.get("proposes")
    for proposal in proposes if isinstance(proposes, list) else []:
        if isinstance(proposal, dict):
            _row(
                "proposes",
                f"{proposal.get('effect', '')} (authority: {proposal.get('authority', 'operator')})" + _only_if(proposal),
            )
    if process.forecast:
        forecast = process.forecast
        others = sorted(forecast.probabilities.items(), key=lambda row: -row[1])
        spread = ", ".join(f"{label} {percent(probability)}" for label, probability in others[:4]) if others else ""
        until = ""
        if process.closes_ns is not None:
            until = f"; the world may show it until {duration(to_s(process.closes_ns - told.admitted_ns))} after the event"
        _row("forecast", (spread or f"{forecast.label} {percent(forecast.probability)}") + until)


def _only_if(proposal: dict[str, Value]) -> str:
    conditions = proposal.get("preconditions")
    return f", only if {'; '.join(str(each) for each in conditions)}" if isinstance(conditions, list) and conditions else ""


def _field(name: str, value: Value) -> None:
    """One field of a typed result: a list of records as one line each, anything else in one."""
    if isinstance(value, list) and value and all(isinstance(entry, dict) for entry in value):
        for index, entry in enumerate(value[:6]):
            _row(name if index == 0 else "", in_words(_filled(entry)))
        if len(value) > 6:
            _row("", f"and {len(value) - 6} more")
        return
    _row(name, in_words(_filled(value)))


def _filled(value: Value) -> Value:
    """A record without its empty fields."""
    if isinstance(value, dict):
        return {name.replace("_", " "): _filled(entry) for name, entry in value.items() if entry not in (None, "", [], {})}
    return value


def _listed(label: str, value: Value) -> None:
    entries = [str(entry) for entry in value] if isinstance(value, list) else []
    for index, entry in enumerate(entries[:6]):
        _row(label if index == 0 else "", entry)
    if len(entries) > 6:
        _row("", f"and {len(entries) - 6} more")


def _since(process: ProcessStory, told: Story) -> None:
    if process.role == "child" or not process.forecast:
        return
    heading("What happened since")
    if not process.verdicts:
        left_s = to_s((process.closes_ns or told.now_ns) - told.now_ns)
        paragraph(f"nothing yet: the window closes in {duration(left_s)}" if left_s > 0 else "nothing that decides it")
    for verdict in process.verdicts:
        _verdict(verdict, told)
    for experience in told.experiences:
        if experience.process == process.id:
            learned = f"learned from as experience {experience.id}"
            paragraph(f"{learned}: {_lesson(experience.treatment_label, experience.treatment)}")


def _lesson(right: str, applied: str) -> str:
    if not right:
        return f"{applied} counts as a negative, the right treatment is not known"
    return f"{right} is right for such an event" if right == applied else f"{right} would have been right, not {applied}"


def _verdict(verdict: VerdictTold, told: Story) -> None:
    judged = verdict.judged
    why = f" ({judged.why})" if judged.why else ""
    if verdict.outcome is None:
        passed = "the window passed and the world showed" if judged.verdict != "undecided" else "nothing was shown either way:"
        paragraph(f"{passed} {judged.label or 'nothing'}: {judged.verdict}{why}")
        return
    outcome = verdict.outcome
    after = duration(to_s(outcome.at_ns - told.event.stamp.source_ns))
    whom = "the robot" if outcome.entity == "*" else outcome.entity
    who = {"world": "the world showed", "person": "a person said", "reasoner": "a reasoner said"}[outcome.origin]
    acted = ", after the result had been acted on" if outcome.acted_on else ""
    told_so = f", the forecast was {judged.predicted}"
    lead = f" {duration(to_s(judged.lead_ns))} ahead" if judged.lead_ns else ""
    paragraph(f"{after} after the event {who} {outcome.label} of {whom}{acted}{told_so}{lead}: {judged.verdict}{why}")


def _row(label: str, text: str) -> None:
    if text:
        paragraph(text, 2, 17, label.ljust(17))
