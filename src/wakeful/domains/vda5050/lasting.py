"""What lasts over many messages: raised once, repeated in each, changed when it becomes another, cleared when it is gone.

A condition that comes and goes, or whose level wavers, would be a flood of events: one that was raised three times within two
minutes must stay away for half a minute until it counts as cleared, and a level must have been lower for ten seconds.
"""

from __future__ import annotations

import msgspec

from wakeful.facts.events import Phase
from wakeful.facts.time import NS_PER_S

FLAPS = 3
FLAP_NS = 120 * NS_PER_S
AWAY_NS = 30 * NS_PER_S
LOWER_NS = 10 * NS_PER_S
REMEMBERED = 256


class Open(msgspec.Struct):
    """One open condition. ``away_ns`` and ``lower_ns``: since when it has been away or at a lower level, as far as waited for."""

    level: int
    what: str
    since_ns: int
    away_ns: int | None = None
    lower_ns: int | None = None


class Lasting(msgspec.Struct):
    """The open conditions of one vehicle by name, and when those of late were raised."""

    open: dict[str, Open] = {}
    raised_ns: dict[str, list[int]] = {}

    def see(self, name: str, level: int, at_ns: int, what: str = "") -> Phase | None:
        """Take one look at a condition.

        Args:
            name: which one.
            level: how bad it is now; 0 is clear.
            what: its kind in words, where another word at the same level is a change too.

        Returns:
            RAISED, CHANGED, REPEATED or CLEARED; None while nothing is there, or while it is waited whether it really is over.
        """
        now = self.open.get(name)
        if level <= 0:
            return None if now is None else self._away(name, now, at_ns)
        if now is None:
            self._raise(name, level, at_ns, what)
            return Phase.RAISED
        if now.away_ns is not None:
            now.away_ns = None
            self._came(name, at_ns)
        if level > now.level or (level == now.level and what != now.what):
            now.level, now.what, now.lower_ns = level, what, None
            return Phase.CHANGED
        if level == now.level:
            now.lower_ns = None
        elif now.lower_ns is None:
            now.lower_ns = at_ns
        elif at_ns - now.lower_ns >= LOWER_NS:
            now.level, now.what, now.lower_ns = level, what, None
            return Phase.CHANGED
        return Phase.REPEATED

    def _raise(self, name: str, level: int, at_ns: int, what: str) -> None:
        if len(self.open) >= REMEMBERED:
            del self.open[next(iter(self.open))]
        self.open[name] = Open(level=level, what=what, since_ns=at_ns)
        self._came(name, at_ns)

    def _came(self, name: str, at_ns: int) -> None:
        before = [instant for instant in self.raised_ns.pop(name, []) if 0 <= at_ns - instant <= FLAP_NS]
        self.raised_ns[name] = [*before[-FLAPS:], at_ns]
        if len(self.raised_ns) > REMEMBERED:
            del self.raised_ns[next(iter(self.raised_ns))]

    def _away(self, name: str, now: Open, at_ns: int) -> Phase | None:
        lately = [instant for instant in self.raised_ns.get(name, []) if at_ns - instant <= FLAP_NS]
        if now.away_ns is None:
            now.away_ns = at_ns
        if len(lately) >= FLAPS and at_ns - now.away_ns < AWAY_NS:
            return None
        del self.open[name]
        return Phase.CLEARED
