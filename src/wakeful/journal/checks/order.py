"""The journal itself: every line can be read, none is missing, and kernel time never runs back."""

from __future__ import annotations

from collections.abc import Iterator

from wakeful.contracts.journal import JournalError
from wakeful.facts.lines import Compacted, Line
from wakeful.journal.checks.check import Check, Offence
from wakeful.journal.readable import Readable


class ReadableLines(Check):
    """Every line can be read as what it says it is. It stands before the others, which see only what can be read."""

    name = "readable"
    says = "every line can be read"

    def of(self, journal: Readable) -> Iterator[Line]:
        """The journal's lines, up to the first that cannot be read."""
        last = 0
        try:
            for line in journal.lines():
                self.checked += 1
                last = line.position
                yield line
        except JournalError as error:
            self.offences += 1
            self.first = Offence(position=last + 1, record="unreadable", says=str(error))


class Positions(Check):
    """Positions count from 1 without a gap, but where counts stand for lines that were given up."""

    name = "positions"
    says = "positions count from 1 without a gap; what was compacted stands there with its counts"

    def __init__(self) -> None:
        super().__init__()
        self._last = 0

    def see(self, line: Line) -> None:
        """Each position is the last one's successor."""
        self.checked += 1
        record = line.record
        first = record.first if isinstance(record, Compacted) else line.position
        if first != self._last + 1:
            self.offend(line, f"position {first} follows {self._last}")
        elif isinstance(record, Compacted) and record.lines != line.position - first + 1:
            self.offend(line, f"{record.lines} lines are said to stand from {first} to {line.position}")
        self._last = line.position


class Time(Check):
    """Kernel time never runs back."""

    name = "time"
    says = "kernel time never runs back"

    def __init__(self) -> None:
        super().__init__()
        self._last: int | None = None

    def see(self, line: Line) -> None:
        """Each instant is not before the last one's."""
        self.checked += 1
        if self._last is not None and line.at_ns < self._last:
            self.offend(line, f"kernel time {line.at_ns} ns comes after {self._last} ns")
        self._last = line.at_ns
