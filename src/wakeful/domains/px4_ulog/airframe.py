"""The airframe: vibration, clipped accelerometers, and actuators that can give no more."""

from __future__ import annotations

from collections.abc import Iterator

import msgspec

from wakeful.contracts.detector import Found, Shown
from wakeful.domains.latch import Latch
from wakeful.domains.plain import number, series, within
from wakeful.domains.px4_ulog.flight import Flight, numbered, split_topic
from wakeful.domains.remembering import Remembering, Seen
from wakeful.facts.domain import DetectorSpec, DomainSpec
from wakeful.facts.events import Observation, Phase
from wakeful.facts.time import to_ns

VIBRATION_M_S2 = (4.905, 9.81)
"""accel_vibration_metric that Flight Review marks as high and as critical (PX4 docs, log analysis)."""

UNMET = (0.2, 0.5)
"""Share of full torque or thrust that control allocation could not give: notable, and close to losing control."""

_CLEAR_NS = to_ns(20.0)
"""What comes and goes with every gust is one condition."""


class _Memory(msgspec.Struct):
    flight: Flight = msgspec.field(default_factory=Flight)
    latches: dict[str, Latch] = {}
    clipped: dict[str, float] = {}


class Airframe(Remembering[_Memory]):
    """Three lasting conditions: ``vibration`` and ``clipping`` of each IMU, ``saturation`` of the actuators while in the air."""

    def __init__(self, spec: DetectorSpec, domain: DomainSpec) -> None:  # noqa: ARG002 (the factory's signature)
        super().__init__(_Memory())

    def observe(self, observation: Observation) -> Iterator[Seen]:
        """Look at one IMU's status, at control allocation or at the motors."""
        name, instance = split_topic(observation.topic)
        match name:
            case "vehicle_imu_status":
                yield from self._imu(observation, numbered("imu", instance, always=True))
            case "control_allocator_status" if instance == 0:
                yield from self._allocation(observation)
            case "actuator_motors" if instance == 0:
                yield from self._motors(observation)
            case _:
                self.memory.flight.see(observation)

    def _imu(self, observation: Observation, entity: str) -> Iterator[Seen]:
        values, at_ns = observation.values, observation.at_ns
        shaken = number(values, "accel_vibration_metric")
        if shaken is not None:
            said = f"vibration is {shaken:.1f} m/s²"
            yield from self._lasting("vibration", entity, shaken, VIBRATION_M_S2, at_ns, said, hold_s=1.0)
        counts = [one for one in series(values, "accel_clipping") if one is not None]
        if counts:
            total, before = sum(counts), self.memory.clipped.get(entity)
            self.memory.clipped[entity] = total
            more = 0.0 if before is None else max(0.0, total - before)
            said = f"the accelerometer was clipped {more:.0f} times"
            yield from self._lasting("clipping", entity, more, (1.0, 100.0), at_ns, said, hold_s=0.0)

    def _allocation(self, observation: Observation) -> Iterator[Seen]:
        parts = [*series(observation.values, "unallocated_torque"), *series(observation.values, "unallocated_thrust")]
        unmet = max((abs(one) for one in parts if one is not None), default=None)
        if unmet is not None:
            share = unmet if self.memory.flight.airborne else 0.0
            said = f"control allocation cannot give {unmet:.0%} of what is asked"
            yield from self._lasting("saturation", "control allocation", share, UNMET, observation.at_ns, said, hold_s=0.3)

    def _motors(self, observation: Observation) -> Iterator[Seen]:
        outputs = [one for one in series(observation.values, "control") if one is not None]
        if outputs:
            flight = self.memory.flight
            # A fixed wing climbs at full throttle as a matter of course; a multirotor at its limit cannot hold its attitude.
            most = max(outputs) if flight.airborne and not flight.fixed_wing else 0.0
            said = f"motor {outputs.index(max(outputs)) + 1} runs at {max(outputs):.0%}"
            yield from self._lasting("saturation", "motors", most, (0.98, 2.0), observation.at_ns, said, hold_s=0.5)

    def _lasting(
        self, kind: str, entity: str, value: float, limits: tuple[float, float], at_ns: int, said: str, hold_s: float
    ) -> Iterator[Seen]:
        latch = self.memory.latches.setdefault(f"{kind} {entity}", Latch())
        level = sum(value >= limit for limit in limits)
        phase = latch.see(level, at_ns, to_ns(hold_s), _CLEAR_NS)
        if phase is None:
            return
        over = phase is Phase.CLEARED
        if over:
            yield Shown(label="recovered", entity=entity)
        flight = self.memory.flight
        yield Found(
            kind=kind,
            entity=entity,
            fields={**flight.fields(), "size": within(value, 0.0, 100.0), "severity": within(0.3 + 0.3 * latch.level, 0.0, 1.0)},
            says=f"{entity.capitalize()}: {'over: ' if over else ''}{said} ({flight.says()}).",
            criticality=min(3, 1 + latch.level) if flight.airborne else 1,
            deadline_s=5.0 if flight.airborne and latch.level >= 2 else None,
            phase=phase,
            type=kind,
            references=(entity,),
            task=flight.mode,
            safety=bool(flight.armed),
        )
