"""Rows: the entries of one commit, or a part of them, as they stand in the table, with what they are about."""

from __future__ import annotations

import zlib
from array import array
from collections.abc import Callable, Iterator, Sequence
from hashlib import blake2b
from typing import get_args

import msgspec

from wakeful.facts.lines import Admitted, AnyRecord, Compacted, Duplicate, Refused
from wakeful.facts.packs import AnyBurst, Covered, Entry, Inquired, Pack, Ran, Validated, Woken, last_position
from wakeful.journal.compact.body import PLAIN, BodyWriter
from wakeful.journal.readable import event_of, process_of

#: So many entries stand in one row at most: whoever wants one of them reads them all.
ENTRIES_PER_ROW = 256

_DIGEST_BYTES = 8


class Row(msgspec.Struct, frozen=True):
    """One row: the positions of its first and last line, the kernel time of the last, the body, and what it is about.

    ``keys`` are four bytes for each event, process and kind of record in it, in one string: a look-up reads only these.
    """

    first: int
    last: int
    at_ns: int
    body: bytes
    keys: bytes
    admitted: int
    duplicate: int
    refused: int
    form: int = PLAIN

    @property
    def digest(self) -> bytes:
        """What tells a damaged body, or one that stands in another's place."""
        return digest_of(self.first, self.body)


def digest_of(first: int, body: bytes) -> bytes:
    """The digest of a body whose first line has that position."""
    return blake2b(body, digest_size=_DIGEST_BYTES, key=first.to_bytes(8, "big")).digest()


def event_key(event: str) -> bytes:
    """The key of an event. Keys of different things may be equal: what is found by them must be looked at."""
    return _bytes(zlib.crc32(event.encode()))


def process_key(process: int) -> bytes:
    """The key of a process."""
    return _bytes(process & 0xFFFFFFFF)


def kind_key(kind: str) -> bytes:
    """The key of a kind of record, by its tag."""
    return _bytes(zlib.crc32(b"kind " + kind.encode()))


def rows_of(entries: Sequence[Entry], writer: BodyWriter) -> Iterator[Row]:
    """The rows that hold entries which follow one another.

    Args:
        entries: packed or not.
        writer: of their bodies; the words that it learns must be committed with the rows.
    """
    for start in range(0, len(entries), ENTRIES_PER_ROW):
        yield _row(entries[start : start + ENTRIES_PER_ROW], writer)


def _row(entries: Sequence[Entry], writer: BodyWriter) -> Row:
    numbers: set[int] = set()
    kinds: set[type] = set()
    admitted = duplicate = refused = 0
    for entry in entries:
        if isinstance(entry, Pack):
            burst = entry.burst
            cls = burst.__class__
            kinds.add(cls)
            numbers.update(_ABOUT[cls](burst))
            admitted += cls is Covered
        else:
            record = entry.record
            event, process = event_of(record), process_of(record)
            if event:
                numbers.add(zlib.crc32(event.encode()))
            if process:
                numbers.add(process & 0xFFFFFFFF)
            kinds.add(record.__class__)
            if isinstance(record, Admitted):
                admitted += 1
            elif isinstance(record, Duplicate):
                duplicate += 1
            elif isinstance(record, Refused):
                refused += 1
            elif isinstance(record, Compacted):
                admitted, duplicate, refused = (
                    admitted + record.admitted,
                    duplicate + record.duplicate,
                    refused + record.refused,
                )
    for kind in kinds:
        numbers |= _KINDS_OF[kind]
    return Row(
        first=entries[0].position,
        last=last_position(entries[-1]),
        at_ns=entries[-1].at_ns,
        body=writer.write(entries),
        keys=array("I", numbers).tobytes(),
        admitted=admitted,
        duplicate=duplicate,
        refused=refused,
    )


def _bytes(number: int) -> bytes:
    return array("I", (number,)).tobytes()


def _number(key: bytes) -> int:
    return array("I", key)[0]


def _crc(event: str) -> int:
    return zlib.crc32(event.encode())


_About = Callable[..., tuple[int, ...]]

_ABOUT: dict[type, _About] = {
    Covered: lambda burst: (_crc(burst.event.id), burst.process & 0xFFFFFFFF),
    Inquired: lambda burst: (burst.asked.process & 0xFFFFFFFF,),
    Woken: lambda burst: (burst.answered.process & 0xFFFFFFFF,),
    Ran: lambda burst: (_crc(burst.event), burst.process & 0xFFFFFFFF),
    Validated: lambda burst: (_crc(burst.judged.event), burst.judged.process & 0xFFFFFFFF),
}

#: The kinds of record that an entry stands for: a record for its own, a burst for several.
_KINDS_OF: dict[type, frozenset[int]] = {
    cls: frozenset(_number(kind_key(kind)) for kind in kinds.split())
    for cls, kinds in {
        **{cls: cls.__name__.lower() for cls in get_args(AnyRecord)},
        Covered: "admitted created decided",
        Inquired: "moved asked",
        Woken: "answered moved",
        Ran: "moved concluded",
        Validated: "witnessed judged gained trusted",
    }.items()
}

if set(_ABOUT) != set(get_args(AnyBurst)):
    raise TypeError("a burst is missing here: a row must say what each of its entries is about")
