"""ROS messages with plain names."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from rosbags.typesys import Stores, get_typestore

from wakeful.bridges.ros_messages import stamp_ns, values_of

ROS1, ROS2 = get_typestore(Stores.ROS1_NOETIC), get_typestore(Stores.ROS2_HUMBLE)
QUARTER_TURN = {"x": 0.0, "y": 0.0, "z": math.sqrt(0.5), "w": math.sqrt(0.5)}


def make(kind: str, store: Any = ROS2, **said: Any) -> Any:
    """A message of a type: what is not said is zero, empty, or made likewise."""
    return store.types[kind](**{name: said.get(name, _blank(field, store)) for name, field in store.fielddefs[kind][1]})


def _blank(field: Any, store: Any) -> Any:
    node, detail = field
    if node.name == "NAME":
        return make(detail, store)
    if node.name in ("ARRAY", "SEQUENCE"):
        length = detail[1] if node.name == "ARRAY" else 0
        return np.zeros(length) if detail[0][0].name == "BASE" and detail[0][1][0] != "string" else []
    return {"string": "", "bool": False}.get(detail[0], 0.0 if "float" in detail[0] else 0)


def quaternion(store: Any = ROS2, **parts: float) -> Any:
    return make("geometry_msgs/msg/Quaternion", store, **parts)


def vector(x: float, y: float, z: float) -> Any:
    return make("geometry_msgs/msg/Vector3", x=x, y=y, z=z)


def header(frame: str, sec: int = 0, nanosec: int = 0) -> Any:
    return make("std_msgs/msg/Header", frame_id=frame, stamp=make("builtin_interfaces/msg/Time", sec=sec, nanosec=nanosec))


def test_an_imu_without_orientation_says_no_angles() -> None:
    kind = "sensor_msgs/msg/Imu"
    unknown = np.array([-1.0, *[0.0] * 8])
    turned = make(kind, header=header("imu"), orientation=quaternion(**QUARTER_TURN), linear_acceleration=vector(1, 2, 9.8))
    assert values_of(turned, kind)["yaw"] == pytest.approx(math.pi / 2)
    assert values_of(turned, kind) | {"ay": 2} == values_of(turned, kind)
    for message in (make(kind), make(kind, orientation=quaternion(**QUARTER_TURN), orientation_covariance=unknown)):
        assert "yaw" not in values_of(message, kind)


@pytest.mark.parametrize(
    ("kind", "names"),
    [
        ("geometry_msgs/msg/Twist", "vx vy vz wx wy wz"),
        ("geometry_msgs/msg/TwistStamped", "frame vx vy vz wx wy wz"),
        ("geometry_msgs/msg/TwistWithCovarianceStamped", "frame vx vy vz wx wy wz"),
        ("geometry_msgs/msg/AccelStamped", "frame ax ay az wx wy wz"),
        ("geometry_msgs/msg/Pose", "x y z roll pitch yaw"),
        ("geometry_msgs/msg/PoseWithCovarianceStamped", "frame x y z roll pitch yaw"),
        ("geometry_msgs/msg/Vector3Stamped", "frame x y z"),
        ("geometry_msgs/msg/PointStamped", "frame x y z"),
        ("nav_msgs/msg/Odometry", "frame x y z yaw vx vy vz wx wy wz child_frame"),
        ("sensor_msgs/msg/NavSatFix", "frame latitude longitude altitude fix service"),
        ("sensor_msgs/msg/Range", "frame range min_range max_range field_of_view"),
        ("sensor_msgs/msg/Image", "frame width height encoding bytes"),
        ("sensor_msgs/msg/CompressedImage", "frame format bytes"),
        ("sensor_msgs/msg/PointCloud2", "frame width height points bytes"),
        ("nav_msgs/msg/OccupancyGrid", "frame width height resolution"),
        ("nav_msgs/msg/Path", "frame poses"),
        (
            "sensor_msgs/msg/BatteryState",
            "frame voltage current charge capacity percentage temperature present status health",
        ),
    ],
)
def test_a_known_type_has_the_documented_names(kind: str, names: str) -> None:
    assert set(values_of(make(kind), kind)) == {"_type", *names.split()}


def test_transforms_are_a_list_of_parent_child_and_place() -> None:
    kind = "tf2_msgs/msg/TFMessage"
    transform = make("geometry_msgs/msg/Transform", translation=vector(1, 2, 0), rotation=quaternion(**QUARTER_TURN))
    stamped = make("geometry_msgs/msg/TransformStamped", header=header("odom", 5), child_frame_id="base", transform=transform)
    (found,) = values_of(make(kind, transforms=[stamped]), kind)["transforms"]  # type: ignore[misc]
    assert found == {
        "parent": "odom",
        "child": "base",
        "x": 1.0,
        "y": 2.0,
        "z": 0.0,
        "yaw": pytest.approx(math.pi / 2),
        "at_s": 5.0,
    }


@pytest.mark.parametrize("store", [ROS1, ROS2])
def test_diagnostics_are_a_list_with_the_worst_level(store: Any) -> None:
    kind, one = "diagnostic_msgs/msg/DiagnosticArray", "diagnostic_msgs/msg/DiagnosticStatus"
    pair = make("diagnostic_msgs/msg/KeyValue", store, key="rpm", value="0")
    status = [make(one, store, name="motor", level=2, message="stalled", hardware_id="m1", values=[pair]), make(one, store)]
    values = values_of(make(kind, store, status=status), kind)
    assert values["worst"] == 2
    assert values["status"][0] == {  # type: ignore[index, call-overload]
        "name": "motor",
        "level": 2,
        "message": "stalled",
        "hardware_id": "m1",
        "values": {"rpm": "0"},
    }


@pytest.mark.parametrize(
    ("store", "kind", "level", "shown"),
    [
        (ROS1, "rosgraph_msgs/msg/Log", 4, ("warning", 2)),
        (ROS1, "rosgraph_msgs/msg/Log", 16, ("fatal", 4)),
        (ROS2, "rcl_interfaces/msg/Log", 40, ("error", 3)),
        (ROS2, "rcl_interfaces/msg/Log", 20, ("info", 1)),
    ],
)
def test_a_log_message_has_the_same_levels_in_both(store: Any, kind: str, level: int, shown: tuple[str, int]) -> None:
    values = values_of(make(kind, store, level=level, msg="wheel slips", name="base"), kind)
    assert (values["level"], values["severity"], values["msg"]) == (*shown, "wheel slips")


def test_joints_are_named() -> None:
    kind = "sensor_msgs/msg/JointState"
    message = make(kind, name=["left", "right"], position=np.array([0.1, 0.2]), velocity=np.array([1.0, float("nan")]))
    values = values_of(message, kind)
    assert (values["position.right"], values["velocity.left"], values["velocity.right"]) == (0.2, 1.0, None)


def test_any_other_type_is_flattened_within_bounds() -> None:
    kind = "sensor_msgs/msg/CameraInfo"
    values = values_of(make(kind, header=header("cam"), height=480, d=np.arange(40.0), k=np.arange(9.0)), kind)
    assert values["roi.do_rectify"] is False
    assert values["d.count"] == 40
    assert values["k"] == [float(number) for number in range(9)]
    markers = [make("visualization_msgs/msg/Marker", id=number) for number in range(50)]
    many = values_of(make("visualization_msgs/msg/MarkerArray", markers=markers), "visualization_msgs/msg/MarkerArray")
    assert many["markers.count"] == 50
    assert many["markers.1.id"] == 1
    assert len(many) <= 130


def test_a_header_is_believed_within_ten_seconds_of_receipt() -> None:
    message = make("nav_msgs/msg/Odometry", header=header("odom", 100, 5))
    assert stamp_ns(message, 101_000_000_000) == 100_000_000_005
    assert stamp_ns(message, 111_000_000_000) is None
    assert stamp_ns(make("nav_msgs/msg/Odometry"), 5) is None
    assert stamp_ns(make("geometry_msgs/msg/Twist"), 5) is None


def scan(ranges: list[float], **said: float) -> dict[str, Any]:
    kind = "sensor_msgs/msg/LaserScan"
    limits = {"angle_min": -math.pi, "angle_increment": math.pi / 2, "range_min": 0.1, "range_max": 10.0} | said
    return dict(values_of(make(kind, ranges=np.array(ranges, dtype=np.float32), **limits), kind))


def test_a_scan_says_what_is_near_in_which_direction() -> None:
    values = scan([4.0, 3.0, 2.0, 1.0])
    assert (values["back"], values["right"], values["front"], values["left"]) == (4, 3, 2, 1)
    assert values["left_bearing"] == pytest.approx(math.pi / 2)
    assert (values["min"], values["min_bearing"]) == (1, values["left_bearing"])
    assert (values["median"], values["rays"], values["valid_share"]) == (2.5, 4, 1.0)


def test_returns_out_of_range_or_infinite_are_not_valid() -> None:
    values = scan([math.inf, math.nan, 0.05, 20.0])
    assert values["valid_share"] == 0
    assert {values[name] for name in ("min", "p05", "median", "front", "left", "right", "back", "front_bearing")} == {None}
    assert scan([])["valid_share"] is None


def test_a_sector_wraps_around_behind() -> None:
    values = scan([9.0, 5.0, 9.0], angle_min=3.0, angle_increment=0.2)
    assert values["back"] == 5
    assert values["back_bearing"] == pytest.approx(3.2 - 2 * math.pi)
