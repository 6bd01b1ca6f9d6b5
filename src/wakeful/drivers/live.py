"""The live driver: asyncio over the same kernel. What is admitted is durable before its admission returns."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import TYPE_CHECKING
from uuid import uuid4

import msgspec

from wakeful.contracts.journal import Journal, JournalError, JournalStalled
from wakeful.contracts.learner import Learner
from wakeful.contracts.reasoner import Reasoner
from wakeful.drivers import garbage
from wakeful.drivers.blobs import JournalBlobs
from wakeful.drivers.outside import make
from wakeful.drivers.poison import CAREFUL_INPUTS, CrashMark, marked, take_up
from wakeful.drivers.room import Room
from wakeful.drivers.sd_notify import Heart
from wakeful.drivers.stalled import HELD_ENTRIES, RETRY_S, Stall, StallMark
from wakeful.drivers.tidying import Tidying
from wakeful.drivers.trainer import Trainer
from wakeful.facts.crash_points import reach
from wakeful.facts.events import CRITICAL, Draft, Observation
from wakeful.facts.evidence import Evidence, Outcome
from wakeful.facts.inputs import Act, Answer, Begin, Call, Input, Mark, Requests
from wakeful.facts.lines import GAP, Admitted, Answered, Concluded, Duplicate, Line, Moved, Noted, Refused
from wakeful.facts.packs import Covered, Entry
from wakeful.facts.processes import State
from wakeful.journal.acts import ActSpool, Handed
from wakeful.kernel import Kernel
from wakeful.scheduling.evidence import KEPT

if TYPE_CHECKING:
    from types import TracebackType

#: Inputs that come within so many seconds of one another are committed together.
GROUP_S = 0.005

#: How often finished trainings are looked for while one runs.
_TRAINING_POLL_S = 0.05

#: How often operators' acts are looked for in the folder beside the journal.
ACTS_POLL_S = 0.2

#: For about so long treatments think before the driver looks whether something came. It measures how long their steps take and
#: gives as many as fit: one at a time where steps are slow, so that a treatment is preempted at its next await.
TURN_S = 0.002

#: At most so many steps, however short they were.
MOST_STEPS = 4096


class Receipt(msgspec.Struct, frozen=True):
    """What became of an offered event, once that is durable: ``admitted``, ``duplicate`` or ``refused`` with its reason."""

    status: str
    event: str = ""
    reason: str = ""


class _Batch:
    """Events that were offered together: positions from ``first`` to ``until``, and who waits for their receipts."""

    __slots__ = ("first", "future", "until")

    def __init__(self, future: asyncio.Future[list[Receipt]], first: int) -> None:
        self.future = future
        self.first = self.until = first


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
    ) -> None:
        self.kernel = kernel
        self.journal = journal
        self._reasoner = reasoner
        self._trainer = Trainer(learner)
        self._tidying = Tidying(journal)
        self._tidied: asyncio.Future[bool] | None = None
        self._stall_mark = stall_mark
        self._stall = Stall(source, self._now_ns, stall_mark)
        self._retry_s = retry_s
        self._source = source
        self._clock_ns = clock_ns
        self._acts = acts
        self._closes_journal = closes_journal
        self._settles_garbage = settles_garbage
        self._group_s = group_s
        self._monotonic_ns = monotonic_ns
        self._crash_mark = crash_mark
        self._heart = heart if heart is not None else Heart()
        self._careful = 0
        self._room = Room(kernel.settings.overload, lambda: len(self._inbox) // 2 + kernel.backlog)
        self._acts_due_s = 0.0
        self._feeding: dict[object, asyncio.Future[Receipt]] = {}
        self._inbox: list[tuple[Input, asyncio.Future[Receipt] | None]] = []
        self._batches: list[_Batch] = []
        self._feeding_batches: list[_Batch] = []
        self._called: dict[tuple[int, int], asyncio.Task[None]] = {}
        self._settled: dict[str, list[asyncio.Future[Concluded]]] = {}
        self._commits = ThreadPoolExecutor(max_workers=1, thread_name_prefix="wakeful-journal")
        self._position = -1
        self._state: dict[str, bytes | None] = {}
        self._wake_ns: int | None = None
        self._step_s = TURN_S
        self._error: JournalError | None = None
        self._closing = False

    async def __aenter__(self) -> LiveDriver:
        self._woken = asyncio.Event()
        self._careful = CAREFUL_INPUTS if take_up(self._crash_mark, self.journal) is not None else 0
        if self._crash_mark is not None:
            self.kernel.mark_on(self._crash_mark.page)
        recovered = self.kernel.recover(self.journal.entries(), self.journal.state(), JournalBlobs(self.journal))
        self._start_ns = max(self._clock_ns(), self.kernel.now_ns) - self._monotonic_ns()
        recovered = await self._commit(recovered)
        reach("recovery: committed")
        await self._act(recovered)
        known = self.kernel.source(self._source)
        if known is not None and not known.finished:
            self._position, digest = known.cursor, known.digest
        else:
            digest = uuid4().hex
        if self._settles_garbage:
            garbage.settle()
        self._inbox.append((Begin(source=self._source, digest=digest), None))
        self._tell_of_stall()
        self._pump_task = asyncio.create_task(self._pump())
        self._woken.set()
        self._heart.ready(self._says)
        return self

    async def __aexit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self._closing = True
        self._room.close(JournalError("the mind is closing; nothing more is taken"))
        self._woken.set()
        await self._pump_task
        under_way = list(self._called.values())
        for task in under_way:
            task.cancel()  # a call without an answer is in the journal as asked, and is made again at the next start
        await asyncio.gather(*under_way, return_exceptions=True)
        self._trainer.close()
        self._commits.shutdown()
        if self._crash_mark is not None:
            self._crash_mark.close()
        self._stall.close()
        self._heart.stop(str(self._error or ""))
        if self._closes_journal:
            self.journal.close()

    @property
    def busy(self) -> bool:
        """Whether something was offered and not yet fed, or a call is under way."""
        return bool(self._inbox or self._called)

    async def admit(self, draft: Draft, patience_s: float | None = None) -> Receipt:
        """Offer an event; returns once what became of it is durable.

        Args:
            draft: the event; its source and position are the mind's own.
            patience_s: where the backlog has no room the caller waits, at most so long: then the event is offered all the same,
                and may be refused with a reason. None: until there is room.

        Raises:
            JournalError: it could not be written; it is not admitted.
        """
        await self._room.enter(draft.criticality >= CRITICAL, patience_s)
        self._position += 1
        if self._stall.active:
            return Receipt("refused", reason=self._stall.refuse(self._position, draft.kind))
        placed = msgspec.structs.replace(draft, source=self._source, position=self._position)
        return await self._put(placed, Mark(source=self._source, position=self._position))

    async def admit_many(self, drafts: Sequence[Draft], patience_s: float | None = None) -> list[Receipt]:
        """Offer many events at once; returns once what became of each is durable. Costs a fraction of what they do one by one."""
        if not drafts:
            return []
        await self._room.enter(any(draft.criticality >= CRITICAL for draft in drafts), patience_s)
        return await self.take_many(drafts)

    async def take_many(self, inputs: Sequence[Draft | Evidence | Outcome]) -> list[Receipt]:
        """Hand over events, evidence and outcomes in the order of their coming, without waiting for room; returns once all of
        it is durable, with a receipt for each event.

        Raises:
            JournalError: it could not be written; nothing of it was taken.
        """
        if self._error is not None:
            raise self._error
        if self._closing:
            raise JournalError("the mind is closing; nothing more is taken")
        batch = _Batch(asyncio.get_running_loop().create_future(), self._position + 1)
        for each in inputs:
            if isinstance(each, Draft):
                self._position += 1
                self._inbox.append((msgspec.structs.replace(each, source=self._source, position=self._position), None))
            else:
                self._inbox.append((each, None))
        batch.until = self._position
        self._inbox.append((Mark(source=self._source, position=self._position), None))
        self._batches.append(batch)
        self._woken.set()
        return await batch.future

    async def observe(self, observation: Observation) -> None:
        """Hand over an observation; returns once what it led to is durable. Registration decides whether it is an event."""
        await self._room.enter(False, None)
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

    def _tell_of_stall(self) -> None:
        """The run before ended while nothing could be written: what it refused by then was never recorded."""
        broken = self._stall_mark.before if self._stall_mark is not None else None
        if broken is not None:
            detail = (
                f"the journal could not be written from {broken.since_ns} ns to the end of that run; {broken.refused} refused"
            )
            self.kernel.write(Noted(what=GAP, detail=detail, source=self._source))

    # --- the pump: feed, commit, act ---

    def _now_ns(self) -> int:
        return self._start_ns + self._monotonic_ns()

    async def _pump(self) -> None:
        try:
            await self._turns()
        except JournalError as error:
            self._stop(error)
        except Exception as error:
            self._stop(JournalError(f"the mind has stopped, nothing more is taken: {error!r}"))
            raise  # a defect: whoever leaves the mind's context hears of it whole

    def _stop(self, error: JournalError) -> None:
        """Nobody waits for ever: all that was offered and is not durable fails, and so does every wait for a conclusion."""
        self._error = error
        self._room.close(error)
        waiting: list[asyncio.Future[Receipt]] = [*self._feeding.values(), *(each for _, each in self._inbox if each is not None)]
        for future in waiting:
            if not future.done():
                future.set_exception(error)
        for each in (*self._feeding_batches, *self._batches):
            if not each.future.done():
                each.future.set_exception(error)
        for waiter in (each for waiters in self._settled.values() for each in waiters):
            if not waiter.done():
                waiter.set_exception(error)

    async def _turns(self) -> None:
        while True:
            await self._wait()
            self._heart.beat()
            batch, self._inbox = self._inbox, []
            batches, self._batches = self._batches, []
            self._feeding_batches = batches
            inputs = [each for each, _ in batch]
            inputs.extend(self._trainer.finished())
            handed = self._handed()
            inputs.extend(each.act for each in handed)
            if self._closing and not inputs and not self._due():
                break
            futures = self._feeding = {_place(each): future for each, future in batch if future is not None}
            requests = await self._think(inputs)
            if handed:
                reach("acts: fed")
            requests = await self._commit(requests)
            if self._acts is not None:
                if handed:
                    reach("acts: committed")
                self._acts.done(handed)
            self._answer(requests.lines, futures, batches)
            await self._act(requests)
            self._room.let_in()

    async def _wait(self) -> None:
        """Until something comes, something is due, or a training may have ended; then a moment for more of the same."""
        if not self._inbox and self._due():
            await asyncio.sleep(0)  # a treatment is thinking: hear what came, and go on at its next await
        elif not self._inbox and not self._closing:
            self._woken.clear()
            waits = [_TRAINING_POLL_S] if self._trainer.next_publication_ns() is not None else []
            if self._acts is not None:
                waits.append(ACTS_POLL_S)
            if self._heart.every_s is not None:
                waits.append(self._heart.every_s / 2)
            if self._wake_ns is not None:
                waits.append(max(0.0, (self._wake_ns - self._now_ns()) / 1e9))
            try:
                await asyncio.wait_for(self._woken.wait(), min(waits, default=None))
            except TimeoutError:
                return
        if self._inbox and not self._closing:
            await asyncio.sleep(self._group_s)

    async def _think(self, inputs: list[Input]) -> Requests:
        """Feed, then let treatments think for as long as a group lasts, hearing what comes at each of their awaits."""
        began_s = time.monotonic()
        if self._careful > 0 and inputs:  # the run before crashed: an event is durable before its treatment can end this run too
            self._careful -= len(inputs)
            let_go = self._fed(())
            return let_go.then(self.kernel.feed(inputs, self._now_ns(), hold=True))
        requests = self._fed(inputs)
        self._wake_ns = requests.wake_ns
        while self._due() and not self._inbox and time.monotonic() - began_s < self._group_s:
            await asyncio.sleep(0)
            requests = requests.then(self._fed(()))
            self._wake_ns = requests.wake_ns
        return requests

    def _fed(self, inputs: Sequence[Input]) -> Requests:
        """Feed, giving treatments as many steps as fit into a turn, by how long steps took before."""
        steps = max(1, min(MOST_STEPS, int(TURN_S / self._step_s)))
        done, began_s = self.kernel.steps_done, time.monotonic()
        requests = self.kernel.feed(inputs, self._now_ns(), steps)
        done = self.kernel.steps_done - done
        if done:
            took_s = (time.monotonic() - began_s) / done
            # A slow step counts at once, quick ones little by little.
            self._step_s = took_s if took_s > self._step_s else 0.75 * self._step_s + 0.25 * took_s
        return requests

    def _says(self) -> str:
        counts = self.kernel.counts
        return f"{counts.admitted} admitted, {counts.refused} refused, {self.kernel.runnable} at work or ready"

    def _due(self) -> bool:
        """Whether a step can be done at once."""
        return self.kernel.runnable > 0 and self._wake_ns is not None and self._wake_ns <= self._now_ns()

    def _handed(self) -> list[Handed]:
        now_s = time.monotonic()
        if self._acts is None or now_s < self._acts_due_s:
            return []
        self._acts_due_s = now_s + ACTS_POLL_S
        return self._acts.waiting()

    async def _commit(self, requests: Requests) -> Requests:
        """Make them durable, however long that takes; returns them, with what was worked meanwhile."""
        while True:
            try:
                await self._write(requests)
            except JournalStalled as error:
                if self._closing:
                    raise
                self._stall.begin(str(error))
                requests = await self._work_on(requests)
            else:
                self._inbox[:0] = [(each, None) for each in self._stall.over()]
                return requests

    async def _work_on(self, requests: Requests) -> Requests:
        """Until writing is tried again: work, and nothing else. No input is heard, and kernel time stands still, so that no wait
        runs out unheard."""
        self._heart.beat()
        until_s = time.monotonic() + self._retry_s
        wake_ns: int | None = self.kernel.now_ns
        while time.monotonic() < until_s and len(requests.lines) < HELD_ENTRIES:
            if not self.kernel.runnable or wake_ns is None or wake_ns > self.kernel.now_ns:
                break
            requests = requests.then(self.kernel.feed((), self.kernel.now_ns, 1))
            wake_ns = requests.wake_ns
            await asyncio.sleep(0)
        await asyncio.sleep(max(0.0, until_s - time.monotonic()))
        return requests

    async def _write(self, requests: Requests) -> None:
        self._state.update(self.kernel.changed())
        # Evidence that nobody waits for yet gives no line, and whoever told it was promised that it is durable.
        if requests.lines or requests.blobs or any(key.startswith(KEPT) for key in self._state):
            reach("feed: decided")
            loop = asyncio.get_running_loop()
            state, self._state = self._state, {}
            try:
                await loop.run_in_executor(self._commits, self.journal.commit, requests.lines, state, requests.blobs)
            except JournalStalled:
                self._state = {**state, **self._state}
                raise
            if requests.blobs:
                reach("publication: committed")
            if self._tidied is None or self._tidied.done():
                self._tidied = loop.run_in_executor(self._commits, self._tidying.turn)

    def _answer(
        self, entries: tuple[Entry, ...], futures: Mapping[object, asyncio.Future[Receipt]], batches: Sequence[_Batch]
    ) -> None:
        receipts: dict[object, Receipt] = {}
        for line in self._telling(entries, receipts):
            record = line.record
            if isinstance(record, Admitted):
                receipts[record.event.position] = Receipt("admitted", record.event.id)
            elif isinstance(record, Duplicate):
                receipts[record.position] = Receipt("duplicate", record.event)
            elif isinstance(record, Refused):
                receipts[record.position] = Receipt("refused", record.event, record.reason)
            elif isinstance(record, Answered):
                self._give_up(record.process, record.seq)
            elif isinstance(record, Moved):
                if record.after is State.COMPLETED:
                    self._give_up(record.process)
            elif isinstance(record, Concluded):
                for waiter in self._settled.pop(record.event, ()):
                    if not waiter.done():
                        waiter.set_result(record)
        for place, future in futures.items():
            if not future.done():
                future.set_result(receipts.get(place, _TAKEN))
        for each in batches:
            if not each.future.done():
                each.future.set_result([receipts.get(place, _TAKEN) for place in range(each.first, each.until + 1)])

    def _telling(self, entries: tuple[Entry, ...], receipts: dict[object, Receipt]) -> Iterator[Line]:
        """The lines that somebody may wait for; of packs the receipts alone, where nobody waits for what is concluded."""
        for entry in entries:
            if isinstance(entry, Line):
                yield entry
            elif isinstance(entry.burst, Covered):
                event = entry.burst.event
                receipts[event.position] = Receipt("admitted", event.id)
            elif self._settled:
                yield from entry.lines()

    async def _act(self, requests: Requests) -> None:
        self._wake_ns = requests.wake_ns
        for call in requests.calls:
            task = asyncio.create_task(self._call(call))
            self._called[call.process, call.seq] = task
        for training in requests.trainings:
            reach("acting: training")
            self._trainer.start(training)

    def _give_up(self, process: int, seq: int | None = None) -> None:
        """Nobody waits for these calls any more: another may have their place."""
        for place in [each for each in self._called if each[0] == process and seq in (None, each[1])]:
            self._called.pop(place).cancel()

    async def _call(self, call: Call) -> None:
        left_s = max(0.0, (call.expires_ns - self._now_ns()) / 1e9)
        reach("acting: call")
        try:
            async with asyncio.timeout(left_s):
                answer = await make(marked(call, self._crash_mark), self._reasoner)
            reach("acting: call made")
        except TimeoutError:
            answer = Answer(process=call.process, seq=call.seq, error="expired")
        self._called.pop((call.process, call.seq), None)
        self._inbox.append((answer, None))
        self._woken.set()


_TAKEN = Receipt("taken")


def _place(item: Input) -> object:
    """What a receipt is found by: the position of an event, or the input itself where it has none."""
    return item.position if isinstance(item, Draft | Observation) else id(item)
