"""`wakeful status`, `events` and `processes`: what the robot has met and what is being thought about."""

from __future__ import annotations

from pathlib import Path

import click

from wakeful.cli.options import journal_option, json_option, option, print_json, reading
from wakeful.cli.summary import print_backlog, print_curve, print_state
from wakeful.cli.terminal import heading, paragraph, say, table
from wakeful.facts.processes import State
from wakeful.journal.named import Named, named
from wakeful.journal.overload import backlog
from wakeful.journal.rows import event_row, process_row
from wakeful.journal.views import History, history, summary_of
from wakeful.journal.wording.waiting import deadline_words
from wakeful.journal.wording.words import count, duration, instant

#: Of each kind of thing to look at so many processes are named; `--json` names all.
NAMES_SHOWN = 20


@click.command("status")
@journal_option
@json_option
def status_command(journal: Path | None, as_json: bool) -> None:
    """Say in short where things stand: intake, open processes, debt, models; and by name what did not go on as it was."""
    with reading(journal) as opened:
        read = history(opened)
        path = opened.path
    told = summary_of(read, strange=0)
    if as_json:
        state = {"journal": str(path), "lines": read.last, "now_ns": read.now_ns, "summary": told}
        print_json({**state, "backlog": backlog(read), "named": named(read)})
        return
    older = f"; {count(read.given_up, 'older event')} given up" if read.given_up else ""
    say(f"{path}: {count(read.last, 'line')}{older}, {', '.join(_sources(read)) or 'no source yet'}")
    print_state(told)
    print_backlog(backlog(read))
    _print_named(named(read))
    print_curve(told)


def _print_named(found: list[Named]) -> None:
    if found:
        heading("To look at")
    for each in found:
        whom = [f"P{process}" for process in each.processes] or [event[:10] for event in each.events]
        shown = ", ".join(whom[:NAMES_SHOWN]) + (f" and {len(whom) - NAMES_SHOWN} more" if len(whom) > NAMES_SHOWN else "")
        still = f" ({each.open:,} still open)" if each.open else ""
        paragraph(f"{len(whom):,} {each.means}{still}: {shown}" if whom else each.means, 2, 2)


def _sources(read: History) -> list[str]:
    finished = {record.source for record in read.finished}
    return [
        f"{opened.source} ({opened.domain}, {'read to its end' if opened.source in finished else 'not finished'})"
        for opened in {opened.source: opened for opened in read.opened}.values()
    ]


@click.command("events")
@journal_option
@option("--kind", default=None, help="Only events of this kind.")
@option("--treatment", default=None, help="Only events with this treatment.")
@option("--mode", type=click.Choice(["auto", "delib", "fallback"]), default=None, help="Only events treated in this mode.")
@option(
    "--verdict",
    type=click.Choice(["supported", "contradicted", "undecided"]),
    default=None,
    help="Only events with this verdict.",
)
@option("--limit", type=click.IntRange(min=0), default=20, show_default=True, help="The last so many; 0: all.")
@json_option
def events_command(
    journal: Path | None,
    kind: str | None,
    treatment: str | None,
    mode: str | None,
    verdict: str | None,
    limit: int,
    as_json: bool,
) -> None:
    """List admitted events, the last ones last, with how each was treated and how it ended."""
    with reading(journal) as opened:
        read = history(opened)
    rows = [
        row
        for row in (event_row(read, past) for past in read.events.values())
        if kind in (None, row.kind)
        and treatment in (None, row.treatment)
        and mode in (None, row.mode)
        and verdict in (None, row.verdict)
    ]
    shown = rows[-limit:] if limit else rows
    if as_json:
        print_json(shown)
        return
    table(
        ["event", "when", "kind", "entity", "treatment", "mode", "ended", "says"],
        [
            [
                row.id[:10],
                instant(row.at_ns),
                row.kind,
                row.entity,
                row.treatment,
                row.mode,
                row.verdict or row.state,
                row.says,
            ]
            for row in shown
        ],
        whole=["event", "when"],
        drop=["mode", "treatment", "when", "entity", "ended", "kind"],
    )
    if len(shown) < len(rows):
        click.echo(f"the last {len(shown)} of {count(len(rows), 'event')}; --limit 0 shows all", err=True)


@click.command("processes")
@journal_option
@option("--all", "everything", is_flag=True, help="Completed processes too.")
@option("--state", type=click.Choice([state.value for state in State]), default=None, help="Only processes in this state.")
@option("--limit", type=click.IntRange(min=0), default=50, show_default=True, help="The last so many; 0: all.")
@json_option
def processes_command(journal: Path | None, everything: bool, state: str | None, limit: int, as_json: bool) -> None:
    """List open processes: state, age, deadline, what each waits for, and who preempted it."""
    with reading(journal) as opened:
        read = history(opened)
    found = [process for process in read.processes.values() if (process.state == state if state else everything or process.open)]
    shown = [process_row(read, process) for process in (found[-limit:] if limit else found)]
    if as_json:
        print_json(shown)
        return
    if not shown:
        say(
            "no process is open: everything that was admitted has been thought through" if not state else f"no process is {state}"
        )
        return
    table(
        ["process", "event", "treatment", "mode", "state", "age", "steps", "deadline", "stands"],
        [
            [
                str(row.id),
                row.event[:10],
                row.treatment,
                row.mode,
                row.state,
                duration(row.age_s),
                str(row.steps),
                deadline_words(row.deadline_s),
                row.stands,
            ]
            for row in shown
        ],
        ["process", "age", "steps"],
        whole=["event", "age"],
    )
    if len(shown) < len(found):
        click.echo(f"the last {len(shown)} of {count(len(found), 'process', 'processes')}; --limit 0 shows all", err=True)
