"""Commits beside the feeding: the kernel goes on, nobody is told of anything that is not durable, nothing is made too late."""

from __future__ import annotations

import asyncio
import itertools
from collections.abc import Coroutine, Mapping, Sequence

import msgspec

from tests.drivers.test_live import box
from wakeful.contracts.treatment import Mind
from wakeful.deliberation.guidelines import GuidelineReasoner
from wakeful.domains import load
from wakeful.drivers.assembly import assemble
from wakeful.drivers.live import LiveDriver
from wakeful.drivers.pump import LONGEST_COMMIT_S
from wakeful.drivers.sd_notify import Heart
from wakeful.facts.domain import Guideline
from wakeful.facts.events import Event
from wakeful.facts.lines import Admitted, Answered
from wakeful.facts.packs import Entry, expanded
from wakeful.facts.results import Result
from wakeful.facts.settings import MindSettings
from wakeful.facts.time import to_ns
from wakeful.journal import MemoryJournal
from wakeful.testing.virtual_loop import Beside, VirtualLoop
from wakeful.treatments.decorator import treatment
from wakeful.treatments.registry import Registry

START_NS = 1_700_000_000_000_000_000


class Noting(MemoryJournal):
    """Notes how many events each commit admits."""

    def __init__(self) -> None:
        super().__init__()
        self.commits: list[int] = []

    def commit(self, lines: Sequence[Entry], state: Mapping[str, bytes | None], blobs: Mapping[str, bytes]) -> None:
        super().commit(lines, state, blobs)
        admitted = sum(isinstance(line.record, Admitted) for line in expanded(lines))
        if admitted:
            self.commits.append(admitted)


class Called(Result, frozen=True, kw_only=True, tag="called"):
    """What was concluded after a call."""


class OneWay:
    """A domain with one treatment for everything."""

    def __init__(self) -> None:
        spec = load("service_robot").spec
        rule = Guideline(treat="calling", because="a test")
        self.spec = msgspec.structs.replace(spec, treatments=("calling",), detect=(), guideline=(rule,))

    def detectors(self) -> dict:
        return {}

    def simulate(self, seed: int) -> None:
        return None


class Listened(Heart):
    """Notes when the pump has got on, for a supervisor who would act after three seconds of silence."""

    def __init__(self, loop: VirtualLoop) -> None:
        super().__init__()
        self._loop = loop
        self.at_s: list[float] = []

    @property
    def every_s(self) -> float | None:
        return 1.0

    def beat(self) -> None:
        super().beat()
        self.at_s.append(self._loop.time())

    def longest_s(self, until_s: float) -> float:
        return max(after - before for before, after in itertools.pairwise([*self.at_s, until_s]))


def live(
    loop: VirtualLoop, journal: MemoryJournal, commit_s: float, registry: Registry | None = None, heart: Heart | None = None
) -> LiveDriver:
    domain = "service_robot" if registry is None else OneWay()
    kernel, learner = assemble(domain, MindSettings(step_s=0.0, trains=False), registry=registry)
    return LiveDriver(
        kernel,
        journal,
        GuidelineReasoner(kernel.domain.spec),
        learner,
        clock_ns=lambda: START_NS,
        monotonic_ns=lambda: to_ns(loop.time()),
        clock_s=loop.time,
        commits=Beside(loop, lambda: commit_s),
        group_s=0.002,
        heart=heart,
    )


def played(loop: VirtualLoop, story: Coroutine[object, object, None]) -> None:
    try:
        loop.run_until_complete(story)
    finally:
        loop.close()


def test_what_comes_during_a_commit_is_fed_meanwhile_and_committed_together_afterwards() -> None:
    loop, journal = VirtualLoop(), Noting()
    told: list[tuple[str, float]] = []

    async def story() -> None:
        async with live(loop, journal, commit_s=1.0) as mind:
            began_s = loop.time()

            async def offer(number: int) -> None:
                await asyncio.sleep(number * 0.1)
                receipt = await mind.admit(box(f"box {number}"))
                told.append((receipt.status, round(loop.time() - began_s, 1)))

            offering = [asyncio.create_task(offer(number)) for number in range(5)]
            await asyncio.sleep(0.9)
            assert mind.kernel.counts.admitted == 5  # the kernel is ahead of the journal
            assert not told
            assert not journal.commits
            await asyncio.gather(*offering)

    played(loop, story())
    assert journal.commits == [1, 4]
    assert told == [("admitted", 1.0)] + [("admitted", 2.0)] * 4


def test_on_a_slow_disk_the_heart_beats_while_the_writer_is_full_and_while_it_is_drained() -> None:
    loop = VirtualLoop()
    heart = Listened(loop)
    full: list[bool] = []

    async def story() -> None:
        async with live(loop, Noting(), commit_s=30.0, heart=heart) as mind:
            offering = []
            for number in range(40):
                offering.append(asyncio.create_task(mind.admit(box(f"box {number}"))))
                await asyncio.sleep(0.01)
            full.append(mind._writer.full)
        await asyncio.gather(*offering, return_exceptions=True)

    played(loop, story())
    assert full == [True]
    assert heart.longest_s(loop.time()) <= 1.0


def test_a_commit_that_hangs_is_not_covered_for() -> None:
    loop = VirtualLoop()
    heart = Listened(loop)

    async def story() -> None:
        async with live(loop, Noting(), commit_s=1000.0, heart=heart) as mind:
            await mind.admit(box("box"))

    played(loop, story())
    assert heart.longest_s(loop.time()) > 1000.0 - LONGEST_COMMIT_S - 1.0


def test_a_call_whose_limit_has_passed_before_it_was_durable_is_not_made() -> None:
    made: list[str] = []

    @treatment(name="calling", says="Does something outside, within a second.")
    async def calling(event: Event, mind: Mind) -> Called:
        await mind.call(lambda: made.append(event.entity), key="act", within_s=1.0, safety="effect")
        return Called(says="done", confidence=1.0)

    registry = Registry(own=(calling,), installed=())
    for commit_s, expected in ((0.01, ["box"]), (1.5, [])):
        made.clear()
        loop, journal = VirtualLoop(), Noting()

        async def story(loop: VirtualLoop = loop, journal: Noting = journal, commit_s: float = commit_s) -> None:
            async with live(loop, journal, commit_s, registry) as mind:
                await mind.admit(box("box"))
                await asyncio.sleep(200.0)

        played(loop, story())
        assert made == expected
        asked = [line.record for line in journal.lines() if isinstance(line.record, Answered) and line.record.key == "act"]
        assert ["expired" in each.error for each in asked][:1] == [not expected]
