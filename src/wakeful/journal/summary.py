"""The summary of a run: what was received, how it was treated, how it ended, and how the automatic share grew."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Sequence

from wakeful.facts.decisions import Mode
from wakeful.facts.events import CRITICAL
from wakeful.facts.experience import Verdict
from wakeful.facts.processes import Completion, State
from wakeful.facts.time import to_s
from wakeful.journal.debt import in_debt
from wakeful.journal.history import EventPast, History, ProcessPast, history
from wakeful.journal.incidents import observations_of
from wakeful.journal.readable import Readable, View
from wakeful.journal.strange import StrangeEpisode, strangest
from wakeful.journal.unmatched import outcomes_unmatched

DECILES = 10
REASONS_TOLD = 20


class Share(View, frozen=True):
    """``right`` of ``of``, with the fraction (None of nothing) and its 95 % Wilson interval."""

    right: int
    of: int
    fraction: float | None
    low: float
    high: float


def share(right: int, of: int) -> Share:
    """A share with its Wilson score interval.

    >>> share(9, 10).fraction
    0.9
    """
    if not of:
        return Share(right=0, of=0, fraction=None, low=0.0, high=1.0)
    z, p = 1.959964, right / of
    middle, spread = p + z * z / (2 * of), z * math.sqrt(p * (1 - p) / of + z * z / (4 * of * of))
    scale = 1 + z * z / of
    return Share(
        right=right,
        of=of,
        fraction=p,
        low=max(0.0, round((middle - spread) / scale, 6)),
        high=min(1.0, round((middle + spread) / scale, 6)),
    )


class Accuracy(View, frozen=True):
    """Accuracy of treatment (where the recording labels it), of result (where the world decided), and of both in one event.

    ``base_rate`` is what always forecasting the most common outcome would have got of the same results.
    """

    treatment: Share
    result: Share
    joint: Share
    base_rate: Share
    base_label: str = ""


class Stretch(View, frozen=True):
    """One tenth of the admitted events, in order."""

    events: int
    automatic: float
    result: Share


class Summary(View, frozen=True):
    """What a run came to. Fractions are in [0, 1]; counts are of the whole journal."""

    source: str
    domain: str
    received: int
    admitted: int
    duplicate: int
    refused: int
    refused_because: dict[str, int]
    coverage: float
    uncovered: int
    completion: float
    completions: dict[str, int]
    treatments: dict[str, int]
    modes: dict[str, int]
    waiting: int
    suspended: int
    debt: int
    outcomes_witnessed: int
    outcomes_matched: int
    outcomes_unmatched: dict[str, int]
    """Outcomes that judged no result, by reason: an unknown label, an event that does not exist, nothing that waited."""
    windows_closed: int
    verdicts: dict[str, int]
    accuracy: Accuracy
    automatic_right: Share
    """Of the automatic results that the world decided, those that were right."""
    deliberated_right: Share
    reasoner_calls: int
    cost_usd: float
    reopened: int
    drifted: tuple[str, ...]
    """Alarms that a treatment erred more than before, in words, the newest last."""
    models_published: int
    models_rejected: int
    experiences: int
    observations: int
    duration_s: float
    first_treatment_s: dict[str, float]
    expired_waits: int
    curve: tuple[Stretch, ...] = ()
    strangest: tuple[StrangeEpisode, ...] = ()


def summary(journal: Readable, strange: int = 5) -> Summary:
    """Sum up a journal.

    Args:
        journal: any journal, complete or in the middle of a run.
        strange: how many of the strangest episodes to tell.

    Returns:
        the summary of all that it holds.
    """
    return summary_of(history(journal), strange)


def summary_of(read: History, strange: int = 5) -> Summary:
    """The same from a history that was read already."""
    roots = read.roots()
    processes = list(read.processes.values())
    judged = [process.judged for process in processes if process.judged]
    refused = sum(read.refused.values())
    uncovered = len(read.events) - sum(1 for _, root in roots if covered(root))
    ended = sum(1 for _, root in roots if root.end not in (None, Completion.ABANDONED))
    return Summary(
        source=", ".join(dict.fromkeys(opened.source for opened in read.opened)),
        domain=", ".join(dict.fromkeys(opened.domain for opened in read.opened)),
        received=len(read.events) + read.duplicates + refused,
        admitted=len(read.events),
        duplicate=read.duplicates,
        refused=refused,
        refused_because=_reasons(read.refused),
        coverage=1.0 - uncovered / len(read.events) if read.events else 1.0,
        uncovered=uncovered,
        completion=ended / len(read.events) if read.events else 1.0,
        completions=_counts(root.end for _, root in roots if root.end),
        treatments=_counts(root.treatment for _, root in roots),
        modes=_counts(root.decision.mode for _, root in roots if root.decision),
        waiting=sum(1 for process in processes if process.state is State.WAITING),
        suspended=sum(1 for process in processes if process.state is State.SUSPENDED),
        debt=sum(1 for past in read.events.values() if in_debt(read, past)),
        outcomes_witnessed=len(read.outcomes),
        outcomes_matched=sum(1 for verdict in judged if verdict.outcome),
        outcomes_unmatched=_reasons(outcomes_unmatched(read)),
        windows_closed=sum(1 for verdict in judged if not verdict.outcome and verdict.verdict is not Verdict.UNDECIDED),
        verdicts={verdict.value: sum(1 for row in judged if row.verdict is verdict) for verdict in Verdict},
        accuracy=accuracy(roots),
        automatic_right=right_in(roots, "auto"),
        deliberated_right=right_in(roots, "delib"),
        reasoner_calls=read.reasoner_calls,
        cost_usd=read.cost_usd,
        reopened=len(read.reopened),
        drifted=tuple(f"{record.treatment}: {record.why}" for _, record in read.drifted),
        models_published=sum(1 for _, published in read.published if published.card.accepted),
        models_rejected=sum(1 for _, published in read.published if not published.card.accepted),
        experiences=len(read.gained),
        observations=observations_of(read),
        duration_s=_duration_s(read),
        first_treatment_s=_first_treatment_s(roots),
        expired_waits=read.expired_waits,
        curve=curve(roots),
        strangest=strangest(read, strange),
    )


def covered(root: ProcessPast) -> bool:
    """Whether the event is attended to: decided, and done, ready, or waiting for something that has a limit."""
    if root.end is Completion.ABANDONED or root.decision is None:
        return False
    return root.state is not State.WAITING or bool(root.unanswered())


def accuracy(roots: Sequence[tuple[EventPast, ProcessPast]]) -> Accuracy:
    """Accuracy of treatment, of result, and of both, over root processes: what was decided before the world showed it."""
    treatment = [past.event.truth_treatment == root.treatment for past, root in roots if past.event.truth_treatment is not None]
    decided = [root.judged for _, root in roots if root.judged and root.judged.verdict is not Verdict.UNDECIDED]
    both = [
        past.event.truth_treatment == root.treatment and root.judged.predicted == root.judged.label
        for past, root in roots
        if past.event.truth_treatment is not None and root.judged and root.judged.verdict is not Verdict.UNDECIDED
    ]
    common = Counter(judged.label for judged in decided).most_common(1)
    return Accuracy(
        treatment=share(sum(treatment), len(treatment)),
        result=share(sum(judged.predicted == judged.label for judged in decided), len(decided)),
        joint=share(sum(both), len(both)),
        base_rate=share(common[0][1] if common else 0, len(decided)),
        base_label=common[0][0] if common else "",
    )


def right_in(roots: Sequence[tuple[EventPast, ProcessPast]], mode: Mode) -> Share:
    """Of the results in this mode that the world decided, those that were right."""
    decided = [
        root.judged
        for _, root in roots
        if root.judged
        and root.judged.verdict is not Verdict.UNDECIDED
        and root.decision is not None
        and (root.concluded.mode if root.concluded else root.decision.mode) == mode
    ]
    return share(sum(judged.predicted == judged.label for judged in decided), len(decided))


def curve(roots: Sequence[tuple[EventPast, ProcessPast]], stretches: int = DECILES) -> tuple[Stretch, ...]:
    """The automatic share and the result accuracy in each tenth of the events, in order of admission."""
    rows = []
    for index in range(stretches):
        part = [root for _, root in roots[len(roots) * index // stretches : len(roots) * (index + 1) // stretches]]
        if not part:
            continue
        decided = [root.judged for root in part if root.judged and root.judged.verdict is not Verdict.UNDECIDED]
        automatic = sum(1 for root in part if root.decision and root.decision.mode == "auto")
        right = sum(1 for judged in decided if judged.predicted == judged.label)
        rows.append(Stretch(events=len(part), automatic=automatic / len(part), result=share(right, len(decided))))
    return tuple(rows)


def _reasons(refused: dict[str, int]) -> dict[str, int]:
    """Refusals by reason, the most frequent first; rare ones together, since a reason may quote what it refuses."""
    ranked = sorted(refused.items(), key=lambda row: (-row[1], row[0]))
    rare = sum(number for _, number in ranked[REASONS_TOLD:])
    return dict(ranked[:REASONS_TOLD]) | ({"other reasons": rare} if rare else {})


def _counts(names: Iterable[str]) -> dict[str, int]:
    return dict(Counter(str(name) for name in names).most_common())


def _duration_s(read: History) -> float:
    instants = [past.event.stamp.source_ns for past in read.events.values()]
    return to_s(max(instants) - min(instants)) if instants else 0.0


def _first_treatment_s(roots: Sequence[tuple[EventPast, ProcessPast]]) -> dict[str, float]:
    """The longest time from admission to first treatment, in seconds, of critical events and of the others."""
    longest: dict[str, float] = {}
    for _, root in roots:
        if root.first_treated_ns is not None:
            name = "critical" if root.criticality >= CRITICAL else "other"
            longest[name] = max(longest.get(name, 0.0), to_s(root.first_treated_ns - root.created_ns))
    return longest
