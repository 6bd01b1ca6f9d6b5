"""Rows: the entries of one commit, or a part of them, as they stand in the table, with what they are about."""

from __future__ import annotations

import zlib
from array import array
from collections.abc import Callable, Iterator, Sequence
from hashlib import blake2b
from typing import get_args

import msgspec

from wakeful.facts.lines import Admitted, AnyRecord, Compacted, Created, Duplicate, Gained, Line, Refused, Reopened, Witnessed
from wakeful.facts.packs import AnyBurst, Covered, Entry, Inquired, Pack, Ran, Validated, Woken, last_position
from wakeful.journal.packed.body import PLAIN, SQUEEZED, BodyWriter
from wakeful.journal.readable import event_of, process_of

#: So many entries stand in one row at most: whoever wants one of them reads them all.
ENTRIES_PER_ROW = 64

_DIGEST_BYTES = 8
_LEVEL = 6

#: No row ends with one of these.
_GO_ON = (Admitted, Created, Reopened)


class Counts(msgspec.Struct):
    """How many inputs of each fate a row holds, how many experiences were gained, and the highest ids in it."""

    admitted: int = 0
    duplicate: int = 0
    refused: int = 0
    gained: int = 0
    process: int = 0
    experience: int = 0


class Row(msgspec.Struct, frozen=True):
    """One row: the positions of its first and last line, the kernel time of the last, the body, and what it is about.

    ``keys`` are four bytes for each event, outcome, process and kind of record in it, in one string: a look-up reads only these.
    """

    first: int
    last: int
    at_ns: int
    body: bytes
    counts: Counts
    keys: bytes
    form: int = PLAIN
    version: int = 0
    born: int = 0

    @property
    def id(self) -> int:
        """The row's key: by its first position; several versions of what stands there may be there at once."""
        return self.first * VERSIONS + self.version

    @property
    def stored(self) -> tuple[int, int, int, bytes, bytes]:
        """As it stands in the table ``rows``."""
        return (self.id, self.last, self.form, digest_of(self.first, self.body), self.body)

    @property
    def about(self) -> tuple[int | bytes | None, ...]:
        """As it stands in the table ``about``."""
        return (self.id, self.last, self.at_ns, *msgspec.structs.astuple(self.counts), self.born, None, self.keys)


#: How many versions of a row may have the same first position.
VERSIONS = 4

ROWS_COLUMNS, ABOUT_COLUMNS = 5, 12


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


def rows_of(entries: Sequence[Entry], writer: BodyWriter, form: int = PLAIN) -> Iterator[Row]:
    """The rows that hold entries which follow one another.

    An event's admission stands in one row with the creation of its process: what is kept of a row is kept of both.

    Args:
        entries: packed or not.
        writer: of their bodies; the words that it learns must be committed with the rows.
        form: how the bodies are written.
    """
    start = 0
    while start < len(entries):
        end = min(len(entries), start + ENTRIES_PER_ROW)
        while end < len(entries) and _goes_on(entries[end - 1]):
            end += 1
        yield _row(entries[start:end], writer, form)
        start = end


def _goes_on(entry: Entry) -> bool:
    return isinstance(entry, Line) and isinstance(entry.record, _GO_ON)


def first_position(entry: Entry) -> int:
    """The position of an entry's first line; of a line that stands for others, that of the first of them."""
    if isinstance(entry, Line) and isinstance(entry.record, Compacted):
        return entry.record.first
    return entry.position


def _row(entries: Sequence[Entry], writer: BodyWriter, form: int) -> Row:
    numbers: set[int] = set()
    kinds: set[type] = set()
    counts = Counts()
    add, crc32 = numbers.add, zlib.crc32
    for entry in entries:
        if isinstance(entry, Pack):
            burst = entry.burst
            kinds.add(burst.__class__)
            if isinstance(burst, Ran):  # the two that every automatic event writes, without a call
                add(crc32(burst.event.encode()))
                add(burst.process & 0xFFFFFFFF)
            elif isinstance(burst, Covered):
                add(crc32(burst.event.id.encode()))
                add(burst.process & 0xFFFFFFFF)
                counts.admitted += 1
                if burst.process > counts.process:
                    counts.process = burst.process
            else:
                numbers.update(_ABOUT[burst.__class__](burst))
                count_burst(burst, counts)
        else:
            kinds.add(entry.record.__class__)
            count(entry.record, counts, numbers)
    for kind in kinds:
        numbers |= _KINDS_OF[kind]
    body = writer.write(entries)
    return Row(
        first=first_position(entries[0]),
        last=last_position(entries[-1]),
        at_ns=entries[-1].at_ns,
        body=zlib.compress(body, _LEVEL) if form == SQUEEZED else body,
        counts=counts,
        keys=array("I", numbers).tobytes(),
        form=form,
    )


def count_burst(burst: AnyBurst, counts: Counts) -> None:
    """Add one burst to the counts."""
    if isinstance(burst, Covered):
        counts.admitted += 1
        counts.process = max(counts.process, burst.process)
    elif isinstance(burst, Validated):
        counts.gained += 1
        counts.experience = max(counts.experience, burst.experience.id)


def count(record: AnyRecord, counts: Counts, numbers: set[int]) -> None:
    """Add one record to the counts, and what it is about to the numbers that the keys are made of."""
    event, process = event_of(record), process_of(record)
    if event:
        numbers.add(zlib.crc32(event.encode()))
    if process:
        numbers.add(process & 0xFFFFFFFF)
    match record:
        case Admitted():
            counts.admitted += 1
        case Duplicate():
            counts.duplicate += 1
        case Refused():
            counts.refused += 1
        case Created():
            counts.process = max(counts.process, process)
        case Gained():
            counts.gained += 1
            counts.experience = max(counts.experience, record.experience.id)
        case Witnessed():
            numbers.add(zlib.crc32(record.outcome.id.encode()))
        case Compacted():
            counts.admitted += record.admitted
            counts.duplicate += record.duplicate
            counts.refused += record.refused
            counts.gained += record.gained
            counts.process = max(counts.process, record.process)
            counts.experience = max(counts.experience, record.experience)
        case _:
            pass


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
    Validated: lambda burst: (_crc(burst.judged.event), burst.judged.process & 0xFFFFFFFF, _crc(burst.outcome.id)),
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
