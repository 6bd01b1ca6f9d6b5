"""`wakeful trust` and `learning`: what experience has taught."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import click

from wakeful.cli.options import journal_option, json_option, print_json, reading
from wakeful.cli.terminal import heading, paragraph, say, table
from wakeful.facts.experience import Verdict
from wakeful.facts.time import to_s
from wakeful.journal.views import History, View, history
from wakeful.journal.wording.words import count, duration, percent
from wakeful.revision.revision import RevisionSettings
from wakeful.selection.gating import POOLED, RESULT, SelectionSettings


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
    automatic: bool
    """Whether events of this treatment may be automatic now, each by its own confidence and novelty."""
    criterion: str
    """What makes it automatic."""
    lacking: str
    """What of that it lacks now, where it is not."""
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
        ["treatment", "trust", "raised", "lowered", "supported", "contradicted", "reopened", "automatic", "last change"],
        [
            [
                row.treatment,
                f"{row.trust:.3f}",
                str(row.raised),
                str(row.lowered),
                str(row.supported),
                str(row.contradicted),
                str(row.reopened),
                "yes" if row.automatic else "no",
                row.last_change,
            ]
            for row in rows
        ],
        ["trust", "raised", "lowered", "supported", "contradicted", "reopened"],
    )
    heading("What makes a treatment automatic")
    for row in rows:
        paragraph(f"{row.treatment}: {row.criterion}" + (f"; not now: {row.lacking}" if row.lacking else "; so it is now"), 2, 2)


def _trust(read: History) -> list[TrustRow]:
    names = dict.fromkeys([process.treatment for process in read.processes.values()] + [row.treatment for _, row in read.trusted])
    verdicts = Counter((process.treatment, process.judged.verdict) for process in read.processes.values() if process.judged)
    reopened = Counter(
        read.processes[record.reopens].treatment for record in read.reopened.values() if record.reopens in read.processes
    )
    rows = []
    for name in sorted(names):
        changes = [record for _, record in read.trusted if record.treatment == name]
        trust = changes[-1].after if changes else RevisionSettings().initial
        criterion, lacking = _criterion(read, name, trust)
        rows.append(
            TrustRow(
                treatment=name,
                trust=trust,
                began=not changes,
                raised=sum(1 for change in changes if change.after > change.before),
                lowered=sum(1 for change in changes if change.after < change.before),
                supported=verdicts[name, Verdict.SUPPORTED],
                contradicted=verdicts[name, Verdict.CONTRADICTED],
                reopened=reopened[name],
                automatic=not lacking,
                criterion=criterion,
                lacking=lacking,
                last_change=changes[-1].why if changes else "never changed: this is what trust begins at",
            )
        )
    return rows


def _criterion(read: History, treatment: str, trust: float) -> tuple[str, str]:
    """What makes a treatment automatic by the version in use, and what it lacks of that. Nothing unvalidated counts."""
    own = SelectionSettings()
    card = next((each.card for _, each in reversed(read.published) if each.card.accepted), None)
    thresholds = card.thresholds if card is not None else {}
    needed = thresholds.get(treatment, thresholds.get(POOLED, own.confidence))
    result = thresholds.get(RESULT, own.result_confidence)
    support = card.support.get(treatment, 0) if card is not None else 0
    criterion = (
        f"confidence of at least {_reached(needed)}, forecast of at least {_reached(result)}, novelty of at most "
        f"{own.novelty_limit:g}, trust of at least {own.trust_limit:g}, {count(own.support, 'validated experience')}"
    )
    lacking = [
        "no model version has been accepted yet" if card is None else "",
        f"{support} validated experiences" if card is not None and support < own.support else "",
        f"trust {trust:.2f}" if trust < own.trust_limit else "",
        "on held-back experience even its surest results went wrong too often" if max(needed, result) > 1.0 else "",
    ]
    return criterion, "; ".join(filter(None, lacking))


def _reached(level: float) -> str:
    return f"{level:.2f}" if level <= 1.0 else "more than 1 (never reached)"


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
