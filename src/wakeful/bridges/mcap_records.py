"""MCAP files record by record, from front to back. Needs the extra ``ros``; imported where it is wanted."""

from __future__ import annotations

import dataclasses
import io
import struct
from collections.abc import Iterator
from pathlib import Path
from typing import Final

from mcap.exceptions import McapError
from mcap.reader import make_reader
from mcap.records import Channel, Chunk, Footer, McapRecord, Message, Schema, Statistics
from mcap.stream_reader import StreamReader, breakup_chunk

from wakeful.bridges.ros_raw import Broken, RawMessage
from wakeful.bridges.unpacking import unpacked

MAGIC_BYTES: Final = 8
_MAX_RECORD_BYTES: Final = 256_000_000
_ENCODINGS: Final = {"jsonschema": "json"}
_DAMAGE: Final = (McapError, struct.error, ValueError, OverflowError, EOFError, MemoryError)


def messages(path: Path) -> Iterator[RawMessage | Broken]:
    """The messages in the order in which they were written.

    A chunk that can't be unpacked is lost alone; a damaged or missing record ends the file. Raises OSError.
    """
    described = _Described()
    with _Bounded(path) as file:
        file.seek(MAGIC_BYTES)
        records = StreamReader(file, skip_magic=True, emit_chunks=True, record_size_limit=_MAX_RECORD_BYTES).records
        try:
            for record in records:
                if isinstance(record, Footer):
                    return
                yield from described.chunk(record) if isinstance(record, Chunk) else described.take(record)
        except _DAMAGE as failure:
            yield Broken(f"the file is damaged or unfinished here, what follows is lost: {type(failure).__name__}: {failure}")
            return
    yield Broken("the file has no end: it was not finished")


def summary(path: Path) -> tuple[Statistics | None, tuple[str, ...]]:
    """The statistics and topics at the end of a finished file; nothing where it has none. Raises OSError."""
    with _Bounded(path) as file:
        try:
            found = make_reader(file).get_summary()
        except (*_DAMAGE, OSError):
            return None, ()
    return (found.statistics, tuple(channel.topic for channel in found.channels.values())) if found else (None, ())


class _Bounded(io.BufferedReader):
    """A file that refuses to read more at once than a record may hold, whatever a damaged length says."""

    def __init__(self, path: Path) -> None:
        super().__init__(io.FileIO(path))

    def read(self, size: int | None = -1, /) -> bytes:
        """As the stream, within a limit."""
        if size is not None and size > _MAX_RECORD_BYTES:
            raise ValueError(f"a record of {size:,} bytes; the limit is {_MAX_RECORD_BYTES:,}")
        return super().read(size)


class _Described:
    """The schemas and channels that a file has described so far."""

    def __init__(self) -> None:
        self._schemas: dict[int, Schema] = {}
        self._channels: dict[int, Channel] = {}

    def chunk(self, chunk: Chunk) -> Iterator[RawMessage | Broken]:
        """The messages of one chunk, or why it cannot be read."""
        try:
            if chunk.uncompressed_size > _MAX_RECORD_BYTES:
                raise ValueError(f"it holds {chunk.uncompressed_size:,} bytes")
            if chunk.compression:
                data = unpacked(chunk.compression, chunk.data, _MAX_RECORD_BYTES)
                chunk = dataclasses.replace(chunk, compression="", data=data)
            records = breakup_chunk(chunk, validate_crc=True)
        except Exception as failure:
            # Each compression library raises errors of its own; none of them derives from another's.
            yield Broken(f"a chunk of {len(chunk.data):,} bytes can't be unpacked: {failure}")
            return
        for record in records:
            yield from self.take(record)

    def take(self, record: McapRecord) -> Iterator[RawMessage | Broken]:
        """The messages of one record."""
        if isinstance(record, Schema):
            self._schemas[record.id] = record
        elif isinstance(record, Channel):
            self._channels[record.id] = record
        elif isinstance(record, Message):
            yield self._message(record)

    def _message(self, message: Message) -> RawMessage | Broken:
        if (channel := self._channels.get(message.channel_id)) is None:
            return Broken(f"a message of channel {message.channel_id}, which the file doesn't describe")
        schema = self._schemas.get(channel.schema_id)
        kind = schema.name if schema else ""
        package, _, name = kind.partition("/")
        return RawMessage(
            topic=channel.topic,
            kind=f"{package}/msg/{name}" if name and "/" not in name else kind,
            received_ns=message.log_time,
            data=message.data,
            encoding=_ENCODINGS.get(channel.message_encoding, channel.message_encoding),
            definition=schema.data.decode("utf-8", "replace") if schema else "",
            idl=schema is not None and schema.encoding == "ros2idl",
        )
