"""Shocks and tilt: what the base's inertial sensor feels that driving doesn't explain."""

from __future__ import annotations

from collections.abc import Iterator
from math import degrees, exp, hypot

import msgspec

from wakeful.contracts.detector import Found, Shown
from wakeful.domains.latch import Latch
from wakeful.domains.mobile_base.inertia import GRAVITY_MPS2, Up, Vector, angle, felt, up_of_orientation
from wakeful.domains.mobile_base.messages import message_type
from wakeful.domains.mobile_base.motion import Bases
from wakeful.domains.plain import number, within
from wakeful.domains.remembering import Remembering, Seen
from wakeful.facts.domain import DetectorSpec, DomainSpec
from wakeful.facts.events import Observation, Phase
from wakeful.facts.time import to_ns, to_s

TILT_DEG = (15.0, 25.0)
"""Away from how it stood first: steep for a wheeled base, and close to what tips one over."""

_QUIET_NS = to_ns(3.0)
_CONTACT_MPS2 = 15.0


class _Sensor(msgspec.Struct):
    usual_mps2: float = 0.5
    seen_ns: int = 0
    count: int = 0
    stood: Vector | None = None
    standing: Up = msgspec.field(default_factory=Up)
    now: Up = msgspec.field(default_factory=Up)
    tilt: Latch = msgspec.field(default_factory=Latch)


class _Memory(msgspec.Struct):
    bases: Bases = msgspec.field(default_factory=Bases)
    sensors: dict[str, _Sensor] = {}
    shock_ns: int | None = None
    """When any of them felt the last one: all feel the same."""


class Shocks(Remembering[_Memory]):
    """A ``shock`` is an acceleration whose size differs from gravity by more than ``least_mps2`` (5.0) and by more than eight
    times what is usual on this ground; those that follow within 3 s belong to the first. From 15 m/s² on it shows ``contact``.
    ``tilt`` is a lasting condition of 15° (level 2: 25°) away from how the base stood first, by the sensor's orientation where
    it gives one, else by what it feels.
    """

    def __init__(self, spec: DetectorSpec, domain: DomainSpec) -> None:  # noqa: ARG002 (the factory's signature)
        super().__init__(_Memory())
        self._least = number(spec.settings, "least_mps2") or 5.0

    def observe(self, observation: Observation) -> Iterator[Seen]:
        """Look at one Imu message."""
        memory = self.memory
        memory.bases.see(observation)
        if message_type(observation) != "Imu" or (observation.topic not in memory.sensors and len(memory.sensors) >= 16):
            return
        acceleration = felt(observation.values)
        sensor = memory.sensors.setdefault(observation.topic, _Sensor())
        passed_s = max(0.0, min(1.0, to_s(observation.at_ns - sensor.seen_ns))) if sensor.count else 0.0
        sensor.seen_ns, sensor.count = observation.at_ns, min(sensor.count + 1, 1000)
        if acceleration is not None:
            yield from self._shock(observation, sensor, acceleration, passed_s)
        yield from self._tilt(observation, sensor, acceleration)

    def _shock(self, observation: Observation, sensor: _Sensor, acceleration: Vector, passed_s: float) -> Iterator[Seen]:
        size = abs(hypot(*acceleration) - GRAVITY_MPS2)
        limit = max(self._least, 8.0 * sensor.usual_mps2)
        share = 1.0 - exp(-passed_s / 10.0)
        sensor.usual_mps2 += (min(size, limit) - sensor.usual_mps2) * share
        if size < limit or sensor.count < 20:
            return
        now_ns = self.memory.bases.clock.now_ns or 0
        before_ns, self.memory.shock_ns = self.memory.shock_ns, now_ns
        if before_ns is not None and now_ns - before_ns < _QUIET_NS:
            return
        motion = self.memory.bases.of(observation.topic)
        if size >= _CONTACT_MPS2:
            yield Shown(label="contact")
        yield Found(
            kind="shock",
            entity="base",
            fields={**motion.fields(), "shock_mps2": within(size, 0.0, 200.0), "severity": within(size / 30.0, 0.2, 1.0)},
            says=(
                f"A shock of {size:.1f} m/s² beside gravity on {observation.topic}, usual is {sensor.usual_mps2:.1f}"
                f" ({motion.says()})."
            ),
            criticality=2 if size >= _CONTACT_MPS2 else 1,
            deadline_s=5.0,
        )

    def _tilt(self, observation: Observation, sensor: _Sensor, acceleration: Vector | None) -> Iterator[Seen]:
        by_orientation = up_of_orientation(observation.values)
        up = by_orientation
        if up is None and acceleration is not None:
            up = sensor.now.see(acceleration, observation.at_ns, slow_s=1.0)
        if up is None:
            return
        if sensor.stood is None:
            # how it stands is known after two seconds
            stood = sensor.standing.see((up[0] * GRAVITY_MPS2, up[1] * GRAVITY_MPS2, up[2] * GRAVITY_MPS2), observation.at_ns)
            sensor.stood = stood if sensor.standing.sure else None
            return
        tilt_deg = degrees(angle(up, sensor.stood))
        phase = sensor.tilt.see(sum(tilt_deg >= limit for limit in TILT_DEG), observation.at_ns, to_ns(0.5), to_ns(2.0))
        if phase is None:
            return
        motion = self.memory.bases.of(observation.topic)
        if phase is Phase.CLEARED:
            yield Shown(label="recovered", entity="attitude")
        yield Found(
            kind="tilt",
            entity="attitude",
            fields={
                **motion.fields(),
                "tilt_deg": within(tilt_deg, 0.0, 180.0),
                "limit_deg": TILT_DEG[1],
                "severity": 0.5 * sensor.tilt.level,
            },
            says=(
                f"The base {'stands level again' if phase is Phase.CLEARED else 'tilts'}: {tilt_deg:.0f}° from how it stood"
                f" first, by {observation.topic} ({motion.says()})."
            ),
            criticality=3 if sensor.tilt.level >= 2 else 2,
            deadline_s=5.0,
            phase=phase,
            type="tilt",
            references=(observation.topic,),
        )
