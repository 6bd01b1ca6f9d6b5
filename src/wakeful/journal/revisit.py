"""Which past decisions rest on knowledge that was refuted, the ones that can't be taken back and the riskiest first."""

from __future__ import annotations

from wakeful.facts.decisions import Decision
from wakeful.facts.experience import Experience, Verdict
from wakeful.facts.time import to_s
from wakeful.journal.history import EventPast, History, ProcessPast
from wakeful.journal.readable import View
from wakeful.journal.results import result_fields

#: How a decision came by the refuted knowledge.
BY_EXPERIENCE, BY_MODEL = "experience", "model"

OPEN_TO_CORRECTION = "open to correction"


class Refuted(View, frozen=True):
    """One experience that was asked about. ``refuted``: the world contradicted what was concluded then."""

    experience: int
    event: str
    says: str
    treatment: str
    predicted: str
    outcome: str
    refuted: bool


class Affected(View, frozen=True):
    """One decision that rests on it.

    ``irreversible``: it was acted on, or it proposed an effect and the time to take that back has passed. ``risk``: the forecast
    probability of anything but the domain's quiet outcome. ``stands``: ``open to correction``, or why it no longer is.
    """

    process: int
    event: str
    says: str
    treatment: str
    mode: str
    predicted: str
    criticality: int
    risk: float
    irreversible: bool
    by: str
    on: tuple[int, ...]
    stands: str
    at_ns: int
    age_s: float


class Revisited(View, frozen=True):
    """What was asked about, and the decisions resting on it."""

    knowledge: tuple[Refuted, ...]
    affected: tuple[Affected, ...]
    through_model: int
    """How many more decisions rest on a model version that had learned from it, and say the same by the same treatment."""


def revisit_event(read: History, past: EventPast, quiet: str, *, through_model: bool = False) -> Revisited:
    """The decisions that rest on what was experienced at an event and, where it was contradicted, on what it rested on itself.

    Args:
        read: the whole journal.
        past: the event.
        quiet: the domain's outcome label for "nothing happened", whose probability is no risk.
        through_model: list the decisions by model versions that had learned from it, too.
    """
    own = [gained.experience for gained in read.gained.values() if gained.experience.event == past.event.id]
    known = {each.id for each in own}
    for each in own:
        decision = _decision_in(read, each.process)
        if each.verdict is Verdict.CONTRADICTED and decision is not None:
            known.update(decision.rests_on)
    return revisit(read, sorted(known), quiet, leave_out=past.event.id, through_model=through_model)


def revisit(read: History, experiences: list[int], quiet: str, *, leave_out: str = "", through_model: bool = False) -> Revisited:
    """The decisions that rest on these experiences. See ``revisit_event``; ``leave_out`` is an event that is not listed."""
    known = set(experiences)
    learned = [read.gained[each].experience for each in experiences if each in read.gained]
    stale = [(each, _versions_on(read, each)) for each in learned if each.verdict is Verdict.CONTRADICTED]
    found: list[Affected] = []
    by_model = 0
    for process in read.processes.values():
        decision = process.decision
        if process.parent or decision is None or process.event == leave_out:
            continue
        shared = tuple(sorted(known.intersection(decision.rests_on)))
        if shared:
            found.append(_affected(read, process, decision, quiet, BY_EXPERIENCE, shared))
            continue
        on = tuple(each.id for each, versions in stale if decision.model in versions and _says_the_same(process, each))
        if on:
            by_model += 1
            if through_model:
                found.append(_affected(read, process, decision, quiet, BY_MODEL, on))
    found.sort(key=lambda row: (not row.irreversible, row.stands != OPEN_TO_CORRECTION, -row.criticality, -row.risk, row.process))
    return Revisited(knowledge=tuple(_told(read, each) for each in learned), affected=tuple(found), through_model=by_model)


def _decision_in(read: History, process: int) -> Decision | None:
    found = read.processes.get(process)
    return found.decision if found is not None else None


def _versions_on(read: History, experience: Experience) -> set[int]:
    """The model versions that took the experience's event for what was concluded then: those before it was learned from.

    A contradicted experience corrects the versions that learned from it; what is stale is every version that did not.
    """
    made = _decision_in(read, experience.process)
    first = made.model if made is not None else 0
    corrected = [published.card.version for _, published in read.published if published.card.watermark >= experience.id]
    until = min(corrected, default=None)
    versions = {published.card.version for _, published in read.published if published.card.accepted}
    return {version for version in versions if version >= max(first, 1) and (until is None or version < until)}


def _says_the_same(process: ProcessPast, experience: Experience) -> bool:
    forecast = process.concluded.forecast if process.concluded is not None else None
    same = forecast is not None and forecast.label == experience.predicted
    return same and process.treatment == experience.treatment and process.id != experience.process


def _affected(read: History, process: ProcessPast, decision: Decision, quiet: str, by: str, on: tuple[int, ...]) -> Affected:
    past = read.events[process.event]
    forecast = process.concluded.forecast if process.concluded is not None else None
    return Affected(
        process=process.id,
        event=process.event,
        says=past.event.says or f"{past.event.kind} {past.event.entity}",
        treatment=process.treatment,
        mode=process.concluded.mode if process.concluded is not None else decision.mode,
        predicted=forecast.label if forecast is not None else "",
        criticality=process.criticality,
        risk=round(1.0 - forecast.probabilities.get(quiet, 0.0), 6) if forecast is not None and forecast.probabilities else 0.0,
        irreversible=_irreversible(read, process),
        by=by,
        on=on,
        stands=_stands(read, process),
        at_ns=past.event.stamp.source_ns,
        age_s=to_s(read.now_ns - process.created_ns),
    )


def _irreversible(read: History, process: ProcessPast) -> bool:
    judged = process.judged
    outcome = read.outcomes.get(judged.outcome) if judged is not None else None
    if outcome is not None and outcome.acted_on:
        return True
    concluded = process.concluded
    if concluded is None:
        return False
    proposed = result_fields(concluded.result).get("proposes")
    limits = [each.get("valid_until_ns") for each in proposed if isinstance(each, dict)] if isinstance(proposed, list) else []
    return any(isinstance(until_ns, int) and until_ns <= read.now_ns for until_ns in limits)


def _stands(read: History, process: ProcessPast) -> str:
    reopened = [record.process for record in read.reopened.values() if record.reopens == process.id]
    if reopened:
        return f"reopened as P{reopened[-1]}"
    if process.open:
        return "under way: it will be decided with what is known now"
    if process.judged is not None and process.judged.verdict is not Verdict.UNDECIDED:
        return f"{process.judged.verdict} by {process.judged.label!r}"
    if process.concluded is None:
        return f"ended {process.end}"
    closes_ns = process.concluded.closes_ns
    if closes_ns is None or closes_ns < read.now_ns:
        return "its window has closed"
    return OPEN_TO_CORRECTION


def _told(read: History, experience: Experience) -> Refuted:
    past = read.events.get(experience.event)
    event = past.event if past is not None else None
    return Refuted(
        experience=experience.id,
        event=experience.event,
        says=(event.says or f"{event.kind} {event.entity}") if event is not None else "",
        treatment=experience.treatment,
        predicted=experience.predicted,
        outcome=experience.outcome,
        refuted=experience.verdict is Verdict.CONTRADICTED,
    )
