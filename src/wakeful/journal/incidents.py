"""How well registration hears: observations per event, events per hour, and incidents that were registered before they came.

Coverage of a deaf registrar is 100 % of nothing. Where a recording knows its incidents (outcomes that the world showed), this
says how many of them had an event in the window before, how early, and how many random events at the same rate would get.
"""

from __future__ import annotations

from bisect import bisect_left
from collections import Counter
from collections.abc import Collection, Sequence
from itertools import pairwise
from statistics import median

from wakeful.facts.experience import Verdict
from wakeful.facts.time import NS_PER_S, to_ns, to_s
from wakeful.journal.history import History, history
from wakeful.journal.readable import Readable, View

DEFAULT_WITHIN_S = 60.0
_UNRECORDED_S = 600.0


class Heard(View, frozen=True):
    """Incidents of one label (or all) that had at least one event in the window before them.

    ``by_chance`` is the share that as many events thrown at random over the same time would get, ``lift`` the quotient.
    ``first_s`` and ``last_s`` are median seconds from the earliest and the latest such event to the incident.
    ``foretold`` counts those that a result had forecast by their own label before they came.
    """

    label: str
    incidents: int
    before: int
    share: float
    by_chance: float
    lift: float | None
    first_s: float | None
    last_s: float | None
    foretold: int = 0


class KindStats(View, frozen=True):
    """One kind of event: how many, how often, and the incidents that it stood before."""

    kind: str
    events: int
    per_hour: float
    observations: int
    before: int
    share: float
    by_chance: float


class Stats(View, frozen=True):
    """What registration made of a source."""

    observations: int
    events: int
    observations_per_event: float
    duration_s: float
    events_per_hour: float
    within_s: float
    kinds: tuple[KindStats, ...]
    incidents: tuple[Heard, ...]


def stats(journal: Readable, within_s: float | None = None, bad: Collection[str] | None = None) -> Stats:
    """Registration's statistics.

    Args:
        journal: any journal.
        within_s: how long before an incident an event counts as its sign; None: the window of the journal's own forecasts.
        bad: the labels of outcomes that are incidents, as the domain says; None: all but what a closed window means.

    Returns:
        the statistics; ``incidents`` is empty where the recording knows none, else its first row is of all labels.
    """
    return stats_of(history(journal), within_s, bad)


def stats_of(read: History, within_s: float | None = None, bad: Collection[str] | None = None) -> Stats:
    """The same from a history that was read already."""
    window_s = _own_window_s(read) if within_s is None else within_s
    events = [past.event for past in read.events.values()]
    instants = sorted(event.stamp.source_ns for event in events)
    quiet = _quiet_labels(read)
    shown = sorted(
        (outcome.at_ns, outcome.label, outcome.id)
        for outcome in read.outcomes.values()
        if outcome.origin == "world" and (outcome.label not in quiet if bad is None else outcome.label in bad)
    )
    known = sorted([*instants, *(outcome.at_ns for outcome in read.outcomes.values() if outcome.origin == "world")])
    start_ns, observed_ns = (known[0] if known else 0), _observed_ns(known)
    hours = to_s(observed_ns) / 3600
    frame = (start_ns, observed_ns, to_ns(window_s))
    observed = observations_of(read)
    foretold = _foretold(read)
    kinds = Counter(event.kind for event in events)
    rows = []
    for kind, count in kinds.most_common():
        own = sorted(event.stamp.source_ns for event in events if event.kind == kind)
        heard = _heard(kind, own, [at_ns for at_ns, _, _ in shown], frame)
        rows.append(
            KindStats(
                kind=kind,
                events=count,
                per_hour=count / hours if hours else 0.0,
                observations=sum(event.observations for event in events if event.kind == kind),
                before=heard.before,
                share=heard.share,
                by_chance=heard.by_chance,
            )
        )
    labels = ["", *sorted({label for _, label, _ in shown})] if shown else []
    return Stats(
        observations=observed,
        events=len(events),
        observations_per_event=observed / len(events) if events else 0.0,
        duration_s=to_s(observed_ns),
        events_per_hour=len(events) / hours if hours else 0.0,
        within_s=window_s,
        kinds=tuple(rows),
        incidents=tuple(
            _heard(
                label or "any",
                instants,
                [at_ns for at_ns, shows, _ in shown if label in ("", shows)],
                frame,
                sum(1 for _, shows, identity in shown if label in ("", shows) and identity in foretold),
            )
            for label in labels
        ),
    )


def observations_of(read: History) -> int:
    """How many observations were read, each source once: as its end says, or up to its last event where it has not ended."""
    most: dict[str, int] = {}
    for source, number in (
        *((finished.source, finished.observations) for finished in read.finished),
        *((past.event.source, past.event.position + 1) for past in read.events.values()),
    ):
        most[source] = max(most.get(source, 0), number)
    return sum(most.values())


def _observed_ns(known: Sequence[int]) -> int:
    """The time between the first and the last of these instants, without the stretches in which nobody was recording.

    The journal knows when things happened, not when somebody looked: a stretch counts as unrecorded when it is longer than ten
    minutes and than twenty times what nine in ten of them last. Counting it would flatter registration against chance.
    """
    stretches = [later - earlier for earlier, later in pairwise(known)]
    if not stretches:
        return 0
    usual = sorted(stretches)[len(stretches) * 9 // 10]
    longest = max(to_ns(_UNRECORDED_S), 20 * usual)
    return sum(stretch for stretch in stretches if stretch <= longest)


def _quiet_labels(read: History) -> set[str]:
    """The labels that an unbroken window without any outcome means: to witness one is no incident."""
    closed = {
        judged.label
        for process in read.processes.values()
        for _, judged in process.verdicts
        if not judged.outcome and judged.verdict is not Verdict.UNDECIDED
    }
    return closed or {"none"}


def _own_window_s(read: History) -> float:
    """The window that most forecasts of the journal were given."""
    windows = Counter(
        round(to_s(root.concluded.closes_ns - past.admitted_ns), 3)
        for past, root in read.roots()
        if root.concluded and root.concluded.closes_ns is not None and root.concluded.closes_ns > past.admitted_ns
    )
    return windows.most_common(1)[0][0] if windows else DEFAULT_WITHIN_S


def _foretold(read: History) -> set[str]:
    """Outcomes that a result had forecast by their own label before they came."""
    return {
        judged.outcome
        for process in read.processes.values()
        for _, judged in process.verdicts
        if judged.outcome and judged.predicted == judged.label and (judged.lead_ns is None or judged.lead_ns > 0)
    }


def _heard(
    label: str, events_ns: Sequence[int], incidents_ns: Sequence[int], frame: tuple[int, int, int], foretold: int = 0
) -> Heard:
    start_ns, observed_ns, window_ns = frame
    first, last, chance = [], [], []
    for at_ns in incidents_ns:
        opened = bisect_left(events_ns, at_ns - window_ns)
        closed = bisect_left(events_ns, at_ns)
        if closed > opened:
            first.append((at_ns - events_ns[opened]) / NS_PER_S)
            last.append((at_ns - events_ns[closed - 1]) / NS_PER_S)
        reach = min(window_ns, at_ns - start_ns) / max(1, observed_ns)
        chance.append(1.0 - (1.0 - min(1.0, reach)) ** len(events_ns))
    share = len(first) / len(incidents_ns) if incidents_ns else 0.0
    by_chance = sum(chance) / len(chance) if chance else 0.0
    return Heard(
        label=label,
        incidents=len(incidents_ns),
        before=len(first),
        share=share,
        by_chance=by_chance,
        lift=share / by_chance if by_chance else None,
        first_s=median(first) if first else None,
        last_s=median(last) if last else None,
        foretold=foretold,
    )
