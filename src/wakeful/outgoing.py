"""What a feed asks of its driver, gathered while the rooms do their work: entries to commit, weights, calls and trainings."""

from __future__ import annotations

from wakeful.facts.inputs import Call, Requests, Training
from wakeful.facts.lines import AnyRecord, Line
from wakeful.facts.packs import AnyBurst, Entry, Pack


class Outgoing:
    """Gathers, and numbers the lines: ``position`` is the last one's."""

    def __init__(self) -> None:
        self.position = 0
        self._entries: list[Entry] = []
        self._blobs: dict[str, bytes] = {}
        self._calls: list[Call] = []
        self._trainings: list[Training] = []

    @property
    def asks(self) -> bool:
        """Whether anything outside is to be done, once the entries are durable."""
        return bool(self._calls or self._trainings)

    def line(self, record: AnyRecord, at_ns: int) -> None:
        """One record is to be committed."""
        self.position += 1
        self._entries.append(Line(self.position, at_ns, record))

    def pack(self, burst: AnyBurst, at_ns: int) -> None:
        """Several records are to be committed as one entry."""
        self._entries.append(Pack(self.position + 1, at_ns, burst))
        self.position += burst.count

    def blob(self, name: str, content: bytes) -> None:
        """Weights are to be committed with them."""
        self._blobs[name] = content

    def call(self, call: Call) -> None:
        """A call is to be made."""
        self._calls.append(call)

    def train(self, training: Training) -> None:
        """A training is to be run."""
        self._trainings.append(training)

    def take(self, wake_ns: int | None, left: int) -> Requests:
        """All of it, and when the kernel wants to be fed again; from here on it gathers anew."""
        requests = Requests(
            lines=tuple(self._entries),
            blobs=self._blobs,
            calls=tuple(self._calls),
            trainings=tuple(self._trainings),
            wake_ns=wake_ns,
            left=left,
        )
        self._entries, self._blobs, self._calls, self._trainings = [], {}, [], []
        return requests
