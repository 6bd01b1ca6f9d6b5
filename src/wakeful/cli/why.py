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
from wakeful.journal.sqlite import SqliteJournal
from wakeful.journal.views import EventPast, History, NoSuchEvent, Story, find_event, history, story
from wakeful.journal.wording.events import event_rows, role_words


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
            heading(role_words(process))
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
    for name, text in event_rows(told):
        row(name, text)
