"""A source's own clock: one that was set back is told from one message that was late, by what comes next."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Iterator

from wakeful.contracts.bridge import Item
from wakeful.facts.events import Draft, Observation
from wakeful.facts.evidence import Evidence, Outcome
from wakeful.facts.time import LARGEST_NS, NS_PER_S

#: A clock that runs back by more was set anew, if what comes next agrees; by less, its messages came out of order.
STEP_BACK_NS = 60 * NS_PER_S

#: So many of the next items that have a time must lie back too.
AGREEING = 3

#: So many items are looked at for them.
LOOKED_AT = 12


class Coming(Iterator[Item]):
    """The items of a source, and a look at the next ones. It looks ahead only when it is asked to."""

    def __init__(self, items: Iterable[Item]) -> None:
        self._rest = iter(items)
        self._seen: deque[Item] = deque()

    def __next__(self) -> Item:
        return self._seen.popleft() if self._seen else next(self._rest)

    def next_times_ns(self) -> list[int]:
        """The own times of the next few items, of those that have one."""
        while len(self._seen) < LOOKED_AT:
            item = next(self._rest, None)
            if item is None:
                break
            self._seen.append(item)
        times = (source_time_ns(item) for item in self._seen)
        return [at_ns for at_ns in times if at_ns is not None][:AGREEING]


def set_back(at_ns: int, coming: Coming, shown_ns: int) -> bool:
    """Whether a source's clock was set back before this item.

    Without that its kernel time would stand still until the clock is again where it was: for a day, if it was set back by one.

    Args:
        at_ns: the item's own time.
        coming: the items after it.
        shown_ns: what the clock must show for kernel time to go on.

    >>> from wakeful.facts.events import Undecodable
    >>> set_back(100 * NS_PER_S, Coming([Undecodable(source="s", position=1, reason="")]), 101 * NS_PER_S)
    False
    """
    oldest_ns = shown_ns - STEP_BACK_NS
    if at_ns >= oldest_ns:
        return False
    times = coming.next_times_ns()
    return len(times) == AGREEING and all(each < oldest_ns for each in times)


def source_time_ns(item: Item) -> int | None:
    """The item's own time; None where it has none, or one that no clock shows."""
    if isinstance(item, Observation | Draft | Evidence | Outcome) and abs(item.at_ns) <= LARGEST_NS:
        return item.at_ns
    return None
