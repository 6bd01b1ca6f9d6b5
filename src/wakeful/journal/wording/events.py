"""An event in words: when, how grave, with which fields, in which context."""

from __future__ import annotations

from wakeful.facts.time import to_s
from wakeful.facts.values import Field, Value
from wakeful.journal.results import in_words
from wakeful.journal.story import ProcessStory, Story
from wakeful.journal.wording.words import count, duration, instant

CRITICALITY = ("routine", "notable", "urgent", "critical")


def event_rows(told: Story) -> list[tuple[str, str]]:
    """The event as named rows; a row may be empty."""
    event = told.event
    rows: list[tuple[str, str]] = []
    robot = f", robot {event.robot}" if event.robot else ""
    rows.append(("id", f"{event.id} (line {told.position}; {event.source}, position {event.position}{robot})"))
    since = f"±{duration(to_s(event.stamp.uncertainty_ns))}, " if event.stamp.uncertainty_ns else ""
    rows.append(("when", f"{instant(event.stamp.source_ns)} ({since}{event.stamp.clock} clock)"))
    deadline = f", to be treated within {duration(event.deadline_s)}" if event.deadline_s is not None else ""
    stands = f"stands for {count(event.observations, 'observation')}" if event.observations > 1 else ""
    again = f"came {count(told.duplicates, 'time')} again" if told.duplicates else ""
    weight = f"{CRITICALITY[event.criticality]}{deadline}; {event.relation.value} against what was remembered"
    rows.append(("weight", "; ".join(part for part in (weight, stands, again) if part)))
    rows.append(("fields", ", ".join(f"{name} = {in_words(_plain(value), 4)}" for name, value in event.fields.items())))
    context = {"task": event.context.task, "zone": event.context.zone, "safety": "yes" if event.context.safety else ""}
    parts = [f"{name} = {value}" for name, value in context.items() if value]
    parts += [f"{name} = {in_words(_plain(value), 4)}" for name, value in event.context.fields.items()]
    rows.append(("context", ", ".join(parts)))
    if event.condition:
        parts = [part for part in event.condition.key.split("|") if part not in ("", event.source)]
        rows.append(("condition", f"{' | '.join(parts)} ({event.condition.phase.value})"))
    return rows


def _plain(value: Field) -> Value:
    return list(value) if isinstance(value, tuple) else value


def role_words(process: ProcessStory) -> str:
    """What a child or a reopening is there for."""
    if process.role == "child":
        return f"{process.treatment.capitalize()} for process {process.parent} (process {process.id})"
    return f"Reopening: process {process.id} thinks again about what process {process.reopens} concluded"
