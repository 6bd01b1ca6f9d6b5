"""The world's faults, each with its defined behaviour: the table of docs/world_faults.md, row by row."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TypeVar

import pytest

from benchmarks.chaos.domain import WINDOW_S, Outside, domain, registry
from benchmarks.chaos.episode import right
from wakeful.contracts.bridge import Item
from wakeful.drivers.assembly import assemble
from wakeful.drivers.simulated import SimulatedDriver
from wakeful.drivers.source_clock import AGREEING, STEP_BACK_NS
from wakeful.facts.events import Draft, Undecodable
from wakeful.facts.evidence import Evidence, Outcome
from wakeful.facts.experience import Verdict
from wakeful.facts.lines import (
    Admitted,
    Answered,
    AnyRecord,
    Concluded,
    Created,
    Duplicate,
    Judged,
    Line,
    Moved,
    Noted,
    Witnessed,
)
from wakeful.facts.processes import State, Trigger
from wakeful.facts.settings import MindSettings
from wakeful.facts.time import LARGEST_NS, to_ns
from wakeful.journal import MemoryJournal
from wakeful.journal.audit import audit
from wakeful.scheduling.evidence import MAX_KEYS, MAX_PER_KEY
from wakeful.testing.faulty_reasoner import FaultyReasoner, Manners

DAY_S = 86_400.0
START_S = 1_000_000.0

R = TypeVar("R", bound=AnyRecord)


def ns(at_s: float) -> int:
    return to_ns(START_S + at_s)


def event(at_s: float, kind: str = "described", entity: str = "box", claimed_s: float | None = None) -> Draft:
    told = at_s if claimed_s is None else claimed_s
    return Draft(kind=kind, entity=entity, source="world", position=0, at_ns=ns(told), fields={"state": "odd"}, ordinal=0)


def reading(at_s: float, name: str = "e1", entity: str = "box", claimed_s: float | None = None) -> Evidence:
    return Evidence(id=name, topic="reading", key=entity, at_ns=ns(at_s if claimed_s is None else claimed_s))


def shown(at_s: float, label: str = "trouble", name: str = "o1", entity: str = "box") -> Outcome:
    return Outcome(id=name, topic="outcome", entity=entity, label=label, at_ns=ns(at_s))


class Told:
    """What a mind made of a source."""

    def __init__(self, *sources: Sequence[Item], read: Iterable[int] | None = None, afterwards_s: float = 200.0) -> None:
        self.journal = MemoryJournal()
        kernel, learner = assemble(domain(), MindSettings(step_s=0.1), registry=registry(Outside(lambda *_: "done")))
        good = FaultyReasoner(right, Manners(rates={}, latency_s=0.1), 0, lambda: 0.0)
        driver = SimulatedDriver(kernel, self.journal, good, learner)
        for number in read if read is not None else range(len(sources)):
            for _ in driver.run(f"world {number}", f"digest {number}", lambda after, n=number: sources[n][after + 1 :]):
                pass
        self.ended_ns = kernel.now_ns
        driver.put([], kernel.now_ns + to_ns(afterwards_s))
        self.open = len(kernel._scheduler.processes)
        driver.close()
        report = audit(self.journal)
        assert report.ok, report.first_offender
        assert self.open == 0, "a process is stranded"

    def all(self, kind: type[R]) -> list[R]:
        return [line.record for line in self.journal.lines() if isinstance(line.record, kind)]

    def line(self, kind: type[AnyRecord], number: int = 0) -> Line:
        return [line for line in self.journal.lines() if isinstance(line.record, kind)][number]

    def moved(self, trigger: Trigger) -> Line:
        """The first line by which a process was moved so."""
        lines = (line for line in self.journal.lines() if isinstance(line.record, Moved))
        return next(line for line in lines if getattr(line.record, "trigger", None) is trigger)

    def heard(self, process: int = 1) -> list[str]:
        """The ids of the evidence that a process was answered with."""
        found: list[str] = []
        for answered in self.all(Answered):
            if answered.process == process and answered.kind == "evidence":
                found += [part.split(b'"')[3].decode() for part in bytes(answered.value).split(b"},") if b'"id"' in part]
        return found


# --- evidence ---


def test_early_evidence_is_kept_and_delivered_when_it_is_asked_for() -> None:
    told = Told([reading(0.0), event(5.0, "waits")])
    assert told.heard() == ["e1"]


def test_evidence_older_than_its_retention_is_not_delivered() -> None:
    told = Told([reading(0.0), event(60.0, "waits")])
    assert told.heard() == []
    assert any(moved.trigger is Trigger.EXPIRE for moved in told.all(Moved))


def test_late_evidence_finds_the_wait_over_and_is_there_for_the_next_who_asks() -> None:
    told = Told([event(0.0, "waits"), reading(12.0), event(15.0, "waits")])
    assert told.heard(1) == []
    assert told.heard(2) == ["e1"]
    assert [concluded.mode for concluded in told.all(Concluded)] == ["delib", "delib"]


def test_evidence_that_comes_twice_counts_once() -> None:
    told = Told([event(0.0, "gathers"), reading(1.0), reading(1.5), reading(2.0)])
    assert told.heard() == ["e1"], "two readings were asked for, and one came three times"


def test_evidence_that_never_comes_ends_the_wait_at_its_limit() -> None:
    told = Told([event(0.0, "waits")])
    expired = next(
        line for line in told.journal.lines() if isinstance(line.record, Moved) and line.record.trigger is Trigger.EXPIRE
    )
    assert 8.0 <= (expired.at_ns - ns(0.0)) / 1e9 < 9.0
    assert told.all(Moved)[-1].after is State.COMPLETED


def test_evidence_for_a_process_that_is_long_gone_wakes_nobody_and_changes_nothing() -> None:
    told = Told([event(0.0, "waits"), reading(1.0), reading(5_000.0, "e2"), reading(5_001.0, "e3", "never met")])
    assert told.heard() == ["e1"]
    assert len(told.all(Created)) == 1


def test_a_flood_of_evidence_that_nobody_asks_for_is_bounded() -> None:
    flood = [reading(0.001 * n, f"e{n}") for n in range(MAX_PER_KEY + 50)]
    others = [reading(1.0, f"k{n}", f"key {n}") for n in range(MAX_KEYS + 50)]
    told = Told([*flood, *others])
    kept = {key: value for key, value in told.journal.state().items() if key.startswith("evidence/")}
    assert len(kept) <= MAX_KEYS
    again = Told([*flood, event(0.5, "waits")])
    assert again.heard() == [f"e{MAX_PER_KEY + 49}"], "the newest is delivered"


@pytest.mark.parametrize("claimed_s", [-DAY_S, -45.0, 4.0])
def test_evidence_whose_own_clock_is_off_is_delivered_all_the_same(claimed_s: float) -> None:
    told = Told([event(0.0, "waits"), *[event(0.5, entity=f"other {n}") for n in range(3)], reading(1.0, claimed_s=claimed_s)])
    assert told.heard() == ["e1"]


def test_evidence_of_a_second_recording_is_delivered_although_its_clock_began_elsewhere() -> None:
    told = Told([event(0.0)], [event(-5_000.0, "waits"), reading(-4_999.0)])
    assert told.heard(2) == ["e1"]


# --- outcomes ---


def verdicts(told: Told) -> list[tuple[str, Verdict]]:
    return [(judged.label, judged.verdict) for judged in told.all(Judged)]


def test_of_outcomes_that_contradict_one_another_the_first_in_source_time_decides_and_the_others_are_recorded() -> None:
    told = Told([event(0.0), shown(5.0, "trouble"), shown(6.0, "none", "o2"), shown(4.0, "worse", "o3")])
    assert verdicts(told) == [
        ("trouble", Verdict.SUPPORTED),
        ("none", Verdict.UNDECIDED),
        ("worse", Verdict.CONTRADICTED),
    ], "the one that came last lies first: it supersedes"
    assert len(told.all(Witnessed)) == 3


def test_of_contradicting_outcomes_of_the_same_instant_the_first_that_came_decides() -> None:
    told = Told([event(0.0), shown(5.0, "none"), shown(5.0, "trouble", "o2")])
    assert verdicts(told) == [("none", Verdict.CONTRADICTED), ("trouble", Verdict.UNDECIDED)]


def test_an_outcome_that_comes_twice_counts_once() -> None:
    told = Told([event(0.0), shown(5.0), shown(5.0), shown(5.0)])
    assert len(told.all(Witnessed)) == len(verdicts(told)) == 1


def test_an_outcome_that_comes_late_but_lies_within_the_window_supersedes_what_its_close_said() -> None:
    told = Told([event(0.0), event(WINDOW_S + 20.0, entity="other"), shown(5.0, "trouble")])
    assert ("none", Verdict.CONTRADICTED) in verdicts(told)
    assert verdicts(told)[1] == ("trouble", Verdict.SUPPORTED)


@pytest.mark.parametrize("at_s", [-1.0, 0.0, WINDOW_S + 0.1, 5_000.0, -DAY_S])
def test_an_outcome_before_its_event_or_after_the_window_is_recorded_and_judges_nothing(at_s: float) -> None:
    told = Told([event(0.0), shown(at_s), event(0.1, entity="other")], afterwards_s=100.0)
    assert len(told.all(Witnessed)) == 1
    assert all(judged.outcome == "" for judged in told.all(Judged))


def test_an_outcome_in_a_word_that_the_domain_does_not_know_is_recorded_and_judges_nothing() -> None:
    told = Told([event(0.0), shown(5.0, "unheard of")])
    assert len(told.all(Witnessed)) == 1
    assert all(judged.outcome == "" for judged in told.all(Judged))


# --- events, and the clock ---


def test_events_out_of_order_are_admitted_as_they_come_keep_their_own_time_and_kernel_time_stands_still() -> None:
    told = Told([event(10.0), event(8.0, entity="late"), event(11.0, entity="next")])
    stamps = [(admitted.event.stamp.source_ns, admitted.event.stamp.received_ns) for admitted in told.all(Admitted)]
    assert stamps == [(ns(10.0), ns(10.0)), (ns(8.0), ns(10.0)), (ns(11.0), ns(11.0))]
    assert not told.all(Noted)


def test_events_of_the_same_instant_are_covered_in_the_order_in_which_they_came() -> None:
    told = Told([event(1.0, entity=f"e{n}") for n in range(5)])
    assert [admitted.event.entity for admitted in told.all(Admitted)] == [f"e{n}" for n in range(5)]
    assert len({line.at_ns for line in told.journal.lines() if isinstance(line.record, Admitted)}) == 1


def test_the_same_event_read_again_is_a_duplicate() -> None:
    source = [event(0.0), event(1.0, entity="other")]
    told = Told(source, read=(0, 0))
    assert len(told.all(Admitted)) == len(told.all(Duplicate)) == 2


def test_one_event_from_the_future_takes_kernel_time_along_and_those_after_it_are_treated_without_waiting_for_it() -> None:
    told = Told(
        [event(0.0), event(1.0, entity="early", claimed_s=7_200.0), *[event(float(n), entity=f"e{n}") for n in range(2, 9)]]
    )
    arrivals = [line.at_ns for line in told.journal.lines() if isinstance(line.record, Admitted)]
    assert arrivals[1] == ns(7_200.0)
    assert arrivals[-1] - arrivals[1] == to_ns(8.0 - 2.0), "from the first of them on, kernel time goes on as their clock does"
    assert [noted.what for noted in told.all(Noted)] == ["clock set anew"]


def test_an_event_beyond_any_clock_is_refused_and_moves_no_time() -> None:
    source = [event(0.0), event(1.0), event(2.0, entity="other")]
    source[1] = Draft(kind="described", entity="box", source="world", position=0, at_ns=LARGEST_NS + 1)
    told = Told(source)
    assert len(told.all(Admitted)) == 2
    assert told.line(Admitted, 1).at_ns == ns(2.0)


def test_a_second_recording_that_begins_with_what_cannot_be_read_goes_on_from_where_kernel_time_stands() -> None:
    unread = Undecodable(source="world", position=0, reason="no JSON")
    told = Told([event(0.0)], [unread, event(50.0, entity="again"), event(51.0, entity="and again")])
    assert told.line(Admitted, 2).at_ns - told.line(Admitted, 1).at_ns == to_ns(1.0)
    assert told.line(Admitted, 2).at_ns <= ns(60.0)


def test_one_message_that_is_two_hours_late_sets_no_clock() -> None:
    told = Told([event(0.0), event(1.0, claimed_s=-7_200.0), *[event(float(n), entity=f"e{n}") for n in range(2, 6)]])
    assert not told.all(Noted)
    assert told.line(Admitted, 5).at_ns == ns(5.0)


def test_a_clock_set_back_by_a_day_stops_nothing() -> None:
    before = [event(0.0), event(1.0, "waits", entity="pump")]
    after: list[Item] = [event(2.0 - DAY_S, "toils", entity="shelf"), reading(3.0 - DAY_S, entity="pump")]
    after += [event(n - DAY_S, entity=f"e{n}") for n in (4.0, 5.0, 6.0)]
    after += [shown(7.0 - DAY_S, "trouble", entity="e4.0"), event(40.0 - DAY_S, entity="last")]
    told = Told([*before, *after])
    arrivals = [(line.at_ns - ns(0.0)) / 1e9 for line in told.journal.lines() if isinstance(line.record, Admitted)]
    # Kernel time goes on from where it stood; the first message under the new clock comes at that instant.
    assert arrivals == [0.0, 1.0, 1.0, 3.0, 4.0, 5.0, 39.0]
    assert [noted.what for noted in told.all(Noted)] == ["clock set anew"]
    assert told.heard(2) == ["e1"]
    toiled = next(line for line in told.journal.lines() if isinstance(line.record, Concluded) and line.record.process == 3)
    assert toiled.at_ns < ns(10.0), "who worked went on working"
    judged = {judged.process: (judged.label, judged.verdict) for judged in told.all(Judged) if judged.outcome}
    assert judged == {4: ("trouble", Verdict.SUPPORTED)}, "what came under the new clock is judged by it"


def test_a_clock_set_back_is_believed_only_when_the_next_messages_agree() -> None:
    back = [event(n - DAY_S, entity=f"back {n}") for n in range(AGREEING)]
    told = Told([event(0.0), *back, event(1.0, entity="as ever"), event(2.0, entity="as ever too")])
    assert not told.all(Noted), "one fewer than must agree"
    assert told.line(Admitted, AGREEING + 2).at_ns == ns(2.0)


def test_a_clock_set_forward_is_as_a_stretch_in_which_nothing_was_heard() -> None:
    told = Told([event(0.0, "waits"), event(DAY_S, entity="next day"), event(DAY_S + 1.0, entity="after it")])
    expired = next(
        line for line in told.journal.lines() if isinstance(line.record, Moved) and line.record.trigger is Trigger.EXPIRE
    )
    assert expired.at_ns < ns(10.0), "limits pass at their instants, not at the end of the stretch"
    assert told.line(Admitted, 2).at_ns == ns(DAY_S + 1.0)


def test_messages_out_of_order_by_less_than_a_minute_set_no_clock() -> None:
    step = STEP_BACK_NS / 1e9
    told = Told([event(100.0), *[event(100.0 - step + n, entity=f"e{n}") for n in range(6)]])
    assert not told.all(Noted)
