"""Comparison: this entity against its peers and against its own past, as a table."""

from __future__ import annotations

from collections.abc import Sequence
from statistics import median

from wakeful.contracts.treatment import Mind
from wakeful.facts.asking import Episode
from wakeful.facts.events import Event
from wakeful.facts.results import Result
from wakeful.facts.values import Fact, Field
from wakeful.treatments.change import change_point, cliffs_delta, robust_z
from wakeful.treatments.consulting import consult
from wakeful.treatments.decorator import treatment
from wakeful.treatments.forecasting import expectation, forecast_reasons, pooled, recalled_voice
from wakeful.treatments.measures import measured, number, plain, significant
from wakeful.treatments.remembering import age_s, of_entity, of_kind, resting, typical
from wakeful.treatments.sureness import NOTHING_TO_GO_ON, sentence, sure
from wakeful.treatments.wording import bare, brief, counted, span, subject, valued


class ComparisonSettings(Fact, frozen=True):
    """How much is recalled, and from which robust z on a number is called unusual."""

    past: int = 20
    peers: int = 20
    deliberating: int = 40
    unusual_z: float = 3.5
    rare_share: float = 0.1


class Row(Fact, frozen=True):
    """One attribute: its value, its own past, its peers, and how far it is from each. ``z`` in robust standard deviations."""

    name: str
    now: Field
    own_usual: Field = None
    own_count: int = 0
    own_z: float | None = None
    peers_usual: Field = None
    peers_count: int = 0
    peers_z: float | None = None
    effect: float | None = None
    """Cliff's delta of its own past (and now) against its peers: 1 above all of them, -1 below all."""
    share: float | None = None
    """Of a value that is no number: the share of past and peers that have it too."""
    shifted_s: float | None = None
    """How long ago its own level shifted, where it did."""
    shifted_from: float | None = None
    shifted_to: float | None = None
    unusual: bool = False


class Telling(Fact, frozen=True):
    """A reasoner's pick: the attribute whose difference matters."""

    attribute: str


class Comparison(Result, frozen=True, kw_only=True, tag="comparison"):
    """The table, the most unusual rows first."""

    rows: tuple[Row, ...] = ()
    past: int = 0
    peers: int = 0
    peer_entities: tuple[str, ...] = ()
    unusual: tuple[str, ...] = ()


@treatment(
    "comparison",
    result=Comparison,
    says="Compares an entity with its peers and its own past: how unusual, how large the effect, and since when.",
)
async def comparison(event: Event, mind: Mind) -> Comparison:
    """Compare every attribute with the entity's own past and with its peers."""
    return await compare(event, mind, ComparisonSettings())


async def compare(event: Event, mind: Mind, settings: ComparisonSettings) -> Comparison:
    """The thinking of ``comparison`` with settings of one's own."""
    await mind.work(1)
    more = mind.mode == "delib"
    limit = settings.deliberating if more else settings.past
    own = [episode for episode in await of_entity(event, mind, limit, event.kind) if age_s(event, episode) >= 0.0]
    found = await of_kind(event, mind, event.kind, settings.deliberating if more else settings.peers)
    await mind.work(1)
    peers = [episode for episode in found.episodes if episode.entity != event.entity and age_s(event, episode) >= 0.0]

    rows = sorted(
        (_row(event, name, own, peers, settings) for name in measured(event.fields, mind.domain.fields)), key=_strangest
    )
    unusual = tuple(row.name for row in rows if row.unusual)
    compared = [row for row in rows if row.own_count or row.peers_count]
    telling = {row.name for row in compared}
    said = await consult(
        event,
        mind,
        "comparison",
        "Which of these attributes differs in a way that matters?",
        Telling,
        lambda pick: "" if pick.attribute in telling else f"{pick.attribute[:60]!r} was not compared with anything",
        own,
        sorted(telling),
    )
    if said.answer is not None:
        first = said.answer.attribute
        rows.sort(key=lambda row: row.name != first)
    voice = recalled_voice(mind, event, [*own, *peers], ranked=False)
    forecast = pooled(mind, event, [voice])
    entities = tuple(dict.fromkeys(brief(episode.entity) for episode in peers))
    # an effect can't be surer than the number of others it is measured against
    most = max((row.own_count + row.peers_count for row in rows), default=0)
    return Comparison(
        says=sentence(mind, subject(event), _beside(rows, len(own), len(peers), len(entities)), expectation(forecast)),
        confidence=sure(mind, NOTHING_TO_GO_ON if not compared else 0.95 * most / (most + 5.0)),
        rests_on=(
            f"event {event.id}",
            *resting((*own, *peers)),
            *forecast_reasons(mind, [voice]),
            *said.basis,
        ),
        would_change=_would_change(event, rows, len(own), len(peers)),
        forecast=forecast,
        consulted=said.consulted,
        rows=tuple(rows),
        past=len(own),
        peers=len(peers),
        peer_entities=entities[:12],
        unusual=unusual,
    )


def _row(event: Event, name: str, own: Sequence[Episode], peers: Sequence[Episode], settings: ComparisonSettings) -> Row:
    now = event.fields[name]
    before = [(age_s(event, episode), episode.fields[name]) for episode in own if name in episode.fields]
    beside = [episode.fields[name] for episode in peers if name in episode.fields]
    value = number(now)
    if value is None:
        return _categorical(name, now, [each for _, each in before], beside, settings)
    past = [(age_s_, known) for age_s_, known in ((age, number(each)) for age, each in before) if known is not None]
    others = [known for known in (number(each) for each in beside) if known is not None]
    history = [known for _, known in past]
    own_z, peers_z = robust_z(value, history), robust_z(value, others)
    # oldest first, this event last
    shift = change_point([*reversed(history), value])
    ages = [*reversed([age for age, _ in past]), 0.0]
    return Row(
        name=name,
        now=value,
        own_usual=significant(median(history)) if history else None,
        own_count=len(history),
        own_z=_rounded(own_z),
        peers_usual=significant(median(others)) if others else None,
        peers_count=len(others),
        peers_z=_rounded(peers_z),
        effect=_rounded(cliffs_delta([*history, value], others)),
        shifted_s=None if shift is None else significant(ages[shift.at]),
        shifted_from=None if shift is None else significant(shift.before),
        shifted_to=None if shift is None else significant(shift.after),
        unusual=any(abs(z) >= settings.unusual_z for z in (own_z, peers_z) if z is not None),
    )


def _categorical(name: str, now: Field, own: list[Field], peers: list[Field], settings: ComparisonSettings) -> Row:
    others = [plain(each) for each in (*own, *peers)]
    share = others.count(plain(now)) / len(others) if others else None
    return Row(
        name=name,
        now=plain(now),
        own_usual=typical(own),
        own_count=len(own),
        peers_usual=typical(peers),
        peers_count=len(peers),
        share=_rounded(share),
        unusual=share is not None and len(others) >= 3 and share <= settings.rare_share,
    )


def _strangest(row: Row) -> tuple[bool, float, str]:
    away = max((abs(z) for z in (row.own_z, row.peers_z) if z is not None), default=1.0 - (row.share or 0.0))
    return (not row.unusual, -away, row.name)


def _rounded(value: float | None) -> float | None:
    return None if value is None else significant(value)


def _beside(rows: Sequence[Row], own: int, peers: int, entities: int) -> str:
    if not own and not peers:
        return "; no past and no peers to compare it with"
    with_whom = " and ".join(
        part
        for part in (
            f"its own {counted(own, 'earlier event')}" if own else "",
            f"{counted(peers, 'event')} of {counted(entities, 'peer')}" if peers else "",
        )
        if part
    )
    odd = [row for row in rows if row.unusual]
    if not rows:
        return f"; nothing in it can be compared with {with_whom}"
    if not odd:
        return f"; nothing unusual in it, compared with {with_whom}"
    return f"; unusual is {' and '.join(_row_said(row) for row in odd[:2])}, compared with {with_whom}"


def _row_said(row: Row) -> str:
    said = f"{bare(row.name)} {valued(row.name, row.now)}"
    if row.share is not None:
        return f"{said} (shared by {100 * row.share:.0f} % of them)"
    z, usual, whose = (
        (row.own_z, row.own_usual, "its own")
        if row.peers_z is None or abs(row.own_z or 0.0) >= abs(row.peers_z)
        else (row.peers_z, row.peers_usual, "its peers'")
    )
    since = f", shifted {span(row.shifted_s)} ago" if row.shifted_s else ""
    far = f"{z or 0.0:+.1f}" if abs(z or 0.0) < 100.0 else "over 100"
    return f"{said} ({far} robust deviations from {whose} {valued(row.name, usual)}{since})"


def _would_change(event: Event, rows: Sequence[Row], own: int, peers: int) -> tuple[str, ...]:
    name = brief(event.entity)
    usual = [(row.name, row.peers_usual if row.own_usual is None else row.own_usual) for row in rows if row.unusual]
    back = tuple(f"{bare(field)} of {name} near {valued(field, value)}" for field, value in usual if value is not None)[:2]
    few = (f"more events of {name} (now {own})",) if own < 6 else ()
    alone = (f"{event.kind.replace('_', ' ')} events of peers (now {peers})",) if peers < 6 else ()
    sized = [bare(row.name) for row in rows if number(event.fields[row.name]) is not None][:2]
    return (*back, *few, *alone) or (f"an event of {name} that is unusual in its {' or '.join(sized) or 'attributes'}",)
