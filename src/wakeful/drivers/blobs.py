"""The journal's blobs as a mapping that reads only what is asked for."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from wakeful.contracts.journal import Journal, JournalError


class JournalBlobs(Mapping[str, bytes]):
    """Blobs by name, read when they are looked up."""

    def __init__(self, journal: Journal) -> None:
        self._journal = journal

    def __getitem__(self, name: str) -> bytes:
        try:
            return self._journal.blob(name)
        except JournalError as error:
            raise KeyError(name) from error

    def __iter__(self) -> Iterator[str]:
        return iter(())

    def __len__(self) -> int:
        return 0
