"""Outcomes that judged nothing: a label that nobody knows, an event that does not exist, or nothing that waited."""

from __future__ import annotations

from collections import Counter

from wakeful.facts.evidence import Outcome
from wakeful.journal.history import History


def outcomes_unmatched(read: History) -> dict[str, int]:
    """Outcomes that changed nothing, and why: nobody can tell from the counts of verdicts that they came.

    A label that no forecast names, and that judged none, is not one of the domain's, or was misspelt.
    """
    used = {judged.outcome for process in read.processes.values() for _, judged in process.verdicts if judged.outcome}
    spoken = _labels(read)
    unmatched = [outcome for identity, outcome in read.outcomes.items() if identity not in used]
    return dict(Counter(_because(outcome, read, spoken) for outcome in unmatched))


def _labels(read: History) -> set[str]:
    """The labels that the journal's own forecasts and verdicts speak of."""
    labels = {judged.label for process in read.processes.values() for _, judged in process.verdicts}
    for process in read.processes.values():
        forecast = process.concluded.forecast if process.concluded else None
        if forecast is not None:
            labels |= {forecast.label, *forecast.probabilities}
        for decision in process.decisions:
            labels |= set(decision.prior)
    return labels


def _because(outcome: Outcome, read: History, spoken: set[str]) -> str:
    if outcome.event and outcome.event not in read.events:
        return "an event that does not exist"
    if outcome.label not in spoken:
        return f"the label {outcome.label!r}, which no forecast knows"
    return "no result that waited for it"
