"""ROS bags as observations: ROS 1 ``.bag``, ROS 2 SQLite ``.db3``, or the directory of a ROS 2 bag."""

from __future__ import annotations

import re
from collections.abc import Iterator
from itertools import chain
from pathlib import Path
from typing import Final

from wakeful.bridges import ros1_bag, ros2_db3
from wakeful.bridges.content import begins_with, digest_of, excerpt, files_in, opened
from wakeful.bridges.ros1_bag import Summary
from wakeful.bridges.ros_raw import Broken, RawMessage, channels, observations
from wakeful.contracts.bridge import Item, Peek, SourceError

_SUFFIXES: Final = (".bag", ".db3")


class RosbagBridge:
    """Reads a ROS bag in the order in which it was recorded. A bag in several files is one source, its files in order.

    An unfinished or damaged bag gives what comes before the damage, and one Undecodable that says so.
    """

    name = "rosbag"

    def claims(self, path: Path) -> bool:
        """By suffix or first bytes; a directory by the ``.db3`` files in it."""
        if path.is_dir():
            return bool(files_in(path, ".db3"))
        return path.suffix.lower() in _SUFFIXES or begins_with(path, ros1_bag.MAGIC, ros2_db3.MAGIC)

    def peek(self, path: Path) -> Peek:
        """Topics, number of messages and duration from the bag's index; channels from its first messages."""
        summaries = [_summary(file) for file in _files(path)]
        known = [summary for summary in summaries if summary is not None]
        topics = {topic for summary in known for topic in summary.topics}
        found = channels(_messages(path), sorted(topics))
        if len(known) < len(summaries):
            return Peek(self.name, found)
        duration_s = sum(summary.duration_s for summary in known)
        return Peek(self.name, found, sum(summary.messages for summary in known), duration_s)

    def read(self, path: Path, after: int = -1) -> Iterator[Item]:
        """One item a message."""
        return observations(str(path), _messages(path), after)

    def digest(self, path: Path) -> str:
        """SHA-256 of the file, or of the directory's files."""
        return digest_of(path)


def natural(path: Path) -> list[tuple[int, str]]:
    """The order of split recordings: ``bag_2`` before ``bag_10``.

    >>> sorted([Path("bag_10.db3"), Path("bag_2.db3")], key=natural)[0].name
    'bag_2.db3'
    """
    return [(int(part), "") if part.isdecimal() else (-1, part) for part in re.split(r"(\d+)", path.name)]


def _files(path: Path) -> list[Path]:
    if not path.is_dir():
        return [path]
    if not (files := sorted(files_in(path, ".db3"), key=natural)):
        raise SourceError(f"{path} holds no .db3 file; unpack a compressed bag first (zstd -d)")
    return files


def _messages(path: Path) -> Iterator[RawMessage | Broken]:
    return chain.from_iterable(_of_file(file) for file in _files(path))


def _of_file(path: Path) -> Iterator[RawMessage | Broken]:
    if _is_ros2(path):
        yield from ros2_db3.messages(path)
        return
    with opened(path) as file:
        if not (beginning := file.read(len(ros1_bag.MAGIC))):
            raise SourceError(f"{path} is empty: no recording was written to it")
        if beginning != ros1_bag.MAGIC:
            raise SourceError(
                f"{path} is no ROS bag: it begins with {excerpt(beginning)!r}, not with {excerpt(ros1_bag.MAGIC)!r}"
            )
        yield from ros1_bag.messages(file)


def _summary(path: Path) -> Summary | None:
    if _is_ros2(path):
        return ros2_db3.summary(path)
    with opened(path) as file:
        return ros1_bag.summary(file) if file.read(len(ros1_bag.MAGIC)) == ros1_bag.MAGIC else None


def _is_ros2(path: Path) -> bool:
    return begins_with(path, ros2_db3.MAGIC)
