"""`wakeful compact` and `wakeful backup`: what is old is given up at once, and a copy is a journal."""

from __future__ import annotations

import stat
from pathlib import Path

import pytest

from tests.cli.conftest import Wakeful
from tests.journal.builder import Book
from wakeful.journal import open_journal
from wakeful.journal.audit import audit
from wakeful.journal.compaction import ages


@pytest.fixture
def long(tmp_path: Path) -> Path:
    book = Book()
    for _ in range(120):
        process = book.admit()
        book.run_through(process)
        book.wait(31)
        book.judge(process, "none", "none")
    path = tmp_path / "long.db"
    with open_journal(path, full_sync=False) as journal:
        for start in range(0, len(book.written), 50):
            journal.commit(book.written[start : start + 50], {}, {})
    return path


def test_what_is_old_is_given_up_and_said(wakeful: Wakeful, long: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ages, "_EVENTS", 10)
    result = wakeful("compact", "--journal", long, "--events", 40, "--least", 10)
    assert result.exit_code == 0, result.output
    assert "MB before" in result.output
    events = int(result.output.split("given up so far: ")[1].split(" events")[0])
    assert 60 <= events <= 80
    with open_journal(long, read_only=True) as journal:
        assert audit(journal).ok
    assert f"; {events} older events given up," in wakeful("status", "--journal", long).output
    exported = wakeful("export", "--journal", long).stdout
    assert '"is":"compacted","first":' in exported


def test_nothing_is_given_up_within_the_defaults(wakeful: Wakeful, long: Path) -> None:
    assert "nothing was given up so far" in wakeful("compact", "--journal", long).output


def test_a_backup_is_the_same_journal_for_its_owner_alone(wakeful: Wakeful, long: Path, tmp_path: Path) -> None:
    copy = tmp_path / "copy.db"
    with open_journal(long):  # somebody is writing it
        assert wakeful("backup", copy, "--journal", long).exit_code == 0
    assert stat.S_IMODE(copy.stat().st_mode) == 0o600
    with open_journal(long, read_only=True) as before, open_journal(copy, read_only=True) as after:
        assert list(after.lines()) == list(before.lines())


def test_a_backup_never_writes_over_a_file(wakeful: Wakeful, long: Path) -> None:
    result = wakeful("backup", long, "--journal", long)
    assert result.exit_code == 1
    assert "exists" in result.output
