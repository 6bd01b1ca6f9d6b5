"""W through wakeful's live driver: what has come is handed over at once, and that returns when all of it is durable."""

from __future__ import annotations

import asyncio

from benchmarks.peers.drafting import draft, evidence, outcome
from benchmarks.peers.learned import DOMAIN
from benchmarks.peers.messages import AnyMessage, Event, Tick, decode
from benchmarks.peers.messages import Evidence as Reading
from benchmarks.peers.of_wakeful import SOURCE, finals_of, prepare, registry
from benchmarks.peers.running import Run, now_ns, size_of
from benchmarks.peers.treating import LIMIT_NS
from wakeful import Draft, Evidence, LiveDriver, Outcome
from wakeful.contracts.journal import Journal
from wakeful.deliberation.guidelines import GuidelineReasoner
from wakeful.drivers.assembly import assemble
from wakeful.drivers.live import GROUP_S
from wakeful.facts.settings import MindSettings
from wakeful.journal import open_journal

Input = Draft | Evidence | Outcome


class WakefulLive:
    """Kernel time follows the workload's clock, so that limits pass in workload time."""

    def __init__(self, run: Run, variant: str) -> None:
        self._run = run
        self._path = run.store / "mind.db"
        full_sync = run.load.full_sync or variant.endswith("full")
        if not self._path.exists():
            prepare(self._path, run.workload, full_sync)
        self._before = size_of(run.store, "mind.db")
        kernel, learner = assemble(DOMAIN, MindSettings(step_s=0.0, trains=False), registry=registry(run))
        journal: Journal = open_journal(self._path, full_sync=full_sync)
        self._at_ns = first_ns = decode(run.messages[min(run.cursor, len(run.messages) - 1)]).at_ns
        self._mind = LiveDriver(
            kernel,
            journal,
            GuidelineReasoner(kernel.domain.spec),
            learner,
            source=SOURCE,
            clock_ns=lambda: first_ns,
            closes_journal=True,
            settles_garbage=True,
            group_s=run.load.group_s if run.load.rate else GROUP_S,
            monotonic_ns=lambda: self._at_ns,
        )

    def run(self) -> None:
        """In an event loop of its own."""
        asyncio.run(self._all())

    async def _all(self) -> None:
        open_loop = bool(self._run.load.rate)
        offered: list[asyncio.Task[None]] = []
        async with self._mind:
            for came, texts in self._run.windows(sleep=False):
                taking: list[Input] = []
                came_from_ns = 0
                for came_ns, text in zip(came, texts, strict=True):
                    message = decode(text)
                    if not open_loop and message.at_ns > self._at_ns + LIMIT_NS // 2:
                        await self._taken(taking)  # no limit passes between two messages that are handed over together
                        taking, came_from_ns = [], now_ns()
                        self._at_ns = message.at_ns
                    taken = self._input(message, max(came_ns, came_from_ns))
                    if taken is not None:
                        taking.append(taken)
                if open_loop:
                    self._at_ns = message.at_ns if texts else self._at_ns
                    offered.append(asyncio.create_task(self._hand(taking)))
                    await asyncio.sleep(self._run.load.group_s / 2)
                else:
                    await self._taken(taking)
            await asyncio.gather(*offered)
            await self._settle()

    async def _hand(self, taking: list[Input]) -> None:
        await self._mind.take_many(taking)
        self._run.acknowledge([each.entity for each in taking if isinstance(each, Draft)])

    async def _thought(self) -> None:
        """Until nobody is ready to think: a client that offers as much as is taken does not build up a backlog."""
        while self._mind.kernel.runnable:
            await asyncio.sleep(0.0005)

    async def _settle(self) -> None:
        """Let the last limits pass, and what is still thinking come to its end."""
        await self._thought()
        self._at_ns += 2 * LIMIT_NS
        await self._mind.tell(self._last)  # what is known already changes nothing, but the mind looks at its clock
        while self._run.times.treated < len(self._run.times.came):
            await asyncio.sleep(0.001)
        await self._thought()

    async def _taken(self, taking: list[Input]) -> None:
        await self._hand(taking)
        await self._thought()

    def _input(self, message: AnyMessage, came_ns: int) -> Input | None:
        if isinstance(message, Event):
            if message.entity in self._run.acknowledged:  # in an earlier life
                return None
            self._run.times.came[message.entity] = came_ns
            return draft(message)
        if isinstance(message, Tick):
            return None
        if isinstance(message, Reading):
            self._run.times.read.setdefault(message.entity, came_ns)
            self._last = evidence(message)
        else:
            self._last = outcome(message)
        return self._last

    def finals(self) -> list[str]:
        """From the journal."""
        return finals_of(self._path)

    def stored_bytes(self) -> int:
        """The journal's growth."""
        return size_of(self._run.store, "mind.db") - self._before
