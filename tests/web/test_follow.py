"""The journal is followed beside its writer and never written."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.journal.builder import Book
from tests.web.conftest import Browse, write
from wakeful.contracts.journal import JournalError
from wakeful.journal.sqlite import open_journal
from wakeful.web.follow import Followed


def test_what_a_running_writer_commits_is_seen_at_the_next_look(browse: Browse, tmp_path: Path) -> None:
    book = Book()
    with open_journal(tmp_path / "j.db") as writer:
        writer.commit(list(book.lines()), {}, {})
        client = browse(tmp_path / "j.db")
        assert "No event has been admitted yet." in client.get("/").text
        process = book.admit()
        writer.commit(list(book.lines(writer.last)), {}, {})
        assert book.event_of(process) in client.get("/").text
        book.run_through(process)
        writer.commit(list(book.lines(writer.last)), {}, {})
        assert "joint 3 runs warm" in client.get("/").text


def test_looking_changes_no_byte_of_the_journal(browse: Browse, journal: Path, book: Book) -> None:
    before = journal.read_bytes()
    client = browse(journal)
    client.get("/")
    client.get(f"/event/{book.event_of(1)}")
    assert journal.read_bytes() == before


def test_a_missing_journal_is_one_clear_error(tmp_path: Path) -> None:
    with pytest.raises(JournalError, match="there is no journal at"):
        Followed(tmp_path / "none.db")


def test_a_journal_that_goes_is_told_and_its_successor_is_read(browse: Browse, tmp_path: Path) -> None:
    path = tmp_path / "j.db"
    book = Book()
    book.admit("old_kind")
    write(book, path)
    client = browse(path)
    assert "old_kind" in client.get("/").text
    for file in tmp_path.glob("j.db*"):
        file.unlink()
    gone = client.get("/")
    assert gone.status_code == 503
    assert "has gone" in gone.text
    later = Book()
    later.admit("new_kind")
    write(later, path)
    text = client.get("/").text
    assert "new_kind" in text
    assert "old_kind" not in text
