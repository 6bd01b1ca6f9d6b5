"""Slots, preemption and operators under the live driver."""

from __future__ import annotations

import asyncio
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import msgspec
import pytest

from tests.drivers.test_live import box, records
from wakeful.contracts.domain import DomainError
from wakeful.contracts.journal import JournalError
from wakeful.contracts.reasoner import Reasoner
from wakeful.contracts.treatment import Mind, Refusal
from wakeful.deliberation.guidelines import GuidelineReasoner
from wakeful.domains import load
from wakeful.drivers.assembly import assemble
from wakeful.drivers.inline import open_live
from wakeful.drivers.live import LiveDriver
from wakeful.drivers.poison import CrashMark
from wakeful.drivers.stalled import Broken, StallMark
from wakeful.facts.asking import Question, Reply
from wakeful.facts.domain import Guideline
from wakeful.facts.events import Draft, Event
from wakeful.facts.inputs import Act
from wakeful.facts.lines import Acted, Asked, Concluded, Moved
from wakeful.facts.processes import Trigger
from wakeful.facts.results import Result
from wakeful.facts.settings import MindSettings
from wakeful.journal import MemoryJournal, open_journal
from wakeful.journal.acts import ActSpool
from wakeful.scheduling import SuspendResume
from wakeful.treatments.decorator import treatment
from wakeful.treatments.registry import Registry


class Long(Result, frozen=True, kw_only=True, tag="long"):
    """The result of a treatment that thinks for long."""


class OneWay:
    """A domain with one treatment for everything."""

    def __init__(self, treat: str) -> None:
        spec = load("service_robot").spec
        self.spec = msgspec.structs.replace(
            spec, treatments=(treat,), detect=(), guideline=(Guideline(treat=treat, because="a test"),)
        )

    def detectors(self) -> dict:
        return {}

    def simulate(self, seed: int) -> None:
        return None


class Counting:
    """A reasoner that keeps every call open, and how many there are."""

    name = "counting"
    latency_s = 0.0

    def __init__(self) -> None:
        self.open = 0
        self.most = 0
        self.asked: list[str] = []
        self.gate = asyncio.Event()

    async def answer(self, question: Question) -> Reply:
        self.open += 1
        self.most = max(self.most, self.open)
        self.asked.append(question.facts["entity"])
        try:
            await self.gate.wait()
        finally:
            self.open -= 1
        return Reply(choice=question.options[0], confidence=0.9, because=("the gate is open",))


def live(journal: MemoryJournal, treat: object, reasoner: Reasoner | None = None, reasoner_slots: int = 0) -> LiveDriver:
    domain = OneWay(treat.name)
    kernel, learner = assemble(
        domain,
        MindSettings(step_s=0.0, reasoner_slots=reasoner_slots),
        registry=Registry(own=[treat], installed=()),
        policy=SuspendResume(),
    )
    return LiveDriver(kernel, journal, reasoner or GuidelineReasoner(domain.spec), learner)


def with_criticality(name: str, criticality: int) -> Draft:
    return msgspec.structs.replace(box(name), criticality=criticality)


async def until(holds: object) -> None:
    while not holds():
        await asyncio.sleep(0)


def test_a_critical_event_preempts_a_long_treatment_at_its_next_await() -> None:
    done: list[str] = []
    stop = asyncio.Event()

    @treatment(says="Thinks until it is told to stop; at once about what is critical.")
    async def long(event: Event, mind: Mind) -> Long:
        while event.criticality < 3 and not stop.is_set():
            await mind.work(1)
        done.append(event.entity)
        return Long(says="done", confidence=1.0, rests_on=(event.id,))

    journal = MemoryJournal()

    async def main() -> None:
        async with live(journal, long) as mind:
            await mind.admit(with_criticality("slow", 0))
            await until(lambda: any(move.trigger is Trigger.DISPATCH for move in records(journal, Moved)))
            await mind.admit(with_criticality("urgent", 3))
            await until(lambda: done)
            assert done == ["urgent"]
            stop.set()
            await until(lambda: len(done) == 2)

    asyncio.run(main())
    preempted = [move for move in records(journal, Moved) if move.trigger is Trigger.PREEMPT]
    assert [(move.process, move.by) for move in preempted] == [(1, "P2")]
    assert len(records(journal, Concluded)) == 2


@treatment(says="Asks the reasoner once.")
async def asking(event: Event, mind: Mind) -> Long:
    question = Question(about="what", event=event.id, asks="?", options=("a",), facts={"entity": event.entity})
    try:
        await mind.deliberate(question)
    except Refusal:
        return Long(says="refused", confidence=0.0, rests_on=(event.id,))
    return Long(says="answered", confidence=1.0, rests_on=(event.id,))


def test_no_more_calls_of_the_reasoner_are_under_way_than_slots_and_criticals_are_next() -> None:
    journal = MemoryJournal()
    reasoner = Counting()

    async def main() -> None:
        async with live(journal, asking, reasoner, reasoner_slots=2) as mind:
            for name, criticality in (("a", 0), ("b", 0), ("c", 0), ("d", 1), ("e", 3)):
                await mind.admit(with_criticality(name, criticality))
            await until(lambda: len(reasoner.asked) == 2 and len(records(journal, Asked)) >= 5)
            reasoner.gate.set()
            await until(lambda: len(records(journal, Concluded)) == 5)

    asyncio.run(main())
    assert reasoner.most == 2
    first_asked = list(dict.fromkeys(reasoner.asked))
    assert first_asked == ["a", "b", "e", "d", "c"]


def test_a_cancelled_process_gives_up_its_call_and_the_next_is_asked() -> None:
    journal = MemoryJournal()
    reasoner = Counting()

    async def main() -> None:
        async with live(journal, asking, reasoner, reasoner_slots=1) as mind:
            await mind.admit(with_criticality("a", 0))
            await mind.admit(with_criticality("b", 0))
            await until(lambda: reasoner.asked == ["a"])
            await mind.tell(Act(who="ana", act="cancel", process=1, why="false alarm"))
            await until(lambda: reasoner.asked == ["a", "b"])
            await until(lambda: reasoner.open == 1)

    asyncio.run(main())
    assert reasoner.most <= 2


def test_an_operators_act_is_heard_while_quick_treatments_are_being_caught_up_with(tmp_path: Path) -> None:
    stop = asyncio.Event()

    @treatment(says="Thinks until it is told to stop.")
    async def endless(event: Event, mind: Mind) -> Long:
        while not stop.is_set():
            await mind.work(1)
        return Long(says="done", confidence=1.0, rests_on=(event.id,))

    journal = MemoryJournal()
    spool = ActSpool(tmp_path / "mind.db")

    async def main() -> None:
        domain = OneWay(endless.name)
        kernel, learner = assemble(domain, MindSettings(step_s=0.0), registry=Registry(own=[endless], installed=()))
        reasoner = GuidelineReasoner(domain.spec)
        async with LiveDriver(kernel, journal, reasoner, learner, acts=spool, clock_s=lambda: 0.0) as mind:
            try:
                await mind.admit(box("a"))
                act = spool.put(Act(who="ana", act="cancel", process=1, why="false alarm"))
                async with asyncio.timeout(5.0):
                    await until(lambda: records(journal, Acted))
                (acted,) = records(journal, Acted)
                assert (acted.id, acted.refused) == (act.id, "")  # it was still thinking
            finally:
                stop.set()

    asyncio.run(main())


def test_when_the_kernel_fails_nobody_waits_for_ever() -> None:
    @treatment(says="Thinks at once.")
    async def quick(event: Event, mind: Mind) -> Long:
        return Long(says="done", confidence=1.0, rests_on=(event.id,))

    async def main() -> None:
        mind = live(MemoryJournal(), quick)
        mind.kernel.domain.spec = msgspec.structs.replace(mind.kernel.domain.spec, detect=load("service_robot").spec.detect)
        async with mind:
            for name in ("lost", "later"):
                with pytest.raises(JournalError, match="the mind has stopped"):
                    await mind.admit(box(name))

    with pytest.raises(DomainError, match="names detector"):
        asyncio.run(main())


def test_a_defect_leaves_nothing_held_and_another_mind_goes_on_with_the_journal(tmp_path: Path) -> None:
    path = tmp_path / "mind.db"
    let_go: list[str] = []

    class Given(ThreadPoolExecutor):
        def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
            let_go.append("an executor")
            super().shutdown(wait, cancel_futures=cancel_futures)

    async def used(mind: LiveDriver) -> None:
        async with mind:
            with pytest.raises(JournalError, match="the mind has stopped"):
                await mind.admit(box("lost"))

    async def main() -> None:
        domain = OneWay(asking.name)
        kernel, learner = assemble(domain, MindSettings(step_s=0.0), registry=Registry(own=[asking], installed=()))
        reasoner = GuidelineReasoner(domain.spec)
        domain.spec = msgspec.structs.replace(domain.spec, detect=load("service_robot").spec.detect)
        mark = CrashMark(path)
        mind = LiveDriver(
            kernel,
            open_journal(path),
            reasoner,
            learner,
            closes_journal=True,
            crash_mark=mark,
            commits=Given(1),
            trainings=Given(1),
        )
        with pytest.raises(DomainError, match="names detector"):
            await used(mind)
        assert not mind._calls
        with pytest.raises(ValueError, match="closed"):
            mark.page[0] = 1

    asyncio.run(main())
    assert let_go == ["an executor"] * 2
    open_journal(path).close()


def test_a_recovery_that_fails_lets_go_of_the_journal(tmp_path: Path) -> None:
    path = tmp_path / "mind.db"

    async def main() -> None:
        before = StallMark(path)
        before.write(Broken(77, 1))
        mind = open_live("service_robot", path)
        mind.kernel.recover = None  # type: ignore[method-assign, assignment]
        with pytest.raises(TypeError):
            async with mind:
                pass

    asyncio.run(main())
    open_journal(path).close()
    assert StallMark(path).before == Broken(77, 1)  # nobody was told of it yet
