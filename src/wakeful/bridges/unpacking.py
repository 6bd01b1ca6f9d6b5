"""Unpacking what somebody else packed, never beyond a limit: a few kilobytes can claim to hold, or hold, terabytes."""

from __future__ import annotations

import bz2
import io
import lzma
import struct
import zipfile
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Final

from wakeful.bridges.content import extra

_BLOCK: Final = 1 << 20
_ARCHIVE_DAMAGE: Final = (
    zipfile.BadZipFile,
    zlib.error,
    lzma.LZMAError,
    struct.error,
    NotImplementedError,
    RuntimeError,
    EOFError,
    OSError,
    ValueError,
)


def unpacked(packing: str, data: bytes, limit: int) -> bytes:
    """The content of a packed chunk.

    Args:
        packing: ``bz2``, ``lz4`` or ``zstd``.
        data: one whole stream.
        limit: so many bytes it may hold.

    Raises:
        ValueError: it holds more, ends early, or is none.
        KeyError: packed in another way.
    """
    content = _UNPACKERS[packing](data, limit)
    if len(content) > limit:
        raise ValueError(f"it holds more than {limit:,} bytes")
    return content


def _bz2(data: bytes, limit: int) -> bytes:
    stream = bz2.BZ2Decompressor()
    content = stream.decompress(data, limit + 1)
    if not stream.eof and len(content) <= limit:
        raise ValueError("it ends in the middle")
    return content


def _lz4(data: bytes, limit: int) -> bytes:
    with extra("ros", "an lz4-packed chunk"):
        import lz4.frame  # noqa: PLC0415
    stream = lz4.frame.LZ4FrameDecompressor()
    content: bytes = stream.decompress(data, limit + 1)
    if not stream.eof and len(content) <= limit:
        raise ValueError("it ends in the middle")
    return content


def _zstd(data: bytes, limit: int) -> bytes:
    with extra("ros", "a zstd-packed chunk"):
        import zstandard  # noqa: PLC0415
    # What the frame says of its own size is not believed: it is read in blocks.
    with zstandard.ZstdDecompressor().stream_reader(io.BytesIO(data)) as stream:
        blocks: list[bytes] = []
        held = 0
        while held <= limit and (block := stream.read(min(_BLOCK, limit + 1 - held))):
            blocks.append(block)
            held += len(block)
    return b"".join(blocks)


_UNPACKERS: Final[dict[str, Callable[[bytes, int], bytes]]] = {"bz2": _bz2, "lz4": _lz4, "zstd": _zstd}


def archive_bytes(path: Path, limit: int) -> int:
    """What the members of a zip archive hold together, unpacked and counted, at most ``limit`` and one block more.

    Raises:
        ValueError: it is no whole archive, or a member holds something else than the archive says.
    """
    held = 0
    try:
        with zipfile.ZipFile(path) as archive:
            for member in archive.infolist():
                with archive.open(member) as content:
                    while block := content.read(_BLOCK):
                        held += len(block)
                        if held > limit:
                            return held
    except _ARCHIVE_DAMAGE as error:
        raise ValueError(str(error) or type(error).__name__) from error
    return held
