"""`wakeful guarantee`: what is promised of automatic processing, per treatment, and what the promise rests on."""

from __future__ import annotations

from pathlib import Path

import click
import msgspec

from wakeful.cli.options import alpha_option, delta_option, journal_option, json_option, option, print_json, reading
from wakeful.cli.terminal import heading, paragraph, say, table
from wakeful.facts.lines import Certified, Decided, Line, Revoked
from wakeful.facts.time import to_s
from wakeful.journal.sqlite import SqliteJournal
from wakeful.journal.wording.words import duration, percent
from wakeful.selection.guarantee import Guarantee, GuaranteeSettings
from wakeful.selection.guarantee.bounds import error_free_needed
from wakeful.selection.guarantee.report import Report, report

_CHANGES_SHOWN = 8
_NUMBERS = ["risk", "bound now", "evidence", "errors", "automatic", "validated", "never", "wrong if automatic"]


@click.command("guarantee")
@journal_option
@alpha_option(None)
@delta_option(None)
@option("--awaiting", is_flag=True, help="List the drawn events whose outcome is still to come, for whoever can tell it.")
@json_option
def guarantee_command(journal: Path | None, alpha: float | None, delta: float | None, awaiting: bool, as_json: bool) -> None:
    """Say per treatment under which risk automatic processing is held, and on what evidence.

    The risk is P(wrong and automatic). It is bounded from outcomes of the world or of a person on events that were drawn with a
    known probability ('wakeful run --gate guarantee'), at every time at once. In a journal of another gate nothing was drawn:
    what is shown then is what its outcomes would have supported, had each been awaited whatever it was.
    """
    with reading(journal) as opened:
        promised = _promised(opened)
        default = promised or GuaranteeSettings()
        settings = msgspec.structs.replace(default, alpha=alpha or default.alpha, delta=delta or default.delta)
        gate, changes = _read(opened, settings, shadow=promised is None)
    rows = report(gate)
    if awaiting:
        _awaiting(gate, as_json)
        return
    if as_json:
        told = {"under_guarantee": promised is not None, "alpha": settings.alpha, "delta": settings.delta}
        print_json({**told, "treatments": rows, "changes": [{"at_ns": line.at_ns, "record": line.record} for line in changes]})
        return
    _print(rows, changes, settings, promised is not None)


def _promised(journal: SqliteJournal) -> GuaranteeSettings | None:
    """What was promised last; None in a journal of another gate."""
    own = GuaranteeSettings()
    alpha, delta, rate, any_audit = own.alpha, own.delta, own.audit_rate, False
    for line in journal.lines_of(kinds=("decided", "certified")):
        record = line.record
        if isinstance(record, Decided) and record.decision.audit is not None:
            audit, any_audit = record.decision.audit, True
            alpha = audit.alpha
            rate = audit.probability if audit.automatic else rate
        elif isinstance(record, Certified):
            delta = record.promised
    return GuaranteeSettings(alpha=alpha, delta=delta, audit_rate=rate) if any_audit else None


def _read(journal: SqliteJournal, settings: GuaranteeSettings, shadow: bool) -> tuple[Guarantee, list[Line]]:
    gate = Guarantee(settings, shadow=shadow)
    changes: list[Line] = []
    for line in journal.lines():
        gate.apply(line.record)
        if isinstance(line.record, Certified | Revoked):
            changes.append(line)
    return gate, changes


def _awaiting(gate: Guarantee, as_json: bool) -> None:
    found = gate.awaiting()
    if as_json:
        print_json([{"event": event, "treatment": treatment} for event, treatment in found])
    elif found:
        table(["event", "treatment"], [[event, treatment] for event, treatment in found], whole=["event"])
    else:
        say("no drawn event awaits its outcome")


def _print(rows: list[Report], changes: list[Line], settings: GuaranteeSettings, promised: bool) -> None:
    if not rows:
        say("nothing is promised: no model has decided anything yet" if not promised else _nothing(settings))
        return
    if not promised:
        paragraph(
            "This journal was made under another gate, so nothing is promised of it. As if each outcome had been awaited, "
            "whatever it was:",
            indent=0,
        )
    table(
        ["treatment", *_NUMBERS, "state"],
        [_cells(row) for row in rows],
        _NUMBERS,
        drop=["never", "validated", "wrong if automatic"],
    )
    if changes:
        heading("Certificates")
    for line in changes[-_CHANGES_SHOWN:]:
        paragraph(_change(line, changes[0].at_ns), 2, 2)
    if len(changes) > _CHANGES_SHOWN:
        say(f"  {len(changes) - _CHANGES_SHOWN:,} earlier changes stand in the journal ('wakeful trace')")
    say()
    paragraph(_how(settings), indent=0)


def _cells(row: Report) -> list[str]:
    rate = row.conditional
    return [
        row.treatment,
        percent(row.alpha),
        percent(row.bound, 2),
        f"{row.drawn:,} of {row.events:,}",
        f"{row.errors:,}",
        percent(row.share_automatic) if row.decided else "–",
        percent(row.share_validated) if row.automatic else "–",
        percent(row.share_never_validated) if row.automatic else "–",
        "–" if rate is None else f"{percent(rate.share)}, at most {percent(rate.upper)}",
        row.says,
    ]


def _change(line: Line, first_ns: int) -> str:
    record, at = line.record, f"line {line.position}, {duration(to_s(line.at_ns - first_ns))} after the first"
    if isinstance(record, Certified):
        return (
            f"{record.treatment}: certified for scores from {record.level:.2f} on, model version {record.model}, after "
            f"{record.events:,} events with {record.errors:,} wrong: risk at most {percent(record.bound, 2)} ({at})"
        )
    if isinstance(record, Revoked):
        return f"{record.treatment}: revoked, {record.why} ({at})"
    return ""


def _nothing(settings: GuaranteeSettings) -> str:
    return (
        "nothing is certified and nothing is automatic: no model has learned from "
        f"{settings.seek_from:,} experiences yet, from which on a version is put to the test"
    )


def _how(settings: GuaranteeSettings) -> str:
    one_look = error_free_needed(settings.alpha, settings.delta)
    return (
        f"Risk: P(wrong and automatic) of an event that could be automatic; held with probability {1 - settings.delta:g} "
        f"over all times and certificates of the treatment. Bound now: at the level in force, else at the strictest. Evidence: "
        f"drawn events with a settled outcome, of all since the model version began; for one look at a sample of fixed size "
        f"{one_look} without an error are enough at {percent(settings.alpha)}, for a look after each outcome it takes some more. "
        "Automatic: of the events that could be. Validated, never: automatic ones whose outcome came, or never will."
    )
