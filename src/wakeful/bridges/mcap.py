"""MCAP recordings as observations, finished or not; ROS 2 (CDR), ROS 1 and JSON messages."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import chain
from pathlib import Path
from typing import Final

from wakeful.bridges.content import begins_with, digest_of, excerpt, extra, files_in, opened
from wakeful.bridges.ros_raw import Broken, RawMessage, channels, observations
from wakeful.bridges.rosbag import natural
from wakeful.contracts.bridge import Item, Peek, SourceError
from wakeful.facts.time import to_s

MAGIC: Final = b"\x89MCAP0\r\n"


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
        """Channels from the first messages, numbers from the summary where every file was finished."""
        with extra("ros", "an MCAP recording"):
            from wakeful.bridges.mcap_records import summary  # noqa: PLC0415
        summaries = [summary(file) for file in _files(path)]
        found = channels(_messages(path), sorted({topic for _, topics in summaries for topic in topics}))
        known = [statistics for statistics, _ in summaries if statistics is not None]
        if len(known) < len(summaries):
            return Peek(self.name, found)
        duration_ns = sum(each.message_end_time - each.message_start_time for each in known)
        return Peek(self.name, found, sum(each.message_count for each in known), to_s(duration_ns))

    def read(self, path: Path, after: int = -1) -> Iterator[Item]:
        """One item a message, in the order in which they were written."""
        return observations(str(path), _messages(path), after)

    def digest(self, path: Path) -> str:
        """SHA-256 of the file, or of the directory's files."""
        return digest_of(path)


def _files(path: Path) -> list[Path]:
    """The recording's files in order, each seen to be an MCAP file. Raises SourceError."""
    files = sorted(files_in(path, ".mcap"), key=natural) if path.is_dir() else [path]
    if not files:
        raise SourceError(f"{path} holds no .mcap file")
    for file in files:
        with opened(file) as content:
            beginning = content.read(len(MAGIC))
        if not beginning:
            raise SourceError(f"{file} is empty: no recording was written to it")
        if beginning != MAGIC:
            raise SourceError(f"{file} is no MCAP file: it begins with {excerpt(beginning)!r}, not with the MCAP mark")
    return files


def _messages(path: Path) -> Iterator[RawMessage | Broken]:
    with extra("ros", "an MCAP recording"):
        from wakeful.bridges.mcap_records import messages  # noqa: PLC0415
    try:
        yield from chain.from_iterable(map(messages, _files(path)))
    except OSError as failure:
        raise SourceError(f"{path} cannot be read on: {failure.strerror or failure}") from failure
