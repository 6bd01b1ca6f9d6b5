"""`wakeful trust` and `learning`: what experience has taught."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import click

from wakeful.cli.options import journal_option, json_option, print_json, reading
from wakeful.cli.terminal import say, table
from wakeful.facts.experience import Verdict
from wakeful.facts.time import to_s
from wakeful.journal.views import History, View, history
from wakeful.journal.wording.words import duration, percent
from wakeful.revision.revision import RevisionSettings


class TrustRow(View, frozen=True):
    """Trust in one treatment, with what it was earned and lost on. ``began``: never changed, it is what trust begins at."""

    treatment: str
    trust: float
    began: bool
    raised: int
    lowered: int
    supported: int
    contradicted: int
    reopened: int
    last_change: str = ""


@click.command("trust")
@journal_option
@json_option
def trust_command(journal: Path | None, as_json: bool) -> None:
    """Show the trust in each treatment and how often experience raised or lowered it."""
    with reading(journal) as opened:
        read = history(opened)
    rows = _trust(read)
    if as_json:
        print_json(rows)
        return
    if not rows:
        say("no treatment has been used yet")
        return
    table(
        ["treatment", "trust", "raised", "lowered", "supported", "contradicted", "reopened", "last change"],
        [
            [
                row.treatment,
                f"{row.trust:.3f}",
                str(row.raised),
                str(row.lowered),
                str(row.supported),
                str(row.contradicted),
                str(row.reopened),
                row.last_change,
            ]
            for row in rows
        ],
        ["trust", "raised", "lowered", "supported", "contradicted", "reopened"],
    )


def _trust(read: History) -> list[TrustRow]:
    names = dict.fromkeys([process.treatment for process in read.processes.values()] + [row.treatment for _, row in read.trusted])
    verdicts = Counter((process.treatment, process.judged.verdict) for process in read.processes.values() if process.judged)
    reopened = Counter(
        read.processes[record.reopens].treatment for record in read.reopened.values() if record.reopens in read.processes
    )
    rows = []
    for name in sorted(names):
        changes = [record for _, record in read.trusted if record.treatment == name]
        rows.append(
            TrustRow(
                treatment=name,
                trust=changes[-1].after if changes else RevisionSettings().initial,
                began=not changes,
                raised=sum(1 for change in changes if change.after > change.before),
                lowered=sum(1 for change in changes if change.after < change.before),
                supported=verdicts[name, Verdict.SUPPORTED],
                contradicted=verdicts[name, Verdict.CONTRADICTED],
                reopened=reopened[name],
                last_change=changes[-1].why if changes else "never changed: this is what trust begins at",
            )
        )
    return rows


@click.command("learning")
@journal_option
@json_option
def learning_command(journal: Path | None, as_json: bool) -> None:
    """List model versions: what each learned from, how it compared with the one before, and whether it was accepted."""
    with reading(journal) as opened:
        read = history(opened)
    if as_json:
        print_json(
            {
                "experiences": len(read.gained),
                "imported": len(read.imported),
                "models": [{"at_ns": at_ns, "card": record.card} for at_ns, record in read.published],
            }
        )
        return
    if not read.published:
        say(f"no model yet, {len(read.gained):,} experiences: every decision follows the domain's guidelines")
        return
    start_ns = min((past.admitted_ns for past in read.events.values()), default=0)
    table(
        ["version", "from", "after", "experiences", "accepted", "held back", "loss", "before", "accuracy", "was", "why"],
        [
            [
                str(record.card.version),
                str(record.card.base),
                duration(to_s(at_ns - start_ns)),
                f"{record.card.watermark:,}",
                "yes" if record.card.accepted else "no",
                f"{record.card.held_back:,}",
                _number(record.card.challenger_loss),
                _number(record.card.champion_loss),
                percent(record.card.challenger_accuracy),
                percent(record.card.champion_accuracy),
                record.card.why,
            ]
            for at_ns, record in read.published
        ],
        ["version", "from", "after", "experiences", "held back", "loss", "before", "accuracy", "was"],
    )


def _number(value: float | None) -> str:
    return "–" if value is None else f"{value:.3f}"
