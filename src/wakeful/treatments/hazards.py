"""The hazard table for one event: severity × exposure × likelihood, the likelihood learned from how like cases ended."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Literal

from msgspec.structs import replace

from wakeful.facts.asking import Episode
from wakeful.facts.domain import DomainSpec, Hazard, matches
from wakeful.facts.events import Event
from wakeful.facts.values import Fact, Field
from wakeful.treatments.beta import Belief
from wakeful.treatments.measures import significant
from wakeful.treatments.overlap import worth
from wakeful.treatments.signals import margin

Rating = Literal["low", "medium", "serious", "high"]

RATINGS: tuple[Rating, ...] = ("low", "medium", "serious", "high")

#: Levels of the probability of harm (exposure × likelihood), most frequent first: MIL-STD-882E Table II names them A to E; its
#: bounds are for the life of an item, so these are declared for one event.
LEVELS: tuple[tuple[str, float], ...] = (
    ("frequent", 0.3),
    ("probable", 0.1),
    ("occasional", 0.03),
    ("remote", 0.01),
    ("improbable", 0.0),
)

#: MIL-STD-882E Table III: the rating by level (row) and severity class 1 (slight) to 4 (fatal) (column).
MATRIX: dict[str, tuple[Rating, Rating, Rating, Rating]] = {
    "frequent": ("medium", "serious", "high", "high"),
    "probable": ("medium", "serious", "high", "high"),
    "occasional": ("low", "medium", "serious", "high"),
    "remote": ("low", "medium", "medium", "serious"),
    "improbable": ("low", "medium", "medium", "medium"),
}

#: What stands for the severity of an outcome that the table does not list. Nobody has said how bad it is.
UNLISTED_SEVERITY = 1


class HazardRow(Fact, frozen=True):
    """One row: what the table says, what like cases add, and the rating at the mean and at the interval's upper end."""

    hazard: str
    severity: int
    exposure: float
    likelihood: float
    low: float
    high: float
    risk: float
    rating: Rating
    rating_at_worst: Rating
    cases: float = 0.0
    """How much the like cases weigh together; 0: the likelihood is the table's own."""
    harmed: float = 0.0
    cases_to_halve: int = 0
    control: str = ""
    listed: bool = True
    margin: float | None = None
    """How far the event's signals are from keeping the hazard's rule (below zero: broken by so much); None without a rule."""


def assess(event: Event, domain: DomainSpec, past: Sequence[Episode], table_cases: float, mass: float) -> tuple[HazardRow, ...]:
    """The rows that this event opens, greatest risk first, and after them one for each outcome that like cases showed and no
    open hazard speaks of: it is not known to be harm, so it is not rated; it starts from Jeffreys' prior, Beta(1/2, 1/2).
    """
    has = circumstances(event)
    open_now = [hazard for hazard in domain.hazard if matches(hazard.when, has) and not _kept(hazard, event)]
    spoken_of = {label for hazard in open_now for label in shows_as(hazard, domain)}
    rows = [_listed(event, hazard, domain, past, table_cases, mass) for hazard in open_now]
    for label in domain.outcome.labels[1:]:
        if label not in spoken_of and any(case.outcome == label for case in past):
            rows.append(_unlisted(event, label, domain, past, mass))
    return tuple(sorted(rows, key=lambda row: (not row.listed, -row.risk, row.hazard)))


def worst(rows: Sequence[HazardRow]) -> HazardRow | None:
    """The listed row with the worst rating, of equals the greater risk; where none is listed, the likeliest."""
    return max(rows, key=lambda row: (row.listed, RATINGS.index(row.rating), row.risk), default=None)


def circumstances(event: Event) -> Mapping[str, Field]:
    """What conditions (``when``) may look at: the event's fields, its context's, and what it is."""
    return {
        **event.context.fields,
        **event.fields,
        "kind": event.kind,
        "entity": event.entity,
        "says": event.says,
        "relation": event.relation.value,
        "task": event.context.task,
        "zone": event.context.zone,
        "safety": event.context.safety,
        "criticality": event.criticality,
    }


def shows_as(hazard: Hazard, domain: DomainSpec) -> tuple[str, ...]:
    """The outcome labels that show this hazard come true; none where the domain does not tell."""
    labels = domain.outcome.labels
    if hazard.outcomes:
        return tuple(label for label in hazard.outcomes if label in labels)
    if hazard.name in labels:
        return (hazard.name,)
    return labels[1:] if len(labels) == 2 else ()


def rating(severity: int, harm: float) -> Rating:
    """The matrix at a severity class and a probability of harm.

    >>> rating(4, 0.05), rating(1, 0.001)
    ('high', 'low')
    """
    level = next(name for name, least in LEVELS if harm >= least)
    return MATRIX[level][min(max(severity, 1), 4) - 1]


def _listed(
    event: Event, hazard: Hazard, domain: DomainSpec, past: Sequence[Episode], table_cases: float, mass: float
) -> HazardRow:
    hits, cases = _shown(event, shows_as(hazard, domain), domain, past)
    belief = Belief.of(hazard.likelihood, table_cases).after(hits, cases - hits)
    exposure = min(max(hazard.exposure, 0.0), 1.0)
    row = _row(hazard.name, hazard.severity, exposure, belief, cases, hits, mass, hazard.control)
    return replace(row, margin=margin(hazard.rule, event.fields)) if hazard.rule else row


def _kept(hazard: Hazard, event: Event) -> bool:
    """Whether the event's signals keep the hazard's rule; where it has none, or a signal is missing, nobody knows."""
    if not hazard.rule:
        return False
    left = margin(hazard.rule, event.fields)
    return left is not None and left >= 0.0


def _unlisted(event: Event, label: str, domain: DomainSpec, past: Sequence[Episode], mass: float) -> HazardRow:
    hits, cases = _shown(event, (label,), domain, past)
    belief = Belief(0.5, 0.5).after(hits, cases - hits)
    row = _row(label, UNLISTED_SEVERITY, 1.0, belief, cases, hits, mass)
    return replace(row, rating="low", rating_at_worst="low", listed=False)


def _row(
    name: str, severity: int, exposure: float, belief: Belief, cases: float, hits: float, mass: float, control: str = ""
) -> HazardRow:
    low, high = belief.interval(mass)
    severity = min(max(severity, 1), 4)
    return HazardRow(
        hazard=name,
        severity=severity,
        exposure=exposure,
        likelihood=significant(belief.mean),
        low=low,
        high=high,
        risk=significant(severity / 4 * exposure * belief.mean),
        rating=rating(severity, exposure * belief.mean),
        rating_at_worst=rating(severity, exposure * high),
        cases=significant(cases),
        harmed=significant(hits),
        cases_to_halve=belief.cases_to_halve(),
        control=control,
    )


def _shown(event: Event, labels: tuple[str, ...], domain: DomainSpec, past: Sequence[Episode]) -> tuple[float, float]:
    """How many of the ended cases showed one of the labels, of how many; nothing is learned where no label is known."""
    ended = [(case, worth(event, case, domain.fields)) for case in past if labels and case.outcome in domain.outcome.labels]
    return sum(weight for case, weight in ended if case.outcome in labels), sum(weight for _, weight in ended)
