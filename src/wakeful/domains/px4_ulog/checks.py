"""PX4's own health and preflight checks: each report names all that fails now, so what it no longer names is well again."""

from __future__ import annotations

from collections.abc import Iterator

import msgspec

from wakeful.contracts.detector import Found, Shown
from wakeful.domains.plain import series, text, whole, within
from wakeful.domains.px4_ulog.event_names import COMPONENTS, REPORT_BEGINS, REPORT_ENDS, event_name, in_words
from wakeful.domains.px4_ulog.flight import Flight
from wakeful.domains.remembering import Remembering, Seen
from wakeful.domains.template import plain_text
from wakeful.facts.domain import DetectorSpec, DomainSpec
from wakeful.facts.events import Observation, Phase

_WARNING = 4
_EVERY_MODE = 0xFFFFFFFF
_MOST = 200


class Check(msgspec.Struct):
    """One failing check as a report names it: syslog level, the mask of the modes that it concerns, the component."""

    name: str
    level: int
    modes: int
    component: int
    words: str = ""


class _Memory(msgspec.Struct):
    flight: Flight = msgspec.field(default_factory=Flight)
    reporting: bool = False
    report: dict[str, Check] = {}
    raised: dict[str, Check] = {}


class Checks(Remembering[_Memory]):
    """Registers a failing check as a lasting condition of the component that it concerns.

    Only checks at warning level or worse that concern the present flight mode count (a missing offboard signal is none of a
    manual flight's business). A check that a later report leaves out is cleared, which shows ``recovered`` for its component.
    """

    def __init__(self, spec: DetectorSpec, domain: DomainSpec) -> None:  # noqa: ARG002 (the factory's signature)
        super().__init__(_Memory())

    def observe(self, observation: Observation) -> Iterator[Seen]:
        """Collect a report; compare it with what is raised when it ends."""
        memory = self.memory
        if observation.topic != "event":
            memory.flight.see(observation)
            return
        number, levels = whole(observation.values, "id"), whole(observation.values, "log_levels")
        if number is None or levels is None:
            return
        name = event_name(number)
        if name == REPORT_BEGINS:
            memory.reporting, memory.report = True, {}
        elif name == REPORT_ENDS:
            if memory.reporting:
                yield from self._compare()
            memory.reporting, memory.report = False, {}
        elif memory.reporting and len(memory.report) < _MOST:
            arguments = series(observation.values, "arguments")
            given = [int(one) & 0xFF if one is not None else 0 for one in arguments[:5]]
            given += [0] * (5 - len(given))
            modes = given[0] | given[1] << 8 | given[2] << 16 | given[3] << 24
            label = name or f"check_{number & 0xFFFFFF}"
            words = plain_text(text(observation.values, "text", 120)) or in_words(label)
            memory.report[label] = Check(label, levels >> 4 & 0xF, modes, given[4], words)

    def _compare(self) -> Iterator[Seen]:
        memory = self.memory
        for name, check in memory.report.items():
            if name not in memory.raised and check.level <= _WARNING and self._concerns(check):
                memory.raised[name] = check
                yield self._found(check, Phase.RAISED)
        for name in [name for name in memory.raised if name not in memory.report]:
            check = memory.raised.pop(name)
            yield Shown(label="recovered", entity=_component(check))
            yield self._found(check, Phase.CLEARED)

    def _concerns(self, check: Check) -> bool:
        nav = self.memory.flight.nav
        return check.modes == _EVERY_MODE or (nav is not None and 0 <= nav < 32 and bool(check.modes >> nav & 1))

    def _found(self, check: Check, phase: Phase) -> Found:
        flight, entity = self.memory.flight, _component(check)
        modes = "every mode" if check.modes == _EVERY_MODE else f"{flight.mode} mode"
        failing = "fails" if phase is Phase.RAISED else "is passed again"
        return Found(
            kind="check",
            entity=entity,
            fields={**flight.fields(), "check": check.name, "needed": True, "severity": within((7 - check.level) / 7, 0.0, 1.0)},
            says=f"PX4's check of the {entity} {failing}: {check.words}; it concerns {modes} ({flight.says()}).",
            criticality=(3 if check.level < _WARNING else 2) if flight.airborne else 1,
            deadline_s=10.0 if flight.airborne else None,
            phase=phase,
            type="check",
            references=(check.name,),
            task=flight.mode,
            safety=bool(flight.armed),
        )


def _component(check: Check) -> str:
    return COMPONENTS[check.component] if 0 < check.component < len(COMPONENTS) else "vehicle"
