"""The live driver: asyncio over the same kernel. What is admitted is durable before its admission returns."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING
from uuid import uuid4

import msgspec

from wakeful.contracts.journal import Journal, JournalError
from wakeful.contracts.learner import Learner
from wakeful.contracts.reasoner import Reasoner
from wakeful.drivers.blobs import JournalBlobs
from wakeful.drivers.outside import make
from wakeful.drivers.trainer import Trainer
from wakeful.facts.events import Draft, Observation
from wakeful.facts.evidence import Evidence, Outcome
from wakeful.facts.inputs import Act, Answer, Begin, Call, Input, Mark, Requests
from wakeful.facts.lines import Admitted, Concluded, Duplicate, Line, Refused
from wakeful.kernel import Kernel

if TYPE_CHECKING:
    from types import TracebackType

#: Inputs that come within so many seconds of one another are committed together.
GROUP_S = 0.005

#: How often finished trainings are looked for while one runs.
_TRAINING_POLL_S = 0.05


class Receipt(msgspec.Struct, frozen=True):
    """What became of an offered event, once that is durable: ``admitted``, ``duplicate`` or ``refused`` with its reason."""

    status: str
    event: str = ""
    reason: str = ""


class LiveDriver:
    """Runs a kernel in real time. Use as ``async with``.

    Args:
        kernel: fed nothing yet; it is recovered from the journal on entry.
        journal: what is committed to, in a thread of its own.
        reasoner: answers the kernel's questions.
        learner: trains off the kernel's thread.
        source: the name under which events are offered; its positions go on over restarts.
        clock_ns: the time of day, read once: from there on kernel time follows the monotonic clock and never runs back.
    """

    def __init__(
        self,
        kernel: Kernel,
        journal: Journal,
        reasoner: Reasoner,
        learner: Learner,
        source: str = "live",
        clock_ns: Callable[[], int] = time.time_ns,
    ) -> None:
        self.kernel = kernel
        self.journal = journal
        self._reasoner = reasoner
        self._trainer = Trainer(learner)
        self._source = source
        self._clock_ns = clock_ns
        self._inbox: list[tuple[Input, asyncio.Future[Receipt] | None]] = []
        self._called: set[asyncio.Task[None]] = set()
        self._settled: dict[str, list[asyncio.Future[Concluded]]] = {}
        self._commits = ThreadPoolExecutor(max_workers=1, thread_name_prefix="wakeful-journal")
        self._position = -1
        self._wake_ns: int | None = None
        self._error: JournalError | None = None
        self._closing = False

    async def __aenter__(self) -> LiveDriver:
        self._woken = asyncio.Event()
        recovered = self.kernel.recover(self.journal.lines(), self.journal.state(), JournalBlobs(self.journal))
        self._start_ns = max(self._clock_ns(), self.kernel.now_ns) - time.monotonic_ns()
        await self._act(recovered)
        known = self.kernel.source(self._source)
        if known is not None and not known.finished:
            self._position, digest = known.cursor, known.digest
        else:
            digest = uuid4().hex
        self._inbox.append((Begin(source=self._source, digest=digest), None))
        self._pump_task = asyncio.create_task(self._pump())
        self._woken.set()
        return self

    async def __aexit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self._closing = True
        self._woken.set()
        await self._pump_task
        for task in self._called:
            task.cancel()  # a call without an answer is in the journal as asked, and is made again at the next start
        await asyncio.gather(*self._called, return_exceptions=True)
        self._trainer.close()
        self._commits.shutdown()

    async def admit(self, draft: Draft) -> Receipt:
        """Offer an event; returns once what became of it is durable.

        Raises:
            JournalError: it could not be written; it is not admitted.
        """
        self._position += 1
        placed = msgspec.structs.replace(draft, source=self._source, position=self._position)
        return await self._put(placed, Mark(source=self._source, position=self._position))

    async def observe(self, observation: Observation) -> None:
        """Hand over an observation; returns once what it led to is durable. Registration decides whether it is an event."""
        self._position += 1
        placed = msgspec.structs.replace(observation, source=self._source, position=self._position)
        await self._put(placed, Mark(source=self._source, position=self._position))

    async def tell(self, later: Evidence | Outcome | Act) -> None:
        """Hand over evidence, an outcome, or an operator's act; returns once it is durable."""
        await self._put(later)

    async def concluded(self, event: str) -> Concluded:
        """Wait for the next conclusion on an event."""
        future: asyncio.Future[Concluded] = asyncio.get_running_loop().create_future()
        self._settled.setdefault(event, []).append(future)
        return await future

    async def _put(self, first: Input, *more: Input) -> Receipt:
        if self._error is not None:
            raise self._error
        if self._closing:
            raise JournalError("the mind is closing; nothing more is taken")
        future: asyncio.Future[Receipt] = asyncio.get_running_loop().create_future()
        self._inbox.append((first, future))
        self._inbox.extend((each, None) for each in more)
        self._woken.set()
        return await future

    # --- the pump: feed, commit, act ---

    def _now_ns(self) -> int:
        return self._start_ns + time.monotonic_ns()

    async def _pump(self) -> None:
        while self._error is None:
            await self._wait()
            batch, self._inbox = self._inbox, []
            inputs = [each for each, _ in batch]
            inputs.extend(self._trainer.finished())
            if self._closing and not inputs:
                break
            futures = {_place(each): future for each, future in batch if future is not None}
            requests = self.kernel.feed(inputs, self._now_ns())
            try:
                await self._commit(requests)
            except JournalError as error:
                self._error = error
                for future in futures.values():
                    future.set_exception(error)
                return
            self._answer(requests.lines, futures)
            await self._act(requests, committed=True)

    async def _wait(self) -> None:
        """Until something comes, something is due, or a training may have ended; then a moment for more of the same."""
        if not self._inbox and not self._closing:
            self._woken.clear()
            waits = [_TRAINING_POLL_S] if self._trainer.next_publication_ns() is not None else []
            if self._wake_ns is not None:
                waits.append(max(0.0, (self._wake_ns - self._now_ns()) / 1e9))
            try:
                await asyncio.wait_for(self._woken.wait(), min(waits, default=None))
            except TimeoutError:
                return
        if self._inbox and not self._closing:
            await asyncio.sleep(GROUP_S)

    async def _commit(self, requests: Requests) -> None:
        if requests.lines or requests.blobs:
            loop = asyncio.get_running_loop()
            await loop.run_in_executor(self._commits, self.journal.commit, requests.lines, self.kernel.changed(), requests.blobs)

    def _answer(self, lines: tuple[Line, ...], futures: Mapping[object, asyncio.Future[Receipt]]) -> None:
        receipts: dict[object, Receipt] = {}
        for line in lines:
            record = line.record
            if isinstance(record, Admitted):
                receipts[record.event.position] = Receipt("admitted", record.event.id)
            elif isinstance(record, Duplicate):
                receipts[record.position] = Receipt("duplicate", record.event)
            elif isinstance(record, Refused):
                receipts[record.position] = Receipt("refused", record.event, record.reason)
            elif isinstance(record, Concluded):
                for waiter in self._settled.pop(record.event, ()):
                    if not waiter.done():
                        waiter.set_result(record)
        for place, future in futures.items():
            if not future.done():
                future.set_result(receipts.get(place, Receipt("taken")))

    async def _act(self, requests: Requests, *, committed: bool = False) -> None:
        if not committed:
            await self._commit(requests)
        self._wake_ns = requests.wake_ns
        for call in requests.calls:
            task = asyncio.create_task(self._call(call))
            self._called.add(task)
            task.add_done_callback(self._called.discard)
        for training in requests.trainings:
            self._trainer.start(training)

    async def _call(self, call: Call) -> None:
        left_s = max(0.0, (call.expires_ns - self._now_ns()) / 1e9)
        try:
            async with asyncio.timeout(left_s):
                answer = await make(call, self._reasoner)
        except TimeoutError:
            answer = Answer(process=call.process, seq=call.seq, error="expired")
        self._inbox.append((answer, None))
        self._woken.set()


def _place(item: Input) -> object:
    """What a receipt is found by: the position of an event, or the input itself where it has none."""
    return item.position if isinstance(item, Draft | Observation) else id(item)
