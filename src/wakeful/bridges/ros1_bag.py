"""ROS 1 bags (format 2.0), read from front to back: an unfinished or damaged one gives what comes before the damage.

The format: http://wiki.ros.org/Bags/Format/2.0. The index at the end is used by ``summary`` alone.
"""

from __future__ import annotations

import io
import struct
from collections.abc import Iterator
from typing import BinaryIO, Final

import msgspec

from wakeful.bridges.ros_raw import Broken, RawMessage
from wakeful.bridges.unpacking import unpacked
from wakeful.facts.time import NS_PER_S

MAGIC: Final = b"#ROSBAG V2.0\n"
MAX_RECORD_BYTES: Final = 256_000_000
_LENGTH: Final = struct.Struct("<I")
_POSITION: Final = struct.Struct("<Q")
_TIME: Final = struct.Struct("<II")
_PACKINGS: Final = ("none", "bz2", "lz4")
_MESSAGE, _BAG, _INDEX, _CHUNK, _CHUNK_INFO, _CONNECTION = 2, 3, 4, 5, 6, 7

Fields = dict[bytes, bytes]


class Damaged(ValueError):
    """The bytes are no record of a bag."""


class _Connection(msgspec.Struct, frozen=True):
    topic: str
    kind: str
    definition: str


class Summary(msgspec.Struct, frozen=True):
    """What a bag's index says: its topics, how many messages, over what time."""

    topics: tuple[str, ...]
    messages: int
    duration_s: float


def messages(file: BinaryIO) -> Iterator[RawMessage | Broken]:
    """The messages in the order in which they were written. ``file`` stands after MAGIC."""
    connections: dict[int, _Connection] = {}
    try:
        while record := _record(file):
            fields, data = record
            kind = _operation(fields)
            if kind == _CHUNK:
                yield from _chunk(fields, data, connections)
            elif kind == _CONNECTION:
                _learn(fields, data, connections)
            elif kind == _MESSAGE:
                yield _message(fields, data, connections)
    except (Damaged, struct.error) as failure:
        yield Broken(f"the bag is damaged or unfinished here, what follows is lost: {failure}")


def summary(file: BinaryIO) -> Summary | None:
    """What the index says; None where there is none. ``file`` stands after MAGIC."""
    connections: dict[int, _Connection] = {}
    count, earliest_ns, latest_ns = 0, None, 0
    try:
        first = _record(file)
        if first is None or not (index_at := _POSITION.unpack(first[0][b"index_pos"])[0]):
            return None
        file.seek(index_at)
        while record := _record(file):
            fields, data = record
            if (kind := _operation(fields)) == _CONNECTION:
                _learn(fields, data, connections)
            elif kind == _CHUNK_INFO:
                start_ns, end_ns = _time_ns(fields[b"start_time"]), _time_ns(fields[b"end_time"])
                earliest_ns = start_ns if earliest_ns is None else min(earliest_ns, start_ns)
                latest_ns = max(latest_ns, end_ns)
                count += sum(number for _, number in struct.iter_unpack("<II", data))
    except (Damaged, struct.error, KeyError, OverflowError, OSError):
        return None
    if earliest_ns is None:
        return None
    topics = tuple(sorted({each.topic for each in connections.values()}))
    return Summary(topics, count, (latest_ns - earliest_ns) / NS_PER_S)


def _record(stream: BinaryIO) -> tuple[Fields, bytes] | None:
    head = stream.read(_LENGTH.size)
    if not head:
        return None
    fields = _fields(_exactly(stream, _LENGTH.unpack(head)[0]))
    size = _LENGTH.unpack(_exactly(stream, _LENGTH.size))[0]
    if fields.get(b"compression") == b"none" and size <= MAX_RECORD_BYTES:
        # An unfinished chunk's messages are as good as any; its last one is found out to be cut when it is read.
        return fields, stream.read(size)
    return fields, _exactly(stream, size)


def _exactly(stream: BinaryIO, size: int) -> bytes:
    if size > MAX_RECORD_BYTES:
        raise Damaged(f"a record of {size:,} bytes")
    if len(data := stream.read(size)) < size:
        raise Damaged("it ends in the middle of a record")
    return data


def _fields(header: bytes) -> Fields:
    fields: Fields = {}
    at = 0
    while at < len(header):
        end = at + _LENGTH.size + _LENGTH.unpack_from(header, at)[0]
        name, sign, value = header[at + _LENGTH.size : end].partition(b"=")
        if not sign or end > len(header):
            raise Damaged("a record's header is garbled")
        fields[name] = value
        at = end
    return fields


def _operation(fields: Fields) -> int:
    if not (kind := fields.get(b"op")):
        raise Damaged("a record says no kind")
    return kind[0]


def _chunk(fields: Fields, data: bytes, connections: dict[int, _Connection]) -> Iterator[RawMessage | Broken]:
    """A chunk's messages. A chunk that can't be unpacked is lost alone; one that turns out garbled, from there on."""
    packing = fields.get(b"compression", b"none").decode("ascii", "replace")
    if packing not in _PACKINGS:
        yield Broken(f"a chunk packed as {packing!r}, which is not read here (none, bz2 and lz4 are)")
        return
    try:
        stream = io.BytesIO(data if packing == "none" else unpacked(packing, data, MAX_RECORD_BYTES))
    except (OSError, ValueError, RuntimeError, EOFError) as failure:
        yield Broken(f"a chunk of {len(data):,} bytes can't be unpacked: {failure}")
        return
    try:
        while record := _record(stream):
            inner, body = record
            if (kind := _operation(inner)) == _CONNECTION:
                _learn(inner, body, connections)
            elif kind == _MESSAGE:
                yield _message(inner, body, connections)
    except (Damaged, struct.error) as failure:
        yield Broken(f"a chunk is damaged, the rest of it is lost: {failure}")


def _learn(fields: Fields, data: bytes, connections: dict[int, _Connection]) -> None:
    said = _fields(data)
    topic = (fields.get(b"topic") or said.get(b"topic") or b"").decode("utf-8", "replace")
    package, _, name = said.get(b"type", b"").decode("utf-8", "replace").rpartition("/")
    definition = said.get(b"message_definition", b"").decode("utf-8", "replace")
    connections[_number(fields, b"conn")] = _Connection(topic, f"{package}/msg/{name}", definition)


def _message(fields: Fields, data: bytes, connections: dict[int, _Connection]) -> RawMessage | Broken:
    if (connection := connections.get(number := _number(fields, b"conn"))) is None:
        return Broken(f"a message of connection {number}, which the bag doesn't describe")
    return RawMessage(connection.topic, connection.kind, _time_ns(fields.get(b"time", b"")), data, "ros1", connection.definition)


def _number(fields: Fields, name: bytes) -> int:
    number: int = _LENGTH.unpack(fields.get(name, b""))[0]
    return number


def _time_ns(packed: bytes) -> int:
    seconds, nanoseconds = _TIME.unpack(packed)
    return int(seconds) * NS_PER_S + int(nanoseconds)
