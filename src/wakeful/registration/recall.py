"""What registration was worth: the share of known incidents that an event came before, how early, and against chance.

Coverage says nothing of this: a deaf registrar covers 100 % of nothing.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterable, Sequence
from statistics import quantiles

from wakeful.facts.evidence import Outcome
from wakeful.facts.time import to_ns
from wakeful.facts.values import Fact


class Incident(Fact, frozen=True):
    """Something that is known to have gone wrong: its label, when it began, over how many observations it lasted."""

    label: str
    at_ns: int
    observations: int = 1


class Recall(Fact, frozen=True):
    """How many incidents of one label had an event in the window before them.

    ``share`` is of incidents, ``observations_share`` of the observations that they lasted. ``lead_s`` are the lower
    quartile, median and upper quartile of the seconds from the earliest event in the window to the incident.
    ``chance`` is the share that as many events placed evenly at random over the time observed would be expected to reach;
    None where that time is not known.
    """

    label: str
    window_s: float
    incidents: int
    preceded: int
    share: float
    observations: int
    observations_share: float
    lead_s: tuple[float, float, float] | None = None
    chance: float | None = None


def incidents_of(outcomes: Iterable[Outcome]) -> tuple[Incident, ...]:
    """The incidents that outcomes stand for, in order of time: one each, by what began it."""
    ordered = sorted(outcomes, key=lambda outcome: (outcome.at_ns, outcome.label, outcome.id))
    return tuple(Incident(label=outcome.label, at_ns=outcome.at_ns) for outcome in ordered)


def recall(
    incidents: Sequence[Incident], events_ns: Iterable[int], window_s: float, observed_s: float | None = None
) -> tuple[Recall, ...]:
    """The recall of registration for each label of the incidents.

    Only events strictly before an incident's beginning count, and not longer before it than the window: the event that an
    incident itself makes is never counted for it.

    Args:
        incidents: what is known to have gone wrong.
        events_ns: the instants of the events, in any order.
        window_s: how long before an incident an event counts, in seconds.
        observed_s: for how long the source was observed, its gaps left out; for ``chance``.

    Returns:
        One Recall for each label, in the order in which the labels first appear.

    >>> stops = (Incident(label="stop", at_ns=10_000_000_000, observations=3), Incident(label="stop", at_ns=60_000_000_000))
    >>> (found,) = recall(stops, [8_000_000_000, 10_000_000_000, 60_000_000_000], window_s=5.0, observed_s=100.0)
    >>> found.preceded, found.share, found.observations_share, found.lead_s, round(found.chance, 3)
    (1, 0.5, 0.75, (2.0, 2.0, 2.0), 0.143)
    """
    events = sorted(events_ns)
    window_ns = to_ns(window_s)
    found = []
    for label in dict.fromkeys(incident.label for incident in incidents):
        of_label = [incident for incident in incidents if incident.label == label]
        leads_s, preceded, observations = [], 0, 0
        for incident in of_label:
            first = bisect_left(events, incident.at_ns - window_ns)
            if first < bisect_left(events, incident.at_ns):
                preceded += 1
                observations += incident.observations
                leads_s.append((incident.at_ns - events[first]) / 1e9)
        every = sum(incident.observations for incident in of_label)
        found.append(
            Recall(
                label=label,
                window_s=window_s,
                incidents=len(of_label),
                preceded=preceded,
                share=preceded / len(of_label),
                observations=every,
                observations_share=observations / every,
                lead_s=_quartiles(leads_s),
                chance=None if observed_s is None else _chance(len(events), window_s, observed_s),
            )
        )
    return tuple(found)


def _chance(events: int, window_s: float, observed_s: float) -> float:
    """That at least one of so many evenly random instants falls into a window."""
    return 0.0 if not events else 1.0 if window_s >= observed_s else 1.0 - (1.0 - window_s / observed_s) ** events


def _quartiles(values: Sequence[float]) -> tuple[float, float, float] | None:
    if not values:
        return None
    if len(values) == 1:
        return (values[0], values[0], values[0])
    low, middle, high = quantiles(values, n=4, method="inclusive")
    return (low, middle, high)
