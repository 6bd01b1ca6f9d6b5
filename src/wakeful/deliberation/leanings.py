"""What the written knowledge says for one of a question's options, before history is heard."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import msgspec

from wakeful.deliberation.grounds import blame, risk
from wakeful.facts.asking import Question
from wakeful.facts.domain import DomainSpec, Guideline, Hazard
from wakeful.facts.values import Field


class Leaning(msgspec.Struct, frozen=True):
    """An option, how much speaks for it, and what."""

    option: str
    confidence: float
    because: tuple[str, ...]


class Grounds(msgspec.Struct, frozen=True):
    """What holds of a question: its facts as read, the guidelines that apply (weightiest first), the hazards (gravest first)."""

    spec: DomainSpec
    facts: Mapping[str, tuple[Field, ...]]
    guidelines: Sequence[Guideline]
    hazards: Sequence[Hazard]


def lean(question: Question, grounds: Grounds) -> Leaning:
    """The first that speaks to the options: a guideline, the faults, a hazard, what a guideline expects; else a draw."""
    for ground in (_by_guideline, _by_fault, _by_hazard, _by_expectation):
        leaning = ground(question, grounds)
        if leaning is not None:
            return leaning
    first, draw = question.options[0], 1.0 / len(question.options)
    nothing = f"No guideline of {grounds.spec.name} speaks to this; {first} is only the first of the options."
    return Leaning(first, draw, (nothing,))


def _by_guideline(question: Question, grounds: Grounds) -> Leaning | None:
    speaking = [one for one in grounds.guidelines if one.treat in question.options]
    if not speaking:
        return None
    best = speaking[0]
    agreeing = [one for one in speaking if one.treat == best.treat]
    rival = next((one for one in speaking if one.treat != best.treat), None)
    clarity = max(_clarity(one) for one in agreeing if one.weight == best.weight)
    against = 0.0 if rival is None else 0.5 * _clarity(rival) * rival.weight
    confidence = clarity * best.weight / (best.weight + against) if best.weight > 0 else 0.0
    because = [quote(one) for one in agreeing[:3]]
    if rival is not None:
        because.append(f"Against it, for {rival.treat}: {quote(rival)}")
    return Leaning(best.treat, confidence, tuple(because))


def _by_fault(question: Question, grounds: Grounds) -> Leaning | None:
    faults = [one for one in grounds.spec.fault if one.name in question.options]
    posterior = blame(faults, grounds.facts)
    if not posterior:
        return None
    best = max(posterior, key=lambda name: (round(posterior[name], 9), -question.options.index(name)))
    says = f"Of the {len(faults)} faults asked about, {best} explains the facts best ({posterior[best]:.0%})."
    check = next(one.check for one in faults if one.name == best)
    return Leaning(best, posterior[best], (says, *((f"To check: {check}",) if check else ())))


def _by_hazard(question: Question, grounds: Grounds) -> Leaning | None:
    worst = next((one for one in grounds.hazards if one.name in question.options), None)
    if worst is None:
        return None
    return Leaning(worst.name, max(0.5, risk((worst,))), (f"{worst.name} is the gravest hazard whose conditions hold.",))


def _by_expectation(question: Question, grounds: Grounds) -> Leaning | None:
    best = next((one for one in grounds.guidelines if one.expect in question.options), None)
    return None if best is None else Leaning(best.expect, best.probability, (quote(best),))


def quote(guideline: Guideline) -> str:
    """A guideline's reason in its owner's words, with the conditions that hold."""
    met = " and ".join(f"{name} is {wanted}" for name, wanted in guideline.when.items())
    return f"{guideline.because} (as {met})" if met else f"{guideline.because} (always)"


def _clarity(guideline: Guideline) -> float:
    """How far a guideline settles the matter: each condition that holds halves the doubt."""
    return float(1.0 - 0.5 ** (1 + len(guideline.when)))
