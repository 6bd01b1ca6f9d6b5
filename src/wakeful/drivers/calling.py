"""The calls under way in real time: each a task of its own, given up when nobody waits for its answer any more."""

from __future__ import annotations

import asyncio
from collections.abc import Callable

from wakeful.contracts.reasoner import Reasoner
from wakeful.drivers.outside import make
from wakeful.drivers.poison import CrashMark, marked
from wakeful.facts.crash_points import reach
from wakeful.facts.inputs import Answer, Call


class Calls:
    """Makes calls, and hands their answers over.

    Args:
        reasoner: answers the kernel's questions.
        crash_mark: says whose function is running; None: nobody will know.
        now_ns: kernel time, by which calls expire.
        answered: takes each answer.
    """

    def __init__(
        self, reasoner: Reasoner, crash_mark: CrashMark | None, now_ns: Callable[[], int], answered: Callable[[Answer], None]
    ) -> None:
        self._reasoner = reasoner
        self._crash_mark = crash_mark
        self._now_ns = now_ns
        self._answered = answered
        self._under_way: dict[int, dict[int, asyncio.Task[None]]] = {}

    def __len__(self) -> int:
        """How many are under way."""
        return sum(map(len, self._under_way.values()))

    def make(self, call: Call) -> None:
        """Begin a call that is recorded as asked."""
        self._under_way.setdefault(call.process, {})[call.seq] = asyncio.create_task(self._make(call))

    def give_up(self, process: int, seq: int | None = None) -> None:
        """Nobody waits for these calls any more: another may have their place."""
        of_process = self._under_way.get(process)
        if of_process is None:
            return
        for each in list(of_process) if seq is None else [seq] * (seq in of_process):
            of_process.pop(each).cancel()
        if not of_process:
            del self._under_way[process]

    async def close(self) -> None:
        """A call without an answer is in the journal as asked, and is made again at the next start."""
        under_way = [task for each in self._under_way.values() for task in each.values()]
        for task in under_way:
            task.cancel()
        await asyncio.gather(*under_way, return_exceptions=True)

    async def _make(self, call: Call) -> None:
        left_s = (call.expires_ns - self._now_ns()) / 1e9
        answer = Answer(process=call.process, seq=call.seq, error="expired")
        if left_s > 0.0:  # else what it does outside would come after all who waited for it have gone on
            reach("acting: call")
            try:
                async with asyncio.timeout(left_s):
                    answer = await make(marked(call, self._crash_mark), self._reasoner)
                reach("acting: call made")
            except TimeoutError:
                pass
        of_process = self._under_way.get(call.process, {})
        of_process.pop(call.seq, None)
        if not of_process:
            self._under_way.pop(call.process, None)
        self._answered(answer)
