"""The learning curve, from records."""

from __future__ import annotations

import msgspec

from tests.learning.worlds import event
from wakeful.facts.decisions import Decision, Gate, Mode
from wakeful.facts.experience import ModelCard, Verdict
from wakeful.facts.lines import Admitted, Concluded, Created, Decided, Judged, Published
from wakeful.facts.values import NOTHING
from wakeful.learning.curve import Curve

GATE = Gate(confidence=0.9, threshold=0.5, novelty=0.1, novelty_limit=0.9, trust=1.0, trust_limit=0.5)


def decided(number: int, mode: Mode, treatment: str = "planning", process: int = 0, model: int = 0) -> Decided:
    decision = Decision(treatment=treatment, mode=mode, confidence=0.9, candidates=(), reasons=(), gate=GATE, model=model)
    return Decided(process=process or number, event=f"e{number}", decision=decision)


def judged(number: int, verdict: Verdict, process: int = 0) -> Judged:
    return Judged(process=process or number, event=f"e{number}", predicted="a", label="b", verdict=verdict)


def opened(curve: Curve, number: int, truth: str | None = None) -> None:
    curve.apply(Admitted(event=msgspec.structs.replace(event(number), truth_treatment=truth)))
    curve.apply(Created(process=number, event=f"e{number}", treatment="planning", criticality=0))


def test_shares_and_accuracies_are_those_of_the_stretch() -> None:
    curve = Curve()
    for number in range(1, 11):
        opened(curve, number, truth="planning" if number % 2 else "memory")
        curve.apply(decided(number, "delib" if number <= 5 else "auto", model=0 if number <= 5 else 2))
        curve.apply(judged(number, Verdict.SUPPORTED if number > 2 else Verdict.CONTRADICTED))
    early, late = curve.points(2)
    assert (early.first, early.last, late.first, late.last) == (1, 5, 6, 10)
    assert (early.auto, early.delib, late.auto, late.delib) == (0.0, 1.0, 1.0, 0.0)
    assert (early.result_accuracy, late.result_accuracy) == (0.6, 1.0)
    assert (early.automatic_accuracy, late.automatic_accuracy) == (None, 1.0)
    assert (early.treatment_accuracy, early.joint_accuracy) == (0.6, 0.4)
    assert (early.experiences, late.experiences, late.model) == (5, 10, 2)


def test_the_decision_that_held_counts_and_second_thoughts_do_not() -> None:
    curve = Curve()
    opened(curve, 1)
    curve.apply(decided(1, "delib"))
    curve.apply(decided(1, "fallback"))
    curve.apply(Concluded(process=1, event="e1", treatment="planning", mode="fallback", result=NOTHING))
    curve.apply(decided(1, "auto"))
    curve.apply(Created(process=9, event="e1", treatment="planning", criticality=0, reopens=1))
    curve.apply(decided(1, "auto", process=9))
    curve.apply(judged(1, Verdict.UNDECIDED))
    curve.apply(judged(1, Verdict.CONTRADICTED))
    curve.apply(judged(1, Verdict.SUPPORTED, process=9))
    (point,) = curve.points(1)
    assert (point.auto, point.fallback, point.result_accuracy) == (0.0, 1.0, 0.0)


def test_an_empty_journal_has_no_points_and_few_events_few() -> None:
    curve = Curve()
    assert curve.points(10) == ()
    opened(curve, 1)
    (point,) = curve.points(10)
    assert (point.auto, point.result_accuracy, point.judged) == (0.0, None, 0)


def test_published_versions_are_placed_in_the_stream() -> None:
    curve = Curve()
    opened(curve, 1)
    card = ModelCard(version=1, base=0, watermark=1, seed=0, epochs=1, blob="", accepted=True)
    curve.apply(Published(training=1, card=card))
    assert curve.published == [(1, 1, True)]
