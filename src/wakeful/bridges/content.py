"""A source's content as bytes: opening it, its digest, its lines within bounds, and what to say where it cannot be read."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from hashlib import sha256
from pathlib import Path
from typing import BinaryIO, Final

from wakeful.contracts.bridge import SourceError

MAX_LINE_BYTES: Final = 1_000_000
"""A longer line is refused, and never held in memory as a whole."""
_BLOCK_BYTES: Final = 1 << 20
EXCERPT_CHARS: Final = 120


@contextmanager
def opened(path: Path) -> Iterator[BinaryIO]:
    """The file, open for reading. Raises SourceError where it cannot be opened or read."""
    try:
        with path.open("rb") as file:
            yield file
    except OSError as failure:
        raise SourceError(f"{path} cannot be read: {failure.strerror or failure}") from failure


@contextmanager
def extra(name: str, reads: str) -> Iterator[None]:
    """Surrounds the import of an optional library, so that a missing one is named with the extra that brings it."""
    try:
        yield
    except ImportError as missing:
        raise SourceError(f"{reads} needs an extra that is not installed: pip install 'wakeful[{name}]' ({missing})") from missing


def begins_with(path: Path, *magics: bytes) -> bool:
    """Whether a regular file begins with one of these bytes. False where it cannot be read; never raises."""
    try:
        if not path.is_file():
            return False
        with path.open("rb") as file:
            return file.read(max(map(len, magics))).startswith(magics)
    except OSError:
        return False


def files_in(directory: Path, *suffixes: str, deep: bool = False) -> list[Path]:
    """The files in a directory with one of these suffixes (any, if none is named), by name; none where it can't be read."""
    try:
        found = directory.rglob("*") if deep else directory.iterdir()
        return sorted(path for path in found if path.is_file() and (not suffixes or path.suffix.lower() in suffixes))
    except OSError:
        return []


def digest_of(path: Path) -> str:
    """SHA-256 of a file's content, or of a directory's files one after another in the order of their names.

    Raises:
        SourceError: it cannot be read.
    """
    digest = sha256()
    if path.is_dir():
        for file in files_in(path, deep=True):
            digest.update(bytes.fromhex(digest_of(file)))
        return digest.hexdigest()
    with opened(path) as content:
        while block := content.read(_BLOCK_BYTES):
            digest.update(block)
    return digest.hexdigest()


class Overlong(int):
    """The length in bytes of a line that was longer than MAX_LINE_BYTES."""


def bounded_lines(file: BinaryIO, limit: int = MAX_LINE_BYTES) -> Iterator[bytes | Overlong]:
    """The lines of a file, ends included; for an overlong one its length. Never holds more than ``limit`` bytes of a line."""
    while line := file.readline(limit + 1):
        if len(line) <= limit:
            yield line
            continue
        length = len(line)
        while not line.endswith(b"\n") and (line := file.readline(limit)):
            length += len(line)
        yield Overlong(length)


def too_long(length: int) -> str:
    """Why an overlong line is refused."""
    return f"a line of {length:,} bytes; the limit is {MAX_LINE_BYTES:,}"


def excerpt(line: bytes | str) -> str:
    """The beginning of an input, printable, for a refusal."""
    text = line.decode("utf-8", "replace") if isinstance(line, bytes) else line.encode("utf-8", "replace").decode()
    return "".join(char if char.isprintable() else "·" for char in text.strip()[:EXCERPT_CHARS])
