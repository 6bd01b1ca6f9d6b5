"""Commanded velocities: what is asked of a base, by however many."""

from __future__ import annotations

from math import hypot

import msgspec

from wakeful.domains.mobile_base.messages import is_command, nearest_topic
from wakeful.domains.mobile_base.motion import MOVING_MPS, MOVING_RADPS
from wakeful.domains.plain import number
from wakeful.facts.events import Observation
from wakeful.facts.time import to_ns

_FRESH_NS = to_ns(1.0)
"""A command that is older than this asks for nothing."""
_MOST = 16


class Command(msgspec.Struct):
    """The last command of one topic."""

    heard_ns: int
    speed_mps: float
    turn_radps: float

    @property
    def asks(self) -> bool:
        """Whether it asks for motion at all."""
        return self.speed_mps >= MOVING_MPS or self.turn_radps >= MOVING_RADPS


class Asked(msgspec.Struct, frozen=True):
    """What is asked of a base now. Several may command it, and which of them is obeyed is not recorded.

    ``least`` is the least of all fresh commands: only that is surely due. ``anything``: at least one asks for motion.
    """

    least: Command | None
    anything: bool


class Commands(msgspec.Struct):
    """The last command of each topic."""

    by_topic: dict[str, Command] = {}

    def see(self, observation: Observation, now_ns: int) -> bool:
        """Take up a command, heard at ``now_ns`` of the common time; False where the observation is none."""
        if not is_command(observation):
            return False
        values = observation.values
        forward, turn = number(values, "vx"), number(values, "wz")
        if forward is not None and turn is not None and (observation.topic in self.by_topic or len(self.by_topic) < _MOST):
            speed = hypot(forward, number(values, "vy") or 0.0)
            self.by_topic[observation.topic] = Command(now_ns, speed, abs(turn))
        return True

    def of(self, odometry_topic: str, now_ns: int) -> Asked:
        """What is asked of the base of that odometry, at ``now_ns`` of the common time."""
        nearest = nearest_topic(odometry_topic, list(self.by_topic))
        if nearest is None:
            return Asked(None, False)
        space = nearest.rpartition("/")[0]
        fresh = [
            one
            for topic, one in self.by_topic.items()
            if topic.rpartition("/")[0] == space and now_ns - one.heard_ns <= _FRESH_NS
        ]
        least = min(fresh, key=lambda one: (one.asks, one.speed_mps, one.turn_radps), default=None)
        return Asked(least, any(one.asks for one in fresh))
