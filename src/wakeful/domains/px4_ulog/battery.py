"""Batteries: PX4's own warning levels, the share that remains, and a voltage that gives way under load."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import msgspec

from wakeful.contracts.detector import Found, Shown
from wakeful.domains.latch import Latch
from wakeful.domains.plain import Values, flag, number, whole, within
from wakeful.domains.px4_ulog.flight import Flight, numbered, split_topic
from wakeful.domains.remembering import Remembering, Seen
from wakeful.facts.domain import DetectorSpec, DomainSpec
from wakeful.facts.events import Observation, Phase
from wakeful.facts.time import to_ns, to_s
from wakeful.facts.values import Field

WARNINGS: Mapping[int, str] = {1: "low", 2: "critical", 3: "emergency", 4: "failed", 5: "unhealthy", 6: "charging"}
"""battery_status.warning (PX4 msg/BatteryStatus.msg). Charging is no warning."""

_MOST_CELLS = 24
_EMERGENCY = 0.07
"""Share that remains when it becomes an emergency: where the countdown of a discharge ends."""


class _Battery(msgspec.Struct):
    level: Latch = msgspec.field(default_factory=Latch)
    sag: Latch = msgspec.field(default_factory=Latch)
    rest_v: float | None = None
    seen_ns: int = 0
    earlier: tuple[int, float] | None = None
    """(instant, share that remained) half a minute to a minute ago."""
    slope_per_s: float | None = None


class _Memory(msgspec.Struct):
    flight: Flight = msgspec.field(default_factory=Flight)
    batteries: dict[str, _Battery] = {}


class Batteries(Remembering[_Memory]):
    """Two lasting conditions of each connected battery.

    ``battery_low`` follows ``warning``, and where the firmware doesn't warn, ``remaining`` below 25, 15 and 7 % (PX4's defaults
    are 15, 7 and 5: here it is noticed before PX4 acts). ``voltage_sag`` is a voltage per cell that falls by ``sag_v`` (0.35 V)
    below its own slow average (20 s) or under 3.4 V for a second: a weak, cold or overloaded battery.
    """

    def __init__(self, spec: DetectorSpec, domain: DomainSpec) -> None:  # noqa: ARG002 (the factory's signature)
        super().__init__(_Memory())
        self._sag_v = number(spec.settings, "sag_v") or 0.35

    def observe(self, observation: Observation) -> Iterator[Seen]:
        """Look at one battery's status."""
        name, instance = split_topic(observation.topic)
        if name != "battery_status":
            self.memory.flight.see(observation)
            return
        values = observation.values
        volts = number(values, "voltage_filtered_v") or number(values, "voltage_v")
        if flag(values, "connected") is False or not volts or not 1.0 <= volts <= 500.0:
            return
        entity = numbered("battery", instance, always=True)
        battery = self.memory.batteries.setdefault(entity, _Battery())
        remaining = number(values, "remaining")
        cell_v = _cell_volts(values, volts)
        _discharge(battery, remaining, observation.at_ns)
        fields: dict[str, Field] = {
            **self.memory.flight.fields(),
            "remaining": None if remaining is None else within(remaining, 0.0, 1.0),
            "value": None if remaining is None else within(remaining, 0.0, 1.0),
            "slope_per_s": battery.slope_per_s,
            "limit_low": _EMERGENCY,
            "cell_v": None if cell_v is None else within(cell_v, 0.0, 5.0),
            "current_a": None if (current := number(values, "current_a")) is None else within(current, -1.0, 500.0),
        }
        level = _level(whole(values, "warning"), remaining)
        if phase := battery.level.see(level, observation.at_ns, hold_ns=0, clear_ns=to_ns(5.0)):
            word = "recovered" if phase is Phase.CLEARED else WARNINGS.get(battery.level.level, "low")
            share = "" if remaining is None else f", {remaining:.0%} left"
            if phase is Phase.CLEARED:
                yield Shown(label="recovered", entity=entity)
            yield self._found("battery_low", entity, f"is {word}{share}", fields, phase, battery.level.level)
        if cell_v is not None:
            yield from self._sag(entity, battery, cell_v, observation.at_ns, fields)

    def _sag(self, entity: str, battery: _Battery, cell_v: float, at_ns: int, fields: Mapping[str, Field]) -> Iterator[Seen]:
        rest_v = battery.rest_v if battery.rest_v is not None else cell_v
        fallen_v = rest_v - cell_v
        level = 2 if cell_v < 3.2 or fallen_v >= 2 * self._sag_v else 1 if cell_v < 3.4 or fallen_v >= self._sag_v else 0
        if phase := battery.sag.see(level, at_ns, hold_ns=to_ns(1.0), clear_ns=to_ns(10.0)):
            if phase is Phase.CLEARED:
                yield Shown(label="recovered", entity=entity)
            says = (
                "holds its voltage again"
                if phase is Phase.CLEARED
                else f"gives way under load: {cell_v:.2f} V a cell, {fallen_v:.2f} V below its average"
            )
            yield self._found("voltage_sag", entity, says, {**fields, "drop_v": within(fallen_v, 0.0, 2.0)}, phase, level)
        passed_s = max(0.0, to_s(at_ns - battery.seen_ns)) if battery.rest_v is not None else 0.0
        battery.rest_v, battery.seen_ns = rest_v + (cell_v - rest_v) * min(1.0, passed_s / 20.0), at_ns

    def _found(self, kind: str, entity: str, says: str, fields: Mapping[str, Field], phase: Phase, level: int) -> Found:
        flight = self.memory.flight
        return Found(
            kind=kind,
            entity=entity,
            fields={**fields, "severity": within(level / 3, 0.0, 1.0)},
            says=f"{entity.capitalize()} {says} ({flight.says()}).",
            criticality=(3 if level >= 2 else 2) if flight.airborne else min(level, 2),
            deadline_s=10.0 if flight.airborne else None,
            phase=phase,
            type=kind,
            references=(entity,),
            task=flight.mode,
            safety=bool(flight.armed),
        )


def _discharge(battery: _Battery, remaining: float | None, at_ns: int) -> None:
    """Follow how fast the battery empties, over half a minute at least."""
    if remaining is None:
        return
    earlier = battery.earlier
    passed_s = -1.0 if earlier is None else to_s(at_ns - earlier[0])
    if earlier is None or not 0.0 <= passed_s < 300.0:
        battery.earlier, battery.slope_per_s = (at_ns, remaining), None
    elif passed_s >= 30.0:
        battery.slope_per_s = round((remaining - earlier[1]) / passed_s, 6)
        battery.earlier = (at_ns, remaining)


def _level(warning: int | None, remaining: float | None) -> int:
    if warning is not None and 1 <= warning <= 5:
        return min(warning, 3)
    if remaining is None or remaining < 0.0:
        return 0
    return 3 if remaining < _EMERGENCY else 2 if remaining < 0.15 else 1 if remaining < 0.25 else 0


def _cell_volts(values: Values, volts: float) -> float | None:
    """Volts of one cell, None where the count of cells is not known or gives no voltage that a lithium cell can have."""
    cells = whole(values, "cell_count")
    if cells is None or not 1 <= cells <= _MOST_CELLS:
        return None
    cell_v = volts / cells
    return cell_v if 1.5 <= cell_v <= 4.6 else None
