"""The story of one event holds all that happened because of it."""

from __future__ import annotations

import pytest
from hypothesis import given, settings

from tests.journal.builder import Book, full_book
from tests.journal.strategies import any_lines
from tests.journal.test_audit import Pages
from wakeful.facts.lines import Answered, Asked, Line
from wakeful.journal.history import history
from wakeful.journal.story import NoSuchEvent, find_event, lineage, story


def test_the_story_of_a_contradicted_event_has_its_child_its_reopening_its_verdict_and_the_trust_it_cost() -> None:
    book = full_book()
    read = history(book)
    told = story(read, find_event(read, book.event_of(1)))
    assert [process.role for process in told.processes] == ["root", "child", "reopening"]
    root = told.processes[0]
    assert [line.record.kind for line in root.trail if isinstance(line.record, Asked)] == ["evidence", "deliberate", "treat"]
    assert [line.record.seq for line in root.trail if isinstance(line.record, Answered)] == [1, 2, 3]
    verdict = root.verdicts[0]
    assert verdict.judged.verdict == "contradicted"
    assert verdict.outcome is not None
    assert verdict.outcome.label == "protective_stop"
    assert told.processes[2].because == "the world contradicted it"
    assert [told.trusted.after for told in told.trust] == [0.6]
    assert told.duplicates == 1


def test_the_story_says_which_experiences_a_decision_rests_on_and_where_its_model_comes_from() -> None:
    book = full_book()
    read = history(book)
    auto = next(past for past, root in read.roots() if root.decision and root.decision.mode == "auto")
    told = story(read, auto)
    assert [memory.experience.id for memory in told.rests_on] == [1]
    assert told.rests_on[0].says == "joint_3: current left its band"
    assert [card.version for card in told.lineage] == [1]


def test_an_event_is_found_by_the_beginning_of_its_id() -> None:
    book = full_book()
    read = history(book)
    identity = book.event_of(1)
    assert find_event(read, identity[:8]).event.id == identity


def test_an_unknown_id_names_close_ones() -> None:
    book = full_book()
    read = history(book)
    identity = book.event_of(1)
    with pytest.raises(NoSuchEvent) as caught:
        find_event(read, identity[:6] + "zzzz")
    assert identity in caught.value.close


def test_an_ambiguous_prefix_names_the_candidates() -> None:
    book = Book()
    for _ in range(40):
        book.admit()
    read = history(book)
    firsts = [identity[0] for identity in read.events]
    prefix = next(letter for letter in firsts if firsts.count(letter) > 1)
    with pytest.raises(NoSuchEvent, match="events begin with") as caught:
        find_event(read, prefix)
    assert len(caught.value.close) >= 2


def test_the_lineage_goes_back_to_the_first_version() -> None:
    book = Book()
    book.run_through(book.admit())
    for training in (1, 2, 3):
        book.train(training, training - 1, training)
    assert [card.version for card in lineage(history(book), 3)] == [3, 2, 1]


@settings(max_examples=100, deadline=None)
@given(any_lines())
def test_a_story_can_be_told_of_any_event_of_any_typed_lines(lines: list[Line]) -> None:
    read = history(Pages(lines))
    for past in read.events.values():
        assert story(read, past).event is past.event
