"""The domain as a whole: any content is passed over, and recorded drives give few and true events."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given, settings

from tests.domains.watching import Watch, observations
from wakeful.bridges.mcap import McapBridge
from wakeful.bridges.rosbag import RosbagBridge
from wakeful.contracts.detector import Found, Shown
from wakeful.domains import load
from wakeful.domains.mobile_base.detectors import DETECTORS
from wakeful.facts.events import Draft, Observation
from wakeful.facts.evidence import Outcome
from wakeful.registration.registrar import SpecRegistrar

TOPICS = ("/odom", "/a/odom", "/cmd_vel", "/imu", "/scan", "/tf", "/tf_static", "/fix", "/rosout", "/e_stop", "/bump", "")
TYPES = (
    "nav_msgs/msg/Odometry",
    "turtlesim/msg/Pose",
    "geometry_msgs/msg/Twist",
    "geometry_msgs/msg/PoseWithCovarianceStamped",
    "sensor_msgs/msg/Imu",
    "sensor_msgs/msg/LaserScan",
    "sensor_msgs/msg/Range",
    "sensor_msgs/msg/NavSatFix",
    "sensor_msgs/msg/BatteryState",
    "tf2_msgs/msg/TFMessage",
    "diagnostic_msgs/msg/DiagnosticArray",
    "rcl_interfaces/msg/Log",
    "irobot_create_msgs/msg/HazardDetectionVector",
    "std_msgs/msg/Bool",
    "std_msgs/msg/Empty",
)
NAMES = (
    *("x", "y", "yaw", "theta", "vx", "vy", "wz", "wx", "wy", "ax", "ay", "az", "roll", "pitch", "frame", "child_frame"),
    *("linear_velocity", "angular_velocity", "front", "left", "back_bearing", "front_bearing", "range", "max_range"),
    *("transforms", "status", "level", "severity", "name", "msg", "fix", "latitude", "longitude", "percentage", "present"),
    *("data", "state", "bumper", "detections.count", "detections.0.type"),
)


@given(stream=observations(TOPICS, NAMES, TYPES))
@settings(max_examples=50, deadline=None)
def test_no_content_makes_a_detector_raise(stream: list[Observation]) -> None:
    labels = load("mobile_base").spec.outcome.labels
    watches = [Watch(factory) for factory in DETECTORS.values()]
    for observation in stream:
        for said in (said for watch in watches for said in watch.look(observation)):
            if isinstance(said, Shown):
                assert said.label in labels
            if isinstance(said, Found):
                assert said.kind
                assert said.says
                assert len(said.says) < 1000


def _register(path: Path) -> tuple[list[Draft], list[Outcome], int]:
    bridge = next(one for one in (RosbagBridge(), McapBridge()) if one.claims(path))
    registrar = SpecRegistrar(load("mobile_base"), bridge.digest(path))
    events: list[Draft] = []
    outcomes: list[Outcome] = []
    count = 0
    for item in bridge.read(path):
        if isinstance(item, Observation):
            count += 1
            registered = registrar.observe(item)
            events.extend(registered.events)
            outcomes.extend(registered.outcomes)
    return events, outcomes, count


def test_the_recorded_turtlebot_drives_off_once_and_stops_once(shared_data: Path) -> None:
    pytest.importorskip("rosbags", reason="needs the extra wakeful[ros]")
    events, outcomes, count = _register(shared_data / "rosbag2_turtlebot")
    assert count == 2425
    assert [one.kind for one in events if one.kind in ("start", "stop", "unexpected_stop")] == ["start", "stop"]
    # it is asked for 0.5 m/s all the time and its base is limited to 0.31
    assert "shortfall" in {one.kind for one in events}
    assert len(events) <= 6
    assert [one.label for one in outcomes if one.entity == "*"] == ["stopped"]


def test_the_recorded_jackal_slips_in_its_turns(shared_data: Path) -> None:
    pytest.importorskip("rosbags", reason="needs the extra wakeful[ros]")
    events, _, count = _register(shared_data / "rosbag1" / "test2.bag")
    assert "slip" in {one.kind for one in events}
    assert len(events) < count / 200


def test_the_recorded_husky_with_its_sensor_on_its_side_neither_slips_nor_tilts(shared_data: Path) -> None:
    pytest.importorskip("rosbags", reason="needs the extra wakeful[ros]")
    events, _, _ = _register(shared_data / "rosbag1" / "test1.bag")
    assert not {"slip", "tilt", "jump"} & {one.kind for one in events}


def test_recorded_format_samples_without_a_robot_in_them_give_no_event(shared_data: Path) -> None:
    pytest.importorskip("rosbags", reason="needs the extra wakeful[ros]")
    samples = sorted((shared_data / "rosbag2_samples").rglob("talker*.mcap")) + sorted(
        (shared_data / "rosbag2_samples").rglob("wbag_0.*")
    )
    assert samples
    for path in samples:
        assert _register(path)[0] == [], path.name
