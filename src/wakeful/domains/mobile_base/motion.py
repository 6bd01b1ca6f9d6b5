"""How the base moves, by its odometry: what every detector needs to know of it."""

from __future__ import annotations

from math import exp, hypot

import msgspec

from wakeful.domains.latch import Latch
from wakeful.domains.mobile_base.clock import Clock
from wakeful.domains.mobile_base.messages import frame, message_type, nearest_topic
from wakeful.domains.plain import number, within
from wakeful.facts.events import Observation, Phase
from wakeful.facts.time import to_ns, to_s
from wakeful.facts.values import Field

MOVING_MPS, MOVING_RADPS = 0.05, 0.1
"""Above one of these the base moves; under half of both it rests."""

_START_NS, _REST_NS = to_ns(0.3), to_ns(0.5)
_FRESH_NS, _OWNED_NS = to_ns(0.5), to_ns(3.0)
_SMOOTH_S = 0.25
_MOST_BASES = 16


class Motion(msgspec.Struct):
    """One odometry topic's last word: pose in its own frame, forward, sideways and turning speed, and whether it moves."""

    at_ns: int = 0
    heard_ns: int = 0
    """When it was heard, in the common time of the recording's clocks."""
    x_m: float = 0.0
    y_m: float = 0.0
    yaw_rad: float = 0.0
    forward_mps: float = 0.0
    sideways_mps: float = 0.0
    turning_radps: float = 0.0
    frame: str = ""
    child: str = ""
    known: bool = False
    mean_mps: float = 0.0
    mean_radps: float = 0.0
    """Speed over ground and turning rate, smoothed over a quarter of a second: noise is no motion."""
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


class Reported(msgspec.Struct, frozen=True):
    """What one odometry message says. A position or heading that it doesn't carry is None."""

    forward_mps: float
    sideways_mps: float
    turning_radps: float
    x_m: float | None
    y_m: float | None
    yaw_rad: float | None
    frame: str
    child: str


def reported(observation: Observation) -> Reported | None:
    """Read an odometry message; None for any other, and for one without velocities."""
    kind, values = message_type(observation), observation.values
    if kind == "Odometry":
        forward, turning, yaw = number(values, "vx"), number(values, "wz"), number(values, "yaw")
    elif kind == "Pose":  # turtlesim's, which carries velocities; geometry_msgs/Pose doesn't
        forward, turning = number(values, "linear_velocity"), number(values, "angular_velocity")
        yaw = number(values, "theta")
    else:
        return None
    if forward is None or turning is None:
        return None
    return Reported(
        forward_mps=forward,
        sideways_mps=number(values, "vy") or 0.0,
        turning_radps=turning,
        x_m=number(values, "x"),
        y_m=number(values, "y"),
        yaw_rad=yaw,
        frame=frame(values),
        child=frame(values, "child_frame"),
    )


class Bases(msgspec.Struct):
    """The motion of each base in the recording, by its odometry topic.

    Several odometries of one base (of the wheels, filtered, visual) have the same child frame: the first that is heard counts for
    as long as it goes on. Bases that share frame names have transforms in a name space of their own.
    """

    clock: Clock = msgspec.field(default_factory=Clock)
    by_topic: dict[str, Motion] = {}
    owners: dict[str, str] = {}
    """The odometry topic that counts, by base."""
    spaces: list[str] = []
    """Name spaces with transforms of their own."""

    def see(self, observation: Observation) -> tuple[Motion, Phase | None] | None:
        """Take up an odometry message, and the time of any message.

        Returns:
            The motion, and RAISED when the base began to move, CLEARED when it came to rest; None for any other message and for
            a further odometry of the same base.
        """
        now_ns = self.clock.see(observation)
        if message_type(observation) in ("TFMessage", "tfMessage"):
            space = observation.topic.strip("/").rpartition("/")[0]
            if space and space not in self.spaces and len(self.spaces) < _MOST_BASES:
                self.spaces.append(space)
            return None
        said = reported(observation)
        if said is None or not self._counts(observation, said, now_ns):
            return None
        motion = self.by_topic.setdefault(observation.topic, Motion())
        _smooth(motion, said, to_s(observation.at_ns - motion.at_ns))
        motion.at_ns, motion.heard_ns, motion.known = observation.at_ns, now_ns, True
        motion.x_m = motion.x_m if said.x_m is None else said.x_m
        motion.y_m = motion.y_m if said.y_m is None else said.y_m
        motion.yaw_rad = motion.yaw_rad if said.yaw_rad is None else said.yaw_rad
        motion.forward_mps, motion.sideways_mps, motion.turning_radps = said.forward_mps, said.sideways_mps, said.turning_radps
        motion.frame, motion.child = said.frame, said.child
        return motion, motion.latch.see(_level(motion), observation.at_ns, _START_NS, _REST_NS)

    def fresh(self, motion: Motion) -> bool:
        """Whether the motion was heard within the last half second."""
        return motion.known and (self.clock.now_ns or 0) - motion.heard_ns <= _FRESH_NS

    def of(self, topic: str) -> Motion:
        """The motion of the base that a topic belongs to; an unknown motion where that is not clear."""
        nearest = nearest_topic(topic, list(self.by_topic))
        return Motion() if nearest is None else self.by_topic[nearest]

    def name(self, topic: str) -> str:
        """What the base of an odometry topic is called: ``base``; among several by its frame's or its topic's name space."""
        motion = self.by_topic.get(topic)
        if len(self.owners) <= 1 or motion is None:
            return "base"
        space = motion.child.rpartition("/")[0] or topic.strip("/").partition("/")[0]
        return f"base {space}"

    def part(self, part: str, topic: str) -> str:
        """What a part of that base is called: its name alone where there is one base."""
        name = self.name(topic)
        return part if name == "base" else f"{part} of {name}"

    def _counts(self, observation: Observation, said: Reported, now_ns: int) -> bool:
        topic = observation.topic
        space = next((one for one in self.spaces if topic.strip("/").startswith(f"{one}/")), "")
        base = f"{space}@{said.child}" if said.child else topic
        owner = self.owners.get(base)
        if owner is not None and owner != topic:
            if owner in self.by_topic and now_ns - self.by_topic[owner].heard_ns < _OWNED_NS:
                return False
            self.by_topic.pop(owner, None)
        elif owner is None and len(self.owners) >= _MOST_BASES:
            return False
        self.owners[base] = topic
        return True


def _smooth(motion: Motion, said: Reported, passed_s: float) -> None:
    speed, turning = hypot(said.forward_mps, said.sideways_mps), said.turning_radps
    share = 1.0 - exp(-passed_s / _SMOOTH_S) if motion.known and 0.0 <= passed_s < 1.0 else 1.0
    motion.mean_mps += (speed - motion.mean_mps) * share
    motion.mean_radps += (turning - motion.mean_radps) * share


def _level(motion: Motion) -> int:
    mean_mps, mean_radps = motion.mean_mps, abs(motion.mean_radps)
    if motion.speed_mps < MOVING_MPS / 2 and abs(motion.turning_radps) < MOVING_RADPS / 2:
        return 0
    if mean_mps >= MOVING_MPS or mean_radps >= MOVING_RADPS:
        return 1
    return 0 if mean_mps < MOVING_MPS / 2 and mean_radps < MOVING_RADPS / 2 else motion.latch.level
