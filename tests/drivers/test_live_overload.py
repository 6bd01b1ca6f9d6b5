"""A live mind under more than it can think about: callers wait, criticals do not, and who has no patience is told why."""

from __future__ import annotations

import asyncio
import itertools

from wakeful.deliberation.guidelines import GuidelineReasoner
from wakeful.drivers.assembly import assemble
from wakeful.drivers.live import LiveDriver, Receipt
from wakeful.facts.events import CRITICAL, Draft
from wakeful.facts.lines import Admitted, Refused
from wakeful.facts.overload import REFUSED, OverloadSettings
from wakeful.facts.settings import MindSettings
from wakeful.journal import MemoryJournal
from wakeful.journal.audit import audit

SETTINGS = OverloadSettings(shed_backlog=4, refuse_backlog=10, reserve=0.2, source_share=1.0)


def draft(index: int, criticality: int = 0) -> Draft:
    return Draft(
        kind="object",
        entity=f"box {index}",
        source="",
        position=0,
        at_ns=1_700_000_000_000_000_000 + index,
        fields={"category": "obstacle", "location": "edge", "state": "unstable", "route": "none"},
        criticality=criticality,  # type: ignore[arg-type]
    )


def live(journal: MemoryJournal) -> LiveDriver:
    """A mind whose every step seems to take 5 ms, so that events queue up however fast the machine is."""
    kernel, learner = assemble("service_robot", MindSettings(step_s=0.0, reasoner_slots=1, overload=SETTINGS))
    ticks = itertools.count()
    return LiveDriver(kernel, journal, GuidelineReasoner(kernel.domain.spec), learner, clock_s=lambda: 0.005 * next(ticks))


async def quiet(mind: LiveDriver) -> None:
    while len(mind.kernel._scheduler.processes):
        await asyncio.sleep(0)


def kinds(journal: MemoryJournal, kind: type) -> list[object]:
    return [line.record for line in journal.lines() if isinstance(line.record, kind)]


def test_whoever_can_wait_is_admitted_however_many_they_are() -> None:
    journal = MemoryJournal()

    async def main() -> list[Receipt]:
        async with live(journal) as mind:
            receipts = await asyncio.gather(*(mind.admit(draft(index)) for index in range(60)))
            await quiet(mind)
            return receipts

    assert {receipt.status for receipt in asyncio.run(main())} == {"admitted"}
    assert len(kinds(journal, Admitted)) == 60
    assert audit(journal).ok


def test_who_has_no_patience_is_refused_with_the_reason_in_the_journal_and_criticals_are_not() -> None:
    journal = MemoryJournal()

    async def main() -> tuple[list[Receipt], list[Receipt]]:
        async with live(journal) as mind:
            hasty = [mind.admit(draft(index), patience_s=0.0) for index in range(40)]
            critical = [mind.admit(draft(100 + index, CRITICAL)) for index in range(20)]
            found = await asyncio.gather(asyncio.gather(*hasty), asyncio.gather(*critical))
            await quiet(mind)
            return found[0], found[1]

    hasty, critical = asyncio.run(main())
    assert {receipt.status for receipt in critical} == {"admitted"}
    refused = [receipt for receipt in hasty if receipt.status == "refused"]
    assert refused
    assert all(receipt.reason.startswith(REFUSED) for receipt in refused)
    assert len(kinds(journal, Refused)) == len(refused)
    assert len(kinds(journal, Admitted)) == 60 - len(refused)
    assert audit(journal).ok


def test_a_mind_that_closes_lets_nobody_wait_for_ever() -> None:
    async def main() -> list[object]:
        async with live(MemoryJournal()) as mind:
            offered = [asyncio.create_task(mind.admit(draft(index))) for index in range(200)]
            await asyncio.sleep(0)
        return list(await asyncio.gather(*offered, return_exceptions=True))

    found = asyncio.run(main())
    assert len(found) == 200
    assert all(isinstance(each, Receipt | Exception) for each in found)
