"""Symptoms: whether an event or a remembered case shows what a fault of the domain is said to cause.

A symptom is an event kind, or a field with a value (``state=unstable``) or a bound (``load>0.6``, also written ``load=>0.6``:
the field, and then what guidelines would write), or one of some words in a text (``text~overheat|temperature``; ``says`` is the
event's own sentence).
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping

from wakeful.facts.asking import Episode
from wakeful.facts.domain import Fault, matches
from wakeful.facts.events import Event
from wakeful.facts.values import Field
from wakeful.treatments.hazards import circumstances
from wakeful.treatments.measures import number
from wakeful.treatments.wording import bare, quantity

_CONDITION = re.compile(r"([^<>=]+)=?(<=|>=|=|<|>|~)(.*)", re.DOTALL)


def seen_in(symptom: str, event: Event) -> bool | None:
    """Whether the event shows the symptom: True, False, or None where it says nothing of it."""
    condition = split(symptom)
    if condition is None:
        return True if symptom == event.kind else None
    shown = holds(condition, circumstances(event))
    # that its sentence does not name a thing is no finding: most sentences name one thing only
    return None if shown is False and condition[:2] == ("says", "~") else shown


def findings(faults: Iterable[Fault], event: Event, others: Iterable[Episode] = ()) -> dict[str, bool]:
    """The symptoms of the faults that are known to be there or not to be: from the event, and from other events' kinds.

    That a kind was not registered is no finding: a detector may be deaf to it.
    """
    kinds = {episode.kind for episode in others}
    known: dict[str, bool] = {}
    for symptom in dict.fromkeys(symptom for fault in faults for symptom in fault.causes):
        shown = seen_in(symptom, event)
        if shown is None and symptom in kinds:
            shown = True
        if shown is not None:
            known[symptom] = shown
    return known


def split(symptom: str) -> tuple[str, str, str] | None:
    """A condition as (field, sign, value); None where the symptom is an event kind.

    >>> split("load >= 0.6"), split("load=>0.6"), split("motor_hot")
    (('load', '>=', '0.6'), ('load', '>', '0.6'), None)
    """
    found = _CONDITION.fullmatch(symptom)
    return None if found is None else (found[1].strip(), found[2], found[3].strip())


def told(symptom: str, event: Event | None = None) -> str:
    """A symptom as a sentence says it; of words in a text only those that the event has, where there is one.

    >>> told("temperature_c=>70"), told("state=unstable"), told("motor_hot")
    ('temperature > 70 °C', 'state unstable', 'motor hot')
    >>> told("text~heat|hot")
    '“heat”, “hot” in its text'
    """
    condition = split(symptom)
    if condition is None:
        return symptom.replace("_", " ")
    name, sign, value = condition
    if sign == "~":
        text = "" if event is None else str(circumstances(event).get(name, "")).casefold()
        words = [word.strip() for word in value.split("|")]
        said = [word for word in words if word.casefold() in text] or words
        return f"“{'”, “'.join(said)}” in {'what it says' if name == 'says' else 'its ' + bare(name)}"
    sized = quantity(name, float(value)) if _is_number(value) else value
    return f"{bare(name)} {'' if sign == '=' else sign + ' '}{sized}"


def holds(condition: tuple[str, str, str], has: Mapping[str, Field]) -> bool | None:
    """Whether a condition holds among these fields; None where the field is absent, empty or of no comparable kind."""
    name, sign, value = condition
    actual = has.get(name)
    if actual is None or isinstance(actual, tuple):
        return None
    if sign == "~":
        words = [word.strip().casefold() for word in value.split("|")]
        return any(word and word in actual.casefold() for word in words) if isinstance(actual, str) else None
    if sign != "=":
        if number(actual) is None or not _is_number(value):
            return None
        return matches({name: f"{sign}{value}"}, {name: actual})
    if isinstance(actual, str):
        return actual.casefold() == value.casefold()
    if isinstance(actual, bool) or value.casefold() in ("true", "false"):
        # a flag may have been recorded as a number
        return bool(actual) == (value.casefold() in ("true", "yes", "1"))
    return number(actual) == float(value) if _is_number(value) else False


def _is_number(text: str) -> bool:
    try:
        return number(float(text)) is not None
    except ValueError:
        return False
