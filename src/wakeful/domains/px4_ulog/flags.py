"""Failsafe and health flags as lasting conditions: raised when a flag turns bad, cleared when it turns good."""

from __future__ import annotations

from collections.abc import Iterator

import msgspec

from wakeful.contracts.detector import Found, Shown
from wakeful.domains.latch import Latch
from wakeful.domains.plain import flag, whole
from wakeful.domains.px4_ulog.flag_names import KINDS, TOPICS, FlagKind, flag_name, kind_of
from wakeful.domains.px4_ulog.flight import Flight
from wakeful.domains.remembering import Remembering, Seen
from wakeful.facts.domain import DetectorSpec, DomainSpec
from wakeful.facts.events import Observation, Phase
from wakeful.facts.time import to_ns

_FATAL = frozenset(name for name, kind in KINDS.items() if name.startswith("fd_") or kind.entity == "motors")

_CLEAR_NS, _FLICKER_NS = to_ns(2.0), to_ns(30.0)
"""A flag is over after the first, and one that came back within the second only after that: flickering is one condition."""


class _Memory(msgspec.Struct):
    flight: Flight = msgspec.field(default_factory=Flight)
    bad: dict[str, bool] = {}
    raised: dict[str, Latch] = {}
    early: dict[str, bool] = {}
    """Flags that have been bad ever since the first look."""
    cleared_ns: dict[str, int] = {}
    flickers: dict[str, bool] = {}
    """Flags that came back soon after they had cleared."""
    masks: dict[str, int] = {}
    owner: dict[str, str] = {}
    """The topic that spoke first of a flag: two topics that say the same do not quarrel."""
    failsafe: bool = False


class Flags(Remembering[_Memory]):
    """Registers flags of ``failsafe_flags`` and its forerunners, and ``vehicle_status.failsafe`` itself.

    Many flags stand on all flight long and mean nothing (no mission loaded, no offboard computer). And while an autopilot
    starts up most are on. So one that is bad from the first look on is registered once the vehicle is armed and its flight mode
    needs what the flag denies, by the masks that PX4 logs beside it (older firmware logs none: there only what every mode
    needs is). A flag that turns bad later always is.
    A raised failsafe shows the outcome ``failsafe``, a motor's failure or a failure detector's ``fault``, a flag that
    clears ``recovered`` for its entity.
    """

    def __init__(self, spec: DetectorSpec, domain: DomainSpec) -> None:  # noqa: ARG002 (the factory's signature)
        super().__init__(_Memory())

    def observe(self, observation: Observation) -> Iterator[Seen]:
        """Compare each flag with what it was."""
        memory, values = self.memory, observation.values
        memory.flight.see(observation)
        if observation.topic not in TOPICS:
            return
        if observation.topic == "vehicle_status":
            yield from self._failsafe(flag(values, "failsafe"))
        if observation.topic == "failsafe_flags":
            for field in values:
                if field.startswith("mode_req_") and (mask := whole(values, field)) is not None:
                    memory.masks[field] = mask
        for field in values:
            named = flag_name(field, observation.topic)
            if named is None or (on := flag(values, field)) is None:
                continue
            if memory.owner.setdefault(named[0], observation.topic) == observation.topic:
                yield from self._flag(named[0], on is named[1], observation.at_ns)

    def _failsafe(self, on: bool | None) -> Iterator[Seen]:
        memory = self.memory
        if on is None or on == memory.failsafe:
            return
        memory.failsafe = on
        yield Shown(label="failsafe") if on else Shown(label="recovered", entity="vehicle")
        flight = memory.flight
        yield Found(
            kind="failsafe",
            entity="vehicle",
            fields={**flight.fields(), "flag": "failsafe", "needed": True, "severity": 1.0},
            says=f"PX4 {'entered' if on else 'left'} failsafe ({flight.says()}).",
            criticality=3 if flight.airborne else 2,
            deadline_s=3.0,
            phase=Phase.RAISED if on else Phase.CLEARED,
            type="failsafe",
            task=flight.mode,
            safety=True,
        )

    def _flag(self, name: str, bad: bool, at_ns: int) -> Iterator[Seen]:
        memory, kind = self.memory, kind_of(name)
        before = memory.bad.get(name)
        memory.bad[name] = bad
        needed = self._needed(kind)
        memory.early[name] = before is None or (memory.early.get(name, False) and bad)
        latch = memory.raised.setdefault(name, Latch())
        counts = bad and (latch.level > 0 or before is False or not memory.early[name] or (needed and bool(memory.flight.armed)))
        flickers = name in memory.flickers
        phase = latch.see(int(counts), at_ns, 0, _FLICKER_NS if flickers else _CLEAR_NS)
        if phase is Phase.RAISED:
            if 0 <= at_ns - memory.cleared_ns.get(name, at_ns + 1) < _FLICKER_NS:
                memory.flickers[name] = True
            if name in _FATAL:
                yield Shown(label="fault")
            yield self._found(name, kind, needed, Phase.RAISED, since_start=memory.early[name])
        elif phase is Phase.CLEARED:
            memory.cleared_ns[name] = at_ns
            memory.flickers.pop(name, None)
            yield Shown(label="recovered", entity=kind.entity)
            yield self._found(name, kind, needed, Phase.CLEARED)

    def _needed(self, kind: FlagKind) -> bool:
        memory, flight = self.memory, self.memory.flight
        if not kind.needed_by:
            return kind.criticality >= 2 or bool(flight.armed)
        mask = memory.masks.get(kind.needed_by)
        return mask is not None and flight.nav is not None and 0 <= flight.nav < 63 and bool(mask >> flight.nav & 1)

    def _found(self, name: str, kind: FlagKind, needed: bool, phase: Phase, since_start: bool = False) -> Found:
        flight = self.memory.flight
        worst = kind.criticality if needed or flight.airborne else 1
        if not flight.armed:
            worst = min(worst, 1)
        need = f"{flight.mode} mode needs it" if needed and kind.needed_by else "" if needed else "the mode does not need it"
        start = "since the log's start" if since_start else ""
        return Found(
            kind="flag",
            entity=kind.entity,
            fields={**flight.fields(), "flag": name, "needed": needed, "severity": round(kind.criticality / 3, 2)},
            says=f"Flag {name} {phase}: {kind.says} ({', '.join(one for one in (flight.says(), need, start) if one)}).",
            criticality=worst,
            deadline_s=5.0 if worst >= 3 else None,
            phase=phase,
            type="flag",
            references=(name,),
            task=flight.mode,
            safety=bool(flight.armed),
        )
