"""Who waits for what became of what they offered, and for what is concluded: told once that is durable."""

from __future__ import annotations

import asyncio
from collections.abc import Iterator, Sequence

import msgspec

from wakeful.drivers.calling import Calls
from wakeful.facts.events import Draft, Observation
from wakeful.facts.inputs import Input
from wakeful.facts.lines import Admitted, Answered, Concluded, Duplicate, Line, Moved, Refused
from wakeful.facts.packs import Covered, Entry
from wakeful.facts.processes import State


class Receipt(msgspec.Struct, frozen=True):
    """What became of an offered event, once that is durable: ``admitted``, ``duplicate`` or ``refused`` with its reason."""

    status: str
    event: str = ""
    reason: str = ""


#: What is no event is taken, and there is no more to say of it.
TAKEN = Receipt("taken")


class Batch:
    """Events that were offered together: positions from ``first`` to ``until``, and who waits for their receipts."""

    __slots__ = ("first", "future", "until")

    def __init__(self, future: asyncio.Future[list[Receipt]], first: int) -> None:
        self.future = future
        self.first = self.until = first


class Offered:
    """What was handed over and is fed together, in the order of its coming, and who waits for it."""

    __slots__ = ("batches", "inputs", "singles")

    def __init__(self) -> None:
        self.inputs: list[Input] = []
        self.singles: list[tuple[object, asyncio.Future[Receipt]]] = []
        self.batches: list[Batch] = []

    def fail(self, error: Exception) -> None:
        """It will never be durable."""
        for _, single in self.singles:
            if not single.done():
                single.set_exception(error)
        for batch in self.batches:
            if not batch.future.done():
                batch.future.set_exception(error)

    def answer(self, receipts: dict[object, Receipt]) -> None:
        """All of it is durable."""
        for place, single in self.singles:
            if not single.done():
                single.set_result(receipts.get(place, TAKEN))
        for batch in self.batches:
            if not batch.future.done():
                batch.future.set_result([receipts.get(place, TAKEN) for place in range(batch.first, batch.until + 1)])


class Listeners:
    """Tells everybody who waits what a commit means for them.

    Args:
        calls: those under way, of which some are given up by what was recorded.
    """

    def __init__(self, calls: Calls) -> None:
        self._calls = calls
        self._concluded: dict[str, list[asyncio.Future[Concluded]]] = {}

    def concluded(self, event: str) -> asyncio.Future[Concluded]:
        """The next conclusion on an event."""
        future: asyncio.Future[Concluded] = asyncio.get_running_loop().create_future()
        self._concluded.setdefault(event, []).append(future)
        return future

    def tell(self, entries: Sequence[Entry], offered: Offered) -> None:
        """These entries are durable: whoever waits for one of them hears of it."""
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
                self._calls.give_up(record.process, record.seq)
            elif isinstance(record, Moved):
                if record.after is State.COMPLETED:
                    self._calls.give_up(record.process)
            elif isinstance(record, Concluded):
                for waiter in self._concluded.pop(record.event, ()):
                    if not waiter.done():
                        waiter.set_result(record)
        offered.answer(receipts)

    def fail(self, error: Exception) -> None:
        """Nothing more is concluded."""
        for waiter in (each for waiters in self._concluded.values() for each in waiters):
            if not waiter.done():
                waiter.set_exception(error)

    def _telling(self, entries: Sequence[Entry], receipts: dict[object, Receipt]) -> Iterator[Line]:
        """The lines that somebody may wait for; of packs the receipts alone, where nobody waits for what is concluded."""
        for entry in entries:
            if isinstance(entry, Line):
                yield entry
            elif isinstance(entry.burst, Covered):
                event = entry.burst.event
                receipts[event.position] = Receipt("admitted", event.id)
            elif self._concluded:
                yield from entry.lines()


def place(item: Input) -> object:
    """What a receipt is found by: the position of an event, or the input itself where it has none."""
    return item.position if isinstance(item, Draft | Observation) else id(item)
