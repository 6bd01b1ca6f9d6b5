"""What a question's facts and history say about the domain's written knowledge: the grounds of the guideline reasoner."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from math import prod

import msgspec

from wakeful.facts.domain import DomainSpec, Fault, Guideline, Hazard, Scalar, matches
from wakeful.facts.values import Field

_LONGEST_SCALAR = 40
_PYTHON_WORDS: dict[str, Field] = {"True": True, "False": False, "None": None}
_LEAK = 0.01
_SUPPORTED = re.compile(r"\b(?:supported|confirmed|proved right|was right)\b", re.IGNORECASE)
_CONTRADICTED = re.compile(r"\b(?:contradicted|refuted|proved wrong|was wrong)\b", re.IGNORECASE)
_TREATED = re.compile(r"\btreated (?:by|with)\s+", re.IGNORECASE)
_SHOWED = re.compile(r"\b(?:outcome|showed|shown|shows|ended)\b", re.IGNORECASE)


class Tally(msgspec.Struct, frozen=True):
    """How often validated history supports and contradicts something."""

    supported: int = 0
    contradicted: int = 0


def readings(text: str) -> tuple[Field, ...]:
    """What a fact may mean: the JSON scalar that it spells, and the text itself.

    A field whose text happens to look like a number is still found by a guideline that compares it with text.

    >>> readings("0.7"), readings("blocked"), readings("True")
    ((0.7, '0.7'), ('blocked',), (True, 'True'))
    """
    if text in _PYTHON_WORDS:
        return (_PYTHON_WORDS[text], text)
    if len(text) > _LONGEST_SCALAR:
        return (text,)
    try:
        scalar: None | bool | int | float | str = msgspec.json.decode(text, type=None | bool | int | float | str)
    except (msgspec.MsgspecError, UnicodeError):
        return (text,)
    return (text,) if isinstance(scalar, str) else (scalar, text)


def holds(when: Mapping[str, Scalar | list[Scalar]], facts: Mapping[str, tuple[Field, ...]]) -> bool:
    """Whether every condition holds in some reading of its fact; a fact that is absent never holds."""
    return all(any(matches({name: wanted}, {name: one}) for one in facts.get(name, ())) for name, wanted in when.items())


def applying(spec: DomainSpec, facts: Mapping[str, tuple[Field, ...]]) -> tuple[list[Guideline], list[Hazard]]:
    """The guidelines that apply, by weight and then by order, and the hazards that do, gravest first."""
    guidelines = sorted((one for one in spec.guideline if holds(one.when, facts)), key=lambda one: -one.weight)
    hazards = sorted((one for one in spec.hazard if holds(one.when, facts)), key=lambda one: (-one.severity, -risk((one,))))
    return guidelines, hazards


def risk(hazards: Sequence[Hazard]) -> float:
    """The probability that at least one of them comes about, each with exposure × likelihood, independently."""
    return 1.0 - prod(1.0 - one.exposure * one.likelihood for one in hazards)


def blame(faults: Sequence[Fault], facts: Mapping[str, tuple[Field, ...]]) -> dict[str, float]:
    """Which of the faults explains the facts: posterior of each, one fault at a time, by its prior and its causes.

    A symptom is an event kind or ``field=value``, where the value may be a comparison such as ``>70``. One that is seen counts
    with the fault's probability of causing it (or a small leak); one whose field is there with another value counts against; one
    that nobody looked for says nothing.

    Returns:
        Probabilities that sum to 1 over the faults; empty where no symptom of any is seen.
    """
    symptoms = sorted({symptom for one in faults for symptom in one.causes})
    seen = {symptom: found for symptom in symptoms if (found := _symptom(symptom, facts)) is not None}
    if not any(seen.values()):
        return {}
    scores = {
        one.name: one.prior
        * prod(
            max(_LEAK, one.causes.get(symptom, 0.0)) if found else 1.0 - min(1.0 - _LEAK, one.causes.get(symptom, 0.0))
            for symptom, found in seen.items()
        )
        for one in faults
    }
    total = sum(scores.values())
    return {name: score / total for name, score in scores.items()} if total > 0 else {}


def _symptom(symptom: str, facts: Mapping[str, tuple[Field, ...]]) -> bool | None:
    """Seen, seen to be absent, or not looked for."""
    name, equals, wanted = symptom.partition("=")
    if not equals:
        return True if symptom in facts.get("kind", ()) else None
    if name not in facts:
        return None
    return any(holds({name: one}, facts) for one in readings(wanted) if isinstance(one, bool | int | float | str))


def history_of(option: str, history: Sequence[str]) -> Tally:
    """How often sentences on validated experience say that this option was supported, and contradicted.

    In a sentence that says "treated by" or "treated with", what follows the last of them is meant; in others, any mention counts.
    """
    about = [sentence for sentence in history if _is_about(option, sentence)]
    contradicted = sum(1 for sentence in about if _CONTRADICTED.search(sentence))
    supported = sum(1 for sentence in about if _SUPPORTED.search(sentence) and not _CONTRADICTED.search(sentence))
    return Tally(supported, contradicted)


def shown(labels: Sequence[str], history: Sequence[str]) -> dict[str, int]:
    """How often history says that the world showed each label: the first named after the last "outcome", "showed" or "ended"."""
    counts = dict.fromkeys(labels, 0)
    for sentence in history:
        verbs = list(_SHOWED.finditer(sentence))
        if not verbs:
            continue
        places = {label: at for label in labels if (at := _mention(label, sentence, verbs[-1].end())) is not None}
        if places:
            counts[min(places, key=lambda label: (places[label], -len(label)))] += 1
    return counts


def _is_about(option: str, sentence: str) -> bool:
    treated = list(_TREATED.finditer(sentence))
    if not treated:
        return _mention(option, sentence) is not None
    return _mention(option, sentence, treated[-1].end()) == treated[-1].end()


def _mention(name: str, sentence: str, start: int = 0) -> int | None:
    """Where a name stands in a sentence as a word of its own, ``_`` and space being the same."""
    words = re.escape(name).replace("_", "[ _]")
    found = re.compile(rf"(?<![\w-]){words}(?![\w-])", re.IGNORECASE).search(sentence, start)
    return found.start() if found else None
