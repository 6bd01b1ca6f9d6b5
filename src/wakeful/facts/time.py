"""When something happened, by whose clock. All instants are integer nanoseconds."""

from __future__ import annotations

from wakeful.facts.values import Fact

NS_PER_S = 1_000_000_000


def to_ns(seconds: float) -> int:
    """Seconds as whole nanoseconds, rounded to nearest."""
    return round(seconds * NS_PER_S)


def to_s(nanoseconds: int) -> float:
    """Nanoseconds as seconds."""
    return nanoseconds / NS_PER_S


class Stamp(Fact, frozen=True):
    """When an observation was made and when it was received.

    Journal order decides; source time joins outcomes to decisions; kernel time (``received_ns``) sets deadlines.
    """

    source_ns: int
    clock: str = "source"
    uncertainty_ns: int = 0
    received_ns: int = 0
    boot: str = ""
    monotonic_ns: int = 0
