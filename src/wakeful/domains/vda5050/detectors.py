"""The watch over a fleet: state messages in; events, evidence and outcomes of each vehicle out."""

from __future__ import annotations

from collections.abc import Iterator

import msgspec

from wakeful.contracts.detector import DetectorFactory, Found, Shown
from wakeful.domains.plain import text
from wakeful.domains.remembering import Remembering, Seen
from wakeful.domains.vda5050 import errors, stream, watch
from wakeful.domains.vda5050.lasting import Lasting
from wakeful.domains.vda5050.message import LEVELS, StateMessage, read
from wakeful.domains.vda5050.sign import CRITICALITY, DEADLINE_S, Sign
from wakeful.facts.domain import DetectorSpec, DomainSpec
from wakeful.facts.events import Observation, Phase
from wakeful.facts.time import to_ns
from wakeful.facts.values import Field

VEHICLES = 500
ENTITIES = 256
CONNECTION = {"ONLINE": 0, "OFFLINE": LEVELS.index("warning"), "CONNECTIONBROKEN": LEVELS.index("critical")}


ABOUT = {
    "emergency_stop": "safety",
    "field_violation": "safety",
    "battery": "energy",
    "battery_drop": "energy",
    "charging": "energy",
    "position": "localization",
    "position_jump": "localization",
    "stall": "drive",
    "action_failed": "order",
    "order_stuck": "order",
    "order_replaced": "order",
    "load": "load",
    "silence": "communication",
    "stream_fault": "communication",
    "restart": "communication",
    "connection": "communication",
}


class Vehicle(msgspec.Struct):
    """All that is remembered of one vehicle. ``told``: when something was last registered of each of its entities."""

    errors: errors.Errors = msgspec.field(default_factory=errors.Errors)
    watched: watch.Watched = msgspec.field(default_factory=watch.Watched)
    stream: stream.Stream = msgspec.field(default_factory=stream.Stream)
    connection: Lasting = msgspec.field(default_factory=Lasting)
    told: dict[str, int] = {}
    zone: str = ""
    order: str = ""
    fields: dict[str, Field] = {}


class Fleet(msgspec.Struct):
    """The vehicles by serial number, the one longest unheard of first."""

    vehicles: dict[str, Vehicle] = {}


class StateMessages(Remembering[Fleet]):
    """Registers what state messages show of each vehicle; an outcome is what became of it within the domain's window.

    ``cleared``: a condition is gone. ``escalated``: it became worse. ``stopped``: while it lasted (or soon after it happened)
    the vehicle came to an emergency stop or a FATAL error.
    """

    def __init__(self, spec: DetectorSpec, domain: DomainSpec) -> None:
        super().__init__(Fleet())
        self._limits = watch.Limits.of(spec)
        self._within_ns = to_ns(domain.outcome.within_s)
        self._silence_ns = to_ns(self._limits.silence_s)

    def observe(self, observation: Observation) -> Iterator[Seen]:
        """One message of any topic of the standard; only ``state`` and ``connection`` say something here."""
        if observation.topic == "connection":
            yield from self._connection(observation)
        if observation.topic != "state":
            return
        message = read(observation.values, observation.robot)
        if message is None:
            return
        vehicle = self._vehicle(message.serial)
        halted = bool(vehicle.fields.get("stopped")) or vehicle.fields.get("worst") == LEVELS[-1]
        heard = stream.look(message, vehicle.stream, observation.at_ns, self._silence_ns)
        signs = list(heard.signs)
        if not heard.stale:
            signs += errors.look(message, vehicle.errors, observation.at_ns)
            signs += watch.look(message, vehicle.watched, self._limits, observation.at_ns)
            _describe(vehicle, message)
        yield from self._told(message.serial, vehicle, signs, observation, halted)

    def _told(
        self, serial: str, vehicle: Vehicle, signs: list[Sign], observation: Observation, halted: bool = False
    ) -> Iterator[Seen]:
        at_ns = observation.at_ns
        for sign in signs:
            entity = _entity(serial, sign)
            if sign.phase is Phase.CLEARED:
                yield Shown(label="cleared", entity=entity)
            elif sign.rose:
                yield Shown(label="escalated", entity=entity)
        stops = set() if halted else {_entity(serial, sign) for sign in signs if sign.stops}
        if stops:
            yield from (
                Shown(label="stopped", entity=entity)
                for entity, told_ns in vehicle.told.items()
                if entity not in stops and 0 < at_ns - told_ns <= self._within_ns
            )
        for sign in signs:
            yield _found(serial, vehicle, sign, observation.robot)
            if sign.phase in (None, Phase.RAISED, Phase.CHANGED):
                entity = _entity(serial, sign)
                vehicle.told.pop(entity, None)
                vehicle.told[entity] = at_ns
                if len(vehicle.told) > ENTITIES:
                    del vehicle.told[next(iter(vehicle.told))]

    def _connection(self, observation: Observation) -> Iterator[Seen]:
        serial = text(observation.values, "serialNumber", 100) or observation.robot
        state = text(observation.values, "connectionState", 30).upper().replace("_", "")
        if not serial or state not in CONNECTION:
            return
        vehicle = self._vehicle(serial)
        phase = vehicle.connection.see("connection", level := CONNECTION[state], observation.at_ns, state)
        if phase is not None:
            says = f"connection is {state}"
            sign = Sign(kind="connection", type="connection", phase=phase, level=level, says=says)
            yield from self._told(serial, vehicle, [sign], observation)

    def _vehicle(self, serial: str) -> Vehicle:
        vehicle = self.memory.vehicles.pop(serial, None)
        if vehicle is None:
            vehicle = Vehicle()
            if len(self.memory.vehicles) >= VEHICLES:
                del self.memory.vehicles[next(iter(self.memory.vehicles))]
        self.memory.vehicles[serial] = vehicle
        return vehicle


def _found(serial: str, vehicle: Vehicle, sign: Sign, robot: str) -> Found:
    criticality = CRITICALITY[sign.level] if sign.criticality is None else sign.criticality
    return Found(
        kind=sign.kind,
        entity=_entity(serial, sign),
        zone=vehicle.zone,
        task=vehicle.order,
        safety=bool(vehicle.fields.get("stopped")),
        fields={"about": ABOUT.get(sign.kind, "other"), **vehicle.fields, "level": LEVELS[sign.level], **sign.fields},
        says=f"{serial} {sign.says}",
        criticality=criticality,
        deadline_s=DEADLINE_S.get(criticality),
        phase=sign.phase,
        type=sign.type,
        references=sign.references if robot == serial else (serial, *sign.references),
    )


def _entity(serial: str, sign: Sign) -> str:
    name = f"{serial}/{sign.type or sign.kind}"
    return f"{name} {' '.join(sign.references)}" if sign.references else name


def _describe(vehicle: Vehicle, message: StateMessage) -> None:
    """Take over what the message says of the vehicle as a whole, for the context of whatever is registered of it."""
    vehicle.zone = message.zone or vehicle.zone
    if message.order is not None:
        vehicle.order = message.order
    place = message.place
    told: dict[str, Field] = {
        "battery": message.charge,
        "charging": message.charging,
        "driving": message.driving,
        "mode": message.mode or None,
        "loaded": None if message.loads is None else bool(message.loads),
        "nodes_left": message.nodes_left,
        "score": None if place is None else place.score,
        "speed": None if message.speed_m_s is None else round(message.speed_m_s, 3),
        "stopped": None if not message.stop else message.stop != "NONE",
    }
    vehicle.fields.update({name: value for name, value in told.items() if value is not None})
    vehicle.fields["open_errors"] = len(vehicle.errors.lasting.open)
    vehicle.fields["worst"] = LEVELS[vehicle.errors.worst]


DETECTORS: dict[str, DetectorFactory] = {"state_messages": StateMessages}
