"""What the base touches, and who stopped it: bumpers, cliff and wheel-drop sensors, emergency stops; and its battery."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import msgspec

from wakeful.contracts.detector import Found, Shown
from wakeful.domains.latch import Latch
from wakeful.domains.mobile_base.messages import message_type
from wakeful.domains.mobile_base.motion import Bases
from wakeful.domains.plain import flag, number, text, whole, within
from wakeful.domains.remembering import Remembering, Seen
from wakeful.facts.domain import DetectorSpec, DomainSpec
from wakeful.facts.events import Observation, Phase
from wakeful.facts.time import to_ns

SENSORS: Mapping[str, str] = {
    "bump": "bumper",
    "cliff": "cliff sensor",
    "wheeldrop": "wheel drop",
    "wheel_drop": "wheel drop",
    "e_stop": "emergency stop",
    "estop": "emergency stop",
    "emergency": "emergency stop",
    "kidnap": "kidnap sensor",
    "hazard": "hazard sensor",
}
"""Words in a topic's or type's name that tell a safety sensor: such messages have no type in common."""

HAZARDS: Mapping[int, str] = {1: "bumper", 2: "cliff sensor", 3: "wheel stall", 4: "wheel drop"}
"""irobot_create_msgs/HazardDetection types that are contacts (0 is the backup limit, 5 an object nearby)."""

_IGNORED = ("_type", "frame", "header", "seq", "stamp", "count", "child_frame", "bottom")


class _Memory(msgspec.Struct):
    bases: Bases = msgspec.field(default_factory=Bases)
    pressed: dict[str, bool] = {}
    batteries: dict[str, Latch] = {}


class Contacts(Remembering[_Memory]):
    """``contact``: a lasting condition of each safety sensor while it is on; it shows the outcome ``contact``, its end
    ``recovered``. ``battery_low``: below 20 and 10 % of a BatteryState that is not charging.
    """

    def __init__(self, spec: DetectorSpec, domain: DomainSpec) -> None:  # noqa: ARG002 (the factory's signature)
        super().__init__(_Memory())

    def observe(self, observation: Observation) -> Iterator[Seen]:
        """Look at safety sensors and batteries."""
        self.memory.bases.see(observation)
        kind = message_type(observation)
        if kind == "BatteryState":
            yield from self._battery(observation)
        elif kind == "HazardDetectionVector":
            yield from self._hazards(observation)
        elif kind and (sensor := _sensor(observation.topic, kind)):
            on = _on(observation)
            if on is not None:
                which = _which(observation)
                yield from self._sensor(observation, f"{sensor}{which}", on)

    def _hazards(self, observation: Observation) -> Iterator[Seen]:
        values = observation.values
        count = min(whole(values, "detections.count") or 0, 8)
        now = {HAZARDS.get(whole(values, f"detections.{index}.type") or 0, "") for index in range(count)}
        for sensor in HAZARDS.values():
            if sensor in now or f"{observation.topic} {sensor}" in self.memory.pressed:
                yield from self._sensor(observation, sensor, sensor in now)

    def _sensor(self, observation: Observation, sensor: str, on: bool) -> Iterator[Seen]:
        key = f"{observation.topic} {sensor}"
        pressed = self.memory.pressed
        before = pressed.get(key, False)
        if len(pressed) < 200 or key in pressed:
            pressed[key] = on
        if on == before:
            return
        motion = self.memory.bases.of(observation.topic)
        yield Shown(label="contact") if on else Shown(label="recovered", entity=sensor)
        yield Found(
            kind="contact",
            entity=sensor,
            fields={**motion.fields(), "severity": 0.9},
            says=f"The {sensor} is {'on' if on else 'off again'} ({motion.says()}, {observation.topic}).",
            criticality=3,
            deadline_s=2.0,
            phase=Phase.RAISED if on else Phase.CLEARED,
            type="contact",
            references=(key,),
            safety=True,
        )

    def _battery(self, observation: Observation) -> Iterator[Seen]:
        values, topic = observation.values, observation.topic
        share = number(values, "percentage")
        status = text(values, "status", 20).lower()
        if share is None or share < 0.0 or flag(values, "present") is False or len(self.memory.batteries) >= 64:
            return
        share = share / 100.0 if share > 1.5 else share
        level = 0 if status in ("charging", "full") else 2 if share < 0.1 else 1 if share < 0.2 else 0
        latch = self.memory.batteries.setdefault(topic, Latch())
        phase = latch.see(level, observation.at_ns, to_ns(1.0), to_ns(5.0))
        if phase is None:
            return
        if phase is Phase.CLEARED:
            yield Shown(label="recovered", entity=f"battery {topic}")
        motion = self.memory.bases.of(topic)
        yield Found(
            kind="battery_low",
            entity=f"battery {topic}",
            fields={**motion.fields(), "remaining": within(share, 0.0, 1.0), "severity": 0.4 * max(latch.level, 1)},
            says=f"The battery on {topic} is {'no longer ' if phase is Phase.CLEARED else ''}low: {share:.0%} ({motion.says()}).",
            criticality=2 if latch.level >= 2 else 1,
            deadline_s=60.0,
            phase=phase,
            type="battery_low",
            references=(topic,),
        )


def _sensor(topic: str, kind: str) -> str:
    names = f"{topic.rpartition('/')[2]} {kind}".lower()
    return next((sensor for word, sensor in SENSORS.items() if word in names), "")


def _on(observation: Observation) -> bool | None:
    """Whether any of the message's flags is on; an empty message (std_msgs/Empty) is a press. None where there is no flag."""
    flags = [
        flag(observation.values, name)
        for name in observation.values
        if name.rpartition(".")[2] not in _IGNORED and name not in ("sensor", "bumper", "wheel", "button")
    ]
    known = [one for one in flags if one is not None]
    if known:
        return any(known)
    return True if message_type(observation) == "Empty" else None


def _which(observation: Observation) -> str:
    for name in ("sensor", "bumper", "wheel"):
        if (number_of := whole(observation.values, name)) is not None and 0 <= number_of < 16:
            return f" {number_of + 1}"
    return ""
