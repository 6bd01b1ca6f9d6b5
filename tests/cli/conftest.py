"""A journal on disk with something of everything, and a way to call the command line."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from tests.journal.builder import Book, full_book
from wakeful.cli.main import main
from wakeful.facts.lines import Line
from wakeful.journal.sqlite import open_journal

Wakeful = Callable[..., Result]


def written(lines: list[Line], path: Path, blobs: Mapping[str, bytes] | None = None) -> Path:
    """The lines as a journal file."""
    with open_journal(path) as journal:
        journal.commit(lines, {}, blobs or {})
    return path


@pytest.fixture
def book() -> Book:
    return full_book()


@pytest.fixture
def journal(book: Book, tmp_path: Path) -> Path:
    return written(list(book.lines()), tmp_path / "journal.db", book.blobs)


@pytest.fixture
def wakeful(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Wakeful:
    """Calls `wakeful` with arguments, in a state directory of its own."""
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))

    def call(*arguments: object, **settings: object) -> Result:
        return CliRunner().invoke(main, [str(argument) for argument in arguments], **settings)  # type: ignore[arg-type]

    return call
