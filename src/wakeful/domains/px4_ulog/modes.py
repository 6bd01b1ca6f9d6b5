"""Arming, take-off, landing and changes of the flight mode: who wanted them, and the outcomes that they are for others."""

from __future__ import annotations

from collections.abc import Iterator

import msgspec

from wakeful.contracts.detector import Found, Shown
from wakeful.domains.px4_ulog.flight import SAFE_MODES, Flight, mode_name
from wakeful.domains.remembering import Remembering, Seen
from wakeful.facts.domain import DetectorSpec, DomainSpec
from wakeful.facts.events import Observation


class _Memory(msgspec.Struct):
    flight: Flight = msgspec.field(default_factory=Flight)
    flown: bool = False
    changes: int = 0


class Modes(Remembering[_Memory]):
    """Registers changes of mode, of arming and of contact with the ground; the first values seen are not changes.

    A change into a mode that a failsafe chooses while the pilot wanted another shows the outcome ``failsafe``; disarming in
    the air shows ``fault`` (a crash or a kill); leaving the ground ``takeoff``; touching it ``landed``.
    """

    def __init__(self, spec: DetectorSpec, domain: DomainSpec) -> None:  # noqa: ARG002 (the factory's signature)
        super().__init__(_Memory())

    def observe(self, observation: Observation) -> Iterator[Seen]:
        """Compare the vehicle's state before and after the observation."""
        flight = self.memory.flight
        armed, nav, landed, airborne = flight.armed, flight.nav, flight.landed, flight.airborne
        flight.see(observation)
        if armed is not None and flight.armed is not None and flight.armed != armed:
            yield from self._arming(airborne)
        if nav is not None and flight.nav != nav:
            yield from self._mode(nav)
        if landed is not None and flight.landed != landed and flight.armed:
            yield from self._ground()

    def _arming(self, was_airborne: bool) -> Iterator[Seen]:
        flight = self.memory.flight
        dropped = was_airborne and not flight.armed and flight.landed is False
        word = "armed" if flight.armed else "disarmed in the air" if dropped else "disarmed"
        if dropped:
            yield Shown(label="fault")
        yield Found(
            kind="arming",
            entity="vehicle",
            fields={**flight.fields(), "severity": 1.0 if dropped else 0.2, "intended": not dropped},
            says=f"The vehicle was {word} ({flight.mode} mode).",
            criticality=3 if dropped else 1,
            task=flight.mode,
            safety=bool(flight.armed),
        )

    def _mode(self, before: int) -> Iterator[Seen]:
        flight = self.memory.flight
        self.memory.changes += 1
        intended = flight.wanted is None or flight.wanted == flight.nav
        unwanted = not intended and flight.nav in SAFE_MODES and bool(flight.armed)
        if unwanted:
            yield Shown(label="failsafe")
        why = "as asked for" if intended else f"though {mode_name(flight.wanted)} was asked for"
        yield Found(
            kind="mode_change",
            entity="vehicle",
            fields={
                **flight.fields(),
                "from_mode": mode_name(before),
                "intended": intended,
                "severity": 0.8 if unwanted else 0.2 if intended else 0.5,
            },
            says=f"Flight mode changed from {mode_name(before)} to {flight.mode}, {why} ({flight.says()}).",
            criticality=3 if unwanted and flight.airborne else 2 if unwanted else 1,
            deadline_s=5.0 if unwanted else None,
            task=flight.mode,
            safety=bool(flight.armed),
        )

    def _ground(self) -> Iterator[Seen]:
        flight = self.memory.flight
        yield Shown(label="landed" if flight.landed else "takeoff")
        yield Found(
            kind="landing" if flight.landed else "takeoff",
            entity="vehicle",
            fields={**flight.fields(), "severity": 0.2, "intended": True},
            says=f"The vehicle {'touched the ground' if flight.landed else 'left the ground'} in {flight.mode} mode.",
            criticality=1,
            task=flight.mode,
            safety=bool(flight.armed),
        )
