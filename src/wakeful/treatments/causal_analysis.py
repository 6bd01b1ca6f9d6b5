"""Causal analysis: which earlier events could have brought this about, ranked, and the question that would decide it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import prod

from wakeful.contracts.treatment import Mind
from wakeful.facts.asking import Episode
from wakeful.facts.events import Event
from wakeful.facts.results import Result
from wakeful.facts.values import Fact
from wakeful.treatments.causal_effect import Effect, effect_of
from wakeful.treatments.causal_graph import Arrow, arrows_of, chains, out_of
from wakeful.treatments.consulting import consult
from wakeful.treatments.decorator import treatment
from wakeful.treatments.forecasting import expectation, forecast_reasons, model_voice, pooled, recalled_voice
from wakeful.treatments.measures import significant
from wakeful.treatments.remembering import NAMED, NOTHING_RECALLED, Recalled, age_s, of_kind
from wakeful.treatments.sureness import NOTHING_TO_GO_ON, sentence, sure
from wakeful.treatments.wording import brief, percent, span, subject


class CausalSettings(Fact, frozen=True):
    """How far back along the arrows it looks, and how many cases make an effect more than an assumption."""

    depth: int = 1
    depth_deliberating: int = 3
    kinds: int = 4
    kinds_deliberating: int = 12
    episodes: int = 12
    least_cases: int = 3
    arrow_cases: float = 4.0
    """How many cases an arrow's written strength weighs against what was seen."""


class Candidate(Fact, frozen=True):
    """An earlier event that could have brought this about, by a chain of arrows (cause first)."""

    event: str
    kind: str
    entity: str
    before_s: float
    score: float
    fit: float
    chain: tuple[str, ...]
    effect: Effect
    because: str = ""


class Blamed(Fact, frozen=True):
    """A reasoner's pick: the earlier event that most likely brought this about."""

    event: str


class CausalAnalysis(Result, frozen=True, kw_only=True, tag="causal_analysis"):
    """The causes, the likeliest first, and what would decide between them."""

    candidates: tuple[Candidate, ...] = ()
    other: float = 1.0
    """Share of what none of the candidates explains."""
    question: str = ""
    looked_for: tuple[str, ...] = ()
    leads_to: dict[str, float] = {}
    """What the arrows out of this event say may follow, with their strengths."""


@treatment(
    "causal_analysis",
    result=CausalAnalysis,
    says="Ranks the earlier events that could have brought this about, and asks the question that would decide it.",
)
async def causal_analysis(event: Event, mind: Mind) -> CausalAnalysis:
    """Follow the domain's causal arrows back to events that were seen in time."""
    return await trace(event, mind, CausalSettings())


async def trace(event: Event, mind: Mind, settings: CausalSettings) -> CausalAnalysis:
    """The thinking of ``causal_analysis`` with settings of one's own."""
    await mind.work(1)
    deep = mind.mode == "delib"
    arrows = arrows_of(mind.domain)
    ways = list(chains(arrows, event.kind, settings.depth_deliberating if deep else settings.depth))
    wanted = list(dict.fromkeys(way[-1].cause for way in ways))[: settings.kinds_deliberating if deep else settings.kinds]
    seen: dict[str, Recalled] = {}
    for kind in wanted:
        seen[kind] = await of_kind(event, mind, kind, settings.episodes)
    effects = await of_kind(event, mind, event.kind, settings.episodes) if wanted else NOTHING_RECALLED
    await mind.work(2 if deep else 1)

    found = [
        _candidate(event, way, episode, arrows, seen, effects, settings) for way in ways for episode in _in_time(event, way, seen)
    ]
    best: dict[str, Candidate] = {}
    for candidate in sorted(found, key=lambda each: (-each.score, each.before_s, each.event)):
        best.setdefault(candidate.event, candidate)
    said = await consult(
        event,
        mind,
        "causal_analysis",
        "Which of these earlier events, by its id, most likely brought this one about?",
        Blamed,
        lambda blamed: "" if blamed.event in best else f"{blamed.event[:60]!r} is no event that came before it in time",
        [episode for kind in wanted for episode in seen[kind].episodes if episode.event in best],
        best,
    )
    blamed = said.answer.event if said.answer is not None else ""
    candidates = tuple(sorted(best.values(), key=lambda each: each.event != blamed)) if blamed else tuple(best.values())
    other = prod(1.0 - candidate.score for candidate in candidates)
    leads = {arrow.effect: significant(arrow.strength) for arrow in reversed(out_of(arrows, event.kind))}
    voices = [
        recalled_voice(mind, event, effects.episodes, ranked=False),
        model_voice(mind.domain, "causal graph", leads),
    ]
    forecast = pooled(mind, event, voices)
    question = _question(event, candidates, wanted)
    return CausalAnalysis(
        says=sentence(mind, subject(event), _brought_about(candidates, other, wanted, mind), expectation(forecast)),
        confidence=sure(mind, 1.0 - other if candidates else NOTHING_TO_GO_ON),
        rests_on=(
            f"event {event.id}",
            *dict.fromkeys(f"causal graph: {' → '.join(candidate.chain)}" for candidate in candidates),
            *(f"event {candidate.event}" for candidate in candidates[:NAMED]),
            *forecast_reasons(mind, voices),
            *said.basis,
        ),
        would_change=(question, *(f"an earlier {kind.replace('_', ' ')}" for kind in wanted if not seen[kind].episodes)),
        forecast=forecast,
        consulted=said.consulted,
        candidates=candidates,
        other=significant(other),
        question=question,
        looked_for=tuple(wanted),
        leads_to=leads,
    )


def _in_time(event: Event, way: tuple[Arrow, ...], seen: Mapping[str, Recalled]) -> list[Episode]:
    window_s = sum(arrow.within_s for arrow in way)
    earlier = seen.get(way[-1].cause, NOTHING_RECALLED).episodes
    return [episode for episode in earlier if 0.0 < age_s(event, episode) <= window_s]


def _candidate(
    event: Event,
    way: tuple[Arrow, ...],
    episode: Episode,
    arrows: Sequence[Arrow],
    seen: Mapping[str, Recalled],
    effects: Recalled,
    settings: CausalSettings,
) -> Candidate:
    before_s = age_s(event, episode)
    window_s = sum(arrow.within_s for arrow in way)
    # whole at once, half at the end of the window: later is possible, but another cause had as much time
    fit = 1.0 - 0.5 * before_s / window_s
    here = 1.0 if episode.entity == event.entity else 0.8
    strengths = [effect_of(event, arrow, arrows, seen, effects, settings.arrow_cases, settings.least_cases) for arrow in way]
    return Candidate(
        event=episode.event,
        kind=episode.kind,
        entity=brief(episode.entity),
        before_s=before_s,
        score=significant(prod(effect.strength for effect in strengths) * fit * here),
        fit=significant(fit),
        chain=(*(arrow.cause for arrow in reversed(way)), event.kind),
        effect=strengths[-1],
        because="; ".join(arrow.because for arrow in reversed(way) if arrow.because),
    )


def _brought_about(candidates: Sequence[Candidate], other: float, wanted: Sequence[str], mind: Mind) -> str:
    if not mind.domain.cause:
        return f": its cause is unidentified, because domain {mind.domain.name} has no causal graph"
    if not wanted:
        return ": no arrow of the causal graph leads to it; its cause is unidentified"
    if not candidates:
        kinds = ", ".join(kind.replace("_", " ") for kind in wanted[:3])
        return f": none of its known causes ({kinds}) was seen in time before it"
    top = candidates[0]
    how = f"most likely brought about by {top.kind.replace('_', ' ')} of {top.entity} {span(top.before_s)} before"
    seen = f"followed in {top.effect.followed} of {top.effect.cases} earlier cases" if top.effect.cases else "written strength"
    need = ""
    if top.effect.necessity is not None:
        spared = f"with {percent(top.effect.necessity)} it would not have come without it"
        need = f"; {spared if top.effect.necessity >= 0.01 else 'it comes as often without it'}"
    doubt = "" if top.effect.identified else "; its effect is unidentified"
    return f": {how} (score {top.score:.2g}, {seen}{need}{doubt}); {percent(other)} is left unexplained"


def _question(event: Event, candidates: Sequence[Candidate], wanted: Sequence[str]) -> str:
    effect = event.kind.replace("_", " ")
    if candidates:
        top = candidates[0]
        cause = top.kind.replace("_", " ")
        return f"would the {effect} have come without the {cause} {span(top.before_s)} before: does a {effect} occur without one?"
    if wanted:
        return f"was there a {wanted[0].replace('_', ' ')} that was not registered before the {effect}?"
    return f"which earlier event does the {effect} always follow?"
