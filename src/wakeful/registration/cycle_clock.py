"""Where in its cycle of work a robot is: which cycle, and how far into it. What stops the work stops this clock."""

from __future__ import annotations

import msgspec

from wakeful.facts.events import Observation
from wakeful.registration.channels import Channels
from wakeful.registration.plain import Scalar, elapsed_s, scalar


class Place(msgspec.Struct):
    """The cycle under way: its id as the channel gives it, its number since the beginning, and how far it has come."""

    value: Scalar | None = None
    number: int = 0
    gone_s: float = 0.0
    paused: bool = False
    at_ns: int | None = None


class CycleClock:
    """Follows a channel whose changes begin a cycle. A value that says nothing changes nothing; ids may start over.

    Args:
        cycle: the channel whose changes begin a cycle; empty: there is none.
        pause: channels of flags; while one is up the work stands still, and so does this clock.
    """

    def __init__(self, cycle: str, pause: tuple[str, ...] = ()) -> None:
        self._cycle = Channels((cycle,) if cycle else ())
        self._pause = Channels(pause) if pause else None
        self.patterns = ((cycle,) if cycle else ()) + pause
        self.place = Place()

    def observe(self, observation: Observation) -> Place:
        """Take up an observation. Returns the place; a new one where a cycle began with it."""
        place, at_ns = self.place, observation.at_ns
        if self._pause is not None:
            flags = [bool(flag) for _, value in self._pause.of(observation) if (flag := scalar(value)) is not None]
            place.paused = any(flags) if flags else place.paused
        step_s = elapsed_s(at_ns, place.at_ns)
        # a clock that was set back says nothing of how far the work has come
        place.gone_s += 0.0 if place.paused or step_s == float("inf") else step_s
        place.at_ns = at_ns
        for _, value in self._cycle.of(observation):
            now = scalar(value)
            if now is not None and now != place.value:
                place = self.place = Place(now, place.number + 1, 0.0, place.paused, at_ns)
        return place
