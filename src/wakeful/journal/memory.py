"""A journal in memory, for tests, experiments and minds that need not survive."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterator, Mapping, Sequence

from wakeful.contracts.journal import JournalError
from wakeful.facts.lines import Line
from wakeful.facts.packs import Entry, expanded, last_position


class MemoryJournal:
    """The Journal contract without a file. Nothing survives the process."""

    def __init__(self) -> None:
        self._entries: list[Entry] = []
        self._ends: list[int] = []
        self._state: dict[str, bytes] = {}
        self._blobs: dict[str, bytes] = {}

    @property
    def last(self) -> int:
        """The last position, 0 when empty."""
        return self._ends[-1] if self._ends else 0

    def commit(self, lines: Sequence[Entry], state: Mapping[str, bytes | None], blobs: Mapping[str, bytes]) -> None:
        """Append lines, replace state, add blobs.

        Raises:
            JournalError: the positions don't continue the journal's; nothing was kept.
        """
        last = self.last
        ends = []
        for entry in lines:
            if entry.position != last + 1:
                raise JournalError(f"line {entry.position} does not follow {last}")
            last = last_position(entry)
            ends.append(last)
        self._entries.extend(lines)
        self._ends.extend(ends)
        for key, value in state.items():
            if value is None:
                self._state.pop(key, None)
            else:
                self._state[key] = value
        self._blobs.update(blobs)

    def lines(self, after: int = 0) -> Iterator[Line]:
        """The lines with position > ``after``, in order."""
        return (line for line in expanded(self.entries(after)) if line.position > after)

    def entries(self, after: int = 0) -> Iterator[Entry]:
        """What was committed with position > ``after``, in order, packs as packs."""
        return iter(self._entries[bisect_right(self._ends, after) :])

    def state(self) -> dict[str, bytes]:
        """The keyed state as of the last commit."""
        return dict(self._state)

    def blob(self, name: str) -> bytes:
        """The bytes of a blob.

        Raises:
            JournalError: there is none of that name.
        """
        try:
            return self._blobs[name]
        except KeyError:
            raise JournalError(f"there is no blob {name}") from None

    def tidy(self, least_events: int = 0) -> bool:  # noqa: ARG002
        """Nothing to do: nothing of it survives."""
        return False

    def close(self) -> None:
        """Nothing to release."""
