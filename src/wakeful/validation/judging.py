"""What one outcome, or a window's close, says of one forecast: the verdict as it is recorded."""

from __future__ import annotations

from wakeful.facts.evidence import Outcome
from wakeful.facts.experience import Verdict
from wakeful.facts.lines import Judged
from wakeful.validation.ledger import Entry
from wakeful.validation.verdict import verdict


def against(entry: Entry, outcome: Outcome, now_ns: int, quiet: str) -> Judged | None:
    """What one outcome says of one forecast, given what is known of it already; None where it says nothing new.

    Args:
        entry: the forecast.
        outcome: in kernel time.
        now_ns: kernel time.
        quiet: the label that says that nothing came.
    """
    if entry.verdict is None:
        return judge(entry, outcome, quiet, "came late but lies inside the window" if entry.closes_ns < now_ns else "")
    if outcome.id == entry.decided_by or outcome.id in entry.overruled:
        return None
    if not supersedes(outcome, entry):
        return None if outcome.label == entry.shown else too_late(entry, outcome, entry.shown)
    if outcome.label == entry.shown:
        # Recorded although it changes no verdict: what comes later still, but lies between the two, must not supersede it.
        return judge(entry, outcome, quiet, "came late and bears out what was judged")
    if entry.decided_by:
        return judge(entry, outcome, quiet, f"came late but lies before the outcome {entry.shown!r}: supersedes it")
    return judge(entry, outcome, quiet, "came late but lies inside the window: supersedes what its close said")


def judge(entry: Entry, outcome: Outcome, quiet: str, why: str = "") -> Judged:
    """The verdict that an outcome decides (Eq. 10)."""
    seen = verdict(entry.label, outcome.label, outcome.acted_on, quiet)
    reasons = [why] if why else []
    if seen is Verdict.UNDECIDED:
        reasons.append("the result had been acted on: what it forecast may have been prevented")
    return Judged(
        process=entry.process,
        event=entry.event,
        predicted=entry.label,
        label=outcome.label,
        verdict=seen,
        outcome=outcome.id,
        why="; ".join(reasons),
        lead_ns=outcome.at_ns + entry.offset_ns - entry.concluded_ns,
    )


def too_late(entry: Entry, outcome: Outcome, standing: str) -> Judged:
    """An outcome that contradicts an earlier one changes nothing, and is recorded."""
    return Judged(
        process=entry.process,
        event=entry.event,
        predicted=entry.label,
        label=outcome.label,
        verdict=Verdict.UNDECIDED,
        outcome=outcome.id,
        why=f"the world showed {standing!r} first, and the first in source time decides",
    )


def silence(entry: Entry, quiet: str) -> Judged:
    """The window closed over an unbroken recording: nothing came."""
    return Judged(
        process=entry.process,
        event=entry.event,
        predicted=entry.label,
        label=quiet,
        verdict=verdict(entry.label, quiet),
        why=f"the window closed over an unbroken recording: {quiet!r}",
    )


def undecided(entry: Entry, why: str) -> Judged:
    """Nobody can know what came."""
    return Judged(process=entry.process, event=entry.event, predicted=entry.label, label="", verdict=Verdict.UNDECIDED, why=why)


def supersedes(outcome: Outcome, entry: Entry) -> bool:
    """Whether an outcome overrides the verdict that stands: it does over a closed window, and over a later outcome."""
    return entry.decided_ns is None or outcome.at_ns < entry.decided_ns
