"""`wakeful stats`: what registration made of a source, and how many of its incidents it heard before they came."""

from __future__ import annotations

from pathlib import Path

import click
import msgspec

from wakeful.cli.options import journal_option, json_option, option, print_json, reading
from wakeful.cli.summary import print_backlog
from wakeful.cli.terminal import heading, paragraph, say, table
from wakeful.contracts.domain import DomainError
from wakeful.domains import load, names
from wakeful.journal.overload import backlog
from wakeful.journal.views import History, Stats, history, stats_of
from wakeful.journal.wording.words import count, duration, percent


@click.command("stats")
@journal_option
@option(
    "--within",
    "within_s",
    type=click.FloatRange(min=0, min_open=True),
    default=None,
    help="Seconds before an incident in which an event counts as its sign. Without it: the window of the forecasts.",
)
@json_option
def stats_command(journal: Path | None, within_s: float | None, as_json: bool) -> None:
    """Say how many observations each event stands for, events per hour by kind, and which incidents had a sign before."""
    with reading(journal) as opened:
        read = history(opened)
    told = stats_of(read, within_s, _incidents(read))
    waited = backlog(read)
    if as_json:
        print_json({**msgspec.to_builtins(told), "backlog": waited})
    else:
        _print(told)
        if waited.most or waited.refused:
            heading("Backlog")
            print_backlog(waited)


def _incidents(read: History) -> set[str] | None:
    """The outcome labels that are incidents to the journal's domain; None where it is not on this machine."""
    labels: set[str] = set()
    for name in {opened.domain for opened in read.opened}:
        # A journal from elsewhere may name a path; only what is installed is loaded.
        if name not in names():
            return None
        try:
            outcome = load(name).spec.outcome
        except DomainError:
            return None
        labels.update(outcome.incidents or outcome.labels[1:])
    return labels or None


def _print(told: Stats) -> None:
    if not told.events:
        over = f" in {duration(told.duration_s)}" if told.duration_s else ""
        say(f"No event came of {count(told.observations, 'observation')}{over}.")
        return
    say(f"{count(told.observations, 'observation')} became {count(told.events, 'event')}.")
    say(f"One event stands for {told.observations_per_event:,.1f} observations.")
    say(f"{told.events_per_hour:,.1f} events an hour, over {duration(told.duration_s)}.")
    heading("Events by kind")
    before = bool(told.incidents)
    columns = ["kind", "events", "per hour", "observations each"] + (
        ["incidents after", "of them", "by chance"] if before else []
    )
    rows = [
        [row.kind, f"{row.events:,}", f"{row.per_hour:,.1f}", f"{row.observations / row.events:,.0f}"]
        + ([f"{row.before:,}", percent(row.share), percent(row.by_chance)] if before else [])
        for row in told.kinds
    ]
    table(columns, rows, columns[1:])
    if not told.incidents:
        paragraph("The recording shows no outcomes, so nothing can be said on what registration missed.", indent=0)
        return
    heading(f"Incidents with an event in the {duration(told.within_s)} before")
    table(
        ["incident", "incidents", "with a sign", "share", "by chance", "lift", "first sign", "last sign", "foretold"],
        [
            [
                heard.label,
                f"{heard.incidents:,}",
                f"{heard.before:,}",
                percent(heard.share),
                percent(heard.by_chance),
                f"{heard.lift:.2f}" if heard.lift is not None else "–",
                duration(heard.first_s) if heard.first_s is not None else "–",
                duration(heard.last_s) if heard.last_s is not None else "–",
                f"{heard.foretold:,}",
            ]
            for heard in told.incidents
        ],
        ["incidents", "with a sign", "share", "by chance", "lift", "first sign", "last sign", "foretold"],
    )
    paragraph(
        "By chance: the share that as many events at random instants would get. First and last sign: median time from the "
        "earliest and the latest such event to the incident. Foretold: a result had forecast it by name before it came.",
        indent=0,
    )
