"""Words that were never met, compared with known ones by their meaning: what an analogy may rest on beside attributes.

A word that was met before is told from the others by being another, whatever it means: "above" and "below" are near in meaning.
So is one of those that the domain declares. Only what is new can be like something else.
"""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Generator, Mapping, Sequence
from functools import partial

from msgspec import convert

from wakeful.contracts.treatment import Mind, Refusal
from wakeful.facts.asking import Episode
from wakeful.facts.events import Event
from wakeful.facts.values import Fact
from wakeful.treatments.meaning import counts, nearness, read, words
from wakeful.treatments.measures import comparable
from wakeful.treatments.overlap import Meanings

#: How long the encoder may take, from reading its model on.
WITHIN_S = 10.0

#: So many known words are compared with one, at most and at least: which of one or two is nearest says nothing of likeness.
KNOWN, LEAST_KNOWN = 32, 3


class Unmet(Fact, frozen=True):
    """A word of the event that no recalled case has: where it stands, and the known ones there."""

    field: str
    word: str
    known: tuple[str, ...]


class Meant(Fact, frozen=True):
    """A word that was never met, and the known ones that it counts as, most first, in [0, 1]. ``kind``: the event's own."""

    field: str
    word: str
    counts: dict[str, float]


def unmet(event: Event, cases: Sequence[Episode], mind: Mind) -> tuple[Unmet, ...]:
    """The event's words that neither the domain declares nor a case has, where the cases have others."""
    found = []
    kinds = {case.kind for case in cases}
    if event.kind not in kinds:
        found.append(("kind", event.kind, kinds))
    for name, value in comparable(event.fields).items():
        declared = mind.domain.fields[name].values if name in mind.domain.fields else ()
        known = {each for case in cases if isinstance(each := case.fields.get(name), str) and words(each)}
        if isinstance(value, str) and words(value) and value not in declared and value not in known:
            found.append((name, value, known))
    return tuple(
        Unmet(field=name, word=word, known=tuple(sorted(known)[:KNOWN]))
        for name, word, known in found
        if len(known) >= LEAST_KNOWN
    )


async def meant(event: Event, cases: Sequence[Episode], mind: Mind) -> tuple[Meant, ...]:
    """What the event's new words count as; nothing where there are none, or no encoder answers."""
    new = unmet(event, cases, mind)
    if not new:
        return ()
    read_all: Callable[[], Awaitable[object]] = partial(_near, new)
    try:
        answer: object = await mind.call(read_all, "meaning", WITHIN_S)
    except Refusal:
        return ()
    near = convert(answer, tuple[dict[str, float], ...])
    told = [
        Meant(field=each.field, word=each.word, counts=_most_first(counts(known))) for each, known in zip(new, near, strict=True)
    ]
    return tuple(each for each in told if any(each.counts.values()))


def meanings(told: Sequence[Meant]) -> Meanings:
    """The same, as overlap and worth take it."""
    return {each.field: each.counts for each in told}


class _Breath:
    """Between two words whoever else runs in this thread has a turn: a word takes 5 ms, all of them a fifth of a second."""

    def __await__(self) -> Generator[None, None, None]:
        yield


async def _near(new: Sequence[Unmet]) -> list[dict[str, float]]:
    for each in new:
        for word in (each.word, *each.known):
            read(words(word))
            await _Breath()
    return [
        dict(zip(each.known, nearness([words(each.word)], [words(known) for known in each.known])[0], strict=True))
        for each in new
    ]


def _most_first(found: Mapping[str, float]) -> dict[str, float]:
    return dict(sorted(found.items(), key=lambda each: (-each[1], each[0])))
