"""PX4 flight logs (ULog) as observations, in time order over all topics."""

from __future__ import annotations

import contextlib
import io
import re
import struct
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Final

import numpy as np

from wakeful.bridges.content import begins_with, digest_of, excerpt, extra, opened
from wakeful.bridges.instants import LATEST_NS
from wakeful.bridges.plain import text
from wakeful.bridges.ulog_events import LEVELS, TOPIC, EventTexts
from wakeful.bridges.ulog_topics import Layout, kept_rows
from wakeful.contracts.bridge import Item, Peek, SourceError
from wakeful.facts.events import Observation, Undecodable
from wakeful.facts.values import Value

if TYPE_CHECKING:
    from pyulog import ULog

MAGIC: Final = b"ULog\x01\x12\x35"
_SUFFIXES: Final = (".ulg", ".ulog")
_HEADER: Final = struct.Struct("<HB")
_NS_PER_US: Final = 1_000
_LATEST_US: Final = LATEST_NS // _NS_PER_US
#: Colours for a terminal, and what else can't be shown.
_CONTROL: Final = re.compile(r"\x1b\[[0-9;]*m|[\x00-\x08\x0b-\x1f\x7f]")
_MODULE: Final = re.compile(r"\[([\w ./-]{1,40})\]\s*")

Values = Callable[[], dict[str, Value]]


class UlogBridge:
    """Reads a flight log. Times are those of the autopilot's clock, which began at its start (``clock`` is ``boot``).

    The log is held in memory as arrays (the library needs it), rows are made one by one.

    Args:
        max_hz: streams of measurements are thinned to this many rows a second; 0 keeps all. Part of the digest where it is
            not the default, since positions depend on it.
    """

    name = "ulog"

    def __init__(self, max_hz: float = 10.0) -> None:
        self.max_hz = max_hz

    def claims(self, path: Path) -> bool:
        """By suffix or first bytes."""
        return path.suffix.lower() in _SUFFIXES or begins_with(path, MAGIC)

    def peek(self, path: Path) -> Peek:
        """All channels, the number of observations and the duration. Reads the whole log."""
        log = _load(path)
        rows = _Rows(log, self.max_hz)
        return Peek(self.name, tuple(rows.channels()), len(rows.order), (log.last_timestamp - log.start_timestamp) / 1e6)

    def read(self, path: Path, after: int = -1) -> Iterator[Item]:
        """Rows, log messages, dropouts and parameter changes in time order; a damaged log ends with an Undecodable."""
        source, log = str(path), _load(path)
        damage = _damage(path, log)
        rows = _Rows(log, self.max_hz)
        for position in range(after + 1, len(rows.order)):
            at_us, topic, values = rows[position]
            if at_us > _LATEST_US:
                yield Undecodable(source=source, position=position, reason=f"a time of {at_us} µs since boot", excerpt=topic)
                continue
            yield Observation(
                source=source, position=position, topic=topic, at_ns=at_us * _NS_PER_US, values=values(), clock="boot"
            )
        if damage and after < len(rows.order):
            yield Undecodable(source=source, position=len(rows.order), reason=damage)

    def digest(self, path: Path) -> str:
        """SHA-256 of the file, with ``max_hz`` where it is not the default."""
        digest = digest_of(path)
        return digest if self.max_hz == UlogBridge().max_hz else f"{digest}@{self.max_hz:g}Hz"


class _Rows:
    """All rows of a log in the order of their times; equal times in the order of their topics' names."""

    def __init__(self, log: ULog, max_hz: float) -> None:
        self._texts = EventTexts(log)
        self._topics: list[tuple[str, Layout]] = []
        times, topics, rows = [np.empty(0, np.uint64)], [np.empty(0, np.intp)], [np.empty(0, np.intp)]
        for data in sorted(log.data_list, key=lambda data: (data.name, data.multi_id)):
            if "timestamp" not in data.data:
                continue
            name = text(data.name if data.multi_id == 0 else f"{data.name}.{data.multi_id}")
            layout = Layout(data.data, {field.field_name: field.type_str for field in data.field_data})
            times_us = data.data["timestamp"].astype(np.uint64)
            kept = kept_rows(data.name, times_us, layout.flags, max_hz)
            times.append(times_us[kept])
            topics.append(np.full(len(kept), len(self._topics)))
            rows.append(kept)
            self._topics.append((name, layout))
        self._said = list(_said(log))
        times.append(np.array([at_us for at_us, _, _ in self._said], np.uint64))
        topics.append(np.full(len(self._said), len(self._topics)))
        rows.append(np.arange(len(self._said)))
        self._times, self._which, self._rows = np.concatenate(times), np.concatenate(topics), np.concatenate(rows)
        self.order = np.lexsort((self._rows, self._which, self._times))

    def __getitem__(self, position: int) -> tuple[int, str, Values]:
        at = self.order[position]
        which, row = int(self._which[at]), int(self._rows[at])
        at_us = int(self._times[at])
        if which == len(self._topics):
            _, topic, values = self._said[row]
            return at_us, topic, lambda: values
        topic, layout = self._topics[which]
        if topic == TOPIC:
            return at_us, topic, lambda: (shown := layout.values(row)) | self._texts.words(shown)
        return at_us, topic, lambda: layout.values(row)

    def channels(self) -> Iterator[str]:
        for topic, layout in self._topics:
            yield from (f"{topic}/{name}" for name in layout.names())
        for topic in sorted({topic for _, topic, _ in self._said}):
            first = next(values for _, said, values in self._said if said == topic)
            yield from (f"{topic}/{name}" for name in first)


def _said(log: ULog) -> Iterator[tuple[int, str, dict[str, Value]]]:
    """What is no row of a topic: messages, dropouts, parameters changed in flight."""
    tagged = [(message, str(tag)) for tag, messages in sorted(log.logged_messages_tagged.items()) for message in messages]
    for message, tag in [*((message, "") for message in log.logged_messages), *tagged]:
        digit = message.log_level - ord("0")
        level, severity = LEVELS[digit] if 0 <= digit < len(LEVELS) else ("unknown", 1)
        shown = _CONTROL.sub("", text(message.message)).strip()
        module = _MODULE.match(shown)
        values: dict[str, Value] = {
            "level": level,
            "severity": severity,
            "text": shown[module.end() :] if module else shown,
            "module": module[1] if module else "",
        }
        if tag:
            values["tag"] = tag
        yield message.timestamp, "log", values
    for dropout in log.dropouts:
        yield dropout.timestamp, "dropout", {"duration_ms": dropout.duration}
    for at_us, name, value in log.changed_parameters:
        number = value if isinstance(value, int | float) and np.isfinite(value) else None
        yield at_us, "parameter", {"name": text(str(name)), "value": number}


def _load(path: Path) -> ULog:
    with extra("ulog", "a flight log"):
        from pyulog import ULog  # noqa: PLC0415
    with opened(path) as file:
        if file.read(len(MAGIC)) != MAGIC:
            raise SourceError(f"{path} is no ULog file: it begins with {excerpt(_beginning(path))!r}, not with the ULog mark")
        file.seek(0)
        try:
            # The library prints its warnings; what they say is found out by _damage and recorded.
            with contextlib.redirect_stdout(io.StringIO()):
                return ULog(file)
        except OSError as failure:
            raise SourceError(f"{path} cannot be read: {failure.strerror or failure}") from failure
        except Exception as failure:
            # The library raises whatever its decoding runs into; there is no narrower type to name.
            raise SourceError(
                f"{path} is damaged beyond reading ({type(failure).__name__}: {failure}); take another copy"
            ) from failure


def _beginning(path: Path) -> bytes:
    with opened(path) as file:
        return file.read(16)


def _damage(path: Path, log: ULog) -> str:
    """What is known to be missing from what was read; empty where nothing is."""
    if log.file_corruption:
        return "the log is damaged in places: what stood there is missing"
    rows = sum(len(data.data["timestamp"]) for data in log.data_list if "timestamp" in data.data)
    with opened(path) as file:
        size = file.seek(0, io.SEEK_END)
        at, data_messages = 16, 0
        while at < size:
            file.seek(at)
            header = file.read(_HEADER.size)
            if len(header) < _HEADER.size:
                return "the log ends in the middle of a message: its tail is missing"
            length, kind = _HEADER.unpack(header)
            at += _HEADER.size + length
            data_messages += kind == ord("D")
        if at > size:
            return "the log ends in the middle of a message: its tail is missing"
    return f"{data_messages - rows} rows could not be decoded" if data_messages > rows else ""
