"""Events that await their outcome, taken up as evidence in the order in which they were decided."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator

import msgspec


class Waiting(msgspec.Struct):
    """One event that could be automatic. ``wrong`` is None until its outcome is decided, and where nobody decides it.

    ``number`` is that of the certificate, standing or wanted, for which it is evidence. ``predicted`` is the label that the
    model's answer forecast; ``automatic`` whether the gate allowed it, ``ran`` whether it was decided to be automatic, ``mode``
    how it was executed in the end. ``judgeable``: a result was concluded with a window in which the world may judge it.
    ``settled``: no more is to come. ``doubted``: a reasoner answered otherwise, and the outcome is still to come.
    """

    process: int
    event: str
    number: int
    treatment: str
    predicted: str
    place: int
    automatic: bool
    probability: float
    drawn: bool
    mode: str
    ran: bool
    judgeable: bool = False
    settled: bool = False
    doubted: bool = False
    wrong: bool | None = None


class InOrder:
    """A queue by order of decision: bad news often comes first, and evidence in the order of arrival would be slanted by it.

    ``longest`` is how many stood in it at most: the delay of outcomes, counted in events.
    """

    def __init__(self) -> None:
        self._queue: deque[Waiting] = deque()
        self.longest = 0

    def __len__(self) -> int:
        return len(self._queue)

    def add(self, waiting: Waiting) -> None:
        """An event was decided."""
        self._queue.append(waiting)
        self.longest = max(self.longest, len(self._queue))

    def ready(self) -> Iterator[Waiting]:
        """Take out the events at the head that are settled."""
        while self._queue and self._queue[0].settled:
            yield self._queue.popleft()
