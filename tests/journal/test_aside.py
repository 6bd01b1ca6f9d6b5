"""Where parked processes are put away."""

from __future__ import annotations

from pathlib import Path

import pytest

from wakeful.contracts.aside import AsideFull
from wakeful.journal.aside import AsideFile


def test_what_is_put_away_is_taken_back_once() -> None:
    with AsideFile() as aside:
        aside.put(3, b"three")
        aside.put(4, b"four")
        assert aside.take(3) == b"three"
        assert aside.take(4) == b"four"
        with pytest.raises(KeyError):
            aside.take(3)


def test_the_newest_bytes_of_a_process_count() -> None:
    with AsideFile() as aside:
        aside.put(3, b"old")
        aside.put(3, b"new")
        assert aside.take(3) == b"new"


def test_it_leaves_nothing_behind_and_nothing_that_others_could_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SQLITE_TMPDIR", str(tmp_path))
    with AsideFile() as aside:
        for process in range(3_000):
            aside.put(process, b"x" * 2_000)  # more than stays in memory
        assert list(tmp_path.iterdir()) == []
        assert aside.take(17) == b"x" * 2_000
    assert list(tmp_path.iterdir()) == []


def test_a_folder_without_room_is_said_and_loses_nothing() -> None:
    aside = AsideFile()
    aside.put(1, b"kept")
    aside._opened().execute("PRAGMA max_page_count = 8")

    def fill() -> None:
        for process in range(2, 200):
            aside.put(process, b"x" * 4_000)

    with pytest.raises(AsideFull, match="parked"):
        fill()
    assert aside.take(1) == b"kept"
