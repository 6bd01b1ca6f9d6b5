"""`wakeful compact` and `wakeful backup`: a journal's size, and a copy of it."""

from __future__ import annotations

from pathlib import Path

import click

from wakeful.cli.options import journal_option, named_journal, option, reading
from wakeful.cli.terminal import say
from wakeful.facts.lines import Compacted
from wakeful.journal import SqliteJournal, open_journal
from wakeful.journal.backup import back_up
from wakeful.journal.retention import Retention
from wakeful.journal.wording.words import count

_DEFAULT = Retention()


@click.command("compact")
@journal_option
@option(
    "--days", type=click.FloatRange(min=0.0), default=_DEFAULT.days, show_default=True, help="Keep so many days. 0: no limit."
)
@option(
    "--events",
    "events",
    type=click.IntRange(min=0),
    default=_DEFAULT.events,
    show_default=True,
    help="Keep the newest so many events. 0: no limit.",
)
@option(
    "--megabytes",
    type=click.IntRange(min=0),
    default=_DEFAULT.megabytes,
    show_default=True,
    help="Keep about so much. 0: no limit.",
)
@option(
    "--least",
    type=click.IntRange(min=0),
    default=_DEFAULT.least,
    show_default=True,
    help="Keep the newest so many events whatever the limits say.",
)
def compact_command(journal: Path | None, days: float, events: int, megabytes: int, least: int) -> None:
    """Give up what is older than the retention now, all of it; bring a journal of an older schema to today's.

    A mind that runs does the same by itself, a little after each commit. Events that are open or owed are kept.
    """
    path = named_journal(journal)
    before = path.stat().st_size
    retention = Retention(days=days, events=events, megabytes=megabytes, least=least)
    with open_journal(path, retention=retention) as opened:
        if opened.migrated is not None:
            kept = opened.migrated.backup
            say(f"from schema {opened.migrated.version}, {count(opened.migrated.lines, 'line')}; as it was: {kept}")
        while opened.tidy(1):
            pass
        given_up = _given_up(opened)
    after = path.stat().st_size
    say(f"{before / 1e6:,.1f} MB before, {after / 1e6:,.1f} MB now; {given_up}")


@click.command("backup")
@click.argument("to", type=click.Path(path_type=Path, dir_okay=False))
@journal_option
def backup_command(to: Path, journal: Path | None) -> None:
    """Copy a journal as of one commit, also beside a mind that is writing it, and compare the copy's sum of rows."""
    with reading(journal) as opened:
        back_up(opened.path, to)
    with open_journal(to, read_only=True) as copied:
        say(f"{to}: up to line {copied.last:,}, {to.stat().st_size / 1e6:,.1f} MB")


def _given_up(journal: SqliteJournal) -> str:
    """What was given up so far, in words."""
    gone = [line.record for line in journal.lines_of(kinds=("compacted",)) if isinstance(line.record, Compacted)]
    if not gone:
        return "nothing was given up so far"
    events, lines = sum(each.admitted for each in gone), sum(each.lines for each in gone)
    return f"given up so far: {count(events, 'event')} in {count(lines, 'line')}"
