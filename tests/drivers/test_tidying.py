"""Housekeeping from the drivers: it is done between commits, and where it can't be, the mind goes on."""

from __future__ import annotations

import asyncio
import logging
from pathlib import Path

import pytest

from tests.drivers.test_live import box, live
from wakeful import Mind
from wakeful.contracts.journal import JournalError
from wakeful.drivers.tidying import Tidying
from wakeful.facts.lines import Compacted
from wakeful.journal import MemoryJournal, SqliteJournal, open_journal
from wakeful.journal.audit import audit
from wakeful.journal.compaction import ages
from wakeful.journal.retention import Retention


class Damaged(MemoryJournal):
    """Cannot be tidied."""

    tried = 0

    def tidy(self, least_events: int = 0) -> bool:
        self.tried += 1
        raise JournalError("mind.db is damaged: line 7")


def test_what_cannot_be_tidied_is_said_once_and_left(caplog: pytest.LogCaptureFixture) -> None:
    journal = Damaged()
    tidying = Tidying(journal)
    with caplog.at_level(logging.WARNING, "wakeful.journal"):
        assert [tidying.turn() for _ in range(5)] == [False] * 5
    assert journal.tried == 1
    assert caplog.messages == ["mind.db is damaged: line 7; it grows until the next start"]


def test_a_defect_of_the_housekeeping_is_said_once_with_its_traceback_and_a_live_mind_goes_on(
    caplog: pytest.LogCaptureFixture,
) -> None:
    class Defect(MemoryJournal):
        tried = 0

        def tidy(self, least_events: int = 0) -> bool:
            self.tried += 1
            raise ZeroDivisionError("a defect")

    journal = Defect()

    async def main() -> list[str]:
        async with live(journal) as mind:
            return [(await mind.admit(box(f"box {number}"))).status for number in range(3)]

    with caplog.at_level(logging.ERROR, "wakeful.journal"):
        assert asyncio.run(main()) == ["admitted"] * 3
    assert journal.tried == 1
    (said,) = caplog.records
    assert "has a defect" in said.message
    assert said.exc_info is not None
    assert said.exc_info[0] is ZeroDivisionError


def test_a_mind_gives_up_what_is_old_while_it_thinks_and_goes_on_after_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(ages, "_EVENTS", 10)
    small = Retention(events=30, least=20)

    def small_journal(path: Path) -> SqliteJournal:
        return open_journal(path, full_sync=False, retention=small)

    monkeypatch.setattr("wakeful.drivers.inline.open_journal", small_journal)
    path = tmp_path / "mind.db"
    with Mind("service_robot", path) as mind:
        for number in range(120):
            fields = {"category": "item", "load": 0.5}
            assert mind.admit("object", f"item-{number % 7}", fields, at_ns=number * 10**11).status == "admitted"
    with Mind("service_robot", path) as mind:
        assert mind.admit("object", "item-1", {"category": "item", "load": 0.5}, at_ns=10**14).status == "admitted"
    with open_journal(path, read_only=True) as journal:
        gone = [line.record for line in journal.lines() if isinstance(line.record, Compacted)]
        report = audit(journal)
    assert sum(record.admitted for record in gone) > 20
    assert report.ok, report.first_offender
