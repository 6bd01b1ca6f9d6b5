"""ROS messages of well-known types as plain values with plain names; every other type by ``flat``.

Written against what the messages carry, not against a library: a message is any object with the type's fields as attributes.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from typing import Any, Final, TypeAlias

from wakeful.bridges.plain import plain, text
from wakeful.bridges.ros_flat import flat
from wakeful.bridges.ros_scan import laser_scan
from wakeful.facts.time import NS_PER_S
from wakeful.facts.values import Value

#: A decoded message. Its type is only known when the recording is read, so nothing narrower can be said here.
Message: TypeAlias = Any

_MAX_ITEMS: Final = 256
_MAX_JOINTS: Final = 64
_HEADER_TOLERANCE_NS: Final = 10 * NS_PER_S
_ROS1_LEVELS: Final = {1: 0, 2: 1, 4: 2, 8: 3, 16: 4}
_SEVERITIES: Final = ("debug", "info", "warning", "error", "fatal")
_BATTERY_STATUS: Final = ("unknown", "charging", "discharging", "not charging", "full")
_BATTERY_HEALTH: Final = (
    "unknown",
    "good",
    "overheat",
    "dead",
    "overvoltage",
    "unspecified failure",
    "cold",
    "watchdog expired",
    "safety expired",
)


def values_of(message: Message, kind: str) -> dict[str, Value]:
    """A message's values, with its type under ``_type`` and its header's frame under ``frame``.

    Args:
        message: the decoded message.
        kind: its type in the ROS 2 manner, ``nav_msgs/msg/Odometry``.

    Raises:
        TooLarge: a text of the message is beyond what an observation may hold.
    """
    values: dict[str, Value] = {"_type": kind}
    if (header := getattr(message, "header", None)) is not None:
        values["frame"] = text(str(getattr(header, "frame_id", "")))
    package, _, name = kind.rpartition("/")
    reader = _READERS.get(name) if package.split("/")[0] in _PACKAGES else None
    values.update(reader(message) if reader else flat(message))
    return values


def stamp_ns(message: Message, received_ns: int) -> int | None:
    """The header's stamp in nanoseconds where it lies within ten seconds of the receipt; None elsewhere."""
    stamp = getattr(getattr(message, "header", None), "stamp", None)
    if stamp is None:
        return None
    at_ns = _time_ns(stamp)
    return at_ns if at_ns > 0 and abs(at_ns - received_ns) <= _HEADER_TOLERANCE_NS else None


def _time_ns(stamp: Message) -> int:
    return int(getattr(stamp, "sec", 0)) * NS_PER_S + int(getattr(stamp, "nanosec", 0))


def angles(q: Message) -> tuple[float | None, float | None, float | None]:
    """Roll, pitch and yaw of a quaternion, in radians; Nones where it is none (zero, NaN)."""
    x, y, z, w = (float(getattr(q, axis)) for axis in "xyzw")
    norm = math.sqrt(x * x + y * y + z * z + w * w)
    if not math.isfinite(norm) or norm < 1e-6:
        return None, None, None
    x, y, z, w = x / norm, y / norm, z / norm, w / norm
    roll = math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))
    pitch = math.asin(max(-1.0, min(1.0, 2 * (w * y - z * x))))
    yaw = math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
    return roll, pitch, yaw


def _numbers(names: str, numbers: Iterable[float | None]) -> dict[str, Value]:
    return {name: plain(number) for name, number in zip(names.split(), numbers, strict=True)}


def _vector(names: str, vector: Message) -> dict[str, Value]:
    return _numbers(names, (float(vector.x), float(vector.y), float(vector.z)))


def _level(message: Message) -> int:
    """DiagnosticStatus.level: a byte in ROS 1, an octet in ROS 2."""
    level = message.level
    return level[0] if isinstance(level, bytes) and level else int(level)


def _some(items: Sequence[Message]) -> Sequence[Message]:
    return items[:_MAX_ITEMS]


def _odometry(message: Message) -> dict[str, Value]:
    pose, twist = message.pose.pose, message.twist.twist
    return {
        **_vector("x y z", pose.position),
        "yaw": plain(angles(pose.orientation)[2]),
        **_twist(twist),
        "child_frame": text(message.child_frame_id),
    }


def _twist(message: Message) -> dict[str, Value]:
    while hasattr(message, "twist"):
        message = message.twist
    return {**_vector("vx vy vz", message.linear), **_vector("wx wy wz", message.angular)}


def _accel(message: Message) -> dict[str, Value]:
    while hasattr(message, "accel"):
        message = message.accel
    return {**_vector("ax ay az", message.linear), **_vector("wx wy wz", message.angular)}


def _pose(message: Message) -> dict[str, Value]:
    while hasattr(message, "pose"):
        message = message.pose
    return {**_vector("x y z", message.position), **_numbers("roll pitch yaw", angles(message.orientation))}


def _point(message: Message) -> dict[str, Value]:
    message = getattr(message, "vector", getattr(message, "point", message))
    return _vector("x y z", message)


def _imu(message: Message) -> dict[str, Value]:
    values = {**_vector("ax ay az", message.linear_acceleration), **_vector("wx wy wz", message.angular_velocity)}
    covariance = message.orientation_covariance
    # REP 145: a first element of -1 says that there is no orientation.
    if len(covariance) and covariance[0] != -1:
        turned = angles(message.orientation)
        if turned[0] is not None:
            values |= _numbers("roll pitch yaw", turned)
    return values


def _transforms(message: Message) -> dict[str, Value]:
    return {
        "transforms": [
            {
                "parent": text(each.header.frame_id),
                "child": text(each.child_frame_id),
                **_vector("x y z", each.transform.translation),
                "yaw": plain(angles(each.transform.rotation)[2]),
                "at_s": _time_ns(each.header.stamp) / NS_PER_S,
            }
            for each in _some(message.transforms)
        ]
    }


def _diagnostics(message: Message) -> dict[str, Value]:
    return {
        "status": [_diagnostic(each) for each in _some(message.status)],
        "worst": max((_level(each) for each in message.status), default=0),
    }


def _diagnostic(message: Message) -> dict[str, Value]:
    return {
        "name": text(message.name),
        "level": _level(message),
        "message": text(message.message),
        "hardware_id": text(message.hardware_id),
        "values": {text(pair.key): text(pair.value) for pair in _some(message.values)},
    }


def _log(message: Message) -> dict[str, Value]:
    level = _level(message)
    severity = _ROS1_LEVELS[level] if level in _ROS1_LEVELS else max(0, min(4, level // 10 - 1))
    values: dict[str, Value] = {"level": _SEVERITIES[severity], "severity": severity}
    return values | {name: plain(getattr(message, name)) for name in ("name", "msg", "file", "function", "line")}


def _battery(message: Message) -> dict[str, Value]:
    names = ("voltage", "current", "charge", "capacity", "percentage", "temperature", "present")
    status, health = int(message.power_supply_status), int(message.power_supply_health)
    return {
        **{name: plain(getattr(message, name)) for name in names if hasattr(message, name)},
        "status": _BATTERY_STATUS[status] if 0 <= status < len(_BATTERY_STATUS) else "unknown",
        "health": _BATTERY_HEALTH[health] if 0 <= health < len(_BATTERY_HEALTH) else "unknown",
    }


def _fix(message: Message) -> dict[str, Value]:
    place = {name: plain(float(getattr(message, name))) for name in ("latitude", "longitude", "altitude")}
    return {**place, "fix": int(message.status.status), "service": int(message.status.service)}


def _range(message: Message) -> dict[str, Value]:
    return {name: plain(float(getattr(message, name))) for name in ("range", "min_range", "max_range", "field_of_view")}


def _joints(message: Message) -> dict[str, Value]:
    return {
        f"{quantity}.{text(name)}": plain(float(number))
        for quantity in ("position", "velocity", "effort")
        for name, number in zip(message.name[:_MAX_JOINTS], getattr(message, quantity), strict=False)
    }


def _goals(message: Message) -> dict[str, Value]:
    return {
        "goals": [
            {
                "id": text(str(getattr(getattr(each, "goal_id", None), "id", ""))),
                "status": int(each.status),
                "text": text(str(getattr(each, "text", ""))),
            }
            for each in _some(message.status_list)
        ]
    }


def _path(message: Message) -> dict[str, Value]:
    values: dict[str, Value] = {"poses": len(message.poses)}
    if message.poses:
        end = message.poses[-1].pose
        values |= _numbers("end_x end_y end_yaw", (float(end.position.x), float(end.position.y), angles(end.orientation)[2]))
    return values


def _grid(message: Message) -> dict[str, Value]:
    info = message.info
    return {"width": int(info.width), "height": int(info.height), "resolution": plain(float(info.resolution))}


def _picture(message: Message) -> dict[str, Value]:
    named = {name: plain(getattr(message, name)) for name in ("width", "height", "encoding", "format") if hasattr(message, name)}
    return named | {"bytes": len(message.data)}


def _cloud(message: Message) -> dict[str, Value]:
    if not hasattr(message, "data"):
        return {"points": len(message.points)}
    width, height = int(message.width), int(message.height)
    return {"width": width, "height": height, "points": width * height, "bytes": len(message.data)}


_PACKAGES: Final = frozenset(
    (
        *("actionlib_msgs", "action_msgs", "diagnostic_msgs", "geometry_msgs", "nav_msgs", "rcl_interfaces", "rosgraph_msgs"),
        *("sensor_msgs", "tf", "tf2_msgs"),
    )
)
_READERS: Final[dict[str, Callable[[Message], dict[str, Value]]]] = {
    "Odometry": _odometry,
    **dict.fromkeys(("Twist", "TwistStamped", "TwistWithCovariance", "TwistWithCovarianceStamped"), _twist),
    **dict.fromkeys(("Accel", "AccelStamped", "AccelWithCovariance", "AccelWithCovarianceStamped"), _accel),
    **dict.fromkeys(("Pose", "PoseStamped", "PoseWithCovariance", "PoseWithCovarianceStamped"), _pose),
    **dict.fromkeys(("Vector3", "Vector3Stamped", "Point", "Point32", "PointStamped"), _point),
    "Imu": _imu,
    "LaserScan": laser_scan,
    **dict.fromkeys(("TFMessage", "tfMessage"), _transforms),
    "DiagnosticArray": _diagnostics,
    "DiagnosticStatus": _diagnostic,
    "Log": _log,
    "BatteryState": _battery,
    "NavSatFix": _fix,
    "Range": _range,
    "JointState": _joints,
    "GoalStatusArray": _goals,
    "Path": _path,
    "OccupancyGrid": _grid,
    **dict.fromkeys(("Image", "CompressedImage"), _picture),
    **dict.fromkeys(("PointCloud", "PointCloud2"), _cloud),
}
