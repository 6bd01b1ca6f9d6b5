"""`wakeful debt`: what is owed a better treatment, the riskiest first."""

from __future__ import annotations

from pathlib import Path

import click

from wakeful.cli.options import journal_option, json_option, option, print_json, reading
from wakeful.cli.terminal import say, table
from wakeful.journal.debt import debt
from wakeful.journal.views import history
from wakeful.journal.wording.words import count, duration


@click.command("debt")
@journal_option
@option("--limit", type=click.IntRange(min=0), default=50, show_default=True, help="The first so many; 0: all.")
@json_option
def debt_command(journal: Path | None, limit: int, as_json: bool) -> None:
    """List events that hold only a provisional treatment, or none: fallback, unresolved, cancelled; by risk."""
    with reading(journal) as opened:
        rows = debt(history(opened))
    shown = rows[:limit] if limit else rows
    if as_json:
        print_json(shown)
        return
    if not shown:
        say("nothing is in debt: every event holds a treatment of its own")
        return
    table(
        ["event", "criticality", "age", "kind", "entity", "process", "because", "says"],
        [
            [
                row.id[:10],
                str(row.criticality),
                duration(row.age_s),
                row.kind,
                row.entity,
                str(row.process),
                f"{row.because} by {row.who}" if row.who else row.because,
                row.says,
            ]
            for row in shown
        ],
        ["criticality", "age", "process"],
        whole=["event"],
    )
    if len(shown) < len(rows):
        click.echo(f"the first {len(shown)} of {count(len(rows), 'event')}; --limit 0 shows all", err=True)
