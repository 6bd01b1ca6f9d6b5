"""Explicit reasoning over the domain's written guidelines: the offline default."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from wakeful.contracts.reasoner import ReasonerError
from wakeful.deliberation.grounds import applying, history_of, readings, risk, shown
from wakeful.deliberation.leanings import Grounds, Leaning, lean
from wakeful.deliberation.replies import answer_mismatch
from wakeful.facts.asking import Question, Reply
from wakeful.facts.domain import DomainSpec, Guideline, Hazard
from wakeful.facts.values import NOTHING

_TRUST_IN_TEXT = 4.0
"""How many validated experiences a written guideline counts for."""
_TRUST_IN_FORECAST = 2.0
_SENTENCES = 8


class GuidelineError(ValueError):
    """A guideline or hazard whose condition cannot be read. The message names it."""


class GuidelineReasoner:
    """Chooses as the domain's owner wrote, says so in her words, and hears validated experience.

    The weightiest guideline that applies and names an option decides; where none does, the faults that explain the facts, the
    gravest hazard, or what the guidelines expect, whichever the options are. Each condition met halves the doubt; a rival
    guideline adds some. Validated experience moves the confidence; it overrules the text where it has contradicted its choice at
    least twice more often than supported it, and speaks for another option. Where nothing is written about any option, the
    first is chosen with the confidence of a draw, and the reasons say so.

    Deterministic: the same question over the same domain gives the same reply.

    Args:
        spec: the domain.
        latency_s: what an answer takes in virtual time.

    Raises:
        GuidelineError: a condition cannot be read.
    """

    name = "guidelines"

    def __init__(self, spec: DomainSpec, latency_s: float = 0.2) -> None:
        for where, when in [
            *((f"guideline {number} ({one.treat})", one.when) for number, one in enumerate(spec.guideline, 1)),
            *((f"hazard {one.name}", one.when) for one in spec.hazard),
        ]:
            _check(where, when, spec.name)
        self.latency_s = latency_s
        self._spec = spec

    def describe(self) -> str:
        """One line on who answers."""
        spec = self._spec
        return (
            f"the {len(spec.guideline)} written guidelines and {len(spec.hazard)} hazards of {spec.name} (version {spec.version})"
        )

    async def answer(self, question: Question) -> Reply:
        """One answer; see ``decide``."""
        return self.decide(question)

    def decide(self, question: Question) -> Reply:
        """One answer, at once.

        Raises:
            ReasonerError: there are no options, or an answer in free form is wanted, which written guidelines do not give.
        """
        if not question.options:
            raise ReasonerError("the question has no options to choose from")
        if question.schema != NOTHING and answer_mismatch(NOTHING, question.schema) is not None:
            raise ReasonerError("written guidelines choose among options; this question wants an answer of its own form")
        facts = {name: readings(text) for name, text in question.facts.items()}
        guidelines, hazards = applying(self._spec, facts)
        leaning = lean(question, Grounds(self._spec, facts, guidelines, hazards))
        choice, confidence, heard = _hear(leaning, question)
        forecast, probability, expects = _forecast(question, choice, guidelines, hazards)
        warned = [
            f"Hazard {one.name}, severity {one.severity} of 4." + (f" {one.control}" if one.control else "") for one in hazards
        ]
        return Reply(
            choice=choice,
            confidence=round(confidence, 6),
            forecast=forecast,
            forecast_probability=round(probability, 6),
            because=(*leaning.because, *heard, *expects, *warned)[:_SENTENCES],
            reasoner=self.name,
        )


def _hear(leaning: Leaning, question: Question) -> tuple[str, float, list[str]]:
    """Choice, confidence and reasons once validated history has been heard."""
    tallies = {option: history_of(option, question.history) for option in question.options}
    own = tallies[leaning.option]
    better = max(
        question.options, key=lambda one: (tallies[one].supported - tallies[one].contradicted, -question.options.index(one))
    )
    choice, start = leaning.option, leaning.confidence
    heard = tallies[better].supported - tallies[better].contradicted
    overruled = own.contradicted >= own.supported + 2 and heard > 0 and better != choice
    if overruled:
        choice, start = better, 1.0 / len(question.options)
    tally = tallies[choice]
    confidence = (_TRUST_IN_TEXT * start + tally.supported) / (_TRUST_IN_TEXT + tally.supported + tally.contradicted)
    because = []
    if overruled:
        because.append(f"But {leaning.option} was contradicted {own.contradicted} times in like cases, and {choice} was not.")
    if tally.supported or tally.contradicted:
        because.append(
            f"In like cases {choice} was supported {tally.supported} times and contradicted {tally.contradicted} times."
        )
    return choice, min(1.0, max(0.0, confidence)), because


def _forecast(
    question: Question, choice: str, guidelines: Sequence[Guideline], hazards: Sequence[Hazard]
) -> tuple[str, float, list[str]]:
    """Label, probability and reasons: what a guideline expects, else what the hazards threaten, else nothing known."""
    labels = question.labels
    if not labels:
        return "", 0.0, []
    expecting = [one for one in guidelines if one.expect in labels]
    best = next((one for one in expecting if one.treat == choice), expecting[0] if expecting else None)
    if best is not None:
        first, sure = best.expect, best.probability
    elif hazards and len(labels) > 1:
        first, sure = labels[0], 1.0 - risk(hazards)
    else:
        first, sure = labels[0], 1.0 / len(labels)
    rest = (1.0 - sure) / (len(labels) - 1) if len(labels) > 1 else 0.0
    counts = shown(labels, question.history)
    seen = sum(counts.values())
    scores = {
        label: (_TRUST_IN_FORECAST * (sure if label == first else rest) + counts[label]) / (_TRUST_IN_FORECAST + seen)
        for label in labels
    }
    forecast = max(labels, key=lambda label: (round(scores[label], 9), -labels.index(label)))
    because = [f"Like cases ended {counts[forecast]} of {seen} times in {forecast}."] if seen else []
    return forecast, scores[forecast], because


def _check(where: str, when: Mapping[str, object], domain: str) -> None:
    for name, wanted in when.items():
        if isinstance(wanted, str) and wanted[:1] in ("<", ">"):
            try:
                float(wanted.lstrip("<>").removeprefix("="))
            except ValueError:
                raise GuidelineError(
                    f"{where} of domain {domain} compares {name} with {wanted!r}; write a number after the sign, such as '>0.6'"
                ) from None
