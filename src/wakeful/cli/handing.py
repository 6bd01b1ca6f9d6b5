"""Handing in operators' acts: done here where nobody writes the journal, else handed to whoever does."""

from __future__ import annotations

import time
from collections.abc import Sequence
from pathlib import Path

import click

from wakeful.cli.mistakes import Mistake
from wakeful.cli.options import option
from wakeful.drivers.at_rest import act_at_rest
from wakeful.facts.inputs import Act
from wakeful.facts.lines import Acted
from wakeful.journal.acts import ActSpool
from wakeful.journal.lock import JournalLocked
from wakeful.journal.sqlite import open_journal
from wakeful.journal.views import View

_LOOK_EVERY_S = 0.1

wait_option = option(
    "--wait",
    "wait_s",
    type=click.FloatRange(min=0),
    default=5.0,
    show_default=True,
    metavar="S",
    help="Under a running mind: wait so many seconds for its record.",
)
who_option = option("--who", required=True, metavar="NAME", help="Who acts, for the record.")
why_option = option("--why", required=True, metavar="TEXT", help="The reason, for the record.")

THIS_COMMAND = "this command"


class Operated(View, frozen=True):
    """What became of an act. ``by`` is ``this command`` or the pid of the mind that recorded it, or is to record it."""

    act: str
    process: int
    id: str
    recorded: bool
    position: int
    by: str
    version: int = 0


def hand(path: Path, acts: Sequence[Act], wait_s: float) -> list[Operated]:
    """Have the acts recorded, at rest or by the running mind, and say what became of each.

    Args:
        path: the journal's file.
        acts: each with an id of its own.
        wait_s: how long to wait for a running mind's records.

    Raises:
        Mistake: one of them was refused.
        JournalError: the journal cannot be read or written.
    """
    spool = ActSpool(path)
    until_s = time.monotonic() + wait_s
    handed, by = False, THIS_COMMAND
    while True:
        try:
            _at_rest(path, spool, acts)
            by = THIS_COMMAND
        except JournalLocked as locked:
            by = locked.holder
            if not handed:
                for act in acts:
                    spool.put(act)
                handed = True
        found = _records(path, acts)
        if len(found) == len(acts) or time.monotonic() >= until_s:
            return [_operated(act, found.get(act.id), by) for act in acts]
        time.sleep(_LOOK_EVERY_S)


def _operated(act: Act, found: tuple[int, Acted] | None, by: str) -> Operated:
    if found is not None and found[1].refused:
        raise Mistake(f"{found[1].refused} any more: nothing was changed by it (line {found[0]})")
    return Operated(
        act=act.act,
        process=act.process,
        id=act.id,
        recorded=found is not None,
        position=found[0] if found is not None else 0,
        by=by,
        version=act.version,
    )


def _at_rest(path: Path, spool: ActSpool, acts: Sequence[Act]) -> None:
    """Take up what was handed in and nobody has taken up yet, and these acts."""
    with open_journal(path) as opened:
        waiting = spool.waiting()
        ids = {each.act.id for each in waiting}
        act_at_rest(opened, [*(each.act for each in waiting), *(act for act in acts if act.id not in ids)])
        spool.done(waiting)


def _records(path: Path, acts: Sequence[Act]) -> dict[str, tuple[int, Acted]]:
    wanted = {act.id for act in acts}
    with open_journal(path, read_only=True) as opened:
        lines = opened.lines_of(kinds=("acted",))
        return {
            line.record.id: (line.position, line.record)
            for line in lines
            if isinstance(line.record, Acted) and line.record.id in wanted
        }
