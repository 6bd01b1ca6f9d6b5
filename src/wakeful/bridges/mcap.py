"""MCAP recordings as observations, finished or not; ROS 2 (CDR), ROS 1 and JSON messages."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Final

from wakeful.bridges.content import begins_with, digest_of, excerpt, extra, files_in, opened
from wakeful.bridges.ros_raw import Broken, RawMessage, channels, observations
from wakeful.bridges.rosbag import natural
from wakeful.contracts.bridge import Item, Peek, SourceError
from wakeful.facts.time import NS_PER_S

if TYPE_CHECKING:
    from mcap.records import Channel, McapRecord, Schema, Statistics

MAGIC: Final = b"\x89MCAP0\r\n"
_MAX_RECORD_BYTES: Final = 256_000_000
_ENCODINGS: Final = {"cdr": "cdr", "ros1": "ros1", "json": "json", "jsonschema": "json"}


class McapBridge:
    """Reads MCAP files from front to back, so that an unfinished one gives all that was written of it.

    A chunk that is damaged is lost alone; a damaged record ends the file, and one Undecodable says so.
    """

    name = "mcap"

    def claims(self, path: Path) -> bool:
        """By suffix or first bytes; a directory by the ``.mcap`` files in it."""
        if path.is_dir():
            return bool(files_in(path, ".mcap"))
        return path.suffix.lower() == ".mcap" or begins_with(path, MAGIC)

    def peek(self, path: Path) -> Peek:
        """Channels from the first messages, numbers from the summary where the file was finished."""
        summaries = [_summary(file) for file in _files(path)]
        topics = sorted({channel.topic for _, known in summaries for channel in known})
        found = channels(_messages(path), topics)
        statistics = [each for each, _ in summaries if each is not None]
        if len(statistics) < len(summaries):
            return Peek(self.name, found)
        duration_ns = sum(each.message_end_time - each.message_start_time for each in statistics)
        return Peek(self.name, found, sum(each.message_count for each in statistics), duration_ns / NS_PER_S)

    def read(self, path: Path, after: int = -1) -> Iterator[Item]:
        """One item a message, in the order in which they were written."""
        return observations(str(path), _messages(path), after)

    def digest(self, path: Path) -> str:
        """SHA-256 of the file, or of the directory's files."""
        return digest_of(path)


def _files(path: Path) -> list[Path]:
    return sorted(files_in(path, ".mcap"), key=natural) if path.is_dir() else [path]


def _messages(path: Path) -> Iterator[RawMessage | Broken]:
    return chain.from_iterable(_of_file(file) for file in _files(path))


def _of_file(path: Path) -> Iterator[RawMessage | Broken]:
    with extra("ros", "an MCAP recording"):
        from mcap.exceptions import McapError  # noqa: PLC0415
        from mcap.records import Channel, Chunk, Footer, Message, Schema  # noqa: PLC0415
        from mcap.stream_reader import StreamReader, breakup_chunk  # noqa: PLC0415
    schemas: dict[int, Schema] = {}
    known: dict[int, Channel] = {}

    def take(record: McapRecord) -> RawMessage | Broken | None:
        if isinstance(record, Schema):
            schemas[record.id] = record
        elif isinstance(record, Channel):
            known[record.id] = record
        elif isinstance(record, Message):
            if (channel := known.get(record.channel_id)) is None:
                return Broken(f"a message of channel {record.channel_id}, which the file doesn't describe")
            return _message(channel, schemas.get(channel.schema_id), record.log_time, record.data)
        return None

    finished = False
    with opened(path) as file:
        _check(path, file.read(len(MAGIC)))
        records = StreamReader(file, skip_magic=True, emit_chunks=True, record_size_limit=_MAX_RECORD_BYTES).records
        try:
            for record in records:
                if isinstance(record, Footer):
                    finished = True
                    break
                if not isinstance(record, Chunk):
                    if (raw := take(record)) is not None:
                        yield raw
                    continue
                try:
                    inner = breakup_chunk(record, validate_crc=True)
                except Exception as failure:
                    # Three compression libraries raise errors of their own here.
                    yield Broken(f"a chunk of {len(record.data):,} bytes can't be unpacked: {failure}")
                    continue
                for part in inner:
                    if (raw := take(part)) is not None:
                        yield raw
        except (McapError, struct.error, ValueError, EOFError, MemoryError) as failure:
            yield Broken(f"the file is damaged or unfinished here, what follows is lost: {type(failure).__name__}: {failure}")
            return
    if not finished:
        yield Broken("the file has no end: it was not finished")


def _message(channel: Channel, schema: Schema | None, received_ns: int, data: bytes) -> RawMessage:
    kind = schema.name if schema else ""
    parts = kind.split("/")
    return RawMessage(
        channel.topic,
        f"{parts[0]}/msg/{parts[1]}" if len(parts) == 2 else kind,
        received_ns,
        data,
        _ENCODINGS.get(channel.message_encoding, channel.message_encoding),
        schema.data.decode("utf-8", "replace") if schema else "",
        bool(schema) and schema.encoding == "ros2idl" if schema else False,
    )


def _check(path: Path, beginning: bytes) -> None:
    if not beginning:
        raise SourceError(f"{path} is empty: no recording was written to it")
    if beginning != MAGIC:
        raise SourceError(f"{path} is no MCAP file: it begins with {excerpt(beginning)!r}, not with the MCAP mark")


def _summary(path: Path) -> tuple[Statistics | None, list[Channel]]:
    with extra("ros", "an MCAP recording"):
        from mcap.reader import make_reader  # noqa: PLC0415
    with opened(path) as file:
        _check(path, file.read(len(MAGIC)))
        file.seek(0)
        try:
            summary = make_reader(file).get_summary()
        except Exception:
            # The summary is a convenience at the end of a finished file; without it the messages still say what they are.
            return None, []
    return (summary.statistics, list(summary.channels.values())) if summary else (None, [])
