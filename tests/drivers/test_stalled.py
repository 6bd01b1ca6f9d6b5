"""A full disk under a live mind: nothing is acknowledged or called, work goes on, and afterwards all of it is told."""

from __future__ import annotations

import asyncio
import logging
import stat
from collections.abc import Mapping, Sequence
from pathlib import Path

import pytest

from tests.drivers.test_live import box
from wakeful.contracts.journal import JournalError, JournalStalled
from wakeful.deliberation.guidelines import GuidelineReasoner
from wakeful.drivers.assembly import assemble
from wakeful.drivers.live import LiveDriver
from wakeful.drivers.stalled import Broken, Stall, StallMark
from wakeful.facts.asking import Question, Reply
from wakeful.facts.events import Observation, Undecodable
from wakeful.facts.evidence import Outcome
from wakeful.facts.inputs import Mark
from wakeful.facts.lines import GAP, Admitted, Asked, Noted, Refused
from wakeful.facts.overload import OverloadSettings
from wakeful.facts.packs import Entry
from wakeful.facts.settings import MindSettings
from wakeful.journal import MemoryJournal, SqliteJournal, open_journal
from wakeful.journal.audit import audit
from wakeful.testing.faulty_disk import FaultyDisk


class Counting(GuidelineReasoner):
    """Counts the calls that reach it."""

    made = 0

    async def answer(self, question: Question) -> Reply:
        self.made += 1
        return await super().answer(question)


class FullDisk(MemoryJournal):
    """Cannot be written once there is an event to write."""

    def commit(self, lines: Sequence[Entry], state: Mapping[str, bytes | None], blobs: Mapping[str, bytes]) -> None:
        if lines:
            raise JournalStalled("the disk is full")
        super().commit(lines, state, blobs)


def live(journal: SqliteJournal, reasoner: Counting | None = None, mark: StallMark | None = None) -> LiveDriver:
    kernel, learner = assemble("service_robot", MindSettings(step_s=0.0))
    thinks = reasoner or Counting(kernel.domain.spec)
    return LiveDriver(kernel, journal, thinks, learner, stall_mark=mark, retry_s=0.01)


def test_on_a_full_disk_nothing_is_acknowledged_or_called_and_later_all_of_it_is(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    kernel, _ = assemble("service_robot", MindSettings(step_s=0.0))
    reasoner = Counting(kernel.domain.spec)
    path = tmp_path / "mind.db"

    async def main(disk: FaultyDisk, journal: SqliteJournal) -> None:
        async with live(journal, reasoner) as mind:
            first = await mind.admit(box("kept"))
            assert first.status == "admitted"
            while mind.busy:
                await asyncio.sleep(0)
            made = reasoner.made
            disk.fail("broken")
            waiting = asyncio.create_task(mind.admit(box("held")))
            while not mind._stall.active:
                await asyncio.sleep(0)
            for number in range(3):
                receipt = await mind.admit(box(f"refused-{number}"))
                assert receipt.status == "refused"
                assert "cannot be written" in receipt.reason
            for _ in range(20):
                await asyncio.sleep(0)
            assert not waiting.done()
            assert reasoner.made == made
            disk.mend()
            receipt = await waiting
            assert receipt.status == "admitted"
            assert (await mind.admit(box("after"))).status == "admitted"
            while mind.busy:
                await asyncio.sleep(0)

    caplog.set_level(logging.WARNING, "wakeful.journal")
    with FaultyDisk() as disk, open_journal(path, vfs=disk.name) as journal:
        asyncio.run(main(disk, journal))
        report = audit(journal)
        records = [line.record for line in journal.lines()]
    assert report.ok, report.first_offender
    assert {record.event.entity for record in records if isinstance(record, Admitted)} == {"kept", "held", "after"}
    refused = [record for record in records if isinstance(record, Refused)]
    assert len(refused) == 3
    assert all("the journal cannot be written" in record.reason for record in refused)
    assert reasoner.made == sum(isinstance(record, Asked) and record.kind == "deliberate" for record in records)
    assert sum("treatments work on" in message for message in caplog.messages) == 1
    assert sum("3 offers were refused" in message for message in caplog.messages) == 1


def test_a_mind_that_is_closed_meanwhile_fails_what_waits_and_has_written_nothing(tmp_path: Path) -> None:
    path = tmp_path / "mind.db"

    async def main(disk: FaultyDisk, journal: SqliteJournal) -> None:
        async with live(journal) as mind:
            await mind.admit(box("kept"))
            disk.fail("broken")
            waiting = asyncio.create_task(mind.admit(box("lost")))
            while not mind._stall.active:
                await asyncio.sleep(0)
        with pytest.raises(JournalError, match="could not be written"):
            await waiting

    with FaultyDisk() as disk:
        journal = open_journal(path, vfs=disk.name)
        asyncio.run(main(disk, journal))
        disk.mend()
        journal.close()
    with open_journal(path) as journal:
        admitted = [line.record.event.entity for line in journal.lines() if isinstance(line.record, Admitted)]
    assert admitted == ["kept"]


def test_while_nothing_can_be_written_batches_are_refused_and_counted_and_what_has_no_receipt_stays_with_its_owner(
    tmp_path: Path,
) -> None:
    path = tmp_path / "mind.db"
    seen = Outcome(id="o", topic="outcome", entity="held", label="none", at_ns=1_700_000_001_000_000_000)

    async def main(disk: FaultyDisk, journal: SqliteJournal) -> None:
        async with live(journal) as mind, asyncio.timeout(20.0):
            await mind.admit(box("kept"))
            disk.fail("broken")
            waiting = asyncio.create_task(mind.admit(box("held")))
            while not mind._stall.active:
                await asyncio.sleep(0)
            receipts = await mind.admit_many([box("many-1"), box("many-2")])
            receipts += await mind.take_many([box("many-3")])
            assert [receipt.status for receipt in receipts] == ["refused"] * 3
            assert all("cannot be written" in receipt.reason for receipt in receipts)
            with pytest.raises(JournalStalled, match="nothing of this was taken"):
                await mind.take_many([box("with it"), seen])
            with pytest.raises(JournalStalled):
                await mind.tell(seen)
            with pytest.raises(JournalStalled):
                await mind.observe(Observation(topic="t", source="", position=0, at_ns=1, values={}))
            assert not mind._pump.waiting
            disk.mend()
            assert (await waiting).status == "admitted"
            await mind.take_many([box("with it"), seen])
            position = mind._position
        state = mind.kernel.source("live")
        assert state is not None
        assert state.cursor == position

    with FaultyDisk() as disk, open_journal(path, vfs=disk.name) as journal:
        asyncio.run(main(disk, journal))
        report = audit(journal)
        records = [line.record for line in journal.lines()]
    assert report.ok, report.first_offender
    assert {record.event.entity for record in records if isinstance(record, Admitted)} == {"kept", "held", "with it"}
    assert sum(isinstance(record, Refused) for record in records) == 3


def test_whoever_waits_for_room_when_writing_fails_is_refused_and_not_held() -> None:
    async def main() -> list[str]:
        kernel, learner = assemble("service_robot", MindSettings(step_s=0.0, overload=OverloadSettings(refuse_backlog=1)))
        async with LiveDriver(kernel, FullDisk(), Counting(kernel.domain.spec), learner, retry_s=0.01) as mind:
            held = asyncio.create_task(mind.admit(box("held")))
            offered = [asyncio.create_task(mind.admit(box(f"box {number}"))) for number in range(3)]
            async with asyncio.timeout(20.0):
                receipts = await asyncio.gather(*offered)
        with pytest.raises(JournalStalled):
            await held
        return [receipt.status for receipt in receipts]

    assert asyncio.run(main()) == ["refused"] * 3


def test_more_than_can_be_held_to_be_recorded_stays_with_its_owner(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr("wakeful.drivers.stalled.HELD_REFUSALS", 2)
    stall = Stall("live", lambda: 0, None)
    stall.begin("full")
    assert stall.has_room(2)
    stall.refuse(1, "object")
    assert not stall.has_room(2)
    with pytest.raises(JournalStalled, match="full; nothing of this was taken"):
        stall.turn_away(2)
    assert len(stall.over()) == 2
    assert "1 offers were refused, 2 turned away" in caplog.text


def test_a_crash_while_nothing_could_be_written_is_told_as_a_gap(tmp_path: Path) -> None:
    path = tmp_path / "mind.db"
    open_journal(path).close()
    mark = StallMark(path)
    assert stat.S_IMODE((tmp_path / "mind.db.stall").stat().st_mode) == 0o600
    stall = Stall("live", lambda: 77, mark)
    stall.begin("the disk is full")
    stall.refuse(4, "object")
    assert StallMark(path).before == Broken(77, 1)  # the process was killed here

    mark = StallMark(path)
    mark.before = Broken(77, 1)

    async def main() -> None:
        with open_journal(path) as journal:
            async with live(journal, mark=mark) as mind:
                await mind.admit(box("next"))

    asyncio.run(main())
    with open_journal(path, read_only=True) as journal:
        noted = [line.record for line in journal.lines() if isinstance(line.record, Noted)]
    assert [(record.what, record.source) for record in noted] == [(GAP, "live")]
    assert "from 77 ns to the end of that run; 1 refused" in noted[0].detail
    assert not (tmp_path / "mind.db.stall").exists()


def test_what_was_refused_is_handed_over_once(caplog: pytest.LogCaptureFixture) -> None:
    stall = Stall("live", lambda: 0, None)
    assert stall.over() == []
    stall.begin("full")
    stall.begin("full")
    reason = stall.refuse(7, "object")
    assert stall.active
    assert stall.over() == [
        Undecodable(source="live", position=7, reason=reason, excerpt="object"),
        Mark(source="live", position=7),
    ]
    assert (stall.active, stall.over()) == (False, [])
    assert len([record for record in caplog.records if record.levelno == logging.ERROR]) == 1


def test_a_mark_that_says_nothing_is_no_crash(tmp_path: Path) -> None:
    (tmp_path / "mind.db.stall").write_bytes(b"  \x00 nonsense")
    assert StallMark(tmp_path / "mind.db").before is None
