"""Ranking treatments by a domain's written guidelines: what a mind starts from before it has any experience."""

from __future__ import annotations

from typing import Final

import msgspec

from wakeful.facts.domain import DomainSpec, Guideline, matches
from wakeful.facts.events import Event
from wakeful.facts.values import Field

UNWRITTEN_WEIGHT: Final = 0.05
"""What a treatment that no guideline speaks for weighs beside one written with weight 1."""


class Advice(msgspec.Struct, frozen=True):
    """What the guidelines say of one event: shares over the allowed treatments, in their order, and the one that leads."""

    shares: tuple[float, ...]
    leading: Guideline | None
    also: tuple[Guideline, ...] = ()


def facts_of(event: Event) -> dict[str, Field]:
    """What a guideline's ``when`` may name: the event's fields, then those of its context, and the event's own words."""
    return {
        **event.context.fields,
        **event.fields,
        "kind": event.kind,
        "entity": event.entity,
        "relation": event.relation.value,
        "criticality": event.criticality,
        "task": event.context.task,
        "zone": event.context.zone,
        "safety": event.context.safety,
        "condition": event.condition.phase.value if event.condition is not None else "",
    }


def advise(spec: DomainSpec, allowed: tuple[str, ...], event: Event) -> Advice:
    """Rank ``allowed`` by the guidelines that hold for the event: first by weight, then by the order they are written in.

    A treatment's share is the weight of its best guideline (``UNWRITTEN_WEIGHT`` without one), over their sum.
    """
    has = facts_of(event)
    holding = [line for line in spec.guideline if line.treat in allowed and line.weight > 0 and matches(line.when, has)]
    holding.sort(key=lambda line: -line.weight)
    best: dict[str, float] = {}
    for line in holding:
        best.setdefault(line.treat, line.weight)
    weights = [best.get(name, UNWRITTEN_WEIGHT) for name in allowed]
    total = sum(weights)
    shares = tuple(round(weight / total, 9) for weight in weights)
    return Advice(shares, holding[0] if holding else None, tuple(holding[1:]))


def expected(spec: DomainSpec, guideline: Guideline | None) -> dict[str, float]:
    """The guideline's expectation as probabilities over the domain's outcome labels.

    Where none is stated, all are equally likely: even a forecast that rests on nothing is judged, and learned from.
    """
    labels = spec.outcome.labels
    if guideline is None or guideline.expect not in labels or len(labels) == 1:
        return {label: round(1.0 / len(labels), 9) for label in labels}
    probability = min(max(guideline.probability, 0.0), 1.0)
    rest = (1.0 - probability) / (len(labels) - 1)
    return {label: round(probability if label == guideline.expect else rest, 9) for label in labels}
