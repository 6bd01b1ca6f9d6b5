"""W through a plain asyncio loop: a task for each event, futures for readings, everything in memory. Nothing survives a crash."""

from __future__ import annotations

import asyncio
from pathlib import Path

from benchmarks.peers.beside import Limits
from benchmarks.peers.messages import Event, Evidence, Outcome, decode
from benchmarks.peers.running import Run, now_ns
from benchmarks.peers.treating import LIMIT_NS, WAITS, conclude, final, look, verdict, weigh

Concluded = tuple[str, str, float | None, int]


class Asyncio:
    """Takes messages in windows, and lets the tasks run after each."""

    def __init__(self, run: Run, _variant: str) -> None:
        self._run = run
        self._limits = Limits()
        self._futures: dict[str, asyncio.Future[float | None]] = {}
        self._tasks: set[asyncio.Task[None]] = set()
        self._open: set[str] = set()
        self._results: dict[str, Concluded] = {}
        self._early: dict[str, float] = {}
        self._finals: list[str] = []

    def run(self) -> None:
        """In an event loop of its own."""
        asyncio.run(self._all())

    async def _all(self) -> None:
        run = self._run
        for came, texts in run.windows():
            messages = [decode(text) for text in texts]
            chosen = iter(run.lean.choose([message for message in messages if isinstance(message, Event)]))
            for came_ns, message in zip(came, messages, strict=True):
                for entity in self._limits.late(message.at_ns):
                    self._futures.pop(entity).set_result(None)
                if isinstance(message, Event):
                    chosen_now = next(chosen)
                    if message.entity in run.acknowledged:  # in an earlier life
                        continue
                    run.times.came[message.entity] = came_ns
                    self._start(message, *chosen_now)
                elif isinstance(message, Evidence):
                    run.times.read.setdefault(message.entity, came_ns)
                    if self._limits.end(message.entity):
                        self._futures.pop(message.entity).set_result(message.value)
                    elif message.entity not in run.times.came:
                        self._early.setdefault(message.entity, message.value)
                elif isinstance(message, Outcome):
                    while message.entity in self._open:
                        await asyncio.sleep(0)
                    if message.entity in self._results:  # else a crash took it
                        self._judge(message)
            for _ in range(4):
                await asyncio.sleep(0)
        await asyncio.gather(*self._tasks)

    def _start(self, event: Event, treatment: str, label: str) -> None:
        if event.category == WAITS:
            future = self._futures[event.entity] = asyncio.get_running_loop().create_future()
            if event.entity in self._early:
                self._futures.pop(event.entity).set_result(self._early.pop(event.entity))
            else:
                self._limits.begin(event.entity, event.at_ns + LIMIT_NS)
        else:
            future = None
        task = asyncio.create_task(self._treat(event, treatment, label, future))
        self._tasks.add(task)
        self._open.add(event.entity)
        task.add_done_callback(self._tasks.discard)
        self._run.acknowledge([event.entity])

    async def _treat(self, event: Event, treatment: str, label: str, future: asyncio.Future[float | None] | None) -> None:
        times, entity = self._run.times, event.entity
        times.stepped[entity] = now_ns()
        seen = look(entity, event.load)
        await asyncio.sleep(0)
        reading = 0.0
        if future is not None:
            reading = await future
            times.resumed[entity] = now_ns()
        state = weigh(seen, reading)
        self._run.call(entity)
        await asyncio.sleep(0)
        self._open.discard(entity)
        self._results[entity] = treatment, label, reading if future is not None else None, conclude(state, label)

    def _judge(self, outcome: Outcome) -> None:
        treatment, predicted, reading, state = self._results.pop(outcome.entity)
        judged = verdict(predicted, outcome.label, outcome.acted_on)
        self._finals.append(final(outcome.entity, treatment, predicted, reading, state, outcome.label, judged))

    def finals(self) -> list[str]:
        """From memory."""
        return self._finals

    def stored_bytes(self) -> int:
        """Nothing is kept."""
        return 0


def answered(_store: Path, _variant: str) -> set[str]:
    """No answer is committed."""
    return set()
