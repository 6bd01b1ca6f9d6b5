"""The state estimator (EKF2): measurements that it disbelieves, faults of its own, and states that it reset."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import msgspec

from wakeful.contracts.detector import Found, Shown
from wakeful.domains.latch import Latch
from wakeful.domains.plain import flag, number, whole, within
from wakeful.domains.px4_ulog.flight import Flight, numbered, split_topic
from wakeful.domains.remembering import Remembering, Seen
from wakeful.facts.domain import DetectorSpec, DomainSpec
from wakeful.facts.events import Observation, Phase
from wakeful.facts.time import to_ns

RATIOS: Mapping[str, str] = {
    "mag_test_ratio": "magnetometer",
    "vel_test_ratio": "velocity",
    "pos_test_ratio": "position",
    "hgt_test_ratio": "height",
    "tas_test_ratio": "airspeed",
    "hagl_test_ratio": "height above ground",
    "beta_test_ratio": "sideslip",
}
"""estimator_status: innovation over its gate. Above 1 EKF2 rejects the measurement; above 0.5 preflight checks complain."""

FAULTS = (
    "bad_mag_x",
    "bad_mag_y",
    "bad_mag_z",
    "bad_hdg",
    "bad_mag_decl",
    "bad_airspeed",
    "bad_sideslip",
    "bad_optflow_x",
    "bad_optflow_y",
    "bad_vel_n",
    "bad_vel_e",
    "bad_vel_d",
    "bad_pos_n",
    "bad_pos_e",
    "bad_pos_d",
    "bad_acc_bias",
    "bad_acc_vertical",
    "bad_acc_clipping",
)
"""Bits of estimator_status.filter_fault_flags, and with `fs_` before it the fields of estimator_status_flags."""

STATES: Mapping[str, str] = {
    "cs_mag_fault": "magnetometer fault",
    "cs_gps_yaw_fault": "GPS heading fault",
    "cs_ev_yaw_fault": "vision heading fault",
    "cs_rng_fault": "range finder fault",
    "cs_mag_field_disturbed": "magnetic field disturbed",
    "cs_wind_dead_reckoning": "dead reckoning on wind",
    "cs_inertial_dead_reckoning": "dead reckoning on inertia",
    "cs_gnss_fault": "GNSS fault",
    "cs_baro_fault": "barometer fault",
}
"""Fields of estimator_status_flags that say that the filter runs on less than it should."""

_HOLD_NS, _CLEAR_NS = to_ns(0.5), to_ns(10.0)


class _Filter(msgspec.Struct):
    latches: dict[str, Latch] = {}
    bits_known: bool = False


class _Memory(msgspec.Struct):
    flight: Flight = msgspec.field(default_factory=Flight)
    filters: dict[str, _Filter] = {}
    first: dict[str, str] = {}
    """Of each open condition the instance that showed it first."""


class Estimators(Remembering[_Memory]):
    """Lasting conditions of each filter instance.

    ``innovation`` (level 1 above 0.5, level 2 above 1, held for 0.5 s) for each test ratio; ``estimator_fault`` for numerical
    faults; ``estimator_degraded`` for what makes it run on less than it should. What several instances show at the same time is
    the first one's condition, the others are evidence for it. A fault shows the outcome ``fault``.
    """

    def __init__(self, spec: DetectorSpec, domain: DomainSpec) -> None:  # noqa: ARG002 (the factory's signature)
        super().__init__(_Memory())
        self._warn = number(spec.settings, "warn_ratio") or 0.5
        self._reject = number(spec.settings, "reject_ratio") or 1.0

    def observe(self, observation: Observation) -> Iterator[Seen]:
        """Look at one filter's status."""
        name, instance = split_topic(observation.topic)
        entity = numbered("estimator", instance)
        match name:
            case "estimator_status":
                yield from self._ratios(observation, entity)
                yield from self._fault_bits(observation, entity)
            case "estimator_status_flags":
                yield from self._flags(observation, entity)
            case _:
                self.memory.flight.see(observation)

    def _ratios(self, observation: Observation, entity: str) -> Iterator[Seen]:
        for field, what in RATIOS.items():
            ratio = number(observation.values, field)
            if ratio is None:
                continue
            latch = self._latch(entity, field)
            level = 2 if ratio >= self._reject else 1 if ratio >= self._warn else 0
            # once raised it is over only well below the limit: ratios hover about it
            level = min(1, latch.level) if level == 0 and ratio >= 0.7 * self._warn else level
            phase = latch.see(level, observation.at_ns, _HOLD_NS, _CLEAR_NS)
            if phase is None:
                continue
            word = "agrees again" if phase is Phase.CLEARED else "is rejected" if latch.level == 2 else "disagrees"
            yield from self._condition(
                phase, "innovation", entity, what, latch.level, f"{what} {word}: innovation test ratio {ratio:.2f}", ratio
            )

    def _fault_bits(self, observation: Observation, entity: str) -> Iterator[Seen]:
        bits = whole(observation.values, "filter_fault_flags")
        if bits is None or bits < 0:
            return
        self._filter(entity).bits_known = True
        for bit, name in enumerate(FAULTS):
            yield from self._fault(observation, entity, name, bool(bits >> bit & 1))

    def _flags(self, observation: Observation, entity: str) -> Iterator[Seen]:
        values = observation.values
        if not self._filter(entity).bits_known:
            for name in FAULTS:
                if (on := flag(values, f"fs_{name}")) is not None:
                    yield from self._fault(observation, entity, name, on)
        for field, what in STATES.items():
            on = flag(values, field)
            # At rest before take-off a filter always starts by dead reckoning: that is how it begins, not a loss.
            if on is None or (on and not self.memory.flight.armed):
                continue
            if phase := self._latch(entity, field).see(int(on), observation.at_ns, 0, _CLEAR_NS):
                said = f"{what}{' is over' if phase is Phase.CLEARED else ''}"
                yield from self._condition(phase, "estimator_degraded", entity, what, 1, said)

    def _fault(self, observation: Observation, entity: str, name: str, on: bool) -> Iterator[Seen]:
        if phase := self._latch(entity, name).see(int(on), observation.at_ns, 0, _CLEAR_NS):
            if phase is Phase.RAISED:
                yield Shown(label="fault")
            said = f"numerical fault {name}{' is over' if phase is Phase.CLEARED else ''}"
            yield from self._condition(phase, "estimator_fault", entity, name, 2, said)

    def _condition(
        self, phase: Phase, kind: str, entity: str, what: str, level: int, said: str, ratio: float | None = None
    ) -> Iterator[Seen]:
        first = self.memory.first
        owner = first.get(f"{kind} {what}", "")
        if phase is Phase.CLEARED and owner != entity:
            return
        owner = first.setdefault(f"{kind} {what}", entity)
        if owner != entity:
            phase, said = Phase.REPEATED, f"{said} (as {owner} showed before)"
        elif phase is Phase.CLEARED:
            del first[f"{kind} {what}"]
            yield Shown(label="recovered", entity=entity)
        flight = self.memory.flight
        yield Found(
            kind=kind,
            entity=entity,
            fields={
                **flight.fields(),
                "what": what,
                "severity": 0.5 * level,
                "ratio": None if ratio is None else within(ratio, 0.0, 5.0),
            },
            says=f"{entity.capitalize()}: {said} ({flight.says()}).",
            criticality=min(3, level + 1) if flight.airborne else 1,
            deadline_s=5.0 if flight.airborne and level >= 2 else None,
            phase=phase,
            type=kind,
            references=(owner, what),
            task=flight.mode,
            safety=bool(flight.armed),
        )

    def _filter(self, entity: str) -> _Filter:
        return self.memory.filters.setdefault(entity, _Filter())

    def _latch(self, entity: str, what: str) -> Latch:
        return self._filter(entity).latches.setdefault(what, Latch())
