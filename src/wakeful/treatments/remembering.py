"""What is recalled, and what it says beside what is here now: how it ended, and what differs."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from math import inf
from statistics import median
from typing import NamedTuple

from wakeful.contracts.treatment import Mind
from wakeful.facts.asking import Episode, Query
from wakeful.facts.domain import FieldSpec
from wakeful.facts.events import Event
from wakeful.facts.time import to_s
from wakeful.facts.values import Fact, Field
from wakeful.treatments.measures import measured, number, plain, significant
from wakeful.treatments.overlap import scale
from wakeful.treatments.wording import valued, worded

#: A number differs when it is off by more than this part of its declared range, or of itself where no range is declared.
TOLERANCE = 0.05


#: How many recalled events a result names.
NAMED = 8


class Ending(Fact, frozen=True):
    """How recalled cases ended: the outcome's label, and in how many."""

    outcome: str
    count: int


class Difference(Fact, frozen=True):
    """One field that is not as remembered. ``held_s`` is how long ago the old value was last seen."""

    name: str
    was: Field
    now: Field
    held_s: float | None = None
    sightings: int = 1
    """How many sightings in a row, back from the last, had the old value."""


class Recalled(NamedTuple):
    """Episodes, newest first, and how far back nothing of their kind is missing."""

    episodes: tuple[Episode, ...]
    reach_s: float


NOTHING_RECALLED = Recalled((), inf)


async def similar(event: Event, mind: Mind, limit: int) -> tuple[Episode, ...]:
    """Recall the cases most like this event, never the event itself."""
    found = await mind.recall(Query(event=event.id, limit=limit))
    return tuple(episode for episode in found if episode.event != event.id)


async def of_entity(event: Event, mind: Mind, limit: int, kind: str = "") -> tuple[Episode, ...]:
    """Recall what is remembered of the event's entity (only events of a kind, if given), newest first, never the event itself."""
    found = await mind.recall(Query(entity=event.entity, kind=kind, limit=limit))
    return newest_first(episode for episode in found if episode.event != event.id and episode.entity == event.entity)


async def of_robot(event: Event, mind: Mind, limit: int) -> tuple[Episode, ...]:
    """Recall the newest events of the event's robot, of whatever entity, never the event itself."""
    found = await mind.recall(Query(limit=limit))
    return newest_first(episode for episode in found if episode.event != event.id and _same_robot(event, episode))


async def of_kind(event: Event, mind: Mind, kind: str, limit: int) -> Recalled:
    """Recall events of one kind and of the event's robot, never the event itself."""
    found = await mind.recall(Query(kind=kind, limit=limit))
    kept = newest_first(e for e in found if e.event != event.id and e.kind == kind and _same_robot(event, e))
    # a recall that is full may have left older ones out
    reach_s = inf if len(found) < limit else max(age_s(event, episode) for episode in found)
    return Recalled(kept, reach_s)


def _same_robot(event: Event, episode: Episode) -> bool:
    """A memory that doesn't name robots is of one robot."""
    return not episode.robot or not event.robot or episode.robot == event.robot


def newest_first(episodes: Iterable[Episode]) -> tuple[Episode, ...]:
    """In falling order of time; equal instants by the event's id, so that the order never depends on the search."""
    return tuple(sorted(episodes, key=lambda episode: (-episode.at_ns, episode.event)))


def age_s(event: Event, episode: Episode) -> float:
    """How long before the event the episode was, by the source's clock; below zero where it came later."""
    return significant(to_s(event.stamp.source_ns - episode.at_ns))


def resting(episodes: Iterable[Episode]) -> tuple[str, ...]:
    """The episodes as ``rests_on`` names them: the first ones, and how many more."""
    ids = list(dict.fromkeys(episode.event for episode in episodes))
    more = (f"{len(ids) - NAMED} more recalled events",) if len(ids) > NAMED else ()
    return (*(f"event {each}" for each in ids[:NAMED]), *more)


def endings(episodes: Iterable[Episode]) -> tuple[Ending, ...]:
    """The cases by outcome, most frequent first; those whose outcome nobody has seen yet stand under ``""``, last."""
    counts: dict[str, int] = {}
    for episode in episodes:
        counts[episode.outcome] = counts.get(episode.outcome, 0) + 1
    rows = [Ending(outcome=label, count=count) for label, count in counts.items()]
    return tuple(sorted(rows, key=lambda row: (not row.outcome, -row.count, row.outcome)))


def ended(rows: Sequence[Ending]) -> str:
    """The endings as part of a sentence.

    >>> ended((Ending(outcome="none", count=4), Ending(outcome="", count=1)))
    '4 ended in none, 1 not yet known'
    """
    said = [f"{row.count} ended in {row.outcome}" if row.outcome else f"{row.count} not yet known" for row in rows]
    return ", ".join(said)


def same(name: str, a: Field, b: Field, specs: Mapping[str, FieldSpec]) -> bool:
    """Whether two values of a field count as the same: numbers within a tolerance of the field's range."""
    left, right = number(a), number(b)
    if left is None or right is None:
        return plain(a) == plain(b)
    return abs(left - right) <= TOLERANCE * scale(left, right, specs.get(name)) + 1e-12


def differences(event: Event, past: Sequence[Episode], specs: Mapping[str, FieldSpec]) -> tuple[Difference, ...]:
    """What differs between the event and the last sighting of its entity that had each field.

    ``past`` is newest first, and of the event's own kind: another kind's fields may mean something else by the same name.
    """
    found = []
    for name, now in measured(event.fields, specs).items():
        having = [episode for episode in past if name in episode.fields]
        if not having or same(name, now, having[0].fields[name], specs):
            continue
        was = having[0].fields[name]
        run = 0
        while run < len(having) and same(name, was, having[run].fields[name], specs):
            run += 1
        held = age_s(event, having[0])
        found.append(Difference(name=name, was=plain(was), now=plain(now), held_s=held if held >= 0.0 else None, sightings=run))
    return tuple(found)


def change(difference: Difference) -> str:
    """A difference as part of a sentence.

    >>> change(Difference(name="load_kg", was=1.0, now=2.5))
    'load 2.5 kg (was 1 kg)'
    """
    name, now, was = difference.name, difference.now, difference.was
    return f"{worded(name, now)} (was {valued(name, was)})"


def typical(values: Sequence[Field]) -> Field:
    """The usual one: the median of numbers, else the most frequent value (the earlier of equals)."""
    known = [value for value in (number(each) for each in values) if value is not None]
    if known and len(known) == len(values):
        return significant(median(known))
    usable = [plain(value) for value in values]
    return max(usable, key=usable.count) if usable else None
