"""The few strangest episodes: where the world surprised the forecast, contradicted it, or was like nothing before."""

from __future__ import annotations

import math

from wakeful.facts.experience import Verdict
from wakeful.facts.lines import Judged
from wakeful.facts.processes import Completion, State
from wakeful.facts.results import Forecast
from wakeful.facts.time import to_s
from wakeful.journal.history import EventPast, History, ProcessPast
from wakeful.journal.readable import View
from wakeful.journal.results import result_says

#: Bits added to the surprise for each further sign of strangeness; a forecast never counts for more than the floor.
CONTRADICTED_BITS = 2.0
NOVEL_BITS = 2.0
REOPENED_BITS = 1.0
UNRESOLVED_BITS = 1.0
FLOOR = 1e-3


class StrangeEpisode(View, frozen=True):
    """One event's story in short: opened, what was concluded, how it ended. ``surprise_bits`` is what it is ranked by."""

    event: str
    kind: str
    entity: str
    says: str
    at_ns: int
    treatment: str
    mode: str
    concluded: str
    surprise_bits: float
    novelty: float = 0.0
    predicted: str = ""
    predicted_probability: float = 0.0
    label: str = ""
    label_probability: float | None = None
    verdict: str = ""
    judged_after_s: float | None = None
    state: str = ""
    end: str = ""
    reopened: int = 0


def probability_of(label: str, forecast: Forecast) -> float:
    """What the forecast gave to ``label``; where it names only its own label, the rest is all that is left for the others."""
    if label in forecast.probabilities:
        return forecast.probabilities[label]
    return forecast.probability if label == forecast.label else max(0.0, 1.0 - forecast.probability)


def surprise_bits(process: ProcessPast, reopened: int) -> float:
    """How strange a root process's episode was.

    The bits of the forecast's surprise at what happened (-log2 p, at most 10), with fixed bits for a contradiction, a
    novel event, a reopening, and an unresolved end.
    """
    bits = 0.0
    forecast = process.concluded.forecast if process.concluded else None
    if process.judged and forecast:
        bits += -math.log2(min(1.0, max(FLOOR, probability_of(process.judged.label, forecast))))
    if process.judged and process.judged.verdict is Verdict.CONTRADICTED:
        bits += CONTRADICTED_BITS
    if process.decision:
        bits += NOVEL_BITS * min(1.0, max(0.0, process.decision.gate.novelty))
    bits += REOPENED_BITS * min(reopened, 2)
    if process.end in (Completion.UNRESOLVED, Completion.ABANDONED):
        bits += UNRESOLVED_BITS
    return round(bits, 6) if math.isfinite(bits) else 0.0


def strangest(read: History, limit: int = 5) -> tuple[StrangeEpisode, ...]:
    """The strangest episodes, most surprising first, each kind of surprise once before any comes twice.

    Args:
        read: the journal's history.
        limit: how many.

    Returns:
        at most ``limit`` episodes; ties go to the earlier event.
    """
    ranked = sorted(
        ((surprise_bits(root, _reopenings(read, past)), past, root) for past, root in read.roots()),
        key=lambda row: (-row[0], row[1].position),
    )
    chosen: list[tuple[float, EventPast, ProcessPast]] = []
    seen: set[tuple[str, str, str]] = set()
    again: list[tuple[float, EventPast, ProcessPast]] = []
    for row in ranked:
        sort = (row[1].event.kind, row[2].treatment, row[2].judged.label if row[2].judged else "")
        if sort in seen:
            again.append(row)
            continue
        seen.add(sort)
        chosen.append(row)
        if len(chosen) == limit:
            break
    return tuple(episode(read, past, root, bits) for bits, past, root in (chosen + again)[:limit])


def _reopenings(read: History, past: EventPast) -> int:
    return sum(1 for process in past.processes if read.processes[process].reopens)


def _judged_after_s(read: History, past: EventPast, judged: Judged | None) -> float | None:
    """How long after the event the world showed it, in source time; None where no outcome came."""
    if judged is None or judged.outcome not in read.outcomes:
        return None
    return to_s(read.outcomes[judged.outcome].at_ns - past.event.stamp.source_ns)


def episode(read: History, past: EventPast, root: ProcessPast, bits: float) -> StrangeEpisode:
    """The short story of one event."""
    forecast = root.concluded.forecast if root.concluded else None
    judged = root.judged
    return StrangeEpisode(
        event=past.event.id,
        kind=past.event.kind,
        entity=past.event.entity,
        says=past.event.says,
        at_ns=past.event.stamp.source_ns,
        treatment=root.treatment,
        mode=root.decision.mode if root.decision else "",
        concluded=result_says(root.concluded.result) if root.concluded else "",
        surprise_bits=bits,
        novelty=root.decision.gate.novelty if root.decision else 0.0,
        predicted=forecast.label if forecast else "",
        predicted_probability=forecast.probability if forecast else 0.0,
        label=judged.label if judged else "",
        label_probability=probability_of(judged.label, forecast) if judged and forecast else None,
        verdict=judged.verdict if judged else "",
        judged_after_s=_judged_after_s(read, past, judged),
        state=State(root.state),
        end=root.end or "",
        reopened=_reopenings(read, past),
    )
