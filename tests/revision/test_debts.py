"""Debts: who is repaid, in which order, at which rate, and who is left alone."""

from __future__ import annotations

import itertools

from wakeful.facts.asking import Kind
from wakeful.facts.decisions import Decision, Gate
from wakeful.facts.lines import Answered, AnyRecord, Concluded, Created, Decided, Moved, Reopened
from wakeful.facts.overload import SHED
from wakeful.facts.processes import State, Trigger
from wakeful.facts.time import to_ns
from wakeful.facts.values import NOTHING
from wakeful.revision.debts import AT_ONCE, LONGEST_PAUSE_S, TRIES, Debts

PAUSE_S, EVERY_S = 60.0, 1.0


class Story:
    """Tells debts what happens, and repays them when they are due."""

    def __init__(self) -> None:
        self.debts = Debts(PAUSE_S, EVERY_S)
        self.records: list[tuple[AnyRecord, int]] = []
        self.now_ns = 0
        self.last = 0
        self.event_of: dict[int, str] = {}

    def tell(self, *records: AnyRecord) -> None:
        for record in records:
            self.records.append((record, self.now_ns))
            self.debts.apply(record, self.now_ns)

    def meets(self, event: str, criticality: int = 0) -> int:
        self.last += 1
        self.event_of[self.last] = event
        self.tell(Created(process=self.last, event=event, treatment="t", criticality=criticality))
        return self.last

    def asks(self, process: int, answered: bool, fails: bool = False) -> None:
        """The process asks the reasoner and concludes: as it wanted, or provisionally."""
        error = "" if answered else "connection refused"
        mode = "delib" if answered and not fails else "fallback"
        self.tell(
            Answered(process=process, seq=1, kind=Kind.DELIBERATE, key="treatment", error=error),
            Concluded(process=process, event=self.event_of[process], treatment="t", mode=mode, result=NOTHING),
            Moved(process=process, before=State.ACTIVE, trigger=Trigger.RESOLVE, after=State.COMPLETED),
        )

    def refused(self, event: str, criticality: int = 0) -> None:
        self.asks(self.meets(event, criticality), answered=False)

    def after(self, seconds: float) -> None:
        self.now_ns += to_ns(seconds)

    def repays(self) -> int:
        """Go on to the next repayment and begin it; returns its process."""
        due_ns = self.debts.next_due_ns()
        assert due_ns is not None
        self.now_ns = max(self.now_ns, due_ns)
        debt = self.debts.due(self.now_ns)
        assert debt is not None
        process = self.last + 1
        self.tell(Reopened(process=process, reopens=debt.process, event=debt.event, because=""))
        assert self.meets(debt.event, debt.criticality) == process
        return process


def test_who_was_refused_is_owed_and_who_was_answered_is_not() -> None:
    story = Story()
    story.asks(story.meets("answered"), answered=True)
    assert story.debts.next_due_ns() is None
    story.refused("refused")
    assert len(story.debts) == 1
    assert story.debts.next_due_ns() == to_ns(PAUSE_S)
    assert story.debts.due(to_ns(PAUSE_S) - 1) is None


def test_the_most_critical_is_repaid_first_and_then_the_oldest() -> None:
    story = Story()
    for event, criticality in (("old", 1), ("new", 1), ("critical", 3), ("routine", 0)):
        story.refused(event, criticality)
        story.after(1.0)
    order = []
    for _ in range(4):
        process = story.repays()
        order.append(story.event_of[process])
        story.asks(process, answered=True)
    assert order == ["critical", "old", "new", "routine"]
    assert len(story.debts) == 0
    assert story.debts.next_due_ns() is None


def test_while_the_reasoner_is_down_it_is_asked_once_after_pauses_that_double_up_to_an_hour() -> None:
    story = Story()
    story.refused("first", 3)
    story.refused("second")
    began_s, asked = [], []
    for _ in range(9):
        process = story.repays()
        began_s.append(round(story.now_ns / 1e9))
        asked.append(story.event_of[process])
        assert story.debts.next_due_ns() is None, "one question at a time"
        story.asks(process, answered=False)
    pauses = [later - earlier for earlier, later in itertools.pairwise(began_s)]
    assert pauses == [120, 240, 480, 960, 1920, LONGEST_PAUSE_S, LONGEST_PAUSE_S, LONGEST_PAUSE_S]
    assert asked[:4] == ["first", "second", "first", "second"], "by turns: one may be refused for a reason of its own"
    story.asks(story.meets("another"), answered=True)
    assert story.event_of[story.repays()] == "first", "a refusal by a reasoner that is down says nothing about the event"


def test_once_it_answers_at_most_four_are_repaid_at_once_and_one_a_second() -> None:
    story = Story()
    for number in range(8):
        story.refused(f"e{number}")
    story.asks(story.repays(), answered=True)
    began = story.now_ns
    under_way = [story.repays() for _ in range(AT_ONCE)]
    assert story.now_ns - began >= to_ns((AT_ONCE - 1) * EVERY_S)
    assert story.debts.next_due_ns() is None
    story.asks(under_way[0], answered=True)
    assert story.debts.next_due_ns() is not None


def test_an_answer_to_anybody_ends_the_pause() -> None:
    story = Story()
    story.refused("owed")
    story.after(5.0)
    story.asks(story.meets("another"), answered=True)
    assert story.debts.next_due_ns() == story.now_ns + to_ns(EVERY_S)


def test_a_question_that_is_always_refused_does_not_stand_before_the_others_and_is_left_at_last() -> None:
    story = Story()
    story.refused("poison", 3)
    story.refused("plain")
    served = []
    while story.debts.next_due_ns() is not None:
        story.asks(story.meets("another"), answered=True)
        process = story.repays()
        served.append(story.event_of[process])
        story.asks(process, answered=served[-1] != "poison")
    assert served == ["poison", "plain", *["poison"] * (TRIES - 1)]


def test_what_fails_for_another_reason_than_the_reasoner_is_not_tried_again() -> None:
    story = Story()
    story.refused("owed")
    story.asks(story.repays(), answered=True, fails=True)
    assert story.debts.next_due_ns() is None


def test_what_became_moot_or_was_cancelled_is_owed_nothing() -> None:
    story = Story()
    story.refused("owed")
    process = story.repays()
    story.tell(Moved(process=process, before=State.WAITING, trigger=Trigger.MOOT, after=State.COMPLETED))
    assert len(story.debts) == 0


def test_an_event_that_is_no_longer_in_memory_is_passed_over() -> None:
    story = Story()
    story.refused("gone", 3)
    story.refused("there")
    story.after(PAUSE_S)
    debt = story.debts.due(story.now_ns)
    assert debt is not None
    story.debts.forget(debt.event)
    assert story.event_of[story.repays()] == "there"


def test_with_a_pause_of_zero_nothing_is_repaid() -> None:
    story = Story()
    story.debts = Debts(0.0, EVERY_S)
    story.refused("owed", 3)
    assert story.debts.next_due_ns() is None


def test_the_same_records_give_the_same_debts_at_every_point() -> None:
    story = Story()
    for number in range(5):
        story.refused(f"e{number}", number % 4)
    for answered in (False, False, True, True, False, True):
        story.asks(story.repays(), answered=answered)
        again = Debts(PAUSE_S, EVERY_S)
        for record, at_ns in story.records:
            again.apply(record, at_ns)
        assert again.next_due_ns() == story.debts.next_due_ns()
        assert again.due(2**62) == story.debts.due(2**62)


def test_what_was_shed_under_overload_is_owed_too_and_repaid_when_there_was_no_more_of_that_for_a_pause() -> None:
    story = Story()
    for event, criticality in (("routine", 0), ("urgent", 2)):
        process = story.meets(event, criticality)
        story.tell(Decided(process=process, event=event, decision=provisional(f"{SHED}, 300 events wait")))
        story.tell(
            Concluded(process=process, event=event, treatment="t", mode="fallback", result=NOTHING),
            Moved(process=process, before=State.ACTIVE, trigger=Trigger.RESOLVE, after=State.COMPLETED),
        )
        story.after(10.0)
    story.asks(story.meets("another"), answered=True)
    assert story.debts.next_due_ns() == to_ns(10.0 + PAUSE_S), "an answer to another ends no overload"
    order = []
    for _ in range(2):
        process = story.repays()
        order.append(story.event_of[process])
        story.asks(process, answered=True)
    assert order == ["urgent", "routine"]


def test_what_is_provisional_because_it_is_unlike_anything_is_no_debt_of_the_reasoners() -> None:
    story = Story()
    process = story.meets("strange")
    story.tell(
        Decided(process=process, event="strange", decision=provisional("unlike anything experienced so far")),
        Concluded(process=process, event="strange", treatment="t", mode="fallback", result=NOTHING),
    )
    assert len(story.debts) == 0


def provisional(why: str) -> Decision:
    gate = Gate(confidence=0.0, threshold=1.0, novelty=0.0, novelty_limit=1.0, trust=1.0, trust_limit=0.0)
    return Decision(treatment="t", mode="fallback", confidence=0.5, candidates=(), reasons=(why, "a guideline"), gate=gate)
