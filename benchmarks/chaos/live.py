"""One episode of a live mind: the same plan, world and disk through asyncio, in virtual time, with commits beside the feeding.

What comes, comes when the script says, several at once where they come at once. Commits take their time, so that the kernel is
ahead of the journal when a life ends. Whoever was not answered offers again, as a client does: what was durable and not
acknowledged is then a second event, so such a run is compared with itself, not with an undisturbed one.
"""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable
from contextlib import AbstractContextManager, nullcontext, suppress
from pathlib import Path
from random import Random
from typing import TypeVar

from benchmarks.chaos.episode import AFTERWARDS_S, MOST_TURNS, TURN_S, Report, _Episode, _policy
from benchmarks.chaos.ledger import Witness
from benchmarks.chaos.plan import End, Plan
from benchmarks.chaos.script import START_NS
from wakeful.contracts.bridge import Item
from wakeful.contracts.journal import JournalStalled
from wakeful.contracts.reasoner import Reasoner
from wakeful.drivers.assembly import assemble
from wakeful.drivers.live import LiveDriver
from wakeful.drivers.receipts import Receipt
from wakeful.facts.asking import Question, Reply
from wakeful.facts.events import Draft, Undecodable
from wakeful.facts.evidence import Evidence, Outcome
from wakeful.facts.inputs import Act
from wakeful.facts.lines import Admitted
from wakeful.facts.settings import MindSettings
from wakeful.facts.time import to_ns
from wakeful.testing.crash_points import Crashed, crashing
from wakeful.testing.faulty_disk import FaultyDisk
from wakeful.testing.virtual_loop import Beside, VirtualLoop

T = TypeVar("T")

#: A commit takes up to so long, so that the kernel is some groups ahead of the journal.
COMMIT_S = 0.02

#: After so many seconds a disk that failed is mended.
MENDED_AFTER_S = 3.0

#: A dead mind lives again after so long.
DOWN_S = 1.0


def play_live(plan: Plan, journal: Path) -> Report:
    """Play a plan through the live driver, on a journal that is not there yet."""
    return _LiveEpisode(plan, journal).play()


class _LiveEpisode(_Episode):
    def __init__(self, plan: Plan, journal: Path) -> None:
        super().__init__(plan, journal)
        self._random = Random(f"live {plan.seed}")
        self._answered: set[int] = set()
        self._at_s = 0.0
        self._loop = VirtualLoop()
        self._disk: FaultyDisk | None = None

    def _dying(self, end: End | None, disk: FaultyDisk | None) -> AbstractContextManager[None]:
        self._loop = VirtualLoop(self._at_s)
        self._disk = disk
        if end is None or not end.at:
            return nullcontext()

        def first() -> None:
            if end.how == "power" and disk is not None:
                disk.cut_power()
            self._loop.end(Crashed(end.at))

        return crashing(end.at, end.nth, first=first)

    def _mind(self, journal: Witness) -> LiveDriver:
        plan, random, loop = self.plan, self._random, self._loop
        settings = MindSettings(
            slots=plan.slots,
            reasoner_slots=plan.reasoner_slots,
            step_s=0.0,
            seed=plan.seed,
            keep_waiting=plan.keep_waiting,
        )
        thinker = _Slow(self._thinker())
        self.kernel, learner = assemble(self.domain, settings, registry=self.registry, policy=_policy(plan))
        jumped_ns = to_ns(random.choice((0.0, 0.0, 0.0, -86_400.0, 3_600.0)) if plan.clock_jumps else 0.0)
        lives = self.lives
        return LiveDriver(
            self.kernel,
            journal,
            thinker,
            learner,
            clock_ns=lambda: START_NS + to_ns(loop.time()) + jumped_ns,
            monotonic_ns=lambda: to_ns(loop.time()),
            clock_s=_Ticking(random),
            commits=Beside(loop, lambda: random.uniform(0.0, COMMIT_S)),
            trainings=Beside(loop, lambda: random.uniform(0.0, 5.0)),
            incarnation=lambda: f"life {lives}",
        )

    def _think_on(self, journal: Witness) -> None:
        loop = self._loop
        loop.set_exception_handler(lambda _loop, _context: None)  # who died says nothing more; what lives is raised where it is
        try:
            loop.run_until_complete(self._life(self._mind(journal)))
        finally:
            self._at_s = loop.time() + DOWN_S
            for task in asyncio.all_tasks(loop):
                _bury(task)
            loop.close()

    async def _life(self, driver: LiveDriver) -> None:
        mending = asyncio.create_task(self._mend(driver))  # what recovery has to mend may meet a full disk too
        async with driver as mind:
            await self._offer_all(mind)
            holds = [act for acts in self.script.acts.values() for act in acts if act.act == "hold"]
            for act in holds:
                await mind.tell(Act(who="ana", act="release", process=act.process, why="over", id=f"over {act.id}"))
            for turn in range(MOST_TURNS):
                await asyncio.sleep(TURN_S if turn else AFTERWARDS_S)
                if not len(mind.kernel._scheduler.processes):
                    break
            mending.cancel()
            if mind._pump.error is not None:  # it stopped while nobody offered anything
                raise mind._pump.error

    async def _mend(self, mind: LiveDriver) -> None:
        while self._disk is not None:
            await asyncio.sleep(MENDED_AFTER_S)
            if mind._stall.active:
                await asyncio.sleep(MENDED_AFTER_S)
                self._disk.mend()

    async def _offer_all(self, mind: LiveDriver) -> None:
        """Everything that was not answered in an earlier life, each when it comes."""
        came: dict[float, list[int]] = {}
        for position, at_s in enumerate(self.script.at_s):
            came.setdefault(at_s, []).append(position)
        offering: list[asyncio.Task[None]] = []
        for at_s, positions in came.items():
            await asyncio.sleep(max(0.0, at_s - self._loop.time()))
            together = len(positions) > 1 and self._random.random() < 0.5
            for some in [positions] if together else [[each] for each in positions]:
                left = [each for each in some if each not in self._answered]
                offering.append(asyncio.create_task(self._offer(mind, left)))
            for each in positions:
                for act in self.script.acts.get(each, ()):
                    offering.append(asyncio.create_task(self._tell(mind, act)))
        await asyncio.gather(*offering)

    async def _offer(self, mind: LiveDriver, positions: list[int]) -> None:
        items: list[Item] = [self.script.items[each] for each in positions]
        told = [each for each in items if not isinstance(each, Undecodable)]
        if len(told) == 1 and isinstance(told[0], Draft):
            self._hold_to([await mind.admit(told[0], patience_s=0.1)])
        elif len(told) == 1:
            await self._tell(mind, told[0])  # type: ignore[arg-type]
        elif told:
            self._hold_to(await self._patient(mind, lambda: mind.take_many(told)))  # type: ignore[arg-type]
        self._answered.update(positions)

    async def _tell(self, mind: LiveDriver, later: Evidence | Outcome | Act) -> None:
        await self._patient(mind, lambda: mind.tell(later))

    async def _patient(self, mind: LiveDriver, hand_over: Callable[[], Awaitable[T]]) -> T:
        """Hand it over again until something can be written."""
        while True:
            try:
                return await hand_over()
            except JournalStalled:
                if mind._pump.error is not None:
                    raise
                await asyncio.sleep(MENDED_AFTER_S)

    def _hold_to(self, receipts: list[Receipt]) -> None:
        """What was acknowledged as admitted must be in the journal by now."""
        admitted = {each.event for each in receipts if each.status == "admitted"}
        if admitted:
            admitted -= {line.record.event.id for line in self.ledger.known if isinstance(line.record, Admitted)}
            self.ledger.lost += len(admitted)


def _bury(task: asyncio.Task[object]) -> None:
    """Let go of what a killed process would leave to the operating system; nothing of it runs on."""
    task._log_destroy_pending = False  # type: ignore[attr-defined]
    for _ in range(3):  # once for each ``async with`` that would await its own end
        with suppress(RuntimeError):
            task.get_coro().close()  # type: ignore[union-attr]
            return


class _Slow:
    """A reasoner whose answers take, in the loop's time, as long as it says."""

    def __init__(self, inner: Reasoner) -> None:
        self.name = inner.name
        self.latency_s = inner.latency_s
        self._inner = inner

    async def answer(self, question: Question) -> Reply:
        """As the inner one, later."""
        try:
            return await self._inner.answer(question)
        finally:
            await asyncio.sleep(self._inner.latency_s)


class _Ticking:
    """The clock by which steps are measured: mostly quick, now and then not."""

    def __init__(self, random: Random) -> None:
        self._random = random
        self._now_s = 0.0

    def __call__(self) -> float:
        self._now_s += self._random.choice((1e-6, 1e-6, 1e-6, 1e-4, 5e-3))
        return self._now_s


Play = Callable[[Plan, Path], Report]
