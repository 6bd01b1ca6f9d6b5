"""Memory: how this differs from what was remembered, since when, whether it has happened before, and how that ended."""

from __future__ import annotations

from wakeful.contracts.treatment import Mind
from wakeful.facts.asking import Episode
from wakeful.facts.events import Event
from wakeful.facts.results import Result
from wakeful.facts.values import Fact
from wakeful.treatments.consulting import consult
from wakeful.treatments.decorator import treatment
from wakeful.treatments.forecasting import expectation, forecast_reasons, pooled, recalled_voice
from wakeful.treatments.measures import measured, significant
from wakeful.treatments.overlap import overlap
from wakeful.treatments.remembering import (
    Difference,
    Ending,
    age_s,
    change,
    differences,
    ended,
    endings,
    of_entity,
    resting,
    similar,
)
from wakeful.treatments.sureness import NOTHING_TO_GO_ON, sentence, sure
from wakeful.treatments.wording import ago, bare, brief, counted, span, subject


class MemorySettings(Fact, frozen=True):
    """How much is recalled, what counts as the same happening, and how fast a sighting fades."""

    sightings: int = 12
    cases: int = 8
    cases_deliberating: int = 20
    alike: float = 0.8
    """The least share of attributes on which a case of the same kind must agree to count as the same happening."""
    half_life_s: float = 3600.0
    """A memory that was never refreshed is worth half after so long; each further sighting makes it last as much longer."""


class SameAs(Fact, frozen=True):
    """A reasoner's recognition: the recalled case that this is the same happening as."""

    case: str


class Memory(Result, frozen=True, kw_only=True, tag="memory"):
    """The event beside what is remembered of its entity and of like events."""

    known: bool
    sightings: int = 0
    last_seen: str = ""
    last_seen_s: float | None = None
    """How long ago; below zero where it was by another clock, so that nobody knows."""
    retention: float = 0.0
    """How much of the memory may still hold, in [0, 1]: the forgetting curve at the age of the last sighting."""
    differs: tuple[Difference, ...] = ()
    unchanged: tuple[str, ...] = ()
    as_before: str = ""
    """The last sighting of the entity that differs in nothing, where it is not the last of all."""
    as_before_s: float | None = None
    same_as: str = ""
    """The recalled case that a reasoner took this for, where it was asked."""
    happened: int = 0
    endings: tuple[Ending, ...] = ()


@treatment(
    "memory",
    result=Memory,
    says="Compares with what is remembered: what differs, since when, whether it happened before and how it ended.",
)
async def memory(event: Event, mind: Mind) -> Memory:
    """Recall the entity and like events, and say what differs from what was remembered."""
    return await remember(event, mind, MemorySettings())


async def remember(event: Event, mind: Mind, settings: MemorySettings) -> Memory:
    """The thinking of ``memory`` with settings of one's own.

    Source: retention falls exponentially with age and more slowly with each repetition (Ebbinghaus 1885; the half-life form of
    Settles and Meeder 2016).
    """
    await mind.work(1)
    past = await of_entity(event, mind, settings.sightings)
    limit = settings.cases_deliberating if mind.mode == "delib" else settings.cases
    like = await similar(event, mind, limit)
    alike = [case for case in like if _same_happening(event, case, mind, settings)]
    await mind.work(1)
    recalled = {case.event: case for case in (*like, *past)}
    said = await consult(
        event,
        mind,
        "memory",
        "Which of the recalled cases, by its id, is the same happening as this one?",
        SameAs,
        lambda same: "" if same.case in recalled else f"no case {same.case[:60]!r} was recalled",
        (*like, *past),
        recalled,
    )
    if said.answer is not None and all(case.event != said.answer.case for case in alike):
        alike.append(recalled[said.answer.case])

    same_kind = [episode for episode in past if episode.kind == event.kind]
    differs = differences(event, same_kind, mind.domain.fields)
    changed = {difference.name for difference in differs}
    just_so = next((each for each in same_kind if differs and not differences(event, [each], mind.domain.fields)), None)
    compared = [
        name for name in measured(event.fields, mind.domain.fields) if any(name in episode.fields for episode in same_kind)
    ]
    last_s = age_s(event, past[0]) if past else None
    retention = _retention(last_s, len(past), settings)
    rows = endings(alike)
    voice = recalled_voice(mind, event, alike)
    forecast = pooled(mind, event, [voice])
    confidence = max(retention, 1.0 - 0.5 ** len(alike)) if past or alike else NOTHING_TO_GO_ON
    return Memory(
        says=sentence(
            mind,
            subject(event),
            _differing(differs, past, len(same_kind), last_s),
            f"; it was just so {ago(age_s(event, just_so))}" if just_so is not None else "",
            _before(rows, len(alike), limit),
            expectation(forecast),
        ),
        confidence=sure(mind, 0.95 * confidence),
        rests_on=(
            f"event {event.id}",
            *resting([*past, *alike]),
            *forecast_reasons(mind, [voice]),
            *said.basis,
        ),
        would_change=_would_change(event, differs, alike, mind),
        forecast=forecast,
        consulted=said.consulted,
        as_before=just_so.event if just_so is not None else "",
        as_before_s=age_s(event, just_so) if just_so is not None else None,
        same_as=said.answer.case if said.answer is not None else "",
        known=bool(past),
        sightings=len(past),
        last_seen=past[0].event if past else "",
        last_seen_s=last_s,
        retention=significant(retention, 3),
        differs=differs,
        unchanged=tuple(name for name in compared if name not in changed),
        happened=len(alike),
        endings=rows,
    )


def _same_happening(event: Event, case: Episode, mind: Mind, settings: MemorySettings) -> bool:
    shared = overlap(event.fields, case.fields, mind.domain.fields)
    return case.kind == event.kind and (shared.share >= settings.alike or not shared.names)


def _retention(last_s: float | None, sightings: int, settings: MemorySettings) -> float:
    if last_s is None:
        return 0.0
    if last_s < 0.0:
        return 0.5  # by another clock: how old the memory is nobody knows
    return float(0.5 ** (last_s / (settings.half_life_s * sightings)))


def _differing(differs: tuple[Difference, ...], past: tuple[Episode, ...], same_kind: int, last_s: float | None) -> str:
    if last_s is None:
        return "; not remembered at all"
    if not same_kind:
        return f"; remembered, the last {ago(last_s)}, but never like this ({counted(len(past), 'sighting')} of other kinds)"
    if not differs:
        return f"; as remembered ({counted(same_kind, 'such sighting')}, the last seen {ago(last_s)})"
    told = ", ".join(change(difference) for difference in differs[:3])
    more = f" and {len(differs) - 3} more" if len(differs) > 3 else ""
    oldest = max((difference.held_s or 0.0) for difference in differs)
    since = f", changed within the last {span(oldest)}" if oldest > 0.0 else f", the last seen {ago(last_s)}"
    return f"; differs from what was remembered: {told}{more}{since}"


def _before(rows: tuple[Ending, ...], happened: int, limit: int) -> str:
    if not happened:
        return "; nothing like it has happened before"
    return f"; it happened {counted(happened, 'time', limit)} before: {ended(rows)}"


def _would_change(event: Event, differs: tuple[Difference, ...], alike: list[Episode], mind: Mind) -> tuple[str, ...]:
    name = brief(event.entity)
    moved = tuple(f"a sighting of {name} with {bare(each.name)} as it was" for each in differs[:3])
    open_cases = sum(1 for case in alike if not case.outcome)
    waiting = (f"the end of {counted(open_cases, 'like case')}, not seen yet",) if open_cases else ()
    label = mind.domain.outcome.labels[:1]
    first = (f"a like case that does not end in {label[0]}",) if label and alike and not waiting else ()
    return (*moved, *waiting, *first) or (f"a first sighting or like case of {name}",)
