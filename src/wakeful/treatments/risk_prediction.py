"""Risk prediction: which hazards this event opens, how likely harm is by what has happened, and how long there is."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from msgspec import convert, to_builtins

from wakeful.contracts.treatment import Mind, Refusal
from wakeful.facts.asking import Episode
from wakeful.facts.events import Event
from wakeful.facts.results import Proposal, Result
from wakeful.facts.time import to_ns
from wakeful.facts.values import Fact
from wakeful.treatments.consulting import Consultation, consult
from wakeful.treatments.decorator import treatment
from wakeful.treatments.forecasting import (
    Voice,
    expectation,
    forecast_reasons,
    lately_voice,
    model_voice,
    once,
    pooled,
    recalled_voice,
)
from wakeful.treatments.hazards import RATINGS, HazardRow, assess, shows_as, worst
from wakeful.treatments.kinematics import Countdown, countdown, to_limit
from wakeful.treatments.measures import number
from wakeful.treatments.remembering import of_kind, resting, similar
from wakeful.treatments.rollout import Body, Rollout, tip_over
from wakeful.treatments.sureness import NOTHING_TO_GO_ON, sentence, sure
from wakeful.treatments.waiting import Askable, askable, patience_s, reading
from wakeful.treatments.wording import counted, figure, percent, span, subject


class RiskSettings(Fact, frozen=True):
    """What is assumed where nothing is known, and when a person is asked to act."""

    table_cases: float = 4.0
    """How many cases a likelihood of the hazard table weighs."""
    mass: float = 0.9
    """The probability that a credible interval holds."""
    cases: int = 10
    cases_deliberating: int = 20
    propose_from: str = "serious"
    reasoner_cases: float = 2.0
    """How many cases a reasoner's likelihood of a hazard weighs, once its answer has passed the check."""
    rollout_s: float = 0.0
    """How far ahead a body (``width_m``, ``height_m``, ``tilt_deg``) is rolled out, deliberating (extra ``physics``); 0: not."""
    lately: int = 24
    """So many of the last events of the kind are asked how they ended; 0: none."""
    lately_windows: float = 40.0
    """In so many outcome windows such an event comes to weigh half as much."""
    wait_periods: float = 2.0
    """How many periods of an evidence source to wait for its next reading."""


class Judged(Fact, frozen=True):
    """A reasoner's judgement: a hazard of the table, and how likely it is to come true."""

    hazard: str
    likelihood: float


class RiskPrediction(Result, frozen=True, kw_only=True, tag="risk_prediction"):
    """The hazard table for this event, and the time to consequence."""

    hazards: tuple[HazardRow, ...] = ()
    consequence: Countdown | None = None
    rollout: Rollout | None = None
    halves: str = ""
    """Which evidence would halve the interval of the worst row."""
    asked: tuple[str, ...] = ()
    heard: tuple[str, ...] = ()


@treatment(
    "risk_prediction",
    result=RiskPrediction,
    says="Predicts what harm may follow, how likely and how soon; for what is unstable, near, fast or trending to a limit.",
)
async def risk_prediction(event: Event, mind: Mind) -> RiskPrediction:
    """Assess the hazards that the event opens, by the table and by how like cases ended."""
    return await assess_risk(event, mind, RiskSettings())


async def assess_risk(event: Event, mind: Mind, settings: RiskSettings) -> RiskPrediction:
    """The thinking of ``risk_prediction`` with settings of one's own.

    Source: ISO 12100 (severity, exposure and likelihood estimated apart), MIL-STD-882E tables I to III (classes and matrix).
    """
    await mind.work(2)
    past = await similar(event, mind, settings.cases_deliberating if mind.mode == "delib" else settings.cases)
    last = (await of_kind(event, mind, event.kind, settings.lately)).episodes if settings.lately else ()
    ahead = countdown(event.fields)
    asked: list[str] = []
    heard: list[str] = []
    if mind.mode == "delib":
        for offer in _of_its_own(event, askable(mind.domain, event)):
            limit_s = min(patience_s(event, mind, offer), settings.wait_periods * offer.every_s)
            if limit_s > 0.0:
                asked.append(offer.address)
                ahead = await _hear(event, mind, offer, limit_s, ahead, heard)
                await mind.work(1)

    rolled = await _roll(event, mind, settings)
    if rolled is not None and rolled.falls_in_s is not None:
        ahead = Countdown(what="it falls over", in_s=rolled.falls_in_s, because=f"rolled out over {rolled.seconds:g} s")
    rows = assess(event, mind.domain, past, settings.table_cases, settings.mass)
    top = worst(rows)
    # the table's own likelihoods: the rows have taken in the like cases, which have a voice of their own
    open_now = {row.hazard for row in rows if row.listed}
    told = {
        label: hazard.likelihood
        for hazard in mind.domain.hazard
        for label in shows_as(hazard, mind.domain)
        if hazard.name in open_now and len(shows_as(hazard, mind.domain)) == 1
    }
    judged = await _judgement(event, mind, past)
    half_life_s = settings.lately_windows * mind.domain.outcome.within_s
    like, late = once(event, past, last, mind.domain.fields, half_life_s)
    voices = [
        recalled_voice(mind, event, like),
        lately_voice(mind, event, late, half_life_s),
        model_voice(mind.domain, "hazard table", told),
        _reasoned(mind, judged, settings),
    ]
    forecast = pooled(mind, event, voices)
    halves = _halves(top, askable(mind.domain, event))
    # sure of a risk is who has a narrow interval, whatever its middle
    confidence = NOTHING_TO_GO_ON if top is None else 1.0 - (top.high - top.low)
    return RiskPrediction(
        says=sentence(mind, subject(event), _risk(rows, settings.mass), _time(ahead, heard), expectation(forecast)),
        confidence=sure(mind, confidence),
        rests_on=(
            f"event {event.id}",
            *(f"hazard table: {row.hazard}" for row in rows if row.listed),
            *resting(case for case in past if case.outcome),
            *heard,
            *forecast_reasons(mind, voices),
            *judged.basis,
        ),
        would_change=(halves, *_unseen(past)),
        forecast=forecast,
        proposes=_proposals(event, mind, top, ahead, settings),
        consulted=judged.consulted,
        hazards=rows,
        consequence=ahead,
        halves=halves,
        rollout=rolled,
        asked=tuple(asked),
        heard=tuple(heard),
    )


async def _roll(event: Event, mind: Mind, settings: RiskSettings) -> Rollout | None:
    """What a physics engine says of the next seconds, where the event has a body."""
    known = {name: number(event.fields.get(name)) for name in ("width_m", "height_m", "mass_kg", "tilt_deg", "tilt_rate_dps")}
    told = {name: value for name, value in known.items() if value is not None}
    if mind.mode != "delib" or settings.rollout_s <= 0.0 or not {"width_m", "height_m", "tilt_deg"} <= told.keys():
        return None
    body = Body(**told)
    try:
        answer = await mind.call(partial(_plainly, body, settings.rollout_s), "rollout", settings.rollout_s + 5.0)
    except Refusal:
        return None
    return convert(answer, Rollout)


def _plainly(body: Body, seconds: float) -> object:
    return to_builtins(tip_over(body, seconds))


async def _judgement(event: Event, mind: Mind, past: Sequence[Episode]) -> Consultation[Judged]:
    """Which hazard a reasoner sees, and how likely: one of the table that shows itself as an outcome."""
    shown = {hazard.name: shows_as(hazard, mind.domain) for hazard in mind.domain.hazard}

    def objection(judged: Judged) -> str:
        if judged.hazard not in shown:
            return f"there is no hazard {judged.hazard[:60]!r} in the table"
        return "" if 0.0 <= judged.likelihood <= 1.0 else f"a likelihood of {judged.likelihood} lies outside [0, 1]"

    if not shown:
        return Consultation()
    asks = "Which of these hazards is most likely to come true within the window, and how likely is it, from 0 to 1?"
    return await consult(event, mind, "risk_prediction", asks, Judged, objection, past, shown)


def _reasoned(mind: Mind, judged: Consultation[Judged], settings: RiskSettings) -> Voice | None:
    if judged.answer is None:
        return None
    hazard = next(each for each in mind.domain.hazard if each.name == judged.answer.hazard)
    labels = shows_as(hazard, mind.domain)
    chances = {label: judged.answer.likelihood / len(labels) for label in labels}
    return model_voice(mind.domain, "reasoner on risk", chances, settings.reasoner_cases)


def _of_its_own(event: Event, offers: Sequence[Askable]) -> Sequence[Askable]:
    """Readings of the very channel that the event is about: only these continue its value."""
    return [offer for offer in offers if offer.channel and offer.channel in (event.fields.get("channel"), event.entity)][:1]


async def _hear(
    event: Event, mind: Mind, offer: Askable, limit_s: float, ahead: Countdown | None, heard: list[str]
) -> Countdown | None:
    """Wait for another reading; with the event's own value it gives a slope, and so a time to the limit."""
    for evidence in await mind.evidence(offer.topic, offer.key, limit_s):
        fresh = number(reading(evidence))
        before = number(event.fields.get("value"))
        gap_s = (evidence.at_ns - event.stamp.source_ns) / 1e9
        if fresh is None:
            continue
        heard.append(
            f"evidence {offer.address}: {figure(fresh)}, {span(abs(gap_s))} {'after' if gap_s >= 0.0 else 'before'} the event"
        )
        if before is not None and gap_s != 0.0:
            # a reading that was kept from before the event gives a slope as well
            ahead = to_limit(fresh if gap_s > 0.0 else before, (fresh - before) / gap_s, event.fields) or ahead
    return ahead


def _risk(rows: Sequence[HazardRow], mass: float) -> str:
    top = worst(rows)
    if top is None:
        return "; no hazard of the table is open, and nothing like it has ended yet: its risk is unknown"
    unlisted = [row for row in rows if not row.listed]
    told = ""
    if top.listed:
        name = top.hazard.replace("_", " ")
        told = f"; {top.rating} risk ({name}): {_likely(top, mass)}, severity class {top.severity} of 4"
    if unlisted:
        first = max(unlisted, key=lambda row: row.likelihood)
        lead = "" if top.listed else "no hazard of the table is open; "
        told += f"; {lead}{first.hazard.replace('_', ' ')} may follow: {_likely(first, mass)}"
    return told


def _likely(row: HazardRow, mass: float) -> str:
    """A table's prior is never told as a finding: its interval says only how little is known."""
    if not row.cases:
        return f"{percent(row.likelihood)} by the hazard table alone, no like case has ended yet"
    by = "the hazard table and how like cases ended" if row.listed else "how like cases ended"
    return f"{percent(row.likelihood)} by {by} ({percent(mass)} credible {percent(row.low)} to {percent(row.high)})"


def _time(ahead: Countdown | None, heard: Sequence[str]) -> str:
    if ahead is None:
        return ""
    return f"; {ahead.what} in {span(ahead.in_s)} ({ahead.because}{', by another reading' if heard else ''})"


def _halves(top: HazardRow | None, offers: Sequence[Askable]) -> str:
    reading_of = f", or a reading of {offers[0].address}" if offers else ""
    if top is None:
        return f"the outcome of one like case{reading_of}"
    return f"the outcomes of about {top.cases_to_halve} more like cases would halve the interval{reading_of}"


def _unseen(past: Sequence[Episode]) -> tuple[str, ...]:
    waiting = sum(1 for case in past if not case.outcome)
    return (f"the end of {counted(waiting, 'like case')}, not seen yet",) if waiting else ()


def _proposals(
    event: Event, mind: Mind, top: HazardRow | None, ahead: Countdown | None, settings: RiskSettings
) -> tuple[Proposal, ...]:
    if top is None or not top.control or RATINGS.index(top.rating) < RATINGS.index(settings.propose_from):
        return ()
    window_s = mind.domain.outcome.within_s
    # measured from the event, not from now: a rebuilt process must propose the same
    lasts_s = window_s if ahead is None else min(ahead.in_s, window_s)
    return (
        Proposal(
            effect=top.control,
            preconditions=(f"{top.hazard} still possible at {event.entity}", "no person is put at risk by it"),
            authority="supervisor" if lasts_s < window_s else "operator",
            valid_until_ns=event.stamp.received_ns + to_ns(max(lasts_s, 0.0)),
        ),
    )
