"""A child process of test_poison: a mind whose one treatment ends the process on the event about ``poison``, by some way."""

from __future__ import annotations

import asyncio
import ctypes
import os
import signal
import sys
from collections.abc import Iterator
from pathlib import Path

import msgspec

from wakeful import Event, MindView, Registry, Result, treatment
from wakeful.contracts.domain import Domain
from wakeful.deliberation.guidelines import GuidelineReasoner
from wakeful.domains import load
from wakeful.drivers.assembly import assemble
from wakeful.drivers.inline import Mind, open_live
from wakeful.drivers.live import LiveDriver
from wakeful.drivers.poison import CrashMark
from wakeful.drivers.sd_notify import Heart
from wakeful.drivers.simulated import SimulatedDriver
from wakeful.facts.domain import DomainSpec, Guideline
from wakeful.facts.events import Draft
from wakeful.facts.lines import Admitted
from wakeful.facts.settings import MindSettings
from wakeful.journal import open_journal

EVENTS = 20
POISONOUS = 7
ALARM = Guideline(treat="attend", because="an alarm is attended to", when={"kind": "alarm"})

# As a program; imported, as by the collection of tests, it does nothing.
DRIVER, WAY, JOURNAL = (*sys.argv[1:3], Path(sys.argv[3])) if __name__ == "__main__" else ("", "", Path())


class Attended(Result, frozen=True, kw_only=True, tag="attended"):
    """What the treatment concludes."""


def poison() -> None:
    if WAY in ("spin", "spin-in-call"):
        while True:
            pass
    if WAY == "segfault":
        ctypes.string_at(0)
    os.kill(os.getpid(), signal.SIGKILL)


async def poison_later() -> int:
    await asyncio.sleep(0)
    poison()
    return 1


@treatment(says="Attends to it in three steps.")
async def attend(event: Event, mind: MindView) -> Attended:
    poisonous = event.entity == "poison" and WAY != "mended"
    if poisonous and WAY == "at-once":
        poison()
    await mind.work(2)
    if poisonous and "call" in WAY:
        await mind.call(poison_later if WAY == "later-in-call" else poison, "sensor", 600.0)
    elif poisonous:
        poison()
    await mind.work()
    return Attended(says=f"attended to {event.entity}", confidence=1.0)


class OneTreatment:
    """The plain domain, with one treatment."""

    def __init__(self, domain: Domain) -> None:
        self._domain = domain
        self.spec: DomainSpec = msgspec.structs.replace(domain.spec, treatments=("attend",), guideline=(ALARM,))

    def detectors(self) -> object:
        return self._domain.detectors()

    def simulate(self, seed: int) -> None:
        return None


def drafts(after: int = -1) -> Iterator[Draft]:
    for index in range(after + 1, EVENTS):
        entity = "poison" if index == POISONOUS else f"pump {index}"
        yield Draft(kind="alarm", entity=entity, source="s", position=index, at_ns=10**18 + index * 10**9)


def missing() -> list[Draft]:
    """What a client would offer again: the events that the journal has not."""
    if not JOURNAL.exists():
        return list(drafts())
    with open_journal(JOURNAL, read_only=True) as journal:
        known = {line.record.event.entity for line in journal.lines() if isinstance(line.record, Admitted)}
    return [draft for draft in drafts() if draft.entity not in known]


def run() -> None:
    kernel, learner = assemble(domain, MindSettings(), registry=registry)
    with open_journal(JOURNAL) as journal:
        thinks = GuidelineReasoner(domain.spec)
        beside = {"crash_mark": CrashMark(JOURNAL), "heart": Heart.from_environment()}
        driver = SimulatedDriver(kernel, journal, thinks, learner, **beside)
        for _ in driver.run("alarms", "digest", drafts):
            pass
        driver.close()


def by_calls() -> None:
    with Mind(domain, JOURNAL, registry=registry) as mind:
        for draft in missing():
            mind.offer(draft)


def open_processes(mind: LiveDriver) -> int:
    """How many are not completed: between a decision and its commit nothing is busy, and yet not all is done."""
    return len(mind.kernel._scheduler.processes)


async def live() -> None:
    offered = missing()
    async with open_live(domain, JOURNAL, registry=registry, slots=2) as mind:
        receipts = await asyncio.gather(*(mind.admit(draft) for draft in offered))
        assert all(receipt.status == "admitted" for receipt in receipts), receipts
        while open_processes(mind):
            await asyncio.sleep(0.01)


registry = Registry(own=(attend,), installed=())
domain: Domain = OneTreatment(load("jsonl"))  # type: ignore[assignment]
if __name__ == "__main__":
    if DRIVER == "run":
        run()
    elif DRIVER == "mind":
        by_calls()
    else:
        asyncio.run(live())
