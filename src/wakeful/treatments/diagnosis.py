"""Diagnosis: which fault explains the symptoms, which check would tell most, and what to do. Waits for that evidence."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from msgspec.structs import replace

from wakeful.contracts.treatment import Mind, Refusal
from wakeful.facts.asking import Episode
from wakeful.facts.domain import Fault
from wakeful.facts.events import Event
from wakeful.facts.results import Proposal, Result
from wakeful.facts.time import to_ns
from wakeful.facts.values import Fact
from wakeful.treatments.checking import Check, most_telling, take_in
from wakeful.treatments.consulting import Consultation, consult
from wakeful.treatments.decorator import treatment
from wakeful.treatments.forecasting import Voice, expectation, forecast_reasons, model_voice, pooled, recalled_voice
from wakeful.treatments.measures import significant
from wakeful.treatments.minimal_diagnoses import MinimalDiagnosis, minimal_diagnoses
from wakeful.treatments.noisy_or import Network
from wakeful.treatments.one_fault import network_of
from wakeful.treatments.planning import planning
from wakeful.treatments.remembering import age_s, of_robot, resting, similar
from wakeful.treatments.routes import graph_of, trip_of
from wakeful.treatments.sureness import NOTHING_TO_GO_ON, sentence, sure
from wakeful.treatments.symptoms import findings, seen_in, told
from wakeful.treatments.waiting import askable, patience_s
from wakeful.treatments.wording import percent, subject

#: A suspect less likely than this stands in the result, not in its sentence.
WORTH_NAMING = 0.02


class DiagnosisSettings(Fact, frozen=True):
    """When a fault counts as found, when looking on is worth nothing, and which earlier events still are symptoms."""

    threshold: float = 0.9
    least_gain_bits: float = 0.01
    rounds: int = 3
    leak: float = 0.02
    """Probability that a symptom appears without any fault of the table."""
    recent_windows: float = 1.0
    """Other events of the robot within so many outcome windows of this one count as symptoms of the same fault."""
    episodes: int = 12
    cases: int = 8
    minimal: int = 0
    """So many minimal diagnoses are listed: sets of faults that together explain every sign (the extra ``diagnosis``)."""
    reasoner_odds: float = 3.0
    """By how much the odds of the fault that a reasoner names are raised, once its answer has passed the check."""


class Suspect(Fact, frozen=True):
    """One fault, with its posterior, what speaks for and against it, its check and its remedy."""

    fault: str
    posterior: float
    prior: float
    explains: bool = False
    """Whether it causes a sign of the event itself, not only of others near it."""
    shown: tuple[str, ...] = ()
    missing: tuple[str, ...] = ()
    check: str = ""
    remedy: str = ""


class Suspected(Fact, frozen=True):
    """A reasoner's suspicion: a fault of the table."""

    fault: str


class Diagnosis(Result, frozen=True, kw_only=True, tag="diagnosis"):
    """The suspects, those that explain the event itself first, then by posterior, and the check that would tell most."""

    suspects: tuple[Suspect, ...] = ()
    unexplained: float = 1.0
    """Probability that none of the table's faults is present."""
    findings: dict[str, bool] = {}
    next_check: Check | None = None
    asked: tuple[str, ...] = ()
    heard: tuple[str, ...] = ()
    settled: bool = False
    minimal: tuple[MinimalDiagnosis, ...] = ()
    way_round: str = ""
    """What planning, as a child process, found: the faulty thing stands in the way."""


@treatment(
    "diagnosis",
    result=Diagnosis,
    says="Finds the fault behind abnormal signs of a device, names the most telling check, and waits for its answer.",
)
async def diagnosis(event: Event, mind: Mind) -> Diagnosis:
    """Infer the faults from what is seen, and look for what would tell most."""
    return await diagnose(event, mind, DiagnosisSettings())


async def diagnose(event: Event, mind: Mind, settings: DiagnosisSettings) -> Diagnosis:
    """The thinking of ``diagnosis`` with settings of one's own.

    Source: noisy-OR network (Pearl 1988), exact posterior (Heckerman 1989), next check by expected information gain (de Kleer
    and Williams 1987). It stops when a fault passes the threshold, or nothing more can be asked that would tell enough.
    """
    await mind.work(2)
    network = network_of(mind.domain, settings.leak)
    recent = await _recent(event, mind, settings)
    known = findings(mind.domain.fault, event, recent)
    past = await similar(event, mind, settings.cases)

    asked: list[str] = []
    heard: list[str] = []
    offers = askable(mind.domain, event)
    while mind.mode == "delib" and len(asked) < settings.rounds and _open(event, network, known, settings):
        check, offer = most_telling(network, known, offers, asked, settings.least_gain_bits)
        limit_s = patience_s(event, mind, offer) if offer is not None else 0.0
        if check is None or offer is None or limit_s <= 0.0:
            break
        asked.append(check.symptom)
        arrived = await mind.evidence(offer.topic, offer.key, limit_s)
        for evidence in arrived:
            take_in(network, offer, evidence, known, heard)
        if not arrived:  # a source that was silent once is not waited for again
            offers = tuple(each for each in offers if each.address != offer.address)
        await mind.work(1)
        # while it waited the robot may have shown more
        recent = await _recent(event, mind, settings)
        known = {**findings(mind.domain.fault, event, recent), **known}

    said = await _suspicion(event, mind, network, known, past)
    way_round = await _way_round(event, mind, network, known)
    concluded = _conclude(event, mind, settings, network, known, recent, past, tuple(asked), tuple(heard), said)
    if way_round is None:
        return concluded
    rests_on = (*concluded.rests_on, f"planning, as a child process: {way_round.says}")
    return replace(concluded, way_round=way_round.says, rests_on=rests_on, proposes=(*concluded.proposes, *way_round.proposes))


async def _way_round(event: Event, mind: Mind, network: Network, known: Mapping[str, bool]) -> Result | None:
    """Where a faulty thing blocks a way, planning looks for another one while nobody knows when it will be repaired."""
    trip = trip_of(event, graph_of(mind.domain))
    in_the_way = bool(trip.shut_nodes or trip.shut_legs) and any(_explains(fault, event) for fault in network.faults)
    if mind.mode != "delib" or not in_the_way or not any(known.values()):
        return None
    try:
        return await mind.treat(planning.name, event)
    except Refusal:
        return None


async def _suspicion(
    event: Event, mind: Mind, network: Network, known: Mapping[str, bool], past: Sequence[Episode]
) -> Consultation[Suspected]:
    """Which fault a reasoner suspects: one of the table that brings about a sign that was seen."""
    names = {fault.name: fault for fault in network.faults}

    def objection(suspected: Suspected) -> str:
        fault = names.get(suspected.fault)
        if fault is None:
            return f"there is no fault {suspected.fault[:60]!r} in the table"
        return "" if any(known.get(symptom) for symptom in fault.causes) else f"{fault.name} causes none of the signs seen"

    if not names or not any(known.values()):
        return Consultation()
    seen = ", ".join(symptom for symptom, there in known.items() if there)
    asks = f"Which of these faults most likely explains the signs seen ({seen})?"
    return await consult(event, mind, "diagnosis", asks, Suspected, objection, past, names)


async def _recent(event: Event, mind: Mind, settings: DiagnosisSettings) -> tuple[Episode, ...]:
    past = await of_robot(event, mind, settings.episodes)
    window_s = settings.recent_windows * mind.domain.outcome.within_s
    return tuple(episode for episode in past if abs(age_s(event, episode)) <= window_s)


def _open(event: Event, network: Network, known: Mapping[str, bool], settings: DiagnosisSettings) -> bool:
    """Whether looking on makes sense: some fault explains the event, and none of those has passed the threshold."""
    explaining = {fault.name for fault in network.faults if _explains(fault, event)}
    shares = [share for name, share in network.posterior(known).items() if name in explaining]
    return bool(shares) and max(shares) < settings.threshold


def _explains(fault: Fault, event: Event) -> bool:
    return any(seen_in(symptom, event) for symptom in fault.causes)


def _conclude(
    event: Event,
    mind: Mind,
    settings: DiagnosisSettings,
    network: Network,
    known: Mapping[str, bool],
    recent: Sequence[Episode],
    past: Sequence[Episode],
    asked: tuple[str, ...],
    heard: tuple[str, ...],
    said: Consultation[Suspected],
) -> Diagnosis:
    # what is believed from here on is the network with the reasoner's word in it; priors are told as the table has them
    table, network = network, network if said.answer is None else network.suspecting(said.answer.fault, settings.reasoner_odds)
    posterior = network.posterior(known)
    every = [_suspect(event, fault, posterior[fault.name], known) for fault in table.faults]
    suspects = tuple(sorted(every, key=lambda each: (not each.explains, -each.posterior, each.fault)))
    shown = tuple(symptom for symptom, seen in known.items() if seen)
    check, _ = most_telling(network, known, askable(mind.domain, event), (), settings.least_gain_bits) if shown else (None, None)
    voices = [recalled_voice(mind, event, past), _outcomes(mind, network, known)]
    forecast = pooled(mind, event, voices)
    top = suspects[0] if suspects and shown else None
    settled = top is not None and top.explains and top.posterior >= settings.threshold
    return Diagnosis(
        says=sentence(mind, subject(event), _named(event, top, suspects, mind), _next(check, settled), expectation(forecast)),
        confidence=sure(mind, top.posterior if top is not None and top.explains else NOTHING_TO_GO_ON),
        rests_on=(
            f"event {event.id}",
            *(f"fault table: {symptom} {'seen' if seen else 'not there'}" for symptom, seen in known.items()),
            *resting(episode for episode in recent if episode.kind in known),
            *heard,
            *forecast_reasons(mind, voices),
            *said.basis,
        ),
        would_change=_would_change(top, check, mind),
        forecast=forecast,
        proposes=_proposal(event, mind, top if settled else None),
        minimal=minimal_diagnoses(table.faults, known, settings.minimal) if settings.minimal else (),
        consulted=said.consulted,
        suspects=suspects if shown else (),
        unexplained=significant(network.unexplained(known)) if shown else 1.0,
        findings=dict(known),
        next_check=check,
        asked=asked,
        heard=heard,
        settled=settled,
    )


def _suspect(event: Event, fault: Fault, posterior: float, known: Mapping[str, bool]) -> Suspect:
    return Suspect(
        fault=fault.name,
        posterior=significant(posterior),
        prior=fault.prior,
        explains=_explains(fault, event),
        shown=tuple(symptom for symptom in fault.causes if known.get(symptom) is True),
        missing=tuple(symptom for symptom in fault.causes if known.get(symptom) is False),
        check=fault.check,
        remedy=fault.remedy,
    )


def _outcomes(mind: Mind, network: Network, known: Mapping[str, bool]) -> Voice | None:
    """Where the fault table names outcome labels among what faults cause, it forecasts them, if a fault shows itself at all."""
    if not any(known.values()):
        return None
    named = [label for label in mind.domain.outcome.labels[1:] if label in network.symptoms and label not in known]
    return model_voice(mind.domain, "fault table", {label: network.chance(label, known) for label in named})


def _named(event: Event, top: Suspect | None, suspects: Sequence[Suspect], mind: Mind) -> str:
    if not suspects:
        return f": no diagnosis, because domain {mind.domain.name} has no fault table"
    if top is None:
        return f": no fault of the table shows itself ({len(suspects)} faults, none with a symptom seen here)"
    if not top.explains:
        near = f"; signs near it ({', '.join(map(told, top.shown[:3]))}) point to {top.fault}, {percent(top.posterior)}"
        return f": no fault of the table explains it{near if top.shown else ''}"
    others = ", ".join(
        f"{other.fault} {percent(other.posterior)}"
        for other in suspects[1:3]
        if other.explains and other.posterior >= WORTH_NAMING
    )
    signs = f"from {percent(top.prior)} by {', '.join(told(symptom, event) for symptom in top.shown)}"
    return f": {top.fault} {percent(top.posterior)} ({signs}{'; then ' + others if others else ''})"


def _next(check: Check | None, settled: bool) -> str:
    if check is None or settled:
        return ""
    return f"; look for {told(check.symptom)} next ({check.gain_bits:.2g} bits expected)"


def _would_change(top: Suspect | None, check: Check | None, mind: Mind) -> tuple[str, ...]:
    looked = () if check is None else (f"whether {told(check.symptom)} is there ({check.gain_bits:.2g} bits expected)",)
    by_hand = (f"check: {top.check}",) if top is not None and top.check else ()
    if looked or by_hand:
        return (*looked, *by_hand)
    return ("a symptom of the fault table",) if mind.domain.fault else ("a fault table for this device",)


def _proposal(event: Event, mind: Mind, top: Suspect | None) -> tuple[Proposal, ...]:
    if top is None or not top.remedy:
        return ()
    first = (f"checked: {top.check}",) if top.check else ()
    until_ns = event.stamp.received_ns + to_ns(mind.domain.outcome.within_s)
    return (Proposal(effect=top.remedy, preconditions=(*first, f"{event.entity} is safe to work on"), valid_until_ns=until_ns),)
