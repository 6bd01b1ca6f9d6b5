"""The live driver: durable before it is acknowledged, and the same kernel underneath."""

from __future__ import annotations

import asyncio
from collections.abc import Mapping, Sequence
from pathlib import Path

import msgspec
import pytest

from wakeful.contracts.journal import JournalError
from wakeful.deliberation.guidelines import GuidelineReasoner
from wakeful.drivers.assembly import assemble
from wakeful.drivers.inline import Mind, open_live
from wakeful.drivers.live import LiveDriver
from wakeful.facts.asking import Question, Reply
from wakeful.facts.events import Draft
from wakeful.facts.evidence import Outcome
from wakeful.facts.inputs import Act
from wakeful.facts.lines import Acted, Admitted, Answered, Asked, Concluded, Created, Decided, Judged, Line
from wakeful.facts.settings import MindSettings
from wakeful.journal import MemoryJournal, open_journal


def box(name: str = "box 7", **fields: str) -> Draft:
    found = {"category": "obstacle", "location": "edge", "state": "unstable", "route": "none", **fields}
    return Draft(kind="object", entity=name, source="", position=0, at_ns=1_700_000_000_000_000_000, fields=dict(found))


class Gatekeeper:
    """A reasoner that answers when the test opens the gate."""

    name = "gatekeeper"
    latency_s = 0.0

    def __init__(self) -> None:
        self.gate = asyncio.Event()
        self.asked = asyncio.Event()

    async def answer(self, question: Question) -> Reply:
        self.asked.set()
        await self.gate.wait()
        return Reply(choice=question.options[0], confidence=0.9, because=("the gate is open",), reasoner=self.name)


def live(journal: MemoryJournal, reasoner: object = None) -> LiveDriver:
    kernel, learner = assemble("service_robot", MindSettings(step_s=0.0))
    thinks = reasoner if reasoner is not None else GuidelineReasoner(kernel.domain.spec)
    return LiveDriver(kernel, journal, thinks, learner)  # type: ignore[arg-type]


def records(journal: MemoryJournal, kind: type) -> list:
    return [line.record for line in journal.lines() if isinstance(line.record, kind)]


def test_an_event_is_durable_when_its_admission_returns(tmp_path: Path) -> None:
    path = tmp_path / "mind.db"

    async def main() -> str:
        async with open_live("service_robot", path) as mind:
            receipt = await mind.admit(box())
            reader = open_journal(path, read_only=True)
            kinds = [type(line.record) for line in reader.lines_of(event=receipt.event)]
            reader.close()
            assert kinds[:3] == [Admitted, Created, Decided]
            return receipt.status

    assert asyncio.run(main()) == "admitted"


def test_many_admissions_at_once_share_commits_and_each_gets_its_own_receipt() -> None:
    class Counting(MemoryJournal):
        commits = 0

        def commit(self, lines: Sequence[Line], state: Mapping[str, bytes | None], blobs: Mapping[str, bytes]) -> None:
            type(self).commits += 1
            super().commit(lines, state, blobs)

    journal = Counting()

    async def main() -> list[str]:
        async with live(journal) as mind:
            receipts = await asyncio.gather(*(mind.admit(box(f"box {n}")) for n in range(50)))
            return [receipt.event for receipt in receipts]

    events = asyncio.run(main())
    assert len(set(events)) == 50
    assert [record.event.entity for record in records(journal, Admitted)] == [f"box {n}" for n in range(50)]
    assert Counting.commits < 50


def test_a_bad_event_is_refused_with_its_reason() -> None:
    async def main() -> str:
        async with live(MemoryJournal()) as mind:
            bad = msgspec.structs.replace(box(), fields={"load": float("nan")})
            receipt = await mind.admit(bad)
            assert receipt.status == "refused"
            return receipt.reason

    assert "numbers must be finite" in asyncio.run(main())


def test_others_go_on_while_one_waits_for_the_reasoner_and_an_open_call_survives_a_restart() -> None:
    journal = MemoryJournal()

    async def first() -> None:
        reasoner = Gatekeeper()
        async with live(journal, reasoner) as mind:
            await mind.admit(box("slow"))
            await reasoner.asked.wait()
            await mind.admit(box("next"))
        assert records(journal, Concluded) == []

    async def second() -> None:
        reasoner = Gatekeeper()
        reasoner.gate.set()
        async with live(journal, reasoner) as mind:
            slow, following = (record.event.id for record in records(journal, Admitted))
            await asyncio.gather(mind.concluded(slow), mind.concluded(following))

    asyncio.run(first())
    assert len(records(journal, Asked)) > 0
    asyncio.run(second())
    assert {record.event for record in records(journal, Concluded)} == {record.event.id for record in records(journal, Admitted)}
    answered = [(each.process, each.seq) for each in records(journal, Answered)]
    assert len(answered) == len(set(answered))


def test_an_outcome_is_judged_against_the_recorded_result() -> None:
    journal = MemoryJournal()

    async def main() -> None:
        async with live(journal) as mind:
            receipt = await mind.admit(box())
            if not records(journal, Concluded):
                await mind.concluded(receipt.event)
            outcome = Outcome(
                id="o1",
                topic="report",
                entity="*",
                label="intervention",
                at_ns=1_700_000_005_000_000_000,
                event=receipt.event,
                origin="person",
            )
            await mind.tell(outcome)
            await mind.tell(outcome)

    asyncio.run(main())
    assert len(records(journal, Judged)) == 1


def test_an_operators_cancel_is_recorded_with_who_and_why() -> None:
    journal = MemoryJournal()

    async def main() -> None:
        async with live(journal, Gatekeeper()) as mind:
            await mind.admit(box())
            await mind.tell(Act(who="ana", act="cancel", process=1, why="false alarm"))

    asyncio.run(main())
    assert records(journal, Acted) == [Acted(who="ana", act="cancel", process=1, why="false alarm")]


def test_an_event_that_cannot_be_written_is_not_acknowledged() -> None:
    class Full(MemoryJournal):
        full = False

        def commit(self, lines: Sequence[Line], state: Mapping[str, bytes | None], blobs: Mapping[str, bytes]) -> None:
            if self.full:
                raise JournalError("disk full")
            super().commit(lines, state, blobs)

    journal = Full()

    async def main() -> None:
        async with live(journal) as mind:
            await mind.admit(box("kept"))
            journal.full = True
            with pytest.raises(JournalError, match="disk full"):
                await mind.admit(box("lost"))
            with pytest.raises(JournalError, match="disk full"):
                await mind.admit(box("later"))

    asyncio.run(main())
    assert [record.event.entity for record in records(journal, Admitted)] == ["kept"]


def test_a_synchronous_program_gets_its_conclusion_at_once(tmp_path: Path) -> None:
    with Mind("service_robot", tmp_path / "mind.db") as mind:
        receipt = mind.admit("object", "box 7", {"category": "obstacle", "location": "edge", "state": "unstable"})
        concluded = mind.conclusion(receipt.event)
        assert concluded is not None
        assert mind.decision(receipt.event) is not None
        result = mind.result(receipt.event)
        assert result is not None
        assert "box 7" in result.says
        mind.outcome(receipt.event, "intervention")
        with pytest.raises(ValueError, match="use one of none, intervention"):
            mind.outcome(receipt.event, "explosion")
    with Mind("service_robot", tmp_path / "mind.db") as again:
        other = again.admit("object", "box 7", {"category": "obstacle", "location": "edge", "state": "unstable"})
        assert other.status == "admitted"
        assert other.event != receipt.event


def test_the_live_and_the_virtual_driver_decide_alike() -> None:
    drafts = [box(f"box {n}", state="unstable" if n % 3 else "normal") for n in range(12)]
    journal = MemoryJournal()

    async def main() -> None:
        async with live(journal) as mind:
            for draft in drafts:
                await mind.admit(draft)

    asyncio.run(main())
    with Mind("service_robot") as mind:
        for draft in drafts:
            mind.offer(draft)
        virtual = [line.record for line in mind.journal.lines() if isinstance(line.record, Decided)]

    def choices(found: list[Decided]) -> dict[int, tuple[str, str]]:
        first: dict[int, tuple[str, str]] = {}
        for each in found:
            first.setdefault(each.process, (each.decision.treatment, each.decision.mode))
        return first

    assert choices(records(journal, Decided)) == choices(virtual)


def test_events_that_are_offered_together_get_their_receipts_in_their_order() -> None:
    journal = MemoryJournal()

    async def main() -> list[str]:
        async with live(journal) as mind:
            drafts = [box(f"box {n}", category="" if n == 2 else "obstacle") for n in range(6)]
            drafts[3] = msgspec.structs.replace(drafts[3], kind="")
            receipts = await mind.admit_many(drafts)
            later = await mind.admit_many([])
            assert later == []
            entities = {record.event.id: record.event.entity for record in records(journal, Admitted)}
            assert [entities.get(receipt.event) for receipt in receipts] == ["box 0", "box 1", "box 2", None, "box 4", "box 5"]
            return [receipt.status for receipt in receipts]

    assert asyncio.run(main()) == ["admitted", "admitted", "admitted", "refused", "admitted", "admitted"]


def test_what_is_handed_over_together_is_durable_together() -> None:
    journal = MemoryJournal()

    async def main() -> None:
        async with live(journal) as mind:
            (receipt,) = await mind.take_many([box("box 1")])
            await mind.concluded(receipt.event) if not records(journal, Concluded) else None
            seen = Outcome(
                id="o", topic="outcome", entity="box 1", label="none", at_ns=1_700_000_001_000_000_000, event=receipt.event
            )
            assert await mind.take_many([seen]) == []
            assert len(records(journal, Judged)) == 1

    asyncio.run(main())


def test_nobody_who_offered_many_waits_for_ever_when_the_journal_fails() -> None:
    class Full(MemoryJournal):
        def commit(self, lines: Sequence[Line], state: Mapping[str, bytes | None], blobs: Mapping[str, bytes]) -> None:
            if any(isinstance(line.record, Admitted) for line in lines if isinstance(line, Line)):
                raise JournalError("the disk is full")
            super().commit(lines, state, blobs)

    async def main() -> None:
        async with live(Full()) as mind:
            with pytest.raises(JournalError, match="full"):
                await mind.admit_many([box("box 1"), box("box 2")])
            with pytest.raises(JournalError, match="full"):
                await mind.admit_many([box("box 3")])

    asyncio.run(main())


def test_an_inline_mind_takes_many_at_once() -> None:
    with Mind("service_robot") as mind:
        receipts = mind.offer_many([box(f"box {n}") for n in range(8)])
        assert [receipt.status for receipt in receipts] == ["admitted"] * 8
        assert all(mind.conclusion(receipt.event) is not None for receipt in receipts)
        assert mind.offer_many([]) == []
        assert mind.offer(box("box 9")).status == "admitted"
