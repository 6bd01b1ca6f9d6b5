"""A page over a journal on disk, and a client that asks it without a network."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from starlette.testclient import TestClient

from tests.journal.builder import Book, full_book
from wakeful.journal.sqlite import open_journal
from wakeful.web.app import page
from wakeful.web.follow import Followed

Browse = Callable[..., TestClient]


def write(book: Book, path: Path) -> Path:
    """The book's lines that the file does not have yet, committed."""
    with open_journal(path) as journal:
        journal.commit(list(book.lines(journal.last)), {}, book.blobs)
    return path


@pytest.fixture
def book() -> Book:
    return full_book()


@pytest.fixture
def journal(book: Book, tmp_path: Path) -> Path:
    return write(book, tmp_path / "journal.db")


@pytest.fixture
def browse() -> Iterator[Browse]:
    """Makes a client of a page over a journal; settings go to ``wakeful.web.app.page``."""
    opened: list[Followed] = []

    def make(path: Path, **settings: object) -> TestClient:
        followed = Followed(path)
        opened.append(followed)
        return TestClient(page(followed, **settings), base_url="http://127.0.0.1:8765")  # type: ignore[arg-type]

    yield make
    for followed in opened:
        followed.close()
