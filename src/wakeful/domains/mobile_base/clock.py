"""One clock for streams whose clocks differ: a robot's computers and the recorder may be seconds apart."""

from __future__ import annotations

import msgspec

from wakeful.facts.events import Observation
from wakeful.facts.time import to_ns

FARTHEST_NS = to_ns(20.0)
"""Clocks that differ by more are taken as they are: then it is a pause, not a difference between clocks."""

_MOST_TOPICS = 1000


class Clock(msgspec.Struct):
    """The order of arrival says which instants of two topics belong together: each topic is set by when it was first heard.

    From then on it is told by the topic's own stamps; the common time never runs back. What is compared across topics
    (is a command fresh? has a scanner fallen silent?) is compared in it.

    >>> clock = Clock()
    >>> def at(topic: str, s: float) -> int:
    ...     return clock.see(Observation(source="s", position=0, topic=topic, at_ns=to_ns(s), values={})) // 10**9
    >>> [at("/odom", 100.0), at("/cmd_vel", 95.0), at("/odom", 101.0), at("/cmd_vel", 97.0), at("/odom", 101.5)]
    [100, 100, 101, 102, 102]
    """

    now_ns: int | None = None
    offsets: dict[str, int] = {}

    def see(self, observation: Observation) -> int:
        """Take up the time of one observation; returns the common time (ns), which starts as the first topic's own."""
        at_ns, topic = observation.at_ns, observation.topic
        if self.now_ns is None:
            self.now_ns = at_ns
        offset = self.offsets.get(topic)
        if offset is None:
            offset = self.now_ns - at_ns
            offset = offset if abs(offset) <= FARTHEST_NS else 0
            if len(self.offsets) < _MOST_TOPICS:
                self.offsets[topic] = offset
        self.now_ns = max(self.now_ns, at_ns + offset)
        return self.now_ns
