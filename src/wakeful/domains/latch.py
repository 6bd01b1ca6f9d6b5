"""A lasting condition out of a wavering signal: raised when it held for a while, cleared when it stayed away for a while."""

from __future__ import annotations

import msgspec

from wakeful.facts.events import Phase


class Latch(msgspec.Struct):
    """One condition's memory. Level 0 is clear; higher levels are worse. While it is raised the worst level is kept.

    >>> latch = Latch()
    >>> [latch.see(level, at, hold_ns=2, clear_ns=3) for at, level in enumerate([1, 1, 1, 2, 2, 2, 0, 0, 1, 0, 0, 0, 0])]
    [None, None, <Phase.RAISED: 'raised'>, None, None, <Phase.CHANGED: 'changed'>, None, None, None, None, None, None, \
<Phase.CLEARED: 'cleared'>]
    """

    level: int = 0
    waiting: int = 0
    """1 while it may rise, -1 while it may clear, 0 while it is steady."""
    lowest: int = 0
    since_ns: int = 0

    def see(self, level: int, at_ns: int, hold_ns: int = 0, clear_ns: int = 0) -> Phase | None:
        """Take one look at the signal.

        Args:
            level: how bad it is now.
            at_ns: when; a clock that steps back starts the waiting anew.
            hold_ns: how long it must be worse than before until it counts, as bad as the least in that time.
            clear_ns: how long it must be at level 0 until it is over.

        Returns:
            What changed: RAISED, CHANGED (worse than before), CLEARED, or None.
        """
        direction = 1 if level > self.level else -1 if level == 0 < self.level else 0
        if not direction:
            self.waiting = 0
            return None
        if self.waiting != direction or at_ns < self.since_ns:
            self.waiting, self.since_ns, self.lowest = direction, at_ns, level
        self.lowest = min(self.lowest, level)
        if at_ns - self.since_ns < (hold_ns if direction > 0 else clear_ns):
            return None
        before, self.level, self.waiting = self.level, self.lowest, 0
        if self.level == 0:
            return Phase.CLEARED
        return Phase.CHANGED if before else Phase.RAISED
