"""When something happened, by whose clock. All instants are integer nanoseconds."""

from __future__ import annotations

from wakeful.facts.values import Fact

NS_PER_S = 1_000_000_000

#: The longest deadline or wait: about thirty years. Beyond it a number of seconds is a mistake, and nanoseconds overflow.
LONGEST_S = 1e9

#: Instants lie within this many nanoseconds of 1970 (the years 1843 to 2096): what a signed 64-bit journal can hold with room.
LARGEST_NS = 4_000_000_000_000_000_000


def to_ns(seconds: float) -> int:
    """Seconds as whole nanoseconds, rounded to nearest."""
    return round(seconds * NS_PER_S)


def to_s(nanoseconds: int) -> float:
    """Nanoseconds as seconds."""
    return nanoseconds / NS_PER_S


class Stamp(Fact, frozen=True):
    """When an observation was made, by which clock and how surely, and at what kernel time it was received.

    Journal order decides; source time joins outcomes to decisions; kernel time (``received_ns``) sets deadlines. The time of day,
    the boot id and the monotonic clock are recorded once for each commit, in the journal's table ``commits``.
    """

    source_ns: int
    clock: str = "source"
    uncertainty_ns: int = 0
    received_ns: int = 0
