"""ROS 1 bags, ROS 2 bags."""

from __future__ import annotations

import math
import os
from pathlib import Path

import apsw
import pytest
from rosbags.highlevel import AnyReader
from rosbags.rosbag1 import Writer
from rosbags.typesys import Stores, get_typestore

from tests.bridges.recordings import START_NS, STEP_NS, ros1_bag, ros2_bag
from wakeful.bridges.rosbag import RosbagBridge
from wakeful.contracts.bridge import SourceError
from wakeful.facts.events import Observation, Undecodable
from wakeful.testing.bridge_checks import check_bridge


def observations(path: Path) -> list[Observation]:
    items = list(RosbagBridge().read(path))
    assert all(isinstance(item, Observation) for item in items)
    return [item for item in items if isinstance(item, Observation)]


@pytest.mark.parametrize("packing", [None, Writer.CompressionFormat.BZ2, Writer.CompressionFormat.LZ4])
def test_a_ros1_bag_is_read_however_it_is_packed(packing: Writer.CompressionFormat | None, tmp_path: Path) -> None:
    rows = observations(ros1_bag(tmp_path / "a.bag", packing=packing))
    assert [row.topic for row in rows].count("/odom") == 20
    assert rows[1].topic == "/chatter"
    assert rows[1].values == {"_type": "std_msgs/msg/String", "data": "number 0"}


def test_the_time_is_the_headers_where_there_is_one_else_that_of_receipt(tmp_path: Path) -> None:
    odometry, chatter, *_ = observations(ros1_bag(tmp_path / "a.bag"))
    assert (odometry.at_ns, odometry.clock) == (START_NS - 20_000_000, "header")
    assert (chatter.at_ns, chatter.clock) == (START_NS, "receive")


def test_a_ros2_bag_is_read_as_directory_and_as_file(tmp_path: Path) -> None:
    bag = ros2_bag(tmp_path / "bag")
    (file,) = bag.glob("*.db3")
    of_directory, of_file = observations(bag), observations(file)
    assert [row.values for row in of_directory] == [row.values for row in of_file]
    third = of_directory[3].values
    assert third["x"] == pytest.approx(0.3)
    assert third["yaw"] == pytest.approx(math.pi / 2)
    assert (third["vx"], third["wz"], third["frame"], third["child_frame"]) == (1.0, None, "odom", "base_link")


def test_a_bag_split_in_files_is_read_in_their_order(tmp_path: Path) -> None:
    for number in (10, 2, 1):
        (file,) = ros2_bag(tmp_path / f"b{number}", count=number).glob("*.db3")
        (tmp_path / "split").mkdir(exist_ok=True)
        os.replace(file, tmp_path / "split" / f"bag_{number}.db3")
    rows = observations(tmp_path / "split")
    assert [round((row.at_ns - START_NS) / STEP_NS) for row in rows] == [0, 0, 1, *range(10)]
    check_bridge(RosbagBridge(), tmp_path / "split")


def test_the_index_says_how_much_there_is(tmp_path: Path) -> None:
    peek = RosbagBridge().peek(ros1_bag(tmp_path / "a.bag"))
    assert peek.items == 24
    assert peek.duration_s == pytest.approx(1.9)
    assert {"/odom/vx", "/odom/yaw", "/chatter/data"} <= set(peek.channels)


def test_an_unfinished_ros1_bag_gives_what_was_written(tmp_path: Path) -> None:
    path = ros1_bag(tmp_path / "a.bag", count=2000)
    whole = observations(path)
    path.write_bytes(path.read_bytes()[: path.stat().st_size * 2 // 3])
    *rest, last = RosbagBridge().read(path)
    assert 0 < len(rest) < len(whole)
    assert rest == whole[: len(rest)]
    assert isinstance(last, Undecodable)
    assert "ends in the middle" in last.reason
    assert RosbagBridge().peek(path).items is None


def test_a_truncated_ros2_bag_is_one_error(tmp_path: Path) -> None:
    (file,) = ros2_bag(tmp_path / "bag", count=500).glob("*.db3")
    file.write_bytes(file.read_bytes()[: file.stat().st_size // 2])
    with pytest.raises(SourceError, match=r"bag\.db3 is no ROS 2 bag that can be read \(database disk image is malformed\)"):
        list(RosbagBridge().read(file))


def test_a_ros2_bag_damaged_inside_gives_what_comes_before(tmp_path: Path) -> None:
    (file,) = ros2_bag(tmp_path / "bag", count=500).glob("*.db3")
    whole = observations(file)
    damaged = bytearray(file.read_bytes())
    page = len(damaged) // 2 // 4096 * 4096
    damaged[page : page + 8] = b"\xff" * 8
    file.write_bytes(damaged)
    *rest, last = RosbagBridge().read(file)
    assert 100 < len(rest) < len(whole)
    assert rest == whole[: len(rest)]
    assert isinstance(last, Undecodable)
    assert "what follows is lost" in last.reason


def test_a_message_that_is_not_of_its_type_is_refused_alone(tmp_path: Path) -> None:
    (file,) = ros2_bag(tmp_path / "bag").glob("*.db3")
    database = apsw.Connection(str(file))
    database.execute("UPDATE messages SET data = x'00010000ffff' WHERE id = 5")
    database.close()
    items = list(RosbagBridge().read(file))
    assert [item.position for item in items if isinstance(item, Undecodable)] == [4]
    assert len(items) == 20


def test_a_database_that_is_no_bag_is_one_error(tmp_path: Path) -> None:
    database = apsw.Connection(str(tmp_path / "a.db3"))
    database.execute("CREATE TABLE something (x)")
    database.close()
    with pytest.raises(SourceError, match=r"a\.db3 is no ROS 2 bag"):
        list(RosbagBridge().read(tmp_path / "a.db3"))


def test_reading_leaves_nothing_beside_the_bag(tmp_path: Path) -> None:
    bag = ros2_bag(tmp_path / "bag")
    before = sorted(bag.iterdir())
    observations(bag)
    assert sorted(bag.iterdir()) == before


def test_the_recorded_bags_hold_what_their_library_says(shared_data: Path) -> None:
    for path in [*sorted((shared_data / "rosbag1").glob("*.bag")), shared_data / "rosbag2_turtlebot"]:
        rows = observations(path)
        with AnyReader([path], default_typestore=get_typestore(Stores.ROS2_HUMBLE)) as reader:
            assert len(rows) == reader.message_count
        assert RosbagBridge().peek(path).items == len(rows)


def test_the_recorded_turtlebot_moves_and_sees(shared_data: Path) -> None:
    rows = observations(shared_data / "rosbag2_turtlebot")
    speeds = [row.values["vx"] for row in rows if row.topic == "/odom"]
    nearest = [row.values["front"] for row in rows if row.topic == "/scan"]
    assert max(speed for speed in speeds if isinstance(speed, float)) > 0.1
    assert any(isinstance(distance, float) and 0.1 < distance < 12 for distance in nearest)


def test_the_recorded_samples_without_definitions_are_read_by_those_of_a_distribution(shared_data: Path) -> None:
    rows = observations(shared_data / "rosbag2_samples" / "rosbag2_py" / "test" / "resources" / "sqlite3" / "talker")
    assert [row.values["msg"] for row in rows if row.topic == "/rosout"][1] == "Publishing: 'Hello, world! 1'"
