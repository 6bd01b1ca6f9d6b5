"""The virtual-time driver: one source, one journal, whatever happens in between."""

from __future__ import annotations

import itertools
from collections import Counter
from collections.abc import Iterable

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from wakeful.contracts.bridge import Item
from wakeful.deliberation.guidelines import GuidelineReasoner
from wakeful.drivers.assembly import assemble
from wakeful.drivers.simulated import SimulatedDriver
from wakeful.facts.events import Undecodable
from wakeful.facts.lines import (
    Admitted,
    AnyRecord,
    Created,
    Decided,
    Duplicate,
    Judged,
    Published,
    Refused,
    TrainingAsked,
)
from wakeful.facts.settings import MindSettings
from wakeful.journal import MemoryJournal
from wakeful.journal.export import exported

ITEMS = 4000


def sightings(after: int, count: int = ITEMS) -> Iterable[Item]:
    source = assemble("service_robot")[0].domain.simulate(0)
    assert source is not None
    return itertools.islice(source, after + 1, count)


def driver(journal: MemoryJournal) -> SimulatedDriver:
    kernel, learner = assemble("service_robot", MindSettings())
    return SimulatedDriver(kernel, journal, GuidelineReasoner(kernel.domain.spec), learner)


def run(kills: Iterable[int] = (), journal: MemoryJournal | None = None) -> MemoryJournal:
    """Run to the end; at each position in ``kills`` what was not committed is lost, and a new driver goes on."""
    kept = journal if journal is not None else MemoryJournal()
    for kill in (*kills, None):
        one = driver(kept)
        reading = one.run("sightings", "digest", sightings)
        for position in reading:
            if position == kill:
                one._commit = lambda: None  # type: ignore[method-assign]  # killed: nothing more reaches the journal
                break
        reading.close()
        one.close()
        if kill is None or kept.last == 0:
            continue
    return kept


def records(journal: MemoryJournal) -> list[tuple[int, AnyRecord]]:
    """Everything but the records of going on."""
    return [(x.at_ns, x.record) for x in exported(journal, stable=True)]


@pytest.fixture(scope="module")
def undisturbed() -> MemoryJournal:
    return run()


def count(journal: MemoryJournal) -> Counter[type]:
    return Counter(type(line.record) for line in journal.lines())


def test_every_admitted_event_has_its_process_and_decision_at_once(undisturbed: MemoryJournal) -> None:
    lines = list(undisturbed.lines())
    admitted = [place for place, line in enumerate(lines) if isinstance(line.record, Admitted)]
    assert len(admitted) > 50
    for place in admitted:
        created, decided = lines[place + 1].record, lines[place + 2].record
        assert isinstance(created, Created)
        assert isinstance(decided, Decided)
        assert lines[place].at_ns == lines[place + 2].at_ns


def test_experience_makes_treatments_automatic() -> None:
    journal = MemoryJournal()
    one = driver(journal)
    for _ in one.run("sightings", "digest", lambda after: sightings(after, 16_000)):
        pass
    one.close()
    decided = [line for line in journal.lines() if isinstance(line.record, Decided)]
    first_auto = next(line.position for line in decided if line.record.decision.mode == "auto")
    accepted = [x for x in journal.lines() if isinstance(x.record, Published) and x.record.card.accepted]
    assert accepted[0].position < first_auto
    half = len(decided) // 2
    automatic = [sum(x.record.decision.mode == "auto" for x in part) for part in (decided[:half], decided[half:])]
    assert automatic[0] < automatic[1]
    assert count(journal)[Judged] > 0


@settings(max_examples=6, deadline=None)
@given(st.lists(st.integers(0, ITEMS - 1), min_size=1, max_size=4))
def test_a_killed_and_resumed_run_leaves_the_same_records(undisturbed: MemoryJournal, kills: list[int]) -> None:
    assert records(run(sorted(kills))) == records(undisturbed)


def test_a_kill_during_a_training_leaves_the_same_records(undisturbed: MemoryJournal) -> None:
    asked = next(line for line in undisturbed.lines() if isinstance(line.record, TrainingAsked))
    source_ns = [(item.position, item.at_ns) for item in sightings(-1)]  # type: ignore[union-attr]
    during = next(position for position, at_ns in source_ns if at_ns > asked.at_ns)
    disturbed = run([during])
    assert records(disturbed) == records(undisturbed)


def test_a_second_reading_admits_nothing_twice(undisturbed: MemoryJournal) -> None:
    again = run(journal=run())
    first, both = count(undisturbed), count(again)
    assert both[Admitted] == first[Admitted]
    assert both[Created] == first[Created]
    assert both[Duplicate] == first[Admitted] + first[Duplicate] * 2


def test_what_cannot_be_decoded_is_refused_and_nothing_else_is_lost() -> None:
    def spoilt(after: int) -> Iterable[Item]:
        for item in sightings(after, 1500):
            yield Undecodable(source="s", position=item.position, reason="garbage") if item.position % 7 == 3 else item  # type: ignore[union-attr]

    journal = MemoryJournal()
    one = driver(journal)
    for _ in one.run("spoilt", "digest", spoilt):
        pass
    one.close()
    found = count(journal)
    assert found[Refused] == len([n for n in range(1500) if n % 7 == 3])
    roots = [line for line in journal.lines() if isinstance(line.record, Created) and not line.record.parent]
    assert found[Admitted] == len(roots) > 0


@pytest.mark.parametrize("at_once", [2, 7, 64, 5000])
def test_items_that_are_fed_together_give_the_same_journal(at_once: int) -> None:
    exports = []
    for together in (1, at_once):
        journal = MemoryJournal()
        one = driver(journal)
        assert list(one.run("line", "digest", sightings, at_once=together)) == list(range(ITEMS))
        one.close()
        exports.append(list(exported(journal)))
    assert exports[0] == exports[1]
