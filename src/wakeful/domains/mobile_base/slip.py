"""Slip: the wheels say that the base turns, and the gyroscope says that it doesn't, or the other way round."""

from __future__ import annotations

from collections.abc import Iterator
from math import exp

import msgspec

from wakeful.contracts.detector import Found, Shown
from wakeful.domains.latch import Latch
from wakeful.domains.mobile_base.inertia import Up, dot, felt, turned
from wakeful.domains.mobile_base.messages import message_type, nearest_topic
from wakeful.domains.mobile_base.motion import Bases
from wakeful.domains.plain import number, within
from wakeful.domains.remembering import Remembering, Seen
from wakeful.facts.domain import DetectorSpec, DomainSpec
from wakeful.facts.events import Observation, Phase
from wakeful.facts.time import to_ns, to_s

_SMOOTH_S = 0.3
_OWNED_NS = to_ns(3.0)


class _Gyro(msgspec.Struct):
    up: Up = msgspec.field(default_factory=Up)
    latch: Latch = msgspec.field(default_factory=Latch)
    bias_radps: float = 0.0
    gyro_radps: float = 0.0
    wheels_radps: float = 0.0
    seen_ns: int = 0
    seen: bool = False
    heard_ns: int = 0


class _Memory(msgspec.Struct):
    bases: Bases = msgspec.field(default_factory=Bases)
    gyros: dict[str, _Gyro] = {}
    owners: dict[str, str] = {}
    """Of each base the inertial sensor that was heard first: others on it feel the same."""


class Slip(Remembering[_Memory]):
    """A lasting condition of each inertial sensor's base: turning rates that differ by more than ``least_radps`` (0.3) and by
    more than ``share`` (0.4) of the larger, both smoothed over 0.3 s, for half a second; level 2 at twice that. The turning
    rate is the angular velocity about the direction that the accelerometer feels as up; its bias is learned at rest.
    """

    def __init__(self, spec: DetectorSpec, domain: DomainSpec) -> None:  # noqa: ARG002 (the factory's signature)
        super().__init__(_Memory())
        self._least = number(spec.settings, "least_radps") or 0.3
        self._share = number(spec.settings, "share") or 0.4

    def observe(self, observation: Observation) -> Iterator[Seen]:
        """Compare the gyroscope with the last odometry."""
        memory = self.memory
        memory.bases.see(observation)
        if message_type(observation) != "Imu":
            return
        acceleration, rates = felt(observation.values), turned(observation.values)
        topic = nearest_topic(observation.topic, list(memory.bases.by_topic))
        if acceleration is None or rates is None or (observation.topic not in memory.gyros and len(memory.gyros) >= 16):
            return
        gyro = memory.gyros.setdefault(observation.topic, _Gyro())
        gyro.heard_ns = memory.bases.clock.now_ns or 0
        up = gyro.up.see(acceleration, observation.at_ns)
        if topic is None or not gyro.up.sure:
            return
        motion, owner = memory.bases.by_topic[topic], memory.owners.get(topic)
        if owner is None or (memory.bases.clock.now_ns or 0) - memory.gyros[owner].heard_ns >= _OWNED_NS:
            owner = memory.owners[topic] = observation.topic
        if owner != observation.topic:
            return
        if not memory.bases.fresh(motion):
            return
        self._smooth(gyro, dot(rates, up), motion.turning_radps, observation.at_ns, resting=not motion.moving)
        apart = abs(gyro.gyro_radps - gyro.wheels_radps)
        limit = max(self._least, self._share * max(abs(gyro.gyro_radps), abs(gyro.wheels_radps)))
        level = 2 if apart >= 2 * limit else 1 if apart >= limit else 0 if apart < limit / 2 else gyro.latch.level
        phase = gyro.latch.see(level, observation.at_ns, to_ns(0.5), to_ns(2.0))
        if phase is None:
            return
        entity = memory.bases.part("wheels", topic)
        if phase is Phase.CLEARED:
            yield Shown(label="recovered", entity=entity)
        more = abs(gyro.wheels_radps) > abs(gyro.gyro_radps)
        yield Found(
            kind="slip",
            entity=entity,
            fields={
                **motion.fields(),
                "apart_radps": within(apart, 0.0, 10.0),
                "wheels_faster": more,
                "severity": 0.4 * gyro.latch.level,
            },
            says=(
                f"{'The wheels grip again' if phase is Phase.CLEARED else 'The base slips'}: wheels turn it at"
                f" {gyro.wheels_radps:.2f} rad/s, the gyroscope {observation.topic} feels {gyro.gyro_radps:.2f} rad/s."
            ),
            criticality=1 if gyro.latch.level < 2 else 2,
            deadline_s=10.0,
            phase=phase,
            type="slip",
            references=(entity,),
        )

    def _smooth(self, gyro: _Gyro, rate_radps: float, wheels_radps: float, at_ns: int, resting: bool) -> None:
        passed_s = max(0.0, min(1.0, to_s(at_ns - gyro.seen_ns)))
        share = 1.0 - exp(-passed_s / _SMOOTH_S) if gyro.seen else 1.0
        gyro.seen, gyro.seen_ns = True, at_ns
        if resting and abs(rate_radps - gyro.bias_radps) < 0.1:
            gyro.bias_radps += (rate_radps - gyro.bias_radps) * (1.0 - exp(-passed_s / 5.0))
        gyro.gyro_radps += (rate_radps - gyro.bias_radps - gyro.gyro_radps) * share
        gyro.wheels_radps += (wheels_radps - gyro.wheels_radps) * share
