"""Which fields a model's decision rested on, recomputed exactly with the recorded model version."""

from __future__ import annotations

import msgspec

from wakeful.contracts.learner import Predictor
from wakeful.facts.events import Event
from wakeful.selection.features import Encoder

_DIGITS = 6


class Contribution(msgspec.Struct, frozen=True):
    """What one field did: how much higher the probability of ``treatment`` and of the forecast ``label`` is with the event's
    own value than with the typical one of what was learned from."""

    field: str
    value: str
    treatment: float
    label: float


def contributions(encoder: Encoder, predictor: Predictor, event: Event, treatment: str) -> tuple[Contribution, ...]:
    """The effect of each field on the probability of ``treatment``, and on that of the likeliest outcome label.

    Each group of columns is replaced by its mean over what the model was fitted on, all others kept, and the model is asked
    again: exact for this model version and one field at a time, so the effects need not add up.

    Args:
        encoder: the domain's, as it was when the model version was fitted.
        predictor: the loaded model version that decided.
        event: the event decided upon.
        treatment: the one whose probability is explained; one that the model does not know has effects of 0.

    Returns:
        The contributions that are not 0, the greatest effect first; equal ones in the order of the columns.
    """
    features = encoder.encode(event)
    own = predictor.estimate(features)
    place = predictor.treatments.index(treatment) if treatment in predictor.treatments else None
    label = int(own.labels.argmax())
    found: list[Contribution] = []
    for group, columns in encoder.groups.items():
        at = list(columns)
        if (features[at] == predictor.typical[at]).all():
            continue
        changed = features.copy()
        changed[at] = predictor.typical[at]
        other = predictor.estimate(changed)
        effect = 0.0 if place is None else round(float(own.treatments[place] - other.treatments[place]), _DIGITS)
        on_label = round(float(own.labels[label] - other.labels[label]), _DIGITS)
        if effect or on_label:
            found.append(Contribution(group, value_of(event, group), effect, on_label))
    found.sort(key=lambda item: -max(abs(item.treatment), abs(item.label)))
    return tuple(found)


def value_of(event: Event, group: str) -> str:
    """The event's own value of a group of columns, as a person would write it."""
    own = {
        "kind": event.kind,
        "entity": event.entity,
        "relation": event.relation.value,
        "criticality": str(event.criticality),
        "safety": "yes" if event.context.safety else "no",
        "task": event.context.task or "none",
        "zone": event.context.zone or "none",
        "condition": event.condition.phase.value if event.condition is not None else "none",
    }
    if group in event.fields or group in event.context.fields:
        value = event.fields[group] if group in event.fields else event.context.fields[group]
        return "missing" if value is None else f"{value:.4g}" if isinstance(value, float) else str(value)
    return own.get(group, "several" if group.startswith("other ") else "missing")
