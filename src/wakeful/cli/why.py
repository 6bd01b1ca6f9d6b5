"""`wakeful why EVENT`: what was thought about one event, why, and what has happened since."""

from __future__ import annotations

from pathlib import Path
from random import Random

import click

from wakeful.cli.mistakes import Mistake
from wakeful.cli.options import journal_option, json_option, option, print_json, reading
from wakeful.cli.outcome import print_result, print_since
from wakeful.cli.reasons import print_decisions
from wakeful.cli.terminal import heading, paragraph, row, say, width
from wakeful.cli.thinking import print_thinking
from wakeful.cli.words import count, duration, instant
from wakeful.facts.time import to_s
from wakeful.facts.values import Field, Value
from wakeful.journal.results import in_words
from wakeful.journal.sqlite import SqliteJournal
from wakeful.journal.story import ProcessStory
from wakeful.journal.views import EventPast, History, NoSuchEvent, Story, find_event, history, story

_CRITICALITY = ("routine", "notable", "urgent", "critical")


@click.command("why")
@click.argument("event", required=False)
@journal_option
@option("--sample", type=click.IntRange(min=1), default=None, help="In place of an event: so many, drawn at random.")
@option("--seed", type=int, default=0, show_default=True, help="The same seed draws the same events.")
@json_option
def why_command(event: str | None, journal: Path | None, sample: int | None, seed: int, as_json: bool) -> None:
    """Tell the story of one event, by its id or the beginning of it.

    Candidates with their probabilities, the numbers that were compared, reasons, what it rests on, what was asked and
    answered, the result in words, and what the world showed since.
    """
    if (event is None) == (sample is None):
        raise click.UsageError("name one event, by its id or the beginning of it, or give --sample N")
    with reading(journal) as opened:
        read = history(opened)
        found = _sample(read, sample, seed) if sample is not None else [_named(read, event or "")]
        stories = [story(read, past) for past in found]
        if as_json:
            print_json(stories[0] if sample is None else stories)
            return
        for index, told in enumerate(stories):
            if index:
                heading("─" * width())
                say()
            print_story(opened, read, told)


def _named(read: History, event: str) -> EventPast:
    try:
        return find_event(read, event)
    except NoSuchEvent as error:
        near = f"; close are {', '.join(error.close)}" if error.close else ""
        raise Mistake(f"{error}{near}; 'wakeful events' lists them") from None


def _sample(read: History, sample: int, seed: int) -> list[EventPast]:
    drawn = Random(seed).sample(sorted(read.events), min(sample, len(read.events)))
    return sorted((read.events[identity] for identity in drawn), key=lambda past: past.position)


def print_story(journal: SqliteJournal, read: History, told: Story) -> None:
    """Print all of an event's story."""
    _event(told)
    for process in told.processes:
        if process.role != "root":
            heading(_role(process))
            if process.because:
                paragraph(f"because {process.because}")
        print_decisions(journal, read, told, process)
        print_thinking(read, told, process)
        print_result(read, told, process)
        print_since(told, process)
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
    row("id", f"{event.id} (line {told.position}; {event.source}, position {event.position}{robot})")
    since = f"±{duration(to_s(event.stamp.uncertainty_ns))}, " if event.stamp.uncertainty_ns else ""
    row("when", f"{instant(event.stamp.source_ns)} ({since}{event.stamp.clock} clock)")
    deadline = f", to be treated within {duration(event.deadline_s)}" if event.deadline_s is not None else ""
    stands = f"stands for {count(event.observations, 'observation')}" if event.observations > 1 else ""
    again = f"came {count(told.duplicates, 'time')} again" if told.duplicates else ""
    weight = f"{_CRITICALITY[event.criticality]}{deadline}; {event.relation.value} against what was remembered"
    row("weight", "; ".join(part for part in (weight, stands, again) if part))
    row("fields", ", ".join(f"{name} = {in_words(_value(value), 4)}" for name, value in event.fields.items()))
    context = {"task": event.context.task, "zone": event.context.zone, "safety": "yes" if event.context.safety else ""}
    parts = [f"{name} = {value}" for name, value in context.items() if value]
    parts += [f"{name} = {in_words(_value(value), 4)}" for name, value in event.context.fields.items()]
    row("context", ", ".join(parts))
    if event.condition:
        parts = [part for part in event.condition.key.split("|") if part not in ("", event.source)]
        row("condition", f"{' | '.join(parts)} ({event.condition.phase.value})")


def _value(value: Field) -> Value:
    return list(value) if isinstance(value, tuple) else value


def _role(process: ProcessStory) -> str:
    if process.role == "child":
        return f"{process.treatment.capitalize()} for process {process.parent} (process {process.id})"
    return f"Reopening: process {process.id} thinks again about what process {process.reopens} concluded"
