"""MCAP recordings."""

from __future__ import annotations

from pathlib import Path

import pytest
from mcap.writer import CompressionType
from rosbags.rosbag2 import StoragePlugin

from tests.bridges.recordings import mcap, ros2_bag
from wakeful.bridges.mcap import McapBridge
from wakeful.contracts.bridge import SourceError
from wakeful.facts.events import Observation, Undecodable
from wakeful.testing.bridge_checks import check_bridge


@pytest.mark.parametrize("packing", CompressionType)
def test_messages_of_several_encodings_are_read_however_they_are_packed(packing: CompressionType, tmp_path: Path) -> None:
    items = list(McapBridge().read(mcap(tmp_path / "a.mcap", packing=packing)))
    rows = [item for item in items if isinstance(item, Observation)]
    assert [row.topic for row in rows].count("/odom") == 20
    assert rows[1].topic == "/battery"
    assert rows[1].values == {"charge": 1.0}
    assert rows[0].values["child_frame"] == "base_link"
    assert isinstance(items[-1], Undecodable)
    assert "'protobuf' is not read here" in items[-1].reason


def test_the_summary_says_how_much_there_is(tmp_path: Path) -> None:
    peek = McapBridge().peek(mcap(tmp_path / "a.mcap"))
    assert peek.items == 25
    assert peek.duration_s == pytest.approx(2.0)
    assert {"/odom/vx", "/battery/charge", "/other/_type"} <= set(peek.channels)


def test_an_unfinished_recording_gives_what_was_written(tmp_path: Path) -> None:
    path = mcap(tmp_path / "a.mcap", count=200)
    whole = list(McapBridge().read(path))
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    *rest, last = McapBridge().read(path)
    assert len(rest) > 20
    assert rest == whole[: len(rest)]
    assert isinstance(last, Undecodable)
    assert "unfinished" in last.reason
    peek = McapBridge().peek(path)
    assert peek.items is None
    assert "/odom/vx" in peek.channels


def test_a_damaged_chunk_is_lost_alone(tmp_path: Path) -> None:
    path = mcap(tmp_path / "a.mcap", count=200, packing=CompressionType.NONE)
    whole = list(McapBridge().read(path))
    damaged = bytearray(path.read_bytes())
    where = damaged.index(b"base_link", len(damaged) // 4)
    damaged[where] ^= 0xFF
    path.write_bytes(damaged)
    items = list(McapBridge().read(path))
    broken = [item for item in items if isinstance(item, Undecodable) and "chunk" in item.reason]
    assert len(broken) == 1
    assert "crc" in broken[0].reason
    assert len(whole) - 10 < len(items) < len(whole)
    assert [item for item in items if item.position < broken[0].position] == whole[: broken[0].position]  # type: ignore[union-attr]


def test_a_recording_in_several_files_is_read_in_their_order(tmp_path: Path) -> None:
    for number in (10, 2):
        mcap(tmp_path / f"part_{number}.mcap", count=number)
    items = check_bridge(McapBridge(), tmp_path)
    assert [item.topic for item in items if isinstance(item, Observation)].count("/odom") == 12


def test_a_ros2_bag_in_mcap_storage_is_read_as_its_directory(tmp_path: Path) -> None:
    bag = ros2_bag(tmp_path / "bag", storage=StoragePlugin.MCAP)
    items = check_bridge(McapBridge(), bag)
    assert len(items) == 20
    assert all(isinstance(item, Observation) for item in items)


def test_a_length_that_no_record_has_is_refused_without_reading_it(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    path.write_bytes(b"\x89MCAP0\r\n\x06" + (2**60).to_bytes(8, "little") + bytes(100))
    (item,) = McapBridge().read(path)
    assert isinstance(item, Undecodable)
    assert "exceeds limit" in item.reason


def test_a_file_that_is_no_mcap_is_one_error(tmp_path: Path) -> None:
    (tmp_path / "a.mcap").write_bytes(b"#ROSBAG V2.0\n")
    with pytest.raises(SourceError, match=r"a\.mcap is no MCAP file"):
        list(McapBridge().read(tmp_path / "a.mcap"))


def test_the_recorded_samples_are_read(shared_data: Path) -> None:
    samples = shared_data / "rosbag2_samples" / "rosbag2_py" / "test" / "resources" / "mcap"
    for folder, count in (("talker", 20), ("wbag", 6074)):
        items = list(McapBridge().read(samples / folder))
        assert len(items) == count
        assert all(isinstance(item, Observation) for item in items)
