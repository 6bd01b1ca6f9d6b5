"""The disk under a journal: whatever it does, what was acknowledged is there, what was not has left nothing, or it is said."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import pytest

from wakeful.contracts.journal import JournalError, JournalStalled
from wakeful.facts.lines import LOST_END, Line, Noted
from wakeful.journal import SqliteJournal, open_journal
from wakeful.journal.audit import audit
from wakeful.testing.faulty_disk import FaultyDisk, Survival

PER_COMMIT = 5


@pytest.fixture
def disk() -> Iterator[FaultyDisk]:
    with FaultyDisk(seed=3) as faulty:
        yield faulty


def group(journal: SqliteJournal) -> list[Line]:
    return [
        Line(position, position, Noted(what="test", detail=f"line {position} " + "x" * 300))
        for position in range(journal.last + 1, journal.last + 1 + PER_COMMIT)
    ]


def commit(journal: SqliteJournal, times: int = 1) -> None:
    for _ in range(times):
        journal.commit(group(journal), {"cursor": str(journal.last).encode()}, {})


def whole(path: Path, acknowledged: int) -> int:
    """The journal is sound, holds at least what was acknowledged, and ends with a whole commit; returns its last position."""
    with open_journal(path) as journal:
        lines = list(journal.lines())
        assert [line.position for line in lines] == list(range(1, journal.last + 1))
        assert journal.last >= acknowledged
        told = [isinstance(line.record, Noted) and line.record.what == LOST_END for line in lines]
        written = journal.last - sum(told)
        assert written % PER_COMMIT == 0
        checks = audit(journal).checks
        assert checks["readable"].ok
        assert checks["positions"].ok
        assert checks["whole"].ok
        assert journal.state().get("cursor", b"0") == str(max(0, written - PER_COMMIT)).encode()
        commit(journal)
        return written


@pytest.mark.parametrize("fault", ["full", "read-only", "broken"])
@pytest.mark.parametrize("after_writes", [0, 1, 2, 5])
def test_what_cannot_be_written_leaves_nothing_and_the_same_commit_may_be_tried_again(
    tmp_path: Path, disk: FaultyDisk, fault: str, after_writes: int
) -> None:
    path = tmp_path / "mind.db"
    with open_journal(path, vfs=disk.name) as journal:
        commit(journal, 3)
        disk.fail(fault, after_writes)  # type: ignore[arg-type]
        with pytest.raises(JournalStalled, match="nothing of this commit was kept"):
            commit(journal, times=20)
        kept, refused = journal.last, group(journal)
        assert len(list(journal.lines())) == kept
        disk.mend()
        journal.commit(refused, {"cursor": str(journal.last).encode()}, {})
        assert journal.last == kept + PER_COMMIT
    assert whole(path, kept + PER_COMMIT) == kept + PER_COMMIT


def test_a_slow_disk_is_waited_for_and_nothing_is_acknowledged_before_it_has_synced(tmp_path: Path) -> None:
    waited: list[float] = []
    with FaultyDisk(sleep=waited.append) as disk, open_journal(tmp_path / "mind.db", vfs=disk.name) as journal:
        disk.slow(0.25)
        commit(journal, 4)
        assert sum(waited) >= 4 * 0.25
        disk.slow(0.0)
    assert whole(tmp_path / "mind.db", 20) == 20


@pytest.mark.parametrize("survival", ["all", "none", "some"])
@pytest.mark.parametrize("seed", range(6))
def test_power_is_lost_in_the_middle_of_a_commit(tmp_path: Path, survival: Survival, seed: int) -> None:
    path = tmp_path / "mind.db"
    with FaultyDisk(seed) as disk:
        journal = open_journal(path, vfs=disk.name)
        commit(journal, 4 + seed)
        acknowledged = journal.last
        disk.fail("broken", after_writes=seed)  # the commit under way gets so far
        with suppress(JournalError):
            commit(journal)
            acknowledged = journal.last
        disk.cut_power()
        with suppress(JournalError):
            journal.close()
        disk.restore_power(survival)
    assert whole(path, acknowledged) in (acknowledged, acknowledged + PER_COMMIT)


def test_without_full_sync_a_killed_process_loses_nothing_but_power_may_take_the_newest_commits(tmp_path: Path) -> None:
    path = tmp_path / "mind.db"
    with FaultyDisk() as disk:
        journal = open_journal(path, vfs=disk.name, full_sync=False)
        commit(journal, 6)
        disk.cut_power()
        with suppress(JournalError):
            journal.close()
        disk.restore_power("none")
    assert whole(path, 0) < 30
    with FaultyDisk() as disk:
        journal = open_journal(tmp_path / "killed.db", vfs=disk.name, full_sync=False)
        commit(journal, 6)
        disk.cut_power()
        with suppress(JournalError):
            journal.close()
        disk.restore_power("all")  # the system lives, and writes what the process had handed over
    assert whole(tmp_path / "killed.db", 30) == 30


def _killed(path: Path, disk: FaultyDisk, commits: int) -> int:
    """A process that was killed: its write-ahead file is there, with its commits."""
    journal = open_journal(path, vfs=disk.name)
    commit(journal, commits)
    disk.cut_power()
    with suppress(JournalError):
        journal.close()
    disk.restore_power("all")
    return commits * PER_COMMIT


@pytest.mark.parametrize("lost_bytes", [1, 100, 512, 4096, 9000])
def test_a_torn_end_of_the_write_ahead_file_loses_whole_commits_only(tmp_path: Path, disk: FaultyDisk, lost_bytes: int) -> None:
    path = tmp_path / "mind.db"
    written = _killed(path, disk, 6)
    disk.tear(tmp_path / "mind.db-wal", lost_bytes)
    assert 0 < whole(path, 0) < written


def test_a_lost_write_ahead_file_leaves_the_journal_as_of_its_last_checkpoint_and_is_told_of(
    tmp_path: Path, disk: FaultyDisk, caplog: pytest.LogCaptureFixture
) -> None:
    path = tmp_path / "mind.db"
    with open_journal(path, vfs=disk.name) as journal:
        commit(journal, 2)  # closing makes a checkpoint
    journal = open_journal(path, vfs=disk.name)
    commit(journal, 3)
    disk.cut_power()
    with suppress(JournalError):
        journal.close()
    disk.restore_power("all")
    (tmp_path / "mind.db-wal").unlink()
    with caplog.at_level(logging.ERROR, "wakeful.journal"), open_journal(path) as journal:
        lines = list(journal.lines())
        assert audit(journal).ok
    assert len(lines) == 11
    assert isinstance(lines[-1].record, Noted)
    assert lines[-1].record.what == LOST_END
    assert "positions 11 to 25 had been committed and are gone" in caplog.text
    caplog.clear()
    with open_journal(path) as journal:
        assert journal.last == 11  # it is told once
    assert not caplog.text


def test_a_journal_that_is_made_anew_in_the_place_of_one_that_was_removed_has_lost_nothing(
    tmp_path: Path, disk: FaultyDisk
) -> None:
    path = tmp_path / "mind.db"
    with open_journal(path, vfs=disk.name) as journal:
        commit(journal, 2)
    path.unlink()
    with open_journal(path) as journal:
        assert journal.last == 0


def _says_so_or_reads(path: Path, before: list[Line]) -> bool:
    """Whether it was said that the file is damaged; if not, every line is as it was."""
    try:
        with open_journal(path, read_only=True) as journal:
            lines = list(journal.lines())
    except JournalError as error:
        return str(path) in str(error)
    assert lines == before
    return False


def test_bit_rot_is_an_error_with_its_place_or_changes_nothing_that_is_read(tmp_path: Path, disk: FaultyDisk) -> None:
    path = tmp_path / "mind.db"
    with open_journal(path, vfs=disk.name) as journal:
        commit(journal, 40)
        before = list(journal.lines())
    sound = path.read_bytes()
    found = 0
    for _ in range(60):
        path.write_bytes(sound)
        disk.rot(path, bits=2, after_byte=100)
        found += _says_so_or_reads(path, before)
    assert found > 30


def test_a_torn_last_page_of_the_file_itself_is_said(tmp_path: Path, disk: FaultyDisk) -> None:
    path = tmp_path / "mind.db"
    with open_journal(path, vfs=disk.name) as journal:
        commit(journal, 40)
    disk.tear(path, 6_000)
    with pytest.raises(JournalError, match=r"mind\.db"), open_journal(path, read_only=True) as journal:
        list(journal.lines())


def test_a_new_journal_outlives_a_loss_of_power_under_its_own_name(tmp_path: Path, disk: FaultyDisk) -> None:
    path = tmp_path / "mind.db"
    journal = open_journal(path, vfs=disk.name)
    commit(journal)
    disk.cut_power()
    with suppress(JournalError):
        journal.close()
    disk.restore_power("none")
    assert whole(path, PER_COMMIT) == PER_COMMIT
