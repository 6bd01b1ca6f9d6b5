"""A journal as JSON lines or as a Parquet table, whole or without what differs from run to run."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

import msgspec

from wakeful.facts.crashes import CRASHED
from wakeful.facts.lines import RESUMPTION, Admitted, Line, Noted, Opened
from wakeful.journal.readable import Readable, event_of, process_of, tag_of

_ROWS_PER_GROUP = 10_000


class MissingExtra(Exception):
    """An optional package is not installed. The message names the extra that brings it."""


def exported(journal: Readable, *, stable: bool = False) -> Iterator[Line]:
    """The lines to export.

    Args:
        journal: any journal.
        stable: leave out wall-clock fields and resumption records and count positions anew, so that an interrupted run
            and an undisturbed one of the same seed are equal, byte for byte.

    Returns:
        the lines, in order.
    """
    if not stable:
        yield from journal.lines()
        return
    position = 0
    for line in journal.lines():
        record = line.record
        if isinstance(record, Opened) and record.resumed_at > 0:
            continue
        if isinstance(record, Noted) and record.what in (RESUMPTION, CRASHED):
            continue
        position += 1
        if isinstance(record, Admitted):
            stamp = msgspec.structs.replace(record.event.stamp, received_ns=0)
            record = Admitted(event=msgspec.structs.replace(record.event, stamp=stamp))
        elif isinstance(record, Opened):
            record = msgspec.structs.replace(record, software="")
        yield Line(position, line.at_ns, record)


def write_jsonl(journal: Readable, out: BinaryIO, *, stable: bool = False) -> int:
    """Write one JSON object a line: ``position``, ``at_ns``, ``record``.

    Returns:
        how many lines were written.
    """
    encoder = msgspec.json.Encoder()
    written = 0
    for line in exported(journal, stable=stable):
        out.write(encoder.encode(line))
        out.write(b"\n")
        written += 1
    return written


def write_parquet(journal: Readable, out: Path, *, stable: bool = False) -> int:
    """Write a Parquet table: position, at_ns, kind, event, process, and the record as JSON text.

    Returns:
        how many lines were written.

    Raises:
        MissingExtra: pyarrow is not installed; nothing was written.
    """
    try:
        import pyarrow  # noqa: PLC0415
        import pyarrow.parquet  # noqa: PLC0415
    except ImportError as error:
        raise MissingExtra("Parquet needs pyarrow: pip install 'wakeful[parquet]'") from error
    schema = pyarrow.schema(
        [
            ("position", pyarrow.int64()),
            ("at_ns", pyarrow.int64()),
            ("kind", pyarrow.string()),
            ("event", pyarrow.string()),
            ("process", pyarrow.int64()),
            ("record", pyarrow.string()),
        ]
    )
    encoder = msgspec.json.Encoder()
    written = 0
    rows: list[dict[str, int | str]] = []
    with pyarrow.parquet.ParquetWriter(out, schema) as writer:
        for line in exported(journal, stable=stable):
            rows.append(
                {
                    "position": line.position,
                    "at_ns": line.at_ns,
                    "kind": tag_of(line.record),
                    "event": event_of(line.record),
                    "process": process_of(line.record),
                    "record": encoder.encode(line.record).decode(),
                }
            )
            written += 1
            if len(rows) == _ROWS_PER_GROUP:
                writer.write_table(pyarrow.Table.from_pylist(rows, schema=schema))
                rows.clear()
        if rows:
            writer.write_table(pyarrow.Table.from_pylist(rows, schema=schema))
    return written
