"""JSON lines, single JSON messages and directories of them, as observations, events, evidence and outcomes."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from itertools import islice
from pathlib import Path
from typing import BinaryIO, Final
from uuid import uuid4

import msgspec

from wakeful.bridges.content import Overlong, bounded_lines, digest_of, excerpt, files_in, opened, too_long
from wakeful.bridges.json_lines import Refused, item_of
from wakeful.contracts.bridge import Item, Peek, SourceError
from wakeful.facts.events import Observation, Undecodable
from wakeful.facts.time import NS_PER_S

STDIN: Final = Path("-")
_LINES: Final = (".jsonl", ".ndjson")
_SINGLE: Final = ".json"
_MAX_FILE_BYTES: Final = 64_000_000
_PEEK_ITEMS: Final = 200

Texts = Iterator[bytes | Overlong | Refused]


class JsonlBridge:
    """Reads JSON lines (docs/jsonl.md); ``-`` is standard input. Positions count the lines that are not blank.

    A ``.json`` file is one message, or an array of them; a directory holds such files, taken by name.

    Args:
        incarnation: what stands for the digest of standard input. Give the same one to go on with an interrupted stream;
            without it every bridge is a fresh one.
        stdin: what is read for ``-``.
    """

    name = "jsonl"

    def __init__(self, incarnation: str = "", stdin: BinaryIO | None = None) -> None:
        self._incarnation = incarnation or uuid4().hex
        self._stdin = stdin

    def claims(self, path: Path) -> bool:
        """By suffix; ``-``; a directory with JSON files in it; a file whose first sign is a brace."""
        if path == STDIN or path.suffix.lower() in (*_LINES, _SINGLE):
            return True
        if path.is_dir():
            return bool(files_in(path, _SINGLE, *_LINES, deep=True))
        try:
            with path.open("rb") as file:
                return file.read(256).lstrip(b"\xef\xbb\xbf \t\r\n").startswith(b"{")
        except OSError:
            return False

    def peek(self, path: Path) -> Peek:
        """The channels of the first lines. Standard input is not touched: nothing is known of it."""
        if path == STDIN:
            return Peek(self.name, ())
        found: dict[str, set[str]] = {}
        for item in islice(self.read(path), _PEEK_ITEMS):
            if isinstance(item, Observation):
                found.setdefault(item.topic, set()).update(_names(item.values))
        return Peek(self.name, tuple(f"{topic}/{name}" for topic in sorted(found) for name in sorted(found[topic])))

    def read(self, path: Path, after: int = -1) -> Iterator[Item]:
        """What each line says."""
        source, before_ns = str(path), -NS_PER_S
        for position, text in enumerate(self._texts(path)):
            try:
                if isinstance(text, Refused):
                    raise text
                if isinstance(text, Overlong):
                    raise Refused(too_long(text))
                item, before_ns = item_of(text, source, position, before_ns)
            except Refused as refusal:
                shown = excerpt(text) if isinstance(text, bytes) else ""
                item = Undecodable(source=source, position=position, reason=str(refusal), excerpt=shown)
            if position > after:
                yield item

    def digest(self, path: Path) -> str:
        """SHA-256 of the content; of standard input, its incarnation."""
        return self._incarnation if path == STDIN else digest_of(path)

    def _texts(self, path: Path) -> Texts:
        if path == STDIN:
            yield from _lines(self._stdin or sys.stdin.buffer)
            return
        if path.is_dir():
            if not (files := files_in(path, _SINGLE, *_LINES, deep=True)):
                raise SourceError(f"{path} holds no .json or .jsonl file")
            for file in files:
                yield from _file(file)
            return
        texts = _file(path)
        first = next(texts, None)
        if first is None:
            raise SourceError(f"{path} is empty: there is no line in it")
        yield first
        yield from texts


def _file(path: Path) -> Texts:
    with opened(path) as file:
        if path.suffix.lower() != _SINGLE:
            beginning = file.read(4096)
            if b"\0" in beginning:
                raise SourceError(f"{path} holds binary data, not JSON lines; a recording of another kind needs its own suffix")
            file.seek(0)
            yield from _lines(file)
            return
        text = file.read(_MAX_FILE_BYTES + 1)
    if len(text) > _MAX_FILE_BYTES:
        yield Refused(f"a JSON file of more than {_MAX_FILE_BYTES:,} bytes; write one message a line (.jsonl)")
        return
    if not text.strip():
        raise SourceError(f"{path} is empty: there is no message in it")
    yield from _members(text)


def _members(text: bytes) -> Texts:
    """The messages of a ``.json`` file: its array's members, its lines where it is JSON lines by another name, or itself."""
    try:
        members = msgspec.json.decode(text, type=list[msgspec.Raw])
    except (msgspec.DecodeError, UnicodeDecodeError):
        lines = [line.strip() for line in text.splitlines() if line.strip()]
        by_line = len(lines) > 1 and all(line.startswith(b"{") and line.endswith(b"}") for line in lines)
        yield from lines if by_line else [text]
        return
    yield from (bytes(member) for member in members)


def _lines(file: BinaryIO) -> Texts:
    for number, line in enumerate(bounded_lines(file)):
        if isinstance(line, Overlong):
            yield line
        elif text := (line.removeprefix(b"\xef\xbb\xbf") if number == 0 else line).strip():
            yield text


def _names(values: object, prefix: str = "") -> Iterator[str]:
    if isinstance(values, dict):
        for name, value in values.items():
            yield f"{prefix}{name}"
            yield from _names(value, f"{prefix}{name}.")
