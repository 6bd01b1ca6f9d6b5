"""What the world will show: the prior and what a treatment found, pooled with declared weights.

Each voice is a set of probabilities over the domain's outcome labels that weighs as much as so many cases; the pool is their
weighted mean: the posterior mean of a Dirichlet distribution, a linear opinion pool (Genest and Zidek 1986).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from wakeful.contracts.treatment import Mind
from wakeful.facts.asking import Episode
from wakeful.facts.decisions import Mode
from wakeful.facts.domain import DomainSpec, FieldSpec
from wakeful.facts.events import Event
from wakeful.facts.results import Forecast
from wakeful.facts.time import to_s
from wakeful.facts.values import Fact
from wakeful.treatments.measures import number, significant
from wakeful.treatments.overlap import NO_MEANINGS, Meanings, worth
from wakeful.treatments.wording import percent

#: How many cases the prior weighs. In auto mode the result head has already learned from the episodes that are recalled,
#: so they may move it only a little; a reasoner's or a guideline's prior has seen none of them.
PRIOR_CASES: dict[Mode, float] = {"auto": 20.0, "delib": 4.0, "fallback": 2.0}


#: What a case weighs that was recalled by its entity or kind alone: nobody knows how like the event it is.
UNRANKED = 0.2


#: What not knowing weighs where there is no prior: the even Dirichlet prior of one case.
UNKNOWN_CASES = 1.0

#: What a table of the domain weighs as a forecaster: it says how likely a thing is, but not that it is so within the window.
TABLE_CASES = 1.0


class Voice(Fact, frozen=True):
    """One opinion: who holds it, over which labels, and how many cases it weighs."""

    who: str
    probabilities: dict[str, float]
    cases: float


def prior_voice(mind: Mind) -> Voice | None:
    """The prior (auto: the result head; else the reasoner or guidelines), or the advice's own forecast where there is none."""
    labels = mind.domain.outcome.labels
    known = _over(labels, mind.prior)
    if not known and mind.advice is not None and mind.advice.forecast in labels:
        known = _spread(labels, mind.advice.forecast, mind.advice.forecast_probability)
    return Voice(who="prior", probabilities=known, cases=PRIOR_CASES[mind.mode]) if known else None


def recalled_voice(
    mind: Mind, event: Event, episodes: Iterable[Episode], ranked: bool = True, alike: Meanings = NO_MEANINGS
) -> Voice | None:
    """How the recalled cases ended, each weighing what it is worth; None where none has ended in a label of this domain.

    ``ranked`` cases were recalled by their likeness to the event; others by entity or kind, and weigh UNRANKED each.
    ``alike``: words that count as others by their meaning.
    """
    counts: dict[str, float] = {}
    for episode in episodes:
        if episode.outcome in mind.domain.outcome.labels:
            weight = worth(event, episode, mind.domain.fields, alike) if ranked else UNRANKED
            counts[episode.outcome] = counts.get(episode.outcome, 0.0) + weight
    total = sum(counts.values())
    if total <= 0.0:
        return None
    return Voice(who="recalled outcomes", probabilities={label: c / total for label, c in counts.items()}, cases=total)


def lately_voice(mind: Mind, event: Event, episodes: Iterable[Episode], half_life_s: float) -> Voice | None:
    """How the last events of this kind ended, each weighing half as much for every ``half_life_s`` that it is older.

    What comes is seldom drawn from the same share for long: while a part sits wrong or a battery is low, the last ones tell more
    than the likest ones.
    """
    counts: dict[str, float] = {}
    for episode in episodes:
        if episode.kind == event.kind and episode.outcome in mind.domain.outcome.labels:
            counts[episode.outcome] = counts.get(episode.outcome, 0.0) + recency(event, episode, half_life_s)
    total = sum(counts.values())
    if total <= 0.0:
        return None
    return Voice(
        who=f"the last {event.kind} events", probabilities={label: c / total for label, c in counts.items()}, cases=total
    )


def recency(event: Event, episode: Episode, half_life_s: float) -> float:
    """What is left of a case's weight by its age: half of it for every ``half_life_s``."""
    age_s = max(to_s(event.stamp.source_ns - episode.at_ns), 0.0)
    return float(0.5 ** (age_s / half_life_s))


def once(
    event: Event, like: Sequence[Episode], last: Sequence[Episode], specs: Mapping[str, FieldSpec], half_life_s: float
) -> tuple[tuple[Episode, ...], tuple[Episode, ...]]:
    """The like cases and the last ones, where what is both stays only where it weighs more: one outcome speaks once."""
    late = {episode.event: recency(event, episode, half_life_s) for episode in last if episode.kind == event.kind}
    as_like = {episode.event for episode in like if worth(event, episode, specs) > late.get(episode.event, 0.0)}
    return (
        tuple(episode for episode in like if episode.event in as_like or episode.event not in late),
        tuple(episode for episode in last if episode.event not in as_like),
    )


def model_voice(domain: DomainSpec, who: str, chances: Mapping[str, float], cases: float = TABLE_CASES) -> Voice | None:
    """What a table or model of the domain says of labels beside the first; the first (nothing happened) takes what is left."""
    labels = domain.outcome.labels
    told = {label: min(max(chances[label], 0.0), 1.0) for label in labels[1:] if label in chances}
    if not told or cases <= 0.0:
        return None
    total = sum(told.values())
    if total > 1.0:
        told = {label: share / total for label, share in told.items()}
    return Voice(who=who, probabilities={labels[0]: max(1.0 - total, 0.0), **told}, cases=cases)


def pooled(mind: Mind, event: Event, voices: Iterable[Voice | None]) -> Forecast | None:
    """The forecast that the prior and these voices give together; None where nobody says anything."""
    outcome = mind.domain.outcome
    heard = _heard(mind, voices)
    weight = sum(voice.cases for voice in heard)
    if weight <= 0.0 or not outcome.labels:
        return None
    shares = {
        label: round(sum(voice.cases * voice.probabilities.get(label, 0.0) for voice in heard) / weight, 6)
        for label in outcome.labels
    }
    # equal shares go to the label that stands first in the domain
    label = max(outcome.labels, key=lambda each: shares[each])
    return Forecast(
        label=label,
        probability=shares[label],
        probabilities=shares,
        topic=outcome.topic,
        entity=event.entity if outcome.scope == "entity" else "*",
    )


def forecast_reasons(mind: Mind, voices: Iterable[Voice | None]) -> tuple[str, ...]:
    """Whose opinion the forecast rests on, and how much each weighs."""
    heard = _heard(mind, voices)
    return tuple(f"forecast: {voice.who}, weighing {significant(voice.cases, 3):g} cases" for voice in heard)


def expectation(forecast: Forecast | None) -> str:
    """The forecast as the end of a sentence, or nothing.

    >>> expectation(Forecast(label="none", probability=0.93))
    '; expect none (93 %)'
    """
    return "" if forecast is None else f"; expect {forecast.label} ({percent(forecast.probability)})"


def _heard(mind: Mind, voices: Iterable[Voice | None]) -> list[Voice]:
    """Who speaks. Where the prior is silent, one case's worth of not knowing keeps a few cases from certainty."""
    prior = prior_voice(mind)
    others = [voice for voice in voices if voice is not None and voice.cases > 0.0]
    if prior is not None or not others:
        return [*([prior] if prior is not None else []), *others]
    labels = mind.domain.outcome.labels
    evenly = {label: 1.0 / len(labels) for label in labels}
    return [Voice(who="not knowing", probabilities=evenly, cases=UNKNOWN_CASES), *others]


def _over(labels: tuple[str, ...], prior: Mapping[str, float]) -> dict[str, float]:
    known = {label: max(number(prior.get(label)) or 0.0, 0.0) for label in labels if label in prior}
    total = sum(known.values())
    return {label: share / total for label, share in known.items()} if total > 0.0 else {}


def _spread(labels: tuple[str, ...], label: str, probability: float) -> dict[str, float]:
    share = min(max(number(probability) or 0.0, 0.0), 1.0)
    others = [other for other in labels if other != label]
    if not others:
        return {label: 1.0}
    return {label: share, **{other: (1.0 - share) / len(others) for other in others}}
