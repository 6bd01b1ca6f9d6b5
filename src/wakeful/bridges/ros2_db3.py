"""ROS 2 bags in SQLite storage (``.db3``), message by message."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Final
from urllib.parse import quote

import apsw

from wakeful.bridges.ros1_bag import Summary
from wakeful.bridges.ros_raw import Broken, RawMessage
from wakeful.contracts.bridge import SourceError
from wakeful.facts.time import NS_PER_S

MAGIC: Final = b"SQLite format 3\x00"
#: What a damaged database makes of a query; texts in it may be no text any more.
_DAMAGE: Final = (apsw.Error, UnicodeDecodeError)


def messages(path: Path) -> Iterator[RawMessage | Broken]:
    """The messages in the order in which they were written, which is that of their receipt.

    That order needs no index and no sorting, so that a damaged bag gives what comes before the damage. A file that is shorter
    than it says is refused as a whole: its last page could only be read filled up with zeros, in the midst of messages.

    Raises:
        SourceError: the file is no ROS 2 bag.
    """
    database = _opened(path)
    try:
        definitions = _definitions(database)
        topics = _topics(path, database)
        try:
            for number, received_ns, data in database.execute("SELECT topic_id, timestamp, data FROM messages ORDER BY id"):
                yield _message(topics.get(_whole(number)), definitions, received_ns, data)
        except _DAMAGE as failure:
            yield Broken(f"the bag's database is damaged here, what follows is lost: {failure}")
    finally:
        database.close()


def summary(path: Path) -> Summary:
    """Topics, number of messages and duration. Raises SourceError as ``messages`` does."""
    database = _opened(path)
    try:
        topics = tuple(sorted(topic for topic, _, _ in _topics(path, database).values()))
        count, first_ns, last_ns = next(database.execute("SELECT count(*), min(timestamp), max(timestamp) FROM messages"))
        return Summary(topics, _whole(count), (_whole(last_ns) - _whole(first_ns)) / NS_PER_S)
    except _DAMAGE as failure:
        raise _unreadable(path, failure) from failure
    finally:
        database.close()


def _opened(path: Path) -> apsw.Connection:
    # Without its write-ahead file the bag is finished: nothing is locked or written beside it then.
    finished = not path.with_name(f"{path.name}-wal").exists()
    try:
        address = f"file:{quote(str(path.absolute()))}?mode=ro{'&immutable=1' if finished else ''}"
        return apsw.Connection(address, flags=apsw.SQLITE_OPEN_READONLY | apsw.SQLITE_OPEN_URI)
    except _DAMAGE as failure:
        raise _unreadable(path, failure) from failure


def _topics(path: Path, database: apsw.Connection) -> dict[int, tuple[str, str, str]]:
    """Topic number → (name, type, serialisation)."""
    try:
        rows = database.execute("SELECT id, name, type, serialization_format FROM topics").fetchall()
        database.execute("SELECT timestamp, data, topic_id FROM messages LIMIT 1").fetchall()
    except _DAMAGE as failure:
        raise _unreadable(path, failure) from failure
    return {_whole(number): (str(name), str(kind), str(packing)) for number, name, kind, packing in rows}


def _definitions(database: apsw.Connection) -> dict[str, tuple[str, bool]]:
    """Type → (definition, whether it is IDL). Bags before ROS 2 Iron have none."""
    try:
        rows = database.execute("SELECT topic_type, encoding, encoded_message_definition FROM message_definitions").fetchall()
    except _DAMAGE:
        return {}
    return {str(kind): (str(definition), encoding == "ros2idl") for kind, encoding, definition in rows}


def _message(
    topic: tuple[str, str, str] | None, definitions: dict[str, tuple[str, bool]], received_ns: object, data: object
) -> RawMessage | Broken:
    if topic is None:
        return Broken("a message of a topic that the bag doesn't describe")
    name, kind, packing = topic
    if not isinstance(data, bytes) or not isinstance(received_ns, int):
        return Broken(f"{name}: a row without message or time")
    definition, idl = definitions.get(kind, ("", False))
    return RawMessage(name, kind, received_ns, data, packing, definition, idl)


def _whole(value: object) -> int:
    return value if isinstance(value, int) else 0


def _unreadable(path: Path, failure: Exception) -> SourceError:
    return SourceError(f"{path} is no ROS 2 bag that can be read ({failure}); copy it again, or try: sqlite3 FILE .recover")
