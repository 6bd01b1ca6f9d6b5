"""A journal in memory, for tests, experiments and minds that need not survive."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from wakeful.contracts.journal import JournalError
from wakeful.facts.lines import Line


class MemoryJournal:
    """The Journal contract without a file. Nothing survives the process."""

    def __init__(self) -> None:
        self._lines: list[Line] = []
        self._state: dict[str, bytes] = {}
        self._blobs: dict[str, bytes] = {}

    @property
    def last(self) -> int:
        """The last position, 0 when empty."""
        return len(self._lines)

    def commit(self, lines: Sequence[Line], state: Mapping[str, bytes | None], blobs: Mapping[str, bytes]) -> None:
        """Append lines, replace state, add blobs.

        Raises:
            JournalError: the positions don't continue the journal's; nothing was kept.
        """
        for expected, line in enumerate(lines, self.last + 1):
            if line.position != expected:
                raise JournalError(f"line {line.position} does not follow {expected - 1}")
        self._lines.extend(lines)
        for key, value in state.items():
            if value is None:
                self._state.pop(key, None)
            else:
                self._state[key] = value
        self._blobs.update(blobs)

    def lines(self, after: int = 0) -> Iterator[Line]:
        """The lines with position > ``after``, in order."""
        return iter(self._lines[after:])

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

    def close(self) -> None:
        """Nothing to release."""
