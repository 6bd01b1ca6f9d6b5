"""`wakeful trace` and `wakeful timeline`: processes as lanes of time, for the Perfetto viewer and as a picture."""

from __future__ import annotations

import sys
from pathlib import Path

import click

from wakeful.cli.draw_lanes import draw
from wakeful.cli.mistakes import Mistake
from wakeful.cli.options import journal_option, option, reading
from wakeful.journal.lanes import Lanes, lanes
from wakeful.journal.sqlite import SqliteJournal
from wakeful.journal.trace import write_trace
from wakeful.journal.views import NoSuchEvent, find_event, history
from wakeful.journal.wording.words import count

_event_option = option("--event", default=None, metavar="ID", help="Only this event's processes, and those that preempted them.")


@click.command("trace")
@journal_option
@option("--out", type=click.Path(path_type=Path, dir_okay=False), default=None, help="The file; without it, standard output.")
@_event_option
@option("--last", type=click.IntRange(min=0), default=0, show_default=True, help="Only the last N processes; 0: all.")
def trace_command(journal: Path | None, out: Path | None, event: str | None, last: int) -> None:
    """Write a journal as a trace for ui.perfetto.dev or chrome://tracing.

    Every process is a lane with its states as slices; preemptions are arrows, and evidence, answers, verdicts and operators'
    acts are marks.
    """
    with reading(journal) as opened:
        told = _lanes(opened, event, last)
    if out is None:
        write_trace(told, sys.stdout.buffer)
        sys.stdout.buffer.flush()
        return
    try:
        with out.open("wb") as file:
            written = write_trace(told, file)
    except OSError as error:
        raise Mistake(f"{out} cannot be written: {error.strerror}; name another file with --out") from error
    click.echo(f"{count(len(told.lanes), 'process', 'processes')} in {count(written, 'trace event')} written to {out}", err=True)


@click.command("timeline")
@journal_option
@option("--out", type=click.Path(path_type=Path, dir_okay=False), required=True, help="The picture: FILE.svg or FILE.png.")
@_event_option
@option("--last", type=click.IntRange(min=0), default=30, show_default=True, help="Only the last N processes; 0: all.")
def timeline_command(journal: Path | None, out: Path, event: str | None, last: int) -> None:
    """Draw processes as lanes of time: states, preemptions as arrows, evidence as marks. Needs the extra 'plots'."""
    if out.suffix not in (".svg", ".png"):
        raise click.UsageError(f"{out} is neither .svg nor .png: give --out FILE.svg or FILE.png")
    with reading(journal) as opened:
        told = _lanes(opened, event, last)
    if not told.lanes:
        raise Mistake("the journal has no process yet: there is nothing to draw")
    try:
        draw(told, out)
    except OSError as error:
        raise Mistake(f"{out} cannot be written: {error.strerror}; name another file with --out") from error
    click.echo(f"{count(len(told.lanes), 'process', 'processes')} drawn to {out}", err=True)


def _lanes(journal: SqliteJournal, event: str | None, last: int) -> Lanes:
    if event is None:
        return lanes(journal, last=last)
    try:
        found = find_event(history(journal), event)
    except NoSuchEvent as error:
        raise Mistake(f"{error}; 'wakeful events' lists them") from None
    return lanes(journal, found.event.id, last)
