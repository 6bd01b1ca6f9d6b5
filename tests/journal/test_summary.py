"""The summary counts what the lines say."""

from __future__ import annotations

import math

import msgspec
import pytest
from hypothesis import given, settings

from tests.journal.builder import Book, full_book
from tests.journal.strategies import any_lines
from tests.journal.test_audit import Pages
from wakeful.facts.evidence import Outcome
from wakeful.facts.lines import Line, Witnessed
from wakeful.facts.processes import Trigger
from wakeful.journal.summary import Summary, share, summary


def test_the_counts_of_a_full_journal() -> None:
    told = summary(full_book())
    assert (told.source, told.domain) == ("arm.xlsx", "arm")
    assert (told.received, told.admitted, told.duplicate, told.refused) == (9, 7, 1, 1)
    assert told.refused_because == {"field 'x' is nan": 1}
    assert told.coverage == 1.0
    assert told.completion == pytest.approx(5 / 7)
    assert told.treatments == {"diagnosis": 4, "planning": 1, "risk_prediction": 1, "comparison": 1}
    assert told.modes == {"auto": 3, "delib": 3, "fallback": 1}
    assert (told.waiting, told.suspended) == (1, 0)
    assert (told.outcomes_witnessed, told.outcomes_matched, told.windows_closed) == (1, 1, 4)
    assert told.verdicts == {"supported": 4, "contradicted": 1, "undecided": 0}
    assert (told.reasoner_calls, told.cost_usd) == (1, 0.01)
    assert (told.reopened, told.models_published, told.models_rejected) == (1, 1, 1)
    assert told.observations == 500
    assert told.debt == 1


def test_accuracy_of_treatment_result_and_both_is_of_the_root_process_and_its_last_decision() -> None:
    accuracy = summary(full_book()).accuracy
    assert (accuracy.treatment.right, accuracy.treatment.of) == (4, 5)
    assert (accuracy.result.right, accuracy.result.of) == (4, 5)
    assert (accuracy.joint.right, accuracy.joint.of) == (3, 5)
    assert (accuracy.base_label, accuracy.base_rate.right) == ("none", 4)


def test_an_abandoned_process_is_uncovered_and_not_completed() -> None:
    book = Book()
    book.move(book.admit(), Trigger.ABANDON)
    told = summary(book)
    assert (told.coverage, told.completion, told.completions) == (0.0, 0.0, {"abandoned": 1})


def test_the_curve_shows_the_automatic_share_growing() -> None:
    book = Book()
    for index in range(20):
        process = book.admit(mode="auto" if index >= 10 else "delib")
        book.run_through(process)
        book.judge(process, "none", "stop" if index < 4 else "none")
    curve = summary(book).curve
    assert [stretch.automatic for stretch in curve] == [0.0] * 5 + [1.0] * 5
    assert [stretch.result.fraction for stretch in curve] == [0.0] * 2 + [1.0] * 8


def test_the_strangest_episode_is_the_one_that_surprised_its_forecast_and_each_sort_comes_once_first() -> None:
    book = Book()
    for label, probability, shown in (
        ("none", 0.6, "none"),
        ("none", 0.99, "stop"),
        ("none", 0.99, "stop"),
        ("none", 0.7, "none"),
    ):
        process = book.admit()
        book.move(process, Trigger.DISPATCH)
        book.conclude(process, label, probability)
        book.judge(process, label, shown)
    calm = book.admit("calm", treatment="description", novelty=0.0)
    book.run_through(calm)
    told = summary(book, strange=3).strangest
    assert [(episode.kind, episode.label) for episode in told] == [
        ("joint_current", "stop"),
        ("joint_current", "none"),
        ("calm", ""),
    ]
    assert told[0].label_probability == pytest.approx(0.01)
    assert told[0].surprise_bits > told[1].surprise_bits > told[2].surprise_bits


def test_an_empty_journal_has_a_summary() -> None:
    told = summary(Pages([]))
    assert (told.received, told.coverage, told.completion, told.curve) == (0, 1.0, 1.0, ())
    assert told.accuracy.result.fraction is None


def test_the_interval_of_a_share_contains_it() -> None:
    for right, of in ((0, 5), (5, 5), (3, 7), (900, 1000)):
        found = share(right, of)
        assert found.fraction is not None
        assert found.low - 1e-6 <= found.fraction <= found.high + 1e-6


@settings(max_examples=150, deadline=None)
@given(any_lines())
def test_the_summary_never_raises_on_typed_lines_and_is_sound_json(lines: list[Line]) -> None:
    told = summary(Pages(lines))
    assert told.received == told.admitted + told.duplicate + told.refused
    assert 0.0 <= told.coverage <= 1.0
    assert 0.0 <= told.completion <= 1.0
    assert math.isfinite(told.duration_s)
    assert msgspec.json.decode(msgspec.json.encode(told), type=Summary) == told


def test_automatic_results_are_right_in_a_share_of_their_own_beside_the_deliberated() -> None:
    told = summary(full_book())
    assert (told.automatic_right.right, told.automatic_right.of) == (3, 3)
    assert (told.deliberated_right.right, told.deliberated_right.of) == (0, 1)
    assert told.automatic_right.low < 0.5


def test_outcomes_that_judged_nothing_are_counted_with_their_reason() -> None:
    book = full_book()
    book.witness("protective_stop")
    book.witness("protectve_stop")
    unknown = Outcome(id="o-x", topic="outcome", entity="*", label="none", at_ns=0, event="f" * 20)
    book.write(Witnessed(outcome=unknown))
    told = summary(book)
    assert (told.outcomes_witnessed, told.outcomes_matched) == (4, 1)
    assert told.outcomes_unmatched == {
        "no result that waited for it": 1,
        "the label 'protectve_stop', which no forecast knows": 1,
        "an event that does not exist": 1,
    }
