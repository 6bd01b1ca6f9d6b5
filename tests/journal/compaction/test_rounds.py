"""How long a round of compaction lasts: the more is owed, and the more a commit brings."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.synthetic import Stream
from wakeful.drivers.tidying import Tidying
from wakeful.facts.packs import Covered, Pack
from wakeful.journal import SqliteJournal, open_journal
from wakeful.journal.audit import audit
from wakeful.journal.retention import KEEP_ALL, Retention

KEPT = 2_000
EVENTS = 10_000


def test_a_round_takes_no_more_steps_the_more_is_owed_for_ever(tmp_path: Path) -> None:
    stream = Stream(days=1.0, events=10_000, seed=0, open_one_in=20)
    steps: list[int] = []
    with open_journal(tmp_path / "mind.db", full_sync=False, retention=Retention(events=2_000, least=2_000)) as journal:
        journal.commit(stream.begin(), {}, {})
        for _ in range(10):
            for _ in range(10):
                journal.commit([entry for _ in range(100) for entry in stream.next()], {}, {})
            steps.append(0)
            while journal.tidy(500):
                steps[-1] += 1
        owed = [line for lines in stream.kept.values() for line in lines if line.position <= journal.compacted()]
        kept = {line.position: line for line in journal.lines() if line.position <= journal.compacted()}
        report = audit(journal)
    assert report.ok, report.first_offender
    assert len(owed) > 1_000
    assert all(kept.get(line.position) == line for line in owed)
    assert max(steps[5:]) <= 1.3 * max(steps[2:5])


def _commit(journal: SqliteJournal, stream: Stream, events: int) -> None:
    journal.commit([entry for _ in range(events) for entry in stream.next()], {}, {})


def _not_compacted(journal: SqliteJournal) -> int:
    """How many events lie after what was compacted; those in debt do not count."""
    return sum(isinstance(each, Pack) and isinstance(each.burst, Covered) for each in journal.entries(journal.compacted()))


@pytest.mark.parametrize(("events_per_commit", "open_one_in"), [(1, 20), (57, 20), (250, 2_000), (1_000, 20)])
def test_one_turn_a_commit_keeps_the_file_bounded_however_much_a_commit_brings(
    tmp_path: Path, events_per_commit: int, open_one_in: int
) -> None:
    stream = Stream(days=1.0, events=EVENTS, seed=0, open_one_in=open_one_in)
    path = tmp_path / "mind.db"
    boundaries: set[int] = set()
    size_bytes: list[int] = []
    with open_journal(path, full_sync=False, retention=Retention(events=KEPT, least=KEPT)) as journal:
        tidying = Tidying(journal)
        journal.commit(stream.begin(), {}, {})
        for _ in range(EVENTS // events_per_commit):
            _commit(journal, stream, events_per_commit)
            tidying.turn()
            boundaries.add(journal.compacted())
            size_bytes.append(path.stat().st_size)
        not_compacted = _not_compacted(journal)
        report = audit(journal)
    assert report.ok, report.first_offender
    assert len(boundaries) > 4
    # What is kept; less than a stretch of 1,024 and a commit that were too little for a round; as much again while one lasts.
    assert not_compacted <= KEPT + 2 * (1_024 + events_per_commit)
    half = len(size_bytes) // 2
    assert max(size_bytes[half:]) <= 1.25 * max(size_bytes[:half])


def test_a_journal_that_was_opened_again_full_catches_up_while_large_commits_come(tmp_path: Path) -> None:
    stream = Stream(days=1.0, events=EVENTS, seed=0)
    with open_journal(tmp_path / "mind.db", full_sync=False, retention=KEEP_ALL) as journal:
        journal.commit(stream.begin(), {}, {})
        for _ in range(5):
            _commit(journal, stream, 1_000)
    with open_journal(tmp_path / "mind.db", full_sync=False, retention=Retention(events=KEPT, least=KEPT)) as journal:
        tidying = Tidying(journal)
        for _ in range(5):
            _commit(journal, stream, 1_000)
            tidying.turn()
        assert _not_compacted(journal) <= KEPT + 2 * (1_024 + 1_000)
        assert audit(journal).ok
