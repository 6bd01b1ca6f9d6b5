"""The live driver: asyncio over the same kernel. What is admitted is durable before its admission returns."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable, Sequence
from concurrent.futures import Executor, ThreadPoolExecutor
from contextlib import AsyncExitStack
from typing import TYPE_CHECKING
from uuid import uuid4

import msgspec

from wakeful.contracts.journal import Journal, JournalError
from wakeful.contracts.learner import Learner
from wakeful.contracts.reasoner import Reasoner
from wakeful.drivers import garbage
from wakeful.drivers.blobs import JournalBlobs
from wakeful.drivers.calling import Calls
from wakeful.drivers.poison import CAREFUL_INPUTS, CrashMark, take_up
from wakeful.drivers.pump import Pump
from wakeful.drivers.receipts import Listeners, Receipt
from wakeful.drivers.room import Room
from wakeful.drivers.sd_notify import Heart
from wakeful.drivers.stalled import RETRY_S, Stall, StallMark
from wakeful.drivers.trainer import Trainer
from wakeful.drivers.turn import Turns
from wakeful.drivers.writer import Group, Writer
from wakeful.facts.crash_points import reach
from wakeful.facts.crashes import MARKED
from wakeful.facts.events import CRITICAL, Draft, Observation
from wakeful.facts.evidence import Evidence, Outcome
from wakeful.facts.inputs import Act, Begin, Input, Mark, Requests
from wakeful.facts.lines import GAP, Concluded, Noted
from wakeful.journal.acts import ActSpool
from wakeful.kernel import Kernel

if TYPE_CHECKING:
    from types import TracebackType

#: Inputs that come within so many seconds of one another are committed together.
GROUP_S = 0.005


class LiveDriver:
    """Runs a kernel in real time. Use as ``async with``.

    Args:
        kernel: fed nothing yet; it is recovered from the journal on entry.
        journal: what is committed to, in a thread of its own.
        reasoner: answers the kernel's questions.
        learner: trains off the kernel's thread.
        source: the name under which events are offered; its positions go on over restarts.
        clock_ns: the time of day, read once: from there on kernel time follows the monotonic clock and never runs back.
        acts: where operators at another terminal hand in their acts; None: nowhere.
        crash_mark: says after a crash whose treatment was running; None: nobody will know.
        heart: beats for whoever supervises this process.
        closes_journal: the journal is let go of on exit, so that another may write it.
        settles_garbage: sets Python's garbage collector for the whole process (``wakeful.drivers.garbage``).
        group_s: inputs that come within so many seconds of one another are committed together.
        monotonic_ns: the clock that kernel time follows; a load generator may bring its own.
        stall_mark: tells the next run of a crash while nothing could be written; None: nobody will know.
        retry_s: how often writing is tried again while nothing can be written.
        commits: the executor of one thread that commits; its own where None. One in virtual time makes a run repeatable.
        trainings: the same for trainings.
        incarnation: names this life of the source, where it does not go on with an earlier one.
        clock_s: by which it is measured how long treatments' steps take.
    """

    def __init__(
        self,
        kernel: Kernel,
        journal: Journal,
        reasoner: Reasoner,
        learner: Learner,
        source: str = "live",
        clock_ns: Callable[[], int] = time.time_ns,
        acts: ActSpool | None = None,
        closes_journal: bool = False,
        settles_garbage: bool = False,
        crash_mark: CrashMark | None = None,
        heart: Heart | None = None,
        group_s: float = GROUP_S,
        monotonic_ns: Callable[[], int] = time.monotonic_ns,
        stall_mark: StallMark | None = None,
        retry_s: float = RETRY_S,
        commits: Executor | None = None,
        trainings: Executor | None = None,
        incarnation: Callable[[], str] = lambda: uuid4().hex,
        clock_s: Callable[[], float] = time.perf_counter,
    ) -> None:
        self.kernel = kernel
        self.journal = journal
        self._reasoner = reasoner
        self._trainer = Trainer(learner, trainings)
        self._incarnation = incarnation
        self._stall_mark = stall_mark
        self._stall = Stall(source, self._now_ns, stall_mark)
        self._retry_s = retry_s
        self._source = source
        self._clock_ns = clock_ns
        self._clock_s = clock_s
        self._acts = acts
        self._closes_journal = closes_journal
        self._settles_garbage = settles_garbage
        self._group_s = group_s
        self._monotonic_ns = monotonic_ns
        self._start_ns = 0
        self._crash_mark = crash_mark
        self._heart = heart if heart is not None else Heart()
        self._room = Room(kernel.settings.overload, lambda: self._pump.waiting // 2 + kernel.backlog)
        self._commits = commits if commits is not None else ThreadPoolExecutor(1, thread_name_prefix="wakeful-journal")
        self._held = AsyncExitStack()
        self._why = ""
        self._position = -1

    async def __aenter__(self) -> LiveDriver:
        """Recover, and begin. Where that fails everything is let go of, as on exit."""
        self._to_release()
        try:
            await self._begin()
        except BaseException:
            if self._stall_mark is not None:
                self._stall_mark.write(self._stall_mark.before)  # still to be told of
            await self._held.aclose()
            raise
        return self

    def _to_release(self) -> None:
        """What is let go of in the end, whatever became of the mind and of what was let go of before; the last first."""
        if self._closes_journal:
            self._held.callback(self.journal.close)
        self._held.callback(self.kernel.close)
        self._held.callback(lambda: self._heart.stop(self._why))
        self._held.callback(self._commits.shutdown)
        self._held.callback(self._trainer.close)

    async def _begin(self) -> None:
        kernel = self.kernel
        careful = CAREFUL_INPUTS if take_up(self._crash_mark, self.journal) is not None else 0
        if self._crash_mark is not None:
            self._held.callback(self._crash_mark.close)  # not before: what it says is recorded only now
        turns = Turns(kernel, bytearray(MARKED) if self._crash_mark is None else self._crash_mark.page, self._clock_s)
        self._pump = Pump(
            kernel, turns, self._trainer, self._stall, self._heart, self._acts, self._now_ns, self._group_s, careful
        )
        self._calls = Calls(self._reasoner, self._crash_mark, self._now_ns, self._pump.hear)
        self._held.push_async_callback(self._calls.close)
        self._listeners = Listeners(self._calls)
        self._writer = Writer(
            self.journal, self._commits, self._stall, self._retry_s, self._settle, self._pump.resume, self._moved
        )
        recovered = kernel.recover(self.journal.entries(), self.journal.state(), JournalBlobs(self.journal))
        self._start_ns = max(self._clock_ns(), kernel.now_ns) - self._monotonic_ns()
        await self._pump.begin(self._writer, msgspec.structs.replace(recovered, calls=(), trainings=()))
        known = kernel.source(self._source)
        if known is not None and not known.finished:
            self._position, digest = known.cursor, known.digest
        else:
            digest = self._incarnation()
        if self._settles_garbage:
            garbage.settle()
        self._pump.hear(Begin(source=self._source, digest=digest))
        self._tell_of_stall()
        self._held.callback(self._stall.close)
        self._act(recovered)
        self._heart.ready(self._says)  # before any call runs: one that holds the interpreter is a stall that must be seen
        self._pumping = asyncio.create_task(self._run())

    async def __aexit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self._pump.closing = self._writer.closing = True
        self._room.close(JournalError("the mind is closing; nothing more is taken"))
        self._pump.wake()
        try:
            await self._pumping
        finally:  # a defect too leaves nothing held: another mind may go on with the journal
            with self._heart:  # a training that is waited for is no stall
                await self._held.aclose()

    @property
    def busy(self) -> bool:
        """Whether something was offered that is not durable yet, or a call is under way."""
        return bool(self._pump.waiting or len(self._calls) or not self._writer.idle)

    async def admit(self, draft: Draft, patience_s: float | None = None) -> Receipt:
        """Offer an event; returns once what became of it is durable.

        Args:
            draft: the event; its source and position are the mind's own.
            patience_s: where the backlog has no room the caller waits, at most so long: then the event is offered all the same,
                and may be refused with a reason. None: until there is room.

        Raises:
            JournalError: it could not be written; it is not admitted.
            JournalStalled: nor can it be for now, and more were refused meanwhile than can be held to be recorded.
        """
        await self._enter(draft.criticality >= CRITICAL, patience_s)
        if self._stalled:
            return self._refuse((draft,))[0]
        self._position += 1
        placed = msgspec.structs.replace(draft, source=self._source, position=self._position)
        return await self._pump.put(placed, Mark(source=self._source, position=self._position))

    async def admit_many(self, drafts: Sequence[Draft], patience_s: float | None = None) -> list[Receipt]:
        """Offer many events at once; returns once what became of each is durable. Costs a fraction of what they do one by one.

        Raises as ``admit``; then nothing of it was taken.
        """
        if not drafts:
            return []
        await self._enter(any(draft.criticality >= CRITICAL for draft in drafts), patience_s)
        return await self.take_many(drafts)

    async def take_many(self, inputs: Sequence[Draft | Evidence | Outcome]) -> list[Receipt]:
        """Hand over events, evidence and outcomes in the order of their coming, without waiting for room; returns once all of
        it is durable, with a receipt for each event. While nothing can be written events alone are refused, as ``admit`` does.

        Raises:
            JournalError: it could not be written; nothing of it was taken.
            JournalStalled: the same for now: there is evidence or an outcome in it, which is nobody's to refuse.
        """
        if self._stalled:
            drafts = [each for each in inputs if isinstance(each, Draft)]
            if len(drafts) < len(inputs):
                self._stall.turn_away(len(inputs))
            return self._refuse(drafts)
        first = position = self._position + 1
        placed: list[Input] = []
        for each in inputs:
            if isinstance(each, Draft):
                placed.append(msgspec.structs.replace(each, source=self._source, position=position))
                position += 1
            else:
                placed.append(each)
        placed.append(Mark(source=self._source, position=position - 1))
        future = self._pump.put_many(placed, first, position - 1)
        self._position = position - 1
        return await future

    async def observe(self, observation: Observation) -> None:
        """Hand over an observation; returns once what it led to is durable. Registration decides whether it is an event.

        Raises:
            JournalError: it could not be written. JournalStalled: nor can it be for now; it was not taken.
        """
        await self._enter(False, None)
        if self._stalled:
            self._stall.turn_away(1)
        self._position += 1
        placed = msgspec.structs.replace(observation, source=self._source, position=self._position)
        await self._pump.put(placed, Mark(source=self._source, position=self._position))

    async def tell(self, later: Evidence | Outcome | Act) -> None:
        """Hand over evidence, an outcome, or an operator's act; returns once it is durable. None waits for room: it frees others.

        Raises:
            JournalError: it could not be written. JournalStalled: nor can it be for now; it was not taken.
        """
        if self._stalled:
            self._stall.turn_away(1)
        await self._pump.put(later)

    async def concluded(self, event: str) -> Concluded:
        """Wait for the next conclusion on an event."""
        return await self._listeners.concluded(event)

    @property
    def _stalled(self) -> bool:
        """Whether what is offered now is refused until the journal can be written; a mind that ends takes nothing at all."""
        return self._stall.active and not self._pump.closing and self._pump.error is None

    async def _enter(self, critical: bool, patience_s: float | None) -> None:
        """Wait for room, unless nothing is taken anyway."""
        if not self._stalled:
            await self._room.enter(critical, patience_s)

    def _refuse(self, drafts: Sequence[Draft]) -> list[Receipt]:
        """Nothing can be written: each of them is counted, and has a position, under which that is recorded later."""
        if not self._stall.has_room(len(drafts)):
            self._stall.turn_away(len(drafts))
        receipts: list[Receipt] = []
        for draft in drafts:
            self._position += 1
            receipts.append(Receipt("refused", reason=self._stall.refuse(self._position, draft.kind)))
        return receipts

    def _moved(self) -> None:
        """A commit has ended, well or not."""
        if self._stall.active:
            self._room.dismiss()
        self._pump.wake()

    def _tell_of_stall(self) -> None:
        """The run before ended while nothing could be written: what it refused by then was never recorded."""
        broken = self._stall_mark.before if self._stall_mark is not None else None
        if broken is not None:
            detail = (
                f"the journal could not be written from {broken.since_ns} ns to the end of that run; {broken.refused} refused"
            )
            self.kernel.write(Noted(what=GAP, detail=detail, source=self._source))

    def _now_ns(self) -> int:
        return self._start_ns + self._monotonic_ns()

    def _says(self) -> str:
        counts = self.kernel.counts
        return f"{counts.admitted} admitted, {counts.refused} refused, {self.kernel.runnable} at work or ready"

    async def _run(self) -> None:
        """Pump, and let the last commit come to its end; nobody waits for ever."""
        failed: Exception | None = None
        try:
            await self._pump.run(self._writer)
        except Exception as error:
            failed = error
        await self._pump.drained(self._writer)
        if failed is None and isinstance(self._writer.error, Exception):
            failed = self._writer.error
        if isinstance(failed, JournalError):
            self._stop(failed)
        elif failed is not None:
            self._stop(JournalError(f"the mind has stopped, nothing more is taken: {failed!r}"))
            raise failed  # a defect: whoever leaves the mind's context hears of it whole

    def _stop(self, error: JournalError) -> None:
        self._why = str(error)
        self._room.close(error)
        self._pump.fail(error)
        self._writer.fail(error)
        self._listeners.fail(error)

    def _settle(self, group: Group) -> None:
        """A group is durable: whoever waited for it hears of it, and what it asked for is done."""
        if self._acts is not None and group.handed:
            self._acts.done(list(group.handed))
        self._listeners.tell(group.requests.lines, group.offered)
        self._act(group.requests)
        self._room.let_in()

    def _act(self, requests: Requests) -> None:
        for call in requests.calls:
            # Where kernel time has gone on over a limit, after a restart say, nobody waits for it any more.
            if self.kernel.awaits(call.process, call.seq):
                self._calls.make(call)
        for training in requests.trainings:
            reach("acting: training")
            self._trainer.start(training)


__all__ = ["GROUP_S", "LiveDriver", "Receipt"]
