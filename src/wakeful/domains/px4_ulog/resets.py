"""States that the estimator set anew: a jump of position, height, velocity or heading that the controllers must follow."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from math import hypot

import msgspec

from wakeful.contracts.detector import Found
from wakeful.domains.plain import Values, number, series, whole, within
from wakeful.domains.px4_ulog.flight import Flight
from wakeful.domains.remembering import Remembering, Seen
from wakeful.facts.domain import DetectorSpec, DomainSpec
from wakeful.facts.events import Observation

COUNTERS: Mapping[str, tuple[str, str, str]] = {
    "xy_reset_counter": ("position", "delta_xy", "m"),
    "z_reset_counter": ("height", "delta_z", "m"),
    "vxy_reset_counter": ("velocity", "delta_vxy", "m/s"),
    "vz_reset_counter": ("climb rate", "delta_vz", "m/s"),
    "heading_reset_counter": ("heading", "delta_heading", "rad"),
}
"""Of vehicle_local_position: the counter, what it counts, the field that says by how much, and its unit."""

_LEAST = 0.05
"""A reset by less (m, m/s, rad) moves nothing: filters begin with such ones."""


class _Memory(msgspec.Struct):
    flight: Flight = msgspec.field(default_factory=Flight)
    counts: dict[str, int] = {}


class Resets(Remembering[_Memory]):
    """One event for each observation in which reset counters moved, naming all that were reset and by how much."""

    def __init__(self, spec: DetectorSpec, domain: DomainSpec) -> None:  # noqa: ARG002 (the factory's signature)
        super().__init__(_Memory())

    def observe(self, observation: Observation) -> Iterator[Seen]:
        """Compare the counters with the last ones."""
        if observation.topic != "vehicle_local_position":
            self.memory.flight.see(observation)
            return
        values, moved = observation.values, list[tuple[str, float, str]]()
        for counter, (what, delta, unit) in COUNTERS.items():
            count = whole(values, counter)
            if count is None:
                continue
            before = self.memory.counts.get(counter)
            self.memory.counts[counter] = count
            if before is not None and count != before and ((size := _size(values, delta)) is None or size >= _LEAST):
                moved.append((what, size or 0.0, unit))
        if moved:
            yield self._found(moved)

    def _found(self, moved: list[tuple[str, float, str]]) -> Found:
        flight = self.memory.flight
        parts = ", ".join(f"{what} by {size:.2f} {unit}" for what, size, unit in moved)
        what, size, _ = max(moved, key=lambda one: one[1])
        large = size > 1.0
        return Found(
            kind="estimator_reset",
            entity="estimator",
            fields={**flight.fields(), "what": what, "size": within(size, 0.0, 100.0), "severity": 0.7 if large else 0.3},
            says=f"The estimator reset {parts} ({flight.says()}).",
            criticality=(3 if large else 2) if flight.airborne else 1 if flight.armed else 0,
            deadline_s=5.0 if flight.airborne else None,
            task=flight.mode,
            safety=bool(flight.armed),
        )


def _size(values: Values, field: str) -> float | None:
    parts = [one for one in series(values, field) if one is not None]
    if parts:
        return hypot(*parts)
    single = number(values, field)
    return None if single is None else abs(single)
