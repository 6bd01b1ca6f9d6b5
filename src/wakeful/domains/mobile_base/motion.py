"""How the base moves, by its odometry: what every detector needs to know of it."""

from __future__ import annotations

from math import hypot

import msgspec

from wakeful.domains.latch import Latch
from wakeful.domains.mobile_base.messages import frame, message_type, nearest_topic
from wakeful.domains.plain import number, within
from wakeful.facts.events import Observation, Phase
from wakeful.facts.time import to_ns
from wakeful.facts.values import Field

MOVING_MPS, MOVING_RADPS = 0.05, 0.1
"""Above one of these the base moves; under half of both it rests."""

_START_NS, _REST_NS = to_ns(0.3), to_ns(0.5)
_MOST_BASES = 16


class Motion(msgspec.Struct):
    """One odometry topic's last word: pose in its own frame, forward, sideways and turning speed, and whether it moves."""

    at_ns: int = 0
    x_m: float = 0.0
    y_m: float = 0.0
    yaw_rad: float = 0.0
    forward_mps: float = 0.0
    sideways_mps: float = 0.0
    turning_radps: float = 0.0
    frame: str = ""
    child: str = ""
    known: bool = False
    latch: Latch = msgspec.field(default_factory=Latch)

    @property
    def speed_mps(self) -> float:
        """Speed over ground."""
        return hypot(self.forward_mps, self.sideways_mps)

    @property
    def moving(self) -> bool:
        """Whether it has been moving for some time and has not come to rest since."""
        return self.latch.level > 0

    def fields(self) -> dict[str, Field]:
        """The part of an event's fields that says how the base moved."""
        return {
            "speed_mps": within(self.speed_mps, 0.0, 20.0),
            "turn_radps": within(abs(self.turning_radps), 0.0, 10.0),
            "moving": self.moving,
            "backward": self.forward_mps < -MOVING_MPS,
        }

    def says(self) -> str:
        """The motion in words, to end a sentence with."""
        if not self.known:
            return "motion unknown"
        if not self.moving:
            return "at rest"
        return f"moving at {self.forward_mps:.2f} m/s, turning at {self.turning_radps:.2f} rad/s"


class Bases(msgspec.Struct):
    """The motion of each base in the recording, by its odometry topic."""

    by_topic: dict[str, Motion] = {}

    def see(self, observation: Observation) -> tuple[Motion, Phase | None] | None:
        """Take up an odometry message.

        Returns:
            The motion, and RAISED when the base began to move, CLEARED when it came to rest; None for any other message.
        """
        kind = message_type(observation)
        if kind not in ("Odometry", "Pose"):
            return None
        values = observation.values
        forward, turning = number(values, "vx"), number(values, "wz")
        if kind == "Pose":  # turtlesim's, which carries velocities; geometry_msgs/Pose doesn't
            forward, turning = number(values, "linear_velocity"), number(values, "angular_velocity")
        if forward is None or turning is None:
            return None
        if observation.topic not in self.by_topic and len(self.by_topic) >= _MOST_BASES:
            return None
        motion = self.by_topic.setdefault(observation.topic, Motion())
        sideways = number(values, "vy") or 0.0
        x, y = number(values, "x"), number(values, "y")
        yaw = number(values, "yaw") if "yaw" in values else number(values, "theta")
        motion.at_ns, motion.known = observation.at_ns, True
        motion.x_m, motion.y_m = motion.x_m if x is None else x, motion.y_m if y is None else y
        motion.yaw_rad = motion.yaw_rad if yaw is None else yaw
        motion.forward_mps, motion.sideways_mps, motion.turning_radps = forward, sideways, turning
        motion.frame, motion.child = frame(values), frame(values, "child_frame")
        return motion, motion.latch.see(_level(motion), observation.at_ns, _START_NS, _REST_NS)

    def of(self, topic: str) -> Motion:
        """The motion of the base that a topic belongs to; an unknown motion where that is not clear."""
        nearest = nearest_topic(topic, list(self.by_topic))
        return Motion() if nearest is None else self.by_topic[nearest]


def _level(motion: Motion) -> int:
    speed, turning = motion.speed_mps, abs(motion.turning_radps)
    if speed >= MOVING_MPS or turning >= MOVING_RADPS:
        return 1
    return 0 if speed < MOVING_MPS / 2 and turning < MOVING_RADPS / 2 else motion.latch.level
