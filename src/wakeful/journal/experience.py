"""Experience that travels: a journal's experiences as a Parquet table with their provenance, and taken up in another journal."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from hashlib import blake2b
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

import msgspec

from wakeful.contracts.journal import Journal, JournalError
from wakeful.facts.events import Event
from wakeful.facts.experience import Experience
from wakeful.facts.lines import Admitted, Gained, Imported, Line, Opened
from wakeful.journal.export import MissingExtra

if TYPE_CHECKING:
    import pyarrow

#: Written into the table's metadata; a table of another version is refused.
VERSION = "1"

_ROWS_PER_GROUP = 10_000
_LINES_PER_COMMIT = 1_000
_TEXT = (
    *("origin", "robot", "domain", "event", "kind", "entity"),
    *("treatment", "treatment_label", "predicted", "outcome", "verdict", "mode"),
)
_WHOLE = ("origin_id", "at_ns")


class _Readable(Protocol):
    def lines(self, after: int = 0) -> Iterator[Line]: ...


class Carried(msgspec.Struct, frozen=True, kw_only=True):
    """One experience with its event, and whose it is: the journal in which it was made, and its id there."""

    origin: str
    origin_id: int
    domain: str
    experience: Experience
    event: Event


class Taken(msgspec.Struct, frozen=True, kw_only=True):
    """What an import did. ``known``: from the same origin with the same id before; ``foreign``: of another domain."""

    imported: int
    known: int
    foreign: int


def origin_of(journal: _Readable) -> str:
    """The journal's identity as an origin: a digest of the first source that it opened, with its seed.

    Two journals of the same recording made the same experiences, and count as the same origin. Empty where nothing was opened.
    """
    for line in journal.lines():
        if isinstance(line.record, Opened):
            first = f"{line.record.source}\x1f{line.record.digest}\x1f{line.record.seed}"
            return blake2b(first.encode(), digest_size=8).hexdigest()
    return ""


def carried(journal: _Readable) -> Iterator[Carried]:
    """A journal's experiences as they stand now: the last of each process, in the order in which they were gained.

    Those that were imported keep their own origin.
    """
    origin = origin_of(journal)
    domain = ""
    events: dict[str, Event] = {}
    found: dict[tuple[str, int], Carried] = {}
    for line in journal.lines():
        record = line.record
        if isinstance(record, Opened):
            domain = record.domain
        elif isinstance(record, Admitted):
            events[record.event.id] = record.event
        elif isinstance(record, Imported):
            each = Carried(
                origin=record.origin,
                origin_id=record.origin_id,
                domain=record.domain,
                experience=record.experience,
                event=record.event,
            )
            found[record.origin, record.origin_id] = each
        elif isinstance(record, Gained) and (event := events.get(record.experience.event)) is not None:
            experience = record.experience
            place = ("", experience.process)
            found.pop(place, None)
            found[place] = Carried(origin=origin, origin_id=experience.id, domain=domain, experience=experience, event=event)
    yield from found.values()


def write_experience(rows: Iterable[Carried], out: Path) -> int:
    """Write a Parquet table, one row an experience: plain columns to query by, the event and the experience as JSON text.

    Returns:
        how many experiences were written.

    Raises:
        MissingExtra: pyarrow is not installed; nothing was written.
    """
    pyarrow = _pyarrow()
    schema = pyarrow.schema(
        [
            *((name, pyarrow.string()) for name in _TEXT),
            *((name, pyarrow.int64()) for name in _WHOLE),
            ("acted_on", pyarrow.bool_()),
            ("weight", pyarrow.float64()),
            ("experience_json", pyarrow.string()),
            ("event_json", pyarrow.string()),
        ],
        metadata={b"wakeful.experience": VERSION.encode()},
    )
    written = 0
    part: list[dict[str, object]] = []
    with pyarrow.parquet.ParquetWriter(out, schema) as writer:
        for each in rows:
            part.append(_row(each))
            written += 1
            if len(part) == _ROWS_PER_GROUP:
                writer.write_table(pyarrow.Table.from_pylist(part, schema=schema))
                part.clear()
        if part:
            writer.write_table(pyarrow.Table.from_pylist(part, schema=schema))
    return written


def read_experience(table: Path) -> Iterator[Carried]:
    """The experiences of a table that ``write_experience`` wrote.

    Raises:
        MissingExtra: pyarrow is not installed.
        JournalError: it is no such table, or a row of it cannot be read; the message names the row.
    """
    pyarrow = _pyarrow()
    try:
        opened = pyarrow.parquet.ParquetFile(table)
    except (OSError, pyarrow.ArrowException) as error:
        raise JournalError(f"{table} cannot be read as a Parquet table: {error}") from error
    metadata = opened.schema_arrow.metadata or {}
    if metadata.get(b"wakeful.experience") != VERSION.encode():
        raise JournalError(f"{table} is not a table of experience (version {VERSION}); 'wakeful experience export' writes one")
    number = 0
    for batch in opened.iter_batches(columns=["origin", "origin_id", "domain", "experience_json", "event_json"]):
        for row in batch.to_pylist():
            number += 1
            try:
                yield Carried(
                    origin=str(row["origin"]),
                    origin_id=int(row["origin_id"]),
                    domain=str(row["domain"]),
                    experience=msgspec.json.decode(row["experience_json"], type=Experience),
                    event=msgspec.json.decode(row["event_json"], type=Event),
                )
            except (msgspec.DecodeError, TypeError, ValueError) as error:
                raise JournalError(f"{table}, row {number}: {error}") from error


def take_up(journal: Journal, rows: Iterable[Carried], domain: str) -> Taken:
    """Record another robot's experiences in a journal that no mind is writing; what is known already is passed over.

    Args:
        journal: open for writing.
        rows: what was exported elsewhere.
        domain: only experiences of this domain are taken: another one's fields mean something else. Empty: of any.

    Returns:
        how many were imported, known before, and of another domain. The next mind on this journal learns from them.

    Raises:
        JournalError: it could not be written; what was committed before that stays, and is known at the next try.
    """
    own, last_id, at_ns, known = origin_of(journal), 0, 0, set()
    for line in journal.lines():
        at_ns = line.at_ns
        if isinstance(line.record, Imported):
            known.add((line.record.origin, line.record.origin_id))
        if isinstance(line.record, Gained | Imported):
            last_id = max(last_id, line.record.experience.id)
    counts = {"imported": 0, "known": 0, "foreign": 0}
    lines: list[Line] = []
    for each in rows:
        if domain and each.domain != domain:
            counts["foreign"] += 1
        elif each.origin == own or (each.origin, each.origin_id) in known:
            counts["known"] += 1
        else:
            known.add((each.origin, each.origin_id))
            last_id += 1
            counts["imported"] += 1
            lines.append(Line(journal.last + len(lines) + 1, at_ns, _imported(each, last_id, at_ns)))
        if len(lines) == _LINES_PER_COMMIT:
            journal.commit(lines, {}, {})
            lines = []
    if lines:
        journal.commit(lines, {}, {})
    return Taken(**counts)


def _imported(each: Carried, number: int, at_ns: int) -> Imported:
    stamp = msgspec.structs.replace(each.event.stamp, received_ns=at_ns)
    return Imported(
        experience=msgspec.structs.replace(each.experience, id=number, process=0),
        event=msgspec.structs.replace(each.event, stamp=stamp),
        origin=each.origin,
        origin_id=each.origin_id,
        domain=each.domain,
    )


def _row(each: Carried) -> dict[str, object]:
    experience, event = each.experience, each.event
    return {
        "origin": each.origin,
        "origin_id": each.origin_id,
        "robot": experience.robot or event.robot,
        "domain": each.domain,
        "event": event.id,
        "kind": event.kind,
        "entity": event.entity,
        "at_ns": event.stamp.source_ns,
        "treatment": experience.treatment,
        "treatment_label": experience.treatment_label,
        "predicted": experience.predicted,
        "outcome": experience.outcome,
        "verdict": experience.verdict.value,
        "mode": experience.mode,
        "acted_on": experience.acted_on,
        "weight": experience.weight,
        "experience_json": msgspec.json.encode(experience).decode(),
        "event_json": msgspec.json.encode(event).decode(),
    }


def _pyarrow() -> pyarrow:
    try:
        import pyarrow  # noqa: PLC0415
        import pyarrow.parquet  # noqa: PLC0415
    except ImportError as error:
        raise MissingExtra("Parquet needs pyarrow: pip install 'wakeful[parquet]'") from error
    return pyarrow
