"""Retention: how much of the past a journal keeps. What is older is replaced by its counts (docs/journal.md)."""

from __future__ import annotations

from wakeful.facts.values import Fact


class Retention(Fact, frozen=True):
    """What is kept in full. An event is given up once it is beyond any of the three limits and not among the newest ``least``.

    ``days``: of kernel time since it was recorded. ``events``: the newest so many. ``megabytes``: of file, about; what is open,
    owed or pinned counts too, and is kept all the same. ``least``: the newest so many are kept whatever the limits say: as many
    as learning, memory and late outcomes look back (20,000), so that a mind that recovers thinks as if nothing were gone. 0 in
    one of the limits: no such limit.

    What is kept is folded again by a mind that recovers: a hundred thousand events take it some seconds (docs/performance.md).

    Kept whatever its age: an event with an open process, or whose outcome may still come, or in debt, or that an operator acted
    on; what their decisions rest on; model versions with their lineage, guarantees, imported experience, operators' acts, the
    openings and ends of sources.
    """

    days: float = 90.0
    events: int = 100_000
    megabytes: int = 1_000
    least: int = 20_000


#: Nothing is ever given up.
KEEP_ALL = Retention(days=0.0, events=0, megabytes=0)
