"""How sensors are turned against the base: the yaw from frame to frame, collected from transforms."""

from __future__ import annotations

from collections.abc import Mapping
from math import pi

import msgspec

from wakeful.domains.mobile_base.messages import frame, message_type
from wakeful.domains.plain import number
from wakeful.facts.events import Observation
from wakeful.facts.values import Value

_MOST_FRAMES = 1000
_DEEPEST = 20


class Frames(msgspec.Struct):
    """The last yaw of each child frame in its parent's, in radians."""

    parents: dict[str, tuple[str, float]] = {}

    def see(self, observation: Observation) -> None:
        """Take up the transforms of a TFMessage; anything else is passed over."""
        for transform in transforms_of(observation):
            parent, child, yaw = frame(transform, "parent"), frame(transform, "child"), number(transform, "yaw")
            if parent and child and yaw is not None and (child in self.parents or len(self.parents) < _MOST_FRAMES):
                self.parents[child] = (parent, yaw)

    def yaw(self, sensor: str, base: str) -> float:
        """By how much ``sensor`` is turned anticlockwise against ``base``; 0 where the transforms don't say.

        Where the base's name is not known the chain ends at the first frame that is called base something.
        """
        total, at = 0.0, sensor
        for _ in range(_DEEPEST):
            if at == base or (not base and at.startswith("base")):
                return wrap(total)
            if at not in self.parents:
                break
            parent, yaw = self.parents[at]
            total, at = total + yaw, parent
        return wrap(total) if at.startswith("base") else 0.0


def transforms_of(observation: Observation) -> list[Mapping[str, Value]]:
    """The transforms of a TFMessage, at most a thousand; none for anything else."""
    if message_type(observation) not in ("TFMessage", "tfMessage"):
        return []
    listed = observation.values.get("transforms")
    if not isinstance(listed, list | tuple):
        return []
    return [one for one in listed[:1000] if isinstance(one, Mapping)]


def wrap(angle_rad: float) -> float:
    """The angle within (-π, π].

    >>> round(wrap(3.5 * pi), 3)
    -1.571
    """
    turned = angle_rad % (2 * pi)
    return turned - 2 * pi if turned > pi else turned
