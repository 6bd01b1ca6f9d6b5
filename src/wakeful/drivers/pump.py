"""The pump of a live mind: feeds the kernel with what came, lets treatments think, hands what that came to over for commit."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Sequence

from wakeful.contracts.journal import JournalError
from wakeful.drivers.receipts import Batch, Offered, Receipt, place
from wakeful.drivers.sd_notify import Heart
from wakeful.drivers.stalled import HELD_ENTRIES, Stall
from wakeful.drivers.trainer import Trainer
from wakeful.drivers.turn import Turns
from wakeful.drivers.writer import Group, Writer
from wakeful.facts.crash_points import reach
from wakeful.facts.events import CRITICAL, Draft
from wakeful.facts.inputs import Input, Requests
from wakeful.journal.acts import ActSpool, Handed
from wakeful.kernel import Kernel

#: How often finished trainings are looked for while one runs.
_TRAINING_POLL_S = 0.05

#: How often operators' acts are looked for in the folder beside the journal.
ACTS_POLL_S = 0.2

#: So many inputs are a group, however soon they came.
MOST_INPUTS = 64

#: While quick treatments are being caught up with, what comes waits for so long at most, unless it is critical: an event that
#: meets no backlog costs a fraction of one that has to queue, so that to hear it at once would make the backlog grow.
CATCH_UP_S = 0.25

#: A commit of longer is no slow disk but one that hangs: no heartbeat covers for it, and the supervisor acts.
LONGEST_COMMIT_S = 120.0


class Pump:
    """Turn by turn: what came within a group's time is fed together; between groups treatments think; commits go on meanwhile.

    Args:
        kernel: recovered.
        turns: feeds it.
        trainer: runs its trainings.
        stall: says whether nothing can be written for now: then treatments work, and nothing else happens.
        heart: beats at each turn.
        acts: where operators hand in their acts; None: nowhere.
        now_ns: kernel time.
        group_s: inputs that come within so many seconds of one another are fed, and committed, together.
        careful: of so many inputs each group is durable before a treatment runs on it.
    """

    def __init__(
        self,
        kernel: Kernel,
        turns: Turns,
        trainer: Trainer,
        stall: Stall,
        heart: Heart,
        acts: ActSpool | None,
        now_ns: Callable[[], int],
        group_s: float,
        careful: int,
    ) -> None:
        self.kernel = kernel
        self.error: JournalError | None = None
        self.closing = False
        self._turns = turns
        self._trainer = trainer
        self._stall = stall
        self._heart = heart
        self._acts = acts
        self._now_ns = now_ns
        self._group_s = group_s
        self._careful = careful
        self._loop = asyncio.get_running_loop()
        self._offered = self._feeding = Offered()
        self._since_s = 0.0
        self._urgent = False
        self._acts_due_s = 0.0
        self._wake_ns: int | None = None
        self._woken: asyncio.Future[None] | None = None

    @property
    def waiting(self) -> int:
        """How many inputs are not fed yet."""
        return len(self._offered.inputs)

    def put(self, first: Input, *more: Input) -> asyncio.Future[Receipt]:
        """Take one input, with what belongs to it; the receipt is there once all of that is durable.

        Raises:
            JournalError: nothing more is taken.
        """
        future: asyncio.Future[Receipt] = self._loop.create_future()
        self._offer((first, *more))
        self._offered.singles.append((place(first), future))
        return future

    def put_many(self, inputs: Sequence[Input], first: int, until: int) -> asyncio.Future[list[Receipt]]:
        """Take many, with receipts for the events at positions ``first`` to ``until``.

        Raises:
            JournalError: nothing more is taken.
        """
        batch = Batch(self._loop.create_future(), first)
        batch.until = until
        self._offer(inputs)
        self._offered.batches.append(batch)
        return batch.future

    def hear(self, answer: Input) -> None:
        """Take what nobody waits for: the answer to a call."""
        if not self._offered.inputs:
            self._since_s = self._loop.time()
        self._offered.inputs.append(answer)
        self.wake()

    def resume(self, refused: Sequence[Input]) -> None:
        """What was refused while nothing could be written is recorded before anything else is offered: after what had been
        offered before it, so that the source's positions go on."""
        if refused:
            self._offered.inputs.extend(refused)
            self._since_s = self._loop.time() - self._group_s

    def wake(self) -> None:
        """Something has changed: look again."""
        if self._woken is not None and not self._woken.done():
            self._woken.set_result(None)

    def fail(self, error: JournalError) -> None:
        """Whoever waits for what was not fed, or not to its end, hears that it never will be."""
        self.error = error
        self._feeding.fail(error)
        self._offered.fail(error)

    async def begin(self, writer: Writer, recovered: Requests) -> None:
        """What recovery came to is committed before anything is heard.

        Raises:
            BaseException: what the commit raised.
        """
        self._put(writer, recovered, point="recovery: committed")
        await self.drained(writer)
        if writer.error is not None:
            raise writer.error

    async def drained(self, writer: Writer) -> None:
        """Until all that was handed over for commit is durable and acted on, or cannot be."""
        while not writer.idle and writer.error is None:
            await self._wait_for(writer)

    async def run(self, writer: Writer) -> None:
        """Until the mind closes and nothing is due any more.

        Raises:
            BaseException: what the writer's commit raised, or a defect of the kernel.
        """
        while writer.error is None:
            if writer.takes_s < LONGEST_COMMIT_S:
                self._heart.beat()
            if self._stall.active:
                await self._work_on(writer)
            elif writer.full:
                await self._wait_for(writer)
            elif self._acts_due() or self._trainer.ended or (self._ripe() and not self._catching_up()):
                await self._take(writer)
            elif self._due():
                self._put(writer, self._turns.feed((), self._now_ns()))
                await asyncio.sleep(0)  # a treatment is thinking: hear what came, and go on at its next await
            elif self.closing:
                return
            else:
                await self._come(self._until_s())
        raise writer.error

    def _offer(self, inputs: Sequence[Input]) -> None:
        if self.error is not None:
            raise self.error
        if self.closing:
            raise JournalError("the mind is closing; nothing more is taken")
        if not self._offered.inputs:
            self._since_s = self._loop.time()
        self._offered.inputs.extend(inputs)
        self._urgent |= any(each.criticality >= CRITICAL for each in inputs if each.__class__ is Draft)
        self.wake()

    async def _take(self, writer: Writer) -> None:
        """Feed what came."""
        self._feeding, self._offered = self._offered, Offered()
        self._urgent = False
        inputs = self._feeding.inputs
        inputs.extend(self._trainer.finished())
        handed = self._handed()
        inputs.extend(each.act for each in handed)
        now_ns = self._now_ns()
        careful = self._careful > 0 and bool(inputs)
        if careful:  # the run before crashed: an event is durable before its treatment can end this run too
            self._careful -= len(inputs)
            let_go = self._turns.feed((), now_ns)
            requests = let_go.then(self._turns.feed(inputs, now_ns, hold=True))
        else:
            requests = self._turns.feed(inputs, now_ns)
        if handed:
            reach("acts: fed")
        self._put(writer, requests, self._feeding, handed, "acts: committed" if handed else "")
        await asyncio.sleep(0)
        while careful and not writer.idle and writer.error is None and not self._stall.active:
            await self._wait_for(writer)

    def _put(
        self,
        writer: Writer,
        requests: Requests,
        offered: Offered | None = None,
        handed: Sequence[Handed] = (),
        point: str = "",
    ) -> None:
        self._wake_ns = requests.wake_ns
        offered = Offered() if offered is None else offered
        state = self.kernel.changed()
        writer.put(Group(requests=requests, state=state, offered=offered, handed=handed, point=point))

    async def _work_on(self, writer: Writer) -> None:
        """While nothing can be written: work, and nothing else. No input is heard, and kernel time stands still, so that no wait
        runs out unheard."""
        now_ns = self.kernel.now_ns
        ready = self.kernel.runnable > 0 and self._wake_ns is not None and self._wake_ns <= now_ns
        if ready and writer.held_entries < HELD_ENTRIES:
            self._put(writer, self.kernel.feed((), now_ns, 1))
            await asyncio.sleep(0)
        else:
            await self._wait_for(writer)

    # --- when to look again ---

    async def _wait_for(self, writer: Writer) -> None:
        """Until the writer has got on, or it is time for a heartbeat: on a slow disk the mind is well, and says so."""
        if writer.takes_s < LONGEST_COMMIT_S:
            self._heart.beat()
        await self._come(None if self._heart.every_s is None else self._heart.every_s / 2)

    async def _come(self, within_s: float | None) -> None:
        """Until something has changed, or for so long."""
        self._woken = self._loop.create_future()
        timer = None if within_s is None else self._loop.call_later(within_s, self.wake)
        try:
            await self._woken
        finally:
            self._woken = None
            if timer is not None:
                timer.cancel()

    def _until_s(self) -> float | None:
        waits = [_TRAINING_POLL_S] if self._trainer.next_publication_ns() is not None else []
        if self._offered.inputs:
            waits.append(self._since_s + self._group_s - self._loop.time())
        if self._acts is not None:
            waits.append(ACTS_POLL_S)
        if self._heart.every_s is not None:
            waits.append(self._heart.every_s / 2)
        if self._wake_ns is not None:
            waits.append((self._wake_ns - self._now_ns()) / 1e9)
        return max(0.0, min(waits)) if waits else None

    def _ripe(self) -> bool:
        """Whether what came is fed now, rather than with what else comes within a group's time."""
        count = len(self._offered.inputs)
        if not count:
            return False
        return count >= MOST_INPUTS or self.closing or self._loop.time() >= self._since_s + self._group_s

    def _catching_up(self) -> bool:
        """Whether processes whose treatments are quick have queued up, and nothing critical or old waits to be heard."""
        if self._urgent or self.closing or not self.kernel.runnable or not self._turns.quick or not self._due():
            return False
        return not self._offered.inputs or self._loop.time() < self._since_s + CATCH_UP_S

    def _due(self) -> bool:
        """Whether a step can be done at once, or a limit passes."""
        return self._wake_ns is not None and self._wake_ns <= self._now_ns()

    def _acts_due(self) -> bool:
        return self._acts is not None and self._loop.time() >= self._acts_due_s

    def _handed(self) -> list[Handed]:
        if self._acts is None or not self._acts_due():
            return []
        self._acts_due_s = self._loop.time() + ACTS_POLL_S
        return self._acts.waiting()
