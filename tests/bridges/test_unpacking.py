"""What is packed is unpacked within a limit: a few kilobytes that claim, or hold, more than that are refused, cheaply."""

from __future__ import annotations

import bz2
import io
import resource
import struct
import zipfile
from pathlib import Path

import lz4.frame
import pytest
import zstandard
from mcap.writer import CompressionType, Writer

from wakeful.bridges import bridge_for
from wakeful.bridges.unpacking import archive_bytes, unpacked
from wakeful.contracts.bridge import SourceError
from wakeful.facts.events import Observation, Undecodable

PACK = {"bz2": bz2.compress, "lz4": lz4.frame.compress, "zstd": zstandard.compress}
TEXT = b"a recording " * 100


def pack_zeros(packing: str, mebibytes: int) -> bytes:
    """So many MiB of nothing, packed without ever holding them."""
    block = bytes(1 << 20)
    out = io.BytesIO()
    if packing == "bz2":
        stream = bz2.BZ2Compressor()
        parts = [stream.compress(block) for _ in range(mebibytes)] + [stream.flush()]
        return b"".join(parts)
    if packing == "lz4":
        with lz4.frame.open(out, "wb") as file:
            for _ in range(mebibytes):
                file.write(block)
        return out.getvalue()
    with zstandard.ZstdCompressor().stream_writer(out, closefd=False) as file:
        for _ in range(mebibytes):
            file.write(block)
    return out.getvalue()


@pytest.mark.parametrize("packing", sorted(PACK))
def test_what_was_packed_comes_back_up_to_the_limit_and_not_beyond(packing: str) -> None:
    packed = PACK[packing](TEXT)
    assert unpacked(packing, packed, len(TEXT)) == TEXT
    with pytest.raises(ValueError, match="more than"):
        unpacked(packing, packed, len(TEXT) - 1)


@pytest.mark.parametrize("packing", ["bz2", "lz4"])
def test_what_ends_in_the_middle_is_said_to(packing: str) -> None:
    with pytest.raises(ValueError, match="middle"):
        unpacked(packing, PACK[packing](TEXT)[:-8], len(TEXT))


@pytest.mark.parametrize("packing", sorted(PACK))
def test_a_bomb_is_refused_without_being_held(packing: str) -> None:
    bomb = pack_zeros(packing, 512)
    before_kb = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    with pytest.raises(ValueError, match="more than"):
        unpacked(packing, bomb, 1 << 20)
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before_kb < 100_000


def test_a_zstd_frame_that_claims_terabytes_is_not_believed() -> None:
    frame = bytearray(zstandard.ZstdCompressor(write_content_size=True).compress(TEXT * 1_000))
    size_at = frame.find(struct.pack("<I", len(TEXT) * 1_000))
    assert size_at > 0
    claims = (
        bytes(frame[:4])
        + bytes([frame[4] | 0xC0])
        + bytes(frame[5:size_at])
        + struct.pack("<Q", 2**44)
        + bytes(frame[size_at + 4 :])
    )
    with pytest.raises((ValueError, zstandard.ZstdError)):
        unpacked("zstd", claims, 1 << 16)


def mcap(path: Path, content: bytes) -> None:
    with path.open("wb") as file:
        writer = Writer(file, compression=CompressionType.LZ4, chunk_size=1 << 40)
        writer.start()
        schema = writer.register_schema(name="s", encoding="jsonschema", data=b"{}")
        channel = writer.register_channel(topic="/t", message_encoding="json", schema_id=schema)
        writer.add_message(channel, log_time=1, data=content, publish_time=1)
        writer.finish()


def test_an_mcap_file_with_packed_chunks_is_read_as_before(tmp_path: Path) -> None:
    mcap(tmp_path / "a.mcap", b'{"v": 1.5}')
    items = list(bridge_for(tmp_path / "a.mcap").read(tmp_path / "a.mcap"))
    assert [item.values for item in items if isinstance(item, Observation)] == [{"v": 1.5}]


def test_an_mcap_chunk_that_holds_more_than_it_may_is_lost_alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("wakeful.bridges.mcap_records._MAX_RECORD_BYTES", 100_000)
    path = tmp_path / "bomb.mcap"
    mcap(path, b'{"v": "' + b"x" * 1_000_000 + b'"}')
    content = bytearray(path.read_bytes())
    size_at = content.find(struct.pack("<Q", 1_000_000 + 9)[:3])
    assert size_at
    items = list(bridge_for(path).read(path))
    assert items
    assert all(isinstance(item, Undecodable) for item in items)


def test_a_spreadsheet_that_unpacks_to_more_than_it_may_is_one_clear_error(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("wakeful.bridges.xlsx._MAX_UNPACKED_BYTES", 1_000_000)
    path = tmp_path / "bomb.xlsx"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("xl/worksheets/sheet1.xml", b"0" * 5_000_000)
    with pytest.raises(SourceError, match="more than 1,000,000 bytes"):
        list(bridge_for(path).read(path))


def test_an_archive_that_lies_about_a_member_is_no_archive(tmp_path: Path) -> None:
    path = tmp_path / "lies.xlsx"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("a", b"0" * 100_000)
    assert archive_bytes(path, 1 << 20) == 100_000
    content = path.read_bytes().replace(struct.pack("<I", 100_000), struct.pack("<I", 10))
    path.write_bytes(content)
    with pytest.raises(ValueError, match=r"CRC|Error|error"):
        archive_bytes(path, 1 << 20)
