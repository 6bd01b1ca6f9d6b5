"""A procedure from what the domain's tables write down: make safe, check, remedy, confirm. Ordered, not searched."""

from __future__ import annotations

from collections.abc import Iterable

from wakeful.facts.domain import DomainSpec, Fault, matches
from wakeful.facts.events import Event
from wakeful.facts.values import Fact
from wakeful.treatments.hazards import circumstances
from wakeful.treatments.symptoms import seen_in
from wakeful.treatments.wording import span

#: More faults than this are no longer a procedure but a list.
FAULTS = 3


class Step(Fact, frozen=True):
    """One step: what to do, what must hold first, and which table says so."""

    does: str
    preconditions: tuple[str, ...] = ()
    source: str = ""


def steps_for(event: Event, domain: DomainSpec) -> tuple[Step, ...]:
    """The written steps that apply to the event, in the order in which they should be taken; none where none applies."""
    has = circumstances(event)
    safe = [
        Step(does=hazard.control, source=f"hazard table: {hazard.name}")
        for hazard in sorted(domain.hazard, key=lambda each: -each.severity)
        if hazard.control and matches(hazard.when, has)
    ]
    suspects = sorted(_suspects(event, domain.fault), key=lambda each: -each.prior)[:FAULTS]
    checks = [Step(does=fault.check, source=f"fault table: {fault.name}") for fault in suspects if fault.check]
    remedies = [
        Step(does=fault.remedy, preconditions=(f"{fault.name} is confirmed",), source=f"fault table: {fault.name}")
        for fault in suspects
        if fault.remedy
    ]
    rules = sorted((g for g in domain.guideline if matches(g.when, has) and g.treat == "planning"), key=lambda g: -g.weight)
    advice = [Step(does=rule.because, source="guideline for planning") for rule in rules if rule.because]
    steps = _once([*safe, *checks, *remedies, *advice])
    if not steps or not domain.outcome.labels:
        return steps
    hold = f"watch for {span(domain.outcome.within_s)} what comes of it ({', '.join(domain.outcome.labels)})"
    return (*steps, Step(does=hold, preconditions=("the steps above are done",), source="outcome window of the domain"))


def _suspects(event: Event, faults: Iterable[Fault]) -> list[Fault]:
    return [fault for fault in faults if any(seen_in(symptom, event) for symptom in fault.causes)]


def _once(steps: list[Step]) -> tuple[Step, ...]:
    return tuple({step.does: step for step in reversed(steps)}.values())[::-1]
