"""Analogy: the nearest known cases, what of them transfers, a provisional treatment, and the risk that it is wrong."""

from __future__ import annotations

from collections.abc import Sequence

from wakeful.contracts.treatment import Mind
from wakeful.facts.asking import Episode
from wakeful.facts.events import Event
from wakeful.facts.results import Result
from wakeful.facts.values import Fact
from wakeful.treatments.beta import Belief
from wakeful.treatments.consulting import consult
from wakeful.treatments.decorator import treatment
from wakeful.treatments.forecasting import expectation, forecast_reasons, pooled, recalled_voice
from wakeful.treatments.meaning import installed
from wakeful.treatments.measures import number, significant
from wakeful.treatments.overlap import Meanings, Overlap, overlap, worth
from wakeful.treatments.remembering import resting, similar
from wakeful.treatments.sureness import NOTHING_TO_GO_ON, sentence, sure
from wakeful.treatments.unmet_words import Meant, meanings, meant
from wakeful.treatments.wording import bare, brief, counted, percent, subject


class AnalogySettings(Fact, frozen=True):
    """How many cases, how near one must be to carry an analogy, and what is believed of analogies before any has ended."""

    cases: int = 6
    cases_deliberating: int = 10
    near: float = 0.2
    """The least worth (overlap.worth) of a case that something is transferred from."""
    wrong_before: float = 0.3
    before_cases: float = 2.0
    mass: float = 0.9
    meaning: bool = True
    """Whether words that were never met are compared with known ones by their meaning, outside auto mode (extra ``analogy``)."""
    looked_at: int = 24
    """How many cases are recalled when deliberating, of which the best are kept."""


class Case(Fact, frozen=True):
    """One known case beside the event. ``worth`` is how much it counts, in [0, 1]."""

    event: str
    entity: str
    kind: str
    worth: float
    likeness: float
    overlap: Overlap
    treatment: str
    says: str = ""
    outcome: str = ""
    verdict: str = ""


class Likest(Fact, frozen=True):
    """A reasoner's analogy: the case that this is most like in what matters."""

    case: str


class Analogy(Result, frozen=True, kw_only=True, tag="analogy"):
    """The nearest cases, what transfers, and how far to trust it."""

    cases: tuple[Case, ...] = ()
    transfers: tuple[str, ...] = ()
    does_not_transfer: tuple[str, ...] = ()
    treat_as: str = ""
    """The treatment that served the nearest cases best; provisional."""
    wrong: float = 1.0
    """How likely the forecast of that treatment is contradicted, by the near cases that it treated: whether a forecast held
    stands in for whether the treatment was right, which nobody tells."""
    wrong_low: float = 0.0
    wrong_high: float = 1.0
    meanings: tuple[Meant, ...] = ()
    """Words that were never met, and the known ones that they count as."""


@treatment(
    "analogy",
    result=Analogy,
    says="Treats something unfamiliar like the nearest known cases, and says what transfers and how often that was wrong.",
)
async def analogy(event: Event, mind: Mind) -> Analogy:
    """Find the nearest known cases and what they are worth here."""
    return await liken(event, mind, AnalogySettings())


async def liken(event: Event, mind: Mind, settings: AnalogySettings) -> Analogy:
    """The thinking of ``analogy`` with settings of one's own.

    Source: case-based reasoning, retrieve and reuse (Aamodt and Plaza 1994); a cheap search for many and a comparison of
    structure for few (Forbus, Gentner and Law 1995); overlap after Gower 1971; meaning by sentence embedding (Yang et al. 2020).
    """
    await mind.work(1)
    kept = settings.cases_deliberating if mind.mode == "delib" else settings.cases
    # many are looked at and few are kept: the search weighs all features, what is like in structure is told by comparing
    found = await similar(event, mind, max(settings.looked_at, kept) if mind.mode == "delib" else kept)
    by_meaning = settings.meaning and mind.mode != "auto" and installed()
    new = await meant(event, found, mind) if by_meaning else ()
    await mind.work(1)
    alike = meanings(new)
    every = (_case(event, mind, episode, alike) for episode in found)
    cases = tuple(sorted(every, key=lambda case: (-case.worth, case.event))[:kept])
    near = [case for case in cases if case.worth >= settings.near]
    known = {case.event for case in near}
    said = await consult(
        event,
        mind,
        "analogy",
        "Which of these known cases, by its id, is this event most like in what matters for how it should be treated?",
        Likest,
        lambda likest: "" if likest.case in known else f"case {likest.case[:60]!r} is not among those near enough",
        found,
        sorted(known),
    )
    if said.answer is not None:
        likest = said.answer.case
        near.sort(key=lambda case: case.event != likest)
    treat_as = _serves(near)
    judged = [case for case in near if case.treatment == treat_as and case.verdict in ("supported", "contradicted")]
    belief = _wrong(judged, settings)
    low, high = belief.interval(settings.mass)
    # where no case of that treatment was judged, the risk is taken for as high as it may be
    risk = belief.mean if judged else high
    nearest = near[0] if near else None
    by_event = {episode.event: episode for episode in found}
    voice = recalled_voice(mind, event, (by_event[case.event] for case in near), alike=alike)
    forecast = pooled(mind, event, [voice])
    return Analogy(
        says=sentence(
            mind,
            subject(event),
            _nearest(nearest, cases),
            _treat(treat_as, belief.mean, low, high, len(judged)),
            expectation(forecast),
        ),
        confidence=sure(mind, NOTHING_TO_GO_ON if nearest is None else nearest.worth * (1.0 - risk)),
        rests_on=(
            f"event {event.id}",
            *resting(by_event[case.event] for case in near),
            *(f"meaning of {each.word!r}: nearest {', '.join(list(each.counts)[:3])}" for each in new),
            *forecast_reasons(mind, [voice]),
            *said.basis,
        ),
        would_change=_would_change(near, nearest),
        forecast=forecast,
        consulted=said.consulted,
        cases=cases,
        transfers=() if nearest is None else nearest.overlap.shared,
        does_not_transfer=() if nearest is None else (*nearest.overlap.differing, *nearest.overlap.lacking),
        treat_as=treat_as,
        wrong=significant(belief.mean),
        wrong_low=low,
        wrong_high=high,
        meanings=new,
    )


def _case(event: Event, mind: Mind, episode: Episode, alike: Meanings) -> Case:
    shared = overlap(event.fields, episode.fields, mind.domain.fields, alike)
    return Case(
        event=episode.event,
        entity=brief(episode.entity),
        kind=episode.kind,
        worth=worth(event, episode, mind.domain.fields, alike),
        likeness=significant(min(max(number(episode.likeness) or 0.0, 0.0), 1.0)),
        overlap=shared,
        treatment=episode.treatment,
        says=brief(episode.says, 160),
        outcome=episode.outcome,
        verdict=episode.verdict,
    )


def _serves(near: Sequence[Case]) -> str:
    """The treatment with the most worth behind it: supported cases count whole, open ones half, contradicted ones against it."""
    scores: dict[str, float] = {}
    for case in near:
        if case.treatment and case.treatment != "analogy":
            weight = {"supported": 1.0, "contradicted": -0.5}.get(case.verdict, 0.5)
            scores[case.treatment] = scores.get(case.treatment, 0.0) + weight * case.worth
    best = max(scores, key=lambda name: (scores[name], name), default="")
    return best if scores.get(best, 0.0) > 0.0 else ""


def _wrong(judged: Sequence[Case], settings: AnalogySettings) -> Belief:
    contradicted = sum(case.worth for case in judged if case.verdict == "contradicted")
    supported = sum(case.worth for case in judged if case.verdict == "supported")
    return Belief.of(settings.wrong_before, settings.before_cases).after(contradicted, supported)


def _nearest(nearest: Case | None, cases: Sequence[Case]) -> str:
    if nearest is None:
        far = f"; the nearest of {len(cases)} is worth {cases[0].worth:.2g} of 1" if cases else ""
        return f"; like nothing known{far}"
    shared = ", ".join(bare(name) for name in nearest.overlap.shared[:3]) or "no attribute"
    unlike = [*nearest.overlap.differing, *nearest.overlap.lacking]
    but = f", but not {', '.join(bare(name) for name in unlike[:3])}" if unlike else ""
    ended = f", which ended in {nearest.outcome}" if nearest.outcome else ""
    return f"; most like {nearest.entity} ({nearest.kind.replace('_', ' ')}{ended}): it shares {shared}{but}"


def _treat(treat_as: str, wrong: float, low: float, high: float, ended: int) -> str:
    if not treat_as:
        return "; no treatment is proven on such cases"
    rested = f"from {counted(ended, 'judged case')} of it" if ended else "no case of it has been judged yet"
    return f"; treat provisionally by {treat_as}, wrong with {percent(wrong)} ({percent(low)} to {percent(high)}, {rested})"


def _would_change(near: Sequence[Case], nearest: Case | None) -> tuple[str, ...]:
    if nearest is None:
        return ("a known case that shares this event's attributes",)
    open_cases = sum(1 for case in near if not case.outcome)
    unlike = (*nearest.overlap.differing, *nearest.overlap.lacking)
    bears = tuple(f"whether {bare(name)} bears on how it ends" for name in unlike[:3])
    waits = (f"how {open_cases} of the near cases end",) if open_cases else ()
    return (*bears, *waits, "the outcome of this event itself")
