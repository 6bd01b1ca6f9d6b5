"""How long a round of compaction lasts, the more is owed."""

from __future__ import annotations

from pathlib import Path

from benchmarks.synthetic import Stream
from wakeful.journal import open_journal
from wakeful.journal.audit import audit
from wakeful.journal.retention import Retention


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
