"""GPS: the fix, its accuracy, and whether somebody jams or spoofs it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import msgspec

from wakeful.contracts.detector import Found, Shown
from wakeful.domains.latch import Latch
from wakeful.domains.plain import number, whole, within
from wakeful.domains.px4_ulog.flight import Flight, numbered, split_topic
from wakeful.domains.remembering import Remembering, Seen
from wakeful.facts.domain import DetectorSpec, DomainSpec
from wakeful.facts.events import Observation, Phase
from wakeful.facts.time import to_ns

FIXES: Mapping[int, str] = {
    0: "none",
    1: "none",
    2: "2D",
    3: "3D",
    4: "differential",
    5: "RTK float",
    6: "RTK fixed",
    8: "extrapolated",
}
"""vehicle_gps_position.fix_type."""

_FRESH_NS, _STEADY_NS = to_ns(5.0), to_ns(5.0)


class _Receiver(msgspec.Struct):
    fix: int | None = None
    next_fix: int | None = None
    next_ns: int = 0
    """What the fix seems to become, and since when."""
    poor: Latch = msgspec.field(default_factory=Latch)
    checks: Latch = msgspec.field(default_factory=Latch)
    jammed: Latch = msgspec.field(default_factory=Latch)
    spoofed: Latch = msgspec.field(default_factory=Latch)
    had_fix: bool = False
    settled: bool = False
    """It has had a fix, and passed the estimator's checks with it: what fails from now on is no part of finding its place."""


class _Memory(msgspec.Struct):
    flight: Flight = msgspec.field(default_factory=Flight)
    receivers: dict[str, _Receiver] = {}
    main_ns: int | None = None


class Satellites(Remembering[_Memory]):
    """Registers changes of the fix, and as lasting conditions: poor accuracy (eph above 5 m, level 2 above 20 m, once there was
    a 3D fix), failing GPS checks of the estimator, jamming and spoofing. ``sensor_gps`` is listened to only where the blended
    ``vehicle_gps_position`` is silent. The fix coming back shows the outcome ``recovered`` for the receiver.
    """

    def __init__(self, spec: DetectorSpec, domain: DomainSpec) -> None:  # noqa: ARG002 (the factory's signature)
        super().__init__(_Memory())
        self._poor_m = number(spec.settings, "poor_eph_m") or 5.0
        self._jammed = number(spec.settings, "jamming_indicator") or 150.0

    def observe(self, observation: Observation) -> Iterator[Seen]:
        """Look at one receiver's report, or at the estimator's checks of it."""
        name, instance = split_topic(observation.topic)
        memory = self.memory
        match name:
            case "vehicle_gps_position":
                memory.main_ns = observation.at_ns
                yield from self._receiver(observation, numbered("gps", instance))
            case "sensor_gps":
                if memory.main_ns is None or not 0 <= observation.at_ns - memory.main_ns < _FRESH_NS:
                    yield from self._receiver(observation, numbered("gps", instance))
            case "estimator_status" if instance == 0:
                yield from self._checks(observation)
            case _:
                memory.flight.see(observation)

    def _receiver(self, observation: Observation, entity: str) -> Iterator[Seen]:
        values, at_ns = observation.values, observation.at_ns
        receiver = self.memory.receivers.setdefault(entity, _Receiver())
        fix, eph_m, used = whole(values, "fix_type"), number(values, "eph"), number(values, "satellites_used")
        more: dict[str, float | str | None] = {
            "eph_m": None if eph_m is None else within(eph_m, 0.0, 100.0),
            "satellites": None if used is None else within(used, 0.0, 60.0),
        }
        if fix is not None and 0 <= fix <= 8:
            yield from self._fix(receiver, entity, fix, at_ns, more)
        if receiver.had_fix and eph_m is not None:
            level = 2 if eph_m > 4 * self._poor_m else 1 if eph_m > self._poor_m else 0
            said = f"horizontal accuracy is {eph_m:.1f} m"
            yield from self._lasting(receiver.poor, level, at_ns, "gps_poor", entity, said, more)
        state, indicator = whole(values, "jamming_state"), number(values, "jamming_indicator")
        level = max(state - 1, 0) if state is not None and 0 <= state <= 3 else 0
        level = max(level, int(indicator is not None and indicator >= self._jammed))
        said = f"jamming (indicator {indicator or 0:.0f} of 255)"
        yield from self._lasting(receiver.jammed, level, at_ns, "gps_jamming", entity, said, more)
        spoofing = whole(values, "spoofing_state")
        level = max(spoofing - 1, 0) if spoofing is not None and 0 <= spoofing <= 3 else 0
        yield from self._lasting(receiver.spoofed, level, at_ns, "gps_spoofing", entity, "signs of spoofing", more)

    def _fix(
        self, receiver: _Receiver, entity: str, fix: int, at_ns: int, more: Mapping[str, float | str | None]
    ) -> Iterator[Seen]:
        before, settled = receiver.fix, receiver.had_fix
        receiver.had_fix = receiver.had_fix or fix >= 3
        if before is None or FIXES.get(before) == FIXES.get(fix):
            receiver.fix, receiver.next_fix = fix, None
            return
        if receiver.next_fix != fix or at_ns < receiver.next_ns:
            receiver.next_fix, receiver.next_ns = fix, at_ns
        # RTK floats and fixes in turns; the loss of a fix is not waited for
        if fix >= 3 and before >= 3 and at_ns - receiver.next_ns < _STEADY_NS:
            return
        receiver.fix, receiver.next_fix = fix, None
        worse = fix < before
        lost = worse and fix < 3 <= before
        if before < 3 <= fix:
            yield Shown(label="recovered", entity=entity)
        flight = self.memory.flight
        yield Found(
            kind="gps_fix",
            entity=entity,
            fields={
                **flight.fields(),
                **more,
                "fix": FIXES.get(fix, "none"),
                "worse": worse,
                "settled": settled,
                "severity": 0.8 if lost else 0.3,
            },
            says=(
                f"{entity.upper()} fix went from {FIXES.get(before, 'none')} to {FIXES.get(fix, 'none')}"
                f" with {more['satellites'] or 0:.0f} satellites ({flight.says()})."
            ),
            criticality=(3 if lost else 2) if worse and flight.airborne else int(worse),
            deadline_s=5.0 if lost and flight.airborne else None,
            task=flight.mode,
            safety=bool(flight.armed),
        )

    def _checks(self, observation: Observation) -> Iterator[Seen]:
        bits = whole(observation.values, "gps_check_fail_flags")
        if bits is None:
            return
        receiver = self.memory.receivers.setdefault("gps", _Receiver())
        receiver.settled = receiver.settled or (bits == 0 and receiver.had_fix)
        said = f"the estimator's GPS checks fail (mask {bits})"
        more = {"settled": receiver.settled}
        yield from self._lasting(receiver.checks, int(bits != 0), observation.at_ns, "gps_checks", "gps", said, more, hold_s=1.0)

    def _lasting(
        self,
        latch: Latch,
        level: int,
        at_ns: int,
        kind: str,
        entity: str,
        said: str,
        more: Mapping[str, float | str | bool | None],
        hold_s: float = 0.5,
    ) -> Iterator[Seen]:
        phase = latch.see(level, at_ns, to_ns(hold_s), to_ns(5.0))
        if phase is None:
            return
        if phase is Phase.CLEARED:
            yield Shown(label="recovered", entity=entity)
        flight = self.memory.flight
        yield Found(
            kind=kind,
            entity=entity,
            fields={**flight.fields(), **more, "severity": within(0.4 + 0.2 * latch.level, 0.0, 1.0)},
            says=f"{entity.upper()}: {'over: ' if phase is Phase.CLEARED else ''}{said} ({flight.says()}).",
            criticality=min(3, 1 + latch.level) if flight.airborne else 1,
            deadline_s=10.0 if flight.airborne else None,
            phase=phase,
            type=kind,
            references=(entity,),
            task=flight.mode,
            safety=bool(flight.armed),
        )
