"""The stub treatment, the same for every system: three steps, of which the second may need a reading that comes later."""

from __future__ import annotations

from collections.abc import Iterable
from hashlib import blake2b
from zlib import crc32

#: How long, in workload time, a treatment waits for a reading before it goes on without.
LIMIT_S = 2.0
LIMIT_NS = 2_000_000_000

#: The topic under which readings come, and whose events wait for one.
TOPIC = "reading"
WAITS = "device"


def look(entity: str, load: float) -> int:
    """Step 1: a number that stands for what was seen."""
    return crc32(entity.encode()) ^ round(load * 1000)


def weigh(seen: int, reading: float | None) -> int:
    """Step 2: what was read changes it; None: the limit passed."""
    return crc32(b"%d" % (-1 if reading is None else round(reading * 100)), seen)


def conclude(weighed: int, label: str) -> int:
    """Step 3: what is concluded."""
    return crc32(label.encode(), weighed)


def verdict(predicted: str, label: str, acted_on: bool) -> str:
    """The recorded result against the outcome, by wakeful's rule (Eq. 10): what may have been prevented is undecided."""
    if predicted == label:
        return "supported"
    return "undecided" if acted_on and predicted != "none" and label == "none" else "contradicted"


def final(entity: str, treatment: str, predicted: str, reading: float | None, concluded: int, label: str, judged: str) -> str:
    """An event's final state as one line."""
    shown = "-" if reading is None else f"{reading:.2f}"
    return f"{entity} {treatment} {predicted} {shown} {concluded} {label} {judged}"


def checksum(finals: Iterable[str]) -> str:
    """The same for the same set of final states in whatever order."""
    total = 0
    for line in finals:
        total ^= int.from_bytes(blake2b(line.encode(), digest_size=8).digest(), "big")
    return f"{total:016x}"
