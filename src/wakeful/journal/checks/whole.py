"""The journal beside its lines: it ends where its last commit ended, and as much was offered as was received."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping

import msgspec

from wakeful.contracts.journal import JournalError
from wakeful.facts.lines import Admitted, Compacted, Duplicate, Line, Noted, Refused
from wakeful.journal.checks.check import Check

_NOTHING = Line(0, 0, Noted(what="", detail=""))


class Whole(Check):
    """The lines end where the last commit ended: nothing was cut off.

    Args:
        commits: the last position of each commit, in order, as of the same instant as the lines.
    """

    name = "whole"
    says = "the lines end where the last commit ended, and each commit added to the one before it"

    def __init__(self, commits: Iterable[int]) -> None:
        super().__init__()
        self._commits = commits
        self._last = _NOTHING

    def see(self, line: Line) -> None:
        """The last one counts."""
        self._last = line

    def end(self) -> None:
        """All lines were read."""
        before = 0
        try:
            for last in self._commits:
                self.checked += 1
                if last <= before:
                    self.offend(self._last, f"a commit up to line {last} follows one up to {before}")
                before = last
        except JournalError as error:
            self.offend(self._last, str(error))
            return
        if before != self._last.position:
            self.offend(self._last, f"the lines end at {self._last.position}, but the last commit ended at {before}")


class _SourceOffered(msgspec.Struct):
    offered: int | None = None


class _Offered(msgspec.Struct):
    sources: dict[str, _SourceOffered] = {}


class Offered(Check):
    """As many events and undecodable inputs as were offered are admitted, duplicate or refused.

    The kernel counts what is offered before admission decides on it, and commits the count with the lines.

    Args:
        state: gives the keyed state as of the same instant as the lines.
    """

    name = "offered"
    says = "as many inputs as were offered before admission are admitted, duplicate or refused"

    def __init__(self, state: Callable[[], Mapping[str, bytes]]) -> None:
        super().__init__()
        self._state = state
        self._received = 0
        self._last = _NOTHING

    def see(self, line: Line) -> None:
        """Count what was received."""
        self._last = line
        record = line.record
        if isinstance(record, Compacted):
            self._received += record.admitted + record.duplicate + record.refused
        self._received += isinstance(record, Admitted | Duplicate | Refused)

    def end(self) -> None:
        """All lines were read."""
        try:
            kept = self._state().get("kernel", b"{}")
            sources = msgspec.json.decode(kept, type=_Offered).sources
        except (JournalError, msgspec.DecodeError, UnicodeDecodeError) as error:
            self.offend(self._last, f"the kernel's state cannot be read: {error}")
            return
        counts = [source.offered for source in sources.values() if source.offered is not None]
        if len(counts) < len(sources) or not sources:
            self.skipped = "it was not counted what was offered when this journal was written"
            return
        self.checked = sum(counts)
        if self.checked != self._received:
            self.offend(self._last, f"{self.checked} inputs were offered, but {self._received} became a line of the intake")
