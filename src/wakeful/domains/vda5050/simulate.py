"""The fleet's stream of state messages, endless and seeded, and the same as JSON lines."""

from __future__ import annotations

from collections.abc import Iterator
from datetime import timedelta
from heapq import heappop, heappush
from itertools import islice
from pathlib import Path

import msgspec

from wakeful.domains.vda5050.vehicle import START, Body, Vehicle
from wakeful.facts.events import Observation
from wakeful.facts.time import NS_PER_S

SOURCE = "vda5050"
FLEET = ("AGV-1", "AGV-2", "AGV-3")


def simulate(seed: int) -> Iterator[Observation]:
    """An endless stream of three vehicles' state messages (VDA 5050 2.1.0), one observation a message, in order of time.

    Errors appear, are repeated in every message, become FATAL or not, and clear; messages are lost where the radio is weak.
    The same seed gives the same messages.
    """
    for position, body in enumerate(messages(seed)):
        yield Observation(
            source=SOURCE,
            position=position,
            topic="state",
            at_ns=_instant_ns(body),
            values=body,
            robot=str(body["serialNumber"]),
        )


def messages(seed: int) -> Iterator[Body]:
    """The messages alone, as they would be on the wire."""
    fleet = [Vehicle(serial, seed) for serial in FLEET]
    due = [(vehicle.pause_s(), number, 0.0) for number, vehicle in enumerate(fleet)]
    due.sort()
    while True:
        now_s, number, before_s = heappop(due)
        vehicle = fleet[number]
        lost = vehicle.loses()
        body = vehicle.step(now_s - before_s)
        if not lost:
            yield body
        heappush(due, (now_s + vehicle.pause_s(), number, now_s))


def write_jsonl(seed: int, count: int, path: Path) -> None:
    """Write the first ``count`` messages as JSON lines, for `wakeful run FILE`.

    Raises:
        OSError: the file can't be written.
    """
    with path.open("wb") as file:
        file.writelines(msgspec.json.encode(body) + b"\n" for body in islice(messages(seed), count))


def _instant_ns(body: Body) -> int:
    since = msgspec.convert(body["timestamp"], type(START)) - START
    return (int(START.timestamp()) * 1_000 + since // timedelta(milliseconds=1)) * (NS_PER_S // 1_000)
