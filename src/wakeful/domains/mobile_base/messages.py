"""Which message is which: by its type, never by its topic's name, which every robot chooses for itself."""

from __future__ import annotations

from functools import lru_cache

from wakeful.domains.plain import Values, text
from wakeful.facts.events import Observation

COMMANDS = ("cmd", "command", "setpoint", "twist_mux")
"""Words in the name of a topic whose Twist is a command. Only here a name decides: a measured Twist has the same type."""

STREAMS = frozenset(
    {
        "Odometry",
        "LaserScan",
        "MultiEchoLaserScan",
        "PointCloud2",
        "PointCloud",
        "Imu",
        "MagneticField",
        "JointState",
        "Range",
        "Image",
        "CompressedImage",
        "CameraInfo",
        "NavSatFix",
        "BatteryState",
        "TFMessage",
        "tfMessage",
        "DiagnosticArray",
        "FluidPressure",
        "Temperature",
    }
)
"""Types that a robot publishes all the time: their silence means something. Commands, goals and log messages may rest."""


def message_type(observation: Observation) -> str:
    """The last part of the message type; empty where none is known.

    >>> from wakeful.facts.events import Observation
    >>> message_type(Observation(source="s", position=0, topic="/odom", at_ns=0, values={"_type": "nav_msgs/msg/Odometry"}))
    'Odometry'
    """
    named = observation.values.get("_type")
    return _last_part(named) if isinstance(named, str) and len(named) <= 200 else ""


def is_command(observation: Observation) -> bool:
    """Whether this is a commanded velocity."""
    named = observation.topic.lower().rpartition("/")[2]
    return message_type(observation) in ("Twist", "TwistStamped") and any(word in named for word in COMMANDS)


def nearest_topic(topic: str, others: list[str]) -> str | None:
    """Of ``others`` the topic in the same or closest name space: which odometry belongs to which command or sensor.

    With a name space in common it is the one that shares most; else the only one, or one at the root.

    >>> nearest_topic("/a/scan", ["/a/odom", "/b/odom"]), nearest_topic("/scan", ["/a/odom", "/b/odom"])
    ('/a/odom', None)
    >>> nearest_topic("/scan", ["/controller/odom"])
    '/controller/odom'
    """
    spaces = {one: _shared(topic, one) for one in others}
    best = max(spaces, key=lambda one: (spaces[one], -len(one), one), default=None)
    if best is None or spaces[best] or len(others) == 1:
        return best
    roots = [one for one in others if one.count("/") <= 1]
    return min(roots) if roots else None


def frame(values: Values, key: str = "frame") -> str:
    """A frame's name without the slash that ROS 1 puts before it."""
    return text(values, key, 120).lstrip("/")


@lru_cache(maxsize=1000)
def _last_part(named: str) -> str:
    return named.rpartition("/")[2]


def _shared(one: str, other: str) -> int:
    count = 0
    for mine, theirs in zip(one.strip("/").split("/")[:-1], other.strip("/").split("/")[:-1], strict=False):
        if mine != theirs:
            break
        count += 1
    return count
