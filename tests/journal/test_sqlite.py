"""The SQLite journal: one transaction a commit, one writer, and clear refusals."""

from __future__ import annotations

import os
import stat
import subprocess
import sys
from pathlib import Path

import apsw
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from wakeful.contracts.journal import JournalError
from wakeful.facts.lines import Duplicate, Line, Noted
from wakeful.journal import MemoryJournal, open_journal
from wakeful.journal.schema import VERSION


def lines(start: int, count: int) -> list[Line]:
    return [Line(n, n * 10, Noted(what="test", detail=f"line {n}", process=n)) for n in range(start, start + count)]


def test_what_was_committed_is_there_when_it_is_opened_again(tmp_path: Path) -> None:
    path = tmp_path / "deep" / "mind.db"
    with open_journal(path) as journal:
        journal.commit(lines(1, 250), {"a": b"1", "b": b"2"}, {"w": b"weights"})
        journal.commit(lines(251, 1), {"a": None}, {})
    with open_journal(path) as journal:
        assert journal.last == 251
        assert list(journal.lines()) == lines(1, 251)
        assert list(journal.lines(after=249)) == lines(250, 2)
        assert journal.state() == {"b": b"2"}
        assert journal.blob("w") == b"weights"


def test_a_gap_in_the_positions_is_refused_and_nothing_of_it_is_kept(tmp_path: Path) -> None:
    with open_journal(tmp_path / "mind.db") as journal:
        journal.commit(lines(1, 2), {}, {})
        with pytest.raises(JournalError, match="does not follow 2"):
            journal.commit(lines(4, 1), {"a": b"1"}, {})
        assert (journal.last, journal.state()) == (2, {})


def test_lines_are_found_by_event_process_and_kind(tmp_path: Path) -> None:
    with open_journal(tmp_path / "mind.db") as journal:
        journal.commit([*lines(1, 3), Line(4, 40, Duplicate(event="abc", source="s", position=9))], {}, {})
        assert [line.position for line in journal.lines_of(process=2)] == [2]
        assert [line.position for line in journal.lines_of(event="abc")] == [4]
        assert [line.position for line in journal.lines_of(kinds=("duplicate", "noted"))] == [1, 2, 3, 4]


def test_only_its_owner_may_read_it(tmp_path: Path) -> None:
    with open_journal(tmp_path / "mind.db") as journal:
        journal.commit(lines(1, 1), {}, {})
        for file in tmp_path.iterdir():
            assert stat.S_IMODE(file.stat().st_mode) == 0o600, file


def test_a_second_writer_is_refused_with_the_first_ones_pid(tmp_path: Path) -> None:
    path = tmp_path / "mind.db"
    with open_journal(path):
        code = "import sys, pathlib; from wakeful.journal import open_journal; open_journal(pathlib.Path(sys.argv[1]))"
        second = subprocess.run([sys.executable, "-c", code, str(path)], capture_output=True, text=True, check=False)
    assert second.returncode != 0
    assert f"is being written by process {os.getpid()}" in second.stderr


def test_a_reader_may_look_beside_the_writer(tmp_path: Path) -> None:
    path = tmp_path / "mind.db"
    with open_journal(path) as journal:
        journal.commit(lines(1, 3), {}, {})
        reader = open_journal(path, read_only=True)
        assert reader.last == 3
        with pytest.raises(JournalError):
            reader.commit(lines(4, 1), {}, {})
        reader.close()


@pytest.mark.parametrize(
    ("content", "says"),
    [(b"not a database at all, just text. " * 40, "cannot be opened as a journal"), (b"", "is empty")],
)
def test_what_is_no_journal_is_refused_in_one_sentence(tmp_path: Path, content: bytes, says: str) -> None:
    path = tmp_path / "mind.db"
    path.write_bytes(content)
    with pytest.raises(JournalError, match=says):
        open_journal(path, read_only=True)


def test_somebody_elses_database_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "other.db"
    other = apsw.Connection(str(path))
    other.execute("CREATE TABLE t(x)")
    other.close()
    with pytest.raises(JournalError, match="not a wakeful journal"):
        open_journal(path)


def test_a_newer_schema_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "mind.db"
    open_journal(path).close()
    newer = apsw.Connection(str(path))
    newer.execute(f"PRAGMA user_version={VERSION + 1}")
    newer.close()
    with pytest.raises(JournalError, match="install the newer wakeful"):
        open_journal(path)


def test_a_missing_journal_says_how_to_make_one(tmp_path: Path) -> None:
    with pytest.raises(JournalError, match="wakeful run --journal"):
        open_journal(tmp_path / "none.db", read_only=True)


def test_a_place_that_cannot_be_written_is_named(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(JournalError, match="cannot be written"):
        open_journal(tmp_path / "file" / "mind.db")


@settings(max_examples=25, deadline=None)
@given(st.lists(st.tuples(st.integers(0, 130), st.dictionaries(st.sampled_from("abc"), st.none() | st.binary(max_size=9)))))
def test_sqlite_and_memory_hold_the_same(tmp_path_factory: pytest.TempPathFactory, commits: list) -> None:
    path = tmp_path_factory.mktemp("journal") / "mind.db"
    memory = MemoryJournal()
    with open_journal(path, full_sync=False) as journal:
        for count, state in commits:
            rows = lines(journal.last + 1, count)
            journal.commit(rows, state, {})
            memory.commit(rows, state, {})
            assert (journal.last, journal.state()) == (memory.last, memory.state())
        assert list(journal.lines()) == list(memory.lines())
